//! A simulated fingertip makes recordings that everything downstream takes.

use std::path::Path;

use palpate_tests::palpate;
use serde_json::Value;

fn json(folder: &Path, call: &[&str]) -> Value {
    let output = palpate().current_dir(folder).args(call).arg("--json").assert().success();
    serde_json::from_slice(&output.get_output().stdout).unwrap()
}

#[test]
fn a_recording_goes_the_way_of_a_device_and_comes_back_as_it_was_felt() {
    let folder = tempfile::tempdir().unwrap();
    let run = |call: &[&str]| {
        palpate().current_dir(folder.path()).args(call).assert().success();
    };
    run(&["sensor", "press", "--seed", "5", "-o", "press.palpate"]);
    run(&["sensor", "press", "--seed", "5", "-o", "press.csv"]);
    run(&["convert", "press.palpate", "-o", "back.csv"]);
    let read = |name| palpate::trace::read(&folder.path().join(name)).unwrap();
    let (felt, back) = (read("press.csv"), read("back.csv"));
    for gauge in palpate::trace::GAUGES {
        let pairs = felt.column(gauge).unwrap().iter().zip(back.column(gauge).unwrap());
        let farthest = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(farthest <= 0.5 / 256.0 + 1e-9, "{gauge}: {farthest}");
    }
    // The device was told the relaxation of this silicone, so its FA is that of the press.
    let fa = back.column("gauge1_fa_ustrain").unwrap();
    assert!(fa.iter().copied().fold(0.0, f64::max) > 100.0);
    run(&["decompose", "press.csv", "--signal", "gauge1_ustrain", "-o", "split"]);
    let split = read("split/press.csv");
    let column = |name| split.column(name).unwrap();
    // FA is negative where the load falls; without its sign it answers to touch and release alike.
    let (fa, size) = (column("gauge1_fa_ustrain"), column("gauge1_fa_rectified_ustrain"));
    assert!(fa.iter().any(|fa| *fa < -10.0));
    assert!(fa.iter().zip(size).all(|(fa, size)| fa.abs() == *size));
    run(&["fit", "fung", "press.csv", "--separation", "free", "-o", "model.toml"]);
    run(&["compare", "model.toml", "press.csv"]);
}

#[test]
fn the_force_of_a_press_relaxes_at_the_rates_of_the_silicone() {
    let folder = tempfile::tempdir().unwrap();
    let call = ["sensor", "press", "--composition", "9:1", "--hold", "8", "-o", "press.csv"];
    palpate().current_dir(folder.path()).args(call).assert().success();
    let fit = json(folder.path(), &["fit", "fung", "press.csv", "--hold-only"]);
    let v2 = fit["holds"][0]["parameters"]["v2"]["value"].as_f64().unwrap();
    assert!((v2 / 0.695 - 1.0).abs() < 1e-3, "Table 5.2, hard silicone: {v2}");
}

#[test]
fn sharp_saturates_blunt_does_not_and_thicker_silicone_reads_less() {
    let folder = tempfile::tempdir().unwrap();
    let press = |more: &[&str]| {
        let call = [&["sensor", "press", "--composition", "5:5"], more].concat();
        json(folder.path(), &call)["gauges"][0].clone()
    };
    let (sharp, blunt) = (press(&["--indenter", "sharp"]), press(&["--indenter", "blunt"]));
    assert!(sharp["saturated_after_s"].as_f64().unwrap() < 0.2);
    assert!(blunt["saturated_after_s"].is_null());
    let thick = press(&["--thickness", "8"]);
    let peak = |gauge: &Value| gauge["peak_ustrain"].as_f64().unwrap();
    assert!(peak(&thick) < 0.6 * peak(&blunt));
}

#[test]
fn fa_and_sa_follow_the_filters_formula_from_slow_to_fast() {
    let folder = tempfile::tempdir().unwrap();
    let found = json(folder.path(), &["sensor", "frequency", "--count", "5"]);
    let tones = found["tones"].as_array().unwrap();
    assert_eq!(tones.len(), 5);
    for tone in tones {
        assert!(tone["distance"].as_f64().unwrap() < 2e-3, "{tone}");
    }
}

#[test]
fn nonsense_is_refused_with_what_to_do_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    for (call, word) in [
        (&["press", "--composition", "1:9"][..], "parts of silicone"),
        (&["press", "--thickness", "0"], "thickness"),
        (&["press", "--force", "50"], "press less"),
        (&["press", "--indenter", "round"], "sharp, blunt"),
        (&["press", "--at", "3"], "X,Y"),
        (&["press", "--hold", "1e9"], "the hold"),
        (&["press", "--hold", "9e4"], "make it shorter"),
        (&["frequency", "--to", "3000"], "highest frequency"),
        (&["slide", "--ridges", "0.001"], "period of the ridges"),
        (&["slide", "--ridge-height", "1"], "height of the ridges"),
    ] {
        let call = [&["sensor"], call, &["-o", "out.csv"]].concat();
        let output = palpate().current_dir(folder.path()).args(&call).assert().code(2);
        let said = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
        assert!(said.contains(word), "{call:?}: {said}");
        assert!(output.get_output().stdout.is_empty());
    }
    let call = ["sensor", "press", "-o", "out.xlsx"];
    palpate().current_dir(folder.path()).args(call).assert().code(2);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
