//! What a program that reads an answer may rely on: `docs/schema/`, one JSON schema an answer, held to what the commands print.
//! `INSTA_UPDATE=always cargo test --workspace --test schemas` writes the schemas anew.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use boon::{Compiler, Schemas};
use palpate::answers::schemas;
use palpate_tests::{bundled, palpate, workspace};
use serde_json::Value;

/// Calls of every command that answers in JSON, by the schema of its answer, in the folder of [`lab`].
const CALLS: &[(&str, &[&str])] = &[
    ("afm", &["afm", "curve.csv", "still.csv", "flat.csv", "--tip-radius-nm=2500"]),
    ("afm", &["afm", "stiff.csv", "--shape=cone", "--half-angle-deg=20"]),
    ("afm-rough", &["afm", "rough", "--trials=20"]),
    ("compare", &["compare", "model.toml", "traces"]),
    ("grasp-friction", &["grasp", "friction", "slide.csv", "--contact=circle:5"]),
    (
        "grasp-friction",
        &["grasp", "friction", "twist.csv", "--contact=rectangle:30x20", "--across=shear_N"],
    ),
    (
        "grasp-growth",
        &[
            "grasp",
            "growth",
            "--contact=sphere:35",
            "--friction=0.7",
            "--model=model.toml",
            "--force=1",
        ],
    ),
    (
        "grasp-margin",
        &[
            "grasp",
            "margin",
            "pull.csv",
            "--contact=circle:5",
            "--friction=0.7",
            "--model=model.toml",
        ],
    ),
    (
        "grasp-margin",
        &["grasp", "margin", "slide.csv", "--contact=circle:5", "--friction=0.7", "--tangential=0"],
    ),
    ("grasp-plan", &["grasp", "plan", "finger.toml"]),
    (
        "grasp-plan",
        &["grasp", "plan", "hand.toml", "--model=model.toml", "--for=60", "--least=largest"],
    ),
    (
        "grasp-surface",
        &[
            "grasp",
            "surface",
            "--contact=circle:5",
            "--exponent=inf",
            "--friction=0.7",
            "--force=2",
        ],
    ),
    (
        "grasp-surface",
        &[
            "grasp",
            "surface",
            "--contact=ellipse:6x4",
            "--friction=0.7",
            "--force=2",
            "--tangential=0.5",
            "--moment=1",
        ],
    ),
    (
        "grasp-surface",
        &[
            "grasp",
            "surface",
            "--contact=rectangle:9x4",
            "--friction=0.7",
            "--force=2",
            "--tangential=0",
        ],
    ),
    (
        "grasp-watch",
        &[
            "grasp",
            "watch",
            "--recording=press.palpate",
            "--contact=circle:5",
            "--friction=0.7",
            "--normal=0.001",
            "--tangential=0.3",
        ],
    ),
    (
        "grasp-watch",
        &[
            "grasp",
            "watch",
            "--recording=press.palpate",
            "--contact=sphere:35",
            "--friction=0.7",
            "--normal=0.001",
            "--model=model.toml",
        ],
    ),
    ("sensor-frequency", &["sensor", "frequency", "--count=4", "--from=1"]),
    ("sensor-press", &["sensor", "press", "--indenter=sharp"]),
    ("sensor-press", &["sensor", "press", "--after=0.2", "--force=0.01"]),
    ("sensor-shake", &["sensor", "shake", "--duration=2"]),
    ("sensor-slide", &["sensor", "slide"]),
    ("sensor-slide", &["sensor", "slide", "--rate=100"]),
    ("sensor-slip", &["sensor", "slip"]),
];

/// A folder with recordings in `traces/`, a model of them, force curves, slides, hands and a press.
fn lab() -> tempfile::TempDir {
    let lab = tempfile::tempdir().unwrap();
    fs::create_dir(lab.path().join("traces")).unwrap();
    for row in 1..=3 {
        let name = format!("table-3.1-row-{row:02}.csv");
        fs::copy(bundled(&name), lab.path().join("traces").join(name)).unwrap();
    }
    done(lab.path(), &["fit", "fung", "traces", "-o", "model.toml"]);
    force_curves(lab.path());
    slides(lab.path());
    hands(lab.path());
    done(lab.path(), &["sensor", "press", "-o", "press.palpate"]);
    lab
}

