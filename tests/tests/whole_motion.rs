//! The fit of whole motions finds what was put in, and its standard errors are true.

use palpate::fit::data::Data;
use palpate::fit::whole_motion::fit;
use palpate::model::{BaseLaw, Motion, Separation};
use palpate::trace::{Column, DISPLACEMENT, FORCE, Trace};
use palpate_tests::press;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

/// p, q, c1, c2, v1, v2 of the specimen.
const TRUTH: [f64; 6] = [0.08, 0.8, 0.25, 0.24, 4.0, 0.55];

/// Load, hold, unload to three depths at three rates.
fn motions() -> Vec<Motion<'static>> {
    [4.0, 8.0, 12.0]
        .iter()
        .flat_map(|&x| [5.0, 20.0, 60.0].map(|speed| press(x, speed, 1.5)))
        .collect()
}

/// What a sensor with noise of this size and correlation between neighbours would record.
fn record(law: BaseLaw, noise: f64, correlation: f64, seed: u64) -> Vec<Trace> {
    let motions = motions();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let normal = Normal::new(0.0, 1.0).unwrap();
    let fresh = noise * (1.0 - correlation * correlation).sqrt();
    let force = law.predict(&TRUTH, &motions);
    motions
        .into_iter()
        .zip(force)
        .map(|(motion, force)| {
            let mut error = noise * normal.sample(&mut random);
            let measured = force
                .into_iter()
                .map(|force| {
                    error = correlation * error + fresh * normal.sample(&mut random);
                    force + error
                })
                .collect();
            Trace {
                time: motion.time.into_owned(),
                columns: vec![
                    Column { name: DISPLACEMENT.into(), values: motion.displacement.into_owned() },
                    Column { name: FORCE.into(), values: measured },
                ],
                ..Trace::default()
            }
        })
        .collect()
}

/// Deviations from the truth in standard errors over several data sets.
fn deviations(separation: Separation, correlation: f64, sets: u64) -> Vec<f64> {
    let law = BaseLaw::fung(2, separation);
    (0..sets)
        .flat_map(|seed| {
            let traces = record(law, 0.02, correlation, seed);
            let found = fit(law, &Data::of(&traces, FORCE).unwrap()).unwrap();
            assert!(found.stop.converged());
            assert!(found.at_bound.iter().all(|bound| !bound));
            let errors = found.standard_errors.into_iter().map(|error| error.expect("determined"));
            let both = found.values.into_iter().zip(errors).zip(TRUTH);
            both.map(|((value, error), truth)| (value - truth) / error).collect::<Vec<_>>()
        })
        .collect()
}

fn mean_square(deviations: &[f64]) -> f64 {
    deviations.iter().map(|d| d * d).sum::<f64>() / deviations.len() as f64
}

#[test]
fn standard_errors_are_true_with_white_noise() {
    for separation in [Separation::Clamp, Separation::Free, Separation::Bonded] {
        let found = deviations(separation, 0.0, 20);
        let square = mean_square(&found);
        // 20 sets of six parameters, which correlate: a mean square within a factor of two of one.
        assert!((0.5..2.0).contains(&square), "{separation:?}: {square}");
        assert!(found.iter().all(|d| d.abs() < 4.5), "{separation:?}");
    }
}

#[test]
fn standard_errors_are_true_with_correlated_noise() {
    let square = mean_square(&deviations(Separation::Clamp, 0.6, 20));
    assert!((0.5..2.0).contains(&square), "{square}");
}

#[test]
fn one_exponential_too_many_is_said_to_be_one_too_many() {
    let law = BaseLaw::fung(2, Separation::Clamp);
    let traces = record(law, 0.02, 0.0, 1);
    let data = Data::of(&traces, FORCE).unwrap();
    let more = fit(BaseLaw { terms: 3, ..law }, &data).unwrap();
    let told = palpate::fit::warning::warnings(&more, &data, None);
    assert!(!told.is_empty(), "{more:?}");
    assert!(fit(law, &data).unwrap().bic() < more.bic());
    let less = fit(BaseLaw { terms: 1, ..law }, &data).unwrap();
    assert!(fit(law, &data).unwrap().bic() + 100.0 < less.bic());
}
