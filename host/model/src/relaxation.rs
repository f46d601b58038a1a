//! Relaxation: the reduced relaxation function and the hereditary integral over it.
//!
//! The integral F = ∫ g(t−s) dN(s) (eq. 2.1) with g(t) = c0 + Σ ci e^(−vi t) (eq. 3.3) is a linear
//! state-space model with one state xi for each exponential, xi' = −vi xi + N', and
//! F = c0 N + Σ ci xi. For N linear between samples its step is exact, whatever the interval:
//! xi⁺ = ai xi + bi (N⁺ − N), ai = e^(−vi Δt), bi = (1 − ai)/(vi Δt). The cost of a sample is
//! constant, however long the history.

/// Shares c0, c1, c2 and rates v1, v2 (1/s) of eq. 3.6, the best fit to a hold at 12 mm: what is taken for silicone unless
/// something better is known.
pub const EQUATION_3_6: ([f64; 3], [f64; 2]) = ([0.4852, 0.2472, 0.2676], [3.981, 0.5325]);

/// One exponential of the relaxation function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Branch {
    /// Share ci of the elastic response that this branch carries at first.
    pub share: f64,
    /// Rate vi at which it decays, 1/s.
    pub rate: f64,
}

/// Reduced relaxation function g(t) = c0 + Σ ci e^(−vi t), c0 = 1 − Σ ci (eq. 3.3).
#[derive(Clone, Debug, PartialEq)]
pub struct Relaxation {
    /// The exponentials; their order does not matter.
    pub branches: Vec<Branch>,
}

impl Relaxation {
    /// From shares c1… and rates v1… (1/s) of equal number.
    #[must_use]
    pub fn new(shares: &[f64], rates: &[f64]) -> Self {
        let branches =
            shares.iter().zip(rates).map(|(&share, &rate)| Branch { share, rate }).collect();
        Self { branches }
    }

    /// Share c0 that never relaxes.
    #[must_use]
    pub fn equilibrium(&self) -> f64 {
        self.branches.iter().fold(1.0, |rest, branch| rest - branch.share)
    }

    /// g at a time since a step, s.
    #[must_use]
    pub fn at(&self, time: f64) -> f64 {
        self.branches.iter().fold(self.equilibrium(), |sum, branch| {
            sum + branch.share * (-branch.rate * time).exp()
        })
    }
}

/// What the material remembers: the state of the hereditary integral.
#[derive(Clone, Debug)]
pub struct Memory {
    /// Elastic response N at the last sample, N.
    elastic: f64,
    /// State xi of each branch, N.
    states: Vec<f64>,
    /// ai and bi of each branch for the interval last used: recordings are mostly uniform.
    steps: Vec<(f64, f64)>,
    interval: f64,
}

/// Two intervals closer than this, relatively, are the same: times are printed with few digits.
const SAME_INTERVAL: f64 = 1e-7;

impl Memory {
    /// A specimen at rest that has forgotten all.
    #[must_use]
    pub fn rested(terms: usize) -> Self {
        Self {
            elastic: 0.0,
            states: vec![0.0; terms],
            steps: vec![(0.0, 0.0); terms],
            interval: f64::NAN,
        }
    }

    /// A sudden change of the elastic response to `elastic`, N; returns the force, N.
    pub fn jump(&mut self, relaxation: &Relaxation, elastic: f64) -> f64 {
        let change = elastic - self.elastic;
        self.elastic = elastic;
        for state in &mut self.states {
            *state += change;
        }
        self.force(relaxation)
    }

    /// The elastic response moves linearly to `elastic`, N, within `interval` seconds; returns the
    /// force, N.
    pub fn step(&mut self, relaxation: &Relaxation, elastic: f64, interval: f64) -> f64 {
        self.prepare(relaxation, interval);
        let change = elastic - self.elastic;
        self.elastic = elastic;
        for (state, &(decay, gain)) in self.states.iter_mut().zip(&self.steps) {
            *state = *state * decay + gain * change;
        }
        self.force(relaxation)
    }

    /// The elastic response that leaves the surface free of force after `interval` seconds, N.
    pub fn free(&mut self, relaxation: &Relaxation, interval: f64) -> f64 {
        self.reaching(relaxation, 0.0, interval)
    }

    /// The force reaches a value, N, within `interval` seconds, with an elastic response that moves
    /// linearly; returns that response, N.
    pub fn reach(&mut self, relaxation: &Relaxation, force: f64, interval: f64) -> f64 {
        let elastic = self.reaching(relaxation, force, interval);
        let _ = self.step(relaxation, elastic, interval);
        elastic
    }

    fn reaching(&mut self, relaxation: &Relaxation, force: f64, interval: f64) -> f64 {
        self.prepare(relaxation, interval);
        let mut held = 0.0;
        let mut immediate = 0.0;
        for ((branch, &state), &(decay, gain)) in
            relaxation.branches.iter().zip(&self.states).zip(&self.steps)
        {
            held += branch.share * state * decay;
            immediate += branch.share * gain;
        }
        (force + immediate * self.elastic - held) / (relaxation.equilibrium() + immediate)
    }

