//! What can be set on a device, and is kept over a loss of power.

use core::fmt;

use postcard_schema::Schema;
use postcard_schema::schema::NamedType;
use serde::{Deserialize, Serialize};

use super::per_gauge::PerGauge;
use crate::adaptation::{self, Relaxation};
use crate::calibration::{Calibration, CalibrationError, Sheet};
use crate::phase::{self, Thresholds};
use crate::pipeline::{Config, GAUGES};

/// Everything that can be set on a device.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Listed", into = "Listed")]
pub struct Settings {
    /// Time between two samples of the converter, ns.
    pub interval_ns: u32,
    /// Gain of the converter, gauge by gauge: a power of two, 1 … 128.
    pub gain: [u8; GAUGES],
    /// Counts to strain, gauge by gauge; true for the gain above.
    pub calibration: [Sheet; GAUGES],
    /// Strain taken as zero, LSB, gauge by gauge.
    pub tare: [i32; GAUGES],
    /// The relaxation function of the silicone.
    pub relaxation: Relaxation,
    /// What tells the regions of a grasp from noise.
    pub thresholds: Thresholds,
}

/// The same as it travels, and as it stands in the head of a trace: gauge by gauge in lists.
#[derive(Clone, Copy, Serialize, Deserialize, Schema)]
struct Listed {
    interval_ns: u32,
    gain: PerGauge<u8>,
    calibration: PerGauge<Sheet>,
    tare: PerGauge<i32>,
    relaxation: Relaxation,
    thresholds: Thresholds,
}

impl Schema for Settings {
    const SCHEMA: &'static NamedType = Listed::SCHEMA;
}

impl From<Settings> for Listed {
    fn from(settings: Settings) -> Self {
        let Settings { interval_ns, gain, calibration, tare, relaxation, thresholds } = settings;
        let (gain, calibration, tare) = (PerGauge(gain), PerGauge(calibration), PerGauge(tare));
        Self { interval_ns, gain, calibration, tare, relaxation, thresholds }
    }
}

impl From<Listed> for Settings {
    fn from(listed: Listed) -> Self {
        let Listed { interval_ns, gain, calibration, tare, relaxation, thresholds } = listed;
        let (mut gain, mut calibration) = (gain.0, calibration.0);
        // A gauge without a gain is none of the device's.
        for (gain, sheet) in gain.iter_mut().zip(&mut calibration).filter(|(gain, _)| **gain == 0) {
            (*gain, *sheet) = (1, DEFAULT_SHEET);
        }
        Self { interval_ns, gain, calibration, tare: tare.0, relaxation, thresholds }
    }
}

/// That of a quarter bridge of gauge factor 2 at 2.5 V on a converter of ±1.2 V, at a gain of 128 (ε = 4 V / (2.5 V × 2)).
const DEFAULT_SHEET: Sheet = Sheet {
    gain: 4.0 * 1.2 / 128.0 / 8_388_608.0 / (2.5 * 2.0) * 1e6,
    offset: 0,
    temperature_coefficient: 0.0,
    reference_celsius: 25.0,
};

/// Which setting is out of range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SettingsError {
    /// The gain of a gauge is no power of two from 1 to 128.
    Gain {
        /// The gauge, from 0.
        gauge: u8,
        /// Its gain.
        gain: u8,
    },
    /// The calibration of a gauge.
    Calibration {
        /// The gauge, from 0.
        gauge: u8,
        /// What is wrong with it.
        source: CalibrationError,
    },
    /// The relaxation function.
    Relaxation(adaptation::ConfigError),
    /// The thresholds.
    Thresholds(phase::ConfigError),
}

impl fmt::Display for SettingsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = |gauge: u8| gauge.saturating_add(1);
        match self {
            Self::Gain { gauge, gain } => {
                let gauge = number(*gauge);
                write!(f, "gauge {gauge}: a gain of {gain} must be a power of two from 1 to 128")
            }
            Self::Calibration { gauge, source } => write!(f, "gauge {}: {source}", number(*gauge)),
            Self::Relaxation(source) => write!(f, "relaxation function: {source}"),
            Self::Thresholds(source) => write!(f, "thresholds: {source}"),
        }
    }
}

impl core::error::Error for SettingsError {}

