//! What a program that reads an answer may rely on: `docs/schema/`, one JSON schema an answer, held to what the commands print.
//! `INSTA_UPDATE=always cargo test --workspace --test schemas` writes the schemas anew.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use boon::{Compiler, Schemas};
use palpate::answers::schemas;
use palpate_tests::specimens::{SILICONE, ball, crept, pad, pressed};
use palpate_tests::{answer, bundled, palpate, workspace};

/// Calls of every command that answers in JSON, by the schema of its answer, in the folder of [`lab`].
const CALLS: &[(&str, &[&str])] = &[
    ("compare", &["compare", "model.toml", "traces"]),
    ("creep", &["creep", "held.csv", "--terms", "1"]),
    ("creep", &["creep", "held.csv", "--terms", "3", "--cutoff", "20"]),
    ("decompose", &["decompose", "traces"]),
    ("events", &["events", "pull.csv"]),
    ("events", &["events", "traces"]),
    ("fit-holds", &["fit", "fung", "--hold-only", "traces/table-3.1-row-01.csv"]),
    ("markers", &["markers", "markers.csv"]),
    ("markers", &["markers", "markers.csv", "--order", "free"]),
    ("rates", &["rates", "runs"]),
    ("rates", &["rates", "runs/20.csv"]),
    ("relaxation", &["relaxation", "traces"]),
    ("relaxation", &["relaxation", "runs/20.csv"]),
    ("segment", &["segment", "pads"]),
    ("segment", &["segment", "traces"]),
    ("strain-rate", &["strain-rate", "--modulus", "2.8e4", "--order", "free", "ball.csv"]),
    ("strain-rate", &["strain-rate", "--modulus", "2.8e4", "--simulate", "8", "ball.csv"]),
    ("survey-report", &["survey", "report", "segmented"]),
    ("survey-report", &["survey", "report", "diagnosed"]),
];

/// Answers that take long to compute: the tests of their commands hold them to their schemas.
const ELSEWHERE: &[&str] = &["dissertation"];

/// A folder with recordings in `traces/` and a model of them; recordings of made-up specimens, and surveys.
fn lab() -> tempfile::TempDir {
    let lab = tempfile::tempdir().unwrap();
    fs::create_dir(lab.path().join("traces")).unwrap();
    for row in 1..=3 {
        let name = format!("table-3.1-row-{row:02}.csv");
        fs::copy(bundled(&name), lab.path().join("traces").join(name)).unwrap();
    }
    done(lab.path(), &["fit", "fung", "traces", "-o", "model.toml"]);
    add_specimens(lab.path());
    add_surveys(lab.path());
    lab
}

/// Runs at three rates, pads that adhere, a ball, a hold of a force, markers in a hold, and a contact that slips.
fn add_specimens(lab: &Path) {
    for folder in ["runs", "pads"] {
        fs::create_dir(lab.join(folder)).unwrap();
    }
    for rate in [20.0, 50.0, 100.0] {
        pressed(&lab.join("runs"), rate, SILICONE);
    }
    for speed in [0.03, 0.1, 0.3, 1.0, 3.0, 10.0] {
        pad(&lab.join("pads"), speed, 0.5 * (1.0 + (speed / 0.3f64).powf(0.6)));
    }
    ball(lab);
    crept(lab);
    let row = |k: i32| {
        let t = 0.05 * f64::from(k);
        let wobble = 1e-3 * (f64::from(k * 7919 % 101) / 50.0 - 1.0);
        format!("{t},{},{}\n", 2.0 + 0.5 * (-0.8 * t).exp() + wobble, 7.0 + (-0.6 * t).exp())
    };
    let rows: String = (0..200).map(row).collect();
    fs::write(lab.join("markers.csv"), format!("time_s,marker1_mm,marker2_mm\n{rows}")).unwrap();
    done(lab, &["sensor", "slip", "-o", "pull.csv"]);
}

/// A survey of eleven days, the last without a trace, and one of a specimen that lacks an effect in its model.
fn add_surveys(lab: &Path) {
    let put = |from: &Path, day: usize| {
        let folder = lab.join(format!("days/date={day}"));
        fs::create_dir_all(&folder).unwrap();
        fs::copy(from, folder.join("trace.csv")).unwrap();
    };
    for day in 1..=9 {
        put(&bundled(&format!("table-3.1-row-{day:02}.csv")), day);
    }
    put(&bundled("press.csv"), 10);
    put(&lab.join("model.toml"), 11);
    done(lab, &["survey", "segment", "days", "--by", "date", "-o", "segmented"]);
    done(lab, &["hide", "mullins", "--seed", "7", "-o", "practice"]);
    done(lab, &["fit", "fung", "practice", "-o", "practice.toml"]);
    fs::create_dir_all(lab.join("softened/date=1")).unwrap();
    for name in ["press-12mm-05mms.csv", "press-12mm-20mms.csv", "cycles-08mm-20mms.csv"] {
        fs::copy(lab.join("practice").join(name), lab.join("softened/date=1").join(name)).unwrap();
    }
    let diagnose = ["survey", "diagnose", "--model", "practice.toml", "softened", "--by", "date"];
    done(lab, &[&diagnose[..], &["-o", "diagnosed"]].concat());
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
    let called: BTreeSet<&str> =
        CALLS.iter().map(|(name, _)| *name).chain(ELSEWHERE.iter().copied()).collect();
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
