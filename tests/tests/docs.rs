//! Every command in the documentation runs.
#![cfg(unix)]

use std::fs;
use std::ops::Range;
use std::path::Path;
use std::process::Command;

use palpate::effects::{Setting, applied};
use palpate::model::{Expression, Model, VARIABLES};
use palpate_tests::{palpate, workspace};

/// Commands of a document: a block of kind `sh`, and the lines of the block of kind `text` that
/// follows it, if one does, with their range in the document.
struct Block {
    commands: Vec<String>,
    printed: Option<Range<usize>>,
}

/// The blocks of commands among the lines of a document.
fn blocks(lines: &[&str]) -> Vec<Block> {
    let mut found = Vec::new();
    let mut next = 0;
    while let Some(begin) = (next..lines.len()).find(|&k| lines[k] == "```sh") {
        let end = end_of_block(lines, begin);
        let told = |line: &&&str| !line.trim().is_empty() && !line.starts_with('#');
        let commands = lines[begin + 1..end].iter().filter(told).map(|line| (*line).into());
        let follows = (end + 1..lines.len()).find(|&k| !lines[k].is_empty());
        let printed = follows.filter(|&k| lines[k] == "```text");
        let printed = printed.map(|begin| begin + 1..end_of_block(lines, begin));
        found.push(Block { commands: commands.collect(), printed });
        next = end + 1;
    }
    found
}

/// The line that ends the block that begins in line `begin`.
fn end_of_block(lines: &[&str], begin: usize) -> usize {
    let rest = begin + 1..lines.len();
    rest.clone().find(|&k| lines[k] == "```").unwrap_or(rest.end)
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

/// Runs every command of a document; what the last one of a block prints is what the document says.
/// With `INSTA_UPDATE=always` the document is made to say it.
fn run_all(document: &str) {
    let path = workspace().join(document);
    let folder = place();
    let text = fs::read_to_string(&path).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let found = blocks(&lines);
    assert!(!found.is_empty(), "{document} has no commands");
    let mut updated: Vec<String> = Vec::new();
    let mut copied = 0;
    for block in found {
        let mut last = String::new();
        for command in &block.commands {
            // `cargo run` and the installed command are one; other cargo commands are tests of their own.
            let command = command.replace("cargo run --release -- ", "palpate ");
            if !command.starts_with("cargo ") {
                last = run(document, &command, folder.path());
            }
        }
        if let Some(printed) = block.printed {
            let now: Vec<&str> = last.trim_end().lines().map(str::trim_end).collect();
            if std::env::var("INSTA_UPDATE").is_ok_and(|update| update == "always") {
                updated.extend(lines[copied..printed.start].iter().map(|&line| line.into()));
                updated.extend(now.iter().map(|&line| line.into()));
                copied = printed.end;
            } else {
                assert_eq!(now, lines[printed], "{document}: {:?}", block.commands.last());
            }
        }
    }
    if copied > 0 {
        updated.extend(lines[copied..].iter().map(|&line| line.into()));
        fs::write(&path, updated.join("\n") + "\n").unwrap();
    }
}

/// What a command prints in a folder.
fn run(document: &str, command: &str, folder: &Path) -> String {
    let search = format!("{}:{}", folder.join("bin").display(), env!("PATH"));
    let output = Command::new("sh")
        .args(["-c", command])
        .current_dir(folder)
        .env("PATH", search)
        .env("NO_COLOR", "1")
        .env("COLUMNS", "100")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{document}: {command}\n{said}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn the_walk_from_a_fingertip_to_a_trace_says_what_the_commands_print() {
    run_all("docs/device.md");
}

#[test]
fn the_commands_of_the_readme_run() {
    run_all("README.md");
}

#[test]
fn the_page_of_the_base_laws_says_what_the_commands_print() {
    run_all("docs/base-laws.md");
}

#[test]
fn the_analyses_say_what_the_page_prints() {
    run_all("docs/analyses.md");
}

#[test]
fn the_commands_of_the_format_description_run() {
    run_all("docs/formats.md");
}

#[test]
fn the_walk_from_the_first_comparison_to_the_last_rung_runs_as_printed() {
    run_all("docs/missing-effect.md");
}

#[test]
fn the_walk_from_an_unknown_to_a_formula_runs_as_printed() {
    run_all("docs/discover.md");
}

#[test]
fn the_motion_that_decides_is_found_and_recorded_as_printed() {
    run_all("docs/next-experiment.md");
}

#[test]
fn the_survey_of_a_hundred_fingers_finds_the_three() {
    run_all("docs/fleet.md");
}

#[test]
fn the_walk_through_the_simulated_fingertip_says_what_the_commands_print() {
    run_all("docs/sensor.md");
}

#[test]
fn the_walk_through_force_curves_says_what_the_commands_print() {
    run_all("docs/afm.md");
}

#[test]
fn the_page_on_grasps_says_what_the_commands_print() {
    run_all("docs/grasp.md");
}

#[test]
fn the_commands_for_robots_run() {
    run_all("docs/robots.md");
}

#[test]
fn every_link_to_a_file_leads_somewhere() {
    for document in [
        "README.md",
        "docs/formats.md",
        "docs/dependencies.md",
        "docs/measured.md",
        "docs/effects/README.md",
        "docs/missing-effect.md",
        "docs/next-experiment.md",
        "docs/discover.md",
        "docs/base-laws.md",
        "docs/fleet.md",
        "docs/robots.md",
        "docs/grasp.md",
        "docs/sensor.md",
        "docs/afm.md",
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

/// The source files of a package of the workspace.
fn sources(package: &str) -> Vec<String> {
    let folder = match package {
        "palpate-tests" => "tests".to_owned(),
        _ => match package.strip_prefix("palpate-") {
            Some(part) if workspace().join("host").join(part).is_dir() => format!("host/{part}"),
            Some(part) => part.to_owned(),
            None => "host".to_owned(),
        },
    };
    let manifest = fs::read_to_string(workspace().join(&folder).join("Cargo.toml")).unwrap();
    assert!(manifest.contains(&format!("name = \"{package}\"")), "no package {package}");
    let mut folders = vec![workspace().join(folder)];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push(path.display().to_string().replace('\\', "/"));
            }
        }
    }
    found
}

/// The commands that print figures take too long to be run here; that they could be run is looked at.
#[test]
fn the_commands_behind_the_figures_name_what_there_is() {
    let text = fs::read_to_string(workspace().join("docs/measured.md")).unwrap();
    let commands = text.split('`').filter(|part| part.contains("cargo ") && part.contains(" -p "));
    let mut seen = 0;
    for command in commands {
        let after = |flag: &str| {
            let rest = command.split_once(flag)?.1;
            rest.split_whitespace().next()
        };
        let sources = sources(after(" -p ").unwrap());
        for flag in [" --test ", " --bench "] {
            let Some(target) = after(flag) else { continue };
            let is_target = |file: &String| {
                file.ends_with(&format!("/{target}.rs"))
                    || file.ends_with(&format!("/{target}/main.rs"))
            };
            assert!(sources.iter().any(is_target), "{command}: no target {target}");
        }
        if let Some(filter) = after(" --lib ") {
            let name = filter.rsplit("::").next().unwrap();
            let holds = |file: &String| {
                file.contains(&format!("/{name}"))
                    || fs::read_to_string(file).unwrap().contains(&format!("fn {name}"))
            };
            assert!(sources.iter().any(holds), "{command}: nothing called {name}");
        }
        seen += 1;
    }
    assert!(seen > 10, "{seen}");
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

#[test]
fn the_commands_of_the_local_page_run() {
    run_all("docs/page.md");
}
