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
    ("compare", &["compare", "model.toml", "traces"]),
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

/// A folder with recordings in `traces/` and a model of them, a press of a fingertip and a practice set.
fn lab() -> tempfile::TempDir {
    let lab = tempfile::tempdir().unwrap();
    fs::create_dir(lab.path().join("traces")).unwrap();
    for row in 1..=3 {
        let name = format!("table-3.1-row-{row:02}.csv");
        fs::copy(bundled(&name), lab.path().join("traces").join(name)).unwrap();
    }
    fs::copy(bundled("press.csv"), lab.path().join("press.csv")).unwrap();
    done(lab.path(), &["fit", "fung", "traces", "-o", "model.toml"]);
    done(lab.path(), &["hide", "mullins", "--seed", "7", "-o", "practice"]);
    lab
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
        let printed = answer(lab.path(), &[arguments, &["--json"][..]].concat());
        kept.holds(name, &printed, arguments);
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
