//! Nonlinear least squares within bounds: Levenberg–Marquardt on the normal equations.
//!
//! The step is the minimum of the damped quadratic model within the bounds, found by pinning the
//! coordinates that would leave them, so that a minimum on a bound is reached as fast as one inside.
//! Problems hand over JᵀJ and Jᵀr, never J: memory does not grow with the number of samples.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::watch;

/// A sum of squares to be made small.
pub trait LeastSquares {
    /// Lower and upper bound of each coordinate.
    fn bounds(&self) -> &[(f64, f64)];

    /// Sum of squared residuals at a point within the bounds.
    fn cost(&self, point: &[f64]) -> f64;

    /// Sum of squares with the normal equations at a point within the bounds.
    fn normal(&self, point: &[f64]) -> Normal;

    /// Sum of squares at a point that may turn out worse, with the normal equations where they cost hardly more. The point may be moved
    /// to where it is lower.
    fn tried(&self, point: &mut [f64]) -> (f64, Option<Normal>) {
        (self.cost(point), None)
    }
}

/// The normal equations at a point.
#[derive(Clone, Debug)]
pub struct Normal {
    /// Sum of squared residuals.
    pub cost: f64,
    /// Jᵀr, half the gradient.
    pub gradient: DVector<f64>,
    /// JᵀJ, half the Gauss–Newton curvature.
    pub curvature: DMatrix<f64>,
}

impl Normal {
    /// All zero, for `dimension` coordinates.
    #[must_use]
    pub fn zeros(dimension: usize) -> Self {
        Self {
            cost: 0.0,
            gradient: DVector::zeros(dimension),
            curvature: DMatrix::zeros(dimension, dimension),
        }
    }

    /// Adds others so many times.
    pub fn add_times(&mut self, other: &Self, times: f64) {
        self.cost += times * other.cost;
        self.gradient.axpy(times, &other.gradient, 1.0);
        self.curvature.zip_apply(&other.curvature, |own, other| *own += times * other);
    }

    /// By how much a step raises the sum of squares of the quadratic model; negative where it falls.
    #[must_use]
    pub fn raised_by(&self, step: &DVector<f64>) -> f64 {
        2.0 * self.gradient.dot(step) + step.dot(&(&self.curvature * step))
    }
}

/// Why a search stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The gradient vanished: a minimum.
    Gradient,
    /// The sum of squares stopped falling.
    Cost,
    /// The steps became smaller than the precision of the coordinates.
    Step,
    /// The limit of iterations was reached before a minimum.
    Iterations,
    /// The work was ended from outside.
    Ended,
    /// What was found is no better than a constant.
    NoBetter,
}

impl Stop {
    /// Whether a minimum was reached.
    #[must_use]
    pub fn converged(self) -> bool {
        !matches!(self, Self::Iterations | Self::Ended | Self::NoBetter)
    }
}

impl std::fmt::Display for Stop {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Gradient => "converged: the gradient vanished",
            Self::Cost => "converged: the sum of squares stopped falling",
            Self::Step => "converged: the steps became negligible",
            Self::Iterations => "not converged: the limit of iterations was reached",
            Self::Ended => "not converged: it was ended",
            Self::NoBetter => "not converged: no better than a constant",
        })
    }
}

/// Where a search ended.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The coordinates.
    pub point: Vec<f64>,
    /// The normal equations there.
    pub normal: Normal,
    /// Which coordinates sit on a bound that the data push them against.
    pub at_bound: Vec<bool>,
    /// Why the search stopped.
    pub stop: Stop,
    /// Number of steps tried.
    pub iterations: usize,
}

/// How far a search goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Most steps.
    pub iterations: usize,
    /// Relative fall of the sum of squares that counts as none.
    pub cost: f64,
    /// Damping of the first step, over curvatures of one.
    pub damping: f64,
}

