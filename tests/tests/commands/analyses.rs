//! The analyses of holds and rates, on the bundled recordings and on files that are made here.

use std::path::PathBuf;

use palpate::model::{BaseLaw, Model, Separation};
use palpate::trace::FORCE;
use palpate_tests::specimens::{SILICONE, ball, crept, pad, pressed, write};
use palpate_tests::{bundled, palpate};
use serde_json::Value;

/// The JSON that a command prints.
fn answer(arguments: &[&str], traces: &[PathBuf]) -> Value {
    let output = palpate().args(arguments).arg("--json").args(traces).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

/// What a command says when it refuses, with exit status 2 and nothing on standard output.
fn refusal(arguments: &[&str], traces: &[PathBuf]) -> String {
    let output = palpate().args(arguments).args(traces).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    assert!(output.stdout.is_empty());
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn the_regions_of_the_bundled_press_are_found_with_their_work() {
    let found = answer(&["segment"], &[bundled("press.csv")]);
    assert_eq!(found["palpate_segment"], 1);
    let cycle = &found["traces"][0]["cycles"][0];
    let points: Vec<&str> =
        cycle["points"].as_array().unwrap().iter().map(|p| p["point"].as_str().unwrap()).collect();
    assert_eq!(points, ["O", "A", "B", "C", "D", "C2", "D2", "E", "F"]);
    let types: Vec<&str> =
        cycle["regions"].as_array().unwrap().iter().filter_map(|r| r["type"].as_str()).collect();
    assert_eq!(types, ["Type I", "Type II"]);
    assert_eq!(cycle["direction"], "clockwise");
    let number = |key: &str| cycle[key].as_f64().unwrap();
    let lost = number("work_in_mJ") - number("work_out_mJ");
    assert!((number("dissipated_mJ") - lost).abs() < 1e-9 && lost > 0.0);
}

#[test]
fn the_gripper_of_chapter_3_accelerates_as_printed() {
    let found = answer(&["segment"], &[bundled("table-3.1-row-05.csv")]);
    let inertia = &found["traces"][0]["inertia"];
    assert_eq!(inertia["mass_g"], 14.0);
    // 3.3.4 prints 0.699 m/s² and 9.786 mN.
    assert!((inertia["force_N"].as_f64().unwrap() - 9.8e-3).abs() < 1e-4, "{inertia}");
}

#[test]
fn repeats_are_told_apart_from_noise_and_two_exponentials_are_chosen() {
    let rows: Vec<PathBuf> =
        (1..=10).map(|k| bundled(&format!("table-3.1-row-{k:02}.csv"))).collect();
    let found = answer(&["relaxation"], &rows);
    let spread = found["spread"].as_array().unwrap();
    let c0 = spread.iter().find(|line| line["parameter"] == "c0").unwrap();
    assert!((c0["mean"].as_f64().unwrap() - 0.4845).abs() < 2e-3, "Table 3.4");
    assert!(c0["p_value"].as_f64().unwrap() < 1e-4, "ten sushi are not one sushi");
    let holds = found["holds"].as_array().unwrap();
    assert_eq!(holds.len(), 10);
    assert!(holds.iter().all(|hold| hold["terms"]["decided"] == 2));
    for hold in holds {
        let latency = &hold["latency"];
        let (v1, slope) = (&latency["v1_per_s"], &latency["strain_rate_slope_per_s"]);
        assert_eq!(v1.as_f64().unwrap(), -slope.as_f64().unwrap());
    }
}

#[test]
fn relaxation_and_fit_hold_only_give_the_same_coefficients() {
    let trace = [bundled("table-3.2-row-03.csv")];
    let (new, old) =
        (answer(&["relaxation"], &trace), answer(&["fit", "fung", "--hold-only"], &trace));
    assert_eq!(new["holds"][0]["parameters"], old["holds"][0]["parameters"]);
}

#[test]
fn creep_is_found_without_a_head_and_a_relaxation_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let held = [crept(folder.path())];
    let found = answer(&["creep", "--terms", "1", "--signs"], &held);
    let hold = &found["holds"][0];
    assert_eq!(hold["type"], "Type I");
    let value = |name: &str| hold["parameters"][name]["value"].as_f64().unwrap();
    assert!((value("N") - 6.48).abs() < 2e-3 && (value("v1") - 0.6).abs() < 0.02, "{hold}");
    assert_eq!(value("c0"), 1.0);
    assert_eq!(hold["not_identified"].as_array().unwrap().len(), 0);
    let three = answer(&["creep", "--terms", "3"], &held);
    assert_ne!(three["holds"][0]["not_identified"].as_array().unwrap().len(), 0);
    let filtered = answer(&["creep", "--terms", "1", "--cutoff", "20"], &held);
    assert!(filtered["conditioning"]["minus_3_dB_Hz"].as_f64().unwrap() < 20.0);
    assert!(refusal(&["relaxation"], &held).contains("palpate creep"));
    assert!(refusal(&["creep"], &[bundled("press.csv")]).contains("palpate relaxation"));
    assert!(refusal(&["creep", "--cutoff", "150"], &held).contains("half the sampling rate"));
}

#[test]
fn creep_under_a_controlled_force_is_found_whatever_the_noise() {
    // Ramps at 1.96 N/s to 1 N and back to 0.5 N, each held for 9.5 s, under a PI controller.
    let folder = tempfile::tempdir().unwrap();
    let law = BaseLaw::fung(2, Separation::Clamp);
    let values = [0.28, 0.45, 0.24, 0.26, 3.7, 0.5];
    let model = folder.path().join("model.toml");
    Model::of(&law, FORCE, &values, &[None; 6]).write(&model).unwrap();
    let profile = palpate_tests::workspace().join("tests/profiles/creep.toml");
    for noise in ["0", "0.001", "0.005", "0.02"] {
        for seed in ["1", "2", "3"] {
            let path = folder.path().join(format!("crept-{noise}-{seed}.csv"));
            palpate()
                .args(["simulate", "--noise", noise, "--seed", seed, "--force"])
                .arg(&profile)
                .arg(&model)
                .arg("-o")
                .arg(&path)
                .assert()
                .success();
            let found = answer(&["creep", "--terms", "1"], std::slice::from_ref(&path));
            let holds = found["holds"].as_array().unwrap();
            assert_eq!(holds.len(), 2, "{noise} N, seed {seed}: {holds:#?}");
            assert!(found["left_out"].as_array().unwrap().is_empty());
            for (hold, (ends, kind)) in holds.iter().zip([(0.51, "Type I"), (10.27, "Type II")]) {
                let from = hold["from_s"].as_f64().unwrap();
                assert!(
                    (ends - 0.02..ends + 0.6).contains(&from),
                    "{noise} N, seed {seed}: {from}"
                );
                assert_eq!(hold["type"], kind);
                assert!(hold["parameters"]["N"]["value"].as_f64().unwrap() > 0.0);
            }
        }
    }
}

#[test]
fn a_scrap_of_a_hold_is_left_out_with_its_reason_and_ends_nothing() {
    let folder = tempfile::tempdir().unwrap();
    // Held for 20 s, then for eight samples, at another force.
    let mut slow = 0.0;
    let rows = (0..2200).map(move |k| {
        let t = 0.01 * f64::from(k);
        let force = if t < 1.0 {
            2.0 * t
        } else if t < 21.0 {
            2.0
        } else {
            (2.0 + 20.0 * (t - 21.0)).min(3.0)
        };
        let force = if t > 21.13 { (3.0 - 20.0 * (t - 21.13)).max(0.0) } else { force };
        slow += (force - slow) * 0.006;
        [t, 1.5 * force + 0.3 * slow, force]
    });
    let path = write(folder.path(), "scrap.csv", "# control = \"force\"\n", rows);
    let found = answer(&["creep", "--terms", "4"], &[path]);
    assert_eq!(found["holds"].as_array().unwrap().len(), 1, "{found:#}");
    let left_out = found["left_out"].as_array().unwrap();
    assert!(left_out.len() <= 1, "{left_out:?}");
    assert!(left_out.iter().all(|text| text.as_str().unwrap().contains("too few")), "{left_out:?}");
}

#[test]
fn loading_rates_give_one_stiffness_and_asymptotes_that_agree() {
    let folder = tempfile::tempdir().unwrap();
    let runs: Vec<PathBuf> =
        [20.0, 40.0, 60.0, 80.0, 100.0].map(|rate| pressed(folder.path(), rate, SILICONE)).into();
    let found = answer(&["rates"], &runs);
    let number = |key: &str| found[key].as_f64().unwrap();
    assert!((number("specific_stiffness_Pa") / 3.5e4 - 1.0).abs() < 2e-3, "{found}");
    assert!((number("v1_per_s") - 0.5).abs() < 5e-3);
    let group = &found["groups"][0];
    assert!(group["asymptotes_agree_p_value"].as_f64().unwrap() > 1e-3);
    let trend = &group["peak_trend"];
    assert!(trend["slope_N_per_decade"].as_f64().unwrap() > 0.0);
    // The peaks have standard errors, and by them the stiffening is shown.
    assert!(trend["p_value"].as_f64().unwrap() < 1e-6, "{trend}");
    assert!(group["peaks_agree_p_value"].as_f64().unwrap() < 1e-6);
}

#[test]
fn what_is_missing_of_the_geometry_is_asked_for_and_options_supply_it() {
    let folder = tempfile::tempdir().unwrap();
    let bare = [pressed(folder.path(), 50.0, "")];
    assert!(refusal(&["rates"], &bare).contains("--shape"));
    assert!(
        refusal(&["rates", "--shape", "cylinder", "--radius", "25", "--height", "30"], &bare)
            .contains("--poisson")
    );
    let told =
        ["rates", "--shape", "cylinder", "--radius", "25", "--height", "30", "--poisson", "0.48"];
    let found = answer(&told, &bare);
    assert!((found["specific_stiffness_Pa"].as_f64().unwrap() / 3.5e4 - 1.0).abs() < 5e-3);
    assert!(refusal(&["strain-rate", "--modulus", "0"], &bare).contains("above 0"));
}

#[test]
fn the_power_law_of_a_ball_comes_back_from_its_force() {
    let folder = tempfile::tempdir().unwrap();
    let ball = [ball(folder.path())];
    let found = answer(&["strain-rate", "--modulus", "2.8e4"], &ball);
    assert_eq!(found["order"], 5.0);
    let hold = &found["holds"][0];
    let number = |hold: &Value, key: &str| hold[key].as_f64().unwrap();
    assert!((number(hold, "rate_per_s") / 2.6e4 - 1.0).abs() < 1e-2, "{hold}");
    assert!((number(hold, "equilibrium_strain") - 0.2193).abs() < 1e-4);
    assert_eq!(hold["type"], "Type I");
    assert!(number(&hold["derivative"], "bandwidth_Hz") > 0.0);
    let each = answer(&["strain-rate", "--modulus", "2.8e4", "--faces", "each"], &ball);
    assert!(number(&each["holds"][0], "equilibrium_strain") > 1.5 * 0.2193);
}

#[test]
fn the_run_of_figure_7_8_is_made_along_a_recording_and_its_rate_found() {
    use palpate::analysis::geometry::{Faces, Geometry};
    use palpate::analysis::segment_run::Setting;
    let folder = tempfile::tempdir().unwrap();
    let setting = Setting {
        geometry: Geometry::Ball { radius_mm: 35.0, faces: Faces::Each },
        faces: Faces::Each,
        modulus_pa: 2.8e4,
        segments: 8,
        order: 5.0,
        rate: 2.0e4,
    };
    // Steps of 5 mm at 500 mm/min, holds of 10 s.
    let time: Vec<f64> = (0..2650).map(|k| 0.02 * f64::from(k)).collect();
    let x = |t: &f64| 5.0 * (t / 10.6).floor() + (500.0 / 60.0 * (t % 10.6)).min(5.0);
    let x: Vec<f64> = time.iter().map(x).collect();
    let force = setting.force(&time, &x);
    let rows = (0..time.len()).map(|k| [time[k], x[k], force[k]]);
    let head = "# [specimen]\n# shape = \"sphere\"\n# radius_mm = 35\n";
    let ball = [write(folder.path(), "ball.csv", head, rows)];
    let call = ["strain-rate", "--modulus", "2.8e4", "--faces", "each", "--order", "5"];
    let found = answer(&[&call[..], &["--simulate", "8"]].concat(), &ball);
    let run = &found["simulated"][0];
    assert!((run["rate_per_s"].as_f64().unwrap() / 2e4 - 1.0).abs() < 1e-3, "{run}");
    assert!(run["rms_N"].as_f64().unwrap() < 1e-3 && run["rate_fitted"] == true, "{run}");
    // Another rate is another force; and one order is needed.
    let other = answer(&[&call[..], &["--simulate", "8", "--rate", "2e3"]].concat(), &ball);
    assert!(other["simulated"][0]["rms_N"].as_f64().unwrap() > 0.05);
    let free = ["strain-rate", "--modulus", "2.8e4", "--order", "free", "--simulate", "8"];
    assert!(refusal(&free, &ball).contains("one order"));
    assert!(answer(&call, &ball).get("simulated").is_none());
}

#[test]
fn markers_inside_a_specimen_tell_the_rate_of_its_law() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let run = |call: &[&str]| {
        palpate().args(call).assert().success();
    };
    let press = bundled("table-3.1-row-05.csv").display().to_string();
    run(&["fit", "latency", &press, "--segments", "4", "-o", &path("m.toml")]);
    run(&["simulate", &path("m.toml"), "--motion", &press, "--nodes", "-o", &path("n.csv")]);
    let text = std::fs::read_to_string(path("n.csv")).unwrap().replace("node", "marker");
    std::fs::write(path("seen.csv"), text).unwrap();
    let model = Model::read(&folder.path().join("m.toml")).unwrap();
    let (_, parameters) = model.law().unwrap();
    let found = answer(&["markers", "--order", "1"], &[folder.path().join("seen.csv")]);
    let gaps = found["gaps"].as_array().unwrap();
    assert_eq!(gaps.len(), 2, "{found}");
    for gap in gaps {
        let rate = gap["rate_per_s"].as_f64().unwrap();
        assert!((rate / parameters[2] - 1.0).abs() < 0.02, "{rate} for {}", parameters[2]);
    }
    assert!(refusal(&["markers"], &[bundled("press.csv")]).contains("marker1_mm"));
}

