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
const TOLERANCE: f64 = 1e-13;
/// Most evaluations at one sample.
const MAX_EVALUATIONS: usize = 60;

impl Yielding {
    /// The compression, mm, at a commanded one, x, mm; `next` is where the set-up comes to, mm, under the
    /// force at a compression, mm.
    ///
    /// The root is kept between two compressions once it is known to lie there: secants that leave them
    /// are halved.
    pub fn reached(&mut self, x: f64, next: impl Fn(f64) -> f64) -> f64 {
        let open = |z: f64| z - next(z);
        let settled = TOLERANCE * (1.0 + x.abs());
        let (mut below, mut above) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut z = x - self.yielded;
        let mut rest = open(z);
        for _ in 0..MAX_EVALUATIONS {
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
#[derive(Clone, Debug)]
pub struct StretchYielding {
    /// Time of the stretch's first sample, s.
    start: f64,
    yielded: Vec<f64>,
    slope: Vec<f64>,
    most_runs: usize,
}

impl Default for StretchYielding {
    fn default() -> Self {
        Self { start: 0.0, yielded: Vec::new(), slope: Vec::new(), most_runs: MOST_RUNS }
    }
}

/// Largest part of the compressions of a stretch that is left open, mm.
const STRETCH_SETTLED: f64 = 1e-10;
/// Most runs over a stretch.
const MOST_RUNS: usize = 24;
/// Runs that follow a small change to a few hundredths of it.
const RUNS_NEARBY: usize = 3;

impl StretchYielding {
    /// The same for stretches where little has changed since: a few runs, not until all is settled.
    #[must_use]
    pub fn nearby(&self) -> Self {
        Self { most_runs: RUNS_NEARBY, ..self.clone() }
    }

    /// Whether it is known where a stretch of so many samples that begins at `start`, s, came to.
    #[must_use]
    pub fn knows(&self, start: f64, samples: usize) -> bool {
        self.start.to_bits() == start.to_bits() && self.yielded.len() == samples
    }

    /// A stretch that begins at `start`, s, came to where the set-up yielded so much, mm.
    pub fn came_to(&mut self, start: f64, yielded: impl Iterator<Item = f64>) {
        self.start = start;
        self.yielded.clear();
        self.yielded.extend(yielded);
        self.slope.clear();
        self.slope.resize(self.yielded.len(), 1.0);
    }

    /// The same where that is only near: all is to be settled.
    pub fn comes_near(&mut self, start: f64, yielded: impl Iterator<Item = f64>) {
        self.came_to(start, yielded);
        self.most_runs = MOST_RUNS;
    }

    /// Finds the compressions, mm, of a stretch that begins at `start`, s, at the commanded ones, x, mm:
    /// `next` gives where the set-up comes to under the force at compressions, and its last call is at those
    /// found. The number of those calls.
    pub fn settle(
        &mut self,
        start: f64,
        x: &[f64],
        mut next: impl FnMut(&[f64]) -> Vec<f64>,
    ) -> usize {
        if !self.knows(start, x.len()) {
            self.comes_near(start, x.iter().map(|_| 0.0));
        }
        let mut at: Vec<f64> =
            x.iter().zip(&self.yielded).map(|(x, yielded)| x - yielded).collect();
        let mut reached = next(&at);
        let mut runs = 1;
        while runs < self.most_runs {
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
    use proptest::prelude::*;

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
        let mut near = StretchYielding::default();
        near.comes_near(0.0, yielding.yielded.iter().map(|yielded| 1.02 * yielded));
        let near = near.settle(0.0, &x, next(0.4));
        assert!(near < first, "{near} from nearby, {first} from nothing");
        let mut nearby = yielding.nearby();
        assert_eq!(nearby.settle(0.0, &x, next(0.4 * 1.01)), RUNS_NEARBY);
        let before = yielding.yielded.clone();
        yielding.settle(0.0, &x, next(0.4 * 1.01));
        let apart = |a: &[f64], b: &[f64]| {
            a.iter().zip(b).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
        };
        let (off, changed) =
            (apart(&nearby.yielded, &yielding.yielded), apart(&yielding.yielded, &before));
        assert!(off < 0.05 * changed, "{off} of {changed} mm");
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
