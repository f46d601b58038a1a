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
    /// Whether little has changed since: what is open then is followed, not to the end.
    nearby: bool,
}

impl Default for StretchYielding {
    fn default() -> Self {
        Self { start: 0.0, yielded: Vec::new(), slope: Vec::new(), nearby: false }
    }
}

/// Largest part of the compressions of a stretch that is left open, mm.
const STRETCH_SETTLED: f64 = 1e-10;
/// Most runs over a stretch: some ten settle nearly every one, a hundred a joint that closes at once under a specimen that relaxes.
const MOST_RUNS: usize = 150;
/// Runs from which on the first sample that is open must move on as fast as it has to, to be through after the most: where samples
/// settle more slowly than that, they never do.
const FREE_RUNS: usize = 24;
/// Steepest slope of what is open over the compression that a secant tells: what happened before moves a sample too, and beside a step of
/// nothing that is no slope.
const STEEPEST: f64 = 100.0;
/// Part of what a small change leaves open that may stay so, and most runs that follow it.
const NEARBY: f64 = 0.01;
const RUNS_NEARBY: usize = 4;

impl StretchYielding {
    /// The same for stretches where little has changed since: that is followed to a hundredth, not until all is settled.
    #[must_use]
    pub fn nearby(&self) -> Self {
        Self { nearby: true, ..self.clone() }
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
        self.nearby = false;
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
        let mut open_at =
            |at: &[f64]| -> Vec<f64> { at.iter().zip(next(at)).map(|(z, to)| z - to).collect() };
        let mut rest = open_at(&at);
        // What comes after the first that is open follows it, so that it alone is known to lie between two.
        let (mut first, mut between) = (0, Between::default());
        let mut jumps: Vec<bool> =
            self.slope.iter().map(|slope| self.nearby && *slope >= JUMP).collect();
        let most = rest.iter().fold(0.0, |most: f64, rest| most.max(rest.abs()));
        let (settled, most_runs) = match self.nearby {
            true => (STRETCH_SETTLED.max(NEARBY * most), RUNS_NEARBY),
            false => (STRETCH_SETTLED, MOST_RUNS),
        };
        let mut runs = 1;
        while runs < most_runs {
            let open = |k: &usize| !jumps[*k] && (rest[*k].abs() > settled || rest[*k].is_nan());
            let Some(now) = (0..x.len()).find(open).filter(|&k| rest[k].is_finite()) else { break };
            if runs > FREE_RUNS && now * MOST_RUNS < (runs - FREE_RUNS) * x.len() {
                break;
            }
            if first != now {
                (first, between) = (now, Between::default());
            }
            let mut moved: Vec<f64> = (0..x.len())
                .map(|k| if jumps[k] { at[k] } else { at[k] - rest[k] / self.slope[k] })
                .collect();
            moved[now] = between.follow(at[now], rest[now], moved[now]);
            if between.is_jump() {
                jumps[now] = true;
                moved[now] = at[now];
            }
            let left = open_at(&moved);
            runs += 1;
            for (k, slope) in self.slope.iter_mut().enumerate() {
                // More force never lets a set-up yield less.
                let secant = (left[k] - rest[k]) / (moved[k] - at[k]);
                if secant.is_finite() {
                    *slope = secant.clamp(1.0, STEEPEST);
                }
            }
            (at, rest) = (moved, left);
        }
        for (k, z) in at.iter().enumerate() {
            self.yielded[k] = x[k] - z;
            if jumps[k] {
                // So that the next secant leads just across it.
                self.slope[k] = JUMP;
            }
        }
        runs
    }
}

/// Two compressions, mm, between which a sample comes to rest, so far as is known, and how much, mm, is open at each: secants that
/// cross a touch again and again are halved.
#[derive(Clone, Copy)]
struct Between {
    below: (f64, f64),
    above: (f64, f64),
}

/// Slope, times that of the compression, from which on the force jumps: nothing comes to rest there.
const JUMP: f64 = 1000.0;
/// Compressions, mm, on either side of the touch that tell whether the force jumps there.
const TOUCH: f64 = 1e-6;
/// Least, mm, that is open on either side of a jump.
const LEAST_JUMP: f64 = 1e-6;

