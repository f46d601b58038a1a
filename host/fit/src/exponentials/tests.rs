use super::*;
use proptest::prelude::*;

fn uniform(samples: u32, rate: f64) -> Vec<f64> {
    (0..samples).map(|k| f64::from(k) / rate).collect()
}

fn sum(constant: f64, terms: &[(f64, f64)]) -> ExponentialSum {
    let scale = constant + terms.iter().map(|term| term.0).sum::<f64>();
    let term =
        |(amplitude, rate): &(f64, f64)| Term { coefficient: amplitude / scale, rate: *rate };
    ExponentialSum { scale, constant: constant / scale, terms: terms.iter().map(term).collect() }
}

/// (3.6).
fn sushi() -> ExponentialSum {
    sum(0.4852, &[(0.2472, 3.981), (0.2676, 0.5325)])
}

fn sampled(sum: &ExponentialSum, times: &[f64]) -> Vec<f64> {
    times.iter().map(|t| sum.at(*t)).collect()
}

/// Something like noise, the same on every run, of standard deviation `sd`.
fn disturbed(sum: &ExponentialSum, times: &[f64], sd: f64) -> Vec<f64> {
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let noise = Normal::new(0.0, sd).unwrap();
    sampled(sum, times).into_iter().map(|value| value + noise.sample(&mut random)).collect()
}

fn fit(times: &[f64], values: &[f64], options: &Options) -> Fit {
    Prepared::new(times, options).unwrap().fit(values).unwrap()
}

fn terms(terms: usize) -> Options {
    Options { terms, ..Options::default() }
}

#[track_caller]
fn assert_close(a: f64, b: f64, relative: f64) {
    assert!((a - b).abs() <= relative * b.abs(), "{a} is not {b}");
}

#[test]
fn a_sum_without_noise_comes_back() {
    let times = uniform(860, 200.0);
    for (truth, precision) in [
        (sum(0.5, &[(0.5, 1.2)]), 1e-8),
        (sushi(), 1e-6),
        (sum(0.8852, &[(0.4264, 4.009), (0.3421, 0.8896), (0.3399, 0.1758)]), 1e-3),
    ] {
        let fit = fit(&times, &sampled(&truth, &times), &terms(truth.terms.len()));
        for parameter in fit.parameters() {
            assert_close(fit.value(parameter).unwrap(), truth.value(parameter).unwrap(), precision);
        }
        assert!(fit.residual_rms < 1e-9, "{}", fit.residual_rms);
        assert!(fit.notes.is_empty(), "{:?}", fit.notes);
        assert_eq!(fit.stop, Stop::Converged);
    }
}

#[test]
fn a_single_fit_is_that_after_preparing_for_many() {
    let uneven: Vec<f64> = uniform(700, 160.0).iter().map(|t| t + 0.1 * t * t).collect();
    for times in [uniform(860, 200.0), uneven, uniform(6_000, 1_000.0)] {
        for options in [terms(1), terms(2), Options::relaxation()] {
            for sd in [1e-4, 0.01] {
                let values = disturbed(&sushi(), &times, sd);
                let alone = Prepared::for_one(&times, &options).unwrap().fit(&values).unwrap();
                let fit = fit(&times, &values, &options);
                assert_eq!(alone.notes, fit.notes);
                assert_close(alone.rss, fit.rss, 1e-6);
                for parameter in fit.parameters() {
                    let value = fit.value(parameter).unwrap();
                    let most =
                        fit.standard_error(parameter).map_or(1e-6 * value.abs(), |e| 1e-3 * e);
                    let off = (alone.value(parameter).unwrap() - value).abs();
                    assert!(off <= most, "{parameter} of {} samples: {off:.1e}", times.len());
                    let errors = [&alone, &fit].map(|fit| fit.standard_error(parameter));
                    if let [Some(own), Some(error)] = errors {
                        assert_close(own, error, 1e-4);
                    }
                }
            }
        }
    }
}

