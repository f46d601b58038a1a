//! The hereditary integral over a whole stretch, with what effects can change in it.
//!
//! F = N + s (Σ ci (xi − D) + c⁺ D), xi' = −vi r h(xi) xi + D', D = d N: with all factors at one,
//! h = 1 and c⁺ = 0 it is eq. 2.1 with the relaxation function of eq. 3.3. Steps are exact for N linear between samples
//! where the rates are constant, and of second order where they vary.

use super::relaxation::mean_decay;
use super::{Branch, Separation};

/// How the elastic response relaxes over one stretch.
#[derive(Clone, Debug, PartialEq)]
pub struct Hereditary {
    /// Shares ci and rates vi, 1/s.
    pub branches: Vec<Branch>,
    /// Share c⁺ of branches whose force comes on top of the elastic response.
    pub on_top: f64,
    /// Factor s on all shares, sample by sample; one where absent.
    pub share_factor: Option<Vec<f64>>,
    /// Part d of the elastic response that drives the branches, sample by sample; one where absent.
    pub drive_factor: Option<Vec<f64>>,
    /// Factor r on all rates, sample by sample; one where absent.
    pub rate_factor: Option<Vec<f64>>,
    /// How the rate of a branch grows with its state.
    pub growth: Growth,
    /// What happens when contact breaks.
    pub separation: Separation,
}

/// How the rate of a branch grows with its state x: a factor h(x).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Growth {
    /// h = 1: a linear law.
    None,
    /// h = |x/X|^m: power m, and state X, N, at which the rates are stated.
    Power(f64, f64),
    /// h = sinh(s y)/(s y), y = x/X: strength s and state X, N (Eyring).
    Sinh(f64, f64),
}

impl Growth {
    /// Whether the rate stays what it is.
    fn is_none(self) -> bool {
        matches!(self, Self::None | Self::Power(0.0, _) | Self::Sinh(0.0, _))
    }

    fn at(self, x: f64) -> f64 {
        let factor = match self {
            Self::None => return 1.0,
            Self::Power(power, full) => (x / full).abs().powf(power),
            Self::Sinh(strength, full) => {
                let y = (strength * x / full).abs().min(30.0);
                if y < 1e-4 { 1.0 + y * y / 6.0 } else { y.sinh() / y }
            }
        };
        factor.clamp(RATE_RANGE.0, RATE_RANGE.1)
    }
}

/// State of the hereditary integral between samples and traces.
#[derive(Clone, Debug, Default)]
pub struct HereditaryState {
    /// State xi of each branch, N.
    states: Vec<f64>,
    /// What drives the branches, D, at the last sample, N.
    driven: f64,
    /// Decay and gain of each branch within the interval last used.
    steps: Vec<(f64, f64)>,
    interval: f64,
}

/// Two intervals closer than this, relatively, are the same: times are printed with few digits.
const SAME_INTERVAL: f64 = 1e-7;
/// Largest part of a growth of the rate that is followed; a state far off its reference is at rest or
/// relaxes within a sample anyway.
const RATE_RANGE: (f64, f64) = (1e-9, 1e6);

impl Hereditary {
    /// The linear law of these branches.
    #[must_use]
    pub fn linear(branches: Vec<Branch>, separation: Separation) -> Self {
        Self {
            branches,
            on_top: 0.0,
            share_factor: None,
            drive_factor: None,
            rate_factor: None,
            growth: Growth::None,
            separation,
        }
    }

    /// Runs over a stretch: `elastic` is the elastic response, N, at each `time`, s. The force, N,
    /// goes to `force`; contact breaks at zero force unless bonded.
    ///
    /// `rest` is the time since the last stretch, s; none where the specimen has forgotten all.
    pub fn run(
        &self,
        time: &[f64],
        elastic: &[f64],
        rest: Option<f64>,
        state: &mut HereditaryState,
        force: &mut Vec<f64>,
    ) {
        state.begin(self.branches.len());
        match rest {
            Some(rest) => self.rest(state, rest),
            None => state.forget(),
        }
        force.clear();
        let mut before = f64::NAN;
        for (k, (&time, &elastic)) in time.iter().zip(elastic).enumerate() {
            let interval = time - before;
            before = time;
            let value = if k == 0 {
                self.jump(state, elastic)
            } else {
                self.prepare(state, k, interval, at(&self.drive_factor, k) * elastic);
                let reached = match self.separation {
                    Separation::Clamp | Separation::Bonded => elastic,
                    Separation::Free => elastic.max(self.free(state, k)),
                };
                self.step(state, k, reached)
            };
            force.push(if self.separation == Separation::Bonded { value } else { value.max(0.0) });
        }
    }

