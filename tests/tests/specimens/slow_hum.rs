//! A hum of the mains in samples of nearly its own frequency, which show it as a slow swing.

use std::f64::consts::TAU;
use std::path::Path;

use palpate_tests::held_press::{force, held_press, times, warnings_and_diagnosis};
use palpate_tests::{answer, specimens};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const HUM_HZ: f64 = 50.07;
const NOISE: f64 = 0.01;

/// Writes four presses at 50 Hz, 25 s after each other, with a hum of this amplitude, N.
fn record(folder: &Path, hum: f64) {
    let mut random = ChaCha8Rng::seed_from_u64(41);
    for (number, (deep, speed)) in
        [(4.0, 2.0), (5.0, 3.0), (6.0, 5.0), (5.0, 4.0)].into_iter().enumerate()
    {
        let begun = 25.0 * number as f64;
        let motion = held_press(deep, speed);
        let time = times(1_000, 50.0);
        let rows = time.iter().zip(force(&time, motion)).map(|(&t, f)| {
            let noise: f64 = StandardNormal.sample(&mut random);
            [t, motion(t), f + hum * (TAU * HUM_HZ * (begun + t) + 1.0).sin() + NOISE * noise]
        });
        let head = format!("# [setup]\n# start_s = {begun:.1}\n");
        specimens::write(folder, &format!("{number}.csv"), &head, rows);
    }
}

#[test]
fn a_hum_that_looks_like_a_slow_swing_is_named_and_added() {
    let folder = tempfile::tempdir().expect("a folder");
    record(folder.path(), 0.015);
    let (_, found) = warnings_and_diagnosis(folder.path());
    assert_eq!(found["steps"][0]["effect"], "mains-hum", "{found}");
    assert_eq!(found["verdict"], "named", "{found}");
    assert!(found["notes"].to_string().contains("as a swing of 0.07"), "{}", found["notes"]);
    let add = ["add", "mains-hum", "model.toml", ".", "-o", "better.toml", "--json"];
    let better = answer(folder.path(), &add);
    let left = better["ladder"][1]["rms"].as_f64().expect("an error");
    assert!((left / NOISE - 1.0).abs() < 0.05, "{left} N are left");
}

#[test]
fn samples_at_the_rate_of_the_mains_alone_have_no_hum() {
    let folder = tempfile::tempdir().expect("a folder");
    record(folder.path(), 0.0);
    let (_, found) = warnings_and_diagnosis(folder.path());
    assert_eq!(found["verdict"], "adequate", "{found}");
}
