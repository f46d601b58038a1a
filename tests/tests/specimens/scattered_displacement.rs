//! A displacement that scatters, as a camera or a sensor with noise sees it: what only smooths it is no effect.

use std::path::Path;

use palpate_tests::answer;
use palpate_tests::held_press::{
    force, held_press, holds_the_truth, keep, times, warnings_and_diagnosis,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

/// Noise of the force, N.
const NOISE: f64 = 0.01;
/// Depths, mm, and speeds, mm/s.
const PRESSES: [(f64, f64); 6] =
    [(4.0, 5.0), (5.0, 10.0), (6.0, 20.0), (5.0, 40.0), (3.0, 10.0), (6.0, 5.0)];

/// Writes the presses, 9 s of each at so many samples a second, whose displacement scatters by so much, mm.
fn record(folder: &Path, rate: f64, scatter: f64) {
    let mut random = ChaCha8Rng::seed_from_u64(41);
    let scatter = Normal::new(0.0, scatter).expect("a distribution");
    let noise = Normal::new(0.0, NOISE).expect("a distribution");
    for (number, &(deep, speed)) in PRESSES.iter().enumerate() {
        let motion = held_press(deep, speed);
        let time = times((9.0 * rate) as u32, rate);
        let felt = force(&time, motion).into_iter();
        let measured: Vec<f64> = felt.map(|f| f + noise.sample(&mut random)).collect();
        let seen: Vec<f64> =
            time.iter().map(|&t| motion(t) + scatter.sample(&mut random)).collect();
        keep(folder, number, &time, &seen, &measured);
    }
}

#[test]
fn noise_of_the_displacement_is_no_lag() {
    let folder = tempfile::tempdir().expect("a folder");
    record(folder.path(), 200.0, 0.02);
    let fit = ["fit", "fung", ".", "-o", "model.toml", "--force", "--json"];
    let fit = answer(folder.path(), &fit);
    let noisy = fit["displacement_noise"].as_array().unwrap();
    assert_eq!(noisy.len(), PRESSES.len(), "{noisy:?}");
    for own in noisy {
        let deviation = own["standard_deviation_mm"].as_f64().unwrap();
        assert!((deviation - 0.02).abs() < 0.002, "{own}");
    }
    holds_the_truth(&fit);
    let diagnose = ["diagnose", "--model", "model.toml", ".", "--json"];
    let found = answer(folder.path(), &diagnose);
    assert_eq!(
        (&found["verdict"], found["steps"].as_array().unwrap().len()),
        (&"adequate".into(), 0),
        "{}",
        found["in_words"]
    );
}

#[test]
fn a_play_within_the_scatter_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    // Too few samples to be sure that the force does not follow: nothing is smoothed.
    record(folder.path(), 6.0, 0.02);
    let (_, found) = warnings_and_diagnosis(folder.path());
    assert_eq!(found["displacement_noise"].as_array().unwrap().len(), 0);
    let refused = found["refused"].as_array().unwrap().iter();
    let play = refused.clone().find(|it| it["effect"] == "backlash").expect("it was tried");
    assert!(play["reason"].as_str().unwrap().contains("only smooths the displacement"), "{play}");
    let mut steps = found["steps"].as_array().unwrap().iter();
    assert!(steps.all(|step| step["effect"] != "backlash"), "{steps:?}");
}
