//! A refit in which no sample has more than a bounded say: whether a few wild samples move the parameters.
//!
//! Huber's estimator by weighted refits in turn. A residual within [`TUNING`] standard deviations weighs one, a
//! larger one as much less as it is larger; the standard deviation comes from the median of their sizes, so that
//! wild samples do not set it (Huber 1964; Holland and Welsch 1977). At normal noise 95 % of the efficiency of
//! least squares remain.

use super::data::Data;
use super::least_squares::{Effort, LeastSquares, Solution, minimise_with};
use super::problem::Problem;
use super::uncertainty;
use super::whitening::Whitening;
use super::whole_motion::{MotionFit, declared_uncertainty, independent_share};

/// Standard deviations from which on a residual weighs less.
pub const TUNING: f64 = 1.345;
/// Standard deviation of normal noise over the median of its size.
const OF_MEDIAN: f64 = 1.482_602_218_505_602;
/// Most refits.
const MOST_ROUNDS: usize = 30;
/// A refit that moves the prediction by less than this part of a standard deviation, summed in squares over the
/// samples, is the last: no parameter then moves by more than this part of its standard error.
const SETTLED: f64 = 0.01;

/// A law refitted with bounded influence.
#[derive(Clone, Debug)]
pub struct Robust {
    /// The parameters, in the order of the fit that it began from.
    pub values: Vec<f64>,
    /// Their standard errors; none where the data do not determine the parameter.
    pub standard_errors: Vec<Option<f64>>,
    /// Standard deviation of a residual without the wild ones, in the unit of the signal.
    pub scale: f64,
    /// Weight of every sample, stretch by stretch, at most one.
    pub weights: Vec<Vec<f64>>,
}

impl Robust {
    /// Refits a law to the data that it was fitted to; none where more than half of the residuals are zero.
    #[must_use]
    pub fn of(fit: &MotionFit, data: &Data) -> Option<Self> {
        let white = Whitening::none();
        let problem = Problem::new(&fit.chain, data, &white, None);
        let start = problem.point(&fit.values);
        let mut residuals = problem.residuals(&start);
        let mut scale = deviation(&residuals)?;
        let (mut from, mut rounds) = (start, 0);
        let found = loop {
            let roots = each(&residuals, |r| weight(r, scale).sqrt());
            let found = minimise_with(&problem.weighted(&roots), &from, Effort::TRIAL);
            residuals = problem.residuals(&found.point);
            scale = deviation(&residuals)?;
            rounds += 1;
            if rounds == MOST_ROUNDS || moved(&found, &from) <= (SETTLED * scale).powi(2) {
                break found;
            }
            from.clone_from(&found.point);
        };
        Some(Self {
            values: problem.declared(&found.point),
            standard_errors: standard_errors(&problem, &found, &residuals, scale),
            weights: each(&residuals, |r| weight(r, scale)),
            scale,
        })
    }

    /// By how many of its standard errors each parameter of a fit lies off the refit; none where the data do not
    /// determine it.
    #[must_use]
    pub fn off(&self, fit: &MotionFit) -> Vec<Option<f64>> {
        let pairs = fit.values.iter().zip(&self.values).zip(&self.standard_errors);
        pairs.map(|((fitted, own), error)| error.map(|error| (fitted - own) / error)).collect()
    }
}

fn weight(residual: f64, scale: f64) -> f64 {
    (TUNING * scale / residual.abs()).min(1.0)
}

fn each(residuals: &[Vec<f64>], of: impl Fn(f64) -> f64) -> Vec<Vec<f64>> {
    residuals.iter().map(|stretch| stretch.iter().map(|r| of(*r)).collect()).collect()
}

/// Standard deviation of normal residuals with this median of their size; none where that is zero.
fn deviation(residuals: &[Vec<f64>]) -> Option<f64> {
    let mut sizes: Vec<f64> = residuals.iter().flatten().map(|r| r.abs()).collect();
    let middle = sizes.len() / 2;
    if sizes.is_empty() {
        return None;
    }
    let median = *sizes.select_nth_unstable_by(middle, f64::total_cmp).1;
    (median > 0.0 && median.is_finite()).then_some(OF_MEDIAN * median)
}

/// Sum of squares by which a solution's prediction differs from that at a point.
fn moved(found: &Solution, from: &[f64]) -> f64 {
    let away = found.point.iter().zip(from).map(|(to, from)| to - from);
    let away = nalgebra::DVector::from_iterator(from.len(), away);
    away.dot(&(&found.normal.curvature * &away))
}

