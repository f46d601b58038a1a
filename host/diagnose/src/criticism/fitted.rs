//! A model refitted to whitened data, with what is needed to weigh it against others without fitting
//! again: the normal equations of every block of the data.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use palpate_fit::least_squares::{Effort, LeastSquares, Normal, Solution, minimise_with, settle};
use palpate_fit::levels::LevelSums;
use palpate_fit::problem::{Block, Problem};
use palpate_fit::remembering::Remembering;
use palpate_fit::uncertainty;
use palpate_fit::whole_motion::declared_uncertainty;
use palpate_model::{Chain, Parameter};

/// A chain fitted to a data set.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The chain.
    pub chain: Chain,
    /// The coordinates of the search.
    pub point: Vec<f64>,
    /// The parameters.
    pub values: Vec<f64>,
    /// Blocks of the data.
    pub blocks: Vec<Block>,
    /// Sum of squares of the whitened residual.
    pub cost: f64,
    /// Number of samples.
    pub samples: usize,
    /// Number of rows and root mean square error over all of them, where the data are their means.
    rows: Option<(usize, f64)>,
    /// Which coordinates were fitted and are not on a bound.
    free: Vec<bool>,
    /// Part of the samples that are independent, from how neighbours in the whitened residual agree.
    independent: f64,
    /// The first parameter of the last effect that the data push against a bound.
    pushed: Option<usize>,
    /// Number of parameters that were fitted.
    parameters: usize,
    /// Whether the search for them came to its end.
    converged: bool,
}

impl Fitted {
    /// Refits the problem's chain from a point.
    #[must_use]
    pub fn new(problem: &Problem, from: &[f64], effort: Effort) -> Self {
        let search = Remembering::new(problem);
        let found = minimise_with(&search, from, effort);
        let bounds = problem.bounds();
        let given = |j: usize| bounds[j].0 >= bounds[j].1;
        let blocks = search.blocks(&found.point);
        Self {
            chain: problem.chain.clone(),
            values: problem.declared(&found.point),
            cost: found.normal.cost,
            samples: blocks.iter().map(|block| block.samples).sum(),
            rows: None,
            independent: independent(&blocks),
            free: (0..found.point.len()).map(|j| !found.at_bound[j] && !given(j)).collect(),
            pushed: of_last_effect(problem.chain)
                .find(|&j| found.at_bound[j] && !given(j) && pushed(problem, &found, j)),
            parameters: (0..found.point.len()).filter(|&j| !given(j)).count(),
            converged: found.stop.converged(),
            point: found.point,
            blocks,
        }
    }

    /// Goes on with a search for the parameters that has not come to its end.
    pub fn go_on(&mut self, problem: &Problem) {
        if !self.converged {
            let problem = problem.with_chain(&self.chain);
            *self = Self::new(&problem, &self.point, Effort::LONG);
        }
    }

    /// Takes the parameters that describe best the samples that the means of the search stand for, a few steps from those that describe
    /// the means: these smooth what repeats within a block.
    pub fn confirm(&mut self, samples: &Problem) {
        let problem = samples.with_chain(&self.chain);
        self.point = settle(&Remembering::new(&problem), &self.point, Effort::TRIAL);
        self.values = problem.declared(&self.point);
    }

    /// Takes the error over all rows, where the data that it was fitted to are their means; the sum of squares and the number of rows
    /// of each trace.
    pub fn score(&mut self, rows: &Problem) -> Vec<(f64, usize)> {
        let problem = rows.with_chain(&self.chain);
        let squares = problem.trace_squares(&problem.point(&self.values));
        let total: f64 = squares.iter().map(|(square, _)| square).sum();
        self.rows = Some((problem.data().samples(), (total / problem.rows() as f64).sqrt()));
        squares
    }

