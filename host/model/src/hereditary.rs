//! The hereditary integral over a whole stretch, with what effects can change in it.
//!
//! F = N + s (Σ ci (xi − D) + c⁺ D) + τ N', xi' = −vi r h(xi) xi + D', D = d N: with all factors at one,
//! h = 1, c⁺ = 0 and τ = 0 it is eq. 2.1 with the relaxation function of eq. 3.3. Read backwards,
//! N = F − s Σ ci xi with D = d F, it is the creep of eq. 6.2: what goes in settles late.
//!
//! For N linear between samples steps are exact where the rates are constant, and where they follow the
//! state as exact as [`Growth`] says; a surface that parts and a creep that follows its state are found by
//! two secants.

use super::growth::Growth;
use super::relaxation::decay_and_mean;
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
    /// Viscosity over stiffness of what relaxes within less than an interval, s: it follows the mean speed over the last one.
    pub viscosity: f64,
    /// Viscosity over stiffness τ of a damper beside the spring, s: it follows the speed at each sample, or over the last interval where
    /// what comes next is not known.
    pub damper: f64,
    /// Whether the response settles late to its input (creep) instead of relaxing from it.
    pub retarded: bool,
    /// What happens when contact breaks.
    pub separation: Separation,
}

/// State of the hereditary integral between samples and traces.
#[derive(Debug, Default)]
pub struct HereditaryState {
    /// State xi of each branch, N.
    states: Vec<f64>,
    /// What drives the branches, D, at the last sample, N.
    driven: f64,
    /// What went in at the last sample, N.
    input: f64,
    /// Decay and gain of each branch within the interval last used.
    steps: Vec<(f64, f64)>,
    interval: f64,
    /// Those of other intervals. What holds whatever happened is not copied with the state, nor lost with it.
    known: KnownSteps,
}

impl Clone for HereditaryState {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    fn clone_from(&mut self, other: &Self) {
        self.states.clone_from(&other.states);
        self.steps.clone_from(&other.steps);
        (self.driven, self.input, self.interval) = (other.driven, other.input, other.interval);
    }
}

/// Decays and gains of the branches within intervals that were used: means of a recording are unequally far apart, but few of their
/// distances differ.
#[derive(Debug, Default)]
struct KnownSteps {
    /// Rates of the branches, 1/s.
    rates: Vec<f64>,
    /// Each in the place that its leading digits say; not a number where none is.
    intervals: Vec<f64>,
    /// Of all branches, interval by interval.
    steps: Vec<(f64, f64)>,
}

/// Intervals that are remembered, a power of two.
const KNOWN: usize = 64;

impl KnownSteps {
    /// Forgets what is known of other rates than these.
    fn keep_for(&mut self, branches: &[Branch]) {
        let rates = branches.iter().map(|branch| branch.rate);
        if self.intervals.is_empty() || !rates.clone().eq(self.rates.iter().copied()) {
            self.rates.clear();
            self.rates.extend(rates);
            self.intervals.clear();
            self.intervals.resize(KNOWN, f64::NAN);
            self.steps.resize(KNOWN * branches.len(), (0.0, 0.0));
        }
    }

    fn place(interval: f64) -> usize {
        let spread = (interval as f32).to_bits().wrapping_mul(0x9e37_79b9);
        (spread >> (u32::BITS - KNOWN.trailing_zeros())) as usize
    }

    /// Fills in the steps within an interval, if they are known.
    fn fill(&self, interval: f64, steps: &mut [(f64, f64)]) -> bool {
        let place = Self::place(interval);
        let is_known = (interval - self.intervals[place]).abs() <= SAME_INTERVAL * interval;
        if is_known {
            steps.copy_from_slice(&self.steps[place * steps.len()..][..steps.len()]);
        }
        is_known
    }

    fn keep(&mut self, interval: f64, steps: &[(f64, f64)]) {
        let place = Self::place(interval);
        self.intervals[place] = interval;
        self.steps[place * steps.len()..][..steps.len()].copy_from_slice(steps);
    }
}

