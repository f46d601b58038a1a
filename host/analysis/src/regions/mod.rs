//! The six regions of a grasp (3.4.1) in a recording.
//!
//! Where the displacement was recorded the regions follow from it, or from the force where that was
//! controlled, whatever the sampling (`motion`). Where only the signal is known they are found by the very code that finds them on
//! the device (`signal`).

mod motion;
mod signal;

use std::ops::Range;

use shared::phase::{ConfigError, Region, RelaxationType};

use crate::decomposition::Channel;
use palpate_trace::{Control, FORCE, Trace, control, noise};

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

/// Deviations of its noise above which a signal means touch.
const TOUCH: f64 = 5.0;
/// Deviations of its noise within which a latent part is settled.
const SETTLED: f64 = 3.0;
/// Share of the largest signal below which nothing is told from zero.
const SMALLEST: f64 = 0.01;

/// Finds the regions of a grasp for one decomposed channel of a recording.
///
/// Contact is told from the force where it was recorded, else from the channel. The type of relaxation
/// is the channel's own; under force control it is that of the creep (6.4.2): Type I where the
/// displacement grows.
///
/// # Errors
/// When only the signal is known and its sampling is too coarse for any threshold in time.
pub fn regions(trace: &Trace, channel: &Channel) -> Result<Regions, RegionsError> {
    match (trace.displacement(), trace.force()) {
        (Some(displacement), Some(force)) if control(trace) == Control::Force => {
            Ok(motion::force_controlled(trace, displacement, force, channel))
        }
        (Some(displacement), _) => Ok(motion::regions(trace, displacement, channel)),
        (None, _) => signal::regions(trace, channel)
            .map_err(|source| RegionsError { trace: trace.label(), source }),
    }
}

/// The signal that tells contact: its name and its values.
fn contact<'a>(trace: &'a Trace, channel: &'a Channel) -> (&'a str, &'a [f64]) {
    match trace.force() {
        Some(force) => (FORCE, force),
        None => (&channel.signal, &channel.input),
    }
}

/// The force, N, by size, above which there is contact or a pull: `noise` is the deviation of one sample,
/// `largest` the largest force.
#[must_use]
pub fn touch_level(noise: f64, largest: f64) -> f64 {
    motion::touch_level(noise, largest)
}

/// Noise of a column, 0 where it cannot be told.
fn deviation(trace: &Trace, column: &str) -> f64 {
    noise(trace, column).map_or(0.0, |noise| noise.standard_deviation)
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

/// The numeral of a relaxation type: I after loading, II after partial unloading.
#[must_use]
pub fn numeral(relaxation: RelaxationType) -> &'static str {
    match relaxation {
        RelaxationType::None => "–",
        RelaxationType::TypeI => "I",
        RelaxationType::TypeII => "II",
    }
}

/// A relaxation type in words: `Type I`.
#[must_use]
pub fn type_name(relaxation: RelaxationType) -> String {
    format!("Type {}", numeral(relaxation))
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