    /// Number of rows of the recordings.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows.map_or(self.samples, |(rows, _)| rows)
    }

    /// Root mean square of the residual as it is.
    #[must_use]
    pub fn rms(&self) -> f64 {
        if let Some((_, rms)) = self.rows {
            return rms;
        }
        let squares: f64 = self.blocks.iter().map(|block| block.raw.cost).sum();
        (squares / self.samples as f64).sqrt()
    }

    /// Bayesian information criterion on the whitened residuals.
    #[must_use]
    pub fn bic(&self) -> f64 {
        self.criterion(self.cost, self.samples as f64)
    }

    /// The same if so many more numbers took so much off the sum of squares.
    #[must_use]
    pub fn bic_with(&self, numbers: usize, gain: f64) -> f64 {
        let samples = self.samples as f64;
        self.criterion((self.cost - gain).max(f64::MIN_POSITIVE), samples)
            + numbers as f64 * samples.ln()
    }

    /// Whether this model is better than another by so much of the information criterion where
    /// neighbours in the residual agree: samples count as often as they are independent in what this
    /// one leaves.
    #[must_use]
    pub fn beats_inexact(&self, other: &Self, by: f64) -> bool {
        let samples = self.samples as f64 * self.independent;
        let criterion = |fitted: &Self| {
            samples * (fitted.cost / fitted.samples as f64).ln()
                + fitted.parameters as f64 * samples.max(1.0).ln()
        };
        criterion(other) - criterion(self) > by
    }

    /// Which coordinates were not fitted: given, or on a bound.
    #[must_use]
    pub fn held(&self) -> Vec<bool> {
        self.free.iter().map(|free| !free).collect()
    }

    /// Variance of a whitened residual, as the fit left it.
    #[must_use]
    pub fn variance(&self) -> f64 {
        (self.cost / (self.samples as f64 - self.parameters as f64)).max(1e-300)
    }

    /// The parameter of the last effect that the data push against a bound; none where there is none.
    #[must_use]
    pub fn last_effect_at_bound(&self) -> Option<(&Parameter, f64)> {
        let (place, last) = (self.pushed?, self.chain.effects.len().checked_sub(1)?);
        let own = place.checked_sub(self.chain.range(last).start)?;
        Some((self.chain.effects[last].parameters.get(own)?, self.values[place]))
    }

    /// The curvature of the whitened sum of squares.
    #[must_use]
    pub fn curvature(&self) -> DMatrix<f64> {
        let mut total = Normal::zeros(self.point.len());
        for block in &self.blocks {
            total.add_those_of(&block.coordinates, &block.white, 1.0);
        }
        total.curvature
    }

    fn criterion(&self, cost: f64, samples: f64) -> f64 {
        samples * (cost / samples).ln() + self.parameters as f64 * samples.ln()
    }

    /// The normal equations of the blocks, each counted so many times, without what slow noise explains.
    #[must_use]
    pub fn total(&self, problem: &Problem, weight: impl Fn(&Block) -> f64) -> Normal {
        let weights: Vec<f64> = self.blocks.iter().map(weight).collect();
        self.weighted(problem, &weights)
    }

    /// The same with a weight for each block.
    pub(super) fn weighted(&self, problem: &Problem, weights: &[f64]) -> Normal {
        let mut total = Normal::zeros(self.point.len());
        let mut sums: Option<LevelSums> = None;
        for (block, &weight) in self.blocks.iter().zip(weights) {
            total.add_those_of(&block.coordinates, &block.white, weight);
            if let Some(own) = &block.levels {
                let zeros = || LevelSums::zeros(self.point.len(), own.unit.len());
                sums.get_or_insert_with(zeros).add_weighted(own, weight);
            }
        }
        problem.marginalise(sums.as_ref(), &mut total);
        total
    }

    /// The criterion where every block counts this many times: the model refitted to them in one step.
    #[must_use]
    pub fn weighted_bic(&self, problem: &Problem, weights: &[f64]) -> f64 {
        let total = self.weighted(problem, weights);
        let blocks = self.blocks.iter().zip(weights);
        let samples = blocks.map(|(block, weight)| weight * block.samples as f64).sum();
        let step = self.step(&total, &[]);
        let gained = -(2.0 * total.gradient.dot(&step) + step.dot(&(&total.curvature * &step)));
        self.criterion((total.cost - gained.max(0.0)).max(f64::MIN_POSITIVE), samples)
    }

    /// The Gauss–Newton step of the coordinates that are free, without those that are `fixed`.
    #[must_use]
    pub fn step(&self, normal: &Normal, fixed: &[usize]) -> DVector<f64> {
        gauss_newton(normal, |j| self.free[j] && !fixed.contains(&j))
    }

    /// Sum of squares that the uncertainty of the coordinates adds to the error on each of some `traces` to which they were not
    /// fitted: the trace of its curvature times the covariance that the `normal` equations of the fit give.
    #[must_use]
    pub fn foretold_errors(&self, normal: &Normal, traces: &[usize], fixed: &[usize]) -> Vec<f64> {
        let Some(known) = Scaled::of(normal, |j| self.free[j] && !fixed.contains(&j)) else {
            return vec![0.0; traces.len()];
        };
        let (free, scale) = (&known.free, &known.scale);
        let error_on = |trace: &usize| {
            let mut left_out = Normal::zeros(self.point.len());
            for block in self.blocks.iter().filter(|block| block.trace == *trace) {
                left_out.add_those_of(&block.coordinates, &block.raw, 1.0);
            }
            let matrix = DMatrix::from_fn(free.len(), free.len(), |a, b| {
                left_out.curvature[(free[a], free[b])] / (scale[a] * scale[b])
            });
            known.factor.solve(&matrix).trace()
        };
        traces.iter().map(error_on).collect()
    }

    /// Standard errors of the parameters, with the variance that the whitened residuals show; where the
    /// law is `inexact`, by the delete-one jackknife over the parts of the data, which allows for what
    /// the law leaves.
    #[must_use]
    pub fn standard_errors(&self, problem: &Problem, inexact: bool) -> Vec<Option<f64>> {
        let total = self.total(problem, |_| 1.0);
        let mut known = uncertainty(&total.curvature, &self.held(), self.variance());
        if inexact {
            known.covariance = self.jackknife(problem, &[]);
        }
        declared_uncertainty(problem, &self.point, &known).0
    }

    /// The strengths of the last effect over their standard errors by the jackknife over the parts of the data, root mean square, its
    /// shapes as they are; none where each trace has its own.
    #[must_use]
    pub fn strength_over_error(&self, problem: &Problem) -> Option<f64> {
        let last = self.chain.effects.last().filter(|effect| effect.each_trace == 0)?;
        let range = self.chain.range(self.chain.effects.len() - 1);
        let (first, count) = (range.start, last.strengths);
        let strengths = DVector::from_column_slice(&self.point[first..first + count]);
        if strengths.iter().all(|strength| *strength == 0.0) {
            return Some(0.0);
        }
        let shapes: Vec<usize> = range.skip(count).collect();
        let covariance = self.jackknife(problem, &shapes);
        let own = covariance.view((first, first), (count, count)).into_owned();
        let solved = own.cholesky()?.solve(&strengths);
        Some((strengths.dot(&solved) / count as f64).sqrt())
    }

    /// Covariance of the coordinates from refits in one step to all parts but one: traces, or pieces of
    /// them where there are few; of all but those held.
    fn jackknife(&self, problem: &Problem, held: &[usize]) -> DMatrix<f64> {
        let traces = self.blocks.iter().map(|block| block.trace + 1).max().unwrap_or(0);
        let part = |index: usize| {
            if traces >= FEWEST_TRACES { self.blocks[index].trace } else { index }
        };
        let parts = if traces >= FEWEST_TRACES { traces } else { self.blocks.len() };
        let refit = |left_out: usize| {
            let weights: Vec<f64> =
                (0..self.blocks.len()).map(|k| f64::from(u8::from(part(k) != left_out))).collect();
            self.step(&self.weighted(problem, &weights), held)
        };
        let steps: Vec<DVector<f64>> = (0..parts).map(refit).collect();
        let count = parts.max(1) as f64;
        let mean =
            steps.iter().fold(DVector::zeros(self.point.len()), |sum, step| sum + step) / count;
        let spread = steps.iter().map(|step| step - &mean);
        spread.fold(DMatrix::zeros(self.point.len(), self.point.len()), |sum, off| {
            sum + &off * off.transpose()
        }) * ((count - 1.0) / count)
    }
}

