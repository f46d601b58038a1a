//! Recordings that begin in the midst of a motion: what came before is neither an effect nor noise.

use std::f64::consts::TAU;
use std::path::Path;

use palpate_tests::held_press::{keep, warnings_and_diagnosis};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

const INTERVAL: f64 = 0.01;
/// Stiffness, N/mm^(q+1), exponent q, and shares with rates, 1/s, of what relaxes.
const SPECIMEN: (f64, f64) = (0.08, 0.8);
const BRANCHES: [(f64, f64); 2] = [(0.25, 4.0), (0.24, 0.55)];
const NOISE: f64 = 0.02;
/// Seconds before the sines in which the specimen is pressed and held, and in which the sines go on.
const BEFORE: f64 = 5.0;
const LONG: f64 = 12.0;

/// Writes three sines about a pressed state, from the sines on or from the rest before.
fn record(folder: &Path, from_rest: bool) {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let noise = Normal::new(0.0, NOISE).expect("a distribution");
    for (number, (size, frequency)) in [(1.0, 0.2), (1.5, 0.5), (1.0, 1.0)].into_iter().enumerate()
    {
        let (mut times, mut x, mut force) = (Vec::new(), Vec::new(), Vec::new());
        let (mut before, mut states) = (0.0, [0.0; 2]);
        for k in 0..((BEFORE + LONG) / INTERVAL) as u32 {
            let time = INTERVAL * f64::from(k);
            let turn = TAU * frequency * (time - BEFORE).max(0.0);
            let pressed = (2.0 * (time - 1.0)).clamp(0.0, 3.0) + size * turn.sin();
            let (p, q) = SPECIMEN;
            let elastic = p / (q + 1.0) * pressed.powf(q + 1.0);
            let mut carried = 0.51 * elastic;
            for (state, (share, rate)) in states.iter_mut().zip(BRANCHES) {
                let decay = (-rate * INTERVAL).exp();
                *state = *state * decay + (1.0 - decay) / (rate * INTERVAL) * (elastic - before);
                carried += share * *state;
            }
            before = elastic;
            if from_rest || time >= BEFORE {
                times.push(time);
                x.push(pressed);
                force.push(carried + noise.sample(&mut random));
            }
        }
        keep(folder, number, &times, &x, &force);
    }
}

/// The warnings of a fit, and the diagnosis.
fn answers(from_rest: bool) -> (String, serde_json::Value) {
    let folder = tempfile::tempdir().expect("a folder");
    record(folder.path(), from_rest);
    warnings_and_diagnosis(folder.path())
}

#[test]
fn what_came_before_the_recording_is_named_as_no_effect() {
    let (warnings, found) = answers(false);
    assert!(
        warnings.contains("3 traces, 0.csv to 2.csv, begin pressed and in motion"),
        "{warnings}"
    );
    assert_eq!(
        (&found["verdict"], found["steps"].as_array().unwrap().len()),
        (&"unknown".into(), 0)
    );
    let past = &found["past"];
    assert_eq!(past["traces"].as_array().unwrap().len(), 3, "{found}");
    assert!(past["share"].as_f64().unwrap() > 0.8, "{past}");
    let next = found["next_experiment"].as_str().unwrap();
    assert!(next.contains("from a rest off the specimen"), "{next}");
}

#[test]
fn the_same_motions_from_a_rest_on_lack_nothing() {
    let (warnings, found) = answers(true);
    assert!(!warnings.contains("in motion"), "{warnings}");
    assert_eq!((&found["verdict"], found.get("past")), (&"adequate".into(), None), "{found}");
}