#[test]
fn a_single_fit_finds_a_sum_without_noise() {
    let times = uniform(860, 200.0);
    let alone = Prepared::for_one(&times, &terms(2)).unwrap();
    let fit = alone.fit(&sampled(&sushi(), &times)).unwrap();
    for parameter in fit.parameters() {
        assert_close(fit.value(parameter).unwrap(), sushi().value(parameter).unwrap(), 1e-6);
    }
    assert!(fit.residual_rms < 1e-9, "{}", fit.residual_rms);
}

#[test]
fn coefficients_add_to_one_and_rates_descend() {
    let times = uniform(860, 200.0);
    for n in 1..=4 {
        let fit = fit(&times, &disturbed(&sushi(), &times, 0.02), &terms(n));
        let coefficients: f64 = fit.sum.terms.iter().map(|term| term.coefficient).sum();
        assert_close(fit.sum.constant + coefficients, 1.0, 1e-9);
        assert!(fit.sum.terms.windows(2).all(|pair| pair[0].rate > pair[1].rate));
    }
}

#[test]
fn more_terms_than_the_signal_has_are_a_fit_with_a_note_and_not_a_failure() {
    let times = uniform(860, 200.0);
    let prepared = Prepared::new(&times, &terms(4)).unwrap();
    for sd in [0.003, 0.01, 0.03] {
        let values = disturbed(&sushi(), &times, sd);
        let fit = prepared.fit(&values).unwrap();
        let weak = (1..=4).map(Parameter::Coefficient).any(|parameter| {
            let error = fit.standard_error(parameter).unwrap_or(f64::INFINITY);
            error > 0.3 * fit.value(parameter).unwrap().abs()
        });
        assert!(!fit.notes.is_empty() || weak, "{fit:?}");
        let exact: f64 = times.iter().zip(&values).map(|(t, y)| (y - fit.sum.at(*t)).powi(2)).sum();
        assert_close(fit.rss, exact, 1e-6);
    }
}

#[test]
fn standard_errors_are_those_of_the_full_jacobian() {
    let times = uniform(300, 70.0);
    for normalisation in [Normalisation::Initial, Normalisation::Asymptotic] {
        let options = Options { normalisation, ..Options::default() };
        let fit = fit(&times, &disturbed(&sushi(), &times, 0.003), &options);
        let bound = Bound::new(&fit.sum, times.iter().copied(), fit.noise, normalisation).unwrap();
        for a in fit.parameters() {
            for b in fit.parameters() {
                let Some(covariance) = fit.covariance(a, b) else {
                    assert_eq!(normalisation, Normalisation::Asymptotic);
                    continue;
                };
                let size = fit.standard_error(a).unwrap() * fit.standard_error(b).unwrap();
                assert!((covariance - bound.covariance(a, b).unwrap()).abs() < 1e-6 * size);
            }
        }
    }
}

#[test]
fn one_exponential_on_row_05_gives_what_appendix_a_prints() {
    // Row 05 of Table 3.1, sampled as recorded: (A.1) is what one exponential makes of it.
    let row = sum(0.9987, &[(0.4780, 3.672), (0.5144, 0.5145)]);
    let times = uniform(860, 200.0);
    let terms = Prepared::new(&times, &terms(2)).unwrap();
    let table = terms.compare_terms(&disturbed(&row, &times, 0.005)).unwrap();
    let one = &table.rows[0].fit.sum;
    assert_close(one.scale * one.constant, 1.087, 0.01);
    assert_close(one.scale * one.terms[0].coefficient, 0.782, 0.01);
    assert_close(one.terms[0].rate, 1.208, 0.03);
    assert_eq!(table.chosen, 2);
}

#[test]
fn the_number_of_terms_is_that_of_the_signal() {
    let times = uniform(860, 200.0);
    let prepared = Prepared::new(&times, &terms(4)).unwrap();
    let one = sum(0.5, &[(0.5, 1.2)]);
    let three = sum(0.5, &[(0.3, 20.0), (0.3, 2.5), (0.3, 0.5)]);
    for (truth, expected) in [(one, 1), (sushi(), 2), (three, 3)] {
        let table = prepared.compare_terms(&disturbed(&truth, &times, 0.002)).unwrap();
        assert_eq!(table.chosen, expected);
        assert_eq!(table.rows.len(), 4);
        assert!(
            table.rows.windows(2).all(|rows| rows[1].fit.rss <= rows[0].fit.rss * (1.0 + 1e-9))
        );
        assert_eq!(table.best().sum.terms.len(), expected);
    }
}