impl Settings {
    /// Those of a device that was never set: about 1 kHz, a gain of 128, quarter bridges of gauge factor 2 at 2.5 V on a
    /// converter of ±1.2 V, the relaxation function of eq. 3.6.
    pub const DEFAULT: Self = Self {
        interval_ns: 1_024_000,
        gain: [128; GAUGES],
        calibration: [DEFAULT_SHEET; GAUGES],
        tare: [0; GAUGES],
        relaxation: Relaxation { c1: 0.2472, v1: 3.981, c2: 0.2676, v2: 0.5325 },
        thresholds: Thresholds {
            touch: 20 * 256,
            release: 10 * 256,
            peak_drop: 5 * 256,
            motion_step: 10 * 256,
            latent_dead_band: 5 * 256,
            smoothing_s: 0.02,
            dwell_s: 0.2,
            recovery_limit_s: 20.0,
        },
    };

    /// Time between two samples of the converter, s. A quotient, so that it is the same as of a ratio and a clock, to the last bit.
    #[must_use]
    pub const fn interval_s(&self) -> f64 {
        self.interval_ns as f64 / 1e9
    }

    /// The settings as the pipeline takes them, for samples `interval_s` apart.
    ///
    /// # Errors
    /// [`SettingsError`] names the setting that is out of range.
    pub fn config(&self, interval_s: f64) -> Result<Config, SettingsError> {
        for (gauge, gain) in (0..).zip(self.gain) {
            if !gain.is_power_of_two() {
                return Err(SettingsError::Gain { gauge, gain });
            }
        }
        let [a, b, c, d] = &self.calibration;
        let [p, q, r, s] = self.tare;
        let calibrated = |gauge, sheet: &Sheet, tare| {
            Calibration::new(sheet)
                .map(|calibration| calibration.with_tare(tare))
                .map_err(|source| SettingsError::Calibration { gauge, source })
        };
        Ok(Config {
            calibration: [
                calibrated(0, a, p)?,
                calibrated(1, b, q)?,
                calibrated(2, c, r)?,
                calibrated(3, d, s)?,
            ],
            adaptation: adaptation::Config::new(&self.relaxation, interval_s)
                .map_err(SettingsError::Relaxation)?,
            phase: phase::Config::new(&self.thresholds, interval_s)
                .map_err(SettingsError::Thresholds)?,
        })
    }

    /// The same with other gains: the calibration follows, so that strain stays what it is.
    #[must_use]
    pub fn with_gain(mut self, gain: [u8; GAUGES]) -> Self {
        let gauges = self.calibration.iter_mut().zip(self.gain).zip(gain);
        for ((sheet, before), after) in gauges {
            let ratio = f64::from(after.max(1)) / f64::from(before.max(1));
            sheet.gain /= ratio;
            sheet.offset = crate::fixed::round_to_i32(f64::from(sheet.offset) * ratio)
                .clamp(crate::fixed::STRAIN_MIN, crate::fixed::STRAIN_MAX);
        }
        self.gain = gain;
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::Capabilities;

    #[test]
    fn the_defaults_are_in_range_at_every_rate() {
        for interval_ns in Capabilities::ads131m04(8_000_000).intervals_ns() {
            let settings = Settings { interval_ns, ..Settings::DEFAULT };
            settings.config(settings.interval_s()).unwrap();
        }
    }

    #[test]
    fn the_default_rate_is_about_a_kilohertz() {
        assert_eq!(1.0 / Settings::DEFAULT.interval_s(), 976.562_5);
    }

    #[test]
    fn a_setting_out_of_range_is_named_with_its_gauge() {
        let wrong = Settings { gain: [128, 128, 3, 1], ..Settings::DEFAULT };
        assert_eq!(wrong.config(1e-3), Err(SettingsError::Gain { gauge: 2, gain: 3 }));
        let mut wrong = Settings::DEFAULT;
        wrong.calibration[3].gain = 0.0;
        let said = wrong.config(1e-3).unwrap_err().to_string();
        assert!(said.starts_with("gauge 4: gain of 0"), "{said}");
    }

    #[test]
    fn another_gain_leaves_the_strain_of_the_same_bridge() {
        let before = Settings { gain: [64; GAUGES], ..Settings::DEFAULT };
        let after = before.with_gain([128; GAUGES]);
        let strain = |settings: &Settings, counts| {
            settings.config(1e-3).unwrap().calibration[0].apply(counts, 0).strain
        };
        assert_eq!(strain(&before, 100_000), strain(&after, 200_000));
    }
}
