//! What `fit::exponentials` promises, measured on many noisy copies of known sums: the global
//! minimum (beside many starts of `rmpfit`), no bias, scatter at the Cramér–Rao bound, coverage.
//!
//! The ordinary tests use fewer copies than the ignored ones, which print the measured figures:
//! `cargo test --release -p palpate-tests --test exponentials -- --ignored --nocapture`.

use palpate::fit::exponentials::{
    Bound, ExponentialSum, Normalisation, Options, Parameter, Prepared, Sign, Term,
};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Normal};
use rayon::prelude::*;
use rmpfit::{MPConfig, MPFitter, MPPar, MPResult, MPSide};

// ---------------------------------------------------------------- signals

fn sum(constant: f64, terms: &[(f64, f64)]) -> ExponentialSum {
    let scale = constant + terms.iter().map(|term| term.0).sum::<f64>();
    ExponentialSum {
        scale,
        constant: constant / scale,
        terms: terms
            .iter()
            .map(|(amplitude, rate)| Term { coefficient: amplitude / scale, rate: *rate })
            .collect(),
    }
}

/// (3.5) and (3.6): the force, N.
fn force() -> ExponentialSum {
    ExponentialSum { scale: 2.187, ..sushi() }
}

/// (3.6) by itself, 2.187 times as hard to fit at the same noise.
fn sushi() -> ExponentialSum {
    sum(0.4852, &[(0.2472, 3.981), (0.2676, 0.5325)])
}

/// (A.3).
fn three() -> ExponentialSum {
    sum(0.8852, &[(0.4264, 4.009), (0.3421, 0.8896), (0.3399, 0.1758)])
}

/// Two rates 30 % apart.
fn close() -> ExponentialSum {
    sum(0.5, &[(0.3, 1.3), (0.2, 1.0)])
}

/// (B.2): creep, the amplitudes negative.
fn creep() -> ExponentialSum {
    sum(8.1, &[(-0.5977, 0.8229), (-1.733, 0.007805)])
}

fn uniform(samples: u32, rate: f64) -> Vec<f64> {
    (0..samples).map(|k| f64::from(k) / rate).collect()
}

/// 4.3 s at 200 Hz.
fn recording() -> Vec<f64> {
    uniform(860, 200.0)
}

/// 300 samples from 1 ms to 4.3 s, evenly spaced in the logarithm, after one at 0.
fn logarithmic() -> Vec<f64> {
    let decades = 4300_f64.log10();
    let later = (0..300).map(|k| 1e-3 * 10_f64.powf(decades * f64::from(k) / 299.0));
    std::iter::once(0.0).chain(later).collect()
}

/// Samples dropped and shifted at random, with a gap of a second.
fn ragged() -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut times = recording();
    times.retain(|t| (*t < 1.5 || *t > 2.5) && random.random_bool(0.7));
    times.iter().map(|t| t + 0.004 * random.random::<f64>()).collect()
}

fn noisy(
    sum: &ExponentialSum,
    times: &[f64],
    sd: f64,
    seed: u64,
) -> impl Iterator<Item = Vec<f64>> {
    let clean: Vec<f64> = times.iter().map(|t| sum.at(t - times[0])).collect();
    let noise = Normal::new(0.0, sd).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    std::iter::repeat_with(move || {
        clean.iter().map(|value| value + noise.sample(&mut random)).collect()
    })
}

// ---------------------------------------------------------------- the global minimum

/// Sums of squares by `rmpfit` with bounds and analytic derivatives: (A0, A_i, v_i).
struct Oracle<'a> {
    times: &'a [f64],
    values: &'a [f64],
    limits: Vec<MPPar>,
    config: MPConfig,
}