impl Effort {
    /// To the last digits that mean something.
    pub const FULL: Self = Self { iterations: 200, cost: 1e-13, damping: 1e-3 };
    /// The same from close by.
    pub const NEAR: Self = Self { damping: 1e-6, ..Self::FULL };
    /// No step: what is at the start.
    pub const NONE: Self = Self { iterations: 0, ..Self::TRIAL };
    /// A few steps.
    pub const TRIAL: Self = Self { iterations: 4, cost: 1e-5, damping: 1e-3 };
    /// Enough to choose between models.
    pub const QUICK: Self = Self { iterations: 16, cost: 1e-6, damping: 1e-3 };
    /// Enough for a law that is far from straight.
    pub const LONG: Self = Self { iterations: 200, cost: 1e-6, damping: 1e-3 };
}

/// Cosine between the residual and any free column of J at which the gradient counts as vanished.
const GRADIENT_TOLERANCE: f64 = 1e-9;
const STEP_TOLERANCE: f64 = 1e-12;
const MOST_DAMPING: f64 = 1e18;
/// Least damping after a step that went wrong: from less it would go wrong again.
const REJECTED: f64 = 1e-3;
/// Damping of a step that is not to be damped: none but what keeps it defined.
pub(super) const HARDLY: f64 = 1e-12;
/// Damping below which a step is as good as free.
const FREE: f64 = 1e-4;

/// Searches for a minimum from `start`, which is moved into the bounds first.
pub fn minimise(problem: &impl LeastSquares, start: &[f64]) -> Solution {
    minimise_with(problem, start, Effort::FULL)
}

/// Searches from several starts far enough to be compared, and keeps those that may still end lowest, and
/// somewhere else than a better one; the best first. The same whatever the number of threads.
pub fn race<P: LeastSquares + Sync>(problem: &P, starts: &[Vec<f64>]) -> Vec<Solution> {
    watch::stage("starts of the search", starts.len());
    let run = |start: &Vec<f64>| {
        let found = minimise_with(problem, start, Effort::QUICK);
        watch::done();
        found
    };
    let mut runners: Vec<Solution> = starts.par_iter().map(run).collect();
    runners.sort_by(|a, b| a.normal.cost.total_cmp(&b.normal.cost));
    let lead = runners.first().map_or(0.0, |runner| runner.normal.cost);
    runners.retain(|it| !(it.stop.converged() && it.normal.cost > BEATEN * lead));
    joined(Vec::new(), runners)
}

/// Searches in order, those of the first list before the others, and of those that end in the same minimum the first alone.
#[must_use]
pub fn joined(first: Vec<Solution>, others: Vec<Solution>) -> Vec<Solution> {
    let mut kept = first;
    for other in others {
        if !kept.iter().any(|it| it.met_by(&other)) {
            kept.push(other);
        }
    }
    kept
}

/// Takes searches that a race has kept to their end; the lowest. None without one.
pub fn finish<P: LeastSquares + Sync>(problem: &P, kept: &[Solution]) -> Option<Solution> {
    let finish = |runner: &Solution| {
        let found = minimise_with(problem, &runner.point, Effort::NEAR);
        Solution { iterations: runner.iterations + found.iterations, ..found }
    };
    let finished: Vec<Solution> = kept.par_iter().map(finish).collect();
    finished.into_iter().min_by(|a, b| a.normal.cost.total_cmp(&b.normal.cost))
}

/// Part of what a step promises that it gains where the sum of squares is nearly the quadratic one.
const AS_PROMISED: f64 = 0.9;
/// Part of the sum of squares that such a step may promise and be the last: what is left behind it is far less.
const LAST: f64 = 1e-3;

/// The minimum next to `start`, by steps that are not damped: the first small one that gains what it promises leads there, and the normal
/// equations are not asked for again. Where one gains nothing, a search does with limited effort.
#[must_use]
pub fn settle(problem: &impl LeastSquares, start: &[f64], effort: Effort) -> Vec<f64> {
    let bounds = problem.bounds();
    let mut point = start.to_vec();
    for _ in 0..effort.iterations {
        if !watch::step() {
            break;
        }
        let normal = problem.normal(&point);
        let step = bounded_step(&normal, HARDLY, &point, bounds);
        let promised = -normal.raised_by(&step);
        let stepped = point.iter().zip(step.iter()).zip(bounds);
        let mut trial: Vec<f64> =
            stepped.map(|((x, dx), (lower, upper))| (x + dx).clamp(*lower, *upper)).collect();
        let gained = normal.cost - problem.tried(&mut trial).0;
        if gained.is_nan() || gained < 0.0 {
            return minimise_with(problem, &point, effort).point;
        }
        point = trial;
        if promised <= LAST * normal.cost && gained >= AS_PROMISED * promised {
            break;
        }
    }
    point
}

