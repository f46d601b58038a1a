//! A displacement that was recorded more slowly than the force, or rounded to coarse steps, is told, and joined when asked.

use std::path::Path;

use palpate_tests::answer;
use palpate_tests::held_press::{force, held_press, holds_the_truth, keep, times};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use serde_json::Value;

const NOISE: f64 = 0.02;
const RATE: f64 = 500.0;

/// Writes three presses, the displacement of each as `seen` has it: of the motion and the time.
fn record(folder: &Path, seen: impl Fn(&dyn Fn(f64) -> f64, f64) -> f64) {
    let mut random = ChaCha8Rng::seed_from_u64(17);
    let noise = Normal::new(0.0, NOISE).expect("a distribution");
    for (number, (deep, speed)) in [(4.0, 5.0), (5.0, 10.0), (6.0, 20.0)].into_iter().enumerate() {
        let motion = held_press(deep, speed);
        let time = times(4000, RATE);
        let felt = force(&time, motion).into_iter();
        let measured: Vec<f64> = felt.map(|f| f + noise.sample(&mut random)).collect();
        let x: Vec<f64> = time.iter().map(|&t| seen(&motion, t)).collect();
        keep(folder, number, &time, &x, &measured);
    }
}

fn fitted(folder: &Path, how: &[&str]) -> Value {
    let fit = ["fit", "fung", ".", "-o", "model.toml", "--force", "--json"];
    answer(folder, &[&fit[..], how].concat())
}

fn is_told_and_joined(folder: &Path, cause: &str) {
    let as_it_is = fitted(folder, &[]);
    let told = as_it_is["displacement_steps"].as_array().unwrap();
    assert_eq!(told.len(), 3, "{told:?}");
    assert!(told.iter().all(|it| it["cause"] == cause), "{told:?}");
    let joined = fitted(folder, &["--join-steps"]);
    assert_eq!(joined["displacement_steps_joined"], true);
    let left = |fit: &Value| fit["residual_rms"].as_f64().unwrap();
    assert!(left(&joined) < 1.02 * NOISE && left(&as_it_is) > 1.01 * left(&joined), "{as_it_is}");
    let diagnose = ["diagnose", "--model", "model.toml", ".", "--join-steps", "--json"];
    assert_eq!(answer(folder, &diagnose)["verdict"], "adequate");
    holds_the_truth(&joined);
}

#[test]
fn a_displacement_that_was_held_between_its_records_is_joined() {
    let folder = tempfile::tempdir().expect("a folder");
    record(folder.path(), |motion, t| motion((10.0 * t + 1e-9).floor() / 10.0));
    is_told_and_joined(folder.path(), "held");
}

#[test]
fn a_displacement_that_was_rounded_is_joined() {
    let folder = tempfile::tempdir().expect("a folder");
    record(folder.path(), |motion, t| (motion(t) / 0.25).round() * 0.25);
    is_told_and_joined(folder.path(), "rounded");
}

#[test]
fn one_that_was_recorded_with_the_force_is_left_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    record(folder.path(), |motion, t| motion(t));
    let fit = fitted(folder.path(), &["--join-steps"]);
    assert_eq!(fit["displacement_steps"], Value::Array(Vec::new()));
}