impl MPFitter for Oracle<'_> {
    fn eval(&mut self, p: &[f64], deviates: &mut [f64]) -> MPResult<()> {
        let terms = p.len() / 2;
        for ((deviate, t), y) in deviates.iter_mut().zip(self.times).zip(self.values) {
            let sum: f64 = (1..=terms).map(|i| p[i] * (-p[terms + i] * t).exp()).sum();
            *deviate = p[0] + sum - y;
        }
        Ok(())
    }

    fn number_of_points(&self) -> usize {
        self.times.len()
    }

    fn config(&self) -> &MPConfig {
        &self.config
    }

    fn parameters(&self) -> &[MPPar] {
        &self.limits
    }

    fn jacobian(
        &mut self,
        p: &[f64],
        deviates: &mut [f64],
        derivatives: &mut [Option<Vec<f64>>],
    ) -> MPResult<()> {
        self.eval(p, deviates)?;
        let terms = p.len() / 2;
        for (k, t) in self.times.iter().enumerate() {
            for i in 1..=terms {
                let value = (-p[terms + i] * t).exp();
                if let Some(column) = &mut derivatives[i] {
                    column[k] = value;
                }
                if let Some(column) = &mut derivatives[terms + i] {
                    column[k] = -p[i] * t * value;
                }
            }
            if let Some(column) = &mut derivatives[0] {
                column[k] = 1.0;
            }
        }
        Ok(())
    }
}

fn oracle(
    times: &[f64],
    values: &[f64],
    start: &[f64],
    options: &Options,
    rates: (f64, f64),
) -> f64 {
    let terms = start.len() / 2;
    let limits = (0..start.len())
        .map(|k| {
            let sign = if k == 0 { options.constant_sign } else { options.sign };
            let (low, high) = if k > terms {
                (Some(rates.0), Some(rates.1))
            } else {
                match sign {
                    Sign::Free => (None, None),
                    Sign::NotNegative => (Some(0.0), None),
                    Sign::NotPositive => (None, Some(0.0)),
                }
            };
            MPPar {
                limited_low: low.is_some(),
                limit_low: low.unwrap_or(0.0),
                limited_up: high.is_some(),
                limit_up: high.unwrap_or(0.0),
                side: MPSide::User,
                ..MPPar::default()
            }
        })
        .collect();
    let tight =
        MPConfig { ftol: 1e-14, xtol: 1e-14, gtol: 1e-14, max_iter: 500, ..MPConfig::new() };
    let mut parameters = start.to_vec();
    let status = Oracle { times, values, limits, config: tight }.mpfit(&mut parameters);
    status.map_or(f64::INFINITY, |status| status.best_norm)
}

/// Exact sum of squared residuals.
fn sum_of_squares(sum: &ExponentialSum, times: &[f64], values: &[f64]) -> f64 {
    times.iter().zip(values).map(|(t, y)| (y - sum.at(t - times[0])).powi(2)).sum()
}

/// How many copies end within 1e-6 of the least sum of squares found by any of the starts.
fn found(
    truth: &ExponentialSum,
    times: &[f64],
    sd: f64,
    options: &Options,
    copies: usize,
    starts: usize,
) -> (usize, f64) {
    let prepared = Prepared::new(times, options).unwrap();
    let since: Vec<f64> = times.iter().map(|t| t - times[0]).collect();
    let mut random = ChaCha8Rng::seed_from_u64(77);
    let mut successes = 0;
    let mut worst: f64 = 0.0;
    for values in noisy(truth, times, sd, 36).take(copies) {
        let fit = prepared.fit(&values).unwrap();
        let ours = sum_of_squares(&fit.sum, times, &values);
        let rates = prepared.rate_limits();
        let level = values.last().unwrap();
        let drop = values[0] - level;
        // From where we ended, from the truth, and from anywhere.
        let mut least = f64::INFINITY;
        let vector = |sum: &ExponentialSum| {
            let mut start = vec![sum.scale * sum.constant];
            start.extend(sum.terms.iter().map(|term| sum.scale * term.coefficient));
            start.extend(sum.terms.iter().map(|term| term.rate.clamp(rates.0, rates.1)));
            start
        };
        let mut all = vec![vector(&fit.sum)];
        if truth.terms.len() == options.terms {
            all.push(vector(truth));
        }
        for _ in 0..starts {
            let mut start = vec![*level];
            let share = drop / options.terms as f64;
            start.extend((0..options.terms).map(|_| 2.0 * share * random.random::<f64>()));
            let range = (rates.1 / rates.0).ln();
            start.extend(
                (0..options.terms).map(|_| rates.0 * (range * random.random::<f64>()).exp()),
            );
            all.push(start);
        }
        for start in all {
            // A start outside the limits is an error to rmpfit.
            let signed = |k: usize, value: f64| {
                let sign = if k == 0 { options.constant_sign } else { options.sign };
                match sign {
                    _ if k > options.terms => value.clamp(rates.0, rates.1),
                    Sign::Free => value,
                    Sign::NotNegative => value.max(0.0),
                    Sign::NotPositive => value.min(0.0),
                }
            };
            let start: Vec<f64> =
                start.into_iter().enumerate().map(|(k, value)| signed(k, value)).collect();
            least = least.min(oracle(&since, &values, &start, options, rates));
        }
        let excess = ours / least - 1.0;
        worst = worst.max(excess);
        assert!((fit.rss / ours - 1.0).abs() < 1e-6, "{} is not {ours}", fit.rss);

        successes += usize::from(excess < 1e-6);
    }
    (successes, worst)
}

