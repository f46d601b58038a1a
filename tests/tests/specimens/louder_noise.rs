//! Noise that is louder in contact than at rest is noise.

use std::path::Path;

use palpate_tests::held_press::{force, held_press, keep, times, warnings_and_diagnosis};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;

const RATE: f64 = 200.0;

/// Writes four presses; `noise` is the standard deviation at a force, N, and a speed, mm/s.
fn record(folder: &Path, noise: impl Fn(f64, f64) -> f64) {
    let mut random = ChaCha8Rng::seed_from_u64(23);
    let presses = [(4.0, 5.0), (5.0, 10.0), (6.0, 20.0), (5.0, 40.0)];
    for (number, (deep, speed)) in presses.into_iter().enumerate() {
        let motion = held_press(deep, speed);
        let time = times(1600, RATE);
        let mut measure = |(&t, f): (&f64, f64)| {
            let speed = RATE * (motion(t) - motion(t - 1.0 / RATE)).abs();
            let drawn: f64 = StandardNormal.sample(&mut random);
            f + noise(f, speed) * drawn
        };
        let measured: Vec<f64> = time.iter().zip(force(&time, motion)).map(&mut measure).collect();
        let x: Vec<f64> = time.iter().map(|&t| motion(t)).collect();
        keep(folder, number, &time, &x, &measured);
    }
}

/// The warnings of a fit, and the diagnosis.
fn answers(noise: impl Fn(f64, f64) -> f64) -> (String, Value) {
    let folder = tempfile::tempdir().expect("a folder");
    record(folder.path(), noise);
    warnings_and_diagnosis(folder.path())
}

#[test]
fn noise_that_grows_with_the_force_lacks_no_effect() {
    let (warnings, found) = answers(|force, _| 0.003 + 0.01 * force);
    assert!(warnings.contains("times louder"), "{warnings}");
    assert!(!warnings.contains("something is missing"), "{warnings}");
    assert_eq!(found["verdict"], "adequate", "{found}");
    assert!(found["adequacy"]["after"]["louder_loaded"].as_f64().unwrap() > 1.3, "{found}");
    assert!(found["notes"].to_string().contains("times louder"), "{found}");
}

#[test]
fn a_drive_that_shakes_what_it_moves_is_no_effect() {
    let (_, found) = answers(|_, speed| if speed > 0.1 { 0.012 } else { 0.005 });
    assert_eq!(found["verdict"], "adequate", "{found}");
}

#[test]
fn even_noise_is_not_called_louder() {
    let (warnings, found) = answers(|_, _| 0.005);
    assert!(!warnings.contains("louder"), "{warnings}");
    assert_eq!(found["adequacy"]["after"]["louder_loaded"], 1.0, "{found}");
}