    /// Elastic response at the last sample, N.
    #[must_use]
    pub const fn elastic(&self) -> f64 {
        self.elastic
    }

    /// How the force goes on while the elastic response stands, N: what stays, and what decays of each
    /// branch with its rate, 1/s.
    #[must_use]
    pub fn parts(&self, relaxation: &Relaxation) -> (f64, Vec<(f64, f64)>) {
        let parts = relaxation.branches.iter().zip(&self.states);
        let parts = parts.map(|(branch, state)| (branch.share * state, branch.rate)).collect();
        (relaxation.equilibrium() * self.elastic, parts)
    }

    fn force(&self, relaxation: &Relaxation) -> f64 {
        let relaxed = relaxation.equilibrium() * self.elastic;
        relaxation
            .branches
            .iter()
            .zip(&self.states)
            .fold(relaxed, |sum, (branch, &state)| sum + branch.share * state)
    }

    fn prepare(&mut self, relaxation: &Relaxation, interval: f64) {
        if (interval - self.interval).abs() <= SAME_INTERVAL * interval {
            return;
        }
        self.interval = interval;
        for (step, branch) in self.steps.iter_mut().zip(&relaxation.branches) {
            let exponent = branch.rate * interval;
            *step = ((-exponent).exp(), mean_decay(exponent));
        }
    }
}

/// (1 − e^(−z))/z, the mean of the decay over an interval, exact to rounding also for small z.
pub fn mean_decay(z: f64) -> f64 {
    decay_and_mean(z).1
}

/// e^(−z) and its mean over the interval, for one exponential.
pub(super) fn decay_and_mean(z: f64) -> (f64, f64) {
    let gone = -(-z).exp_m1();
    // The series 1 − z/2 + z²/6; its next term is below 1e-16.
    let mean = if z.abs() < 1e-5 { (z / 6.0 - 0.5) * z + 1.0 } else { gone / z };
    (1.0 - gone, mean)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn sushi() -> Relaxation {
        Relaxation::new(&[0.2472, 0.2676], &[3.981, 0.5325])
    }

    #[test]
    fn a_step_relaxes_along_g() {
        let g = sushi();
        let mut memory = Memory::rested(2);
        assert!((memory.jump(&g, 2.0) - 2.0).abs() < 1e-15);
        let mut time = 0.0;
        for interval in [0.005, 0.005, 0.3, 0.001, 2.0] {
            time += interval;
            let force = memory.step(&g, 2.0, interval);
            assert!((force - 2.0 * g.at(time)).abs() < 1e-14, "at {time} s");
        }
    }

    #[test]
    fn a_ramp_is_exact_in_steps_of_any_size() {
        let g = sushi();
        let closed = |t: f64| {
            let decayed = |c: f64, v: f64| c * (1.0 - (-v * t).exp()) / v;
            0.4852 * t + decayed(0.2472, 3.981) + decayed(0.2676, 0.5325)
        };
        for steps in [1, 3, 1000] {
            let mut memory = Memory::rested(2);
            let interval = 1.7 / f64::from(steps);
            let mut force = 0.0;
            for k in 1..=steps {
                force = memory.step(&g, interval * f64::from(k), interval);
            }
            assert!((force - closed(1.7)).abs() < 1e-12, "{steps} steps");
        }
    }

    #[test]
    fn a_free_surface_carries_no_force() {
        let g = sushi();
        let mut memory = Memory::rested(2);
        memory.jump(&g, 1.0);
        memory.step(&g, 1.0, 3.0);
        for _ in 0..100 {
            let free = memory.free(&g, 0.01);
            assert!(memory.step(&g, free, 0.01).abs() < 1e-14);
        }
    }

    #[test]
    fn the_elastic_response_comes_back_from_the_force_and_a_hold_goes_on_in_parts() {
        let g = sushi();
        let (mut there, mut back) = (Memory::rested(2), Memory::rested(2));
        for k in 1..=300 {
            let elastic = 3.0 * (f64::from(k) * 0.01).sin();
            let force = there.step(&g, elastic, 0.01);
            assert!((back.reach(&g, force, 0.01) - elastic).abs() < 1e-12);
        }
        let (stays, parts) = back.parts(&g);
        let later: f64 = parts.iter().map(|(part, rate)| part * (-rate * 0.7).exp()).sum();
        assert!((stays + later - there.step(&g, back.elastic(), 0.7)).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn mean_decay_has_no_seam(exponent in -8f64..-2.0) {
            let z = 10f64.powf(exponent);
            let series = 1.0 - z / 2.0 + z * z / 6.0 - z.powi(3) / 24.0 + z.powi(4) / 120.0
                - z.powi(5) / 720.0;
            prop_assert!((mean_decay(z) - series).abs() < 2e-15);
        }

        #[test]
        fn superposition_holds(a in -2f64..2.0, b in -2f64..2.0, interval in 1e-4f64..1.0) {
            let g = sushi();
            let run = |first: f64, second: f64| {
                let mut memory = Memory::rested(2);
                memory.step(&g, first, interval);
                memory.step(&g, second, 0.3)
            };
            prop_assert!((run(a, b) - a * run(1.0, 0.0) - b * run(0.0, 1.0)).abs() < 1e-12);
        }
    }
}
