//! A gauge on a NAU7802, from the registers of a modelled part to the rows that a host hears.

use std::cell::RefCell;
use std::rc::Rc;

use embedded_hal::i2c::{ErrorKind, I2c, NoAcknowledgeSource, Operation};
use embedded_hal_mock::eh1::delay::NoopDelay;
use palpate_device::converters::OneChannel;
use palpate_device::{
    Board, Converter, Device, FrontEnd, Identity, Link, Lost, ReadError, Restart, Room, Runner,
    Setting, begin_with,
};
use shared::pipeline::GAUGES;
use shared::wire::{
    Accumulated, Accumulator, Columns, ConverterFault, FRAME_MAX, Head, HelloToDevice, Inputs, Row,
    Rows, SCHEMA, Settings, Source, Start, StoreFault, ToDevice, ToHost, decode, encode,
};

const POWER: usize = 0x00;
const RESULT: usize = 0x12;

/// The part: registers as after power-on, and what it was told.
struct Part {
    registers: [u8; 0x20],
    is_plugged_in: bool,
    /// Looks at the ready bit before it is.
    starts_after: u32,
    /// Registers that keep nothing.
    is_stubborn: bool,
}

impl Part {
    fn new() -> Self {
        let mut part =
            Self { registers: [0; 0x20], is_plugged_in: true, starts_after: 3, is_stubborn: false };
        part.reset();
        part
    }

    fn reset(&mut self) {
        self.registers = [0; 0x20];
        self.registers[0x1f] = 0x0f;
    }

    fn write(&mut self, register: usize, value: u8) {
        if register == POWER && value & 1 != 0 {
            self.reset();
        }
        if !self.is_stubborn || register == POWER {
            self.registers[register] = value;
        }
    }

    fn read(&mut self, register: usize) -> u8 {
        if register == POWER && self.registers[POWER] & 0b10 != 0 {
            self.starts_after = self.starts_after.saturating_sub(1);
            if self.starts_after == 0 {
                self.registers[POWER] |= 1 << 3;
            }
        }
        if register == RESULT + 2 {
            self.registers[POWER] &= !(1 << 5);
        }
        self.registers[register]
    }

    /// A conversion of an input, a share of full scale at a gain of 1, is done.
    fn convert(&mut self, input: f64) {
        let gain = f64::from(1_u32 << (self.registers[1] & 0b111));
        let counts = (input * gain * 8_388_608.0).clamp(-8_388_608.0, 8_388_607.0) as i32;
        self.registers[RESULT..RESULT + 3].copy_from_slice(&counts.to_be_bytes()[1..]);
        self.registers[POWER] |= 1 << 5;
    }

    fn rate_bits(&self) -> u8 {
        self.registers[2] >> 4 & 0b111
    }
}

/// Its bus: the first byte that is written is a register, which grows with every further byte.
#[derive(Clone)]
struct Bus(Rc<RefCell<Part>>);

impl embedded_hal::i2c::ErrorType for Bus {
    type Error = ErrorKind;
}

impl I2c for Bus {
    fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), ErrorKind> {
        let mut part = self.0.borrow_mut();
        if address != 0x2a || !part.is_plugged_in {
            return Err(ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address));
        }
        let mut register = 0;
        for operation in operations {
            match operation {
                Operation::Write([first, values @ ..]) => {
                    register = usize::from(*first);
                    for value in values {
                        part.write(register, *value);
                        register += 1;
                    }
                }
                Operation::Write([]) => {}
                Operation::Read(values) => {
                    for value in values.iter_mut() {
                        *value = part.read(register);
                        register += 1;
                    }
                }
            }
        }
        Ok(())
    }
}

const SETTING: Setting =
    Setting { interval_ns: 12_500_000, gain: [64; GAUGES], inputs: Inputs::Gauges };

fn converter() -> (OneChannel<Bus>, Rc<RefCell<Part>>) {
    let part = Rc::new(RefCell::new(Part::new()));
    (OneChannel::new(Bus(Rc::clone(&part))), part)
}

