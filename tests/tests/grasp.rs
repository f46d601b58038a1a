//! `palpate grasp` from the command line: what a contact carries, over time and on a stream.

use std::fmt::Write as _;
use std::path::Path;

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
