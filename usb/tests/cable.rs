//! The fingertip on a scripted bus: who it is, what it says, and that nothing is lost that is not counted.

mod scripted;

use std::collections::VecDeque;

use device::{
    Board, Device, Identity, Link, Lost, Restart, Room, Runner, Sample, Setting, begin_with,
};
use heapless::spsc::{Consumer, Producer, Queue};
use palpate_usb::{Frame, PACKET, Polled, SerialNumber, UsbLine};
use proptest::prelude::*;
use scripted::Bus;
use shared::calibration::Calibration;
use shared::wire::{
    Accumulated, Accumulator, Capabilities, ClockSource, Columns, ConverterFault, FRAME_MAX, Head,
    HelloToDevice, ResetCause, Rows, SCHEMA, Settings, Source, Start, StoreFault, ToDevice, ToHost,
    USB_MAKER, USB_NAME, USB_PRODUCT, USB_VENDOR, decode, encode,
};
use usb_device::bus::UsbBusAllocator;

const SERIAL: [u32; 3] = [0x0012_3456, 0x89ab_cdef, 7];
/// Endpoints of the data, as they are set up.
const TO_DEVICE: usize = 1;
const TO_HOST: usize = 2;

const GET_DESCRIPTOR: u8 = 6;
const SET_ADDRESS: u8 = 5;
const SET_CONFIGURATION: u8 = 9;
const SET_LINE_CODING: u8 = 0x20;
const SET_CONTROL_LINE_STATE: u8 = 0x22;
const TO_INTERFACE: u8 = 0x21;

/// A port with its queues, as the firmware has them.
struct Port {
    bus: Bus,
    line: UsbLine<'static, Bus>,
    bytes_in: Producer<'static, u8>,
    bytes: Consumer<'static, u8>,
    frames_in: Producer<'static, Frame>,
    frames: Consumer<'static, Frame>,
}

fn leaked<T>(value: T) -> &'static mut T {
    Box::leak(Box::new(value))
}

impl Link for Port {
    fn receive(&mut self) -> Option<u8> {
        self.bytes.dequeue()
    }
    fn has_room(&self) -> bool {
        self.frames_in.ready()
    }
    fn send(&mut self, frame: &[u8]) {
        self.frames_in.enqueue(Frame::from_slice(frame).unwrap()).unwrap();
    }
}

impl Port {
    fn new() -> Self {
        let bus = Bus::default();
        let allocator = leaked(UsbBusAllocator::new(bus.clone()));
        let line = UsbLine::new(allocator, leaked(SerialNumber::new(SERIAL))).unwrap();
        let (bytes_in, bytes) = leaked(Queue::<u8, 513>::new()).split();
        let (frames_in, frames) = leaked(Queue::<Frame, 4>::new()).split();
        Self { bus, line, bytes_in, bytes, frames_in, frames }
    }

    /// One that a host has set up.
    fn configured() -> Self {
        let mut port = Self::new();
        port.set_up();
        port
    }

    fn set_up(&mut self) {
        self.bus.reset_by_host();
        self.poll();
        self.write([0, SET_ADDRESS, 9, 0, 0, 0, 0, 0], &[]);
        assert_eq!(self.bus.wires().address, 9);
        self.write([0, SET_CONFIGURATION, 1, 0, 0, 0, 0, 0], &[]);
        assert!(self.line.is_configured());
    }

    fn poll(&mut self) -> Polled {
        self.line.poll(&mut self.bytes_in, &mut self.frames)
    }

    /// A request that gives the host data.
    fn read(&mut self, setup: [u8; 8]) -> Vec<u8> {
        self.bus.request(setup);
        self.poll();
        assert!(!self.bus.refuses(), "{setup:02x?}");
        let mut data = Vec::new();
        while let Some(packet) = self.bus.take(0) {
            data.extend_from_slice(&packet);
            self.poll();
            if packet.len() < PACKET {
                break;
            }
        }
        assert!(self.bus.give(0, &[]));
        self.poll();
        data
    }

