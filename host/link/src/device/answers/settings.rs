//! `palpate device set`, `palpate device tare`: the settings of a device.

use serde::Serialize;
use shared::adaptation::Relaxation;
use shared::fixed::microstrain;
use shared::pipeline::GAUGES;
use shared::wire::Settings;

use crate::device::change::{Threshold, rate_hz};

/// The settings after a change.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SetAnswer {
    /// Version of this answer.
    pub palpate_settings: u32,
    /// Whether the settings were saved, so that they outlast a loss of power.
    pub saved: bool,
    /// The settings as they are now.
    pub settings: SettingsAnswer,
}

/// The zero after a tare.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct TareAnswer {
    /// Version of this answer.
    pub palpate_tare: u32,
    /// Whether the zero was saved, so that it outlasts a loss of power.
    pub saved: bool,
    /// Strain that each gauge reads as zero now, µε.
    pub tare_ustrain: [f64; GAUGES],
}

/// The settings of a device.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SettingsAnswer {
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Relaxation function that divides strain into FA and SA.
    pub relaxation: RelaxationAnswer,
    /// Thresholds of the regions of a grasp.
    pub thresholds: ThresholdsAnswer,
    /// Gain, calibration and zero of each gauge.
    pub gauges: [GaugeAnswer; GAUGES],
}

/// The relaxation function g(t) = c0 + c1 exp(−v1 t) + c2 exp(−v2 t), eq. 3.4, with c0 = 1 − c1 − c2.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct RelaxationAnswer {
    /// Share of the fast term, 0 to 1.
    pub c1: f64,
    /// Rate of the fast term, 1/s.
    pub v1: f64,
    /// Share of the slow term, 0 to 1.
    pub c2: f64,
    /// Rate of the slow term, 1/s; at most `v1`.
    pub v2: f64,
}

/// Thresholds of the regions of a grasp.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
#[serde(rename_all = "kebab-case")]
pub struct ThresholdsAnswer {
    /// Strain at or above which there is contact, µε.
    pub touch: f64,
    /// Strain at or below which contact is lost, µε.
    pub release: f64,
    /// Fall from the highest strain that counts as having passed the peak, µε.
    pub peak_drop: f64,
    /// Smallest change of the motion that counts as a movement, µε.
    pub motion_step: f64,
    /// Latent part within which the material counts as settled, µε.
    pub dead_band: f64,
    /// Time over which motion and strain are averaged before they are looked at, s.
    pub smoothing: f64,
    /// Time that the motion must stand to have stopped, and the latent part be small to have recovered, s.
    pub dwell: f64,
    /// Time after which recovery ends at the latest, s.
    pub recovery: f64,
}

/// Gain, calibration and zero of one gauge: strain = gain (counts − offset), compensated for temperature, less the tare.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct GaugeAnswer {
    /// Gain of the converter: a power of two, 1 to 128.
    pub gain: u8,
    /// Gain of the calibration, µε per count; negative where pressing lowers the counts.
    pub ustrain_per_count: f64,
    /// Counts without strain, at the reference temperature.
    pub offset_counts: i32,
    /// Apparent strain for each degree above the reference temperature, µε/°C.
    pub temperature_coefficient_ustrain_per_celsius: f64,
    /// Reference temperature, °C.
    pub reference_celsius: f64,
    /// Strain that is read as zero, µε.
    pub tare_ustrain: f64,
}

impl SetAnswer {
    /// Of settings that were changed, and saved or not.
    #[must_use]
    pub fn of(settings: &Settings, saved: bool) -> Self {
        let settings = SettingsAnswer::of(settings);
        Self { palpate_settings: 1, saved, settings }
    }
}

impl TareAnswer {
    /// Of settings with a zero that was saved or not.
    #[must_use]
    pub fn of(settings: &Settings, saved: bool) -> Self {
        Self { palpate_tare: 1, saved, tare_ustrain: settings.tare.map(microstrain) }
    }
}

impl SettingsAnswer {
    /// Of settings.
    #[must_use]
    pub fn of(settings: &Settings) -> Self {
        Self {
            rate_hz: rate_hz(settings),
            relaxation: settings.relaxation.into(),
            thresholds: settings.into(),
            gauges: std::array::from_fn(|gauge| GaugeAnswer::of(settings, gauge)),
        }
    }
}

impl From<Relaxation> for RelaxationAnswer {
    fn from(Relaxation { c1, v1, c2, v2 }: Relaxation) -> Self {
        Self { c1, v1, c2, v2 }
    }
}

impl From<&Settings> for ThresholdsAnswer {
    fn from(settings: &Settings) -> Self {
        let of = |threshold: Threshold| threshold.of(settings);
        Self {
            touch: of(Threshold::Touch),
            release: of(Threshold::Release),
            peak_drop: of(Threshold::PeakDrop),
            motion_step: of(Threshold::MotionStep),
            dead_band: of(Threshold::DeadBand),
            smoothing: of(Threshold::Smoothing),
            dwell: of(Threshold::Dwell),
            recovery: of(Threshold::Recovery),
        }
    }
}

impl GaugeAnswer {
    /// Of a gauge, counted from 0.
    fn of(settings: &Settings, gauge: usize) -> Self {
        let sheet = &settings.calibration[gauge];
        Self {
            gain: settings.gain[gauge],
            ustrain_per_count: sheet.gain,
            offset_counts: sheet.offset,
            temperature_coefficient_ustrain_per_celsius: sheet.temperature_coefficient,
            reference_celsius: sheet.reference_celsius,
            tare_ustrain: microstrain(settings.tare[gauge]),
        }
    }
}
