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

/// The events of a trace, and what the simulation says happened.
fn events(folder: &Path, trace: &str, more: &[&str]) -> (Vec<Value>, Vec<Value>) {
    let answer = json(folder, &[&["events", trace], more].concat());
    assert_eq!(answer["palpate_events"], 1);
    let list = |key: &str| answer["traces"][0][key].as_array().cloned().unwrap_or_default();
    (list("events"), list("happened"))
}

#[test]
fn a_slip_is_told_before_the_contact_slides_and_a_shaking_hand_is_none() {
    let folder = tempfile::tempdir().unwrap();
    let run = |call: &[&str]| {
        palpate().current_dir(folder.path()).args(call).assert().success();
    };
    run(&["sensor", "slip", "-o", "pull.csv"]);
    let pull = json(folder.path(), &["sensor", "slip"]);
    let (found, happened) = events(folder.path(), "pull.csv", &[]);
    let kinds: Vec<&str> = found.iter().filter_map(|it| it["kind"].as_str()).collect();
    assert_eq!(kinds, ["touch", "slip"]);
    let told = found[1]["told_s"].as_f64().unwrap();
    let nubs = pull["nubs_let_go_s"].as_array().unwrap();
    assert!(told > nubs[0].as_f64().unwrap() && told < pull["slides_s"].as_f64().unwrap() - 0.3);
    assert!(happened.iter().all(|it| it["told_after_s"].is_number()), "{happened:?}");
    assert!(found.iter().all(|it| it["false_alarm"] == false), "{found:?}");

    run(&["sensor", "shake", "--duration", "10", "-o", "shake.csv"]);
    let (found, _) = events(folder.path(), "shake.csv", &[]);
    let kinds: Vec<&str> = found.iter().filter_map(|it| it["kind"].as_str()).collect();
    assert_eq!(kinds, ["touch", "release"]);
}

#[test]
fn a_recording_of_a_device_tells_the_events_that_the_host_finds_from_its_own_fa() {
    // FA is in every row of the stream: the code of `shared` over the rows of a recording, and over the trace from which
    // it was made, tells the same events at the same samples.
    use shared::adaptation::Output;
    use shared::events::{Config, Settings, State};
    let folder = tempfile::tempdir().unwrap();
    let run = |call: &[&str]| {
        palpate().current_dir(folder.path()).args(call).assert().success();
    };
    run(&["sensor", "slip", "-o", "pull.palpate"]);
    run(&["convert", "pull.palpate", "-o", "rows.csv"]);
    let rows = palpate::trace::read(&folder.path().join("rows.csv")).unwrap();
    let counts = |name: String, k: usize| (rows.column(&name).unwrap()[k] * 256.0).round() as i32;
    let outputs = |k: usize| {
        std::array::from_fn::<_, 4, _>(|gauge| {
            let signal = counts(format!("gauge{}_ustrain", gauge + 1), k);
            let fa = counts(format!("gauge{}_fa_ustrain", gauge + 1), k);
            Output { signal, fa, equilibrium: signal, elastic: signal }
        })
    };
    let config = Config::new(&Settings::DEFAULT, 1.0 / 256.0, 1e-3).unwrap();
    let mut state = State::at_rest(outputs(0).map(|output| output.signal));
    let told = |k: usize| Some((k, state.step(&config, &outputs(k))?.kind));
    let streamed: Vec<_> = (0..rows.len()).filter_map(told).collect();
    let (found, _) = events(folder.path(), "rows.csv", &["--jolt", "0.05"]);
    assert_eq!(streamed.len(), found.len(), "{streamed:?} {found:?}");
    for ((k, kind), event) in streamed.iter().zip(&found) {
        assert_eq!(rows.time[*k], event["told_s"].as_f64().unwrap());
        assert_eq!(format!("{kind:?}").to_lowercase(), event["kind"].as_str().unwrap());
    }
}

#[test]
fn events_in_a_force_and_bad_calls() {
    let folder = tempfile::tempdir().unwrap();
    let press = palpate_tests::bundled("press.csv");
    let press = press.to_str().unwrap();
    let (found, _) = events(folder.path(), press, &["--signal", "force_N"]);
    assert_eq!(found[0]["kind"], "touch");
    assert_eq!(found.last().unwrap()["kind"], "release");
    for (call, word) in [
        (&["events", press, "--jolts", "1"][..], "2 to 8"),
        (&["events", press, "--burst", "0"], "burst"),
        (&["events", press, "--jolts", "3", "--corner", "90"], "quarter of the sample rate"),
        (&["events", press, "--signal", "nothing_N"], "nothing_N"),
    ] {
        let output = palpate().args(call).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{call:?}: {said}");
        assert!(said.contains(word) && output.stdout.is_empty(), "{call:?}: {said}");
    }
}
