//! Impossible samples and resting values: told with their place, mended only when asked.

use std::fs;
use std::path::Path;

use palpate::model::{BaseLaw, Separation};
use palpate::trace::{Column, DISPLACEMENT, Trace, read, write};
use palpate_tests::held_press::{force, held_press, keep, times, warnings_and_diagnosis};
use palpate_tests::{answer, palpate, press};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use serde_json::Value;

const LAW: BaseLaw = BaseLaw::fung(2, Separation::Clamp);
const TRUTH: [f64; 6] = [0.08, 0.8, 0.25, 0.24, 4.0, 0.55];
const SIGNAL: &str = "sensor_ohm";

/// Two presses whose signal is 100 Ω/N about `rest`, with drop-outs of the motion in the second.
fn record(folder: &Path, rest: f64, drop_outs: &[usize]) {
    let motions = [press(6.0, 10.0, 0.8), press(10.0, 40.0, 0.8)];
    let force = LAW.predict(&TRUTH, &motions);
    let mut random = ChaCha8Rng::seed_from_u64(29);
    let normal = Normal::new(0.0, 1.0).unwrap();
    for (number, (motion, force)) in motions.into_iter().zip(force).enumerate() {
        let signal = force.iter().map(|f| rest + 100.0 * f + normal.sample(&mut random)).collect();
        let mut x = motion.displacement.into_owned();
        for &row in drop_outs.iter().filter(|_| number == 1) {
            x[row - 1] -= 12.0;
        }
        let columns = vec![
            Column { name: DISPLACEMENT.into(), values: x },
            Column { name: SIGNAL.into(), values: signal },
        ];
        let trace = Trace { time: motion.time.into_owned(), columns, ..Trace::default() };
        write(&folder.join(format!("take-{number}.csv")), &trace).unwrap();
    }
}

fn text(folder: &Path, arguments: &[&str]) -> String {
    let output = palpate().current_dir(folder).args(arguments).output().expect("palpate runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    answer(folder, &[arguments, &["--json"]].concat())
}

#[test]
fn drop_outs_are_told_by_file_and_row_and_left_out_when_asked() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    fs::create_dir(folder.join("takes")).unwrap();
    let rows = [180, 260, 261, 300, 340];
    record(&folder.join("takes"), 0.0, &rows);
    let fit = ["fit", "fung", "takes", "--signal", SIGNAL];
    let bad = json(folder, &[&fit[..], &["-o", "model.toml"]].concat());
    let found: Vec<(&str, u64)> = bad["outliers"]
        .as_array()
        .unwrap()
        .iter()
        .map(|out| (out["trace"].as_str().unwrap(), out["row"].as_u64().unwrap()))
        .collect();
    assert_eq!(found, rows.map(|row| ("take-1.csv", row as u64)));
    let good = json(folder, &[&fit[..], &["--drop-outliers"]].concat());
    let r_squared = |answer: &Value| answer["r_squared"].as_f64().unwrap();
    assert!(r_squared(&good) > r_squared(&bad) + 0.002, "{good:#} {bad:#}");
    assert_eq!(bad["without_outliers"]["r_squared"], good["r_squared"]);
    assert_eq!(good["outliers_dropped"], true);
    let told = text(folder, &fit);
    let words = format!("would be {:.3} instead of {:.3}", r_squared(&good), r_squared(&bad));
    assert!(told.split_whitespace().collect::<Vec<_>>().join(" ").contains(&words), "{told}");
    // Weights on the samples of the signal say nothing of a motion that never was.
    assert!(bad.get("robust_refit").is_none_or(Value::is_null), "{bad:#}");
    assert!(!told.contains("robust refit"), "{told}");
    for command in [&["compare", "model.toml"][..], &["diagnose", "--model", "model.toml"]] {
        let answer = json(folder, &[command, &["takes"]].concat());
        assert_eq!(answer["outliers"].as_array().unwrap().len(), rows.len(), "{command:?}");
    }
}

