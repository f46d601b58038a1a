//! An ADS131M04 as its data sheet (SBAS890) has it: registers, two samples kept, DRDY, settling, and what can go wrong with it.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard};

use rsemu::bus::spi::{BitOrder, ChipSelect, Format, Mode, SpiBus, SpiSlave};
use rsemu::core::device::DeviceClass;
use rsemu::core::wire::WireSource;
use rsemu::machine::validate::{ClassSchema, PortDir};

use crate::part::{Clock, Part, Wires, class};

static CLASS: DeviceClass = class("palpate.ads131m04", "ADS131M04");

/// Clock at CLKIN, Hz: one tick of this model.
pub const CLOCK_HZ: u64 = 8_000_000;
/// SYNC/RESET low for so many ticks is a reset (t_w(RSL), §6.6).
const RESET_TICKS: u64 = 2_048;
/// Conversions that mix old and new after a change of gain (§8.3.7).
const SETTLING: u32 = 3;
/// Samples kept for each channel (§8.5.1.9.1).
const KEPT: usize = 2;
const BYTES: usize = 18;

const STATUS: usize = 1;
const MODE: usize = 2;
const CLOCK: usize = 3;
const GAIN1: usize = 4;
const CFG: usize = 6;
/// Inputs of the four channels, in their lowest two bits (§8.6).
const CHANNELS: [usize; 4] = [0x09, 0x0e, 0x13, 0x18];
/// Global chop, and periods of the modulator that the inputs settle for (§8.4.3.2).
const CHOPS: u16 = 1 << 8;
const CHOP_DELAY: u64 = 16;
/// 2/15 of full scale (§8.3.9).
const TEST_SIGNAL: i32 = (1 << 24) / 15;
const WAS_RESET: u16 = 1 << 10;

/// What is wrong with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Fault {
    /// Nothing.
    #[default]
    None,
    /// The wire from DOUT is broken: every byte reads FFh.
    WireBroken,
    /// Every frame has a wrong checksum.
    Damaged,
    /// One frame in so many has a wrong checksum.
    DamagedOnceIn(u64),
    /// The data-ready line stands still.
    DrdyStuck,
}

/// Its insides.
#[derive(Debug)]
pub struct Chip {
    registers: [u16; 64],
    kept: VecDeque<[i32; 4]>,
    /// Counts at a gain of 1, times 128, of a conversion.
    pub input: fn(u64) -> [i32; 4],
    /// Counts that it reads too many, unless it chops.
    pub offset: i32,
    /// What is wrong with it.
    pub fault: Fault,
    /// Conversions since power came.
    pub conversions: u64,
    /// Longest time from a falling edge of DRDY to the frame that answers it, ticks.
    pub slowest_answer: u64,
    /// Frames, and those that found nothing new.
    pub frames: u64,
    /// Frames that found nothing new.
    pub empty: u64,
    settling: u32,
    gains_before: [i32; 4],
    /// What the next frame begins with, if not with the status.
    response: Option<u16>,
    out: [u8; BYTES],
    got: Vec<u8>,
    selected: bool,
    ready_at: Option<u64>,
    next: u64,
    drdy: bool,
    reset_low_since: Option<u64>,
}

/// A steady signal with the noise of a real one.
fn steady(conversion: u64) -> [i32; 4] {
    let noise = (conversion as i32).wrapping_mul(-1_640_531_535) >> 22;
    [1_000_000, -1_000_000, 2_000_000, 3_000_000].map(|counts| counts + noise)
}

impl Chip {
    fn new() -> Self {
        Self {
            registers: defaults(),
            kept: VecDeque::new(),
            input: steady,
            offset: 0,
            fault: Fault::None,
            conversions: 0,
            slowest_answer: 0,
            frames: 0,
            empty: 0,
            settling: 0,
            gains_before: [1; 4],
            response: Some(0xff24),
            out: [0; BYTES],
            got: Vec::new(),
            selected: false,
            ready_at: None,
            next: 2_048,
            drdy: true,
            reset_low_since: None,
        }
    }

    /// As a dip of the supply or a discharge does it: gains, rate and checks are its defaults.
    pub fn reset(&mut self) {
        self.registers = defaults();
        self.kept.clear();
        self.response = Some(0xff24);
        self.gains_before = [1; 4];
        self.settling = SETTLING;
    }