/// Every scenario of the promise: name, truth, times, noise, terms.
fn scenarios() -> Vec<(&'static str, ExponentialSum, Vec<f64>, f64, usize)> {
    let mut all = Vec::new();
    for sd in [0.01, 0.001, 0.05, 0.1] {
        all.push(("(3.6)", sushi(), recording(), sd, 2));
    }
    all.push(("close rates", close(), recording(), 0.001, 2));
    all.push(("close rates", close(), recording(), 0.01, 2));
    all.push(("three", three(), recording(), 0.001, 3));
    all.push(("three", three(), recording(), 0.01, 3));
    all.push(("logarithmic", sushi(), logarithmic(), 0.01, 2));
    all.push(("ragged", sushi(), ragged(), 0.01, 2));
    all.push(("creep", creep(), uniform(1140, 120.0), 0.05, 2));
    all.push(("one too many", sushi(), recording(), 0.01, 3));
    all.push(("one too few", sushi(), recording(), 0.01, 1));
    all
}

fn reaches_the_global_minimum(copies: usize, starts: usize) {
    scenarios().into_par_iter().for_each(|(name, truth, times, sd, terms)| {
        let free = Options { terms, ..Options::default() };
        let signed = if truth.terms[0].coefficient < 0.0 {
            Options { terms, sign: Sign::NotPositive, ..Options::default() }
        } else {
            Options { terms, ..Options::relaxation() }
        };
        for (kind, options) in [("free", &free), ("signed", &signed)] {
            let (successes, worst) = found(&truth, &times, sd, options, copies, starts);
            println!(
                "{name}, noise {sd}, {kind}: {successes} of {copies}, worst excess {worst:.1e}"
            );
            assert_eq!(successes, copies, "{name}, noise {sd}, {kind}: excess {worst:e}");
        }
    });
}

#[test]
fn every_fit_is_the_best_of_many_starts() {
    reaches_the_global_minimum(4, 6);
}

#[test]
#[ignore = "1,000 copies of 26 scenarios with ten starts each take half an hour"]
fn a_thousand_fits_of_every_scenario_are_the_best_of_many_starts() {
    reaches_the_global_minimum(1000, 8);
}

// ---------------------------------------------------------------- statistics

struct Statistics {
    parameter: Parameter,
    /// Mean less truth, in units of the bound's standard error.
    bias: f64,
    /// Standard deviation over the bound's.
    scatter: f64,
    /// Share of copies whose 95 % interval covers the truth.
    coverage: f64,
}

