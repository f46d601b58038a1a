//! The fit of a model to whole motions: loading, holds and unloading of every trace together.
//!
//! Results are given in the model's own parameters, their covariance carried over from the
//! coordinates of the search ([`super::problem`]) by the delta method.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::compression::Compressed;
use super::data::{Data, DataError, Piece};
use super::fold::Fold;
use super::least_squares::{
    HARDLY, LeastSquares, Normal, Solution, Stop, bounded_step, finish, joined, minimise, race,
};
use super::problem::{Problem, Residuals};
use super::start::{Wanted, starts};
use super::uncertainty::{Uncertainty, uncertainty};
use super::watch;
use super::whitening::Whitening;
use palpate_model::{BaseLaw, Chain, Elasticity, FitRecord, History, Model, Parameter, Rung};
use palpate_trace::units;

/// What standard errors rest on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Basis {
    /// The residual, with neighbours that correlate counted as often as they are independent: right where the law
    /// leaves noise.
    Samples,
    /// The scatter of refits without each trace: right also where the law is inexact.
    Traces,
}

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
    /// What standard errors and correlations rest on.
    pub basis: Basis,
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

    /// The model file of this fit; with the noise of one sample where it is known, and the root mean square error on each
    /// trace left out in turn, empty for a single trace.
    #[must_use]
    pub fn model(&self, data: &Data, noise: Option<f64>, held_out: &[f64]) -> Model {
        let base = &self.chain.base;
        let mut model = Model::of(base, &data.signal, &self.values, &self.standard_errors);
        model.fit = Some(self.record(data, noise));
        model.ladder.push(Rung {
            add: base.name().into(),
            fitted_rms: self.rms(),
            heldout_rms: over_traces(held_out, data),
        });
        model
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
    let compressed = Compressed::coarse(data);
    let means = compressed.as_ref().map(|compressed| compressed.data(data));
    let few = compressed.as_ref().zip(means.as_ref());
    let few = few.map(|(compressed, means)| problem.on_means(compressed, means));
    let roots = compressed.as_ref().map_or(Vec::new(), Compressed::roots);
    let starts = |wanted| -> Vec<Vec<f64>> {
        let starts = starts(&law, means.as_ref().unwrap_or(data), &roots, wanted);
        starts.iter().map(|start| problem.point(start)).collect()
    };
    let far = few.unwrap_or_else(|| Problem::new(&chain, data, &white, None)).projecting();
    let raced = |wanted| race(&far, &starts(wanted));
    let mut kept = raced(Wanted::Likely);
    // Where no more than noise is left there is no other valley.
    if kept.first().is_some_and(|best| !leaves_noise(&far, &best.point, &roots)) {
        // Of two that are as low, what comes after goes on from the likelier.
        kept = joined(kept, raced(Wanted::Every));
    }
    let best = finish(&problem, &kept).ok_or(DataError::NothingLeft)?;
    tracing::info!(
        "{}, the best of {} valleys: {} after {} steps, sum of squares {:.6e}",
        law.in_words(),
        kept.len(),
        best.stop,
        best.iterations,
        best.normal.cost
    );
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

/// Least sum of squared differences of neighbours, over the sum of squares, of noise: two if it is white.
const OF_NOISE: f64 = 1.6;

/// Whether neighbours in what a point leaves in contact agree no more than in noise; the samples weigh as the squares of their `roots`.
fn leaves_noise(problem: &Problem, point: &[f64], roots: &[&[f64]]) -> bool {
    let (mut squares, mut differences) = (0.0, 0.0);
    for (index, residual) in problem.residuals(point).iter().enumerate() {
        let roots = roots.get(index).copied().unwrap_or_default();
        let motion = &problem.data().pieces[index].motion;
        let mut before = None;
        for (k, residual) in
            residual.iter().enumerate().filter(|(k, _)| motion.displacement[*k] > 0.0)
        {
            let value = roots.get(k).copied().unwrap_or(1.0) * residual;
            squares += value * value;
            differences += before.map_or(0.0, |before: f64| (value - before).powi(2));
            before = Some(value);
        }
    }
    differences > OF_NOISE * squares
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

/// Change of the prediction by one Gauss–Newton step, over the residual, up to which the step is the refit.
const SMALL: f64 = 0.01;

/// Root mean square error on each trace when it is left out of the fit, the specimen's history kept.
/// A zero that each trace has of its own is taken from what that trace shows before its touch; what it
/// has more of its own stays as it was fitted.
///
/// One step from the fit to all foretells the fit to the others; where that step is large, it is made.
#[must_use]
pub fn held_out(fit: &MotionFit, data: &Data) -> Vec<f64> {
    watch::stage("traces left out, each in turn", data.labels.len());
    let white = Whitening::none();
    let problem = Problem::new(&fit.chain, data, &white, None);
    let point = problem.point(&fit.values);
    let traces = problem.by_trace(&point);
    let mut all = Normal::zeros(point.len());
    for (trace, _) in &traces {
        all.add_times(trace, 1.0);
    }
    let bare = fit.chain.effects.is_empty();
    let compressed = Compressed::of(data).filter(|_| bare);
    let means = compressed.as_ref().map(|compressed| compressed.data(data));
    let few = compressed.as_ref().zip(means.as_ref());
    let few = few.map(|(compressed, means)| problem.on_means(compressed, means));
    // On the means a fit ends slightly elsewhere; by how much it moves without a trace is the same.
    let from = few.as_ref().map_or(point.clone(), |few| minimise(few, &point).point);
    let searched = few.as_ref().unwrap_or(&problem);
    let error = |trace: usize| {
        let (own, samples) = &traces[trace];
        let mut others = all.clone();
        others.add_times(own, -1.0);
        let step = bounded_step(&others, HARDLY, &point, problem.bounds());
        let change = step.dot(&(&all.curvature * &step));
        let belongs = fit.chain.own_of_trace(trace);
        let error = if belongs.is_empty() && change <= SMALL * SMALL * others.cost {
            let square = own.cost + own.raised_by(&step);
            (square.max(0.0) / (*samples as f64).max(1.0)).sqrt()
        } else {
            let zero = belongs.len() == 1;
            let start = from.iter().zip(step.iter()).enumerate().map(|(j, (x, dx))| {
                let own = belongs.contains(&j);
                if own && zero { 0.0 } else { x + if own { 0.0 } else { *dx } }
            });
            let found =
                minimise(&searched.leaving_out(Fold::alone(trace)), &start.collect::<Vec<_>>())
                    .point;
            let moved = point.iter().zip(&found).zip(&from).map(|((x, to), from)| x + (to - from));
            let moved =
                moved.zip(problem.bounds()).map(|(x, (lower, upper))| x.clamp(*lower, *upper));
            let reached = if few.is_some() { moved.collect() } else { found };
            error_on(&problem, data, &reached, trace, zero)
        };
        watch::done();
        error
    };
    (0..traces.len()).into_par_iter().map(error).collect()
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
            let touch = data.touch(piece);
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
    let Residuals { autocorrelation, trace_rms } = problem.residuals_in_short(&found.point);
    let variance = cost / (samples - free) as f64 / independent_share(autocorrelation);
    let known = uncertainty(&found.normal.curvature, held, variance);
    let pressed: Vec<bool> = (0..held.len()).map(|j| held[j] && !given(j)).collect();
    let (standard_errors, correlation) = declared_uncertainty(problem, &found.point, &known);
    let mut fit = MotionFit {
        chain: problem.chain.clone(),
        values: problem.declared(&found.point),
        standard_errors,
        correlation,
        basis: Basis::Samples,
        at_bound: declared_at_bound(problem, &pressed),
        cost,
        samples,
        r_squared: 1.0 - cost / scatter(data),
        autocorrelation,
        trace_rms,
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
    for (j, step) in problem.steps(point).into_iter().enumerate() {
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
pub(super) fn independent_share(autocorrelation: f64) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::warning::{Warning, warnings};
    use palpate_model::{Family, Motion, Separation};
    use palpate_trace::{DISPLACEMENT, FORCE, Trace};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use std::sync::Arc;

    /// What a law answers to a motion, with noise.
    fn noisy(
        (truth, constants): (BaseLaw, &[f64]),
        time: Vec<f64>,
        course: impl Fn(&f64) -> f64,
        random: &mut ChaCha8Rng,
    ) -> Trace {
        let x: Vec<f64> = time.iter().map(course).collect();
        let motion =
            Motion { time: time.clone().into(), displacement: x.clone().into(), rest_before: None };
        let force = truth.predict(constants, &[motion]).remove(0);
        let force = force.iter().map(|f| f + random.random_range(-0.03..0.03)).collect();
        let mut trace = Trace { time, ..Trace::default() };
        trace.set_column(DISPLACEMENT, x);
        trace.set_column(FORCE, force);
        trace
    }

    /// Presses of several depths into a specimen that relaxes twice, with noise.
    fn traces(count: usize) -> Vec<Trace> {
        let mut random = ChaCha8Rng::seed_from_u64(17);
        let truth = BaseLaw::fung(2, Separation::Clamp);
        let press = |trace: usize| {
            let time = (0..160).map(|k| 0.05 * f64::from(k)).collect();
            let deep = 2.0 + (trace % 5) as f64;
            let course = |t: &f64| (3.0 * t - 0.5).min(deep).min(24.0 - 3.5 * t);
            noisy((truth, &[0.3, 0.7, 0.25, 0.2, 4.0, 0.4]), time, course, &mut random)
        };
        (0..count).map(press).collect()
    }

    /// The error on each trace by a whole fit to the others.
    fn refitted(fit: &MotionFit, data: &Data) -> Vec<f64> {
        let white = Whitening::none();
        let error = |trace| {
            let problem = Problem::new(&fit.chain, data, &white, Some(Fold::alone(trace)));
            let found = minimise(&problem, &problem.point(&fit.values));
            error_on(&problem, data, &found.point, trace, false)
        };
        (0..data.labels.len()).map(error).collect()
    }

    #[test]
    fn the_error_on_a_trace_left_out_is_that_of_a_whole_fit_to_the_others() {
        // One exponential where there are two: the law is wrong, as laws are.
        for (count, law) in [(3, 1), (12, 1), (12, 2)] {
            let traces = traces(count);
            let data = Data::of(&traces, FORCE).unwrap();
            let fit = fit(BaseLaw::fung(law, Separation::Clamp), &data).unwrap();
            let (found, expected) = (held_out(&fit, &data), refitted(&fit, &data));
            for (found, expected) in found.iter().zip(&expected) {
                let off = (found / expected - 1.0).abs();
                assert!(off < 5e-4, "{count} traces: {found} for {expected}, off by {off:.1e}");
            }
        }
    }

    /// One long hold after a short press, and one at half the depth, with noise.
    fn holds() -> Vec<Trace> {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let truth = BaseLaw::fung(3, Separation::Clamp);
        let hold = |deep: f64| {
            let time = (0..8000).map(|k| 0.05 * f64::from(k)).collect();
            let course = |t: &f64| (2.0 * t - 1.0).min(deep);
            let constants = [0.3, 0.7, 0.2, 0.15, 0.1, 2.0, 0.1, 0.01];
            noisy((truth, &constants), time, course, &mut random)
        };
        [4.0, 2.0, 3.0].map(hold).to_vec()
    }

    #[test]
    fn a_search_on_block_means_ends_where_one_on_all_samples_does() {
        let traces = holds();
        let data = Data::of(&traces, FORCE).unwrap();
        let compressed = Compressed::of(&data).unwrap();
        assert!(20 * compressed.len() < data.samples(), "{}", compressed.len());
        for law in [BaseLaw::fung(2, Separation::Clamp), BaseLaw::fung(3, Separation::Clamp)] {
            let found = fit(law, &data).unwrap();
            let chain = Chain::new(law);
            let white = Whitening::none();
            let problem = Problem::new(&chain, &data, &white, None);
            let all = starts(&law, &data, &[], Wanted::Every);
            let alone = all.iter().map(|start| minimise(&problem, &problem.point(start)));
            let best = alone.map(|found| found.normal.cost).fold(f64::INFINITY, f64::min);
            assert!((found.cost / best - 1.0).abs() < 1e-9, "{} for {best}", found.cost);
            let (errors, expected) = (held_out(&found, &data), refitted(&found, &data));
            for (found, expected) in errors.iter().zip(&expected) {
                assert!((found / expected - 1.0).abs() < 1e-3, "{found} for {expected}");
            }
        }
    }

    /// Holds at several depths of a specimen that relaxes up to four times, left with play: more than a law with fewer rates describes.
    fn beyond(seed: u64) -> Vec<Trace> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let terms = random.random_range(2..5);
        let truth = BaseLaw::fung(terms, Separation::Clamp);
        let mut shares: Vec<f64> = (0..terms).map(|_| random.random_range(0.1..0.25)).collect();
        let fastest = random.random_range(2.0..20.0);
        let apart = random.random_range(4.0_f64..10.0);
        shares.extend((0..terms).map(|k| fastest / apart.powi(k as i32)));
        let p = random.random_range(0.3..3.0);
        let constants = [&[p, random.random_range(0.3..1.5)], &shares[..]].concat();
        let play = random.random_range(0.05..0.5);
        let lasts = [5.0, 20.0, 40.0][seed as usize % 3];
        let hold = |(deep, speed): (f64, f64)| {
            let time: Vec<f64> = (0..(75.0 * lasts) as usize).map(|k| 0.02 * k as f64).collect();
            let way =
                |t: &f64| (speed * (t - 1.0)).min(deep).min(deep - speed * (t - lasts)).max(-1.0);
            let felt = |t: &f64| way(t) - if *t < lasts { play } else { 0.0 };
            let mut trace = noisy((truth, &constants), time, felt, &mut random);
            let shown = trace.time.iter().map(way).collect();
            trace.set_column(DISPLACEMENT, shown);
            trace
        };
        [(12.0, 60.0), (3.0, 15.0), (9.0, 20.0), (6.0, 5.0)].map(hold).to_vec()
    }

    #[test]
    fn a_fit_ends_as_low_as_the_best_of_many_starts() {
        let mut random = ChaCha8Rng::seed_from_u64(8);
        for (seed, terms) in [2, 5, 11, 20].into_iter().flat_map(|seed| [(seed, 2), (seed, 3)]) {
            let traces = beyond(seed);
            let data = Data::of(&traces, FORCE).unwrap();
            let law = BaseLaw::fung(terms, Separation::Clamp);
            let found = fit(law, &data).unwrap();
            let mut best = f64::INFINITY;
            for _ in 0..15 {
                let rate = |_| 10.0_f64.powf(random.random_range(-2.0..1.5));
                let mut start = vec![found.values[0], found.values[1]];
                start.extend(std::iter::repeat_n(0.4 / terms as f64, terms));
                start.extend((0..terms).map(rate));
                best = best.min(refit(&Chain::new(law), &start, &data).unwrap().cost);
            }
            let over = found.cost / best;
            assert!(over < 1.001, "set {seed}, {terms} terms: {over:.4} times as much");
        }
    }

    #[test]
    fn the_means_tell_the_sum_of_squares_of_all_samples() {
        let traces = holds();
        let data = Data::of(&traces, FORCE).unwrap();
        let law = BaseLaw::fung(2, Separation::Clamp);
        let fit = fit(law, &data).unwrap();
        let chain = Chain::new(law);
        let white = Whitening::none();
        let problem = Problem::new(&chain, &data, &white, None);
        let compressed = Compressed::of(&data).unwrap();
        let means = compressed.data(&data);
        let few = problem.on_means(&compressed, &means);
        let point = problem.point(&fit.values);
        for part in [1.0, 0.98, 1.05] {
            let point: Vec<f64> = point.iter().map(|x| part * x).collect();
            let (all, few) = (problem.cost(&point), few.cost(&point));
            assert!((few / all - 1.0).abs() < 2e-3, "{few} for {all}");
        }
    }

    #[test]
    fn a_fit_that_leaves_noise_seeks_no_other_valley() {
        let traces = traces(12);
        let data = Data::of(&traces, FORCE).unwrap();
        let searches = |terms| {
            let seen = Arc::new(watch::Watch::default());
            watch::under(&seen, || fit(BaseLaw::fung(terms, Separation::Clamp), &data))
                .unwrap()
                .unwrap();
            seen.progress().0
        };
        let (right, wrong) = (searches(2), searches(1));
        assert!(
            right <= 2 * Wanted::Likely.most() && wrong > right,
            "{right} and {wrong} searches"
        );
    }

    #[test]
    fn traces_left_out_cost_no_refit_each() {
        let searches = |count: usize| {
            let traces = traces(count);
            let data = Data::of(&traces, FORCE).unwrap();
            let fit = fit(BaseLaw::fung(2, Separation::Clamp), &data).unwrap();
            let seen = Arc::new(watch::Watch::default());
            watch::under(&seen, || held_out(&fit, &data)).unwrap();
            seen.progress().0
        };
        let searches = searches(40);
        assert!(searches <= 4, "{searches} searches");
    }

    #[test]
    fn a_bonded_specimen_answers_a_motion_to_either_side() {
        // Two springs, one with a damper, and a motion that begins to the negative side.
        let (alone, spring, rate, interval): (f64, f64, f64, f64) = (0.8, 0.5, 1.5, 0.02);
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let decay = (-rate * interval).exp();
        let gain = (1.0 - decay) / (rate * interval);
        let (mut before, mut branch) = (0.0, 0.0);
        let mut trace = Trace::default();
        let (mut x, mut force) = (Vec::new(), Vec::new());
        for k in 0..1000 {
            let time = interval * f64::from(k);
            let now = -2.0 * (3.0 * (time - 1.0).max(0.0)).sin();
            branch = branch * decay + spring * gain * (now - before);
            before = now;
            trace.time.push(time);
            x.push(now);
            force.push(alone * now + branch + random.random_range(-0.01..0.01));
        }
        trace.set_column(DISPLACEMENT, x);
        trace.set_column(FORCE, force);
        let data = Data::of(std::slice::from_ref(&trace), FORCE).unwrap();
        let data = data.with_separation(Separation::Bonded);
        assert_eq!(data.touch(&data.pieces[0]), Some(51));
        let springs = BaseLaw::new(Family::GENERALIZED_MAXWELL, 1, Separation::Bonded);
        for (law, wanted) in [
            (springs, [alone, spring, spring / rate]),
            (
                BaseLaw::fung(1, Separation::Bonded),
                [alone + spring, 0.0, spring / (alone + spring)],
            ),
        ] {
            let found = fit(law, &data).unwrap();
            assert!(found.rms() < 0.006, "{}: {}", law.in_words(), found.rms());
            for (value, wanted) in found.values.iter().zip(wanted) {
                assert!((value - wanted).abs() < 0.01, "{}: {:?}", law.in_words(), found.values);
            }
        }
        // One who does not say that it is bonded is told.
        let told = |separation: Separation| {
            let law = BaseLaw::new(Family::GENERALIZED_MAXWELL, 1, separation);
            let data = data.clone().with_separation(separation);
            let found = warnings(&fit(law, &data).unwrap(), &data, None);
            found.iter().any(|warning| matches!(warning, Warning::PullsBelow { .. }))
        };
        assert!(told(Separation::Clamp) && !told(Separation::Bonded));
    }

    #[test]
    fn a_damper_follows_the_speed_at_each_sample() {
        // Sampled 25 times a cycle; the speed over the last interval is half an interval late.
        let mut random = ChaCha8Rng::seed_from_u64(9);
        let (stiffness, damping, turns) = (0.9, 0.12, 4.0 * std::f64::consts::PI);
        let time: Vec<f64> = (0..600).map(|k| 0.02 * f64::from(k)).collect();
        let x: Vec<f64> = time.iter().map(|t| 1.5 * (1.0 - (turns * t).cos())).collect();
        let mut noise = || random.random_range(-0.01..0.01);
        let force = time
            .iter()
            .zip(&x)
            .map(|(t, x)| stiffness * x + damping * 1.5 * turns * (turns * t).sin() + noise());
        let mut trace = Trace { time: time.clone(), ..Trace::default() };
        let force = force.collect();
        trace.set_column(DISPLACEMENT, x);
        trace.set_column(FORCE, force);
        let data = Data::of(std::slice::from_ref(&trace), FORCE).unwrap();
        let law = BaseLaw::new(Family::KELVIN_VOIGT, 1, Separation::Bonded);
        let found = fit(law, &data.clone().with_separation(Separation::Bonded)).unwrap();
        assert!(found.rms() < 0.02, "{}", found.rms());
        assert!((found.values[0] / stiffness - 1.0).abs() < 0.002, "{:?}", found.values);
        assert!((found.values[1] / damping - 1.0).abs() < 0.02, "{:?}", found.values);
    }
}