    /// Ticks from one conversion to the next.
    #[must_use]
    pub fn interval(&self) -> u64 {
        let ratio = 128 << ((self.registers[CLOCK] >> 2) & 7);
        2 * if self.chops() { CHOP_DELAY + 3 * ratio } else { ratio }
    }

    fn chops(&self) -> bool {
        self.registers[CFG] & CHOPS != 0
    }

    /// Gains that are set.
    #[must_use]
    pub fn gains(&self) -> [i32; 4] {
        std::array::from_fn(|channel| 1 << ((self.registers[GAIN1] >> (4 * channel)) & 7))
    }

    /// The next conversion. While the filter settles its result lies between that of the old gain and that of the new.
    fn convert(&mut self) -> [i32; 4] {
        self.conversions += 1;
        let input = (self.input)(self.conversions);
        let (old, new) = (self.gains_before, self.gains());
        let left = self.settling as i64;
        self.settling = self.settling.saturating_sub(1);
        if self.settling == 0 {
            self.gains_before = new;
        }
        std::array::from_fn(|at| {
            let of = |gain: i32| i64::from(input[at]) * i64::from(gain) / 128;
            let pins = (of(old[at]) * left + of(new[at]) * (4 - left)) / 4;
            let measured = match self.registers[CHANNELS[at]] & 3 {
                0 => pins,
                1 => 0,
                2 => TEST_SIGNAL.into(),
                _ => i64::from(-TEST_SIGNAL),
            };
            let offset = if self.chops() { 0 } else { self.offset };
            (measured + i64::from(offset)).clamp(-(1 << 23), (1 << 23) - 1) as i32
        })
    }

    fn status(&self, fresh: bool) -> u16 {
        self.registers[STATUS] & 0xfff0 | if fresh { 15 } else { 0 }
    }

    fn begin_frame(&mut self) {
        self.got.clear();
        self.frames += 1;
        let counts = self.kept.pop_front();
        self.empty += u64::from(counts.is_none());
        let first = self.response.unwrap_or_else(|| self.status(counts.is_some()));
        self.out = [0; BYTES];
        self.out[..2].copy_from_slice(&first.to_be_bytes());
        for (place, count) in self.out[3..].chunks_mut(3).zip(counts.unwrap_or_default()) {
            place.copy_from_slice(&count.to_be_bytes()[1..]);
        }
        let sum = checksum(&self.out[..15]);
        self.out[15..17].copy_from_slice(&sum.to_be_bytes());
        match self.fault {
            Fault::WireBroken => self.out = [0xff; BYTES],
            Fault::Damaged => self.out[4] ^= 1,
            Fault::DamagedOnceIn(frames) if self.frames.is_multiple_of(frames) => self.out[4] ^= 1,
            _ => {}
        }
    }

    fn end_frame(&mut self) {
        let word = |at: usize| {
            self.got.get(3 * at..3 * at + 2).map_or(0, |b| u16::from_be_bytes([b[0], b[1]]))
        };
        let (command, value) = (word(0), word(1));
        let register = usize::from(command >> 7 & 63);
        self.response = match command & 0xe000 {
            0xa000 if register == STATUS => Some(self.status(!self.kept.is_empty())),
            0xa000 => Some(self.registers[register]),
            0x6000 => {
                self.write(register, value);
                Some(0x4000 | command & 0x1f80)
            }
            _ if command == 0x0011 => {
                self.reset();
                Some(0xff24)
            }
            _ => (command != 0).then_some(command),
        };
    }

    fn write(&mut self, register: usize, value: u16) {
        let settles = [GAIN1, CLOCK, CFG].contains(&register) || CHANNELS.contains(&register);
        if self.registers[register] != value && settles {
            self.gains_before = self.gains();
            self.settling = SETTLING;
        }
        self.registers[register] = value;
        if register == MODE && value & WAS_RESET == 0 {
            self.registers[STATUS] &= !WAS_RESET;
        }
    }
}

fn defaults() -> [u16; 64] {
    let mut registers = [0; 64];
    registers[..4].copy_from_slice(&[0x2403, 0x0500, 0x0510, 0x0f0e]);
    registers[CFG] = 0x0600;
    registers
}

fn checksum(bytes: &[u8]) -> u16 {
    let shift = |sum: u16| if sum & 0x8000 == 0 { sum << 1 } else { sum << 1 ^ 0x1021 };
    bytes.iter().fold(0xffff, |sum, byte| (0..8).fold(sum ^ u16::from(*byte) << 8, |s, _| shift(s)))
}

