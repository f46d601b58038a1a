//! What a relaxation law foretells of a held press, sample by sample, from the signal's own history.
//!
//! A fingertip tells what its gauges feel, not how the finger moves, so while the motion goes on nothing can be foretold. When it
//! stands (region CD) the law alone says how the signal must go on: F = c0 N + Σ ci xi with N constant and every xi decaying at
//! its rate (eq. 3.3). What has to be known for it, N and all xi, is what the same law makes of all that was felt before.
//!
//! ```text
//!  rest         loading    held: CD
//!  ────────────/‾‾‾‾‾‾‾‾‾‾|‾‾‾‾|‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾
//!  noise, zero   N and xi  mean  foretold, residual tested
//!                          of N  against the noise
//! ```
//!
//! A gauge is taken to follow in proportion what the memory of the law gives, a force or the strain of a latency model: neither
//! the stiffness nor the place of the gauge enters. A residual beyond the noise says that the law does not hold, or that the finger did not stand; from
//! the signal alone these two are not told apart.

mod hold;
mod law;
mod noise;

pub use hold::{Failure, Hold};
pub use law::{Law, LawError};

use shared::phase::Region;

use self::noise::{BLOCK_S, Blocks, Noise};
use palpate_model::Memory;

/// The elastic response N is the mean over so long, s, from when it is known that the motion stands.
const MEAN_S: f64 = 2.0 * BLOCK_S;
/// That the motion no longer stands is known late; until so long after it, s, a residual is not judged.
const SURE_S: f64 = 0.5;
/// After so many of the longest time constants it does not matter what was before.
const FORGOTTEN: f64 = 8.0;
/// Samples that are farther apart, s, have not been felt without a gap.
const GAP_S: f64 = 0.1;

/// What a gauge felt at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time, s.
    pub time: f64,
    /// The signal, µε.
    pub signal: f64,
    /// The region of the grasp that the gauge is in.
    pub region: Region,
    /// Where a region was just found: how long ago it was entered, s.
    pub entered_ago: Option<f64>,
}

/// What can be said at present.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// No rest was seen, nor was it followed for long enough, so what was felt before is not known.
    NoHistory,
    /// At rest.
    Rests,
    /// The finger moves, or the contact is lost.
    Moves,
    /// The motion stands; what the law needs is being taken, or there is too little to know the noise.
    Begins,
    /// The residual is within the noise.
    Agrees,
    /// The residual is beyond the noise.
    Fails,
}

/// Follows one gauge.
#[derive(Clone, Debug)]
pub struct Follower {
    law: Law,
    memory: Memory,
    /// The first signal, µε.
    zero: f64,
    noise: Noise,
    blocks: Blocks,
    last: Option<Sample>,
    /// When following began, s.
    began: f64,
    is_known: bool,
    /// When the region was entered that the gauge is in, s.
    entered: f64,
    doing: Doing,
}

#[derive(Clone, Debug)]
enum Doing {
    Follows,
    /// Sum of the elastic responses, how many, since when (s).
    Means(f64, u32, f64),
    Foretells(Hold),
}

impl Follower {
    /// Nothing was felt yet.
    #[must_use]
    pub fn new(law: Law) -> Self {
        let memory = Memory::rested(law.relaxation.branches.len());
        Self {
            law,
            memory,
            zero: 0.0,
            noise: Noise::default(),
            blocks: Blocks::default(),
            last: None,
            began: 0.0,
            is_known: false,
            entered: 0.0,
            doing: Doing::Follows,
        }
    }

    /// What comes next does not go on from what was felt; the noise stays known. The hold that this ends.
    pub fn begin(&mut self) -> Option<Hold> {
        let ended = self.end();
        (self.last, self.is_known) = (None, false);
        ended
    }