#[test]
fn a_coefficient_that_its_sign_forbids_is_held_at_zero_and_said_so() {
    let times = uniform(860, 200.0);
    let rising = sum(1.0, &[(-0.3, 2.0), (0.2, 0.4)]);
    let fit = fit(&times, &disturbed(&rising, &times, 0.001), &Options::relaxation());
    let held: Vec<usize> =
        (1..=2).filter(|term| fit.notes.contains(&Note::Vanishes { term: *term })).collect();
    assert!(!held.is_empty(), "{:?}", fit.notes);
    for term in held {
        assert_eq!(fit.value(Parameter::Coefficient(term)), Some(0.0));
        assert_eq!(fit.standard_error(Parameter::Coefficient(term)), None);
        assert_eq!(fit.standard_error(Parameter::Rate(term)), None);
    }
    assert!(fit.sum.terms.iter().all(|term| term.coefficient >= 0.0));
}

#[test]
fn a_constant_that_its_sign_forbids_is_held_at_zero_and_said_so() {
    let times = uniform(860, 200.0);
    let below = sum(-0.1, &[(0.5, 2.0), (0.7, 0.4)]);
    let values = disturbed(&below, &times, 0.001);
    let fit = fit(&times, &values, &Options::relaxation());
    assert!(fit.notes.contains(&Note::ConstantAtZero), "{:?}", fit.notes);
    assert_eq!(fit.sum.constant, 0.0);
    assert_eq!(fit.standard_error(Parameter::Coefficient(0)), None);
    assert!(fit.standard_error(Parameter::Rate(1)).is_some());
}

#[test]
fn rates_that_coincide_are_said_to() {
    // t e^(−v t) is the limit of two exponentials with the same rate.
    let times = uniform(860, 200.0);
    let values: Vec<f64> = times.iter().map(|t| 0.5 + (0.3 + t) * (-1.5 * t).exp()).collect();
    let fit = fit(&times, &values, &Options::default());
    assert!(fit.notes.contains(&Note::Coincide { first: 1, second: 2 }), "{:?}", fit.notes);
    assert_close(fit.sum.terms[0].rate, 1.5, 2e-3);
    assert_eq!(fit.standard_error(Parameter::Coefficient(1)), None);
    assert!(fit.r_squared > 0.999_999);
}

#[test]
fn rates_beyond_their_limits_are_held_there_and_said_so() {
    let times = uniform(400, 100.0);
    let limits = |slowest, fastest| Options {
        terms: 1,
        slowest: Some(slowest),
        fastest: Some(fastest),
        ..Options::default()
    };
    let values = sampled(&sum(0.5, &[(0.5, 2.0)]), &times);
    let slow = fit(&times, &values, &limits(3.0, 30.0));
    assert_eq!(slow.notes, [Note::AtSlowest { term: 1 }]);
    assert_close(slow.sum.terms[0].rate, 3.0, 1e-12);
    assert_eq!(slow.standard_error(Parameter::Rate(1)), None);
    let fast = fit(&times, &values, &limits(0.1, 1.0));
    assert_eq!(fast.notes, [Note::AtFastest { term: 1 }]);
    assert_close(fast.sum.terms[0].rate, 1.0, 1e-12);
}

#[test]
fn a_force_recorded_as_negative_has_the_same_coefficients() {
    let times = uniform(860, 200.0);
    let values = disturbed(&sushi(), &times, 0.01);
    let negative: Vec<f64> = values.iter().map(|value| -value).collect();
    let a = fit(&times, &values, &Options::relaxation());
    let b = fit(&times, &negative, &Options::relaxation());
    assert_close(b.sum.scale, -a.sum.scale, 1e-9);
    assert_close(b.sum.terms[1].coefficient, a.sum.terms[1].coefficient, 1e-9);
}