/// The part on its bus and pins.
#[derive(Debug)]
pub struct Converter {
    chip: Mutex<Chip>,
    bus: Arc<SpiBus>,
    clock: Clock,
    pins: Wires,
    /// Whether its clock is another finger's.
    is_clocked: bool,
}

const CS: u32 = 0;
const RESET: u32 = 1;

impl Converter {
    /// On a bus, with a clock of its own board or of another finger's, which the board hears by a joint to ground.
    #[must_use]
    pub fn new(bus: Arc<SpiBus>, is_clocked: bool) -> Arc<Self> {
        let converter = Arc::new(Self {
            chip: Mutex::new(Chip::new()),
            bus: bus.clone(),
            clock: Clock::new(),
            pins: Wires::default(),
            is_clocked,
        });
        converter.clock.due(Some(2_048));
        bus.attach(ChipSelect(0), converter.clone()).unwrap();
        converter
    }

    /// Its insides, to look at and to break.
    pub fn chip(&self) -> MutexGuard<'_, Chip> {
        self.chip.lock().unwrap()
    }

    fn drive(&self, drdy: bool) {
        self.chip().drdy = drdy;
        self.pins.drive("drdy", drdy);
    }
}

impl Part for Converter {
    fn class() -> &'static DeviceClass {
        &CLASS
    }

    fn input_named(&self, port: &str) -> Option<u32> {
        match port {
            "cs" => Some(CS),
            "reset" => Some(RESET),
            _ => None,
        }
    }

    fn input(&self, pin: u32, high: bool) {
        if pin == CS {
            // The pin is one of the processor's own, not the bus's.
            self.bus.select((!high).then_some(ChipSelect(0)));
            return;
        }
        self.clock.sync();
        let now = self.clock.now();
        let mut chip = self.chip();
        if !high {
            chip.reset_low_since.get_or_insert(now);
        } else if chip.reset_low_since.take().is_some_and(|since| now - since >= RESET_TICKS) {
            chip.reset();
        }
    }

    fn connect(&self, port: &str, wire: WireSource) {
        self.pins.add(port, wire);
    }

    fn announce(&self) {
        let drdy = self.chip().drdy;
        self.pins.drive("drdy", drdy);
        self.pins.drive("strap", !self.is_clocked);
    }

    fn clock(&self) -> Option<&Clock> {
        Some(&self.clock)
    }

    fn advance(&self, to: u64) {
        loop {
            let mut chip = self.chip();
            let at = chip.next;
            if at > to {
                self.clock.set(to);
                self.clock.due(Some(at));
                return;
            }
            chip.next += chip.interval();
            self.clock.set(at);
            self.clock.due(Some(chip.next));
            if chip.reset_low_since.is_some() {
                continue;
            }
            let counts = chip.convert();
            if chip.kept.len() == KEPT {
                chip.kept.pop_front();
            }
            chip.kept.push_back(counts);
            if chip.fault == Fault::DrdyStuck {
                continue;
            }
            chip.ready_at.get_or_insert(at);
            let unread = !chip.drdy;
            drop(chip);
            if unread {
                // It goes high shortly before the next conversion (§8.5.1.9.1).
                self.drive(true);
            }
            self.drive(false);
        }
    }
}

impl SpiSlave for Converter {
    fn format(&self) -> Format {
        Format { mode: Mode::Mode1, bits: 8, order: BitOrder::MsbFirst }
    }

    fn select(&self, selected: bool) {
        self.clock.sync();
        let now = self.clock.now();
        let mut chip = self.chip();
        if selected == chip.selected {
            return;
        }
        chip.selected = selected;
        if selected {
            if let Some(ready) = chip.ready_at.take() {
                chip.slowest_answer = chip.slowest_answer.max(now - ready);
            }
            chip.begin_frame();
        } else {
            chip.end_frame();
            drop(chip);
            self.drive(true);
        }
    }

    fn transfer(&self, byte: u32) -> u32 {
        let mut chip = self.chip();
        let at = chip.got.len();
        chip.got.push(byte as u8);
        u32::from(chip.out.get(at).copied().unwrap_or(0))
    }
}

/// Its pins.
pub fn schema() -> ClassSchema {
    let schema = ClassSchema::new(CLASS.name);
    schema
        .port("cs", PortDir::In)
        .port("reset", PortDir::In)
        .port("drdy", PortDir::Out)
        .port("strap", PortDir::Out)
}