/// Curves of a specimen that relaxes and adheres, of one that does neither, of a rigid one, and of none.
fn force_curves(folder: &Path) {
    let curve = |file: &str, of: &[&str]| {
        done(folder, &[&["afm", "simulate", "-o", file], of].concat());
    };
    curve("curve.csv", &["--hold", "1", "--relaxation", "0.2,4", "--pull-pn", "300"]);
    curve("still.csv", &["--hold", "1"]);
    curve("stiff.csv", &["--modulus-kpa", "1e7"]);
    let sample = |k: u32| [f64::from(k), 1e-5 * f64::from(k), 1e-11 * f64::from(7 * k % 13)];
    table(folder, "flat.csv", "time_s,displacement_mm,force_N", (0..200).map(sample));
}

/// A slide along a line, one that also turns, and a pull that slips in the end.
fn slides(folder: &Path) {
    let sample = |k: u32| [0.01 * f64::from(k), 2.0, 1.1 + 1e-3 * f64::from(k % 7)];
    table(folder, "slide.csv", "time_s,force_N,tangential_N", (0..100).map(sample));
    let sample = |k: u32| {
        let pull = (0.01 * (f64::from(k) - 40.0)).max(0.0);
        [0.01 * f64::from(k), if k < 20 { 0.0 } else { 2.0 }, pull]
    };
    table(folder, "pull.csv", "time_s,force_N,tangential_N", (0..300).map(sample));
    let pad = ["--contact", "rectangle:30x20", "--exponent", "4", "--friction", "0.6"];
    let surface = ["grasp", "surface", "--force", "2", "-o", "surface.csv"];
    done(folder, &[surface, pad].concat());
    let surface = fs::read_to_string(folder.join("surface.csv")).unwrap();
    let sample = |(k, point): (usize, &str)| {
        let load: Vec<f64> = point.split(',').skip(5).map(|cell| cell.parse().unwrap()).collect();
        [0.01 * k as f64, 2.0, load[0], load[1], load[2]]
    };
    let samples = surface.lines().skip(1).enumerate().map(sample);
    table(folder, "twist.csv", "time_s,force_N,tangential_N,shear_N,moment_Nmm", samples);
}

/// A hand of two fingers, and its first finger alone.
fn hands(folder: &Path) {
    let hand = fs::read_to_string(workspace().join("tests/hands/two-fingers.toml")).unwrap();
    let (finger, _) = hand.rsplit_once("[[finger]]").unwrap();
    fs::write(folder.join("finger.toml"), finger).unwrap();
    fs::write(folder.join("hand.toml"), &hand).unwrap();
}

fn table<const N: usize>(
    folder: &Path,
    file: &str,
    header: &str,
    rows: impl Iterator<Item = [f64; N]>,
) {
    let row = |row: [f64; N]| row.map(|cell| cell.to_string()).join(",") + "\n";
    let text = format!("{header}\n{}", rows.map(row).collect::<String>());
    fs::write(folder.join(file), text).unwrap();
}

/// The JSON that a call prints: one answer, or one after another.
fn answers(folder: &Path, arguments: &[&str]) -> Vec<Value> {
    let output = palpate().current_dir(folder).args(arguments).arg("--json").output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {error}");
    let printed = serde_json::Deserializer::from_slice(&output.stdout).into_iter();
    printed.collect::<Result<_, _>>().unwrap()
}

fn done(folder: &Path, arguments: &[&str]) {
    let output = palpate().current_dir(folder).args(arguments).output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {error}");
}

fn file(name: &str) -> PathBuf {
    workspace().join("docs/schema").join(name).with_extension("json")
}

#[test]
fn the_schemas_are_those_of_the_types() {
    let update = std::env::var("INSTA_UPDATE").is_ok_and(|how| how == "always");
    for (name, schema) in schemas() {
        let text = format!("{:#}\n", schema.as_value());
        if update {
            fs::write(file(name), &text).unwrap();
        }
        let kept = fs::read_to_string(file(name)).unwrap_or_default();
        assert!(kept == text, "docs/schema/{name}.json is not that of its type");
    }
}

#[test]
fn every_answer_has_a_schema_and_every_schema_a_call() {
    let called: BTreeSet<&str> = CALLS.iter().map(|(name, _)| *name).collect();
    let known: BTreeSet<&str> = schemas().into_iter().map(|(name, _)| name).collect();
    assert_eq!(called, known);
}

#[test]
fn what_is_printed_follows_its_schema() {
    let lab = lab();
    let (mut known, mut compiler) = (Schemas::new(), Compiler::new());
    for (name, arguments) in CALLS {
        let schema = compiler.compile(&file(name).to_string_lossy(), &mut known).unwrap();
        let printed = answers(lab.path(), arguments);
        assert!(!printed.is_empty(), "palpate {}", arguments.join(" "));
        for answer in printed {
            if let Err(wrong) = known.validate(&answer, schema) {
                panic!("palpate {}: {wrong:#}\n{answer:#}", arguments.join(" "));
            }
        }
    }
}
