//! The fit of a law to whole motions: loading, holds and unloading of every trace together.
//!
//! The search runs over the simulated force, never over differentiated measurements. Its
//! coordinates are the forces P0…Pn ≥ 0 that the branches carry at the largest compression, the
//! exponent q and the logarithms of the rates: in these, shares that are nonnegative and sum to one
//! are plain bounds, and the stiffness does not trade off against the exponent. Results are given in
//! the law's own parameters, their covariance carried over by the delta method.

use nalgebra::{Const, DMatrix, DVector, U1};
use num_dual::DualNum;

use super::data::{Data, DataError};
use super::least_squares::{LeastSquares, Normal, Solution, Stop, minimise};
use super::start::starts;
use super::uncertainty::{Uncertainty, uncertainty};
use crate::model::{CHUNK, Dual, Fung, Memory, Number, seeded};

/// The outcome of a fit.
#[derive(Clone, Debug)]
pub struct MotionFit {
    /// The law that was fitted.
    pub law: Fung,
    /// Its parameters, in the order of [`Fung::parameters`], rates from fast to slow.
    pub values: Vec<f64>,
    /// Their standard errors; none where the data do not determine the parameter.
    pub standard_errors: Vec<Option<f64>>,
    /// Their correlations.
    pub correlation: DMatrix<f64>,
    /// Whether a parameter ended on a bound of what physics or the sampling allows.
    pub at_bound: Vec<bool>,
    /// Sum of squared residuals.
    pub cost: f64,
    /// Number of samples fitted.
    pub samples: usize,
    /// Coefficient of determination over all samples.
    pub r_squared: f64,
    /// Correlation between a residual and the next, which the standard errors allow for.
    pub autocorrelation: f64,
    /// Root mean square residual of each trace.
    pub trace_rms: Vec<f64>,
    /// Why the search stopped.
    pub stop: Stop,
    /// Number of steps tried.
    pub iterations: usize,
    point: Vec<f64>,
}

impl MotionFit {
    /// Root mean square of the residuals, in the unit of the signal.
    #[must_use]
    pub fn rms(&self) -> f64 {
        (self.cost / self.samples as f64).sqrt()
    }

    /// Bayesian information criterion up to a constant, with the number of samples reduced to the
    /// independent ones.
    #[must_use]
    pub fn bic(&self) -> f64 {
        let independent = self.samples as f64 * independent_share(self.autocorrelation);
        let parameters = self.values.len() as f64;
        independent * (self.cost / self.samples as f64).ln() + parameters * independent.ln()
    }
}

/// Fits the law to the data, from starts of its own.
///
/// # Errors
/// When there are fewer samples than parameters, or no stretch of the data holds the specimen.
pub fn fit(law: Fung, data: &Data) -> Result<MotionFit, DataError> {
    let parameters = 2 + 2 * law.terms;
    if data.samples() <= parameters {
        return Err(DataError::TooFew { samples: data.samples(), parameters });
    }
    let problem = Problem::new(law, data, None);
    // Several starts: the sum of squares may have more than one minimum in q and the rates.
    let best = starts(data, law.terms, problem.reference)
        .into_iter()
        .take(3)
        .map(|start| {
            let rates = start.rates.iter().copied().map(f64::ln);
            let forces = start.forces.iter().copied();
            let point: Vec<f64> = forces.chain(std::iter::once(start.q)).chain(rates).collect();
            let found = minimise(&problem, &point);
            tracing::info!(
                "{} exponential(s), start q = {}, rates {:?} 1/s: {} after {} steps, sum of squares {:.6e}",
                law.terms,
                start.q,
                start.rates,
                found.stop,
                found.iterations,
                found.normal.cost
            );
            found
        })
        .min_by(|a, b| a.normal.cost.total_cmp(&b.normal.cost))
        .ok_or(DataError::NothingLeft)?;
    Ok(problem.describe(&best))
}

/// Root mean square error on each trace when it is left out of the fit, the specimen's history kept.
#[must_use]
pub fn held_out(fit: &MotionFit, data: &Data) -> Vec<f64> {
    (0..data.labels.len())
        .map(|trace| {
            let problem = Problem::new(fit.law, data, Some(trace));
            let found = minimise(&problem, &fit.point);
            problem.trace_rms(&found.point)[trace]
        })
        .collect()
}

/// Residuals of a law over a data set.
struct Problem<'a> {
    law: Fung,
    data: &'a Data,
    /// A trace that is predicted but not fitted.
    left_out: Option<usize>,
    /// The compression at which the branch forces are stated, mm.
    reference: f64,
    bounds: Vec<(f64, f64)>,
}

