//! Regions from the signal alone, by the code of the device.

use shared::phase::{Config, ConfigError, Region, RelaxationType, State, Thresholds};

use super::{Regions, SETTLED, SMALLEST, TOUCH, contact, deviation};
use crate::decomposition::Channel;
use palpate_trace::{Trace, runs, sampling};

/// Averaging of motion and signal, s.
const SMOOTHING: f64 = 0.02;
/// Rest that counts as a hold, s.
const DWELL: f64 = 0.1;
/// Steps into which a motion or a signal is divided up to its largest value.
const STEPS: f64 = 1e6;

/// A quantity as integers for the device's code: its largest value is a million.
struct Scaled {
    lsb: f64,
    sense: f64,
}

impl Scaled {
    /// Positive where the largest value by size is.
    fn of(values: &[f64]) -> Self {
        let largest = values
            .iter()
            .copied()
            .fold(0.0, |most: f64, value| if value.abs() > most.abs() { value } else { most });
        let lsb = if largest == 0.0 { 1.0 } else { largest.abs() / STEPS };
        Self { lsb, sense: if largest < 0.0 { -1.0 } else { 1.0 } }
    }

    fn count(&self, value: f64) -> i32 {
        (self.sense * value / self.lsb).round() as i32
    }

    /// A size, at least `share` of the largest value.
    fn level(&self, size: f64, share: f64) -> i32 {
        (size / self.lsb).max(share * STEPS).round() as i32
    }
}

/// Finds the regions from the channel alone: contact from the force where it was recorded, else from
/// the channel, motion from the channel's elastic input. The device knows a boundary only some time
/// after it was passed; with the whole recording at hand it is put back to where it belongs.
pub(super) fn regions(trace: &Trace, channel: &Channel) -> Result<Regions, ConfigError> {
    let (_, contact) = contact(trace, channel);
    let motion = &channel.elastic;
    let scales = Scales {
        contact: Scaled::of(contact),
        motion: Scaled::of(motion),
        latent: Scaled::of(&channel.input),
    };
    let thresholds = thresholds(trace, channel, &scales);
    let interval = sampling(&trace.time).map_or(1.0, |sampling| sampling.median_s);
    let config = Config::new(&thresholds, interval)?;
    let mut found = Regions {
        region: vec![Region::Rest; trace.len()],
        relaxation: vec![RelaxationType::None; trace.len()],
    };
    for run in runs(&trace.time) {
        let counts = |index: usize| {
            (scales.motion.count(motion[index]), scales.contact.count(contact[index]))
        };
        let (first_motion, first_contact) = counts(run.start);
        let mut state = State::at_rest(first_motion, first_contact);
        for index in run.clone() {
            let (motion, contact) = counts(index);
            let latent = scales.latent.count(channel.latent[index]);
            let phase = state.step(&config, motion, contact, latent);
            let ago = phase.entered_samples_ago.unwrap_or(0) as usize;
            let since = index.saturating_sub(ago).max(run.start);
            found.region[since..=index].fill(phase.region);
            found.relaxation[index] = RelaxationType::of(latent, thresholds.latent_dead_band);
        }
    }
    Ok(found)
}

struct Scales {
    contact: Scaled,
    motion: Scaled,
    latent: Scaled,
}

/// Thresholds from the noise of the recording itself.
fn thresholds(trace: &Trace, channel: &Channel, scales: &Scales) -> Thresholds {
    let (name, _) = contact(trace, channel);
    let contact_noise = deviation(trace, name);
    let noise = deviation(trace, &channel.signal);
    let touch = scales.contact.level(TOUCH * contact_noise, SMALLEST);
    Thresholds {
        touch,
        release: touch / 2,
        peak_drop: scales.contact.level(SETTLED * contact_noise, SMALLEST / 2.0),
        // The elastic input is noisier than the signal, by 1/c0 at most and in practice by two.
        motion_step: scales.motion.level(2.0 * TOUCH * noise, 2.0 * SMALLEST),
        latent_dead_band: scales.latent.level(SETTLED * noise, SMALLEST / 2.0),
        smoothing_s: SMOOTHING,
        dwell_s: DWELL,
        recovery_limit_s: trace.duration(),
    }
}
