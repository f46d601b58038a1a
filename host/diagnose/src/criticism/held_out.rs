//! Errors on traces left out of the fit.
//!
//! Every trace in turn is predicted by a fit to the others; where there are many, those of a fold in turn by a fit to all outside
//! it. One Gauss–Newton step from the fit to all leads there where the model is nearly straight over that step; where the sum of
//! squares over the other traces is not what the step foretells, they are refitted in earnest. What a trace has of its own (its
//! zero, the phase of a hum) is taken from what it shows before its touch, as a user would.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::fitted::Fitted;
use palpate_fit::fold::Fold;
use palpate_fit::least_squares::{Effort, LeastSquares, minimise_with};
use palpate_fit::problem::{Apart, Problem};
use palpate_fit::remembering::Remembering;

/// Errors of a model on traces that it was not fitted to.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldOut {
    /// Root mean square error over all samples, in the unit of the signal.
    pub rms: f64,
    /// Mean square error of each trace, in the squared unit of the signal.
    pub squares: Vec<f64>,
    /// Sum of squares of each trace's whitened residual, in variances of the noise.
    pub whitened: Vec<f64>,
    /// Part of the mean square that the uncertainty of the fits to the other traces explains, in the squared unit of
    /// the signal: where few traces determine a parameter, each is predicted the worse for it, by a law that is right. At most what
    /// the error on traces left out exceeds that of the fit to all by.
    pub by_uncertainty: f64,
}

/// What a model gains over another on traces left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain {
    /// Mean over the traces.
    pub mean: f64,
    /// Its standard error over the traces.
    pub standard_error: f64,
}

impl HeldOut {
    /// What this model gains over another in squares of the whitened residual: for data that a law
    /// describes to the noise.
    #[must_use]
    pub fn gain_in_noise(&self, other: &Self) -> Gain {
        Gain::of(&other.whitened, &self.whitened)
    }

    /// The same over the rows of the recordings, where the model is fitted to means that stand for them: the squared error of the fit
    /// over the rows of each trace exceeds that over their means by what leaving traces out does not change.
    #[must_use]
    pub fn over_rows(mut self, means: &Problem, fitted: &Fitted, rows: &[(f64, usize)]) -> Self {
        let on_means = means.with_chain(&fitted.chain).trace_squares(&fitted.point);
        let mut total = 0.0;
        for ((square, (rows, count)), (means, _)) in self.squares.iter_mut().zip(rows).zip(on_means)
        {
            let count = (*count as f64).max(1.0);
            let sum = (*square * count + (rows - means)).max(0.0);
            *square = sum / count;
            total += sum;
        }
        let count: usize = rows.iter().map(|(_, count)| count).sum();
        self.rms = (total / (count as f64).max(1.0)).sqrt();
        self
    }

    /// Whether a model predicts worse than this by more than so many standard errors, whatever refits without traces would tell: fitted to
    /// all it leaves as much more already.
    #[must_use]
    pub fn surely_beats(&self, fitted: &Fitted, standard_errors: f64) -> bool {
        let several = fitted.blocks.iter().any(|block| block.trace > 0);
        let mut sums = vec![(0.0, 0.0); self.squares.len()];
        for (index, block) in fitted.blocks.iter().enumerate() {
            if let Some((square, count)) = sums.get_mut(if several { block.trace } else { index }) {
                *square += block.raw.cost;
                *count += block.samples as f64;
            }
        }
        let left: Vec<f64> = sums.iter().map(|(square, count)| square / count.max(1.0)).collect();
        Gain::of(&left, &self.squares).exceeds(standard_errors)
    }

    /// What this model gains over another in mean squares of the error of each trace.
    #[must_use]
    pub fn gain(&self, other: &Self) -> Gain {
        Gain::of(&other.squares, &self.squares)
    }
}

impl Gain {
    fn of(before: &[f64], after: &[f64]) -> Self {
        let gains: Vec<f64> =
            before.iter().zip(after).map(|(before, after)| before - after).collect();
        let count = gains.len() as f64;
        let mean = gains.iter().sum::<f64>() / count;
        let squares = gains.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>();
        Self { mean, standard_error: (squares / (count - 1.0) / count).sqrt() }
    }

    /// Whether the gain is larger than this many of its standard errors.
    #[must_use]
    pub fn exceeds(&self, standard_errors: f64) -> bool {
        self.mean > standard_errors * self.standard_error
    }
}

/// Excess over the foretold sum of squares, in variances of the residual, up to which one step counts
/// as a refit.
const SAME: f64 = 1.0;
/// Change of the prediction by one step, over the residual, up to which nothing need be predicted anew.
const SMALL: f64 = 0.01;