#[test]
fn a_large_offset_and_a_late_start_cost_no_precision() {
    let times = uniform(860, 200.0);
    let values = disturbed(&sushi(), &times, 0.01);
    let plain = fit(&times, &values, &Options::default());
    let high: Vec<f64> = values.iter().map(|value| value + 1e5).collect();
    let late: Vec<f64> = times.iter().map(|time| time + 1000.0).collect();
    let moved = fit(&late, &high, &Options::default());
    assert_close(moved.rss, plain.rss, 1e-8);
    assert_close(moved.sum.terms[0].rate, plain.sum.terms[0].rate, 1e-5);
}

#[test]
fn a_weight_of_zero_leaves_a_sample_out_and_only_proportions_count() {
    let times = uniform(400, 100.0);
    let mut values = disturbed(&sushi(), &times, 0.01);
    let options = Options { slowest: Some(0.01), fastest: Some(20.0), ..Options::default() };
    let kept: Vec<usize> = (0..400).filter(|k| k % 7 != 3).collect();
    let pick = |all: &[f64]| kept.iter().map(|k| all[*k]).collect::<Vec<_>>();
    let without = fit(&pick(&times), &pick(&values), &options);
    let weights: Vec<f64> = (0..400).map(|k| if k % 7 == 3 { 0.0 } else { 5.0 }).collect();
    for k in (3..400).step_by(7) {
        values[k] = 99.0;
    }
    let weighted = Prepared::weighted(&times, &weights, &options).unwrap().fit(&values).unwrap();
    assert_close(weighted.rss, without.rss, 1e-6);
    assert_close(weighted.sum.terms[1].rate, without.sum.terms[1].rate, 1e-5);
    assert_eq!(weighted.degrees_of_freedom, without.degrees_of_freedom);
    let error = |fit: &Fit| fit.standard_error(Parameter::Rate(2)).unwrap();
    assert_close(error(&weighted), error(&without), 1e-5);
}

#[test]
fn rates_over_many_decades_come_back_from_logarithmic_sampling() {
    let times: Vec<f64> =
        (0..400).map(|k| 10_f64.powf(-3.0 + f64::from(k) / 399.0 * 6.0)).collect();
    let truth = sum(0.4, &[(0.3, 40.0), (0.3, 0.02)]);
    let fit = fit(&times, &sampled(&truth, &times), &Options::default());
    // Coefficients refer to the first sample, 1 ms.
    assert_close(fit.sum.terms[0].rate, 40.0, 1e-5);
    assert_close(fit.sum.terms[1].rate, 0.02, 1e-5);
    let amplitude = fit.sum.scale * fit.sum.terms[0].coefficient;
    assert_close(amplitude, 0.3 * (-0.04_f64).exp(), 1e-5);
}

#[test]
fn creep_has_a_constant_of_one_and_negative_coefficients() {
    // (B.2), first term only.
    let times = uniform(1140, 120.0);
    let truth = sum(6.48, &[(-0.6787, 0.5907)]);
    let options = Options {
        terms: 1,
        sign: Sign::NotPositive,
        normalisation: Normalisation::Asymptotic,
        ..Options::default()
    };
    let fit = fit(&times, &disturbed(&truth, &times, 0.01), &options);
    assert_eq!(fit.sum.constant, 1.0);
    assert_close(fit.sum.scale, 6.48, 1e-3);
    assert_close(fit.sum.terms[0].coefficient, -0.6787 / 6.48, 0.02);
    assert_eq!(fit.standard_error(Parameter::Coefficient(0)), None);
}

#[test]
fn intervals_of_both_kinds_agree_where_noise_is_low() {
    let times = uniform(860, 200.0);
    let values = disturbed(&sushi(), &times, 0.001);
    let prepared = Prepared::new(&times, &Options::relaxation()).unwrap();
    let fit = prepared.fit(&values).unwrap();
    for parameter in fit.parameters() {
        let (lower, upper) = fit.interval(parameter, 0.95).unwrap();
        let profile = prepared.profile(&values, &fit, parameter, 0.95).unwrap();
        let width = upper - lower;
        assert!((profile.lower.unwrap() - lower).abs() < 0.02 * width, "{parameter}");
        assert!((profile.upper.unwrap() - upper).abs() < 0.02 * width, "{parameter}");
    }
}