    /// Takes a sample; the hold that it ends.
    pub fn take(&mut self, sample: Sample) -> Option<Hold> {
        let interval = self.last.map(|last| sample.time - last.time);
        let mut ended = None;
        match interval {
            Some(interval) if interval > 0.0 && interval < GAP_S => {
                let _ =
                    self.memory.reach(&self.law.relaxation, sample.signal - self.zero, interval);
            }
            // The same time again is no sample.
            Some(0.0) => return None,
            _ => {
                ended = self.begin();
                // A signal that was always the same, as of a bridge that is not tared, has nothing to relax.
                self.memory = Memory::rested(self.law.relaxation.branches.len());
                (self.zero, self.began) = (sample.signal, sample.time);
            }
        }
        if self.last.is_none_or(|last| last.region != sample.region) {
            self.entered = sample.time - sample.entered_ago.unwrap_or(0.0);
        }
        self.last = Some(sample);
        let slowest =
            self.law.relaxation.branches.iter().map(|of| of.rate).fold(f64::MAX, f64::min);
        let is_old = (sample.time - self.began) * slowest >= FORGOTTEN;
        self.is_known |= is_old || sample.region == Region::Rest;
        if sample.region == Region::Relaxation && self.is_known {
            self.hold(&sample);
            return ended;
        }
        let ended = ended.or_else(|| {
            let mut hold = self.end()?;
            hold.end(self.entered);
            Some(hold)
        });
        if sample.region == Region::Rest {
            if let Some(mean) = self.blocks.add(sample.time, sample.signal) {
                self.noise.add(mean);
            }
        } else {
            self.interrupt();
        }
        ended
    }

    fn hold(&mut self, sample: &Sample) {
        match &mut self.doing {
            Doing::Follows => {
                self.interrupt();
                self.doing = Doing::Means(self.memory.elastic(), 1, sample.time);
            }
            Doing::Means(sum, count, since) => {
                *sum += self.memory.elastic();
                *count += 1;
                if sample.time - *since >= MEAN_S {
                    let mean = *sum / f64::from(*count);
                    let mut memory = self.memory.clone();
                    // The noise of the last sample is in every part, and a jump takes it out of all.
                    let _ = memory.jump(&self.law.relaxation, mean);
                    let (stays, parts) = memory.parts(&self.law.relaxation);
                    let level = self.zero + stays;
                    self.doing =
                        Doing::Foretells(Hold::new(self.entered, sample.time, (level, parts)));
                }
            }
            Doing::Foretells(hold) => {
                let residual = hold.go_on(sample.time, sample.signal);
                if let Some(mean) = self.blocks.add(sample.time, residual) {
                    hold.keep(mean);
                }
                while let Some(mean) = hold.sure(sample.time - SURE_S) {
                    hold.judge(mean, self.noise.of_a_block());
                    self.noise.add(mean.1);
                }
            }
        }
    }

    /// Means of blocks do not go on from here.
    fn interrupt(&mut self) {
        self.blocks = Blocks::default();
        self.noise.interrupt();
    }

    fn end(&mut self) -> Option<Hold> {
        match std::mem::replace(&mut self.doing, Doing::Follows) {
            Doing::Foretells(hold) => {
                self.interrupt();
                Some(hold)
            }
            Doing::Follows | Doing::Means(..) => None,
        }
    }

    /// The hold that goes on.
    #[must_use]
    pub const fn hold_now(&self) -> Option<&Hold> {
        match &self.doing {
            Doing::Foretells(hold) => Some(hold),
            Doing::Follows | Doing::Means(..) => None,
        }
    }

    /// What can be said at present.
    #[must_use]
    pub fn standing(&self) -> Standing {
        match (&self.doing, self.last.map(|last| last.region)) {
            (_, None) => Standing::NoHistory,
            _ if !self.is_known => Standing::NoHistory,
            (Doing::Foretells(hold), _) if hold.failure.is_some() => Standing::Fails,
            (Doing::Foretells(hold), _) if hold.is_judged() => Standing::Agrees,
            (Doing::Foretells(_) | Doing::Means(..), _) => Standing::Begins,
            (Doing::Follows, Some(Region::Rest)) => Standing::Rests,
            (Doing::Follows, _) => Standing::Moves,
        }
    }
}

#[cfg(test)]
mod tests;