/// Errors of a fitted model on every trace when it is left out, refitted to the others in earnest where
/// one step does not do; none for a single trace.
#[must_use]
pub fn held_out(problem: &Problem, fitted: &Fitted) -> Option<HeldOut> {
    held_out_with(problem, fitted, true, None)
}

/// The same over all `rows` of the recordings, where the data that the model is fitted to are their means.
#[must_use]
pub fn held_out_on(problem: &Problem, fitted: &Fitted, rows: &Problem) -> Option<HeldOut> {
    held_out_with(problem, fitted, true, Some(rows))
}

/// The same with one step in place of every refit.
#[must_use]
pub fn held_out_in_one_step(problem: &Problem, fitted: &Fitted) -> Option<HeldOut> {
    held_out_with(problem, fitted, false, None)
}

/// Errors on sections of the data, each left out of the fit in turn, in one step from the fit to all and
/// as the straight line of that step foretells: for a single trace, whose sections share what the specimen
/// remembers.
#[must_use]
pub fn over_sections(problem: &Problem, fitted: &Fitted) -> HeldOut {
    let squares_without = |left_out: usize| -> (f64, f64) {
        let weights: Vec<f64> =
            (0..fitted.blocks.len()).map(|block| f64::from(u8::from(block != left_out))).collect();
        let step = fitted.step(&fitted.weighted(problem, &weights), &[]);
        fitted.blocks[left_out].foretold(&step)
    };
    let sums: Vec<(f64, f64)> = (0..fitted.blocks.len()).map(squares_without).collect();
    let count = |block: usize| (fitted.blocks[block].samples as f64).max(1.0);
    let total: f64 = sums.iter().map(|(raw, _)| raw).sum();
    HeldOut {
        rms: (total / (fitted.samples as f64).max(1.0)).sqrt(),
        squares: sums.iter().enumerate().map(|(block, (raw, _))| raw / count(block)).collect(),
        whitened: sums.into_iter().map(|(_, white)| white).collect(),
        by_uncertainty: 0.0,
    }
}

fn held_out_with(
    problem: &Problem,
    fitted: &Fitted,
    in_earnest: bool,
    rows: Option<&Problem>,
) -> Option<HeldOut> {
    let traces = 1 + fitted.blocks.iter().map(|block| block.trace).max()?;
    if traces < 2 {
        return None;
    }
    let problem = problem.with_chain(&fitted.chain);
    let rows = rows.map(|rows| rows.with_chain(&fitted.chain));
    let folds = Fold::all(traces);
    let of_folds: Vec<Vec<TraceError>> = folds
        .par_iter()
        .map(|fold| left_out(&problem, fitted, *fold, in_earnest, rows.as_ref()))
        .collect();
    let mut errors = vec![TraceError::default(); traces];
    for (fold, found) in folds.iter().zip(of_folds) {
        for (trace, error) in fold.traces(traces).zip(found) {
            errors[trace] = error;
        }
    }
    let total: f64 = errors.iter().map(|error| error.square).sum();
    let samples: f64 = errors.iter().map(|error| error.samples).sum();
    let mean_square = total / samples.max(1.0);
    // Of parameters that hardly show, the straight line foretells more than there is.
    let rises = (mean_square - fitted.rms().powi(2)).max(0.0);
    let uncertain = errors.iter().map(|error| error.by_uncertainty).sum::<f64>();
    Some(HeldOut {
        rms: mean_square.sqrt(),
        squares: errors.iter().map(|error| error.square / error.samples.max(1.0)).collect(),
        whitened: errors.iter().map(|error| error.whitened).collect(),
        by_uncertainty: (uncertain / samples.max(1.0)).min(rises),
    })
}

/// Sums over one trace.
#[derive(Clone, Copy, Debug, Default)]
struct TraceError {
    square: f64,
    whitened: f64,
    by_uncertainty: f64,
    samples: f64,
}

