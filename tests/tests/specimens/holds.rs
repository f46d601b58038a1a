//! Holds as laboratories record them: unevenly sampled, with noise that wanders, with a broken cell.

use std::path::{Path, PathBuf};

use palpate::trace::{DISPLACEMENT, FORCE, Trace, write};
use palpate_tests::{answer, palpate};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

/// A press of 0.3 s to 5 mm and a hold of 4.3 s, eqs 3.5 and 3.6, at these times since the hold began;
/// a sample remembers the one 5 ms before by `memory`.
fn hold(since: &[f64], memory: f64, random: &mut ChaCha8Rng) -> Trace {
    let normal = Normal::new(0.0, 0.01).unwrap();
    let (mut wander, mut before) = (normal.sample(random), since[0]);
    let time: Vec<f64> = since.iter().map(|t| t + 0.3).collect();
    let x: Vec<f64> = time.iter().map(|t| (5.0 * t / 0.3).clamp(0.0, 5.0)).collect();
    let force = since.iter().map(|&t| {
        let share = memory.powf((t - before) / 0.005);
        before = t;
        wander = share * wander + (1.0 - share * share).sqrt() * normal.sample(random);
        let relaxed = 0.4852 + 0.2472 * (-3.981 * t).exp() + 0.2676 * (-0.5325 * t).exp();
        wander + if t < 0.0 { 2.187 * (t + 0.3) / 0.3 } else { 2.187 * relaxed }
    });
    let force = force.collect();
    let mut trace = Trace { time, ..Trace::default() };
    trace.set_column(DISPLACEMENT, x);
    trace.set_column(FORCE, force);
    trace
}

fn save(folder: &Path, name: &str, trace: &Trace) -> PathBuf {
    let path = folder.join(name);
    write(&path, trace).unwrap();
    path
}

#[test]
fn bursts_and_random_instants_say_what_even_sampling_says() {
    let place = tempfile::tempdir().unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let bursts: Vec<f64> =
        (0..690).map(|k| f64::from(k / 3) * 0.02 + f64::from(k % 3) * 0.001 - 0.3).collect();
    let mut instants: Vec<f64> = (0..920).map(|_| random.random_range(-0.3..4.3)).collect();
    instants.sort_by(f64::total_cmp);
    for (name, since) in [("bursts.csv", bursts), ("random.csv", instants)] {
        let path = save(place.path(), name, &hold(&since, 0.0, &mut random));
        let path = path.to_str().unwrap();
        let found = answer(place.path(), &["relaxation", "--json", path]);
        let holds = found["holds"].as_array().unwrap();
        assert_eq!(holds.len(), 1, "{name}");
        for (parameter, wanted) in [("v1", 3.981), ("v2", 0.5325)] {
            let own = &holds[0]["parameters"][parameter];
            let (value, error) =
                (own["value"].as_f64().unwrap(), own["standard_error"].as_f64().unwrap());
            assert!((value - wanted).abs() < 4.0 * error, "{name}: {parameter} {value} ± {error}");
            assert!(error < 0.1 * wanted, "{name}: {parameter} ± {error}");
        }
    }
}

#[test]
fn repeats_whose_noise_wanders_are_not_told_apart() {
    // Ten holds of one specimen: the scatter is what the standard errors say, as χ² over them finds.
    let place = tempfile::tempdir().unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let since: Vec<f64> = (0..920).map(|k| f64::from(k) * 0.005 - 0.3).collect();
    let paths: Vec<PathBuf> = (0..10)
        .map(|k| save(place.path(), &format!("take-{k}.csv"), &hold(&since, 0.95, &mut random)))
        .collect();
    let names: Vec<&str> = paths.iter().map(|path| path.to_str().unwrap()).collect();
    let found = answer(place.path(), &[&["relaxation", "--json"][..], &names].concat());
    for spread in found["spread"].as_array().unwrap() {
        let p = spread["p_value"].as_f64().unwrap();
        assert!(p > 0.001, "{}: p = {p}", spread["parameter"]);
    }
    for hold in found["holds"].as_array().unwrap() {
        assert!(hold["error_over_white_noise"].as_f64().unwrap() > 2.0);
    }
}

#[test]
fn a_broken_cell_gives_an_error_and_no_model() {
    let place = tempfile::tempdir().unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let since: Vec<f64> = (0..920).map(|k| f64::from(k) * 0.005 - 0.3).collect();
    for broken in [1e10, 1e160] {
        let mut trace = hold(&since, 0.0, &mut random);
        let mut force = trace.force().unwrap().to_vec();
        force[431] = broken;
        trace.set_column(FORCE, force);
        let path = save(place.path(), "broken.csv", &trace);
        let call = ["fit", "fung", path.to_str().unwrap(), "-o", "model.toml"];
        let output = palpate().current_dir(place.path()).args(call).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{broken}: {said}");
        assert!(said.contains("2.155 s"), "{broken}: {said}");
        assert!(!place.path().join("model.toml").exists(), "{broken}");
    }
}
