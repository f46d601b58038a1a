//! Taps that are over in a few times the lag of the sensor: the base law takes on most of what the lag does, so that it shows little at
//! first.

use std::f64::consts::PI;

use palpate_tests::held_press::{force, keep, times, warnings_and_diagnosis};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

const NOISE: f64 = 0.01;
/// Rows of a tap; it lasts two thirds of them.
const ROWS: u32 = 300;

/// What a sensor of the first order, with a lag of so many samples, shows of a force, N, that is straight between samples.
fn late(force: &[f64], lag: f64) -> Vec<f64> {
    let stays = (-1.0 / lag).exp();
    let mut shown = force[0];
    let mut before = force[0];
    let mut follow = |now: f64| {
        let lags = (now - before) * lag;
        shown = now + (shown - before) * stays - lags * (1.0 - stays);
        before = now;
        shown
    };
    force.iter().map(|&now| follow(now)).collect()
}

/// Records taps of so many depths, mm, at a rate, 1/s, by a sensor whose lag is so many samples, and has it named.
fn is_named(rate: f64, lag: f64, depths: &[f64]) {
    let folder = tempfile::tempdir().expect("a folder");
    let mut random = ChaCha8Rng::seed_from_u64(31);
    let noise = Normal::new(0.0, NOISE).expect("a distribution");
    let time = times(ROWS, rate);
    let span = f64::from(ROWS) / rate;
    for (number, deep) in depths.iter().enumerate() {
        let tap = move |t: f64| {
            let part = ((t / span - 1.0 / 6.0) * 1.5).clamp(0.0, 1.0);
            (deep + 0.2) * (PI * part).sin() - 0.2
        };
        let x: Vec<f64> = time.iter().map(|&t| tap(t)).collect();
        let shown = late(&force(&time, tap), lag).into_iter();
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

#[test]
fn a_lag_that_the_base_law_takes_on_is_named() {
    is_named(5_000.0, 50.0, &[1.0, 1.5, 2.0, 2.5, 3.0, 3.5]);
}

/// A fit to the other taps that begins with too long a step ends far from the best.
#[test]
fn a_tap_that_is_left_out_is_predicted_by_the_best_fit_to_the_others() {
    is_named(500.0, 100.0, &[1.0, 1.5, 2.0, 2.5, 3.0]);
}
