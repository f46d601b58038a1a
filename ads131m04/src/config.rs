//! Clock, oversampling and gains, and the data rate that follows from them.

use core::{fmt, num::NonZero};

use crate::CHANNELS;

/// How the converter is to sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// The clock at CLKIN and the power mode that suits it.
    pub clock: Clock,
    /// Modulator samples per conversion.
    pub oversampling: Oversampling,
    /// Whether the inputs are swapped from one conversion to the next, and each result is the mean of two: the converter's own
    /// offset and its drift go, and conversions are three times as far apart (global chop, §8.4.3.2).
    pub chop: bool,
    /// Gain of each channel.
    pub gains: [Gain; CHANNELS],
}

impl Config {
    /// CLKIN periods per conversion, exact. With the chop on each conversion waits for the inputs and then for the whole filter.
    pub const fn clkin_periods(&self) -> u32 {
        let periods = self.oversampling.clkin_periods();
        // Three times 32,768 at most, and a little.
        if self.chop { periods.wrapping_mul(3).wrapping_add(CHOP_DELAY) } else { periods }
    }

    /// Conversions per second in millihertz, to the nearest. The exact rate is `clock.hz()` divided by
    /// [`Config::clkin_periods`].
    pub fn data_rate_millihertz(&self) -> u32 {
        let half_millihertz = u64::from(self.clock.hz()).saturating_mul(2000);
        // Never zero.
        rounded_half(half_millihertz.checked_div(self.clkin_periods().into()).unwrap_or(0))
    }

    /// Time from one conversion to the next in nanoseconds, to the nearest.
    pub fn sample_interval_ns(&self) -> u32 {
        let half_nanoseconds = u64::from(self.clkin_periods()).saturating_mul(2_000_000_000);
        rounded_half(half_nanoseconds / NonZero::<u64>::from(self.clock.hz))
    }

    /// The CLOCK register: all channels enabled.
    pub(crate) const fn clock_register(&self) -> u16 {
        0x0F00 | (self.oversampling as u16) << 2 | self.clock.power as u16
    }

    /// The CFG register: nothing but the chop, and its delay as after a reset.
    pub(crate) const fn cfg_register(&self) -> u16 {
        0x0600 | (self.chop as u16) << 8
    }

    /// The GAIN1 register.
    pub(crate) const fn gain_register(&self) -> u16 {
        let [g0, g1, g2, g3] = self.gains;
        (g3 as u16) << 12 | (g2 as u16) << 8 | (g1 as u16) << 4 | g0 as u16
    }
}

/// Periods of CLKIN for which the inputs settle when they were swapped: 16 of the modulator, GC_DLY as after a reset (§8.6).
const CHOP_DELAY: u32 = 32;

fn rounded_half(twice: u64) -> u32 {
    u32::try_from(twice.saturating_add(1) >> 1).unwrap_or(u32::MAX)
}

/// The clock that the host feeds to CLKIN; the part has none of its own (§8.3.5).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Clock {
    hz: NonZero<u32>,
    power: PowerMode,
}

impl Clock {
    /// Slowest clock of any power mode.
    pub const MIN_HZ: u32 = 300_000;

    /// A clock of `hz`, at 40 % to 60 % duty, in the given power mode.
    ///
    /// # Errors
    /// [`ClockError`] when the mode is not specified at this frequency (§6.3).
    pub const fn new(hz: u32, power: PowerMode) -> Result<Self, ClockError> {
        match NonZero::new(hz) {
            Some(hz) if Self::MIN_HZ <= hz.get() && hz.get() <= power.max_hz() => {
                Ok(Self { hz, power })
            }
            _ => Err(ClockError { hz, power }),
        }
    }

    /// Frequency at CLKIN.
    pub const fn hz(self) -> u32 {
        self.hz.get()
    }

    /// At least so many of its periods, whole microseconds and one to spare.
    pub(crate) fn duration_us(self, periods: u32) -> u32 {
        let us = u64::from(periods).saturating_mul(1_000_000) / NonZero::<u64>::from(self.hz);
        u32::try_from(us).unwrap_or(u32::MAX).saturating_add(2)
    }

