//! A set-up that yields under the force, so that less of the commanded motion reaches the specimen.

/// Finds, sample by sample, the compression z, mm, that a yielding set-up comes to: z = next(z).
#[derive(Clone, Copy, Debug)]
pub struct Yielding {
    /// What the set-up yielded at the last sample, mm.
    yielded: f64,
    /// Slope of z − next(z) there.
    slope: f64,
}

impl Default for Yielding {
    fn default() -> Self {
        Self { yielded: 0.0, slope: 1.0 }
    }
}

/// Part of the compression, over 1 mm and itself, that is left open.
const SETTLED: f64 = 1e-13;
/// Most evaluations at one sample.
const MOST: usize = 60;

impl Yielding {
    /// The compression, mm, at a commanded one, x, mm; `next` is where the set-up comes to, mm, under the
    /// force at a compression, mm.
    ///
    /// The root is kept between two compressions once it is known to lie there: secants that leave them
    /// are halved.
    pub fn reached(&mut self, x: f64, next: impl Fn(f64) -> f64) -> f64 {
        let open = |z: f64| z - next(z);
        let settled = SETTLED * (1.0 + x.abs());
        let (mut below, mut above) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut z = x - self.yielded;
        let mut rest = open(z);
        for _ in 0..MOST {
            if rest.abs() <= settled || !rest.is_finite() {
                break;
            }
            if rest < 0.0 {
                below = z;
            } else {
                above = z;
            }
            let mut to = z - rest / self.slope;
            if !(below < to && to < above) {
                let between = below.is_finite() && above.is_finite();
                to = if between { 0.5 * (below + above) } else { z - rest };
            }
            let there = open(to);
            let slope = (there - rest) / (to - z);
            if slope.is_finite() && slope > 0.0 {
                self.slope = slope;
            }
            (z, rest) = (to, there);
        }
        self.yielded = x - z;
        z
    }
}

/// The same for a whole stretch at once, where what happens at one sample depends on those before: secants
/// at every sample. It remembers where the last stretch came to, as most runs of a fit come to nearly the
/// same.
#[derive(Clone, Debug, Default)]
pub struct StretchYielding {
    /// Time of the stretch's first sample, s.
    start: f64,
    yielded: Vec<f64>,
    slope: Vec<f64>,
}

/// Largest part of the compressions of a stretch that is left open, mm.
const STRETCH_SETTLED: f64 = 1e-10;
/// Most runs over a stretch.
const MOST_RUNS: usize = 24;

