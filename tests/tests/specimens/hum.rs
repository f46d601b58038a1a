//! A hum of the mains that no clock foretells: in samples of nearly its own frequency, which show it as a slow swing, and one that wanders.

use std::f64::consts::TAU;
use std::path::Path;

use palpate_tests::held_press::{force, held_press, times, warnings_and_diagnosis};
use palpate_tests::{answer, palpate, specimens};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const NOISE: f64 = 0.01;

/// Writes four presses, 25 s after each other, at this rate, 1/s, with a hum, N, of this course over the time of the set, s.
fn record(folder: &Path, rate: f64, hum: impl Fn(f64) -> f64) {
    let mut random = ChaCha8Rng::seed_from_u64(41);
    for (number, (deep, speed)) in
        [(4.0, 2.0), (5.0, 3.0), (6.0, 5.0), (5.0, 4.0)].into_iter().enumerate()
    {
        let begun = 25.0 * number as f64;
        let motion = held_press(deep, speed);
        let time = times((20.0 * rate) as u32, rate);
        let rows = time.iter().zip(force(&time, motion)).map(|(&t, f)| {
            let noise: f64 = StandardNormal.sample(&mut random);
            [t, motion(t), f + hum(begun + t) + NOISE * noise]
        });
        let head = format!("# [setup]\n# start_s = {begun:.1}\n");
        specimens::write(folder, &format!("{number}.csv"), &head, rows);
    }
}

/// Adds the hum to the model of a folder, and expects it to leave the noise.
fn adds_the_hum(folder: &Path) {
    let add = ["add", "mains-hum", "model.toml", ".", "-o", "better.toml", "--json"];
    let better = answer(folder, &add);
    let left = better["ladder"][1]["rms"].as_f64().expect("an error");
    assert!((left / NOISE - 1.0).abs() < 0.05, "{left} N are left");
}

#[test]
fn a_hum_that_looks_like_a_slow_swing_is_named_and_added() {
    let folder = tempfile::tempdir().expect("a folder");
    record(folder.path(), 50.0, |t| 0.015 * (TAU * 50.07 * t + 1.0).sin());
    let (_, found) = warnings_and_diagnosis(folder.path());
    assert_eq!(found["steps"][0]["effect"], "mains-hum", "{found}");
    assert_eq!(found["verdict"], "named", "{found}");
    assert!(found["notes"].to_string().contains("as a swing of 0.07"), "{}", found["notes"]);
    adds_the_hum(folder.path());
}

#[test]
fn a_hum_whose_frequency_wanders_is_followed_and_a_motion_alone_does_not_foretell_it() {
    let folder = tempfile::tempdir().expect("a folder");
    // Between 49.96 and 50.02 Hz.
    let turns = |t: f64| 49.99 * t + 0.4 * (0.08 * t).sin();
    record(folder.path(), 100.0, |t| 0.007 * (TAU * turns(t)).sin());
    let (_, found) = warnings_and_diagnosis(folder.path());
    assert_eq!(found["verdict"], "named", "{found}");
    assert_eq!(found["steps"].as_array().map(Vec::len), Some(1), "{found}");
    assert_eq!(found["steps"][0]["effect"], "mains-hum", "{found}");
    assert_eq!(found["steps"][0]["law"], "followed", "{found}");
    assert!(found["notes"].to_string().contains("the hum wanders"), "{}", found["notes"]);
    adds_the_hum(folder.path());
    let simulate = ["simulate", "better.toml", "--motion", "0.csv"];
    let run = palpate().current_dir(&folder).args(simulate).output().expect("the program runs");
    assert_eq!(run.status.code(), Some(2), "{run:?}");
    let told = String::from_utf8_lossy(&run.stderr);
    assert!(told.contains("mains-hum") && told.contains("palpate drop"), "{told}");
}

#[test]
fn samples_at_the_rate_of_the_mains_alone_have_no_hum() {
    let folder = tempfile::tempdir().expect("a folder");
    record(folder.path(), 50.0, |_| 0.0);
    let (_, found) = warnings_and_diagnosis(folder.path());
    assert_eq!(found["verdict"], "adequate", "{found}");
}