    /// Power mode.
    pub const fn power(self) -> PowerMode {
        self.power
    }
}

/// A clock outside the range of its power mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ClockError {
    /// The frequency asked for.
    pub hz: u32,
    /// The power mode asked for.
    pub power: PowerMode,
}

impl fmt::Display for ClockError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { hz, power } = self;
        let (min, max) = (Clock::MIN_HZ, power.max_hz());
        write!(f, "{power:?} takes a CLKIN of {min} to {max} Hz, not {hz} Hz")
    }
}

impl core::error::Error for ClockError {}

/// Bias currents of the converter; a faster clock needs more (§8.3.5, §8.4.4).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u16)]
pub enum PowerMode {
    /// CLKIN up to 2.08 MHz, nominally 2.048 MHz.
    VeryLow = 0b00,
    /// CLKIN up to 4.15 MHz, nominally 4.096 MHz.
    Low = 0b01,
    /// CLKIN up to 8.4 MHz, nominally 8.192 MHz.
    HighResolution = 0b10,
}

impl PowerMode {
    /// Fastest clock of this mode.
    pub const fn max_hz(self) -> u32 {
        match self {
            Self::VeryLow => 2_080_000,
            Self::Low => 4_150_000,
            Self::HighResolution => 8_400_000,
        }
    }
}

/// Samples of the modulator, which runs at half of CLKIN, per conversion (§8.3.7).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u16)]
pub enum Oversampling {
    /// 128: 32 kHz at 8.192 MHz.
    X128 = 0,
    /// 256: 16 kHz at 8.192 MHz.
    X256 = 1,
    /// 512: 8 kHz at 8.192 MHz.
    X512 = 2,
    /// 1024: 4 kHz at 8.192 MHz; the default after a reset.
    X1024 = 3,
    /// 2048: 2 kHz at 8.192 MHz.
    X2048 = 4,
    /// 4096: 1 kHz at 8.192 MHz.
    X4096 = 5,
    /// 8192: 500 Hz at 8.192 MHz.
    X8192 = 6,
    /// 16384: 250 Hz at 8.192 MHz. So the table of data rates (8-2) and the filter, a sinc³ over 1024 and an average of
    /// 16; the table of the CLOCK register prints 16256.
    X16384 = 7,
}

impl Oversampling {
    /// Every ratio, ascending.
    pub const ALL: [Self; 8] = [
        Self::X128,
        Self::X256,
        Self::X512,
        Self::X1024,
        Self::X2048,
        Self::X4096,
        Self::X8192,
        Self::X16384,
    ];

    /// Modulator samples per conversion.
    pub const fn ratio(self) -> u32 {
        128 << self as u32
    }

    /// CLKIN periods per conversion, exact: twice the ratio.
    pub const fn clkin_periods(self) -> u32 {
        256 << self as u32
    }
}

/// What the channels measure (§8.3.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u16)]
pub enum Inputs {
    /// Their pins.
    Pins = 0b00,
    /// Nothing: both sides of each are joined.
    Shorted = 0b01,
    /// A positive signal of the part's own, [`Inputs::TEST_COUNTS`] at any gain (§8.3.9).
    TestSignal = 0b10,
}

impl Inputs {
    /// Counts of the test signal: 2/15 of full scale.
    pub const TEST_COUNTS: i32 = (1 << 24) / 15;
}

/// Gain before the modulator; full scale is ±1.2 V divided by it (§8.3.3).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u16)]
#[allow(missing_docs, reason = "the names are the gains")]
pub enum Gain {
    X1 = 0,
    X2 = 1,
    X4 = 2,
    X8 = 3,
    X16 = 4,
    X32 = 5,
    X64 = 6,
    X128 = 7,
}

impl Gain {
    /// Every gain, ascending.
    pub const ALL: [Self; 8] =
        [Self::X1, Self::X2, Self::X4, Self::X8, Self::X16, Self::X32, Self::X64, Self::X128];

    /// The gain as a number, 1 to 128.
    pub const fn factor(self) -> u32 {
        1 << self as u32
    }
}