    /// A request that gives the device data.
    fn write(&mut self, setup: [u8; 8], data: &[u8]) -> Polled {
        self.bus.request(setup);
        let mut polled = self.poll();
        if !data.is_empty() {
            assert!(self.bus.give(0, data));
            polled = self.poll();
        }
        assert!(!self.bus.refuses(), "{setup:02x?}");
        assert_eq!(self.bus.take(0).as_deref(), Some(&[][..]), "done");
        self.poll();
        polled
    }

    fn descriptor(&mut self, kind: u8, number: u8) -> Vec<u8> {
        // Texts are asked for in English.
        let [low, high] = if kind == 3 { [0x09, 0x04] } else { [0, 0] };
        self.read([0x80, GET_DESCRIPTOR, number, kind, low, high, 0xff, 0])
    }

    fn text(&mut self, number: u8) -> String {
        let descriptor = self.descriptor(3, number);
        let units: Vec<u16> =
            descriptor[2..].chunks(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect();
        String::from_utf16(&units).unwrap()
    }

    /// A program opens the port with this speed, or closes it.
    fn set_speed(&mut self, baud: u32) -> Polled {
        let coding = [&baud.to_le_bytes()[..], &[0, 0, 8]].concat();
        self.write([TO_INTERFACE, SET_LINE_CODING, 0, 0, 0, 0, 7, 0], &coding)
    }

    fn set_open(&mut self, open: bool) -> Polled {
        self.write([TO_INTERFACE, SET_CONTROL_LINE_STATE, u8::from(open), 0, 0, 0, 0, 0], &[])
    }
}

#[test]
fn a_host_finds_a_serial_port_by_vendor_product_name_and_serial_number() {
    let mut port = Port::new();
    port.bus.reset_by_host();
    port.poll();
    let device = port.descriptor(1, 0);
    let word = |at: usize| u16::from_le_bytes([device[at], device[at + 1]]);
    assert_eq!((word(8), word(10)), (USB_VENDOR, USB_PRODUCT));
    let texts = [device[14], device[15], device[16]].map(|number| port.text(number));
    assert_eq!(texts, [USB_MAKER, USB_NAME, "0012345689abcdef00000007"]);
    let configuration = port.descriptor(2, 0);
    assert_eq!(
        u16::from_le_bytes([configuration[2], configuration[3]]),
        configuration.len() as u16
    );
    let interfaces: Vec<_> = parts(&configuration).filter(|it| it[1] == 4).collect();
    let classes: Vec<_> = interfaces.iter().map(|it| it[5]).collect();
    assert_eq!(classes, [2, 10], "control and data of a serial port");
    port.set_up();
}

/// The descriptors that a configuration is made of.
fn parts(mut all: &[u8]) -> impl Iterator<Item = &[u8]> {
    std::iter::from_fn(move || {
        let (part, rest) = all.split_at_checked(usize::from(*all.first()?))?;
        all = rest;
        Some(part)
    })
}

#[test]
fn a_port_opened_at_1200_baud_and_closed_asks_for_the_loader_and_nothing_else_does() {
    let mut port = Port::configured();
    for baud in [1_000_000, 9_600, 1_201] {
        assert!(!port.set_speed(baud).touched);
        assert!(!port.set_open(true).touched);
        assert!(!port.set_open(false).touched, "{baud}");
    }
    assert!(!port.set_speed(1_200).touched, "not open");
    assert!(!port.set_open(true).touched);
    assert!(!port.set_open(true).touched, "still open");
    assert!(port.set_open(false).touched);
}

#[test]
fn a_cable_that_is_pulled_at_1200_baud_asks_for_nothing() {
    let mut port = Port::configured();
    port.set_speed(1_200);
    port.set_open(true);
    port.bus.reset_by_host();
    assert!(!port.poll().touched);
}

#[test]
fn a_frame_that_was_cut_off_by_the_cable_comes_whole_when_it_is_back() {
    let mut port = Port::configured();
    let frame: Vec<u8> = (0..200).collect();
    port.frames_in.enqueue(Frame::from_slice(&frame).unwrap()).unwrap();
    port.poll();
    assert_eq!(port.bus.take(TO_HOST).unwrap(), frame[..PACKET]);
    port.poll();
    port.set_up();
    assert_eq!(taken(&mut port), frame);
}

#[test]
fn a_bus_that_slept_goes_on_in_the_middle_of_a_frame() {
    let mut port = Port::configured();
    let frame: Vec<u8> = (0..200).collect();
    port.frames_in.enqueue(Frame::from_slice(&frame).unwrap()).unwrap();
    port.poll();
    let first = port.bus.take(TO_HOST).unwrap();
    port.bus.let_sleep(true);
    port.poll();
    assert!(!port.line.is_configured());
    port.poll();
    port.bus.let_sleep(false);
    port.poll();
    assert_eq!([first, taken(&mut port)].concat(), frame);
}

/// Everything that the host gets when it takes all there is.
fn taken(port: &mut Port) -> Vec<u8> {
    let mut all = Vec::new();
    loop {
        port.poll();
        let Some(packet) = port.bus.take(TO_HOST) else { return all };
        all.extend(packet);
    }
}

#[test]
fn without_a_host_frames_wait() {
    let mut port = Port::new();
    port.frames_in.enqueue(Frame::from_slice(&[1, 2, 0]).unwrap()).unwrap();
    assert_eq!(port.poll(), Polled::default());
    assert_eq!(port.frames.len(), 1);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Whoever is slow, and in whatever order things happen.
    #[test]
    fn every_byte_comes_in_order_once_both_ways_and_the_host_is_never_left_waiting(
        from_host in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..=PACKET), 0..60),
        to_host in prop::collection::vec(prop::collection::vec(any::<u8>(), 1..=FRAME_MAX), 0..20),
        turns in prop::collection::vec(0..5_u8, 0..400),
    ) {
        let mut port = Port::configured();
        let sent = [from_host.concat(), to_host.concat()];
        let (mut packets, mut frames) = (VecDeque::from(from_host), VecDeque::from(to_host));
        let (mut heard, mut shown, mut last) = (Vec::new(), Vec::new(), 0);
        // What is left after the given turns is done in turn.
        let rest = [0, 1, 2, 3, 4].into_iter().cycle().take(5 * 400);
        for turn in turns.into_iter().chain(rest) {
            match turn {
                0 => if packets.front().is_some_and(|packet| port.bus.give(TO_DEVICE, packet)) {
                    packets.pop_front();
                },
                1 => heard.extend(std::iter::from_fn(|| port.bytes.dequeue()).take(100)),
                2 => if port.frames_in.ready() && let Some(frame) = frames.pop_front() {
                    port.frames_in.enqueue(Frame::from_slice(&frame).unwrap()).unwrap();
                },
                3 => if let Some(packet) = port.bus.take(TO_HOST) {
                    last = packet.len();
                    shown.extend(packet);
                },
                _ => { port.poll(); }
            }
        }
        prop_assert_eq!([heard, shown], sent);
        prop_assert!(last < PACKET, "the host waits for more");
    }
}

