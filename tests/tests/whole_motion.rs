//! The fit of whole motions finds what was put in, and its standard errors are true.

use palpate::fit::data::Data;
use palpate::fit::whole_motion::{Basis, fit};
use palpate::model::{BaseLaw, Motion, Separation};
use palpate::trace::{Column, DISPLACEMENT, FORCE, Trace};
use palpate_tests::press;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use rayon::prelude::*;

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
    record_of(motions(), law, noise, correlation, seed)
}

/// The same of these motions.
fn record_of(
    motions: Vec<Motion<'static>>,
    law: BaseLaw,
    noise: f64,
    correlation: f64,
    seed: u64,
) -> Vec<Trace> {
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

/// What three presses of one specimen are recorded with.
#[derive(Clone, Copy, Debug)]
struct Sensor {
    /// Standard deviation of the noise, N.
    noise: f64,
    /// Correlation between neighbours.
    correlation: f64,
    /// Share of the samples that are recorded, which ones by chance.
    kept: f64,
}

const SENSOR: Sensor = Sensor { noise: 0.02, correlation: 0.0, kept: 1.0 };

impl Sensor {
    fn motions(&self, seed: u64) -> Vec<Motion<'static>> {
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ (1 << 40));
        let mut thinned = |motion: Motion<'static>| {
            let kept: Vec<usize> =
                (0..motion.time.len()).filter(|_| random.random_bool(self.kept)).collect();
            let pick = |values: &[f64]| kept.iter().map(|&k| values[k]).collect::<Vec<_>>().into();
            let (time, displacement) = (pick(&motion.time), pick(&motion.displacement));
            Motion { time, displacement, ..motion }
        };
        [(4.0, 5.0), (8.0, 20.0), (12.0, 60.0)]
            .map(|(to_mm, speed)| thinned(press(to_mm, speed, 1.5)))
            .into()
    }

    /// Share of so many sets in which the 95 % interval of each parameter holds the truth.
    fn coverage(&self, sets: u64) -> [f64; 6] {
        let law = BaseLaw::fung(2, Separation::Clamp);
        let holds = |seed: u64| {
            let traces = record_of(self.motions(seed), law, self.noise, self.correlation, seed);
            let found = fit(law, &Data::of(&traces, FORCE).unwrap()).unwrap();
            std::array::from_fn(|k| {
                let error = found.standard_errors[k].expect("determined");
                f64::from((found.values[k] - TRUTH[k]).abs() < 1.96 * error)
            })
        };
        let all: Vec<[f64; 6]> = (0..sets).into_par_iter().map(holds).collect();
        std::array::from_fn(|k| all.iter().map(|set| set[k]).sum::<f64>() / sets as f64)
    }
}

#[test]
fn intervals_from_three_traces_hold_the_truth_as_often_as_they_say() {
    let sets = 200;
    for correlation in [0.0, 0.7] {
        let coverage = Sensor { correlation, ..SENSOR }.coverage(sets);
        // Four standard deviations of a share of 95 % among so many sets.
        let off = 4.0 * (0.95 * 0.05 / sets as f64).sqrt();
        assert!(
            coverage.iter().all(|share| (share - 0.95).abs() < off),
            "{correlation}: {coverage:?}"
        );
    }
}

/// The figures of docs/measured.md.
#[test]
#[ignore = "minutes: the figures of docs/measured.md"]
fn coverage_of_intervals() {
    for sensor in [
        SENSOR,
        Sensor { noise: 0.1, ..SENSOR },
        Sensor { correlation: 0.7, ..SENSOR },
        Sensor { correlation: 0.95, ..SENSOR },
        Sensor { kept: 0.3, ..SENSOR },
        Sensor { kept: 0.3, correlation: 0.7, ..SENSOR },
    ] {
        let coverage = sensor.coverage(2_000);
        let shares: Vec<String> = ["p", "q", "c1", "c2", "v1", "v2"]
            .iter()
            .zip(coverage)
            .map(|(name, share)| format!("{name} {:.1} %", 100.0 * share))
            .collect();
        println!("{sensor:?}: {}", shares.join(", "));
    }
}

/// Presses of the specimen to depths and at speeds by chance, 50 samples a second.
fn presses_by_chance(count: usize, seed: u64) -> Vec<Trace> {
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ (1 << 41));
    let motions = (0..count).map(|_| {
        let (to_mm, speed) =
            (random.random_range(4.0..12.0), random.random_range(1.6f64..4.1).exp());
        let motion = press(to_mm, speed, 1.5);
        let thinned = |values: &[f64]| values.iter().step_by(4).copied().collect::<Vec<_>>().into();
        let (time, displacement) = (thinned(&motion.time), thinned(&motion.displacement));
        Motion { time, displacement, ..motion }
    });
    record_of(motions.collect(), BaseLaw::fung(2, Separation::Clamp), 0.01, 0.0, seed)
}

/// Share of so many sets of presses in which the 95 % interval of each parameter of a law with one exponential too few
/// holds what it is over many presses: with errors of the samples, and of the traces.
fn coverage_of_an_inexact_law(traces: usize, sets: u64) -> [[f64; 4]; 2] {
    let law = BaseLaw::fung(1, Separation::Clamp);
    let many = presses_by_chance(400, 1 << 20);
    let truth = fit(law, &Data::of(&many, FORCE).unwrap()).unwrap().values;
    let holds = |seed: u64| {
        let traces = presses_by_chance(traces, seed);
        let data = Data::of(&traces, FORCE).unwrap();
        let plain = fit(law, &data).unwrap();
        let by_trace = plain.clone().allowing_for_misfit(&data, Some(0.01));
        assert_eq!(by_trace.basis, Basis::Traces);
        [plain, by_trace].map(|fit| {
            std::array::from_fn(|k| {
                let error = fit.standard_errors[k].expect("determined");
                f64::from((fit.values[k] - truth[k]).abs() < 1.96 * error)
            })
        })
    };
    let all: Vec<[[f64; 4]; 2]> = (0..sets).into_par_iter().map(holds).collect();
    let share =
        |basis: usize, k: usize| all.iter().map(|set| set[basis][k]).sum::<f64>() / sets as f64;
    [0, 1].map(|basis| std::array::from_fn(|k| share(basis, k)))
}

/// The figures of docs/measured.md.
#[test]
#[ignore = "minutes: the figures of docs/measured.md"]
fn coverage_of_intervals_of_an_inexact_law() {
    for traces in [5, 8, 20] {
        let shares = coverage_of_an_inexact_law(traces, 1_000);
        let told = shares.map(|of| of.map(|share| format!("{:.1} %", 100.0 * share)).join(", "));
        println!(
            "{traces} traces, p, q, c1, v1: errors of samples {}; of traces {}",
            told[0], told[1]
        );
    }
}
