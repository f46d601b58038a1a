//! Long recordings that begin in motion, or on the specimen: their noise, in which neighbours agree, is no missing effect.

use std::path::Path;

use palpate_tests::held_press::{force, keep, times, warnings_and_diagnosis};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;

const RATE: f64 = 1000.0;
const NOISE: f64 = 0.01;

/// Writes four presses that come from far off and go there again without a stop. Neighbours in the noise correlate as told; `add` gives
/// a force, N, at a displacement, mm, and `keeps` says at which displacements the recorder is on.
fn record(folder: &Path, correlation: f64, add: impl Fn(f64) -> f64, keeps: impl Fn(f64) -> bool) {
    let mut random = ChaCha8Rng::seed_from_u64(37);
    for (number, (deep, speed)) in
        [(4.0, 2.0), (5.0, 3.0), (6.0, 5.0), (5.0, 4.0)].into_iter().enumerate()
    {
        let motion = move |t: f64| (speed * (t - 4.0)).min(deep).min(deep - speed * (t - 12.0));
        let time = times(16_000, RATE);
        let mut noise = 0.0;
        let mut measured = |(&t, f): (&f64, f64)| {
            let drawn: f64 = StandardNormal.sample(&mut random);
            noise = correlation * noise + (1.0 - correlation * correlation).sqrt() * drawn;
            [t, motion(t), f + add(motion(t)) + NOISE * noise]
        };
        let rows: Vec<[f64; 3]> =
            time.iter().zip(force(&time, motion)).map(&mut measured).collect();
        let on: Vec<&[f64; 3]> = rows.iter().filter(|row| keeps(row[1])).collect();
        let column = |place: usize| on.iter().map(|row| row[place]).collect::<Vec<f64>>();
        keep(folder, number, &column(0), &column(1), &column(2));
    }
}

fn diagnosed(
    correlation: f64,
    add: impl Fn(f64) -> f64,
    keeps: impl Fn(f64) -> bool,
) -> (String, Value) {
    let folder = tempfile::tempdir().expect("a folder");
    record(folder.path(), correlation, add, keeps);
    warnings_and_diagnosis(folder.path())
}

#[test]
fn nothing_is_missing_where_a_recording_begins_in_motion() {
    let (warnings, found) = diagnosed(0.6, |_| 0.0, |_| true);
    assert_eq!(found["verdict"], "adequate", "{found}");
    let noise = found["noise_rms"].as_f64().unwrap();
    assert!((noise / NOISE - 1.0).abs() < 0.1, "{noise}");
    assert!(!warnings.contains("something is missing"), "{warnings}");
}

#[test]
fn nothing_is_missing_where_a_recording_begins_on_the_specimen() {
    let (_, found) = diagnosed(0.6, |_| 0.0, |x| x > -0.02);
    assert_eq!(found["verdict"], "adequate", "{found}");
}

#[test]
fn what_is_missing_is_no_louder_noise() {
    let ripple = |x: f64| if x > 0.0 { 0.02 * (7.8 * x).sin() } else { 0.0 };
    // A ripple on the way in too, so that no noise is seen there.
    let way = |x: f64| if x < 0.0 { 0.02 * (5.0 * x).sin() } else { 0.0 };
    for beside in [&|_: f64| 0.0, &way] as [&dyn Fn(f64) -> f64; 2] {
        let (_, found) = diagnosed(0.0, |x| ripple(x) + beside(x), |_| true);
        assert_eq!(found["verdict"], "unknown", "{found}");
        assert!(!found["notes"].to_string().contains("louder"), "{}", found["notes"]);
    }
}