/// A jump of the signal off the specimen is none of the law's: nothing moves.
#[test]
fn a_jump_that_moves_no_parameter_is_said_to_hardly_matter() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    fs::create_dir(folder.join("takes")).unwrap();
    record(&folder.join("takes"), 0.0, &[]);
    let path = folder.join("takes/take-1.csv");
    let mut trace = read(&path).unwrap();
    let mut values = trace.column(SIGNAL).unwrap().to_vec();
    values[20] += 40.0;
    trace.set_column(SIGNAL, values);
    write(&path, &trace).unwrap();
    let told = text(folder, &["fit", "fung", "takes", "--signal", SIGNAL]);
    let told = told.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(told.contains("1 sample jumps") && told.contains("so they hardly matter"), "{told}");
}

/// A loose contact or a lost byte: what the noise is seen in has such samples too.
#[test]
fn samples_that_jump_are_no_noise_and_something_that_is_missing() {
    const NOISE: f64 = 0.01;
    let folder = tempfile::tempdir().unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(61);
    let normal = Normal::new(0.0, NOISE).unwrap();
    let presses = [(4.0, 2.0), (5.0, 3.0), (6.0, 5.0), (5.0, 4.0)];
    let jumps: [&[(usize, f64)]; 4] =
        [&[(40, 2.4), (1900, -1.1)], &[(60, -1.6), (450, 1.3)], &[(1850, 2.1)], &[(30, 1.8)]];
    for (number, ((deep, speed), jumps)) in presses.into_iter().zip(jumps).enumerate() {
        let motion = held_press(deep, speed);
        let time = times(2000, 100.0);
        let x: Vec<f64> = time.iter().map(|&t| motion(t)).collect();
        let mut force = force(&time, motion);
        force.iter_mut().for_each(|force| *force += normal.sample(&mut random));
        jumps.iter().for_each(|(row, jump)| force[*row] += jump);
        keep(folder.path(), number, &time, &x, &force);
    }
    let (_, found) = warnings_and_diagnosis(folder.path());
    assert_eq!(found["outliers"].as_array().map(Vec::len), Some(6), "{found}");
    assert_eq!(found["verdict"], "unknown", "{found}");
    let words = found["in_words"].to_string();
    assert!(words.contains("jump away and back are 100 % of the misfit"), "{words}");
    let without = ["diagnose", "--model", "model.toml", ".", "--drop-outliers"];
    assert_eq!(json(folder.path(), &without)["verdict"], "adequate");
    let noise = found["noise"]["standard_deviation"].as_f64().unwrap();
    assert!((noise / NOISE - 1.0).abs() < 0.05, "{noise} N");
}

#[test]
fn a_resting_value_is_named_with_its_remedy() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    record(folder, 33_000.0, &[]);
    let fit = ["fit", "fung", "take-0.csv", "take-1.csv", "--signal", SIGNAL];
    // No law describes that, and no model is made of it.
    let output = palpate().current_dir(folder).args(fit).output().expect("palpate runs");
    let told = String::from_utf8_lossy(&output.stderr).replace("\n", " ");
    assert!(!output.status.success());
    assert!(told.contains("rests at 33000") && told.contains("--tare"), "{told}");
    let tared = json(folder, &[&fit[..], &["--tare"]].concat());
    assert!(tared["r_squared"].as_f64().unwrap() > 0.99, "{tared:#}");
    assert!(!tared["warnings"].to_string().contains("rests at"));
    assert!((tared["tared"]["take-0.csv"].as_f64().unwrap() - 33_000.0).abs() < 1.0);
    assert_eq!(tared["outliers"].as_array().unwrap().len(), 0);
    // Where a law describes part of it, the fit says so.
    record(folder, 100.0, &[]);
    let warnings = json(folder, &fit)["warnings"].to_string();
    assert!(warnings.contains("rests at 99.9") && warnings.contains("--tare"), "{warnings}");
}
