//! `palpate grasp` from the command line: what a contact carries, over time and on a stream.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use palpate::model::{BaseLaw, Model, Separation};
use palpate_tests::{bundled, palpate};
use serde_json::Value;

/// Exit status, standard output, standard error.
fn call(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output = palpate().current_dir(folder).arg("grasp").args(arguments).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().unwrap_or(-1), text(&output.stdout), text(&output.stderr))
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    let (status, out, error) = call(folder, &[arguments, &["--json"]].concat());
    assert_eq!(status, 0, "{arguments:?}: {error}");
    serde_json::from_str(&out).unwrap()
}

/// A ball of 20 mm pressed 3 mm in, held while it relaxes, and pulled harder and harder.
fn pull(folder: &Path, columns: &str) {
    let mut text = String::from(
        "# [specimen]\n# shape = \"sphere\"\n# radius_mm = 20\ntime_s,displacement_mm,force_N,tangential_N",
    );
    writeln!(text, "{columns}").unwrap();
    for k in 0..1000 {
        let t = 0.01 * f64::from(k);
        let pressed = 3.0 * ((t - 1.0) / 0.5).clamp(0.0, 1.0);
        let held = (t - 1.5).max(0.0);
        let force = pressed * (0.5 + 0.3 * (-held).exp());
        let pull = 0.15 * (t - 2.0).max(0.0);
        write!(text, "{t:.2},{pressed:.4},{force:.6},{pull:.4}").unwrap();
        writeln!(text, "{}", if columns.is_empty() { "" } else { ",1.0" }).unwrap();
    }
    std::fs::write(folder.join("pull.csv"), text).unwrap();
}

#[test]
fn a_uniform_round_contact_has_its_closed_form() {
    let folder = tempfile::tempdir().unwrap();
    let call = ["surface", "--contact", "circle:5", "--exponent", "inf", "--friction", "0.7"];
    let surface = json(folder.path(), &[&call[..], &["--force", "2"]].concat());
    assert_eq!(surface["palpate_grasp_surface"], 1);
    let moment = surface["largest_moment_Nmm"].as_f64().unwrap();
    assert!((moment / (2.0 / 3.0 * 0.7 * 2.0 * 5.0) - 1.0).abs() < 1e-6);
    assert!((surface["largest_force_N"].as_f64().unwrap() - 1.4).abs() < 1e-12);
    assert_eq!(surface["points"].as_array().unwrap().len(), 201);
}

#[test]
fn a_surface_goes_into_a_file_and_a_report() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "surface",
        "--contact",
        "rectangle:42.22x26.38",
        "--exponent",
        "4",
        "--friction",
        "0.7",
        "--force",
        "2",
        "--tangential",
        "0.5",
        "--moment",
        "-4",
        "-o",
        "surface.csv",
        "--report",
        "surface.html",
    ];
    let (status, out, error) = call(folder.path(), &arguments);
    assert_eq!(status, 0, "{error}");
    assert!(out.contains("largest moment") && out.contains("holds"), "{out}");
    let csv = std::fs::read_to_string(folder.path().join("surface.csv")).unwrap();
    assert_eq!(csv.lines().count(), 202);
    let report = std::fs::read_to_string(folder.path().join("surface.html")).unwrap();
    assert!(report.matches("<svg").count() >= 2);
}

#[test]
fn creep_widens_the_contact_and_relaxation_loosens_it() {
    let folder = tempfile::tempdir().unwrap();
    let body =
        ["growth", "--contact", "block:40x25x50:0.48", "--exponent", "4", "--friction", "0.7"];
    let ends = |more: &[&str]| {
        let grown = json(folder.path(), &[&body[..], more].concat());
        let course = grown["course"].as_array().unwrap().clone();
        let of = |key: &str| {
            course[course.len() - 1][key].as_f64().unwrap() / course[0][key].as_f64().unwrap()
        };
        (of("largest_force_N"), of("largest_moment_Nmm"))
    };
    let creep = ["--creep", "8.1", "--shares=-0.0738,-0.214", "--rates", "0.8229,0.007805"];
    let (force, moment) = ends(&[&creep[..], &["--force", "2"]].concat());
    assert!(force == 1.0 && moment > 1.005 && moment < 1.01, "{moment}");
    let hold = ["--shares", "0.2472,0.2676", "--rates", "3.981,0.5325", "--compression", "5"];
    let (force, moment) = ends(&[&hold[..], &["--force", "2"]].concat());
    assert!((force - 0.4865).abs() < 1e-3 && (moment - force).abs() < 1e-9, "{force}");
}

