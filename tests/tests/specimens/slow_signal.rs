//! A force that was recorded more slowly than the rows that hold it is told, and what repeats is left out when asked.

use palpate_tests::answer;
use palpate_tests::held_press::{force, held_press, holds_the_truth, keep, times};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use serde_json::Value;

const NOISE: f64 = 0.02;
/// Rows a second, and values of the force.
const RATE: f64 = 200.0;
const RECORDED: f64 = 40.0;

#[test]
fn what_repeats_is_told_and_left_out_when_asked() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut random = ChaCha8Rng::seed_from_u64(23);
    let noise = Normal::new(0.0, NOISE).expect("a distribution");
    let presses = [(4.0, 5.0), (5.0, 10.0), (6.0, 20.0), (5.0, 40.0)];
    for (number, (deep, speed)) in presses.into_iter().enumerate() {
        let motion = held_press(deep, speed);
        let time = times(1800, RATE);
        let felt = force(&time, motion).into_iter();
        let measured: Vec<f64> = felt.map(|f| f + noise.sample(&mut random)).collect();
        let each = (RATE / RECORDED) as usize;
        let held: Vec<f64> = (0..time.len()).map(|k| measured[k - k % each]).collect();
        let x: Vec<f64> = time.iter().map(|&t| motion(t)).collect();
        keep(folder.path(), number, &time, &x, &held);
    }
    let fit = ["fit", "fung", ".", "-o", "model.toml", "--force", "--json"];
    let as_it_is = answer(folder.path(), &fit);
    let told = as_it_is["signal_repeats"].as_array().unwrap();
    assert_eq!(told.len(), presses.len(), "{told:?}");
    assert!(told.iter().all(|it| (it["rows"].as_f64().unwrap() - 5.0).abs() < 0.05), "{told:?}");
    let diagnose = ["diagnose", "--model", "model.toml", ".", "--json"];
    let found = answer(folder.path(), &diagnose);
    let mut steps = found["steps"].as_array().unwrap().iter();
    let is_delay = |step: &Value| step["effect"] == "sensor-lag" || step["effect"] == "sync-delay";
    assert!(!steps.any(is_delay), "{}", found["in_words"]);
    let mut refused = found["refused"].as_array().unwrap().iter();
    let told = |it: &Value| it["reason"].as_str().unwrap().contains("stays for 0.025 s");
    assert!(refused.any(|it| is_delay(it) && told(it)), "{}", found["refused"]);
    let fresh = answer(folder.path(), &[&fit[..], &["--drop-repeats"]].concat());
    assert_eq!(fresh["signal_repeats_dropped"], true);
    assert!(fresh["residual_rms"].as_f64().unwrap() < 1.03 * NOISE, "{}", fresh["residual_rms"]);
    holds_the_truth(&fresh);
    let found = answer(folder.path(), &[&diagnose[..], &["--drop-repeats"]].concat());
    assert_eq!(found["verdict"], "adequate", "{}", found["in_words"]);
}
