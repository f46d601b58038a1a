//! A tip on a specimen that relaxes, carried by a cantilever: the hereditary contact law.
//!
//! While the contact grows the force is the hereditary integral over that of an elastic half space, F = ∫ g(t−s) df(δ(s))
//! (Lee and Radok 1960), g the relaxation function (3.3). Once it shrinks it is as large as it was at an earlier time t1,
//! ∫ from t1 to t of g(t−s) dδ(s) = 0, and only what happened before t1 is left in the force, F = ∫ to t1 of g(t−s) df(δ(s))
//! (Ting 1966); both hold for every axisymmetric tip. The contact is lost when t1 reaches its beginning. A pull of
//! adhesion ([`Law`]) acts besides, constant while there is contact.
//!
//! δ and f(δ) count as linear between samples, for which the exponentials of g make exact recurrences.

use super::law::Law;
use palpate_model::{Relaxation, mean_decay};

/// A contact followed in time.
pub struct Contact<'a> {
    law: Law,
    relaxation: &'a Relaxation,
    spring: Option<f64>,
    /// Time, s, and way of the piezo, m, of the last sample; none before the first.
    last: Option<(f64, f64)>,
    /// Samples since the contact began, as long as it grew.
    grown: Vec<Grown>,
    /// Integrals ∫ e^(−vi (t−s)) dδ(s), m, and of f(δ(s)), N, of each of them, branch by branch.
    integrals: Vec<(f64, f64)>,
    /// The recurrences over the interval last used, s: decay and gain of each branch.
    steps: Vec<(f64, f64)>,
    interval: f64,
    /// On the way back, none otherwise.
    shrinking: Option<Shrinking>,
}

/// A sample of a contact that grows.
#[derive(Clone, Copy)]
struct Grown {
    time: f64,
    depth: f64,
    /// Elastic force f(δ) without adhesion, N.
    elastic: f64,
}

/// A contact that shrinks.
struct Shrinking {
    /// The contact is as large as between this sample and the next.
    as_at: usize,
    /// Time, s, and depth, m, of the last sample.
    time: f64,
    depth: f64,
    /// ∫ e^(−vi (t−s)) dδ(s) to the last sample, m.
    ways: Vec<f64>,
    /// Whether it is lost.
    lost: bool,
}

/// Most steps of a search for a root, which takes about six.
const STEPS: usize = 60;
/// Error of Ting's condition over the depth, and of the earlier time over a sample, that counts as none.
const TOLERANCE: f64 = 1e-13;
/// Two intervals closer than this, relatively, are the same: times are printed with few digits.
const SAME_INTERVAL: f64 = 1e-7;

impl<'a> Contact<'a> {
    /// A specimen at rest under a tip that is off it. The reduced modulus of the law is that at once, g(0) = 1.
    #[must_use]
    pub fn new(law: Law, relaxation: &'a Relaxation, spring: Option<f64>) -> Self {
        Self {
            law,
            relaxation,
            spring,
            last: None,
            grown: Vec::new(),
            integrals: Vec::new(),
            steps: Vec::new(),
            interval: f64::NAN,
            shrinking: None,
        }
    }

    /// Force, N, at a time, s, with the piezo at `z`, m: 0 where the straight cantilever would touch. From the first
    /// sample that `leaves` on the tip only goes back.
    pub fn follow(&mut self, time: f64, z: f64, leaves: bool) -> f64 {
        let before = self.last.replace((time, z));
        if self.shrinking.is_some() {
            return self.shrink(time, z);
        }
        let deepest = self.grown.last().map(|last| last.depth);
        let grows = self.grow(time, z, before);
        if !grows && (!leaves || deepest.is_none()) {
            self.grown.clear();
            self.integrals.clear();
            return 0.0;
        }
        let depth = self.grown.last().map_or(0.0, |last| last.depth);
        if !leaves || grows && deepest.is_none_or(|deepest| depth >= deepest) {
            return self.cantilever(z, depth, self.held());
        }
        if grows {
            self.grown.pop();
            self.integrals.truncate(self.grown.len() * self.branches());
        }
        self.turn();
        self.shrink(time, z)
    }

    /// Force with the tip at a depth, N; where the cantilever is rigid that of the contact.
    fn cantilever(&self, z: f64, depth: f64, contact: f64) -> f64 {
        self.spring.map_or(contact - self.law.adhesion_n, |k| k * (z - depth))
    }

