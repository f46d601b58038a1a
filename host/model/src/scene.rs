//! Everything that is known at every sample of a stretch without a model.

use std::borrow::Cow;

use super::Motion;
use palpate_trace::{Kind, segments};

/// One stretch of recording without a gap, as laws see it. All columns have one value for each sample.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    /// Which trace of the set it is from.
    pub trace: usize,
    /// Commanded motion: time, s, and displacement x, mm.
    pub motion: &'a Motion<'a>,
    /// Time t since the trace began, s.
    pub since: Cow<'a, [f64]>,
    /// Time t_set of the trace's first sample since the data set began, s.
    pub begin: f64,
    /// Velocity v, mm/s.
    pub velocity: Cow<'a, [f64]>,
    /// Acceleration a, mm/s².
    pub acceleration: Cow<'a, [f64]>,
    /// Number n of loadings completed before this one, over the whole set.
    pub loadings: Cow<'a, [f64]>,
    /// Largest compression x_max so far, over the whole set, mm.
    pub largest: Cow<'a, [f64]>,
    /// Temperature above the reference, T − T0, K; absent where it was not recorded.
    pub warmth: Option<Cow<'a, [f64]>>,
    /// The other channels that were recorded, in the order of their columns.
    pub channels: &'a [Channel<'a>],
    /// The signal that was measured; empty where a motion alone is known, or means of the signal.
    pub measured: &'a [f64],
}

/// Another channel than the signal, at each sample.
#[derive(Clone, Debug)]
pub struct Channel<'a> {
    /// What was recorded.
    pub values: &'a [f64],
    /// Its slope over time, in its unit per second, smoothed as much as its scatter asks for.
    pub slope: Vec<f64>,
}

/// What a specimen has been through before a stretch begins.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Past {
    /// Loadings completed.
    pub loadings: u32,
    /// Largest compression, mm.
    pub largest: f64,
}

impl Scene<'_> {
    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.since.len()
    }

    /// Whether there is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.since.is_empty()
    }

    /// Time t_set since the data set began of sample `k`, s.
    #[must_use]
    pub fn set_time(&self, k: usize) -> f64 {
        self.begin + self.since[k]
    }

    /// Temperature above the reference at sample `k`, K; 0 where it was not recorded.
    #[must_use]
    pub fn warmth(&self, k: usize) -> f64 {
        self.warmth.as_ref().map_or(0.0, |warmth| warmth[k])
    }
}

impl Past {
    /// Loadings completed before the one at hand and largest compression so far, at every sample of
    /// a motion; what the specimen has been through grows by it.
    #[must_use]
    pub fn follow(&mut self, motion: &Motion) -> (Vec<f64>, Vec<f64>) {
        let count = motion.time.len();
        let (mut loadings, mut largest) = (Vec::with_capacity(count), Vec::with_capacity(count));
        // A loading that is complete counts from the next loading on.
        let mut complete = false;
        let mut current = self.loadings;
        for segment in segments(&motion.time, &motion.displacement) {
            match segment.kind {
                Kind::Load => {
                    current = self.loadings;
                    complete = true;
                }
                Kind::Unload if complete => {
                    complete = false;
                    self.loadings += 1;
                }
                _ => {}
            }
            for &x in &motion.displacement[segment.range] {
                self.largest = self.largest.max(x);
                loadings.push(f64::from(current));
                largest.push(self.largest);
            }
        }
        loadings.resize(count, f64::from(current));
        largest.resize(count, self.largest);
        (loadings, largest)
    }
}
