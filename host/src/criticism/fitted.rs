//! A model refitted to whitened data, with what is needed to weigh it against others without fitting
//! again: the normal equations of every block of the data.

use nalgebra::{DMatrix, DVector};

use crate::fit::least_squares::{Effort, LeastSquares, Normal, minimise_with};
use crate::fit::problem::{Block, Problem};
use crate::fit::uncertainty;
use crate::fit::whole_motion::declared_uncertainty;
use crate::model::Chain;

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
    /// Which coordinates were fitted and are not on a bound.
    free: Vec<bool>,
    /// Number of parameters that were fitted.
    parameters: usize,
}

/// An error with the errors of every trace by itself.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldOut {
    /// Root mean square error over all traces, each predicted by a fit to the others.
    pub rms: f64,
    /// Mean square error of each trace.
    pub squares: Vec<f64>,
}

impl Fitted {
    /// Refits the problem's chain from a point.
    #[must_use]
    pub fn new(problem: &Problem, from: &[f64], effort: Effort) -> Self {
        let found = minimise_with(problem, from, effort);
        let bounds = problem.bounds();
        let given = |j: usize| bounds[j].0 >= bounds[j].1;
        let blocks = problem.blocks(&found.point);
        Self {
            chain: problem.chain.clone(),
            values: problem.declared(&found.point),
            cost: found.normal.cost,
            samples: blocks.iter().map(|block| block.samples).sum(),
            free: (0..found.point.len()).map(|j| !found.at_bound[j] && !given(j)).collect(),
            parameters: (0..found.point.len()).filter(|&j| !given(j)).count(),
            point: found.point,
            blocks,
        }
    }

    /// Root mean square of the residual as it is.
    #[must_use]
    pub fn rms(&self) -> f64 {
        let squares: f64 = self.blocks.iter().map(|block| block.raw.cost).sum();
        (squares / self.samples as f64).sqrt()
    }

    /// Bayesian information criterion on the whitened residuals.
    #[must_use]
    pub fn bic(&self) -> f64 {
        self.criterion(self.cost, self.samples as f64)
    }

    fn criterion(&self, cost: f64, samples: f64) -> f64 {
        samples * (cost / samples).ln() + self.parameters as f64 * samples.ln()
    }

    /// The criterion where every block counts this many times: the model refitted to them in one step.
    #[must_use]
    pub fn weighted_bic(&self, weights: &[f64]) -> f64 {
        let mut total = Normal::zeros(self.point.len());
        let mut samples = 0.0;
        for (block, &weight) in self.blocks.iter().zip(weights) {
            total.cost += weight * block.white.cost;
            total.gradient += &block.white.gradient * weight;
            total.curvature += &block.white.curvature * weight;
            samples += weight * block.samples as f64;
        }
        let step = self.step(&total, None);
        let gained = -(2.0 * total.gradient.dot(&step) + step.dot(&(&total.curvature * &step)));
        self.criterion((total.cost - gained.max(0.0)).max(f64::MIN_POSITIVE), samples)
    }

    /// The Gauss–Newton step of the coordinates that are free, without the one that is `fixed`.
    fn step(&self, normal: &Normal, fixed: Option<&[usize]>) -> DVector<f64> {
        let dimension = self.point.len();
        let moves = |&j: &usize| {
            self.free[j]
                && normal.curvature[(j, j)] > 0.0
                && fixed.is_none_or(|fixed| !fixed.contains(&j))
        };
        let free: Vec<usize> = (0..dimension).filter(moves).collect();
        let mut step = DVector::zeros(dimension);
        let scale: Vec<f64> = free.iter().map(|&j| normal.curvature[(j, j)].sqrt()).collect();
        let matrix = DMatrix::from_fn(free.len(), free.len(), |a, b| {
            let value = normal.curvature[(free[a], free[b])] / (scale[a] * scale[b]);
            if a == b { value + 1e-9 } else { value }
        });
        let right = DVector::from_fn(free.len(), |a, _| -normal.gradient[free[a]] / scale[a]);
        if let Some(factor) = matrix.cholesky() {
            let found = factor.solve(&right);
            for (a, &j) in free.iter().enumerate() {
                step[j] = found[a] / scale[a];
            }
        }
        step
    }

    /// Error on every trace when it is left out of the fit, in one step from the fit to all; none for a
    /// single trace. A zero that each trace has of its own is taken from before its touch.
    #[must_use]
    pub fn held_out(&self) -> Option<HeldOut> {
        let traces = 1 + self.blocks.iter().map(|block| block.trace).max()?;
        let groups: Vec<usize> = (0..traces).collect();
        self.held_out_by(&groups)
    }

    /// The same with all traces of a group left out together: `groups` names the group of each trace.
    #[must_use]
    pub fn held_out_by(&self, groups: &[usize]) -> Option<HeldOut> {
        let count = 1 + groups.iter().copied().max()?;
        if count < 2 {
            return None;
        }
        let mut squares = vec![0.0; groups.len()];
        let mut samples = vec![0.0; groups.len()];
        for group in 0..count {
            let mut rest = Normal::zeros(self.point.len());
            for block in self.blocks.iter().filter(|block| groups[block.trace] != group) {
                rest.gradient += &block.white.gradient;
                rest.curvature += &block.white.curvature;
            }
            for (trace, _) in groups.iter().enumerate().filter(|(_, g)| **g == group) {
                let own = self.chain.own_of_trace(trace);
                let mut step = self.step(&rest, Some(&own));
                for &j in &own {
                    // The residual before the touch is what the trace's own zero leaves there.
                    let before = self.blocks.iter().filter(|block| block.trace == trace);
                    let (sum, count) = before.fold((0.0, 0.0), |(sum, count), block| {
                        (sum + block.before_touch.0, count + block.before_touch.1)
                    });
                    step[j] = match (own.len(), count > 0.0) {
                        (1, true) => -sum / count,
                        (1, false) => -self.point[j],
                        // What a trace has more of its own than a zero stays as it was fitted.
                        _ => 0.0,
                    };
                }
                for block in self.blocks.iter().filter(|block| block.trace == trace) {
                    let raw = &block.raw;
                    let change =
                        2.0 * raw.gradient.dot(&step) + step.dot(&(&raw.curvature * &step));
                    squares[trace] += (raw.cost + change).max(0.0);
                    samples[trace] += block.samples as f64;
                }
            }
        }
        let total: f64 = squares.iter().sum();
        let all: f64 = samples.iter().sum();
        let mean = squares.iter().zip(&samples).map(|(sum, count)| sum / count.max(1.0)).collect();
        Some(HeldOut { rms: (total / all).sqrt(), squares: mean })
    }

    /// Standard errors of the parameters, with the variance that the whitened residuals show.
    #[must_use]
    pub fn standard_errors(&self, problem: &Problem) -> Vec<Option<f64>> {
        let mut total = Normal::zeros(self.point.len());
        for block in &self.blocks {
            total.curvature += &block.white.curvature;
        }
        let held: Vec<bool> = self.free.iter().map(|free| !free).collect();
        let variance = (self.cost / (self.samples as f64 - self.parameters as f64)).max(1e-300);
        let known = uncertainty(&total.curvature, &held, variance);
        declared_uncertainty(problem, &self.point, &known).0
    }
}