impl Default for Between {
    fn default() -> Self {
        Self { below: (f64::NEG_INFINITY, 0.0), above: (f64::INFINITY, 0.0) }
    }
}

impl Between {
    /// Whether the force jumps where the sample would come to rest: it stays there.
    fn is_jump(&self) -> bool {
        let across = self.above.1 - self.below.1;
        across > LEAST_JUMP && across > JUMP * (self.above.0 - self.below.0)
    }

    /// Where to go, mm, from `z`, where so much, mm, is open, and a secant leads to `to`: there, or half-way to what is known to be too far.
    fn follow(&mut self, z: f64, open: f64, to: f64) -> f64 {
        let (own, far) = match open < 0.0 {
            true => (&mut self.below, self.above.0),
            false => (&mut self.above, self.below.0),
        };
        *own = (z, open);
        let within = if open < 0.0 { to < far } else { to > far };
        let across_touch = z * far < 0.0 && z.abs() > TOUCH;
        match within || to == z {
            true => to,
            // Most jumps are at the touch.
            false if across_touch => TOUCH.copysign(if far.abs() > TOUCH { far } else { z }),
            false => 0.5 * (z + far),
        }
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
        let runs = nearby.settle(0.0, &x, next(0.4 * 1.01));
        assert!(runs <= RUNS_NEARBY, "{runs}");
        let before = yielding.yielded.clone();
        yielding.settle(0.0, &x, next(0.4 * 1.01));
        let apart = |a: &[f64], b: &[f64]| {
            a.iter().zip(b).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
        };
        let (off, changed) =
            (apart(&nearby.yielded, &yielding.yielded), apart(&yielding.yielded, &before));
        assert!(off < 0.02 * changed, "{off} of {changed} mm");
    }

    /// A specimen that relaxes and is touched again and again, pressed by a joint that closes: where each sample comes to, and whether
    /// all settle.
    fn touched(stiffness: f64, compliance: f64, closing: f64, speed: f64) -> (usize, f64) {
        let x: Vec<f64> = (0..400).map(|k| 4.0 * (speed * f64::from(k)).sin() + 0.5).collect();
        let next = |z: &[f64]| {
            let mut late = 0.0;
            let reach = |(x, z): (&f64, &f64)| {
                let elastic = stiffness * z.max(0.0).powf(1.4);
                late += 0.1 * (elastic - late);
                x + compliance * (-(elastic - 0.5 * late).max(0.0) / closing).exp_m1()
            };
            x.iter().zip(z).map(reach).collect::<Vec<_>>()
        };
        let mut last = (Vec::new(), Vec::new());
        let runs = StretchYielding::default().settle(0.0, &x, |z| {
            last = (z.to_vec(), next(z));
            last.1.clone()
        });
        let open =
            last.0.iter().zip(&last.1).fold(0.0, |most: f64, (z, to)| most.max((z - to).abs()));
        (runs, open)
    }

    #[test]
    fn a_stretch_settles_in_a_joint_that_closes_at_once() {
        let cases = [
            (2.387202571335013, 0.595977020828508, 0.1, 0.01),
            (2.410293622929712, 0.4842038089250891, 0.10571072631926412, 0.1535002472300694),
            // Where secants beside what happened before have no slope.
            (2.5608682611611435, 0.46487067518859754, 0.11583645308469645, 0.02812925862623141),
        ];
        for (stiffness, compliance, closing, speed) in cases {
            let (runs, open) = touched(stiffness, compliance, closing, speed);
            assert!(open <= STRETCH_SETTLED, "{open} mm are open after {runs} runs");
        }
    }

    proptest! {
        #[test]
        fn a_stretch_settles_across_touches(
            stiffness in 0.05f64..3.0,
            compliance in 0.01f64..0.6,
            closing in 0.1f64..2.0,
            speed in 0.01f64..0.3,
        ) {
            let (runs, open) = touched(stiffness, compliance, closing, speed);
            prop_assert!(open <= STRETCH_SETTLED, "{open} mm are open after {runs} runs");
        }

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