    fn elastic(&self, depth: f64) -> f64 {
        self.law.tip.force(self.law.reduced_modulus, depth)
    }

    fn branches(&self) -> usize {
        self.relaxation.branches.len()
    }

    /// Force of the hereditary integral at the last sample of the growth, N.
    fn held(&self) -> f64 {
        let elastic = self.grown.last().map_or(0.0, |last| last.elastic);
        let integrals = &self.integrals[self.integrals.len() - self.branches()..];
        let shares = self.relaxation.branches.iter().zip(integrals);
        shares.fold(self.relaxation.equilibrium() * elastic, |sum, (b, y)| sum + b.share * y.1)
    }

    /// The recurrences over an interval, s.
    fn prepare(&mut self, interval: f64) {
        let same = (interval - self.interval).abs() <= SAME_INTERVAL * interval;
        if !same {
            self.interval = interval;
            let step = |rate: f64| ((-rate * interval).exp(), mean_decay(rate * interval));
            self.steps.clear();
            self.steps.extend(self.relaxation.branches.iter().map(|b| step(b.rate)));
        }
    }

    /// Takes the next sample of a growing contact; false out of contact.
    fn grow(&mut self, time: f64, z: f64, before: Option<(f64, f64)>) -> bool {
        if self.grown.is_empty() && !self.touch(time, z, before) {
            return false;
        }
        let last = self.grown[self.grown.len() - 1];
        self.prepare(time - last.time);
        let n = self.branches();
        let from = self.integrals.len() - n;
        // F = held + part f(δ) − pull, and k (z − δ) of the cantilever.
        let mut held = 0.0;
        let mut part = self.relaxation.equilibrium();
        for (i, b) in self.relaxation.branches.iter().enumerate() {
            let (decay, gain) = self.steps[i];
            held += b.share * (decay * self.integrals[from + i].1 - gain * last.elastic);
            part += b.share * gain;
        }
        let depth = match self.spring {
            None => (z > 0.0).then_some(z),
            Some(k) => self.depth(z, k, held, part),
        };
        let Some(depth) = depth else { return false };
        let now = Grown { time, depth, elastic: self.elastic(depth) };
        for i in 0..n {
            let ((decay, gain), (x, y)) = (self.steps[i], self.integrals[from + i]);
            let x = decay * x + gain * (now.depth - last.depth);
            self.integrals.push((x, decay * y + gain * (now.elastic - last.elastic)));
        }
        self.grown.push(now);
        true
    }

    /// Begins a contact between two samples; false where they are both off the specimen.
    fn touch(&mut self, time: f64, z: f64, before: Option<(f64, f64)>) -> bool {
        let touch = self.spring.map_or(0.0, |k| -self.law.adhesion_n / k);
        if z <= touch {
            return false;
        }
        let (before, from) = before.unwrap_or((time, z));
        let part = if from < touch { (touch - from) / (z - from) } else { 0.0 };
        let time = before + part * (time - before);
        self.grown.push(Grown { time, depth: 0.0, elastic: 0.0 });
        self.integrals.resize(self.branches(), (0.0, 0.0));
        true
    }

    /// Depth at which contact and cantilever bear the same force; none where none is above 0. Newton's method from above
    /// on an increasing convex function: every step stays above the root.
    fn depth(&self, z: f64, k: f64, held: f64, part: f64) -> Option<f64> {
        let mut depth = z + (self.law.adhesion_n - held) / k;
        if depth <= 0.0 {
            return None;
        }
        for _ in 0..STEPS {
            let excess = held + part * self.elastic(depth) - self.law.adhesion_n - k * (z - depth);
            // df/dδ = 2 E* a.
            let radius = self.law.tip.contact_radius(depth);
            let step = excess / (2.0 * part * self.law.reduced_modulus * radius + k);
            depth -= step;
            if step.abs() <= 1e-14 * depth.abs() {
                break;
            }
        }
        (depth > 0.0).then_some(depth)
    }

    /// From here on the contact shrinks.
    fn turn(&mut self) {
        let n = self.branches();
        let last = self.grown.len() - 1;
        let ways = self.integrals[last * n..].iter().map(|(x, _)| *x).collect();
        let Grown { time, depth, .. } = self.grown[last];
        self.shrinking =
            Some(Shrinking { as_at: last.saturating_sub(1), time, depth, ways, lost: false });
    }

