//! Traces of which nothing says that one was recorded after the other: each may be of a specimen that has recovered, or of a new one.

use palpate_tests::held_press::{TRUTH, held_press, times, warnings_and_diagnosis};
use palpate_tests::specimens;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use serde_json::Value;

const NOISE: f64 = 0.01;
const RATE: f64 = 100.0;
const PRESSES: [(f64, f64); 4] = [(6.0, 20.0), (4.0, 5.0), (5.0, 10.0), (3.0, 8.0)];

/// The force, N, of a new specimen at displacements, mm, one every 1/RATE s: its elastic response at each, of what it has been through
/// the largest, relaxes by two exponentials.
fn new_specimen(x: &[f64], elastic: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let [_, _, c1, c2, v1, v2] = TRUTH;
    let (mut largest, mut before) = (0.0, 0.0);
    let mut modes = [(c1, v1, 0.0), (c2, v2, 0.0)];
    let mut felt = |x: f64| {
        largest = x.max(largest);
        let now = elastic(x, largest);
        let mut force = (1.0 - c1 - c2) * now;
        for (share, rate, state) in &mut modes {
            let stays = (-*rate / RATE).exp();
            *state = *state * stays + (now - before) * (1.0 - stays) / (*rate / RATE);
            force += *share * *state;
        }
        before = now;
        force.max(0.0)
    };
    x.iter().map(|&x| felt(x)).collect()
}

fn of_fung(x: f64) -> f64 {
    TRUTH[0] / (TRUTH[1] + 1.0) * x.max(0.0).powf(TRUTH[1] + 1.0)
}

/// Records the presses, each on a new specimen, and diagnoses them; `head` says of each what it says, by its number.
fn diagnosed(elastic: impl Fn(f64, f64) -> f64, head: impl Fn(usize) -> String) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    let mut random = ChaCha8Rng::seed_from_u64(29);
    let noise = Normal::new(0.0, NOISE).expect("a distribution");
    for (number, (deep, speed)) in PRESSES.into_iter().enumerate() {
        let time = times(800, RATE);
        let x: Vec<f64> = time.iter().map(|&t| held_press(deep, speed)(t)).collect();
        let force = new_specimen(&x, &elastic);
        let rows = time.iter().zip(&x).zip(force);
        let rows = rows.map(|((t, x), f)| [*t, *x, f + noise.sample(&mut random)]);
        specimens::write(folder.path(), &format!("{number}.csv"), &head(number), rows);
    }
    warnings_and_diagnosis(folder.path()).1
}

fn is_named(found: &Value, effect: &str) {
    assert_eq!(found["verdict"], "named", "{}", found["steps"]);
    let steps = found["steps"].as_array().unwrap();
    assert_eq!((steps.len(), &steps[0]["effect"]), (1, &effect.into()), "{steps:?}");
    let left = found["final_rms_N"].as_f64().unwrap();
    assert!(left < 1.03 * NOISE, "{left}");
}

#[test]
fn a_softening_that_every_specimen_shows_anew_is_named() {
    let softer = |x: f64, largest: f64| of_fung(x) * (1.0 - 0.12 * (largest - x).tanh());
    is_named(&diagnosed(softer, |_| String::new()), "mullins");
}

#[test]
fn a_set_that_every_specimen_takes_anew_is_named() {
    let shorter = |x: f64, largest: f64| of_fung(x - 0.1 * largest);
    is_named(&diagnosed(shorter, |_| String::new()), "permanent-set");
}

#[test]
fn traces_in_an_order_are_of_one_specimen() {
    let softer = |x: f64, largest: f64| of_fung(x) * (1.0 - 0.12 * (largest - x).tanh());
    let found = diagnosed(softer, |number| format!("# [setup]\n# sequence = {number}\n"));
    let steps = found["steps"].as_array().unwrap();
    assert!(!steps.is_empty() && steps.iter().all(|step| step["law"] != "recovered"), "{steps:?}");
}