/// The errors on the traces of a fold by a fit to the others.
fn left_out(
    problem: &Problem,
    fitted: &Fitted,
    fold: Fold,
    in_earnest: bool,
    rows: Option<&Problem>,
) -> Vec<TraceError> {
    let others = problem.leaving_out(fold);
    let traces: Vec<usize> = fold.traces(problem.data().labels.len()).collect();
    let own: Vec<Vec<usize>> =
        traces.iter().map(|&trace| fitted.chain.own_of_trace(trace)).collect();
    let all_own = own.concat();
    let rest = fitted.total(&others, |block| f64::from(u8::from(!fold.holds(block.trace))));
    let step = fitted.step(&rest, &all_own);
    let uncertain = fitted.foretold_errors(&rest, &traces, &all_own);
    let foretold =
        rest.cost + 2.0 * rest.gradient.dot(&step) + step.dot(&(&rest.curvature * &step));
    let mut point: Vec<f64> = fitted
        .point
        .iter()
        .zip(step.iter())
        .zip(others.bounds())
        .map(|((x, step), (lower, upper))| (x + step).clamp(*lower, *upper))
        .collect();
    let inside =
        point.iter().zip(&fitted.point).zip(step.iter()).all(|((to, x), step)| *to == x + step);
    let change = step.dot(&(&rest.curvature * &step));
    let straight = change <= SMALL * SMALL * rest.cost && all_own.is_empty() && rows.is_none();
    if straight && inside && fitted.blocks.iter().all(|block| block.levels.is_none()) {
        let error = |(&trace, by_uncertainty)| TraceError {
            by_uncertainty,
            ..along_the_line(fitted, trace, &step)
        };
        return traces.iter().zip(uncertain).map(error).collect();
    }
    let without_own = |point: &mut [f64]| all_own.iter().for_each(|&j| point[j] = 0.0);
    without_own(&mut point);
    let (mut cost, mut aparts) = others.apart(&point);
    let variance = rest.cost / (fitted.samples as f64).max(1.0);
    if in_earnest && (cost.is_nan() || cost > foretold.max(0.0) + SAME * variance) {
        // A step that leaves more than there was is none to go on from.
        if cost.is_nan() || cost > rest.cost {
            point.clone_from(&fitted.point);
            without_own(&mut point);
        }
        point = minimise_with(&Remembering::new(&others), &point, Effort::QUICK).point;
        (cost, aparts) = others.apart(&point);
    }
    if !cost.is_finite() {
        let (square, whitened) = (f64::INFINITY, f64::INFINITY);
        let lost = TraceError { square, whitened, by_uncertainty: 0.0, samples: 1.0 };
        return vec![lost; traces.len()];
    }
    if !all_own.is_empty() {
        own_from_before(&others, &mut point, &own, &aparts);
        aparts = others.apart(&point).1;
    }
    if let Some(rows) = rows {
        let rows = rows.leaving_out(fold);
        let squares = rows.left_out_squares(&rows.point(&others.declared(&point)));
        for (apart, (square, samples)) in aparts.iter_mut().zip(squares) {
            (apart.square, apart.samples) = (square, samples);
        }
    }
    let error = |(apart, by_uncertainty): (Apart, f64)| TraceError {
        square: apart.square,
        whitened: apart.whitened,
        by_uncertainty,
        samples: apart.samples as f64,
    };
    aparts.into_iter().zip(uncertain).map(error).collect()
}

/// The error on one trace after a step that hardly changes the prediction, from the normal equations of its blocks.
fn along_the_line(fitted: &Fitted, trace: usize, step: &DVector<f64>) -> TraceError {
    let mut error = TraceError::default();
    for block in fitted.blocks.iter().filter(|block| block.trace == trace) {
        let (square, whitened) = block.foretold(step);
        error.square += square;
        error.whitened += whitened;
        error.samples += block.samples as f64;
    }
    error
}

/// Sets what each trace left out has of its own by least squares over its samples before the touch; it stays at
/// zero where there are none.
fn own_from_before(others: &Problem, point: &mut [f64], own: &[Vec<usize>], at_zero: &[Apart]) {
    let most = own.iter().map(Vec::len).max().unwrap_or(0);
    // What belongs to one trace changes no other: one run moves a parameter of each.
    let moved: Vec<Vec<Apart>> = (0..most)
        .map(|which| {
            let mut moved = point.to_vec();
            own.iter().filter_map(|own| own.get(which)).for_each(|&j| moved[j] = 1.0);
            others.apart(&moved).1
        })
        .collect();
    for (place, own) in own.iter().enumerate() {
        let residual = &at_zero[place].before;
        if own.is_empty() || residual.len() < 2 * own.len() {
            continue;
        }
        let difference = |moved: &Vec<Apart>| {
            moved[place].before.iter().zip(residual).map(|(moved, at)| moved - at).collect()
        };
        let columns: Vec<Vec<f64>> = moved[..own.len()].iter().map(difference).collect();
        let columns = DMatrix::from_vec(residual.len(), own.len(), columns.concat());
        let found = columns.svd(true, true).solve(&DVector::from_column_slice(residual), 1e-9);
        for (&j, value) in own.iter().zip(found.iter().flat_map(|found| found.iter())) {
            point[j] = -value;
        }
    }
}