/// A search that has slowed to [`Effort::QUICK`]'s fall in a step and is above this many times the lowest
/// does not catch up in as many steps as [`Effort::FULL`] allows.
const BEATEN: f64 = 1.001;
/// Part of the sum of squares by which the prediction differs where two searches count as met.
const MET: f64 = 1e-4;

impl Solution {
    /// Whether another search has come so close that it ends in the same minimum.
    fn met_by(&self, other: &Self) -> bool {
        let away = DVector::from_iterator(
            self.point.len(),
            self.point.iter().zip(&other.point).map(|(a, b)| b - a),
        );
        away.dot(&(&self.normal.curvature * &away)) <= MET * self.normal.cost
    }
}

/// Searches for a minimum from `start` with limited effort.
pub fn minimise_with(problem: &impl LeastSquares, start: &[f64], effort: Effort) -> Solution {
    watch::search();
    let bounds = problem.bounds();
    let mut point: Vec<f64> =
        start.iter().zip(bounds).map(|(x, (lower, upper))| x.clamp(*lower, *upper)).collect();
    let mut normal = problem.normal(&point);
    let mut damping = effort.damping;
    let mut growth = 2.0;
    let mut iterations = 0;
    let stop = loop {
        if gradient_vanished(&normal, &point, bounds) {
            break Stop::Gradient;
        }
        if iterations >= effort.iterations {
            break Stop::Iterations;
        }
        if !watch::step() {
            break Stop::Ended;
        }
        iterations += 1;
        let step = bounded_step(&normal, damping, &point, bounds);
        if negligible(&step, &point) {
            break Stop::Step;
        }
        let mut trial: Vec<f64> = point
            .iter()
            .zip(step.iter())
            .zip(bounds)
            .map(|((x, dx), (lower, upper))| (x + dx).clamp(*lower, *upper))
            .collect();
        let promised = -normal.raised_by(&step);
        // A free step that promises nothing need not be tried.
        if damping <= FREE && promised <= effort.cost * normal.cost {
            break Stop::Cost;
        }
        let (cost, there) = problem.tried(&mut trial);
        let gained = normal.cost - cost;
        tracing::trace!(
            "step {iterations}: damping {damping:.1e}, sum of squares {:.9e}, gained {gained:.3e} of {promised:.3e}",
            normal.cost
        );
        if gained > 0.0 {
            let ratio = gained / promised.max(f64::MIN_POSITIVE);
            let stalled =
                gained <= effort.cost * normal.cost && promised <= effort.cost * normal.cost;
            point = trial;
            normal = there.unwrap_or_else(|| problem.normal(&point));
            if stalled {
                break Stop::Cost;
            }
            damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).clamp(1.0 / 10.0, 2.0);
            growth = 2.0;
        } else {
            if promised.abs() <= effort.cost * normal.cost {
                break Stop::Cost;
            }
            damping = (damping * growth).max(REJECTED);
            growth *= 2.0;
        }
        damping = damping.max(1e-12);
    };
    let at_bound = (0..point.len()).map(|j| pushed(&normal, &point, bounds, j)).collect();
    Solution { point, normal, at_bound, stop, iterations }
}

/// Whether coordinate `j` has no range, or sits on a bound and the sum of squares would fall beyond it.
fn pushed(normal: &Normal, point: &[f64], bounds: &[(f64, f64)], j: usize) -> bool {
    let (lower, upper) = bounds[j];
    lower >= upper
        || (point[j] <= lower && normal.gradient[j] >= 0.0)
        || (point[j] >= upper && normal.gradient[j] <= 0.0)
}

