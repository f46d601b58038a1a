//! The fit of a model to whole motions: loading, holds and unloading of every trace together.
//!
//! Results are given in the model's own parameters, their covariance carried over from the
//! coordinates of the search ([`super::problem`]) by the delta method.

use nalgebra::DMatrix;

use super::data::{Data, DataError, Piece};
use super::least_squares::{LeastSquares, Solution, Stop, minimise};
use super::problem::Problem;
use super::start::starts;
use super::uncertainty::{Uncertainty, uncertainty};
use super::watch;
use super::whitening::Whitening;
use crate::model::{BaseLaw, Chain, Elasticity, FitRecord, History, Parameter};
use crate::trace::units;

/// The outcome of a fit.
#[derive(Clone, Debug)]
pub struct MotionFit {
    /// The chain that was fitted.
    pub chain: Chain,
    /// Its parameters, in the order of [`Chain::parameters`], rates from fast to slow.
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
}

impl MotionFit {
    /// Root mean square of the residuals, in the unit of the signal.
    #[must_use]
    pub fn rms(&self) -> f64 {
        (self.cost / self.samples as f64).sqrt()
    }

    /// What each value is of.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        self.chain.parameters()
    }

    /// How the parameters were found, for the model file; with the noise of one sample where it is known.
    #[must_use]
    pub fn record(&self, data: &Data, noise: Option<f64>) -> FitRecord {
        FitRecord {
            traces: data.labels.clone(),
            samples: self.samples,
            unit: units::printed(&data.signal).into(),
            residual_rms: self.rms(),
            noise_rms: noise,
            r_squared: self.r_squared,
            largest_compression_mm: Some(data.largest_compression()),
            stop: self.stop.to_string(),
        }
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
/// When there are fewer samples than parameters, no stretch of the data holds the specimen, or its squares are no numbers.
pub fn fit(law: BaseLaw, data: &Data) -> Result<MotionFit, DataError> {
    let law = law.over(data.span());
    let chain = Chain::new(law);
    check_size(&chain, data)?;
    if !scatter(data).is_finite() {
        return Err(not_finite(&law, data));
    }
    let white = Whitening::none();
    let problem = Problem::new(&chain, data, &white, None);
    // Several starts: the sum of squares may have more than one minimum in the exponents and the rates.
    let starts = starts(&law, data);
    watch::stage("starts of the search", starts.len());
    let best = starts
        .into_iter()
        .map(|start| {
            let found = minimise(&problem, &problem.point(&start));
            tracing::info!(
                "{}, start {start:?}: {} after {} steps, sum of squares {:.6e}",
                law.in_words(),
                found.stop,
                found.iterations,
                found.normal.cost
            );
            watch::done();
            found
        })
        .min_by(|a, b| a.normal.cost.total_cmp(&b.normal.cost))
        .ok_or(DataError::NothingLeft)?;
    let mut fit = describe(&problem, data, &best);
    if !is_finite(&fit) {
        return Err(not_finite(&law, data));
    }
    // By the information criterion: a single sample that outweighs all others leaves R² just above 0.
    let samples = fit.samples as f64;
    let left = (1.0 - fit.r_squared).max(f64::MIN_POSITIVE);
    if samples * left.ln() + (fit.values.len() as f64 - 1.0) * samples.ln() >= 0.0 {
        fit.stop = Stop::NoBetter;
    }
    Ok(fit)
}

/// Fits a chain to the data from these parameters.
///
/// # Errors
/// When there are fewer samples than parameters, or the squares of the data are no numbers.
pub fn refit(chain: &Chain, from: &[f64], data: &Data) -> Result<MotionFit, DataError> {
    check_size(chain, data)?;
    let white = Whitening::none();
    let problem = Problem::new(chain, data, &white, None);
    let found = minimise(&problem, &problem.point(from));
    let fit = describe(&problem, data, &found);
    if is_finite(&fit) { Ok(fit) } else { Err(not_finite(&chain.base, data)) }
}

fn is_finite(fit: &MotionFit) -> bool {
    let numbers = [fit.cost, fit.r_squared];
    numbers.iter().chain(&fit.values).all(|number| number.is_finite())
}

/// Squares of the data, or of what the law makes of them, that no number can hold.
fn not_finite(law: &BaseLaw, data: &Data) -> DataError {
    DataError::NotFinite { law: law.in_words(), hint: data.outlier().unwrap_or_default() }
}

/// Root mean square error on each trace when it is left out of the fit, the specimen's history kept.
/// A zero that each trace has of its own is taken from what that trace shows before its touch; what it
/// has more of its own stays as it was fitted.
#[must_use]
pub fn held_out(fit: &MotionFit, data: &Data) -> Vec<f64> {
    watch::stage("traces left out, each in turn", data.labels.len());
    (0..data.labels.len())
        .map(|trace| {
            let white = Whitening::none();
            let problem = Problem::new(&fit.chain, data, &white, Some(trace));
            let mut from = fit.values.clone();
            let own = fit.chain.own_of_trace(trace);
            let zero = own.len() == 1;
            if zero {
                from[own[0]] = 0.0;
            }
            let found = minimise(&problem, &problem.point(&from));
            let error = error_on(&problem, data, &found.point, trace, zero);
            watch::done();
            error
        })
        .collect()
}

/// Root mean square error over all traces from that on each; none where there is none.
#[must_use]
pub fn over_traces(trace_rms: &[f64], data: &Data) -> Option<f64> {
    let squares = |piece: &Piece| {
        trace_rms.get(piece.trace).map(|rms| rms * rms * piece.measured.len() as f64)
    };
    let sum = data.pieces.iter().map(squares).sum::<Option<f64>>()?;
    Some((sum / data.samples() as f64).sqrt())
}

/// Root mean square error on one trace, its own zero taken from before its touch where asked.
fn error_on(problem: &Problem, data: &Data, point: &[f64], trace: usize, tare: bool) -> f64 {
    let predicted = problem.predict(point);
    let mut residual = Vec::new();
    let mut before = Vec::new();
    for (piece, predicted) in data.pieces.iter().zip(&predicted) {
        if piece.trace == trace {
            let first = residual.len();
            residual.extend(predicted.iter().zip(piece.measured).map(|(f, y)| f - y));
            let touch = piece.motion.displacement.iter().position(|&x| x > 0.0);
            before.extend_from_slice(&residual[first..first + touch.unwrap_or(0)]);
        }
    }
    let zero = if tare && !before.is_empty() {
        before.iter().sum::<f64>() / before.len() as f64
    } else {
        0.0
    };
    let squares: f64 = residual.iter().map(|r| (r - zero).powi(2)).sum();
    (squares / (residual.len() as f64).max(1.0)).sqrt()
}

/// Predicted signal of every stretch of a data set.
#[must_use]
pub fn predict(chain: &Chain, parameters: &[f64], data: &Data) -> Vec<Vec<f64>> {
    let mut history = History::default();
    let (mut elasticity, mut force) = (Elasticity::default(), Vec::new());
    let stretch = |piece| {
        chain.run(parameters, &data.scene(piece), &mut history, &mut elasticity, &mut force);
        force.clone()
    };
    data.pieces.iter().map(stretch).collect()
}

fn check_size(chain: &Chain, data: &Data) -> Result<(), DataError> {
    let (samples, parameters) = (data.samples(), chain.parameters().len());
    if samples <= parameters {
        return Err(DataError::TooFew { samples, parameters });
    }
    Ok(())
}

fn describe(problem: &Problem, data: &Data, found: &Solution) -> MotionFit {
    let samples = data.samples();
    let cost = found.normal.cost;
    let bounds = problem.bounds();
    // What has no range is given, not held against a bound.
    let given = |j: usize| bounds[j].0 >= bounds[j].1;
    let held = &found.at_bound;
    let free = held.iter().filter(|held| !**held).count();
    let autocorrelation = problem.autocorrelation(&found.point);
    let variance = cost / (samples - free) as f64 / independent_share(autocorrelation);
    let known = uncertainty(&found.normal.curvature, held, variance);
    let rms = |(sum, count): &(f64, usize)| (sum / (*count as f64).max(1.0)).sqrt();
    let pressed: Vec<bool> = (0..held.len()).map(|j| held[j] && !given(j)).collect();
    let (standard_errors, correlation) = declared_uncertainty(problem, &found.point, &known);
    let mut fit = MotionFit {
        chain: problem.chain.clone(),
        values: problem.declared(&found.point),
        standard_errors,
        correlation,
        at_bound: declared_at_bound(problem, &pressed),
        cost,
        samples,
        r_squared: 1.0 - cost / scatter(data),
        autocorrelation,
        trace_rms: problem.trace_squares(&found.point).iter().map(rms).collect(),
        stop: found.stop,
        iterations: found.iterations,
    };
    sort_branches(&mut fit);
    fit
}

/// Standard errors and correlations in the model's own parameters, by the delta method.
#[must_use]
pub fn declared_uncertainty(
    problem: &Problem,
    point: &[f64],
    known: &Uncertainty,
) -> (Vec<Option<f64>>, DMatrix<f64>) {
    let dimension = point.len();
    let at = problem.declared(point);
    let mut slope = DMatrix::zeros(dimension, dimension);
    for j in 0..dimension {
        let step = 1e-6 * point[j].abs() + 1e-9;
        let mut moved = point.to_vec();
        moved[j] += step;
        for (row, value) in problem.declared(&moved).iter().enumerate() {
            slope[(row, j)] = (value - at[row]) / step;
        }
    }
    let covariance = &slope * &known.covariance * slope.transpose();
    let standard_errors = (0..dimension)
        .map(|row| known.variance(&slope.row(row).transpose()).map(f64::sqrt))
        .collect();
    let correlation = DMatrix::from_fn(dimension, dimension, |i, j| {
        let size = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
        if i == j {
            1.0
        } else if size > 0.0 {
            covariance[(i, j)] / size
        } else {
            0.0
        }
    });
    (standard_errors, correlation)
}

/// Coordinates on a bound, as parameters: a branch without force is a share at zero.
fn declared_at_bound(problem: &Problem, held: &[bool]) -> Vec<bool> {
    let base = problem.coordinates().bound_of_parameters();
    let effects = held[base.len()..].iter().copied();
    base.iter().map(|place| place.is_some_and(|j| held[j])).chain(effects).collect()
}

/// Sum of squares of the measured signal about its mean.
fn scatter(data: &Data) -> f64 {
    let values = || data.pieces.iter().flat_map(|piece| piece.measured);
    let mean = values().sum::<f64>() / data.samples() as f64;
    values().map(|value| (value - mean).powi(2)).sum()
}

/// Share of the samples that count as independent when neighbours correlate like a first-order
/// autoregression.
fn independent_share(autocorrelation: f64) -> f64 {
    let correlation = autocorrelation.clamp(0.0, 0.999);
    (1.0 - correlation) / (1.0 + correlation)
}

/// Puts the exponentials in the order of their rates, fast first.
fn sort_branches(fit: &mut MotionFit) {
    let base = fit.chain.base;
    let Some((shares, rates)) = base.branches() else { return };
    let speeds = base.constants(&fit.values).rates;
    let mut order: Vec<usize> = (0..base.terms).collect();
    order.sort_by(|&a, &b| speeds[b].total_cmp(&speeds[a]));
    let place: Vec<usize> = (0..shares)
        .chain(order.iter().map(|&k| shares + k))
        .chain(order.iter().map(|&k| rates + k))
        .chain(base.count()..fit.values.len())
        .collect();
    fit.values = place.iter().map(|&k| fit.values[k]).collect();
    fit.standard_errors = place.iter().map(|&k| fit.standard_errors[k]).collect();
    fit.at_bound = place.iter().map(|&k| fit.at_bound[k]).collect();
    let unsorted = fit.correlation.clone();
    fit.correlation =
        DMatrix::from_fn(place.len(), place.len(), |i, j| unsorted[(place[i], place[j])]);
}
