//! The dissertation recomputed, through the command.

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use palpate_tests::{follows_schema, palpate, workspace};
use serde_json::Value;
use tempfile::TempDir;

/// Recomputes it into a folder, on so many threads; the answer.
fn recompute(folder: &Path, threads: &str) -> Value {
    let mut command = palpate();
    command.args(["dissertation", "--json", "-o"]).arg(folder).env("RAYON_NUM_THREADS", threads);
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A folder whose `new/folder` holds it recomputed on two threads, and the answer.
fn recomputed() -> &'static (TempDir, Value) {
    static ONCE: OnceLock<(TempDir, Value)> = OnceLock::new();
    ONCE.get_or_init(|| {
        let place = tempfile::tempdir().unwrap();
        let answer = recompute(&place.path().join("new/folder"), "2");
        (place, answer)
    })
}

#[test]
fn kinds_of_evidence_are_told_apart_and_the_report_has_every_chapter() {
    let (place, answer) = recomputed();
    let folder = place.path().join("new/folder");
    assert_eq!(answer["palpate_dissertation"], 1);
    follows_schema("dissertation", answer);
    // Kinds of evidence are told apart, and only what should agree must.
    let kind = |name: &str| {
        let kinds = answer["kinds"].as_array().unwrap();
        kinds.iter().find(|kind| kind["evidence"] == name).unwrap()
    };
    for name in ["derived", "found_again", "said"] {
        assert_eq!(kind(name)["figures"], kind(name)["agree"], "{name}");
    }
    // 210 of Tables 3.1 to 3.3, 4 of Table 5.2, 20 of Tables 7.1 and 7.2, 2 of R²: fed in and found again.
    assert_eq!(kind("found_again")["figures"], 236);
    let derived = kind("derived");
    assert!(derived["within_half_of_the_last_digit"].as_u64() < derived["figures"].as_u64());
    assert_eq!(kind("not_reproduced")["agree"], 0);
    let sources: Vec<&str> = answer["comparisons"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|comparison| comparison["printed_in"].as_str())
        .collect();
    for table in ["3.1", "3.2", "3.3", "3.4", "5.2", "7.1", "7.2", "8.3", "A.1", "B.1"]
        .map(|n| format!("Table {n}"))
    {
        assert!(sources.contains(&table.as_str()), "{table} is not among {sources:?}");
    }
    assert!(sources.contains(&"Fig. 6.10"), "{sources:?}");
    let page = fs::read_to_string(folder.join("report.html")).unwrap();
    for chapter in 2..=8 {
        assert!(page.contains(&format!("Chapter {chapter}: ")), "chapter {chapter}");
    }
    assert!(page.contains("Appendices A and B") && page.contains("Slips in the text"));
    // The documentation states the same counts.
    let measured = fs::read_to_string(workspace().join("docs/measured.md")).unwrap();
    for (name, words) in [
        ("derived", "derived from other printed numbers"),
        ("found_again", "fed into a rebuilt recording"),
        ("fitted", "fitted to the printed numbers"),
        ("said", "said in words"),
        ("not_reproduced", "not reproduced, each"),
    ] {
        let row = measured.lines().find(|line| line.starts_with(&format!("| {words}")));
        let numbers: Vec<&str> = row.unwrap().split('|').skip(2).map(str::trim).collect();
        assert_eq!(numbers[0], kind(name)["figures"].to_string(), "{name}");
        if name != "said" {
            let exact = &kind(name)["within_half_of_the_last_digit"];
            assert_eq!(numbers[1], exact.to_string(), "{name}");
        }
    }
    // Every figure of the text is drawn, or has a reason; those that the text was asked for are drawn.
    let figures = answer["figures"].as_array().unwrap();
    assert_eq!(figures.len(), 65);
    let is_drawn = |figure: &Value| !figure["drawn"].as_array().unwrap().is_empty();
    for figure in figures {
        assert!(is_drawn(figure) != figure["reason"].is_string(), "{figure}");
    }
    for number in ["3.4", "3.6", "3.7", "4.9", "5.2", "5.15", "6.3", "6.4", "6.5", "7.8", "A.1"] {
        let figure = figures.iter().find(|figure| figure["figure"] == number).unwrap();
        assert!(is_drawn(figure), "{figure}");
    }
    let drawn = figures.iter().filter(|figure| is_drawn(figure)).count();
    assert!(page.contains(&format!("Figures of the text: {drawn} of 65")));
    // One line for each figure, and the head.
    let rows = fs::read_to_string(folder.join("comparisons.csv")).unwrap().lines().count();
    let figures: u64 =
        answer["kinds"].as_array().unwrap().iter().map(|k| k["figures"].as_u64().unwrap()).sum();
    assert_eq!(rows as u64, figures + 1);
}

#[test]
fn the_report_is_the_same_on_every_run() {
    let (place, answer) = recomputed();
    let alone = tempfile::tempdir().unwrap();
    assert_eq!(recompute(alone.path(), "1"), *answer);
    let written = |folder: &Path| fs::read_to_string(folder.join("comparisons.csv")).unwrap();
    assert_eq!(written(alone.path()), written(&place.path().join("new/folder")));
}