fn gradient_vanished(normal: &Normal, point: &[f64], bounds: &[(f64, f64)]) -> bool {
    (0..point.len()).all(|j| {
        let size = (normal.curvature[(j, j)] * normal.cost).sqrt();
        pushed(normal, point, bounds, j) || normal.gradient[j].abs() <= GRADIENT_TOLERANCE * size
    })
}

fn negligible(step: &DVector<f64>, point: &[f64]) -> bool {
    step.iter().zip(point).all(|(dx, x)| dx.abs() <= STEP_TOLERANCE * (x.abs() + STEP_TOLERANCE))
}

/// The minimum of the damped quadratic model within the bounds.
pub(super) fn bounded_step(
    normal: &Normal,
    damping: f64,
    point: &[f64],
    bounds: &[(f64, f64)],
) -> DVector<f64> {
    bounded_step_of(0..point.len(), normal, damping, point, bounds)
}

/// The same where only some coordinates move.
pub(super) fn bounded_step_of(
    moving: impl Iterator<Item = usize>,
    normal: &Normal,
    damping: f64,
    point: &[f64],
    bounds: &[(f64, f64)],
) -> DVector<f64> {
    let mut step = DVector::zeros(point.len());
    let mut free: Vec<usize> = moving.filter(|&j| !pushed(normal, point, bounds, j)).collect();
    while !free.is_empty() {
        let inner = free_step(normal, damping, &free, &step);
        let violated = |&(place, j): &(usize, usize)| {
            let reached = point[j] + inner[place];
            reached < bounds[j].0 || reached > bounds[j].1
        };
        let outside: Vec<(usize, usize)> =
            free.iter().copied().enumerate().filter(violated).collect();
        if outside.is_empty() {
            for (place, &j) in free.iter().enumerate() {
                step[j] = inner[place];
            }
            break;
        }
        for &(place, j) in &outside {
            let (lower, upper) = bounds[j];
            step[j] = (point[j] + inner[place]).clamp(lower, upper) - point[j];
        }
        free.retain(|j| outside.iter().all(|(_, pinned)| pinned != j));
    }
    step
}