fn begun() -> (OneChannel<Bus>, Rc<RefCell<Part>>) {
    let (mut converter, part) = converter();
    converter.reset(&mut NoopDelay::new(), &SETTING).unwrap();
    converter.begin(&mut NoopDelay::new(), &SETTING).unwrap();
    (converter, part)
}

#[test]
fn it_is_set_as_its_data_sheet_asks() {
    let (mut converter, part) = begun();
    // On, converting, from its own regulator at 3.0 V; gain 64; data-ready falls; 80 a second; chopper off.
    let registers = part.borrow().registers;
    assert_eq!(registers[POWER] & !(1 << 3), 0b1001_0110);
    assert_eq!((registers[1], part.borrow().rate_bits(), registers[0x15]), (0xae, 3, 0x30));
    for interval_ns in converter.capabilities().intervals_ns() {
        converter.configure(&Setting { interval_ns, gain: [1; GAUGES], ..SETTING }).unwrap();
    }
    assert_eq!((part.borrow().registers[1], part.borrow().rate_bits()), (0xa8, 0));
    let impossible = Setting { interval_ns: 1_000_000, ..SETTING };
    assert_eq!(converter.configure(&impossible), Err(ConverterFault::Register));
}

#[test]
fn a_conversion_has_24_bits_and_a_sign() {
    let (mut converter, part) = begun();
    for (input, counts) in [(0.0, 0), (-1.0, -8_388_608), (1.0, 8_388_607), (-0.001, -536_870)] {
        part.borrow_mut().convert(input);
        assert_eq!(converter.read(), Ok([counts, 0, 0, 0]));
    }
    // What was read is not read again.
    assert_eq!(converter.read(), Err(ReadError::Stale));
}

#[test]
fn what_is_wrong_with_it_is_told_apart() {
    let (mut missing, part) = converter();
    part.borrow_mut().is_plugged_in = false;
    let delay = &mut NoopDelay::new();
    assert_eq!(missing.reset(delay, &SETTING), Err(ConverterFault::Missing));
    let (mut other, part) = converter();
    part.borrow_mut().registers[0x1f] = 0x03;
    assert_eq!(other.begin(delay, &SETTING), Err(ConverterFault::Wrong(0x03)));
    let (mut dead, part) = converter();
    part.borrow_mut().starts_after = u32::MAX;
    assert_eq!(dead.begin(delay, &SETTING), Err(ConverterFault::Register));
    let (mut stubborn, part) = converter();
    part.borrow_mut().is_stubborn = true;
    assert_eq!(stubborn.begin(delay, &SETTING), Err(ConverterFault::Register));
    let (mut lost, part) = begun();
    part.borrow_mut().reset();
    assert_eq!(lost.read(), Err(ReadError::SettingsLost));
}

/// The board of a fingertip with it, on a desk.
struct Desk(FrontEnd<OneChannel<Bus>, NoopDelay>, u64);

impl Board for Desk {
    fn configure(&mut self, setting: Setting) -> Result<(), ConverterFault> {
        self.0.configure(self.1, setting)
    }
    fn listen(&mut self, to_converter: bool) -> Lost {
        self.0.listen(self.1, to_converter)
    }
    fn store(&mut self, _: &[u8]) -> Result<(), StoreFault> {
        Ok(())
    }
    fn can_restart(&self, _: Restart) -> bool {
        false
    }
}

/// A host at the other end of a line without end.
#[derive(Default)]
struct Host {
    to_device: Vec<u8>,
    heard: Accumulator,
    part: String,
    channels: u8,
    settings: Option<Settings>,
    rows: Vec<Row>,
    refused: usize,
}

impl Host {
    fn say(&mut self, sequence: u32, command: &ToDevice<'_>) {
        let mut frame = [0; FRAME_MAX];
        let frame = encode(Head { sequence, time_us: 0 }, command, &mut frame).unwrap();
        self.to_device.extend(frame.iter().rev());
    }