/// The parameters of a chain's last effect that no law bounds: the data may push them against the bounds of a search.
fn of_last_effect(chain: &Chain) -> impl Iterator<Item = usize> {
    let last = chain.effects.len().checked_sub(1);
    last.into_iter().flat_map(|last| {
        let own = chain.effects[last].parameters.iter().zip(chain.range(last));
        own.filter(|(parameter, _)| !parameter.bounded).map(|(_, place)| place)
    })
}

/// Part of its range by which a coordinate on its bound is moved beyond it to see whether the data ask for that.
const BEYOND: f64 = 0.1;
/// Ratio of two bounds of one sign from which on the way beyond one is taken as a factor.
const DECADE: f64 = 10.0;
/// Fall of the sum of squares, in variances of the noise, that asks for a value beyond a bound: 95 % of one parameter.
const ASKS: f64 = 3.84;

/// Whether the data push a coordinate against the bound on which it was found: beyond it, the others following in
/// one step, the error is smaller. Where it is not, the bound keeps nothing from the law: with a sliding
/// speed far below every speed of the motion it is the ideal law already.
fn pushed(problem: &Problem, found: &Solution, j: usize) -> bool {
    let mut point = found.point.clone();
    point[j] = beyond(found.point[j], problem.bounds()[j]);
    let normal = problem.normal(&point);
    let step = gauss_newton(&normal, |k| k != j && !found.at_bound[k]);
    let followed = normal.cost + normal.raised_by(&step);
    let variance = found.normal.cost / (problem.rows() as f64).max(1.0);
    followed + ASKS * variance < found.normal.cost
}

