//! Thresholds that tell a boundary from noise, in physical units and as integers.

use core::fmt;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use super::average::Average;

/// What tells a boundary from noise. Levels are in LSB of the signal or of the motion, whatever those are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Thresholds {
    /// Signal at or above which there is contact.
    pub touch: i32,
    /// Signal at or below which contact is lost; below `touch` by more than the noise of the smoothed signal.
    pub release: i32,
    /// Fall from the highest signal that counts as having passed B; more than the noise of the smoothed signal.
    pub peak_drop: i32,
    /// Smallest change of the motion told from its noise after smoothing. A movement is found when it has covered two of
    /// these, and has stopped when it no longer makes one within the dwell: the slowest motion seen is one step per dwell
    /// (at least one LSB per smoothing time).
    pub motion_step: i32,
    /// Latent part within which the material counts as settled.
    pub latent_dead_band: i32,
    /// Time over which motion and signal are averaged before they are looked at, s; rounded to a power of two of samples,
    /// at most 2^12.
    pub smoothing_s: f64,
    /// Time the motion must stand to have stopped and the latent part be small to have recovered, s.
    pub dwell_s: f64,
    /// Recovery ends after this time at the latest, s.
    pub recovery_limit_s: f64,
}

/// Why a [`Config`] cannot be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConfigError {
    /// A level that must be positive is not.
    Level {
        /// Name of the threshold.
        name: &'static str,
        /// Its value, LSB.
        value: i32,
    },
    /// `release` is not below `touch`.
    Hysteresis {
        /// Touch level, LSB.
        touch: i32,
        /// Release level, LSB.
        release: i32,
    },
    /// A time is negative, not a number, or longer than 2^30 samples.
    Time {
        /// Name of the time.
        name: &'static str,
        /// Its value, s.
        value: f64,
    },
    /// The sample interval is not a positive finite number, s.
    Interval(f64),
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Level { name, value } => write!(f, "{name} = {value} must be positive"),
            Self::Hysteresis { touch, release } => {
                write!(f, "release level {release} must be below touch level {touch}")
            }
            Self::Time { name, value } => {
                write!(f, "{name} = {value} s must lie between 0 and 2^30 sample intervals")
            }
            Self::Interval(interval) => {
                write!(f, "sample interval of {interval} s must be positive and finite")
            }
        }
    }
}

impl core::error::Error for ConfigError {}

/// [`Thresholds`] at one sample interval, as integers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Config {
    pub(super) touch: i32,
    pub(super) release: i32,
    pub(super) peak_drop: i32,
    pub(super) motion_step: i32,
    /// Two steps: what a motion covers before it is seen to begin or to turn.
    pub(super) motion_turn: i32,
    /// How far the level of a standing motion may creep from one mean to the next.
    pub(super) motion_creep: i32,
    pub(super) latent_dead_band: i32,
    /// Each mean begins so.
    pub(super) average: Average,
    pub(super) dwell: u32,
    pub(super) recovery_limit: u32,
}

impl Config {
    /// Thresholds for samples `interval_s` seconds apart.
    ///
    /// # Errors
    /// [`ConfigError`] names the threshold that is out of range.
    pub fn new(thresholds: &Thresholds, interval_s: f64) -> Result<Self, ConfigError> {
        let t = thresholds;
        if !(interval_s.is_finite() && interval_s > 0.0) {
            return Err(ConfigError::Interval(interval_s));
        }
        for (name, value) in [
            ("touch", t.touch),
            ("peak_drop", t.peak_drop),
            ("motion_step", t.motion_step),
            ("latent_dead_band", t.latent_dead_band),
        ] {
            if value <= 0 {
                return Err(ConfigError::Level { name, value });
            }
        }
        if t.release >= t.touch {
            return Err(ConfigError::Hysteresis { touch: t.touch, release: t.release });
        }
        let samples = |name, value: f64| {
            let samples = libm::round(value / interval_s);
            if (0.0..=1_073_741_824.0).contains(&samples) {
                Ok(samples as u32)
            } else {
                Err(ConfigError::Time { name, value })
            }
        };
        let smoothing = f64::from(samples("smoothing_s", t.smoothing_s)?.max(1));
        let dwell = samples("dwell_s", t.dwell_s)?.max(1);
        let smoothing = libm::fmin(libm::round(libm::log2(smoothing)), 12.0) as u32;
        let creep = (i64::from(t.motion_step) << smoothing).checked_div(i64::from(dwell));
        Ok(Self {
            touch: t.touch,
            release: t.release,
            peak_drop: t.peak_drop,
            motion_step: t.motion_step,
            motion_turn: t.motion_step.saturating_mul(2),
            motion_creep: i32::try_from(creep.unwrap_or(0)).unwrap_or(i32::MAX).max(1),
            latent_dead_band: t.latent_dead_band,
            average: Average::of(smoothing),
            dwell,
            recovery_limit: samples("recovery_limit_s", t.recovery_limit_s)?,
        })
    }

    /// Samples between two means: boundaries closer together cannot be told apart.
    pub(super) const fn resolution(&self) -> u32 {
        self.average.samples
    }
}
