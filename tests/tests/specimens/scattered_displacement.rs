//! A displacement that scatters, as a camera sees it: a play that only smooths it is no backlash.

use palpate_tests::held_press::{force, held_press, keep, times, warnings_and_diagnosis};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

/// Frames a second, scatter of the displacement, mm, and noise of the force, N.
const RATE: f64 = 30.0;
const SCATTER: f64 = 0.02;
const NOISE: f64 = 0.01;

#[test]
fn a_play_within_the_scatter_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut random = ChaCha8Rng::seed_from_u64(41);
    let scatter = Normal::new(0.0, SCATTER).expect("a distribution");
    let noise = Normal::new(0.0, NOISE).expect("a distribution");
    let presses = [(4.0, 5.0), (5.0, 10.0), (6.0, 20.0), (5.0, 40.0), (3.0, 10.0), (6.0, 5.0)];
    for (number, (deep, speed)) in presses.into_iter().enumerate() {
        let motion = held_press(deep, speed);
        let time = times(270, RATE);
        let felt = force(&time, motion).into_iter();
        let measured: Vec<f64> = felt.map(|f| f + noise.sample(&mut random)).collect();
        let seen: Vec<f64> =
            time.iter().map(|&t| motion(t) + scatter.sample(&mut random)).collect();
        keep(folder.path(), number, &time, &seen, &measured);
    }
    let (_, found) = warnings_and_diagnosis(folder.path());
    let refused = found["refused"].as_array().unwrap().iter();
    let play = refused.clone().find(|it| it["effect"] == "backlash").expect("it was tried");
    assert!(play["reason"].as_str().unwrap().contains("only smooths the displacement"), "{play}");
    let steps = found["steps"].as_array().unwrap();
    assert!(steps.iter().all(|step| step["effect"] != "backlash"), "{steps:?}");
}
