//! A set-up that yields under the force, so that less of the commanded motion reaches the specimen.

/// A stretch over which a set-up is to settle.
pub trait Settling {
    /// Where the set-up comes to, mm, at each sample under the force at these compressions, mm.
    fn next(&mut self, at: &[f64]) -> Vec<f64>;

    /// How far, mm, each sample is to move where so much, mm, is open, with what happened before and moves as well; none where that is
    /// not known. It may be taken from before, or `anew` where the compressions are those of the last call.
    fn moves(&mut self, rest: &[f64], anew: bool) -> Option<Vec<f64>>;
}

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

/// The same for a whole stretch at once, where what happens at one sample depends on those before: along a tangent with what happened
/// before, or secants at every sample. It remembers where the last stretch came to, as most runs of a fit come to nearly the same.
#[derive(Clone, Debug)]
pub struct StretchYielding {
    /// Time of the stretch's first sample, s.
    start: f64,
    yielded: Vec<f64>,
    slope: Vec<f64>,
    /// Whether little has changed since: what is open then is followed, not to the end.
    nearby: bool,
    /// Whether the last stretch was given up before all its samples had settled.
    is_open: bool,
    /// Whether the next stretch is the last one again, to be left where it is.
    stays: bool,
}

impl Default for StretchYielding {
    fn default() -> Self {
        let (yielded, slope) = (Vec::new(), Vec::new());
        Self { start: 0.0, yielded, slope, nearby: false, is_open: false, stays: false }
    }
}