impl<'a> Problem<'a> {
    fn new(law: Fung, data: &'a Data, left_out: Option<usize>) -> Self {
        let exponent = &law.parameters()[1];
        let slowest = (0.02 / data.longest()).ln();
        let fastest = (3.0 / data.shortest_interval()).ln();
        let bounds = std::iter::repeat_n((0.0, f64::INFINITY), law.terms + 1)
            .chain(std::iter::once((exponent.lower, exponent.upper)))
            .chain(std::iter::repeat_n((slowest, fastest), law.terms))
            .collect();
        Self { law, data, left_out, reference: data.largest_compression(), bounds }
    }

    /// The law's parameters p, q, c1…, v1… from the coordinates P0…Pn, q, ln v1….
    fn declared<T: Number>(&self, point: &[T]) -> Vec<T> {
        let terms = self.law.terms;
        let (forces, rest) = point.split_at(terms + 1);
        let q = rest[0];
        // A model without any force has no shares either; the tiny floor keeps them finite.
        let total =
            forces.iter().fold(T::from(f64::MIN_POSITIVE.sqrt()), |sum, &force| sum + force);
        let exponent = q + 1.0;
        let p = total * exponent * (-exponent * self.reference.ln()).exp();
        [p, q]
            .into_iter()
            .chain(forces[1..].iter().map(|&force| force / total))
            .chain(rest[1..].iter().map(DualNum::exp))
            .collect()
    }

    /// Runs the law over every stretch and hands each sample's index, prediction and measurement on.
    fn predict(&self, point: &[f64], mut sink: impl FnMut(usize, f64, f64)) {
        let parameters = self.declared(point);
        let mut memory = self.law.rested();
        for (index, piece) in self.data.pieces.iter().enumerate() {
            self.law.run(&parameters, &piece.motion, &mut memory, |k, force| {
                sink(index, force, piece.measured[k]);
            });
        }
    }

    fn fitted(&self, piece: usize) -> bool {
        self.left_out != Some(self.data.pieces[piece].trace)
    }

    fn trace_rms(&self, point: &[f64]) -> Vec<f64> {
        let mut sums = vec![(0.0, 0_usize); self.data.labels.len()];
        self.predict(point, |piece, force, measured| {
            let (sum, count) = &mut sums[self.data.pieces[piece].trace];
            *sum += (force - measured).powi(2);
            *count += 1;
        });
        sums.into_iter().map(|(sum, count)| (sum / (count as f64).max(1.0)).sqrt()).collect()
    }

    /// Sum of products of neighbouring residuals over the sum of squares.
    fn autocorrelation(&self, point: &[f64]) -> f64 {
        let (mut product, mut square) = (0.0, 0.0);
        let mut before: Option<(usize, f64)> = None;
        self.predict(point, |piece, force, measured| {
            let residual = force - measured;
            square += residual * residual;
            if let Some((same, earlier)) = before
                && same == piece
            {
                product += residual * earlier;
            }
            before = Some((piece, residual));
        });
        if square > 0.0 { product / square } else { 0.0 }
    }

    fn describe(&self, found: &Solution) -> MotionFit {
        let samples = self.data.samples();
        let cost = found.normal.cost;
        let held: Vec<bool> = found.at_bound.clone();
        let free = held.iter().filter(|held| !**held).count();
        let autocorrelation = self.autocorrelation(&found.point);
        let variance = cost / (samples - free) as f64 / independent_share(autocorrelation);
        let known = uncertainty(&found.normal.curvature, &held, variance);
        let mut fit = MotionFit {
            law: self.law,
            values: self.declared(&found.point),
            standard_errors: Vec::new(),
            correlation: DMatrix::zeros(0, 0),
            at_bound: self.declared_at_bound(&held),
            cost,
            samples,
            r_squared: 1.0 - cost / self.scatter(),
            autocorrelation,
            trace_rms: self.trace_rms(&found.point),
            stop: found.stop,
            iterations: found.iterations,
            point: found.point.clone(),
        };
        self.declare_uncertainty(&mut fit, &known);
        sort_branches(&mut fit);
        fit
    }

