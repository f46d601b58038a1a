//! Presses with a hold of a specimen that relaxes, at a rate of the test's own, for what a recorder does to them.

use std::path::Path;

use palpate::model::{BaseLaw, Motion, Separation};
use serde_json::Value;

use crate::{answer, specimens};

/// The parameters of the specimen, in the order of the law's.
pub const TRUTH: [f64; 6] = [0.08, 0.8, 0.25, 0.24, 4.0, 0.55];

/// A press to `deep`, mm, at `speed`, mm/s, and back: displacement, mm, over time, s. It meets the specimen at 1 s and stays for 4 s.
pub fn held_press(deep: f64, speed: f64) -> impl Fn(f64) -> f64 + Copy {
    move |t| {
        let back = deep - speed * (t - 1.0 - deep / speed - 4.0);
        (speed * (t - 1.0)).min(deep).min(back).max(-1.0)
    }
}

/// Times, s, of so many samples at a rate, 1/s.
#[must_use]
pub fn times(samples: u32, rate: f64) -> Vec<f64> {
    (0..samples).map(|k| f64::from(k) / rate).collect()
}

/// The force, N, of the specimen at each of these times, s, under this motion.
#[must_use]
pub fn force(time: &[f64], motion: impl Fn(f64) -> f64) -> Vec<f64> {
    let x: Vec<f64> = time.iter().map(|&t| motion(t)).collect();
    let motion = Motion { time: time.into(), displacement: x.into(), rest_before: None };
    BaseLaw::fung(2, Separation::Clamp).predict(&TRUTH, &[motion]).remove(0)
}

/// Writes a trace under its number.
///
/// # Panics
/// If the folder cannot be written to.
pub fn keep(folder: &Path, number: usize, time: &[f64], x: &[f64], force: &[f64]) {
    let rows = time.iter().zip(x).zip(force).map(|((t, x), f)| [*t, *x, *f]);
    specimens::write(folder, &format!("{number}.csv"), "", rows);
}

/// Asserts that each parameter of a fit of `fung` lies within four of its standard errors of the truth.
///
/// # Panics
/// If one does not.
#[track_caller]
pub fn holds_the_truth(fit: &Value) {
    for (name, truth) in ["p", "q", "c1", "c2", "v1", "v2"].into_iter().zip(TRUTH) {
        let of = &fit["parameters"][name];
        let number = |field: &str| of[field].as_f64().expect("a number");
        let (value, error) = (number("value"), number("standard_error"));
        assert!((value - truth).abs() < 4.0 * error, "{name} = {value} ± {error}, not {truth}");
    }
}

/// The warnings of a fit of all traces of a folder, and the diagnosis of its model.
#[must_use]
pub fn warnings_and_diagnosis(folder: &Path) -> (String, Value) {
    let fit = answer(folder, &["fit", "fung", ".", "-o", "model.toml", "--json"]);
    let found = answer(folder, &["diagnose", "--model", "model.toml", ".", "--json"]);
    (fit["warnings"].to_string(), found)
}