#[test]
fn every_unusable_input_has_its_reason() {
    let times = uniform(100, 10.0);
    let values = sampled(&sushi(), &times);
    let options = Options::default();
    let changed = |k: usize, value: f64, of: &[f64]| {
        let mut of = of.to_vec();
        of[k] = value;
        of
    };
    let prepare = |times: &[f64]| Prepared::new(times, &options).unwrap_err();
    assert_eq!(prepare(&[]), Error::TooFewSamples { samples: 0, terms: 2, needed: 6 });
    assert_eq!(prepare(&times[..5]), Error::TooFewSamples { samples: 5, terms: 2, needed: 6 });
    assert_eq!(prepare(&changed(7, f64::NAN, &times)), Error::TimeNotFinite { sample: 7 });
    assert_eq!(prepare(&changed(7, times[6], &times)), Error::TimeNotIncreasing { sample: 7 });
    for n in [0, 5] {
        assert_eq!(Prepared::new(&times, &terms(n)).unwrap_err(), Error::Terms { terms: n });
    }
    let limits = |slowest, fastest| {
        let limits =
            Options { slowest: Some(slowest), fastest: Some(fastest), ..Options::default() };
        Prepared::new(&times, &limits).unwrap_err()
    };
    assert_eq!(limits(2.0, 1.0), Error::RateLimits { slowest: 2.0, fastest: 1.0 });
    assert!(matches!(limits(f64::NAN, 1.0), Error::RateLimits { .. }));
    assert!(matches!(limits(0.0, 1.0), Error::RateLimits { .. }));
    let ages: Vec<f64> = (0..400).map(|k| 10_f64.powf(f64::from(k) / 20.0)).collect();
    assert!(matches!(prepare(&ages), Error::TooWide { .. }));
    let weights = |weights: &[f64]| Prepared::weighted(&times, weights, &options).unwrap_err();
    assert!(matches!(weights(&[1.0]), Error::Lengths { times: 100, other: 1, .. }));
    assert_eq!(weights(&changed(3, -1.0, &times)), Error::Weight { sample: 3 });
    assert!(matches!(weights(&vec![0.0; 100]), Error::TooFewSamples { samples: 0, .. }));

    let prepared = Prepared::new(&times, &options).unwrap();
    let refused = |values: &[f64]| prepared.fit(values).unwrap_err();
    assert!(matches!(refused(&values[1..]), Error::Lengths { times: 100, other: 99, .. }));
    let infinite = changed(42, f64::INFINITY, &values);
    assert_eq!(refused(&infinite), Error::ValueNotFinite { sample: 42 });
    assert_eq!(refused(&changed(0, f64::NAN, &values)), Error::ValueNotFinite { sample: 0 });
    assert_eq!(refused(&[3.7; 100]), Error::ConstantSignal);
    assert_eq!(refused(&[0.0; 100]), Error::ConstantSignal);
    let scaled = |factor: f64| values.iter().map(|value| value * factor).collect::<Vec<_>>();
    assert_eq!(refused(&scaled(1e200)), Error::Magnitude);
    assert_eq!(refused(&scaled(1e-200)), Error::Magnitude);
    let from_zero: Vec<f64> = times.iter().map(|t| 1.0 - (-2.0 * t).exp()).collect();
    let one = Prepared::new(&times, &terms(1)).unwrap();
    assert!(matches!(one.fit(&from_zero), Err(Error::ZeroScale { .. })));
    let fit = prepared.fit(&values).unwrap();
    let profile = |parameter, level| prepared.profile(&values, &fit, parameter, level).unwrap_err();
    assert!(matches!(profile(Parameter::Rate(3), 0.95), Error::NoSuchParameter { .. }));
    assert!(matches!(profile(Parameter::Rate(1), 1.0), Error::Argument { .. }));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// Whatever the times and values, a fit is finite in every number or has a reason.
    #[test]
    fn no_input_gives_a_number_that_is_not_finite(
        steps in prop::collection::vec(1e-3_f64..1.0, 10..40),
        seed in prop::collection::vec(-10.0_f64..10.0, 40),
        n in 1_usize..=4,
        signed in any::<bool>(),
        asymptotic in any::<bool>(),
        smooth in any::<bool>(),
    ) {
        let mut time = 0.0;
        let times: Vec<f64> = steps.iter().map(|step| { time += step; time }).collect();
        let values: Vec<f64> = times
            .iter()
            .zip(&seed)
            .map(|(t, s)| if smooth { seed[0] + seed[1] * (-seed[2].abs() * t).exp() } else { *s })
            .collect();
        let sign = if signed { Sign::NotNegative } else { Sign::Free };
        let normalisation =
            if asymptotic { Normalisation::Asymptotic } else { Normalisation::Initial };
        let options =
            Options { terms: n, sign, constant_sign: sign, normalisation, ..Options::default() };
        let fit = Prepared::new(&times, &options).unwrap().fit(&values);
        if let Ok(fit) = fit {
            for parameter in fit.parameters() {
                prop_assert!(fit.value(parameter).unwrap().is_finite());
                let error = fit.standard_error(parameter);
                prop_assert!(error.is_none_or(f64::is_finite), "{parameter}: {error:?}");
            }
            let parts = [fit.rss, fit.noise, fit.residual_rms, fit.r_squared];
            prop_assert!(parts.iter().all(|part| part.is_finite()));
            prop_assert!(fit.rss >= 0.0);
        }
    }
}

