//! Every command in the documentation runs.
#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::Command;

use palpate::effects::{Setting, applied};
use palpate::model::{Expression, Model, VARIABLES};
use palpate_tests::{palpate, workspace};

/// The commands of a document: the lines of its blocks of kind `sh`.
fn commands(document: &Path) -> Vec<String> {
    let text = fs::read_to_string(document).unwrap();
    let mut inside = false;
    let mut found = Vec::new();
    for line in text.lines() {
        if line.starts_with("```") {
            inside = line == "```sh";
        } else if inside && !line.trim().is_empty() && !line.starts_with('#') {
            found.push(line.to_owned());
        }
    }
    found
}

/// A folder with what the documents assume: the bundled recordings, and `palpate` on the path.
fn place() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let link = |from: &Path, to: &str| std::os::unix::fs::symlink(from, folder.path().join(to));
    fs::create_dir_all(folder.path().join("bin")).unwrap();
    link(Path::new(palpate().get_program()), "bin/palpate").unwrap();
    link(&workspace().join("tests"), "tests").unwrap();
    folder
}

fn run_all(document: &str) {
    let path = workspace().join(document);
    let folder = place();
    let found = commands(&path);
    assert!(!found.is_empty(), "{document} has no commands");
    for command in found {
        // `cargo run` and the installed command are one; other cargo commands are tests of their own.
        let command = command.replace("cargo run --release -- ", "palpate ");
        if command.starts_with("cargo ") {
            continue;
        }
        let search = format!("{}:{}", folder.path().join("bin").display(), env!("PATH"));
        let output = Command::new("sh")
            .args(["-c", &command])
            .current_dir(folder.path())
            .env("PATH", search)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{document}: {command}\n{said}");
    }
}

#[test]
fn the_commands_of_the_readme_run() {
    run_all("README.md");
}

#[test]
fn the_commands_of_the_format_description_run() {
    run_all("docs/formats.md");
}

#[test]
fn every_link_to_a_file_leads_somewhere() {
    for document in [
        "README.md",
        "docs/formats.md",
        "docs/dependencies.md",
        "docs/measured.md",
        "docs/effects/README.md",
    ] {
        let path = workspace().join(document);
        let text = fs::read_to_string(&path).unwrap();
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            if target.starts_with("http") || target.starts_with('#') {
                continue;
            }
            let file = target.split('#').next().unwrap_or(target);
            assert!(path.parent().unwrap().join(file).exists(), "{document} links to {target}");
        }
    }
}

#[test]
fn every_task_of_the_readme_is_a_task() {
    let text = fs::read_to_string(workspace().join("README.md")).unwrap();
    let source = fs::read_to_string(workspace().join("xtask/src/main.rs")).unwrap();
    for line in text.lines().filter_map(|line| line.strip_prefix("cargo xtask ")) {
        let task = line.split_whitespace().next().unwrap();
        let variant = format!("    {}{},", task[..1].to_uppercase(), &task[1..]);
        assert!(source.contains(&variant), "no task {task}");
    }
}

/// The blocks of kind `toml` in the description of the formats that begin with a key.
fn toml_blocks(key: &str) -> Vec<String> {
    let text = fs::read_to_string(workspace().join("docs/formats.md")).unwrap();
    let blocks = text.split("```toml\n").skip(1);
    let blocks = blocks.filter_map(|rest| rest.split("```").next().map(String::from));
    blocks.filter(|block| block.starts_with(key)).collect()
}

#[test]
fn the_model_and_the_profile_of_the_description_are_understood() {
    let folder = tempfile::tempdir().unwrap();
    let [model] = &toml_blocks("palpate-model")[..] else { panic!("one model") };
    let [profile] = &toml_blocks("palpate-profile")[..] else { panic!("one profile") };
    // The description shows one parameter of six.
    let others = ["q", "c1", "c2", "v1", "v2"]
        .map(|name| format!("[base.parameters.{name}]\nvalue = 0.4\n"))
        .concat();
    let model = model.replace("[fit] ", &format!("{others}[fit] "));
    fs::write(folder.path().join("model.toml"), model).unwrap();
    fs::write(folder.path().join("profile.toml"), profile).unwrap();
    let call = ["simulate", "model.toml", "--motion", "profile.toml", "-o", "predicted.csv"];
    palpate().current_dir(folder.path()).args(call).assert().success();
}

#[test]
fn the_effects_of_the_description_can_stand_in_a_model() {
    let folder = tempfile::tempdir().unwrap();
    let [effect] = &toml_blocks("[[effect]]")[..] else { panic!("one effect") };
    let [own] = &toml_blocks("[[candidate]]")[..] else { panic!("one law of one's own") };
    let values = ["p", "q", "c1", "c2", "v1", "v2"]
        .map(|name| format!("[base.parameters.{name}]\nvalue = 0.4\n"))
        .concat();
    let base = "palpate-model = 1\n[base]\nlaw = \"fung\"\nsignal = \"force_N\"\n";
    let path = folder.path().join("model.toml");
    fs::write(&path, [base, &values, effect, own].concat()).unwrap();
    let model = Model::read(&path).unwrap();
    for stored in model.effects.iter().chain(&model.candidates) {
        applied(stored, &Setting::default()).unwrap();
    }
}

#[test]
fn the_variables_and_functions_of_the_description_are_those_of_expressions() {
    let text = fs::read_to_string(workspace().join("docs/formats.md")).unwrap();
    for (name, meaning) in VARIABLES {
        let meaning = meaning.split(';').next().unwrap();
        assert!(text.contains(&format!("| `{name}` | {meaning}")), "{name}");
    }
    let functions = text.split("the functions `").nth(1).unwrap().split('`').next().unwrap();
    for function in functions.split_whitespace() {
        Expression::parse(&format!("{function}(x) + PI * E"), &[]).unwrap();
    }
}
