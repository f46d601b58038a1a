//! Taps that are over in a few times the lag of the sensor: the base law takes on most of what the lag does, so that it shows little at
//! first.

use std::f64::consts::PI;

use palpate_tests::held_press::{force, keep, times, warnings_and_diagnosis};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

const NOISE: f64 = 0.01;
const RATE: f64 = 5_000.0;
const LAG_S: f64 = 0.01;

/// What a sensor of the first order shows of a force, N, that is straight between samples.
fn late(force: &[f64]) -> Vec<f64> {
    let stays = (-1.0 / (RATE * LAG_S)).exp();
    let mut shown = force[0];
    let mut before = force[0];
    let mut follow = |now: f64| {
        let lags = (now - before) * RATE * LAG_S;
        shown = now + (shown - before) * stays - lags * (1.0 - stays);
        before = now;
        shown
    };
    force.iter().map(|&now| follow(now)).collect()
}

#[test]
fn a_lag_that_the_base_law_takes_on_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut random = ChaCha8Rng::seed_from_u64(31);
    let noise = Normal::new(0.0, NOISE).expect("a distribution");
    let time = times(300, RATE);
    for (number, deep) in [1.0, 1.5, 2.0, 2.5, 3.0, 3.5].into_iter().enumerate() {
        let tap = move |t: f64| {
            let part = ((t - 0.01) / 0.04).clamp(0.0, 1.0);
            (deep + 0.2) * (PI * part).sin() - 0.2
        };
        let x: Vec<f64> = time.iter().map(|&t| tap(t)).collect();
        let shown = late(&force(&time, tap)).into_iter();
        let shown: Vec<f64> = shown.map(|f| f + noise.sample(&mut random)).collect();
        keep(folder.path(), number, &time, &x, &shown);
    }
    let (_, found) = warnings_and_diagnosis(folder.path());
    let steps = found["steps"].as_array().unwrap();
    assert_eq!(found["verdict"], "named", "{steps:?}");
    assert_eq!((steps.len(), &steps[0]["effect"]), (1, &"sensor-lag".into()), "{steps:?}");
    let left = found["final_rms_N"].as_f64().unwrap();
    assert!(left < 1.1 * NOISE, "{left}");
}