impl StretchYielding {
    /// Finds the compressions, mm, of a stretch that begins at `start`, s, at the commanded ones, x, mm:
    /// `next` gives where the set-up comes to under the force at compressions, and its last call is at those
    /// found. The number of those calls.
    pub fn settle(
        &mut self,
        start: f64,
        x: &[f64],
        mut next: impl FnMut(&[f64]) -> Vec<f64>,
    ) -> usize {
        if self.start.to_bits() != start.to_bits() || self.yielded.len() != x.len() {
            let count = x.len();
            *self = Self { start, yielded: vec![0.0; count], slope: vec![1.0; count] };
        }
        let mut at: Vec<f64> =
            x.iter().zip(&self.yielded).map(|(x, yielded)| x - yielded).collect();
        let mut reached = next(&at);
        let mut runs = 1;
        while runs < MOST_RUNS {
            let open =
                at.iter().zip(&reached).fold(0.0, |most: f64, (z, to)| most.max((z - to).abs()));
            if open <= STRETCH_SETTLED || !open.is_finite() {
                break;
            }
            let rest: Vec<f64> = at.iter().zip(&reached).map(|(z, to)| z - to).collect();
            let moved: Vec<f64> = at
                .iter()
                .zip(&rest)
                .zip(&self.slope)
                .map(|((z, rest), slope)| z - rest / slope)
                .collect();
            reached = next(&moved);
            runs += 1;
            for (k, slope) in self.slope.iter_mut().enumerate() {
                // More force never lets a set-up yield less.
                let secant = (moved[k] - reached[k] - rest[k]) / (moved[k] - at[k]);
                if secant.is_finite() {
                    *slope = secant.max(1.0);
                }
            }
            at = moved;
        }
        for ((yielded, x), z) in self.yielded.iter_mut().zip(x).zip(&at) {
            *yielded = x - z;
        }
        runs
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::candidates;
    use crate::fit::data::Data;
    use crate::fit::whole_motion::predict;
    use crate::model::{Act, BaseLaw, Chain, Family, Motion, Separation};
    use crate::trace::{DISPLACEMENT, FORCE, Trace};
    use proptest::prelude::*;

    /// A press, a hold and a release, 0.01 s and a little apart: times, s, and compressions, mm.
    fn press(jitter: f64) -> (Vec<f64>, Vec<f64>) {
        let time: Vec<f64> =
            (0..400).map(|k| 0.01 * f64::from(k) + jitter * f64::from(k % 3)).collect();
        let x = time.iter().map(|t| (6.0 * t - 2.0).min(5.0).min(20.0 - 6.0 * t)).collect();
        (time, x)
    }

    fn trace(time: &[f64], x: &[f64]) -> Trace {
        let mut trace = Trace { time: time.to_vec(), ..Trace::default() };
        trace.set_column(DISPLACEMENT, x.to_vec());
        trace.set_column(FORCE, time.to_vec());
        trace
    }

    /// What a set-up leaves of a motion under these forces, N.
    fn left(x: &[f64], force: &[f64], act: &Act, own: &[f64]) -> Vec<f64> {
        let Act::Yield(yields) = act else { panic!("no set-up that yields") };
        x.iter().zip(force).map(|(x, force)| x - yields(own, *force)).collect()
    }

    #[track_caller]
    fn same(force: &[f64], again: &[f64], law: &str) {
        for (k, (a, b)) in force.iter().zip(again).enumerate() {
            assert!((a - b).abs() < 1e-8, "{law} {k}: {a} for {b}");
        }
    }

    #[test]
    fn a_chain_that_yields_is_the_base_law_on_what_is_left_of_the_motion() {
        let (time, x) = press(1e-3);
        let traces = [trace(&time, &x)];
        let data = Data::of(&traces, FORCE).unwrap();
        let setting = data.setting();
        let candidates = candidates(&setting, &[]).unwrap();
        let fixture = candidates.iter().find(|c| c.name == "fixture-compliance").unwrap();
        for separation in [Separation::Clamp, Separation::Bonded, Separation::Free] {
            for law in [BaseLaw::fung(2, separation), BaseLaw::new(Family::Latency, 1, separation)]
            {
                let base = Chain::new(law);
                let parameters: Vec<f64> =
                    vec![0.4, 0.6, 0.3, 0.2, 4.0, 0.5][..law.count()].to_vec();
                for form in &fixture.forms {
                    let chain = base.with(form.applied.clone());
                    let own = [vec![0.15], form.grid[0].clone()].concat();
                    let all = [parameters.clone(), own.clone()].concat();
                    let force = predict(&chain, &all, &data).remove(0);
                    let left = left(&x, &force, &form.applied.act, &own);
                    let motion = Motion {
                        time: time.clone().into(),
                        displacement: left.into(),
                        rest_before: None,
                    };
                    let again = law.predict(&parameters, &[motion]).remove(0);
                    same(&force, &again, &form.applied.law);
                }
            }
        }
    }

    #[test]
    fn a_chain_that_yields_beside_another_effect_is_that_chain_on_what_is_left_of_the_motion() {
        let (time, x) = press(0.0);
        let traces = [trace(&time, &x)];
        let data = Data::of(&traces, FORCE).unwrap();
        let candidates = candidates(&data.setting(), &[]).unwrap();
        let named = |name: &str| &candidates.iter().find(|c| c.name == name).unwrap().forms[0];
        let (stiffening, base) = (named("elastic-stiffening"), [0.4, 0.6, 0.3, 0.2, 4.0, 0.5]);
        let alone =
            Chain::new(BaseLaw::fung(2, Separation::Clamp)).with(stiffening.applied.clone());
        let mut own = vec![0.5 * stiffening.typical];
        own.extend(&stiffening.grid[0]);
        let parameters = [base.to_vec(), own].concat();
        for form in &candidates.iter().find(|c| c.name == "fixture-compliance").unwrap().forms {
            let strength = [vec![0.15], form.grid[0].clone()].concat();
            let all = [parameters.clone(), strength.clone()].concat();
            let force = predict(&alone.with(form.applied.clone()), &all, &data).remove(0);
            let left = [trace(&time, &left(&x, &force, &form.applied.act, &strength))];
            let again = predict(&alone, &parameters, &Data::of(&left, FORCE).unwrap()).remove(0);
            same(&force, &again, &form.applied.law);
        }
    }

    #[test]
    fn a_stretch_settles_in_few_runs_and_once_known_in_fewer() {
        // A surface that is touched and left, a force that relaxes, and a gap that closes at once.
        let x: Vec<f64> = (0..600).map(|k| 6.0 * (0.02 * f64::from(k)).sin() - 1.0).collect();
        let next = |stiffness: f64| {
            let x = x.clone();
            move |z: &[f64]| {
                let mut late = 0.0;
                let reach = |(x, z): (&f64, &f64)| {
                    let elastic = stiffness * z.max(0.0).powf(1.7);
                    late += 0.05 * (elastic - late);
                    let force = (elastic - 0.5 * late).max(0.0);
                    x + 0.19 * (-force / 0.46).exp_m1()
                };
                x.iter().zip(z).map(reach).collect::<Vec<_>>()
            }
        };
        let mut yielding = StretchYielding::default();
        let first = yielding.settle(0.0, &x, next(0.4));
        let again = yielding.settle(0.0, &x, next(0.4 * (1.0 + 1e-6)));
        assert!(first <= 9 && again < first, "{first}, then {again}");
    }

    proptest! {
        #[test]
        fn what_is_reached_is_what_the_force_there_leaves(
            x in proptest::collection::vec(-1.0f64..10.0, 1..30),
            compliance in 0.0f64..2.0,
            exponent in 1.0f64..4.0,
            closing in 0.01f64..5.0,
        ) {
            let force = |z: f64| 0.3 * z.max(0.0).powf(exponent);
            let yields = |force: f64| compliance * (1.0 - (-force / closing).exp());
            let mut yielding = Yielding::default();
            for x in x {
                let z = yielding.reached(x, |z| x - yields(force(z)));
                prop_assert!((z - (x - yields(force(z)))).abs() < 1e-11, "{z} at {x}");
                prop_assert!(z <= x + 1e-11);
            }
        }
    }
}