    /// Force on the way back, N.
    fn shrink(&mut self, time: f64, z: f64) -> f64 {
        let Some(mut state) = self.shrinking.take() else { return 0.0 };
        let found = if state.lost { None } else { self.earlier(&state, time, z) };
        let force = match found {
            None => {
                state.lost = true;
                0.0
            }
            Some((as_at, then)) => {
                let (interval, moved) = (time - state.time, then.depth - state.depth);
                for (b, x) in self.relaxation.branches.iter().zip(&mut state.ways) {
                    let exponent = b.rate * interval;
                    *x = (-exponent).exp() * *x + mean_decay(exponent) * moved;
                }
                (state.as_at, state.time, state.depth) = (as_at, time, then.depth);
                self.cantilever(z, then.depth, then.force)
            }
        };
        self.shrinking = Some(state);
        force
    }

    /// The sample before the earlier time t1, and what follows from t1; none where the contact is lost.
    fn earlier(&self, state: &Shrinking, time: f64, z: f64) -> Option<(usize, Then)> {
        // Grows as t1 goes back: positive where the way since t1 has not been taken back yet.
        let mut j = state.as_at;
        let mut low = (0.0, self.then(state, time, z, j, 0.0));
        while low.1.excess < 0.0 {
            j = j.checked_sub(1)?;
            low = (0.0, self.then(state, time, z, j, 0.0));
        }
        let mut high = (1.0, self.then(state, time, z, j, 1.0));
        if high.1.excess >= 0.0 {
            return Some((j, high.1));
        }
        // False position after Illinois: an end that stays is halved.
        let mut kept = 0;
        for _ in 0..STEPS {
            let slope = (high.1.excess - low.1.excess) / (high.0 - low.0);
            let part = (low.0 - low.1.excess / slope).clamp(low.0, high.0);
            let then = self.then(state, time, z, j, part);
            if then.excess.abs() <= TOLERANCE * state.depth.abs() || high.0 - low.0 <= TOLERANCE {
                return Some((j, then));
            }
            if then.excess < 0.0 {
                high = (part, then);
                if kept == 1 {
                    low.1.excess *= 0.5;
                }
                kept = 1;
            } else {
                low = (part, then);
                if kept == 2 {
                    high.1.excess *= 0.5;
                }
                kept = 2;
            }
        }
        Some((j, low.1))
    }

    /// What follows from an earlier time: a part of the interval after sample `j`.
    fn then(&self, state: &Shrinking, time: f64, z: f64, j: usize, part: f64) -> Then {
        let n = self.branches();
        let from = self.grown[j];
        let to = self.grown.get(j + 1).copied().unwrap_or(from);
        let passed = part * (to.time - from.time);
        let (way, rise) = (part * (to.depth - from.depth), part * (to.elastic - from.elastic));
        let since = time - from.time - passed;
        let equilibrium = self.relaxation.equilibrium();
        let mut force = equilibrium * (from.elastic + rise);
        let mut excess = -equilibrium * (from.depth + way);
        let integrals = &self.integrals[j * n..(j + 1) * n];
        for (b, (x, y)) in self.relaxation.branches.iter().zip(integrals) {
            let exponent = b.rate * passed;
            let (decay, gain) = ((-exponent).exp(), mean_decay(exponent));
            let left = b.share * (-b.rate * since).exp();
            force += left * (decay * y + gain * rise);
            excess -= left * (decay * x + gain * way);
        }
        let depth = self.spring.map_or(z, |k| z - (force - self.law.adhesion_n) / k);
        excess += equilibrium * depth;
        let interval = time - state.time;
        for (b, x) in self.relaxation.branches.iter().zip(&state.ways) {
            let exponent = b.rate * interval;
            excess +=
                b.share * ((-exponent).exp() * x + mean_decay(exponent) * (depth - state.depth));
        }
        Then { depth, force, excess }
    }
}

/// What follows from an earlier time at which the contact was as large.
#[derive(Clone, Copy)]
struct Then {
    /// Depth now, m.
    depth: f64,
    /// Force of the contact without adhesion, N.
    force: f64,
    /// The integral of Ting's condition, m: 0 at the right time.
    excess: f64,
}
