//! When a change is an event, in physical units and as integers.

use core::fmt;

use super::vibration::raised;
use crate::fixed::{fraction_31, round_to_i32};

/// Most jolts that a slip can be asked to have.
pub const JOLTS_MOST: usize = 8;

/// Levels in the unit of the signal (µε for a gauge), times in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// FA at or beyond which there is a burst; above 0. A quarter of it is the resting band.
    pub burst: f64,
    /// Vibration of FA at or beyond which there is a jolt; above 0.
    pub jolt: f64,
    /// Jolts that make a slip, 2 to [`JOLTS_MOST`]; 0 looks for none.
    pub jolts: u8,
    /// Time within which they must come, s. As long without one, and a slip is over.
    pub within_s: f64,
    /// What of FA is faster than this is vibration, Hz; at most a quarter of the sample rate.
    pub corner_hz: f64,
    /// Two jolts are at least so far apart, s.
    pub apart_s: f64,
    /// How fast a hard knock is forgotten, and how long no jolt counts after a touch, s.
    pub masking_s: f64,
    /// FA is smoothed with this time before bursts are looked for, s; 0 for none.
    pub smoothing_s: f64,
    /// Quiet for so long, a reading without contact is one at rest, s.
    pub settle_s: f64,
    /// Whether pressing can only raise the signal, as a force; a gauge may be stretched or compressed by it.
    pub only_up: bool,
}

impl Settings {
    /// For a gauge in µε with noise up to 0.1 µε at 1 kHz: a burst of 2 µε, three jolts of 0.05 µε within 0.25 s.
    pub const DEFAULT: Self = Self {
        burst: 2.0,
        jolt: 0.05,
        jolts: 3,
        within_s: 0.25,
        corner_hz: 100.0,
        apart_s: 0.02,
        masking_s: 0.1,
        smoothing_s: 0.002,
        settle_s: 0.5,
        only_up: false,
    };

    /// These for samples `interval_s` seconds apart: without a search for slip where fewer than four of them fall on a period of
    /// the corner.
    #[must_use]
    pub fn at_interval(self, interval_s: f64) -> Self {
        let fast_enough = self.corner_hz * interval_s <= 0.25;
        Self { jolts: if fast_enough { self.jolts } else { 0 }, ..self }
    }
}

/// Why a [`Config`] cannot be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConfigError {
    /// A level is not a positive number.
    Level {
        /// Name of the setting.
        name: &'static str,
        /// Its value, in the unit of the signal.
        value: f64,
    },
    /// A time is negative, not a number, or longer than 2^30 samples.
    Time {
        /// Name of the setting.
        name: &'static str,
        /// Its value, s.
        value: f64,
    },
    /// Neither 0 nor between 2 and [`JOLTS_MOST`] jolts.
    Jolts(u8),
    /// The corner is not between 0 and a quarter of the sample rate.
    Corner {
        /// The corner, Hz.
        corner_hz: f64,
        /// The highest that is possible, Hz.
        most_hz: f64,
    },
    /// The sample interval, s, or the size of one LSB, is not a positive finite number.
    Scale(f64),
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Level { name, value } => write!(f, "{name} = {value} must be positive"),
            Self::Time { name, value } => {
                write!(f, "{name} = {value} s must lie between 0 and 2^30 sample intervals")
            }
            Self::Jolts(jolts) => {
                write!(f, "{jolts} jolts: a slip has 2 to {JOLTS_MOST}, or 0 to look for none")
            }
            Self::Corner { corner_hz, most_hz } => write!(
                f,
                "a corner of {corner_hz} Hz must lie between 0 and {most_hz} Hz, a quarter of the sample rate"
            ),
            Self::Scale(value) => {
                write!(f, "sample interval and LSB must be positive and finite, not {value}")
            }
        }
    }
}

impl core::error::Error for ConfigError {}

/// [`Settings`] at one sample interval, as integers; serves any number of channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Config {
    pub(super) burst: i32,
    pub(super) band: i32,
    pub(super) jolt: i32,
    pub(super) jolts: u8,
    pub(super) within: u32,
    pub(super) apart: u32,
    pub(super) deaf: u32,
    pub(super) settle: u32,
    /// Shares of the way that low passes go in one sample, 31 fractional bits.
    pub(super) corner: i32,
    pub(super) masking: i32,
    pub(super) smoothing: i32,
    pub(super) resting: i32,
    only_up: bool,
}

impl Config {
    /// Settings for samples `interval_s` seconds apart of a signal whose LSB is `lsb` in its unit (2^-8 µε for a gauge).
    /// Levels below one LSB are one LSB.
    ///
    /// # Errors
    /// [`ConfigError`] names the setting that is out of range.
    ///
    /// ```
    /// use palpate_shared::events::{Config, Settings};
    /// let config = Config::new(&Settings::DEFAULT, 1.0 / 256.0, 1e-3)?;
    /// # Ok::<(), palpate_shared::events::ConfigError>(())
    /// ```
    pub fn new(settings: &Settings, lsb: f64, interval_s: f64) -> Result<Self, ConfigError> {
        for scale in [lsb, interval_s] {
            if !(scale.is_finite() && scale > 0.0) {
                return Err(ConfigError::Scale(scale));
            }
        }
        let level = |name, value: f64| {
            if value.is_finite() && value > 0.0 {
                Ok(raised(round_to_i32(value / lsb).max(1)))
            } else {
                Err(ConfigError::Level { name, value })
            }
        };
        let samples = |name, value: f64| {
            let samples = libm::round(value / interval_s);
            if (0.0..=1_073_741_824.0).contains(&samples) {
                Ok(samples as u32)
            } else {
                Err(ConfigError::Time { name, value })
            }
        };
        let share = |name, time_s: f64| {
            samples(name, time_s)?;
            Ok(share_of(interval_s / time_s))
        };
        let jolts = settings.jolts;
        if jolts == 1 || usize::from(jolts) > JOLTS_MOST {
            return Err(ConfigError::Jolts(jolts));
        }
        let (corner_hz, most_hz) = (settings.corner_hz, 0.25 / interval_s);
        if jolts > 0 && !(corner_hz > 0.0 && corner_hz <= most_hz) {
            return Err(ConfigError::Corner { corner_hz, most_hz });
        }
        let burst = level("burst", settings.burst)?;
        Ok(Self {
            burst,
            band: (burst / 4).max(1),
            jolt: level("jolt", settings.jolt)?,
            jolts,
            within: samples("within_s", settings.within_s)?,
            apart: samples("apart_s", settings.apart_s)?,
            deaf: samples("masking_s", settings.masking_s)?,
            settle: samples("settle_s", settings.settle_s)?,
            corner: share_of(core::f64::consts::TAU * corner_hz * interval_s),
            masking: share("masking_s", settings.masking_s)?,
            smoothing: share("smoothing_s", settings.smoothing_s)?,
            resting: share("settle_s", settings.settle_s)?,
            only_up: settings.only_up,
        })
    }

    /// Whether a burst up, or down, may be a touch.
    pub(super) const fn admits(&self, up: bool) -> bool {
        up || !self.only_up
    }
}

/// The share 1 − e^(−x) of its way that a low pass goes in x time constants, 31 fractional bits.
fn share_of(time_constants: f64) -> i32 {
    fraction_31(-libm::expm1(-time_constants))
}
