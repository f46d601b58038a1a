//! A model that lacks something is told where it fails; one that lacks nothing is left alone.

use palpate::criticism::compare::{Comparison, compare};
use palpate::criticism::region::Region;
use palpate::fit::data::Data;
use palpate::fit::whole_motion::fit;
use palpate::model::{BaseLaw, Model, Motion, Separation};
use palpate::trace::{Column, DISPLACEMENT, FORCE, Trace, read};
use palpate_tests::{bundled, press};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

const LAW: BaseLaw = BaseLaw::fung(2, Separation::Clamp);
const TRUTH: [f64; 6] = [0.08, 0.8, 0.25, 0.24, 4.0, 0.55];
const NOISE: f64 = 0.01;

/// Six presses whose force has something more than the law says: a function of x and v.
fn recordings(extra: fn(f64, f64) -> f64) -> Vec<Trace> {
    let motions: Vec<Motion> = [4.0, 8.0, 12.0]
        .iter()
        .flat_map(|&x| [5.0, 40.0].map(|speed| press(x, speed, 1.5)))
        .collect();
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let normal = Normal::new(0.0, NOISE).unwrap();
    let force = LAW.predict(&TRUTH, &motions);
    let recording = |(motion, force): (Motion<'static>, Vec<f64>)| {
        let rate = |k: usize| {
            let before = motion.displacement[k.saturating_sub(1)];
            (motion.displacement[k] - before) * 200.0
        };
        let measured = (0..force.len())
            .map(|k| force[k] + extra(motion.displacement[k], rate(k)) + normal.sample(&mut random))
            .collect();
        Trace {
            columns: vec![
                Column { name: DISPLACEMENT.into(), values: motion.displacement.to_vec() },
                Column { name: FORCE.into(), values: measured },
            ],
            time: motion.time.into_owned(),
            ..Trace::default()
        }
    };
    motions.into_iter().zip(force).map(recording).collect()
}

/// The base law refitted to the recordings, and compared with them.
fn refit_and_compare(extra: fn(f64, f64) -> f64) -> Comparison {
    let traces = recordings(extra);
    let found = fit(LAW, &Data::of(&traces, FORCE).unwrap()).unwrap();
    let model = Model::of(&LAW, FORCE, &found.values, &found.standard_errors);
    compare(&model, &traces).unwrap()
}

#[test]
fn a_model_that_lacks_nothing_leaves_nothing_but_noise() {
    let comparison = refit_and_compare(|_, _| 0.0);
    assert!(comparison.only_noise, "{:?}", comparison.over_noise());
    assert_eq!(comparison.in_words(), "Nothing but noise is left.");
    assert!(comparison.cells.iter().all(|cell| cell.share_of_excess == 0.0));
    // The means that are drawn say so too.
    let bins = comparison.dependences.iter().flat_map(|dependence| &dependence.bins);
    let (near, all) = bins.fold((0, 0), |(near, all), bin| {
        (near + usize::from(bin.mean.abs() <= 2.0 * bin.standard_error), all + 1)
    });
    assert!(near * 10 >= all * 8, "{near} of {all} within two standard errors");
}

#[test]
fn friction_is_located_in_the_moving_regions_and_flips_with_the_direction() {
    let comparison = refit_and_compare(|x, v| if x > 0.0 { 0.03 * (v / 0.5).tanh() } else { 0.0 });
    assert!(!comparison.only_noise);
    let moving: f64 = comparison
        .by_region()
        .iter()
        .filter(|(region, _)| matches!(region, Region::Loading | Region::Unloading))
        .map(|(_, share)| share)
        .sum();
    assert!(moving > 0.5, "{:?}", comparison.by_region());
    let words = comparison.in_words();
    assert!(words.contains("flips with the direction of the motion"), "{words}");
}

#[test]
fn what_grows_with_the_load_is_said_to_depend_on_the_load() {
    let comparison = refit_and_compare(|x, _| if x > 9.0 { 0.02 * (x - 9.0) } else { 0.0 });
    let strongest = comparison.dependences[0].covariate.symbol();
    assert!(["x", "F", "x_max"].contains(&strongest), "{:#?}", comparison.in_words());
    assert!(comparison.dependences[0].p_value <= 0.01);
}

#[test]
fn the_shares_of_what_is_left_sum_to_one_and_the_errors_to_the_whole() {
    let comparison = refit_and_compare(|x, v| if x > 0.0 { 0.002 * v } else { 0.0 });
    let shares: f64 = comparison.cells.iter().map(|cell| cell.share_of_excess).sum();
    assert!((shares - 1.0).abs() < 1e-12);
    let square: f64 =
        comparison.cells.iter().map(|cell| cell.rms * cell.rms * cell.samples as f64).sum();
    let samples: usize = comparison.cells.iter().map(|cell| cell.samples).sum();
    assert!((comparison.rms - (square / samples as f64).sqrt()).abs() < 1e-12);
}

#[test]
fn a_gauge_that_recovers_slowly_after_the_touch_is_not_taken_for_noise() {
    let (traces, signal) = ([read(&bundled("press.csv")).unwrap()], "gauge1_ustrain");
    let found = fit(LAW, &Data::of(&traces, signal).unwrap()).unwrap();
    let model = Model::of(&LAW, signal, &found.values, &found.standard_errors);
    let comparison = compare(&model, &traces).unwrap();
    // Before the touch the gauge scatters by 1.5 µε; after it, it comes back from 2,000.
    let noise = comparison.noise.unwrap().standard_deviation;
    assert!((1.0..2.5).contains(&noise), "{noise}");
    assert!(!comparison.only_noise);
}