/// Standard errors of Huber's estimator, with neighbours that correlate counted as often as they are independent.
fn standard_errors(
    problem: &Problem,
    found: &Solution,
    residuals: &[Vec<f64>],
    scale: f64,
) -> Vec<Option<f64>> {
    let bounded = each(residuals, |r| r * weight(r, scale));
    let samples = residuals.iter().map(Vec::len).sum::<usize>() as f64;
    let free = found.at_bound.iter().filter(|held| !**held).count() as f64;
    let squares: f64 = bounded.iter().flatten().map(|r| r * r).sum();
    let products: f64 =
        bounded.iter().flat_map(|stretch| stretch.windows(2)).map(|pair| pair[0] * pair[1]).sum();
    let within =
        residuals.iter().flatten().filter(|r| r.abs() <= TUNING * scale).count() as f64 / samples;
    let independent = independent_share(products / squares.max(f64::MIN_POSITIVE));
    let variance = squares / (samples - free).max(1.0) / within.powi(2) / independent;
    let curvature = problem.normal(&found.point).curvature;
    let known = uncertainty(&curvature, &found.at_bound, variance);
    declared_uncertainty(problem, &found.point, &known).0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::whole_motion::fit;
    use palpate_model::{BaseLaw, Motion, Separation};
    use palpate_trace::{DISPLACEMENT, FORCE, Trace};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const LAW: BaseLaw = BaseLaw::fung(1, Separation::Clamp);
    const TRUTH: [f64; 4] = [0.3, 0.7, 0.3, 1.5];

    /// Three presses with even noise, and some samples of the force that are `wild` N off.
    fn presses(seed: u64, wild: f64) -> Vec<Trace> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let press = |deep: f64| {
            let time: Vec<f64> = (0..300).map(|k| 0.02 * f64::from(k)).collect();
            let x: Vec<f64> =
                time.iter().map(|t| (5.0 * t - 0.5).min(deep).min(26.0 - 5.0 * t)).collect();
            let motion =
                Motion { time: (&time).into(), displacement: (&x).into(), rest_before: None };
            let force = LAW.predict(&TRUTH, &[motion]).remove(0);
            let noisy = |(k, f): (usize, &f64)| {
                let off = if k % 75 == 40 { wild } else { 0.0 };
                f + off + 0.02 * (0..12).map(|_| random.random_range(-0.5..0.5)).sum::<f64>()
            };
            let force = force.iter().enumerate().map(noisy).collect();
            let mut trace = Trace { time: time.clone(), ..Trace::default() };
            trace.set_column(DISPLACEMENT, x);
            trace.set_column(FORCE, force);
            trace
        };
        [3.0, 4.0, 5.0].map(press).to_vec()
    }

    /// Off the truth, in standard errors of the refit: least squares and the refit.
    fn off_the_truth(wild: f64) -> (Vec<f64>, Vec<f64>) {
        let (mut fitted, mut robust) = (Vec::new(), Vec::new());
        for seed in 0..20 {
            let traces = presses(seed, wild);
            let data = Data::of(&traces, FORCE).unwrap();
            let fit = fit(LAW, &data).unwrap();
            let found = Robust::of(&fit, &data).unwrap();
            for (k, truth) in TRUTH.iter().enumerate() {
                let error = found.standard_errors[k].unwrap();
                fitted.push((fit.values[k] - truth) / error);
                robust.push((found.values[k] - truth) / error);
            }
        }
        (fitted, robust)
    }

    fn rms(off: &[f64]) -> f64 {
        (off.iter().map(|z| z * z).sum::<f64>() / off.len() as f64).sqrt()
    }

    #[test]
    fn a_few_wild_samples_move_the_fit_and_hardly_the_refit() {
        let (fitted, robust) = off_the_truth(1.5);
        assert!(rms(&fitted) > 5.0, "{}", rms(&fitted));
        assert!(rms(&robust) < 1.6, "{}", rms(&robust));
    }

    #[test]
    fn without_wild_samples_its_standard_errors_hold() {
        let (fitted, robust) = off_the_truth(0.0);
        assert!((0.75..1.25).contains(&rms(&robust)), "{}", rms(&robust));
        assert!(rms(&fitted) < 1.25, "{}", rms(&fitted));
    }

    #[test]
    fn the_wild_samples_are_those_of_little_weight() {
        let traces = presses(3, 1.5);
        let data = Data::of(&traces, FORCE).unwrap();
        let found = Robust::of(&fit(LAW, &data).unwrap(), &data).unwrap();
        for (k, weight) in found.weights.concat().iter().enumerate() {
            assert_eq!(*weight < 0.05, k % 75 == 40, "{k}: {weight}");
        }
        assert!((found.scale / 0.02 - 1.0).abs() < 0.15, "{}", found.scale);
    }
}