/// Solves for the free coordinates, the others moving by `step`.
fn free_step(normal: &Normal, damping: f64, free: &[usize], step: &DVector<f64>) -> DVector<f64> {
    let size = free.len();
    // In units where the diagonal is one, so that units of the coordinates do not matter.
    let scale = DVector::from_fn(size, |k, _| {
        let curvature = normal.curvature[(free[k], free[k])];
        if curvature > 0.0 { curvature.sqrt() } else { 1.0 }
    });
    let moved = &normal.curvature * step;
    let slope =
        DVector::from_fn(size, |k, _| -(normal.gradient[free[k]] + moved[free[k]]) / scale[k]);
    let mut damping = damping;
    loop {
        let matrix = DMatrix::from_fn(size, size, |i, j| {
            let entry = normal.curvature[(free[i], free[j])] / (scale[i] * scale[j]);
            if i == j { entry + damping } else { entry }
        });
        if let Some(factor) = matrix.cholesky() {
            return factor.solve(&slope).component_div(&scale);
        }
        damping = (damping * 10.0).max(1e-12);
        // No damping makes a matrix with a value that is no number definite: stay where it is.
        if damping > MOST_DAMPING {
            return DVector::zeros(size);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Residuals A e^(−vt) − y, in A and v.
    struct Decay {
        bounds: Vec<(f64, f64)>,
        data: Vec<(f64, f64)>,
    }

    impl LeastSquares for Decay {
        fn bounds(&self) -> &[(f64, f64)] {
            &self.bounds
        }
        fn cost(&self, point: &[f64]) -> f64 {
            self.normal(point).cost
        }
        fn normal(&self, point: &[f64]) -> Normal {
            let mut normal = Normal::zeros(2);
            for &(t, y) in &self.data {
                let decay = (-point[1] * t).exp();
                let residual = point[0] * decay - y;
                let row = DVector::from_vec(vec![decay, -point[0] * t * decay]);
                normal.cost += residual * residual;
                normal.gradient += &row * residual;
                normal.curvature += &row * row.transpose();
            }
            normal
        }
    }

    fn decay(amplitude: f64, rate: f64, bounds: [(f64, f64); 2]) -> Decay {
        let data = (0..100)
            .map(|k| f64::from(k) * 0.02)
            .map(|t| (t, amplitude * (-rate * t).exp()))
            .collect();
        Decay { bounds: bounds.to_vec(), data }
    }

    /// x⁴ − 2x² + x/4 as a sum of squares, with minima near 1 and −1, counted.
    #[derive(Default)]
    struct TwoValleys {
        evaluations: std::sync::atomic::AtomicUsize,
    }

    impl LeastSquares for TwoValleys {
        fn bounds(&self) -> &[(f64, f64)] {
            &[(-3.0, 3.0)]
        }
        fn cost(&self, point: &[f64]) -> f64 {
            self.normal(point).cost
        }
        fn normal(&self, point: &[f64]) -> Normal {
            self.evaluations.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            let x = point[0];
            let mut normal = Normal::zeros(1);
            for (residual, slope) in [(x * x - 1.0, 2.0 * x), (0.1 * (x + 3.0), 0.1)] {
                normal.cost += residual * residual;
                normal.gradient[0] += slope * residual;
                normal.curvature[(0, 0)] += slope * slope;
            }
            normal
        }
    }

    #[test]
    fn a_race_ends_where_the_best_of_all_starts_does_with_fewer_evaluations() {
        let starts: Vec<Vec<f64>> = [2.9, 1.5, 0.6, -0.4, -2.0, -2.9].map(|x| vec![x]).to_vec();
        let (raced, alone) = (TwoValleys::default(), TwoValleys::default());
        let found = finish(&raced, &race(&raced, &starts)).unwrap();
        let each = starts.iter().map(|start| minimise(&alone, start));
        let best = each.min_by(|a, b| a.normal.cost.total_cmp(&b.normal.cost)).unwrap();
        assert!((found.point[0] - best.point[0]).abs() < 1e-8, "{found:?}");
        assert!(found.point[0] < 0.0 && found.stop.converged());
        let count = |problem: TwoValleys| problem.evaluations.into_inner();
        let (raced, alone) = (count(raced), count(alone));
        assert!(raced < alone, "{raced} for {alone}");
        assert!(race(&TwoValleys::default(), &[]).is_empty());
    }

    #[test]
    fn from_close_by_a_minimum_is_settled_in_without_normal_equations_there() {
        /// What no decay describes.
        const NOISE: f64 = 1.0;
        struct Counted(Decay, std::cell::Cell<usize>);
        impl LeastSquares for Counted {
            fn bounds(&self) -> &[(f64, f64)] {
                self.0.bounds()
            }
            fn cost(&self, point: &[f64]) -> f64 {
                NOISE + self.0.cost(point)
            }
            fn normal(&self, point: &[f64]) -> Normal {
                self.1.set(self.1.get() + 1);
                let normal = self.0.normal(point);
                Normal { cost: NOISE + normal.cost, ..normal }
            }
        }
        let counted = |start: [f64; 2]| {
            let problem = Counted(decay(3.0, 2.0, WIDE), Default::default());
            let found = settle(&problem, &start, Effort::QUICK);
            (found, problem.1.get())
        };
        let (near, asked) = counted([3.001, 2.002]);
        assert!((near[0] - 3.0).abs() < 1e-5 && (near[1] - 2.0).abs() < 1e-5, "{near:?}");
        assert_eq!(asked, 1);
        let (far, _) = counted([0.5, 20.0]);
        assert!((far[0] - 3.0).abs() < 1e-3 && (far[1] - 2.0).abs() < 1e-3, "{far:?}");
    }

    #[test]
    fn a_coordinate_without_a_range_is_held_wherever_it_stands() {
        let mut normal = Normal::zeros(1);
        for (point, gradient) in [(1.9, 1.0), (1.9, -1.0), (2.0, 1.0), (2.1, -1.0), (2.1, 1.0)] {
            normal.gradient[0] = gradient;
            assert!(pushed(&normal, &[point], &[(2.0, 2.0)], 0), "{point}, {gradient}");
        }
    }

    const WIDE: [(f64, f64); 2] = [(-100.0, 100.0), (0.0, 100.0)];

    /// The decay with its coordinates in other units.
    struct InUnits(Decay, [f64; 2], Vec<(f64, f64)>);

    impl LeastSquares for InUnits {
        fn bounds(&self) -> &[(f64, f64)] {
            &self.2
        }
        fn cost(&self, point: &[f64]) -> f64 {
            self.normal(point).cost
        }
        fn normal(&self, point: &[f64]) -> Normal {
            let units = DVector::from_row_slice(&self.1);
            let mut normal = self.0.normal(&[point[0] * units[0], point[1] * units[1]]);
            normal.gradient.component_mul_assign(&units);
            normal.curvature.component_mul_assign(&(&units * units.transpose()));
            normal
        }
    }

    #[test]
    fn units_of_the_coordinates_do_not_matter() {
        let alone = minimise(&decay(3.0, 2.0, WIDE), &[1.0, 0.5]);
        let units = [1e10, 1e-14];
        let bounds = WIDE.iter().zip(units).map(|((low, high), unit)| (low / unit, high / unit));
        let problem = InUnits(decay(3.0, 2.0, WIDE), units, bounds.collect());
        let found = minimise(&problem, &[1.0 / units[0], 0.5 / units[1]]);
        for (k, unit) in units.into_iter().enumerate() {
            let off = found.point[k] * unit / alone.point[k] - 1.0;
            assert!(off.abs() < 1e-9, "coordinate {k}: {} from {}", found.point[k], alone.point[k]);
        }
    }

    #[test]
    fn a_function_that_is_no_number_ends_the_search() {
        struct Broken;
        impl LeastSquares for Broken {
            fn bounds(&self) -> &[(f64, f64)] {
                &[(0.0, 1.0), (0.0, 1.0)]
            }

            fn cost(&self, _: &[f64]) -> f64 {
                f64::NAN
            }

            fn normal(&self, _: &[f64]) -> Normal {
                let mut normal = Normal::zeros(2);
                normal.cost = f64::NAN;
                normal.gradient.fill(f64::NAN);
                normal.curvature.fill(f64::NAN);
                normal
            }
        }
        assert_eq!(minimise(&Broken, &[0.5, 0.5]).point, [0.5, 0.5]);
    }

    proptest! {
        #[test]
        fn finds_the_exact_answer_from_afar(
            amplitude in 0.1f64..10.0,
            rate in 0.1f64..10.0,
            start in (0.01f64..20.0, 0.01f64..10.0),
        ) {
            let found = minimise(&decay(amplitude, rate, WIDE), &[start.0, start.1]);
            prop_assert!(found.stop.converged(), "{:?}", found.stop);
            prop_assert!((found.point[0] - amplitude).abs() < 1e-6 * amplitude);
            prop_assert!((found.point[1] - rate).abs() < 1e-6 * rate);
        }

        #[test]
        fn a_minimum_on_a_bound_is_found_and_named(limit in 0.2f64..2.0) {
            let found = minimise(&decay(1.0, 3.0, [(-100.0, 100.0), (0.0, limit)]), &[5.0, 0.1]);
            prop_assert!(found.stop.converged());
            prop_assert_eq!(found.point[1], limit);
            prop_assert_eq!(&found.at_bound, &[false, true]);
            // The free amplitude is the best one for that rate.
            let size = (found.normal.curvature[(0, 0)] * found.normal.cost).sqrt();
            prop_assert!(found.normal.gradient[0].abs() < 1e-6 * size);
        }
    }

    #[test]
    fn a_coordinate_without_influence_does_no_harm() {
        let found = minimise(&decay(0.0, 1.0, WIDE), &[0.0, 1.0]);
        assert!(found.stop.converged());
        assert_eq!(found.point[0], 0.0);
    }
}
