//! How release 0.1 says rates: as oversampling ratios of an ADS131M04, which mean something only with its clock. Hosts and devices
//! of that release, its recordings and the settings it saved are spoken to and read in these words.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use super::per_gauge::{FOUR, PerGauge};
use super::settings::Settings;
use crate::adaptation::Relaxation;
use crate::calibration::Sheet;
use crate::phase::Thresholds;

/// Oversampling ratio of the converter: it gives one sample for so many of its modulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[allow(missing_docs)]
pub enum Oversampling {
    X1024,
    X2048,
    X4096,
    X8192,
    X16384,
}

impl Oversampling {
    /// All, the fastest first.
    pub const ALL: [Self; 5] = [Self::X1024, Self::X2048, Self::X4096, Self::X8192, Self::X16384];

    /// Modulator samples in one sample.
    #[must_use]
    pub const fn ratio(self) -> u32 {
        match self {
            Self::X1024 => 1_024,
            Self::X2048 => 2_048,
            Self::X4096 => 4_096,
            Self::X8192 => 8_192,
            Self::X16384 => 16_384,
        }
    }

    /// Time between two samples, ns to the nearest, with a converter clock (Hz); the modulator runs at half of it. Exact at 8 MHz.
    #[must_use]
    pub const fn interval_ns(self, converter_clock_hz: u32) -> u32 {
        // Of CLKIN, two in one of the modulator; no ratio is so large that they overflow.
        interval_of_periods_ns(self.ratio().wrapping_mul(2), converter_clock_hz)
    }

    /// The one whose interval is nearest.
    #[must_use]
    pub fn nearest(interval_ns: u32, converter_clock_hz: u32) -> Self {
        let off = |of: &Self| of.interval_ns(converter_clock_hz).abs_diff(interval_ns);
        Self::ALL.into_iter().min_by_key(off).unwrap_or(Self::X4096)
    }
}

/// Time of so many periods of the converter's clock, ns to the nearest.
pub(super) const fn interval_of_periods_ns(periods: u32, converter_clock_hz: u32) -> u32 {
    let twice = (periods as u64).saturating_mul(2_000_000_000);
    match twice.checked_div(converter_clock_hz as u64) {
        Some(twice) if twice >> 32 == 0 => (twice.wrapping_add(1) >> 1) as u32,
        _ => u32::MAX,
    }
}

/// Everything that can be set on a device, with its rate as a ratio.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct SettingsByRatio {
    /// Sets the sample rate.
    pub oversampling: Oversampling,
    /// [`Settings::gain`].
    pub gain: [u8; FOUR],
    /// [`Settings::calibration`].
    pub calibration: [Sheet; FOUR],
    /// [`Settings::tare`].
    pub tare: [i32; FOUR],
    /// [`Settings::relaxation`].
    pub relaxation: Relaxation,
    /// [`Settings::thresholds`].
    pub thresholds: Thresholds,
}

impl SettingsByRatio {
    /// Clock of the converter of every device of release 0.1, Hz.
    pub const CLOCK_HZ: u32 = 8_000_000;

    /// Settings in these words, with the ratio that is nearest to their rate.
    #[must_use]
    pub fn of(settings: &Settings, converter_clock_hz: u32) -> Self {
        let Settings { interval_ns, gain, calibration, tare, relaxation, thresholds } = *settings;
        let oversampling = Oversampling::nearest(interval_ns, converter_clock_hz);
        let gain = PerGauge(gain).four();
        let (calibration, tare) = (PerGauge(calibration).four(), PerGauge(tare).four());
        Self { oversampling, gain, calibration, tare, relaxation, thresholds }
    }

    /// What they mean with a converter clock, Hz.
    #[must_use]
    pub fn settings(&self, converter_clock_hz: u32) -> Settings {
        let Self { oversampling, relaxation, thresholds, .. } = *self;
        let interval_ns = oversampling.interval_ns(converter_clock_hz);
        let PerGauge(gain) = PerGauge::of(&self.gain);
        let PerGauge(calibration) = PerGauge::of(&self.calibration);
        let PerGauge(tare) = PerGauge::of(&self.tare);
        Settings { interval_ns, gain, calibration, tare, relaxation, thresholds }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ratio_and_its_interval_mean_the_same_to_the_last_bit() {
        for oversampling in Oversampling::ALL {
            let by_clock = 2.0 * f64::from(oversampling.ratio()) / 8e6;
            let interval_ns = oversampling.interval_ns(8_000_000);
            let settings = Settings { interval_ns, ..Settings::DEFAULT };
            assert_eq!(settings.interval_s(), by_clock);
            assert_eq!(SettingsByRatio::of(&settings, 8_000_000).settings(8_000_000), settings);
        }
        assert_eq!(Oversampling::X1024.interval_ns(0), u32::MAX);
        assert_eq!(Oversampling::X1024.interval_ns(8_192_000), 250_000);
    }
}
