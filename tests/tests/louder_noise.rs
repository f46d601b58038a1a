//! Noise that is louder in contact than at rest is noise.

use std::path::Path;

use palpate::model::{BaseLaw, Motion, Separation};
use palpate::trace::{DISPLACEMENT, FORCE, Trace, write};
use palpate_tests::answer;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;

const LAW: BaseLaw = BaseLaw::fung(2, Separation::Clamp);
const TRUTH: [f64; 6] = [0.08, 0.8, 0.25, 0.24, 4.0, 0.55];
const RATE: f64 = 200.0;

/// Writes four presses; `noise` is the standard deviation at a force, N, and a speed, mm/s.
fn record(folder: &Path, noise: impl Fn(f64, f64) -> f64) {
    let mut random = ChaCha8Rng::seed_from_u64(23);
    let presses = [(4.0, 5.0), (5.0, 10.0), (6.0, 20.0), (5.0, 40.0)];
    for (number, (deep, speed)) in presses.into_iter().enumerate() {
        let motion = |t: f64| {
            let back = deep - speed * (t - 1.0 - deep / speed - 4.0);
            (speed * (t - 1.0)).min(deep).min(back).max(-1.0)
        };
        let time: Vec<f64> = (0..1600).map(|k| f64::from(k) / RATE).collect();
        let x: Vec<f64> = time.iter().map(|&t| motion(t)).collect();
        let pressed = Motion { time: (&time).into(), displacement: (&x).into(), rest_before: None };
        let force = LAW.predict(&TRUTH, &[pressed]).remove(0);
        let mut measure = |(&t, f): (&f64, f64)| {
            let speed = RATE * (motion(t) - motion(t - 1.0 / RATE)).abs();
            let drawn: f64 = StandardNormal.sample(&mut random);
            f + noise(f, speed) * drawn
        };
        let force = time.iter().zip(force).map(&mut measure).collect();
        let mut trace = Trace { time, ..Trace::default() };
        trace.set_column(DISPLACEMENT, x);
        trace.set_column(FORCE, force);
        write(&folder.join(format!("{number}.csv")), &trace).expect("a file");
    }
}

/// The warnings of a fit, and the diagnosis.
fn answers(noise: impl Fn(f64, f64) -> f64) -> (String, Value) {
    let folder = tempfile::tempdir().expect("a folder");
    record(folder.path(), noise);
    let fit = answer(folder.path(), &["fit", "fung", ".", "-o", "model.toml", "--json"]);
    let found = answer(folder.path(), &["diagnose", "--model", "model.toml", ".", "--json"]);
    (fit["warnings"].to_string(), found)
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
