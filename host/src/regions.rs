//! The six regions of a grasp (3.4.1) in a recording, by the code that finds them on the device.
//!
//! The device knows a boundary only some time after it was passed; with the whole recording at hand,
//! each boundary is put back to where it belongs.

use std::ops::Range;

use shared::phase::{Config, ConfigError, Region, RelaxationType, State, Thresholds};

use crate::decomposition::Channel;
use crate::trace::{DISPLACEMENT, FORCE, Trace, noise, runs, sampling};

/// What happens at each sample of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Regions {
    /// The region of the grasp.
    pub region: Vec<Region>,
    /// Which way the channel relaxes.
    pub relaxation: Vec<RelaxationType>,
}

/// A stretch of one region.
#[derive(Clone, Debug, PartialEq)]
pub struct Stretch {
    /// The region.
    pub region: Region,
    /// Its samples.
    pub range: Range<usize>,
    /// Type of relaxation that most of its samples show.
    pub relaxation: RelaxationType,
}

/// Why regions cannot be found.
#[derive(Debug, thiserror::Error)]
#[error("{trace}: the regions of the grasp cannot be found: {source}")]
pub struct RegionsError {
    /// Name of the trace.
    trace: String,
    /// What is wrong with the thresholds.
    source: ConfigError,
}

/// Averaging of motion and signal, s.
const SMOOTHING: f64 = 0.02;
/// Rest that counts as a hold, s.
const DWELL: f64 = 0.1;
/// Deviations of its noise above which a signal means touch.
const TOUCH: f64 = 5.0;
/// Share of the largest signal below which nothing is told from zero.
const SMALLEST: f64 = 0.01;
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

/// Finds the regions of a grasp for one decomposed channel of a recording.
///
/// Contact is told from the force where it was recorded, else from the channel; motion from the
/// displacement, else from the channel's elastic input. The type of relaxation is the channel's own.
///
/// # Errors
/// When the sampling is too coarse for any threshold in time.
pub fn regions(trace: &Trace, channel: &Channel) -> Result<Regions, RegionsError> {
    let contact = trace.force().unwrap_or(&channel.input);
    let motion = trace.displacement().unwrap_or(&channel.elastic);
    let scales = Scales {
        contact: Scaled::of(contact),
        motion: Scaled::of(motion),
        latent: Scaled::of(&channel.input),
    };
    let thresholds = thresholds(trace, channel, &scales);
    let interval = sampling(&trace.time).map_or(1.0, |sampling| sampling.median_s);
    let config = Config::new(&thresholds, interval)
        .map_err(|source| RegionsError { trace: trace.label(), source })?;
    let mut found = Regions {
        region: vec![Region::Rest; trace.len()],
        relaxation: vec![RelaxationType::None; trace.len()],
    };
    for run in runs(&trace.time) {
        let at = |values: &[f64], scale: &Scaled, index: usize| scale.count(values[index]);
        let first = run.start;
        let mut state =
            State::at_rest(at(motion, &scales.motion, first), at(contact, &scales.contact, first));
        for index in run.clone() {
            let phase = state.step(
                &config,
                at(motion, &scales.motion, index),
                at(contact, &scales.contact, index),
                at(&channel.latent, &scales.latent, index),
            );
            let ago = phase.entered_samples_ago.unwrap_or(0) as usize;
            let since = index.saturating_sub(ago).max(run.start);
            found.region[since..=index].fill(phase.region);
            found.relaxation[index] = phase.relaxation;
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
    let deviation =
        |column: &str| noise(trace, column).map_or(0.0, |noise| noise.standard_deviation);
    let has_force = trace.force().is_some();
    let contact_noise = deviation(if has_force { FORCE } else { &channel.signal });
    let touch = scales.contact.level(TOUCH * contact_noise, SMALLEST);
    let motion_step = if trace.displacement().is_some() {
        scales.motion.level(TOUCH * deviation(DISPLACEMENT), SMALLEST / 2.0)
    } else {
        // The elastic input is noisier than the signal, by 1/c0 at most and in practice by two.
        scales.motion.level(2.0 * TOUCH * deviation(&channel.signal), 2.0 * SMALLEST)
    };
    Thresholds {
        touch,
        release: touch / 2,
        peak_drop: scales.contact.level(3.0 * contact_noise, SMALLEST / 2.0),
        motion_step,
        latent_dead_band: scales.latent.level(3.0 * deviation(&channel.signal), SMALLEST / 2.0),
        smoothing_s: SMOOTHING,
        dwell_s: DWELL,
        recovery_limit_s: trace.duration(),
    }
}

impl Regions {
    /// The stretches of one region each, in order.
    #[must_use]
    pub fn stretches(&self) -> Vec<Stretch> {
        let mut found: Vec<Stretch> = Vec::new();
        for (index, &region) in self.region.iter().enumerate() {
            match found.last_mut() {
                Some(last) if last.region == region => last.range.end = index + 1,
                _ => found.push(Stretch {
                    region,
                    range: index..index + 1,
                    relaxation: RelaxationType::None,
                }),
            }
        }
        for stretch in &mut found {
            stretch.relaxation = self.usual(&stretch.range);
        }
        found
    }

    /// The type that most samples of a stretch show, those near equilibrium not counted.
    fn usual(&self, range: &Range<usize>) -> RelaxationType {
        let count =
            |wanted| self.relaxation[range.clone()].iter().filter(|r| **r == wanted).count();
        let (one, two) = (count(RelaxationType::TypeI), count(RelaxationType::TypeII));
        match one.cmp(&two) {
            std::cmp::Ordering::Greater => RelaxationType::TypeI,
            std::cmp::Ordering::Less => RelaxationType::TypeII,
            std::cmp::Ordering::Equal => RelaxationType::None,
        }
    }
}

/// The points of Figure 3.10 between which a region lies, and its name.
#[must_use]
pub fn name(region: Region) -> (&'static str, &'static str) {
    match region {
        Region::Rest => ("", "rest"),
        Region::Preloading => ("OA", "preloading"),
        Region::Loading => ("AB", "loading"),
        Region::Transition => ("BC", "transition"),
        Region::Relaxation => ("CD", "relaxation"),
        Region::Unloading => ("DE", "unloading"),
        Region::Recovery => ("EF", "recovery"),
    }
}

/// The number of a region in a trace's column: 0 for rest, 1 to 6 for OA to EF.
#[must_use]
pub fn code(region: Region) -> f64 {
    match region {
        Region::Rest => 0.0,
        Region::Preloading => 1.0,
        Region::Loading => 2.0,
        Region::Transition => 3.0,
        Region::Relaxation => 4.0,
        Region::Unloading => 5.0,
        Region::Recovery => 6.0,
    }
}

/// The number of a relaxation type in a trace's column: 0 near equilibrium, 1 and 2.
#[must_use]
pub fn type_code(relaxation: RelaxationType) -> f64 {
    match relaxation {
        RelaxationType::None => 0.0,
        RelaxationType::TypeI => 1.0,
        RelaxationType::TypeII => 2.0,
    }
}
