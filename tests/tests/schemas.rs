//! What a program that reads an answer may rely on: `docs/schema/`, one JSON schema an answer, held to what the commands print.
//! `INSTA_UPDATE=always cargo test --workspace --test schemas` writes the schemas anew.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use boon::{Compiler, Schemas};
use palpate::answers::schemas;
use palpate_tests::{answer, bundled, palpate, workspace};
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
    ("convert", &["convert", "press.csv", "-o", "press.palpate"]),
    ("convert", &["convert", "press.palpate", "traces", "-o", "all.csv"]),
    ("hide-record", &["hide", "--record", "traces/table-3.1-row-01.csv", "-o", "practice"]),
    ("plan", &["plan", "--noise", "0.01"]),
    ("plan", &["plan", "--noise", "0.01", "--want", "v1=2"]),
    ("plan", &["plan", "--noise", "0.01", "--want", "v2=0.001"]),
];

/// The same of a device, which is simulated in that folder.
const DEVICE_CALLS: &[(&str, &[&str])] = &[
    ("device-calibrate", &["device", "calibrate", "--points", "bench.csv"]),
    ("device-calibrate", &["device", "calibrate", "--gauge", "2", "--gain=0.001", "--offset=-7"]),
    ("device-info", &["device", "info"]),
    ("device-self-test", &["device", "self-test"]),
    ("device-set", &["device", "set", "--rate", "2000", "--threshold", "touch=33", "--save"]),
    ("device-tare", &["device", "tare"]),
];
/// Ports that are asked who is there: that device and one without.
const LIST: (&str, &[&str]) = ("device-list", &["device", "list", "fingertip", "absent"]);
/// A recording of it, so long that something is felt: an object a second, and a last one.
const RECORD: ([&str; 2], &[&str]) = (
    ["record-second", "record"],
    &["record", "-o", "take.palpate", "--mcap", "take.mcap", "--duration", "5.2"],
);

/// A folder with recordings in `traces/`, a model of them, force curves, slides, hands, a press and a practice set.
fn lab() -> tempfile::TempDir {
    let lab = tempfile::tempdir().unwrap();
    fs::create_dir(lab.path().join("traces")).unwrap();
    for row in 1..=3 {
        let name = format!("table-3.1-row-{row:02}.csv");
        fs::copy(bundled(&name), lab.path().join("traces").join(name)).unwrap();
    }
    fs::copy(bundled("press.csv"), lab.path().join("press.csv")).unwrap();
    done(lab.path(), &["fit", "fung", "traces", "-o", "model.toml"]);
    force_curves(lab.path());
    slides(lab.path());
    hands(lab.path());
    done(lab.path(), &["sensor", "press", "-o", "press.palpate"]);
    done(lab.path(), &["hide", "mullins", "--seed", "7", "-o", "practice"]);
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
    let calls = CALLS.iter().chain(DEVICE_CALLS).map(|(name, _)| *name);
    let called: BTreeSet<&str> = calls.chain([LIST.0]).chain(RECORD.0).collect();
    let known: BTreeSet<&str> = schemas().into_iter().map(|(name, _)| name).collect();
    assert_eq!(called, known);
}

#[test]
fn what_is_printed_follows_its_schema() {
    let lab = lab();
    let mut kept = Kept::default();
    for (name, arguments) in CALLS {
        let printed = answers(lab.path(), arguments);
        assert!(!printed.is_empty(), "palpate {}", arguments.join(" "));
        for answer in printed {
            kept.holds(name, &answer, arguments);
        }
    }
}

/// The schemas of `docs/schema/`.
#[derive(Default)]
struct Kept {
    known: Schemas,
    compiler: Compiler,
}

impl Kept {
    /// Fails where what a call printed does not follow the schema of this name.
    fn holds(&mut self, name: &str, printed: &Value, arguments: &[&str]) {
        let path = file(name);
        let schema = self.compiler.compile(&path.to_string_lossy(), &mut self.known).unwrap();
        if let Err(wrong) = self.known.validate(printed, schema) {
            panic!("palpate {}: {wrong:#}\n{printed:#}", arguments.join(" "));
        }
    }
}

/// A simulated device in a folder, until it is dropped.
#[cfg(unix)]
struct Fingertip(std::process::Child);

#[cfg(unix)]
impl Drop for Fingertip {
    fn drop(&mut self) {
        // One that has ended on its own is as good.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[cfg(unix)]
#[test]
fn what_a_device_answers_follows_its_schema() {
    let lab = tempfile::tempdir().unwrap();
    let bench = "gauge,strain_ustrain,counts\n1,0,1000\n1,500,251010\n1,1000,500990\n3,0,-40\n3,100,-50040\n";
    fs::write(lab.path().join("bench.csv"), bench).unwrap();
    let _fingertip = Fingertip(palpate_tests::server::simulate(lab.path()));
    let mut kept = Kept::default();
    for (name, arguments) in DEVICE_CALLS {
        let call = [arguments, &["--json", "--port", "fingertip"][..]].concat();
        kept.holds(name, &answer(lab.path(), &call), arguments);
    }
    let (name, arguments) = LIST;
    kept.holds(name, &answer(lab.path(), &[arguments, &["--json"]].concat()), arguments);

    let ([second, last], arguments) = RECORD;
    let call = [arguments, &["--json", "--port", "fingertip"]].concat();
    let output = palpate().current_dir(lab.path()).args(&call).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let lines = String::from_utf8(output.stdout).unwrap();
    let mut objects: Vec<Value> =
        lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    kept.holds(last, &objects.pop().unwrap(), arguments);
    assert!(!objects.is_empty(), "an object a second");
    for object in objects {
        kept.holds(second, &object, arguments);
    }
}
