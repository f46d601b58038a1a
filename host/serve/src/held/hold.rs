//! One held press: how its signal must go on, and whether it does.

use std::collections::VecDeque;

/// Blocks whose mean is tested.
const TESTED: usize = 4;
/// The elastic response was the mean over so many.
const OF_THE_MEAN: f64 = 2.0;
/// A residual of so many standard errors, twice in a row on one side, is beyond the noise. A look every 50 ms at four gauges for a
/// day finds one of normal noise less than once in a hundred days.
const BEYOND: f64 = 6.0;

/// A hold that a law foretells: `level` + Σ part e^(−rate (t − `from`)).
#[derive(Clone, Debug, PartialEq)]
pub struct Hold {
    /// When the motion came to stand, s.
    pub entered: f64,
    /// From when on it is foretold, s.
    pub from: f64,
    /// Until when it was felt, s.
    pub to: f64,
    /// Where it will settle, µε.
    pub level: f64,
    /// What is still to decay at `from`, µε, and its rate, 1/s.
    pub parts: Vec<(f64, f64)>,
    /// The mean residual of the last blocks and its standard error, µε.
    pub residual: Option<(f64, f64)>,
    /// Where the law failed first.
    pub failure: Option<Failure>,
    /// Means of blocks that are not judged yet, and when each was over, s.
    waiting: VecDeque<(f64, f64)>,
    means: VecDeque<f64>,
    /// Whether the last test was beyond the noise, and on which side.
    was_beyond: Option<bool>,
}

/// A residual beyond the noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Failure {
    /// So long after the motion came to stand, s.
    pub after: f64,
    /// The residual there, µε.
    pub residual: f64,
    /// It lies on the side that it comes from: it relaxes less than the law says, or recovers less.
    pub changes_less: bool,
    /// Time constant of the part that changed fastest there by the law, s.
    pub acting: Option<f64>,
}

impl Hold {
    pub(super) fn new(entered: f64, from: f64, (level, parts): (f64, Vec<(f64, f64)>)) -> Self {
        Self {
            entered,
            from,
            to: from,
            level,
            parts,
            residual: None,
            failure: None,
            waiting: VecDeque::new(),
            means: VecDeque::new(),
            was_beyond: None,
        }
    }

    /// The signal at a time, µε.
    #[must_use]
    pub fn foretold(&self, time: f64) -> f64 {
        let left = |&(part, rate): &(f64, f64)| part * (-rate * (time - self.from)).exp();
        self.level + self.parts.iter().map(left).sum::<f64>()
    }

    /// Whether a residual was held against the noise.
    #[must_use]
    pub const fn is_judged(&self) -> bool {
        self.residual.is_some()
    }

    /// Goes on to a sample; its residual, µε.
    pub(super) fn go_on(&mut self, time: f64, signal: f64) -> f64 {
        self.to = time;
        signal - self.foretold(time)
    }

    /// Keeps the mean residual of a block that is over now, µε, until the motion is sure to have stood.
    pub(super) fn keep(&mut self, mean: f64) {
        self.waiting.push_back((self.to, mean));
    }

    /// The next block that was over by this time, s, and its mean residual, µε.
    pub(super) fn sure(&mut self, by: f64) -> Option<(f64, f64)> {
        let (over, _) = self.waiting.front()?;
        if *over <= by { self.waiting.pop_front() } else { None }
    }

    /// The motion did not stand from this time on, s.
    pub(super) fn end(&mut self, at: f64) {
        self.to = self.to.min(at).max(self.from);
    }

    /// Judges the mean residual of a block that was over at a time, s, with the noise of one, µε, if it is known.
    pub(super) fn judge(&mut self, (over, mean): (f64, f64), noise: Option<f64>) {
        self.means.push_back(mean);
        if self.means.len() > TESTED {
            self.means.pop_front();
        }
        let Some(noise) = noise.filter(|_| self.means.len() == TESTED) else { return };
        let residual = self.means.iter().sum::<f64>() / TESTED as f64;
        let standard_error = noise * (1.0 / TESTED as f64 + 1.0 / OF_THE_MEAN).sqrt();
        self.residual = Some((residual, standard_error));
        let beyond = (residual.abs() > BEYOND * standard_error).then_some(residual > 0.0);
        if self.failure.is_none() && beyond.is_some() && beyond == self.was_beyond {
            self.failure = Some(self.failure_of(over, residual));
        }
        self.was_beyond = beyond;
    }

    fn failure_of(&self, time: f64, residual: f64) -> Failure {
        let to_change: f64 = self.parts.iter().map(|(part, _)| part).sum();
        let speed =
            |&(part, rate): &(f64, f64)| (part * rate * (-rate * (time - self.from)).exp()).abs();
        let acting = self.parts.iter().max_by(|a, b| speed(a).total_cmp(&speed(b)));
        Failure {
            after: time - self.entered,
            residual,
            changes_less: (residual > 0.0) == (to_change > 0.0),
            acting: acting.map(|(_, rate)| 1.0 / rate),
        }
    }
}