/// Hardware that never fails.
struct Bench;

impl Board for Bench {
    fn configure(&mut self, _: Setting) -> Result<(), ConverterFault> {
        Ok(())
    }
    fn listen(&mut self, _: bool) -> Lost {
        Lost::NONE
    }
    fn store(&mut self, _: &[u8]) -> Result<(), StoreFault> {
        Ok(())
    }
    fn can_restart(&self, _: Restart) -> bool {
        true
    }
}

const IDENTITY: Identity<'static> = Identity {
    version: "1.2.3",
    git: "abcdef0",
    board: "none",
    serial: SERIAL,
    converter_clock_hz: 8_000_000,
    converter: "ADS131M04",
    capabilities: Capabilities::ads131m04(8_000_000),
    clock: ClockSource::Simulated,
    reset: ResetCause::PowerOn,
    panic: "",
};

/// A fingertip behind the port, and what its host has heard.
struct Fingertip {
    port: Port,
    runner: Runner<'static>,
    now_us: u64,
    host: Accumulator,
    rows: u64,
    last_row: Option<u64>,
    link_full: u32,
    answers: usize,
    name: String,
}

impl Fingertip {
    fn new() -> Self {
        let beginning = begin_with(None, &IDENTITY.capabilities).unwrap();
        let device = Device::new(IDENTITY, &beginning, leaked(Room::new()));
        Self {
            port: Port::configured(),
            runner: Runner::new(device),
            now_us: 0,
            host: Accumulator::new(),
            rows: 0,
            last_row: None,
            link_full: 0,
            answers: 0,
            name: String::new(),
        }
    }