#[test]
fn a_long_hold_on_its_means_is_fitted_as_its_samples_are() {
    let times = uniform(20_000, 50.0);
    let truth = sum(1.0, &[(0.5, 8.0), (0.4, 0.3), (0.3, 0.01)]);
    let values = disturbed(&truth, &times, 0.01);
    let prepared = Prepared::new(&times, &terms(3)).unwrap();
    let fit = prepared.fit(&values).unwrap();
    let exact: f64 = times.iter().zip(&values).map(|(t, y)| (y - fit.sum.at(*t)).powi(2)).sum();
    assert_close(fit.rss, exact, 1e-12);
    assert_eq!((fit.samples, fit.degrees_of_freedom), (20_000, 20_000 - 7));
    for parameter in fit.parameters() {
        let (value, error) =
            (fit.value(parameter).unwrap(), fit.standard_error(parameter).unwrap());
        let off = (value - truth.value(parameter).unwrap()).abs();
        assert!(off < 4.0 * error, "{parameter}: off by {off} with an error of {error}");
    }
    // A step of any parameter by a tenth of its error raises the sum of squares: the minimum is that of
    // the samples.
    for parameter in fit.parameters().skip(1) {
        for sign in [-0.1, 0.1] {
            let mut moved = fit.sum.clone();
            let step = sign * fit.standard_error(parameter).unwrap();
            match parameter {
                Parameter::Coefficient(0) => moved.constant += step,
                Parameter::Coefficient(i) => moved.terms[i - 1].coefficient += step,
                Parameter::Rate(i) => moved.terms[i - 1].rate += step,
                Parameter::Scale => {}
            }
            let there: f64 =
                times.iter().zip(&values).map(|(t, y)| (y - moved.at(*t)).powi(2)).sum();
            assert!(there > exact, "{parameter}");
        }
    }
}

#[test]
fn preparing_a_long_hold_costs_as_its_decades_not_as_its_samples() {
    let blocks = |samples: u32| {
        let since = uniform(samples, 50.0);
        Means::new(&since, &[]).map(|means| means.times().len())
    };
    assert_eq!(blocks(4000), None);
    let (short, long) = (blocks(5000).unwrap(), blocks(500_000).unwrap());
    assert!(long < short + 500 && long < 1100, "{long} for {short}");
}
