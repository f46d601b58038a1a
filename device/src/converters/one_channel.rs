//! The NAU7802 over I²C: one gauge, up to 320 samples a second. Boards with it are sold for weighing cells.
//!
//! Its data-ready pin is set to fall with a conversion, as the line of other converters does. Its two channels share one modulator and
//! settle anew at every change, so that only the first is read; it has no checksums.

use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::{Error, ErrorKind, I2c};
use shared::pipeline::GAUGES;
use shared::wire::{Capabilities, ConverterFault};

use crate::front_end::{Converter, ReadError, Setting};

/// The only address that it has.
const ADDRESS: u8 = 0x2a;

/// Power, beginning and state of conversions.
const POWER: u8 = 0x00;
const REGISTERS_RESET: u8 = 1 << 0;
const DIGITAL_ON: u8 = 1 << 1;
const ANALOGUE_ON: u8 = 1 << 2;
const IS_READY: u8 = 1 << 3;
const CONVERTS: u8 = 1 << 4;
const HAS_DATA: u8 = 1 << 5;
const SUPPLY_OF_ITS_OWN: u8 = 1 << 7;
const RUNNING: u8 = DIGITAL_ON | ANALOGUE_ON | SUPPLY_OF_ITS_OWN;

/// Gain in bits 0 to 2, the regulator's voltage in 3 to 5 (3.0 V for a supply of 3.3 V), and which way the data-ready pin goes.
const CONTROL_1: u8 = 0x01;
const REGULATOR_3_V: u8 = 0b101 << 3;
const READY_IS_LOW: u8 = 1 << 7;

/// Rate in bits 4 to 6.
const CONTROL_2: u8 = 0x02;
const RATES: [(u32, u8); 5] = [
    (3_125_000, 0b111),
    (12_500_000, 0b011),
    (25_000_000, 0b010),
    (50_000_000, 0b001),
    (100_000_000, 0b000),
];

/// The conversion, 24 bits, the highest first.
const RESULT: u8 = 0x12;
/// The chopper's clock, which must be off.
const CHOPPER: u8 = 0x15;
const CHOPPER_OFF: u8 = 0b11 << 4;
/// Its low half is the same in every part.
const REVISION: u8 = 0x1f;
const REVISION_LOW: u8 = 0x0f;

/// From power on to ready takes 200 µs; it is asked so often, so far apart.
const PATIENCE: u32 = 20;
const PAUSE_US: u32 = 50;

/// A NAU7802 on its bus.
#[derive(Debug)]
pub struct OneChannel<I2C> {
    bus: I2C,
}

impl<I2C: I2c> OneChannel<I2C> {
    /// The part on its bus, of at most 400 kHz.
    pub const fn new(bus: I2C) -> Self {
        Self { bus }
    }

    fn write(&mut self, register: u8, value: u8) -> Result<(), ConverterFault> {
        self.bus.write(ADDRESS, &[register, value]).map_err(|error| fault(&error))
    }

    fn take<const BYTES: usize>(&mut self, register: u8) -> Result<[u8; BYTES], ConverterFault> {
        let mut values = [0; BYTES];
        let done = self.bus.write_read(ADDRESS, &[register], &mut values);
        done.map(|()| values).map_err(|error| fault(&error))
    }

    fn write_verified(&mut self, register: u8, value: u8) -> Result<(), ConverterFault> {
        self.write(register, value)?;
        let [kept] = self.take(register)?;
        if kept == value { Ok(()) } else { Err(ConverterFault::Register) }
    }
}

impl<I2C: I2c> Converter for OneChannel<I2C> {
    const PART: &'static str = "NAU7802";

    fn capabilities(&self) -> Capabilities {
        let [a, b, c, d, e] = RATES.map(|(interval_ns, _)| interval_ns);
        Capabilities {
            channels: 1,
            intervals_ns: [a, b, c, d, e, 0, 0, 0],
            chopped: 0,
            gains: 0xff,
            // Half of the regulator's 3.0 V, which is its reference too.
            full_scale_nv: 1_500_000_000,
            count_bits: 24,
            settling: 4,
            test_counts: 0,
        }
    }

    fn reset(&mut self, _: &mut impl DelayNs, _: &Setting) -> Result<(), ConverterFault> {
        self.write(POWER, REGISTERS_RESET)
    }

    fn begin(&mut self, delay: &mut impl DelayNs, setting: &Setting) -> Result<(), ConverterFault> {
        self.write(POWER, DIGITAL_ON)?;
        let mut asked = 0;
        while self.take(POWER).map(|[power]| power & IS_READY == 0)? {
            if asked == PATIENCE {
                return Err(ConverterFault::Register);
            }
            asked = asked.wrapping_add(1);
            delay.delay_us(PAUSE_US);
        }
        let [revision] = self.take(REVISION)?;
        if revision & 0x0f != REVISION_LOW {
            return Err(ConverterFault::Wrong(revision.into()));
        }
        self.configure(setting)?;
        self.write_verified(CHOPPER, CHOPPER_OFF)?;
        self.write(POWER, RUNNING | CONVERTS)
    }

    fn configure(&mut self, setting: &Setting) -> Result<(), ConverterFault> {
        let rate = RATES.into_iter().find(|(interval_ns, _)| *interval_ns == setting.interval_ns);
        let (_, rate) = rate.ok_or(ConverterFault::Register)?;
        let [gain, ..] = setting.gain;
        let gain = gain.checked_ilog2().ok_or(ConverterFault::Register)? as u8;
        self.write_verified(CONTROL_1, READY_IS_LOW | REGULATOR_3_V | gain)?;
        self.write_verified(CONTROL_2, rate << 4)
    }

    fn read(&mut self) -> Result<[i32; GAUGES], ReadError> {
        let [power] = self.take(POWER).map_err(ReadError::Fault)?;
        if power & RUNNING != RUNNING {
            return Err(ReadError::SettingsLost);
        }
        if power & HAS_DATA == 0 {
            return Err(ReadError::Stale);
        }
        let [high, middle, low] = self.take(RESULT).map_err(ReadError::Fault)?;
        // The sign is that of the upper byte.
        Ok([i32::from_be_bytes([high, middle, low, 0]) >> 8, 0, 0, 0])
    }

    fn discard_stale(&mut self) {
        // A line that is dead will say so when it is read.
        let _ = self.take::<3>(RESULT);
    }
}

fn fault(error: &impl Error) -> ConverterFault {
    match error.kind() {
        ErrorKind::NoAcknowledge(_) => ConverterFault::Missing,
        _ => ConverterFault::Bus,
    }
}