/// Least part of a compression that follows at once.
const SMALLEST_IMMEDIATE: f64 = 1e-6;
/// Two intervals closer than this, relatively, are the same: times are printed with few digits.
const SAME_INTERVAL: f64 = 1e-7;

/// Speed, 1/s, of a quantity at a sample from its changes since the `last` sample and until the `next`, each with the interval, s,
/// within which: that of the parabola through the three, and where none comes next that over the last interval.
#[must_use]
pub fn speed((last, came): (f64, f64), next: Option<(f64, f64)>) -> f64 {
    match next {
        Some((next, goes)) => (came / last * next + goes / next * last) / (last + next),
        None => came / last,
    }
}

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
            viscosity: 0.0,
            damper: 0.0,
            retarded: false,
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
        self.start(state, rest);
        force.clear();
        if self.is_linear() {
            return self.run_linear(time, elastic, state, force);
        }
        let mut before = f64::NAN;
        for (k, (&time, &elastic)) in time.iter().zip(elastic).enumerate() {
            let interval = time - before;
            before = time;
            let value = if k == 0 {
                self.jump(state, elastic)
            } else {
                self.advance(state, k, interval, elastic)
            };
            force.push(self.separation.carried(value));
        }
    }

    /// Whether the force at a sample is the same linear function of the state and the elastic response at every sample.
    fn is_linear(&self) -> bool {
        let factors = [&self.share_factor, &self.drive_factor, &self.rate_factor];
        self.is_affine()
            && self.separation != Separation::Free
            && factors.iter().all(|factor| factor.is_none())
    }

    /// [`Self::run`] where it [is linear](Self::is_linear).
    fn run_linear(
        &self,
        time: &[f64],
        elastic: &[f64],
        state: &mut HereditaryState,
        force: &mut Vec<f64>,
    ) {
        let (Some(&first), Some(&begin)) = (elastic.first(), time.first()) else { return };
        force.push(self.separation.carried(self.jump(state, first)));
        let mut before = begin;
        let mut samples = time.iter().zip(elastic).skip(1).peekable();
        while let Some((&time, &elastic)) = samples.next() {
            let interval = time - before;
            before = time;
            self.prepare_steady(state, interval);
            let change = elastic - state.driven;
            state.driven = elastic;
            let mut latent = 0.0;
            let branches = state.states.iter_mut().zip(&state.steps).zip(&self.branches);
            for ((x, &(decay, gain)), branch) in branches {
                *x = *x * decay + gain * change;
                latent += branch.share * (*x - elastic);
            }
            let mut viscous = self.viscosity * change / interval;
            if self.damper > 0.0 {
                let next = samples.peek().map(|&(next, ahead)| (next - time, ahead - elastic));
                viscous += self.damper * speed((interval, change), next);
            }
            force.push(
                self.separation.carried(elastic + (latent + self.on_top * elastic) + viscous),
            );
        }
        state.input = state.driven;
    }

    /// Goes from one stretch to the next.
    pub(super) fn start(&self, state: &mut HereditaryState, rest: Option<f64>) {
        state.begin(self.branches.len());
        match rest {
            Some(rest) => self.rest(state, rest),
            None => state.forget(),
        }
    }

    /// Whether the force at a sample is affine in the elastic response there, whatever was before.
    pub(super) fn is_affine(&self) -> bool {
        !self.retarded && self.growth.is_none()
    }

    /// The force at sample `k`, N, before contact breaks, of a law that is affine: what is held, N, and what
    /// the elastic response is multiplied by. No interval is that of a first sample, reached at once.
    pub(super) fn affine(
        &self,
        state: &mut HereditaryState,
        k: usize,
        interval: Option<f64>,
    ) -> (f64, f64) {
        match interval {
            Some(interval) => self.prepare(state, k, interval, state.driven),
            None => {
                state.steps.fill((1.0, 1.0));
                state.interval = f64::NAN;
            }
        }
        self.held(state, k, interval.unwrap_or(f64::INFINITY))
    }

    /// One sample: the force, N, or where retarded the settled response.
    pub(super) fn advance(
        &self,
        state: &mut HereditaryState,
        k: usize,
        interval: f64,
        elastic: f64,
    ) -> f64 {
        if self.retarded {
            let settled = self.settling(state, k, interval, elastic);
            // A parted surface is free of stress, wherever the indenter is.
            let free = self.separation == Separation::Free && settled < 0.0;
            return self.settle(state, k, if free { 0.0 } else { settled });
        }
        self.prepare(state, k, interval, at(&self.drive_factor, k) * elastic);
        let reached = match self.separation {
            Separation::Clamp | Separation::Bonded => elastic,
            Separation::Free => self.parting(state, k, interval, elastic),
        };
        self.step(state, k, interval, reached)
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

    /// A specimen that has forgotten all is taken to this elastic response, N, at once.
    pub(super) fn begin(&self, state: &mut HereditaryState, elastic: f64) -> f64 {
        state.begin(self.branches.len());
        state.forget();
        self.jump(state, elastic)
    }

    /// The first sample of a stretch: the force, N, or where retarded the settled response.
    pub(super) fn jump(&self, state: &mut HereditaryState, elastic: f64) -> f64 {
        if self.retarded {
            state.steps.fill((1.0, 1.0));
            state.interval = f64::NAN;
            let settled = self.settled(state, 0, elastic);
            return self.settle(state, 0, settled);
        }
        let driven = at(&self.drive_factor, 0) * elastic;
        for x in &mut state.states {
            *x += driven - state.driven;
        }
        (state.driven, state.input) = (driven, elastic);
        self.force(state, 0, elastic)
    }

    fn step(&self, state: &mut HereditaryState, k: usize, interval: f64, elastic: f64) -> f64 {
        let driven = at(&self.drive_factor, k) * elastic;
        let viscous = (self.viscosity + self.damper) * (elastic - state.input) / interval;
        self.drive(state, driven);
        state.input = elastic;
        self.force(state, k, elastic) + viscous
    }

    fn drive(&self, state: &mut HereditaryState, driven: f64) {
        let change = driven - state.driven;
        state.driven = driven;
        for (x, &(decay, gain)) in state.states.iter_mut().zip(&state.steps) {
            *x = *x * decay + gain * change;
        }
    }

    /// The elastic response at sample `k`, N, not below that of a surface that has parted; `elastic` was
    /// prepared for.
    fn parting(&self, state: &mut HereditaryState, k: usize, interval: f64, elastic: f64) -> f64 {
        let free = self.free(state, k, interval);
        if free <= elastic || self.growth.is_none() {
            return free.max(elastic);
        }
        self.prepare(state, k, interval, at(&self.drive_factor, k) * free);
        self.free(state, k, interval).max(elastic)
    }

    /// The elastic response that would leave the surface free of force at sample `k`, N.
    fn free(&self, state: &HereditaryState, k: usize, interval: f64) -> f64 {
        let (held, immediate) = self.held(state, k, interval);
        -held / immediate
    }

    /// The force at sample `k`, prepared for, without any elastic response, N, and what an elastic response
    /// adds to it for each newton.
    fn held(&self, state: &HereditaryState, k: usize, interval: f64) -> (f64, f64) {
        let (share, drive) = (at(&self.share_factor, k), at(&self.drive_factor, k));
        let viscous = (self.viscosity + self.damper) / interval;
        let mut held = -viscous * state.input;
        let mut immediate = 1.0 + viscous + self.on_top * share * drive;
        for ((branch, x), &(decay, gain)) in
            self.branches.iter().zip(&state.states).zip(&state.steps)
        {
            held += branch.share * share * (decay * x - gain * state.driven);
            immediate += branch.share * share * drive * (gain - 1.0);
        }
        (held, immediate)
    }

    /// Where retarded: prepares the step to sample `k` and gives the settled response to this input.
    fn settling(&self, state: &mut HereditaryState, k: usize, interval: f64, input: f64) -> f64 {
        self.prepare(state, k, interval, state.driven);
        let settled = self.settled(state, k, input);
        if self.growth.is_none() {
            return settled;
        }
        self.prepare(state, k, interval, at(&self.drive_factor, k) * settled);
        self.settled(state, k, input)
    }

    /// Where retarded: the settled response to this input at sample `k`.
    fn settled(&self, state: &HereditaryState, k: usize, input: f64) -> f64 {
        let (share, drive) = (at(&self.share_factor, k), at(&self.drive_factor, k));
        let (mut late, mut immediate) = (0.0, 1.0);
        for ((branch, x), &(decay, gain)) in
            self.branches.iter().zip(&state.states).zip(&state.steps)
        {
            late += branch.share * share * (decay * x - gain * state.driven);
            immediate -= branch.share * share * drive * gain;
        }
        (input + late) / immediate.max(SMALLEST_IMMEDIATE)
    }

    fn settle(&self, state: &mut HereditaryState, k: usize, settled: f64) -> f64 {
        self.drive(state, at(&self.drive_factor, k) * settled);
        let late: f64 =
            self.branches.iter().zip(&state.states).map(|(branch, x)| branch.share * x).sum();
        state.input = settled - at(&self.share_factor, k) * late;
        settled
    }

    /// Decay and gain of every branch from sample `k` − 1 to `k`, towards the drive `ahead`.
    fn prepare(&self, state: &mut HereditaryState, k: usize, interval: f64, ahead: f64) {
        if self.rate_factor.is_none() && self.growth.is_none() {
            return self.prepare_steady(state, interval);
        }
        state.interval = f64::NAN;
        let factor = at(&self.rate_factor, k);
        let change = ahead - state.driven;
        // A surface that does not part goes to where it was prepared for.
        let parts = self.separation == Separation::Free || self.retarded;
        let step = if parts { Growth::step } else { Growth::step_by };
        for ((found, branch), &x) in state.steps.iter_mut().zip(&self.branches).zip(&state.states) {
            *found = step(self.growth, x, change, branch.rate * factor * interval);
        }
    }

    /// The same where the rates are constant.
    #[inline]
    fn prepare_steady(&self, state: &mut HereditaryState, interval: f64) {
        let same = (interval - state.interval).abs() <= SAME_INTERVAL * interval;
        if !same {
            state.interval = interval;
            state.known.keep_for(&self.branches);
            if !state.known.fill(interval, &mut state.steps) {
                for (step, branch) in state.steps.iter_mut().zip(&self.branches) {
                    *step = decay_and_mean(branch.rate * interval);
                }
                state.known.keep(interval, &state.steps);
            }
        }
    }

    /// Lets the specimen rest between two stretches.
    fn rest(&self, state: &mut HereditaryState, seconds: f64) {
        let factor = at(&self.rate_factor, 0);
        if self.separation != Separation::Free && !self.retarded {
            for (x, branch) in state.states.iter_mut().zip(&self.branches) {
                *x = self.growth.alone(*x, branch.rate * factor * seconds);
            }
            return;
        }
        // The recovery is curved; linear pieces of growing length follow it closely.
        const PIECES: i32 = 24;
        let unit = seconds / (2f64.powi(PIECES) - 1.0);
        let input = state.input;
        for piece in 0..PIECES {
            let interval = unit * 2f64.powi(piece);
            if self.retarded {
                self.advance(state, 0, interval, input);
            } else {
                self.prepare(state, 0, interval, state.driven);
                let free = self.parting(state, 0, interval, 0.0);
                self.step(state, 0, interval, free);
            }
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
        (self.driven, self.input) = (0.0, 0.0);
    }
}

fn at(factor: &Option<Vec<f64>>, k: usize) -> f64 {
    factor.as_ref().map_or(1.0, |factor| factor[k])
}