#[test]
fn odd_recordings_are_refused_or_analysed_but_never_break_a_command() {
    let folder = tempfile::tempdir().unwrap();
    type Shape = fn(f64) -> [f64; 2];
    let shapes: [(&str, Shape); 7] = [
        ("nothing-moves", |_| [0.0, 0.0]),
        ("huge", |t| [(t * 3.0).min(5.0), 1e300 * t]),
        ("tiny", |t| [(t * 3.0).min(5.0) * 1e-300, 1e-300 * t]),
        ("backwards", |t| [-(t * 3.0).min(5.0), -2.0 + t]),
        ("steps", |t| [t.floor(), t.floor()]),
        ("still-hold", |t| [(t * 3.0).min(5.0), (t * 3.0).min(5.0)]),
        ("sine", |t| [1.0 + (3.0 * t).sin(), (3.1 * t).sin()]),
    ];
    for (name, shape) in shapes {
        let rows = (0..400).map(|k| 0.025 * f64::from(k)).map(|t| {
            let [x, force] = shape(t);
            [t, x, force]
        });
        let path = write(folder.path(), &format!("{name}.csv"), SILICONE, rows);
        for arguments in [
            &["segment"][..],
            &["relaxation"],
            &["creep"],
            &["creep", "--cutoff", "3"],
            &["rates"],
            &["strain-rate", "--modulus", "1e4"],
            &["strain-rate", "--modulus", "1e4", "--order", "free"],
            &["strain-rate", "--modulus", "1e4", "--simulate", "8"],
            &["markers"],
            &["events"],
        ] {
            let output = palpate().args(arguments).arg(&path).output().unwrap();
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(matches!(output.status.code(), Some(0 | 2)), "{name} {arguments:?}: {said}");
            assert!(!said.contains("panicked"), "{name} {arguments:?}: {said}");
        }
    }
}