    fn hear(&mut self, head: Head, message: &ToHost<'_>) {
        match message {
            ToHost::Hello(hello) => self.channels = hello.channels,
            ToHost::Converter { part, .. } => self.part = (*part).into(),
            ToHost::Settings { settings, .. } => self.settings = Some(*settings),
            ToHost::Answer(answer) => self.refused += usize::from(answer.outcome.is_err()),
            ToHost::Samples(block) => {
                assert_eq!(block.gauges, 1, "what is not there is not sent");
                let settings = self.settings.unwrap();
                let calibration = settings.config(settings.interval_s()).unwrap().calibration;
                self.rows.extend(Rows::decode(head, block).unwrap().iter(&calibration));
            }
            _ => {}
        }
    }
}

impl Link for Host {
    fn receive(&mut self) -> Option<u8> {
        self.to_device.pop()
    }
    fn has_room(&self) -> bool {
        true
    }
    fn send(&mut self, frame: &[u8]) {
        let mut heard = std::mem::take(&mut self.heard);
        for byte in frame {
            if let Accumulated::Frame(frame) = heard.push(*byte) {
                let (head, message) = decode(frame).unwrap();
                self.hear(head, &message);
            }
        }
        self.heard = heard;
    }
}

#[test]
fn a_fingertip_with_one_gauge_says_so_and_streams_it_at_its_own_rates() {
    let (converter, part) = converter();
    let capabilities = converter.capabilities();
    let identity = Identity {
        version: "1",
        git: "",
        board: "desk",
        serial: [0; 3],
        converter_clock_hz: 4_915_200,
        converter: <OneChannel<Bus> as Converter>::PART,
        capabilities,
        clock: shared::wire::ClockSource::Simulated,
        reset: shared::wire::ResetCause::PowerOn,
        panic: "",
    };
    let mut room = Room::new();
    let beginning = begin_with(None, &capabilities).unwrap();
    let mut runner = Runner::new(Device::new(identity, &beginning, &mut room));
    let mut desk = Desk(FrontEnd::new(converter, NoopDelay::new()), 0);
    let mut host = Host::default();
    let commands = [
        ToDevice::Hello(HelloToDevice { schema: SCHEMA, version: "1" }),
        // About a kilohertz is not to be had.
        ToDevice::SetInterval { ns: 1_024_000 },
        ToDevice::SetInterval { ns: 3_125_000 },
        ToDevice::Start(Start { source: Source::Converter, columns: Columns::Parts }),
    ];
    for (sequence, command) in (1..).zip(&commands) {
        host.say(sequence, command);
        runner.turn(0, &mut host, &mut std::iter::empty(), &mut desk, &mut ());
    }
    for sample in 1..=400 {
        desk.1 = sample * 3_125;
        part.borrow_mut().convert(sample as f64 * 1e-6);
        let mut came = desk.0.ready(desk.1).into_iter();
        runner.turn(desk.1, &mut host, &mut came, &mut desk, &mut ());
    }
    assert_eq!((&*host.part, host.channels, host.refused), ("NAU7802", 1, 1));
    assert_eq!((part.borrow().rate_bits(), host.settings.unwrap().interval_ns), (7, 3_125_000));
    // The first four settle; a block is on its way.
    assert!((380..=396).contains(&host.rows.len()), "{}", host.rows.len());
    let last = host.rows.last().unwrap();
    let sample = last.number + 5;
    assert_eq!(last.counts, [(sample as f64 * 128e-6 * 8_388_608.0) as i32, 0, 0, 0]);
    // The default calibration is true for its full scale: ε = 4 V / (2.5 V × 2).
    let strain = f64::from(last.fa[0] + last.sa[0]) / 256.0;
    let expected = sample as f64 * 1e-6 * 1.5 * 4.0 / 5.0 * 1e6;
    assert!((strain - expected).abs() < 0.01, "{strain} µε, not {expected}");
}
