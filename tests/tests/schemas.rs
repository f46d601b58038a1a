//! What a program that reads an answer may rely on: `docs/schema/`, one JSON schema an answer, held to what the commands print.
//! `INSTA_UPDATE=always cargo test --workspace --test schemas` writes the schemas anew.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use palpate::answers::schemas;
use palpate::trace::read_set;
use palpate_tests::{answer, bundled, follows_schema, palpate, schema_file, workspace};

/// Calls of every command that answers in JSON, by the schema of its answer, in the folder of [`lab`].
/// `next_motion` and `discover` hold a proposed motion and formulas to their schemas, which take longer to find.
const CALLS: &[(&str, &[&str])] = &[
    ("add", &["add", "mullins", "model.toml", "traces"]),
    ("compare", &["compare", "model.toml", "traces"]),
    ("diagnose", &["diagnose", "--model", "few.toml", "few"]),
    ("discover", &["discover", "--model", "few.toml", "few"]),
    ("drop", &["drop", "mullins", "better.toml", "traces"]),
    ("effects-check", &["effects", "--check", "laws.toml"]),
    ("effects-list", &["effects"]),
    ("effects-one", &["effects", "mullins"]),
    ("explore", &["explore", "--model", "stress.toml", "stress"]),
    ("explore", &["explore", "--model", "model.toml", ROW, "-o", "top.toml"]),
    ("fit", &["fit", "fung", "few", "--terms", "auto"]),
    ("fit", &["fit", "latency", ROW, "--segments", "2"]),
    ("fit-holds", &["fit", "fung", "traces", "--hold-only", "--terms", "auto"]),
    ("fit-rank", &["fit", "--all", "few"]),
    ("fit-rank", &["fit", "--all", ROW, "--terms", "1"]),
    ("hide", &["hide", "mullins", "--seed", "7", "-o", "practice"]),
    ("hide-open", &["hide", "--open", "set"]),
    ("hide-record", &["hide", "--record", ROW, "-o", "set"]),
];
/// One of the recordings.
const ROW: &str = "traces/table-3.1-row-01.csv";

/// A folder with recordings in `traces/` and models of them, laws of one's own, a practice set, and in `few/` three recordings of it
/// that two effects explain alike, in `stress/` the same with another unit.
fn lab() -> tempfile::TempDir {
    let lab = tempfile::tempdir().unwrap();
    fs::create_dir(lab.path().join("traces")).unwrap();
    for row in 1..=3 {
        let name = format!("table-3.1-row-{row:02}.csv");
        fs::copy(bundled(&name), lab.path().join("traces").join(name)).unwrap();
    }
    done(lab.path(), &["fit", "fung", "traces", "-o", "model.toml"]);
    done(lab.path(), &["add", "mullins", "model.toml", "traces", "-o", "better.toml"]);
    let laws = workspace().join("tests/discover/teeth.toml");
    fs::copy(laws, lab.path().join("laws.toml")).unwrap();
    practice(lab.path());
    lab
}

/// A practice set, and three recordings of it in N and in kPa with a model each.
fn practice(folder: &Path) {
    let hide = ["hide", "elastic-stiffening", "--seed", "2", "--size", "0.3", "-o", "set"];
    done(folder, &hide);
    fs::create_dir(folder.join("few")).unwrap();
    fs::create_dir(folder.join("stress")).unwrap();
    for trace in read_set(&[folder.join("set")]).unwrap().iter().take(3) {
        let text = fs::read_to_string(folder.join("set").join(trace.label())).unwrap();
        let stress = text.replace("force_N", "stress_kPa");
        fs::write(folder.join("few").join(trace.label()), text).unwrap();
        fs::write(folder.join("stress").join(trace.label()), stress).unwrap();
    }
    done(folder, &["fit", "fung", "few", "-o", "few.toml"]);
    done(folder, &["fit", "fung", "stress", "--signal", "stress_kPa", "-o", "stress.toml"]);
}

fn done(folder: &Path, arguments: &[&str]) {
    let output = palpate().current_dir(folder).args(arguments).output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {error}");
}

#[test]
fn the_schemas_are_those_of_the_types() {
    let update = std::env::var("INSTA_UPDATE").is_ok_and(|how| how == "always");
    for (name, schema) in schemas() {
        let text = format!("{:#}\n", schema.as_value());
        if update {
            fs::write(schema_file(name), &text).unwrap();
        }
        let kept = fs::read_to_string(schema_file(name)).unwrap_or_default();
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
    for (name, arguments) in CALLS {
        follows_schema(name, &answer(lab.path(), &[arguments, &["--json"][..]].concat()));
    }
}