#[test]
fn every_analysis_writes_a_report() {
    let folder = tempfile::tempdir().unwrap();
    let run = pressed(folder.path(), 50.0, SILICONE);
    for arguments in
        [&["segment"][..], &["relaxation"], &["rates"], &["strain-rate", "--modulus", "3.5e4"]]
    {
        let report = folder.path().join("report.html");
        let output =
            palpate().args(arguments).arg(&run).arg("--report").arg(&report).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let page = std::fs::read_to_string(&report).unwrap();
        assert!(page.contains("<svg") && page.contains("<table"), "{arguments:?}");
    }
}

#[test]
fn the_growth_of_a_pull_off_is_told_where_the_speeds_tell_it() {
    let folder = tempfile::tempdir().unwrap();
    let law = |v: f64| 0.5 * (1.0 + (v / 0.3).powf(0.6));
    let speeds = [0.03, 0.1, 0.3, 1.0, 3.0, 10.0];
    let pads: Vec<PathBuf> =
        speeds.iter().map(|speed| pad(folder.path(), *speed, law(*speed))).collect();
    let found = answer(&["segment"], &pads);
    let pull = &found["traces"][1]["cycles"][0]["pull_off"];
    assert!((pull["force_N"].as_f64().unwrap() - law(0.1)).abs() < 0.01, "{pull}");
    let growth = &found["pull_off_growth"];
    let told: Vec<f64> = growth["speeds"]
        .as_array()
        .unwrap()
        .iter()
        .map(|speed| speed["speed_mm_per_s"].as_f64().unwrap())
        .collect();
    assert!(told.iter().zip(speeds).all(|(a, b)| (a / b - 1.0).abs() < 0.02), "{told:?}");
    for (name, truth) in [("F0_N", 0.5), ("v0_mm_per_s", 0.3), ("n", 0.6)] {
        let found = &growth["law"][name];
        let [value, error] = ["value", "standard_error"].map(|key| found[key].as_f64().unwrap());
        assert!((value - truth).abs() < 4.0 * error + 0.02 * truth, "{name}: {value} ± {error}");
    }
    // Three speeds cannot tell three parameters and their errors.
    let few = answer(&["segment"], &pads[..3]);
    assert!(few["pull_off_growth"]["law"].is_null());
    assert!(few["pull_off_growth"]["not_identifiable"].as_str().unwrap().contains("too few"));
    // One speed is no growth.
    assert!(answer(&["segment"], &pads[..1])["pull_off_growth"].is_null());
}