/// A value as far beyond the nearer bound as a tenth of the range is inside it.
fn beyond(value: f64, (lower, upper): (f64, f64)) -> f64 {
    let inwards = BEYOND * (upper - lower);
    let (bound, inside) = if value - lower < upper - value {
        (lower, lower + inwards)
    } else {
        (upper, upper - inwards)
    };
    let factor = lower * upper > 0.0 && (upper / lower).max(lower / upper) > DECADE;
    if factor { bound * bound / inside } else { 2.0 * bound - inside }
}

/// The Gauss–Newton step of the coordinates that `moves` names; the others stay.
fn gauss_newton(normal: &Normal, moves: impl Fn(usize) -> bool) -> DVector<f64> {
    let mut step = DVector::zeros(normal.gradient.len());
    if let Some(Scaled { free, scale, factor }) = Scaled::of(normal, moves) {
        let right = DVector::from_fn(free.len(), |a, _| -normal.gradient[free[a]] / scale[a]);
        for ((&j, scale), found) in free.iter().zip(&scale).zip(factor.solve(&right).iter()) {
            step[j] = found / scale;
        }
    }
    step
}

/// The curvature of some coordinates, each in the unit in which its own is one, factorised.
struct Scaled {
    free: Vec<usize>,
    scale: Vec<f64>,
    factor: Cholesky<f64, Dyn>,
}

impl Scaled {
    /// Of those coordinates that `moves` names and the data depend on; none where they cannot be solved for.
    fn of(normal: &Normal, moves: impl Fn(usize) -> bool) -> Option<Self> {
        let known = |&j: &usize| moves(j) && normal.curvature[(j, j)] > 0.0;
        let free: Vec<usize> = (0..normal.gradient.len()).filter(known).collect();
        let scale: Vec<f64> = free.iter().map(|&j| normal.curvature[(j, j)].sqrt()).collect();
        let matrix = DMatrix::from_fn(free.len(), free.len(), |a, b| {
            let value = normal.curvature[(free[a], free[b])] / (scale[a] * scale[b]);
            if a == b { value + 1e-9 } else { value }
        });
        let factor = matrix.cholesky()?;
        Some(Self { free, scale, factor })
    }
}

/// Fewest traces that count as the parts of the data; of fewer, their pieces do.
const FEWEST_TRACES: usize = 8;

/// Part of the samples that are independent: the mean square of a whitened sample over that of block
/// sums per sample, at most one.
fn independent(blocks: &[Block]) -> f64 {
    let sums: f64 = blocks.iter().map(|block| block.slow).sum();
    let squares: f64 = blocks.iter().map(|block| block.white.cost).sum();
    if sums > 0.0 { (squares / sums).clamp(1e-4, 1.0) } else { 1.0 }
}