/// Largest part of the compressions of a stretch that is left open, mm.
const STRETCH_SETTLED: f64 = 1e-10;
/// Most runs over a stretch: some ten settle nearly every one, a hundred a joint that closes at once under a specimen that relaxes.
const MOST_RUNS: usize = 150;
/// Runs from which on the first sample that is open must move on as fast as it has to, to be through after the most: where samples
/// settle more slowly than that, they never do.
const FREE_RUNS: usize = 24;
/// Runs within which what is open in all must halve: where it does, all settles soon, however slow the first sample is.
const PATIENCE: usize = 12;
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
        Self { nearby: true, stays: false, ..self.clone() }
    }

    /// The next run is over the last stretch with the same numbers: it stays where it came to.
    pub const fn stay(&mut self) {
        self.stays = true;
    }

    /// Whether the next run stays where the last stretch came to.
    #[must_use]
    pub const fn stays(&self) -> bool {
        self.stays
    }

    /// Whether little has changed since the stretch settled.
    #[must_use]
    pub const fn is_nearby(&self) -> bool {
        self.nearby
    }

    /// Whether the last stretch was given up before all its samples had settled.
    #[must_use]
    pub const fn is_open(&self) -> bool {
        self.is_open
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

    /// Finds the compressions, mm, of a stretch that begins at `start`, s, at the commanded ones, x, mm: the last run over the stretch is
    /// at those found. The number of runs.
    pub fn settle(&mut self, start: f64, x: &[f64], stretch: &mut impl Settling) -> usize {
        if !self.knows(start, x.len()) {
            self.comes_near(start, x.iter().map(|_| 0.0));
        }
        let mut at: Vec<f64> =
            x.iter().zip(&self.yielded).map(|(x, yielded)| x - yielded).collect();
        // What comes after the first that is open follows it, so that it alone is known to lie between two.
        let (mut first, mut between) = (0, Between::default());
        let mut jumps: Vec<bool> =
            self.slope.iter().map(|slope| self.nearby && *slope >= JUMP).collect();
        let mut rest = left_open(stretch, &at, &jumps);
        let most = rest.iter().fold(0.0, |most: f64, rest| most.max(rest.abs()));
        let (settled, most_runs) = match self.nearby {
            true => (STRETCH_SETTLED.max(NEARBY * most), RUNS_NEARBY),
            false if std::mem::take(&mut self.stays) => (f64::INFINITY, 1),
            false => (STRETCH_SETTLED, MOST_RUNS),
        };
        let open = |rest: &f64| rest.abs() > settled || rest.is_nan();
        let mut runs = 1;
        let mut along = Along::Tangent;
        let (mut least, mut since) = (f64::INFINITY, runs);
        let mut in_all = total(&rest);
        while runs < most_runs {
            let Some(now) = rest.iter().position(open).filter(|&k| rest[k].is_finite()) else {
                break;
            };
            if in_all <= 0.5 * least {
                (least, since) = (in_all, runs);
            }
            if runs - since > PATIENCE
                && runs > FREE_RUNS
                && now * MOST_RUNS < (runs - FREE_RUNS) * x.len()
            {
                break;
            }
            if first != now {
                (first, between) = (now, Between::default());
            }
            let moves = match along {
                Along::Secants => None,
                _ => stretch.moves(&rest, along == Along::NewTangent),
            };
            let all = moves.unwrap_or_else(|| {
                rest.iter().zip(&self.slope).map(|(rest, slope)| -rest / slope).collect()
            });
            let mut moved: Vec<f64> =
                (0..x.len()).map(|k| if jumps[k] { at[k] } else { at[k] + all[k] }).collect();
            moved[now] = between.follow(at[now], rest[now], moved[now]);
            if between.is_jump() {
                jumps[now] = true;
                moved[now] = at[now];
            }
            let left = left_open(stretch, &moved, &jumps);
            runs += 1;
            let left_in_all = total(&left);
            along = along.after(left_in_all / in_all);
            in_all = left_in_all;
            for (k, slope) in self.slope.iter_mut().enumerate() {
                // More force never lets a set-up yield less.
                let secant = (left[k] - rest[k]) / (moved[k] - at[k]);
                if secant.is_finite() && rest[k].abs() > settled {
                    *slope = secant.clamp(1.0, STEEPEST);
                }
            }
            (at, rest) = (moved, left);
        }
        self.is_open = !self.nearby && rest.iter().any(open);
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

/// How samples move.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Along {
    /// With what happened before, along a tangent that is known.
    Tangent,
    /// The same along a tangent where the samples are.
    NewTangent,
    /// Each by itself, along its secant: slower where what happened before counts, but to be trusted from afar.
    Secants,
}

/// Part of what is open that a run may leave and be fast: from there on a tangent is taken anew, and secants give way to one.
const FAST: f64 = 0.1;
/// Part of what is open from which on a run along a tangent is too slow.
const SLOW: f64 = 0.8;

impl Along {
    /// How to move after a run that left this part of what was open.
    const fn after(self, part: f64) -> Self {
        match self {
            Self::Secants if part <= FAST => Self::Secants,
            Self::Secants => Self::NewTangent,
            Self::Tangent | Self::NewTangent if part <= FAST => Self::Tangent,
            Self::Tangent | Self::NewTangent if part <= SLOW => Self::NewTangent,
            Self::Tangent | Self::NewTangent => Self::Secants,
        }
    }
}

/// How much, mm, is open in all.
fn total(rest: &[f64]) -> f64 {
    rest.iter().map(|rest| rest.abs()).sum()
}

/// How much, mm, is open at each sample at these compressions, mm: nothing where the force jumps, as nothing comes to rest there.
fn left_open(stretch: &mut impl Settling, at: &[f64], jumps: &[bool]) -> Vec<f64> {
    let open = at.iter().zip(stretch.next(at)).zip(jumps);
    open.map(|((z, to), jumps)| if *jumps { 0.0 } else { z - to }).collect()
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

    /// A stretch of which nothing is known but where it comes to.
    impl<F: FnMut(&[f64]) -> Vec<f64>> Settling for F {
        fn next(&mut self, at: &[f64]) -> Vec<f64> {
            self(at)
        }

        fn moves(&mut self, _: &[f64], _: bool) -> Option<Vec<f64>> {
            None
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
        let first = yielding.settle(0.0, &x, &mut next(0.4));
        let again = yielding.settle(0.0, &x, &mut next(0.4 * (1.0 + 1e-6)));
        assert!(first <= 9 && again < first, "{first}, then {again}");
        let mut near = StretchYielding::default();
        near.comes_near(0.0, yielding.yielded.iter().map(|yielded| 1.02 * yielded));
        let near = near.settle(0.0, &x, &mut next(0.4));
        assert!(near < first, "{near} from nearby, {first} from nothing");
        let mut nearby = yielding.nearby();
        let runs = nearby.settle(0.0, &x, &mut next(0.4 * 1.01));
        assert!(runs <= RUNS_NEARBY, "{runs}");
        let before = yielding.yielded.clone();
        yielding.settle(0.0, &x, &mut next(0.4 * 1.01));
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
        let runs = StretchYielding::default().settle(0.0, &x, &mut |z: &[f64]| {
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
