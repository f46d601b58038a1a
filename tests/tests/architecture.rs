//! The crates of the project: what `docs/architecture.md` draws is what Cargo says, and the library alone stays small.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// Workspaces of their own beside the first.
const WORKSPACES: [&str; 4] = ["", "firmware", "emulator", "python"];
/// Most crates that a program gets with the library alone, palpate's own among them.
const MOST_CRATES: usize = 90;
const BEGIN: &str = "<!-- written by the test `architecture` -->\n";
const END: &str = "<!-- end -->\n";

fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

fn cargo(folder: &Path, arguments: &[&str]) -> String {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let output = Command::new(cargo).current_dir(folder).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// A crate of ours.
struct Crate {
    folder: String,
    description: String,
    /// Those of ours that it depends on, tests aside.
    needs: BTreeSet<String>,
}

/// Every crate that is part of the product, by name.
fn crates() -> BTreeMap<String, Crate> {
    let mut all = BTreeMap::new();
    for workspace in WORKSPACES {
        let metadata = ["metadata", "--no-deps", "--offline", "--format-version", "1"];
        let metadata: Value =
            serde_json::from_str(&cargo(&top().join(workspace), &metadata)).unwrap();
        for package in metadata["packages"].as_array().unwrap() {
            let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
            let manifest = PathBuf::from(text(&package["manifest_path"]));
            let folder = manifest.parent().unwrap().strip_prefix(top()).unwrap();
            let folder = folder.display().to_string().replace('\\', "/");
            let helper =
                ["tests", "xtask", "firmware/cost"].iter().any(|it| folder.starts_with(it));
            if helper {
                continue;
            }
            let needs = package["dependencies"].as_array().unwrap().iter();
            let needs = needs.filter(|it| !it["path"].is_null() && it["kind"].is_null());
            let needs = needs.map(|it| text(&it["name"])).collect();
            let description = text(&package["description"]);
            all.insert(text(&package["name"]), Crate { folder, description, needs });
        }
    }
    all
}

/// Whether `from` reaches `to` over at least one other crate.
fn by_a_detour(all: &BTreeMap<String, Crate>, from: &str, to: &str) -> bool {
    let others = all[from].needs.iter().filter(|needed| *needed != to);
    others.into_iter().any(|needed| all[needed].needs.contains(to) || by_a_detour(all, needed, to))
}

/// The drawing and the table.
fn drawn(all: &BTreeMap<String, Crate>) -> String {
    let short = |name: &str| name.strip_prefix("palpate-").unwrap_or(name).replace('-', "_");
    let mut text = String::from("```mermaid\ngraph TD\n");
    for (name, it) in all {
        for needed in it.needs.iter().filter(|needed| !by_a_detour(all, name, needed)) {
            text += &format!("    {} --> {}\n", short(name), short(needed));
        }
    }
    text += "```\n\n| crate | folder | what | needs directly |\n|-|-|-|-|\n";
    for (name, it) in all {
        let needs: Vec<String> = it.needs.iter().map(|needed| short(needed)).collect();
        text += &format!(
            "| `{name}` | `{}/` | {} | {} |\n",
            it.folder,
            it.description,
            needs.join(", ")
        );
    }
    text
}

#[test]
fn the_drawing_of_the_crates_is_what_cargo_says() {
    let path = top().join("docs/architecture.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let (before, rest) = page.split_once(BEGIN).expect("where it begins");
    let (told, after) = rest.split_once(END).expect("where it ends");
    let now = format!("\n{}\n", drawn(&crates()));
    if std::env::var("INSTA_UPDATE").is_ok_and(|update| update == "always") {
        std::fs::write(&path, [before, BEGIN, &now, END, after].concat()).unwrap();
        return;
    }
    assert!(
        told == now,
        "docs/architecture.md is older than the crates: INSTA_UPDATE=always makes it anew\n{now}"
    );
}

#[test]
fn nothing_below_the_summaries_knows_how_results_are_shown() {
    let all = crates();
    let shown = ["palpate-report", "palpate-present", "palpate-serve", "palpate-cli"];
    for room in ["trace", "model", "fit", "analysis", "diagnose", "contact", "survey", "link"] {
        let needs = &all[&format!("palpate-{room}")].needs;
        assert!(shown.iter().all(|it| !needs.contains(*it)), "{room} needs {needs:?}");
    }
    assert!(all["palpate-report"].needs.is_empty(), "report has no domain types");
}

#[test]
fn a_program_that_only_fits_and_diagnoses_gets_few_crates() {
    let tree = ["tree", "--offline", "--package", "palpate", "--no-default-features"];
    let form = ["--edges", "normal", "--prefix", "none", "--format", "{p}"];
    let tree = cargo(&top(), &[&tree[..], &form[..]].concat());
    let crates: BTreeSet<&str> = tree
        .lines()
        .map(|line| line.trim_end_matches(" (*)"))
        .filter(|it| !it.is_empty())
        .collect();
    assert!(crates.len() <= MOST_CRATES, "{} crates: {crates:?}", crates.len());
    let without = ["axum", "tokio", "serialport", "parquet", "clap", "maud"];
    for name in without {
        let brought = crates.iter().any(|it| it.split(' ').next() == Some(name));
        assert!(!brought, "{name} is brought along");
    }
}