#[test]
fn a_fitted_model_foretells_the_growth() {
    let folder = tempfile::tempdir().unwrap();
    let press = bundled("table-3.1-row-06.csv");
    palpate()
        .current_dir(folder.path())
        .args(["fit", "fung", press.to_str().unwrap(), "-o", "model.toml"])
        .assert()
        .success();
    let body = ["growth", "--contact", "sphere:35", "--friction", "0.7", "--model", "model.toml"];
    let creep = json(folder.path(), &[&body[..], &["--force", "1"]].concat());
    let course = creep["course"].as_array().unwrap();
    let compression = |k: usize| course[k]["compression_mm"].as_f64().unwrap();
    assert!(compression(100) > compression(0) * 1.2, "{} {}", compression(0), compression(100));
    let relaxing = json(folder.path(), &[&body[..], &["--compression", "12"]].concat());
    let course = relaxing["course"].as_array().unwrap();
    let normal = |k: usize| course[k]["normal_N"].as_f64().unwrap();
    assert!(normal(100) < 0.6 * normal(0));
}

#[test]
fn the_instant_of_slip_of_a_recorded_pull_is_found() {
    let folder = tempfile::tempdir().unwrap();
    pull(folder.path(), "");
    let found = json(
        folder.path(),
        &["margin", "pull.csv", "--friction", "0.6", "--contact-above", "0.01"],
    );
    let trace = &found["traces"][0];
    // 0.15 (t − 2) = 0.6 · 3 (0.5 + 0.3 e^(−(t − 1.5))) at t = 8.0054 s.
    let slip = trace["first_slip_s"].as_f64().unwrap();
    assert!((slip - 8.0054).abs() < 2e-3, "{slip}");
    assert!(trace["smallest_margin"].as_f64().unwrap() < 1.0);
    pull(folder.path(), ",moment_Nmm");
    let twisted = json(
        folder.path(),
        &["margin", "pull.csv", "--friction", "0.6", "--contact-above", "0.01"],
    );
    assert!(twisted["traces"][0]["first_slip_s"].as_f64().unwrap() < slip);
    let (status, out, error) = call(
        folder.path(),
        &[
            "margin",
            "pull.csv",
            "--friction",
            "2",
            "--contact-above",
            "0.01",
            "--moment",
            "0",
            "-o",
            "m.csv",
        ],
    );
    assert_eq!(status, 0, "{error}");
    assert!(out.contains("never slips"), "{out}");
    assert_eq!(std::fs::read_to_string(folder.path().join("m.csv")).unwrap().lines().count(), 1001);
}

#[test]
fn a_recording_of_gauges_is_followed_line_by_line() {
    let folder = tempfile::tempdir().unwrap();
    let press = bundled("press.csv");
    let arguments = [
        "watch",
        "--recording",
        press.to_str().unwrap(),
        "--contact",
        "circle:5",
        "--friction",
        "0.7",
        "--normal",
        "0.001",
        "--tangential",
        "0.3",
        "--rest",
        "0.5",
        "--every",
        "0.5",
    ];
    let (status, out, error) = call(folder.path(), &[&arguments[..], &["--json"]].concat());
    assert_eq!(status, 0, "{error}");
    let lines: Vec<Value> = out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(lines.len() > 20, "{out}");
    assert!(lines.iter().any(|line| line["state"] == "none"));
    let held: Vec<&Value> = lines.iter().filter(|line| line["now"]["margin"].is_number()).collect();
    assert!(!held.is_empty(), "{out}");
    for line in held {
        let margin = line["now"]["margin"].as_f64().unwrap();
        let normal = line["now"]["normal_N"].as_f64().unwrap();
        assert!((margin - 0.7 * normal / 0.3).abs() < 1e-6 * margin, "{line}");
    }
    let (_, words, _) = call(folder.path(), &arguments);
    assert_eq!(words.lines().count(), lines.len());
    assert!(words.contains("settled"), "{words}");
}

#[test]
fn what_is_wrong_is_said_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    pull(folder.path(), "");
    let press = bundled("press.csv");
    let press = press.to_str().unwrap();
    let pad = ["--contact", "circle:5", "--friction", "0.7"];
    for (arguments, words) in [
        (&["surface", "--contact", "cone:5", "--friction", "1", "--force", "1"][..], "circle:R"),
        (&["surface", "--contact", "circle:5", "--friction", "0", "--force", "1"], "above 0"),
        (
            &[
                "surface",
                "--contact",
                "circle:5",
                "--friction",
                "1",
                "--force",
                "1",
                "--exponent",
                "0.5",
            ],
            "1 or more",
        ),
        (&["surface", "--contact", "sphere:5", "--friction", "1", "--force", "1"], "--compression"),
        (&["growth", "--contact", "sphere:5", "--friction", "1", "--force", "1"], "give --model"),
        (
            &[
                "growth",
                "--contact",
                "circle:5",
                "--friction",
                "1",
                "--force",
                "1",
                "--shares",
                "0.7,0.6",
                "--rates",
                "1,2",
            ],
            "no more than 1",
        ),
        (&["margin", press, "--friction", "0.7"], "--contact"),
        (&["margin", press, pad[0], pad[1], pad[2], pad[3]], "--tangential"),
        (&["margin", "pull.csv", "--friction", "0.7", "--contact-above", "90"], "no contact"),
        (
            &[
                "watch",
                "--recording",
                "pull.csv",
                pad[0],
                pad[1],
                pad[2],
                pad[3],
                "--normal",
                "0.001",
            ],
            "gauge1_ustrain",
        ),
        (&["watch", pad[0], pad[1], pad[2], pad[3], "--normal", "1,2"], "four with commas"),
    ] {
        let (status, out, error) = call(folder.path(), arguments);
        assert_eq!((status, out.as_str()), (2, ""), "{arguments:?}: {error}");
        assert!(error.contains(words), "{arguments:?}: {error}");
    }
}

