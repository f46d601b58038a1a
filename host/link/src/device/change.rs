//! Changes of a device's settings, checked before they are sent.

use shared::adaptation::Relaxation;
use shared::fixed::strain_from_microstrain;
use shared::pipeline::GAUGES;
use shared::wire::{Oversampling, PerGauge, SCHEMA, Settings, SettingsError, ToDevice};

use super::heard::Identity;

/// A threshold of the regions, by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Threshold {
    Touch,
    Release,
    PeakDrop,
    MotionStep,
    DeadBand,
    Smoothing,
    Dwell,
    Recovery,
}

impl Threshold {
    /// All, with their names and units.
    pub const ALL: [(Self, &'static str, &'static str); 8] = [
        (Self::Touch, "touch", "µε"),
        (Self::Release, "release", "µε"),
        (Self::PeakDrop, "peak-drop", "µε"),
        (Self::MotionStep, "motion-step", "µε"),
        (Self::DeadBand, "dead-band", "µε"),
        (Self::Smoothing, "smoothing", "s"),
        (Self::Dwell, "dwell", "s"),
        (Self::Recovery, "recovery", "s"),
    ];

    /// Its value in its unit.
    #[must_use]
    pub fn of(self, settings: &Settings) -> f64 {
        let (all, strain) = (&settings.thresholds, shared::fixed::microstrain);
        match self {
            Self::Touch => strain(all.touch),
            Self::Release => strain(all.release),
            Self::PeakDrop => strain(all.peak_drop),
            Self::MotionStep => strain(all.motion_step),
            Self::DeadBand => strain(all.latent_dead_band),
            Self::Smoothing => all.smoothing_s,
            Self::Dwell => all.dwell_s,
            Self::Recovery => all.recovery_limit_s,
        }
    }

    fn set(self, settings: &mut Settings, value: f64) {
        let (all, strain) = (&mut settings.thresholds, strain_from_microstrain(value));
        match self {
            Self::Touch => all.touch = strain,
            Self::Release => all.release = strain,
            Self::PeakDrop => all.peak_drop = strain,
            Self::MotionStep => all.motion_step = strain,
            Self::DeadBand => all.latent_dead_band = strain,
            Self::Smoothing => all.smoothing_s = value,
            Self::Dwell => all.dwell_s = value,
            Self::Recovery => all.recovery_limit_s = value,
        }
    }
}

/// What is to be changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Change {
    /// First of all, take the settings the device was made with.
    pub defaults: bool,
    /// Sample rate, Hz; the nearest of those possible is taken.
    pub rate_hz: Option<f64>,
    /// Gains of the converter.
    pub gain: Option<[u8; GAUGES]>,
    /// The relaxation function.
    pub relaxation: Option<Relaxation>,
    /// Thresholds, in their units.
    pub thresholds: Vec<(Threshold, f64)>,
}

impl Change {
    /// The settings after the change, and the commands that make it.
    ///
    /// # Errors
    /// [`SettingsError`] names the setting that would be out of range; then the device need not be asked.
    pub fn of(
        &self,
        before: &Settings,
        device: &Identity,
    ) -> Result<(Settings, Vec<ToDevice<'static>>), SettingsError> {
        let capabilities = &device.capabilities;
        let mut after = if self.defaults { capabilities.defaults() } else { *before };
        let mut commands = Vec::new();
        if self.defaults {
            commands.push(ToDevice::LoadDefaults);
        }
        if let Some(rate_hz) = self.rate_hz {
            after.interval_ns = capabilities.nearest_ns(rate_hz.recip());
            commands.push(device.set_interval(after.interval_ns));
        }
        if let Some(gain) = self.gain {
            // Checked before the calibration follows it.
            Settings { gain, ..after }.config(after.interval_s())?;
            after = after.with_gain(gain);
            commands.push(device.set_gain(gain));
        }
        if let Some(relaxation) = self.relaxation {
            after.relaxation = relaxation;
            commands.push(ToDevice::SetFilter(relaxation));
        }
        for (threshold, value) in &self.thresholds {
            threshold.set(&mut after, *value);
        }
        if !self.thresholds.is_empty() {
            commands.push(ToDevice::SetThresholds(after.thresholds));
        }
        after.config(after.interval_s())?;
        Ok((after, commands))
    }
}

impl Identity {
    /// The command for other gains, in words that the firmware's release has.
    #[must_use]
    pub const fn set_gain(&self, gain: [u8; GAUGES]) -> ToDevice<'static> {
        if self.schema == SCHEMA {
            ToDevice::SetGain(PerGauge(gain))
        } else {
            ToDevice::SetGainOfFour(gain)
        }
    }

    /// The command for another interval, in words that the firmware's release has.
    fn set_interval(&self, ns: u32) -> ToDevice<'static> {
        if self.schema == SCHEMA {
            ToDevice::SetInterval { ns }
        } else {
            ToDevice::SetRatio(Oversampling::nearest(ns, self.converter_clock_hz))
        }
    }
}

/// Sample rate, Hz.
#[must_use]
pub fn rate_hz(settings: &Settings) -> f64 {
    settings.interval_s().recip()
}

/// What to say where the rate that was taken is not the one that was wanted.
#[must_use]
pub fn rate_note(wanted_hz: f64, now: &Settings) -> Option<String> {
    let rate = rate_hz(now);
    let is_off = (rate / wanted_hz - 1.0).abs() > 1e-3;
    is_off.then(|| format!("the rate nearest to {wanted_hz} Hz is {rate} Hz"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use shared::wire::{Capabilities, EARLIER};

    fn device() -> Identity {
        let schema = SCHEMA;
        Identity { schema, capabilities: Capabilities::ads131m04(8_000_000), ..Identity::unknown() }
    }

    #[test]
    fn a_change_out_of_range_is_refused_before_anything_is_sent() {
        let change = Change { gain: Some([3, 1, 1, 1]), ..Change::default() };
        let refused = change.of(&Settings::DEFAULT, &device()).unwrap_err().to_string();
        assert!(refused.contains("gauge 1: a gain of 3"), "{refused}");
        let change = Change { thresholds: vec![(Threshold::Touch, 5.0)], ..Change::default() };
        let refused = change.of(&Settings::DEFAULT, &device()).unwrap_err().to_string();
        assert!(refused.starts_with("thresholds:"), "{refused}");
    }

    #[test]
    fn one_command_is_sent_for_each_kind_of_change() {
        let change = Change {
            defaults: true,
            rate_hz: Some(500.0),
            thresholds: vec![(Threshold::Touch, 40.0), (Threshold::Release, 30.0)],
            ..Change::default()
        };
        let (after, commands) = change.of(&Settings::DEFAULT, &device()).unwrap();
        let kinds: Vec<_> = commands.iter().map(std::mem::discriminant).collect();
        let expected = [
            ToDevice::LoadDefaults,
            ToDevice::SetInterval { ns: 2_048_000 },
            ToDevice::SetThresholds(after.thresholds),
        ];
        assert_eq!(kinds, expected.each_ref().map(std::mem::discriminant));
        assert_eq!(Threshold::Touch.of(&after), 40.0);
    }

    #[test]
    fn firmware_of_release_0_1_is_told_a_ratio() {
        let change = Change { rate_hz: Some(500.0), ..Change::default() };
        let old = Identity { schema: EARLIER[0], converter_clock_hz: 8_000_000, ..device() };
        let (after, commands) = change.of(&Settings::DEFAULT, &old).unwrap();
        assert_eq!(commands, [ToDevice::SetRatio(Oversampling::X8192)]);
        assert_eq!(after.interval_ns, 2_048_000);
    }
}