    fn say(&mut self, sequence: u32, command: &ToDevice<'_>) {
        let mut room = [0; FRAME_MAX];
        let frame = encode(Head { sequence, time_us: 0 }, command, &mut room).unwrap();
        for packet in frame.chunks(PACKET) {
            assert!(self.port.bus.give(TO_DEVICE, packet));
            self.turn();
        }
    }

    fn turn(&mut self) {
        self.turn_with(None);
    }

    fn turn_with(&mut self, sample: Option<Sample>) {
        self.port.poll();
        let mut samples = sample.into_iter();
        self.runner.turn(self.now_us, &mut self.port, &mut samples, &mut Bench, &mut ());
        self.port.poll();
    }

    /// The host takes everything.
    fn hear(&mut self) {
        loop {
            self.turn();
            let Some(packet) = self.port.bus.take(TO_HOST) else { return };
            for byte in packet {
                let Accumulated::Frame(frame) = self.host.push(byte) else { continue };
                let (head, message) = decode::<ToHost<'_>>(frame).expect("a whole frame");
                match message {
                    ToHost::Samples(block) => {
                        let sheets = Settings::DEFAULT.calibration;
                        let calibration = sheets.map(|sheet| Calibration::new(&sheet).unwrap());
                        let rows = Rows::decode(head, &block).unwrap();
                        let rows: Vec<_> = rows.iter(&calibration).collect();
                        assert!(self.last_row < Some(block.first));
                        self.rows += rows.len() as u64;
                        self.last_row = rows.last().map(|row| row.number);
                    }
                    ToHost::Status(status) => self.link_full = status.counters.link_full,
                    ToHost::Answer(answer) => {
                        answer.outcome.unwrap();
                        self.answers += 1;
                    }
                    ToHost::Hello(hello) => self.name = hello.board.into(),
                    _ => {}
                }
            }
        }
    }

    fn stream(&mut self, rows: std::ops::Range<i32>, listening: bool) {
        for row in rows {
            let counts = [row, -row, row * row % 8_191, 7].map(|it| it * 1_000 % 8_000_000);
            self.now_us = row as u64 * 256;
            self.turn_with(Some(Sample { time_us: self.now_us, counts, lost: Lost::NONE }));
            if listening {
                self.hear();
            }
        }
    }
}

#[test]
fn a_host_that_takes_everything_gets_every_row_and_one_that_sleeps_is_told_how_many_it_lost() {
    let mut tip = Fingertip::new();
    tip.say(1, &ToDevice::Hello(HelloToDevice { schema: SCHEMA, version: "1" }));
    tip.hear();
    assert_eq!((tip.name.as_str(), tip.answers), ("none", 1));
    tip.say(2, &ToDevice::Start(Start { source: Source::Converter, columns: Columns::All }));
    tip.hear();
    tip.stream(0..4_000, true);
    // Blocks that are not full yet.
    for _ in 0..3 {
        tip.now_us += 10_000;
        tip.hear();
    }
    assert_eq!((tip.rows, tip.last_row), (4_000, Some(3_999)));
    tip.stream(4_000..9_000, false);
    tip.hear();
    tip.say(3, &ToDevice::Stop);
    tip.hear();
    tip.say(4, &ToDevice::Status);
    tip.hear();
    assert!(tip.link_full > 4_000, "{}", tip.link_full);
    assert_eq!(tip.rows + u64::from(tip.link_full), 9_000, "received and counted");
    assert_eq!(tip.answers, 4);
}