/// Two fingertips that hold a weight of 4 N between them.
fn gripper(folder: &Path, more: &str) -> PathBuf {
    let finger = |name: &str, x: i32| {
        format!(
            "[[finger]]\nname = \"{name}\"\nposition_mm = [{x}, 0, 0]\nnormal = [{}, 0, 0]\n\
             contact = \"circle:6\"\nfriction = 0.5\nnormal_N = 5\n{more}",
            -x
        )
    };
    let text = format!(
        "palpate-hand = 1\n[load]\nforce_N = [0, 0, -4]\n{}{}",
        finger("left", -20),
        finger("right", 20)
    );
    let path = folder.join("hand.toml");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn a_hand_is_planned_with_its_least_grip_and_when_it_slips() {
    let place = tempfile::tempdir().unwrap();
    let model = place.path().join("tip.toml");
    let law = BaseLaw::fung(1, Separation::Clamp);
    Model::of(&law, "force_N", &[2.0, 0.5, 0.4, 0.5], &[None; 4]).write(&model).unwrap();
    let hand = gripper(place.path(), "model = \"tip.toml\"\n");
    let report = place.path().join("hand.html");
    let output = palpate()
        .args(["grasp", "plan", "--margin", "1.1", "--for", "60", "--json", "--report"])
        .arg(&report)
        .arg(&hand)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let plan: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(plan["force_closed"], true);
    // 4 N over 0.5, with a margin of 1.1.
    assert!((plan["least_grip_N"]["value"].as_f64().unwrap() - 8.8).abs() < 1e-5, "{plan:#}");
    assert!((plan["now"]["value"].as_f64().unwrap() - 1.25).abs() < 1e-5);
    // 5 N (0.6 + 0.4 e^(−0.5 t)) falls to 4 N.
    let slips = plan["forecast"]["slips_after_s"].as_f64().unwrap();
    assert!((slips - 2.0 * 2f64.ln()).abs() < 0.01, "{slips}");
    // 0.6 of the first squeeze and of what is added must be 4.4 N.
    let tighten = plan["forecast"]["tighten_by"].as_f64().unwrap();
    assert!((5.0 * tighten * 0.6 - 4.4).abs() < 0.02, "{tighten}");
    let page = std::fs::read_to_string(&report).unwrap();
    assert!(
        page.matches("<svg").count() >= 4 && page.contains("slips after"),
        "three views and a plot"
    );
}

#[test]
fn a_hand_that_cannot_be_is_refused_in_words() {
    let place = tempfile::tempdir().unwrap();
    for (more, arguments, word) in [
        ("", &["--for", "9"][..], "model"),
        ("contact = \"cube:3\"\n", &[], "not a hand"),
        ("most_N = 0\n", &[], "most_N"),
        ("model = \"none.toml\"\n", &[], "none.toml"),
        ("gripping = 3\n", &[], "gripping"),
    ] {
        let hand = gripper(place.path(), more);
        let output = palpate().args(["grasp", "plan"]).args(arguments).arg(&hand).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{more}: {said}");
        assert!(said.contains(word) && output.stdout.is_empty(), "{more}: {said}");
    }
}

#[test]
fn friction_is_identified_from_the_part_of_a_recording_that_slides() {
    let place = tempfile::tempdir().unwrap();
    let mut text = String::from("time_s,force_N,tangential_N\n");
    for k in 0..400 {
        let t = 0.01 * f64::from(k);
        // Pulled harder and harder until it slides at 2 s, with μ 0.55.
        let pull = if t < 2.0 { 0.5 * t } else { 1.1 + 1e-3 * f64::from(k % 7 - 3) };
        writeln!(text, "{t},2.0,{pull}").unwrap();
    }
    std::fs::write(place.path().join("slide.csv"), text).unwrap();
    let arguments = ["friction", "slide.csv", "--contact", "circle:5", "--from", "2"];
    let found = json(place.path(), &arguments);
    assert!((found["friction"].as_f64().unwrap() - 0.55).abs() < 1e-3, "{found}");
    assert_eq!(found["exponent_is_told"], false);
    let (status, out, said) =
        call(place.path(), &["friction", "slide.csv", "--contact", "circle:5", "--from", "9"]);
    assert!(status == 2 && out.is_empty() && said.contains("too few"), "{said}");
}