fn statistics(truth: &ExponentialSum, times: &[f64], sd: f64, copies: usize) -> Vec<Statistics> {
    let prepared = Prepared::new(times, &Options::default()).unwrap();
    let bound = Bound::new(truth, times.iter().copied(), sd, Normalisation::Initial).unwrap();
    let parameters: Vec<Parameter> = Parameter::all(2).collect();
    let mut sums = vec![(0.0, 0.0, 0); parameters.len()];
    for values in noisy(truth, times, sd, 95).take(copies) {
        let fit = prepared.fit(&values).unwrap();
        for (sums, parameter) in sums.iter_mut().zip(&parameters) {
            let expected = truth.value(*parameter).unwrap();
            let error = fit.value(*parameter).unwrap() - expected;
            sums.0 += error;
            sums.1 += error * error;
            let interval = fit.interval(*parameter, 0.95);
            sums.2 += usize::from(interval.is_some_and(|(a, b)| a <= expected && expected <= b));
        }
    }
    let count = copies as f64;
    std::iter::zip(parameters, sums)
        .map(|(parameter, (first, second, covered))| {
            let mean: f64 = first / count;
            let least = bound.standard_error(parameter).unwrap();
            Statistics {
                parameter,
                bias: mean / least,
                scatter: (second / count - mean * mean).sqrt() / least,
                coverage: covered as f64 / count,
            }
        })
        .collect()
}

fn print(title: &str, statistics: &[Statistics]) {
    println!("{title}");
    for s in statistics {
        println!(
            "  {:<3} bias {:+.3} of the bound, scatter {:.3} of the bound, coverage {:.2} %",
            s.parameter.to_string(),
            s.bias,
            s.scatter,
            100.0 * s.coverage
        );
    }
}

fn is_efficient(truth: &ExponentialSum, times: &[f64], sd: f64, copies: usize) {
    let statistics = statistics(truth, times, sd, copies);
    print(&format!("noise {sd}, {copies} copies"), &statistics);
    for s in &statistics {
        assert!(s.bias.abs() < 0.08, "{}: bias {}", s.parameter, s.bias);
        assert!((s.scatter - 1.0).abs() < 0.05, "{}: scatter {}", s.parameter, s.scatter);
        assert!((0.94..=0.96).contains(&s.coverage), "{}: {}", s.parameter, s.coverage);
    }
}

#[test]
fn fits_are_unbiased_scatter_at_the_bound_and_cover_the_truth() {
    is_efficient(&force(), &recording(), 0.01, 10_000);
    is_efficient(&sushi(), &recording(), 0.001, 10_000);
    is_efficient(&sushi(), &logarithmic(), 0.002, 10_000);
}

#[test]
#[ignore = "prints measured figures, among them those at high noise, where linear theory fails"]
fn statistics_at_every_noise() {
    for sd in [0.01, 0.001, 0.05, 0.1] {
        for (name, truth) in [("force (3.5, 3.6)", force()), ("(3.6)", sushi())] {
            let title = format!("{name}, noise {sd}");
            print(&title, &statistics(&truth, &recording(), sd, 40_000));
        }
    }
}

/// Share of copies whose 95 % profile-likelihood interval covers the truth, for each parameter.
fn profile_coverage(sd: f64, options: &Options, copies: usize) -> Vec<(Parameter, f64)> {
    let (truth, times) = (sushi(), recording());
    let prepared = Prepared::new(&times, options).unwrap();
    let mut covered = vec![0; 6];
    for values in noisy(&truth, &times, sd, 41).take(copies) {
        let fit = prepared.fit(&values).unwrap();
        for (count, parameter) in covered.iter_mut().zip(Parameter::all(2)) {
            let interval = prepared.profile(&values, &fit, parameter, 0.95).unwrap();
            *count += usize::from(interval.covers(truth.value(parameter).unwrap()));
        }
    }
    Parameter::all(2).zip(covered.into_iter().map(|count| count as f64 / copies as f64)).collect()
}

#[test]
#[ignore = "4,000 copies at each noise take two minutes"]
fn profile_intervals_cover_the_truth_at_high_noise() {
    for (sd, copies) in [(0.01, 1000), (0.05, 4000), (0.1, 4000)] {
        for (kind, options) in [("free", Options::default()), ("signed", Options::relaxation())] {
            let coverage = profile_coverage(sd, &options, copies);
            let text: Vec<String> =
                coverage.iter().map(|(p, share)| format!("{p} {:.1}", 100.0 * share)).collect();
            println!("noise {sd}, {kind}, {copies} copies: {} %", text.join(", "));
            for (parameter, share) in coverage {
                // Binomial scatter of 1,000 copies is 0.7 %.
                assert!((0.93..=0.98).contains(&share), "{parameter} at {sd}, {kind}: {share}");
            }
        }
    }
}