    /// Covariance in the law's own parameters, by the delta method.
    fn declare_uncertainty(&self, fit: &mut MotionFit, known: &Uncertainty) {
        let dimension = fit.values.len();
        let mut slope = DMatrix::zeros(dimension, dimension);
        for first in (0..dimension).step_by(CHUNK) {
            for (row, value) in self.declared(&seeded(&fit.point, first)).iter().enumerate() {
                let derivatives = value.eps.unwrap_generic(Const, U1);
                for (place, derivative) in derivatives.iter().enumerate() {
                    if first + place < dimension {
                        slope[(row, first + place)] = *derivative;
                    }
                }
            }
        }
        let covariance = &slope * &known.covariance * slope.transpose();
        fit.standard_errors = (0..dimension)
            .map(|row| known.variance(&slope.row(row).transpose()).map(f64::sqrt))
            .collect();
        fit.correlation = DMatrix::from_fn(dimension, dimension, |i, j| {
            let size = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
            if i == j {
                1.0
            } else if size > 0.0 {
                covariance[(i, j)] / size
            } else {
                0.0
            }
        });
    }

    /// Coordinates on a bound, as parameters: a branch without force is a share at zero.
    fn declared_at_bound(&self, held: &[bool]) -> Vec<bool> {
        let terms = self.law.terms;
        std::iter::once(false)
            .chain(std::iter::once(held[terms + 1]))
            .chain(held[1..=terms].iter().copied())
            .chain(held[terms + 2..].iter().copied())
            .collect()
    }

    /// Sum of squares of the measured signal about its mean.
    fn scatter(&self) -> f64 {
        let values = || self.data.pieces.iter().flat_map(|piece| &piece.measured);
        let mean = values().sum::<f64>() / self.data.samples() as f64;
        values().map(|value| (value - mean).powi(2)).sum()
    }
}

impl LeastSquares for Problem<'_> {
    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }

    fn cost(&self, point: &[f64]) -> f64 {
        let mut cost = 0.0;
        self.predict(point, |piece, force, measured| {
            if self.fitted(piece) {
                cost += (force - measured).powi(2);
            }
        });
        cost
    }

    fn normal(&self, point: &[f64]) -> Normal {
        let dimension = point.len();
        let passes: Vec<usize> = (0..dimension).step_by(CHUNK).collect();
        let parameters: Vec<Vec<Dual>> =
            passes.iter().map(|&first| self.declared(&seeded(point, first))).collect();
        let mut memories: Vec<Memory<Dual>> = vec![self.law.rested(); passes.len()];
        let mut normal = Normal::zeros(dimension);
        for (index, piece) in self.data.pieces.iter().enumerate() {
            let mut rows = vec![0.0; piece.measured.len() * dimension];
            let mut residuals = vec![0.0; piece.measured.len()];
            for ((&first, parameters), memory) in passes.iter().zip(&parameters).zip(&mut memories)
            {
                let width = CHUNK.min(dimension - first);
                self.law.run(parameters, &piece.motion, memory, |k, force| {
                    residuals[k] = force.re - piece.measured[k];
                    let derivatives = force.eps.unwrap_generic(Const, U1);
                    let begin = k * dimension + first;
                    rows[begin..begin + width].copy_from_slice(&derivatives.as_slice()[..width]);
                });
            }
            if self.fitted(index) {
                accumulate(&mut normal, &rows, &residuals);
            }
        }
        normal
    }
}

fn accumulate(normal: &mut Normal, rows: &[f64], residuals: &[f64]) {
    let dimension = normal.gradient.len();
    let jacobian = DMatrix::from_row_slice(residuals.len(), dimension, rows);
    let residuals = DVector::from_column_slice(residuals);
    normal.cost += residuals.norm_squared();
    normal.gradient += jacobian.tr_mul(&residuals);
    normal.curvature += jacobian.tr_mul(&jacobian);
}

/// Share of the samples that count as independent when neighbours correlate like a first-order
/// autoregression.
fn independent_share(autocorrelation: f64) -> f64 {
    let correlation = autocorrelation.clamp(0.0, 0.999);
    (1.0 - correlation) / (1.0 + correlation)
}

/// Puts the exponentials in the order of their rates, fast first.
fn sort_branches(fit: &mut MotionFit) {
    let terms = fit.law.terms;
    let mut order: Vec<usize> = (0..terms).collect();
    order.sort_by(|&a, &b| fit.values[2 + terms + b].total_cmp(&fit.values[2 + terms + a]));
    let place: Vec<usize> = [0, 1]
        .into_iter()
        .chain(order.iter().map(|&k| 2 + k))
        .chain(order.iter().map(|&k| 2 + terms + k))
        .collect();
    fit.values = place.iter().map(|&k| fit.values[k]).collect();
    fit.standard_errors = place.iter().map(|&k| fit.standard_errors[k]).collect();
    fit.at_bound = place.iter().map(|&k| fit.at_bound[k]).collect();
    let unsorted = fit.correlation.clone();
    fit.correlation =
        DMatrix::from_fn(place.len(), place.len(), |i, j| unsorted[(place[i], place[j])]);
}
