//! What a program that reads an answer may rely on: `docs/schema/`, one JSON schema an answer, held to what the commands print.
//! `INSTA_UPDATE=always cargo test --workspace --test schemas` writes the schemas anew.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use boon::{Compiler, Schemas};
use palpate::answers::schemas;
use palpate_tests::{answer, bundled, palpate, workspace};

/// Calls of every command that answers in JSON, by the schema of its answer, in the folder of [`lab`].
const CALLS: &[(&str, &[&str])] = &[("compare", &["compare", "model.toml", "traces"])];

/// A folder with recordings in `traces/` and a model of them.
fn lab() -> tempfile::TempDir {
    let lab = tempfile::tempdir().unwrap();
    fs::create_dir(lab.path().join("traces")).unwrap();
    for row in 1..=3 {
        let name = format!("table-3.1-row-{row:02}.csv");
        fs::copy(bundled(&name), lab.path().join("traces").join(name)).unwrap();
    }
    done(lab.path(), &["fit", "fung", "traces", "-o", "model.toml"]);
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
        let printed = answer(lab.path(), &[arguments, &["--json"][..]].concat());
        if let Err(wrong) = known.validate(&printed, schema) {
            panic!("palpate {}: {wrong:#}\n{printed:#}", arguments.join(" "));
        }
    }
}