    fn force(&self, state: &HereditaryState, k: usize, elastic: f64) -> f64 {
        let latent: f64 = self
            .branches
            .iter()
            .zip(&state.states)
            .map(|(branch, x)| branch.share * (x - state.driven))
            .sum();
        elastic + at(&self.share_factor, k) * (latent + self.on_top * state.driven)
    }

    fn jump(&self, state: &mut HereditaryState, elastic: f64) -> f64 {
        let driven = at(&self.drive_factor, 0) * elastic;
        for x in &mut state.states {
            *x += driven - state.driven;
        }
        state.driven = driven;
        self.force(state, 0, elastic)
    }

    fn step(&self, state: &mut HereditaryState, k: usize, elastic: f64) -> f64 {
        let driven = at(&self.drive_factor, k) * elastic;
        let change = driven - state.driven;
        state.driven = driven;
        for (x, &(decay, gain)) in state.states.iter_mut().zip(&state.steps) {
            *x = *x * decay + gain * change;
        }
        self.force(state, k, elastic)
    }

    /// The elastic response that would leave the surface free of force at sample `k`, N.
    fn free(&self, state: &HereditaryState, k: usize) -> f64 {
        let (share, drive) = (at(&self.share_factor, k), at(&self.drive_factor, k));
        let (mut held, mut immediate) = (0.0, 1.0 + self.on_top * share * drive);
        for ((branch, x), &(decay, gain)) in
            self.branches.iter().zip(&state.states).zip(&state.steps)
        {
            held += branch.share * share * (decay * x - gain * state.driven);
            immediate += branch.share * share * drive * (gain - 1.0);
        }
        -held / immediate
    }

    /// Decay and gain of every branch from sample `k` − 1 to `k`, towards the drive `ahead`.
    fn prepare(&self, state: &mut HereditaryState, k: usize, interval: f64, ahead: f64) {
        let steady = self.rate_factor.is_none() && self.growth.is_none();
        if steady && (interval - state.interval).abs() <= SAME_INTERVAL * interval {
            return;
        }
        state.interval = if steady { interval } else { f64::NAN };
        let factor = at(&self.rate_factor, k);
        let half = 0.5 * (ahead - state.driven);
        for ((step, branch), x) in state.steps.iter_mut().zip(&self.branches).zip(&state.states) {
            let exponent = branch.rate * factor * self.growth.at(x + half) * interval;
            *step = ((-exponent).exp(), mean_decay(exponent));
        }
    }

    /// Lets the specimen rest between two stretches.
    fn rest(&self, state: &mut HereditaryState, seconds: f64) {
        let factor = at(&self.rate_factor, 0);
        if self.separation != Separation::Free {
            for (x, branch) in state.states.iter_mut().zip(&self.branches) {
                *x = self.rested(*x, branch.rate * factor, seconds);
            }
            return;
        }
        // The free recovery is curved; linear pieces of growing length follow it closely.
        const PIECES: i32 = 24;
        let unit = seconds / (2f64.powi(PIECES) - 1.0);
        for piece in 0..PIECES {
            self.prepare(state, 0, unit * 2f64.powi(piece), state.driven);
            let free = self.free(state, 0).max(0.0);
            self.step(state, 0, free);
        }
    }
}

impl HereditaryState {
    fn begin(&mut self, branches: usize) {
        self.states.resize(branches, 0.0);
        self.steps.resize(branches, (0.0, 0.0));
        self.interval = f64::NAN;
    }

    fn forget(&mut self) {
        self.states.fill(0.0);
        self.driven = 0.0;
    }
}

impl Hereditary {
    /// The state x of a branch after a rest, at a rate stated for the linear law, in closed form.
    fn rested(&self, x: f64, rate: f64, seconds: f64) -> f64 {
        match self.growth {
            // tanh(s y/2) decays exponentially.
            Growth::Sinh(strength, full) if strength.abs() > 1e-6 => {
                let half = (0.5 * strength * x / full).tanh() * (-rate * seconds).exp();
                half.atanh() * 2.0 * full / strength
            }
            Growth::Power(power, _) if power.abs() > 1e-9 => {
                let turns = rate * self.growth.at(x) * seconds;
                x * (1.0 + power * turns).max(0.0).powf(-1.0 / power)
            }
            _ => x * (-rate * seconds).exp(),
        }
    }
}

fn at(factor: &Option<Vec<f64>>, k: usize) -> f64 {
    factor.as_ref().map_or(1.0, |factor| factor[k])
}
