//! What the Device room and the margin show beside the health of a session.

use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::foretold::Foretold;
use super::grasp::Readings;
use palpate_link::device::answers::ReleaseAnswer;
use palpate_link::device::release::Verdict;

/// Counts that are older than this are of a stream that stands.
const FRESH: Duration = Duration::from_secs(1);

/// The latest of each.
#[derive(Default)]
pub struct Bench {
    /// Whether firmware and program go together; none before a device answered.
    pub release: Option<Verdict>,
    /// Settings have changed so often.
    pub generation: u32,
    /// The raw counts now, and when that was.
    pub counts: Option<(Instant, Value)>,
    /// How a grasp is watched, as the page reads it.
    pub holding: Value,
    /// The margin of the grasp.
    pub readings: Readings,
    /// What a model foretells.
    pub foretold: Foretold,
}

impl Bench {
    /// As the page reads it, with the readings from a number on.
    #[must_use]
    pub fn json(&self, from: u64) -> Value {
        let fresh = self.counts.as_ref().filter(|(at, _)| at.elapsed() < FRESH);
        json!({
            "release": self.release.as_ref().map(ReleaseAnswer::from),
            "generation": self.generation,
            "counts": fresh.map(|(_, counts)| counts),
            "holding": self.holding,
            "resting": self.readings.is_resting(),
            "readings": self.readings.after(from),
            "foretold": self.foretold.json(),
        })
    }
}
