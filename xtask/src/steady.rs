//! The tests that wait for something, round after round beside other work: they must pass whatever the machine does meanwhile.

use std::fs::{self, File};
use std::hint::spin_loop;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Instant;

use clap::ValueEnum;
use miette::{IntoDiagnostic, bail};

use crate::check::{STEADY_S, rust, workspace};
use crate::{browser, emulate, modelled};

/// Loops that do nothing but take time, beside every round.
const BUSY_LOOPS: usize = 2;

/// What is run in a round.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Suite {
    /// The local page in a real browser.
    Browser,
    /// The firmware on two emulated boards.
    Emulator,
    /// Devices, lines and servers that are processes of this machine.
    Device,
}

impl Suite {
    /// The files of tests, and whether they are those that need something set up.
    fn files(self) -> (&'static [&'static str], bool) {
        match self {
            Self::Browser => (&["browser", "hostile_page"], true),
            Self::Emulator => (&["emulated"], true),
            Self::Device => {
                (&["device", "line", "serve", "serve_device", "serve_lab", "serve_limits"], false)
            }
        }
    }
}

/// A command of a round, ready to be run again and again.
struct Course {
    name: &'static str,
    folder: PathBuf,
    arguments: Vec<String>,
    environment: Vec<(&'static str, String)>,
}

/// What came of it: how long it took, and which tests failed.
struct Outcome {
    seconds: f64,
    failed: Option<Vec<String>>,
}

/// Runs the tests of these suites, all where none is named, so many times in a row and prints a table of the rounds.
pub fn run(rounds: u32, suites: &[Suite]) -> miette::Result<()> {
    let all = Suite::value_variants();
    let courses = courses(if suites.is_empty() { all } else { suites })?;
    let folder = workspace().join("target/steady");
    fs::create_dir_all(&folder).into_diagnostic()?;
    let done = AtomicBool::new(false);
    let outcomes = thread::scope(|scope| {
        for _ in 0..BUSY_LOOPS {
            scope.spawn(|| {
                while !done.load(Ordering::Relaxed) {
                    spin_loop();
                }
            });
        }
        let outcomes = all_rounds(rounds, &courses, &folder);
        done.store(true, Ordering::Relaxed);
        outcomes
    })?;
    let failures = outcomes.iter().flatten().filter(|outcome| outcome.failed.is_some()).count();
    let runs = outcomes.len() * courses.len();
    println!("{} of {runs} runs passed beside {BUSY_LOOPS} busy loops", runs - failures);
    if failures > 0 {
        bail!("{failures} of {runs} runs failed; what they said is in {}", folder.display());
    }
    Ok(())
}

/// Sets up and builds what the suites need, while the machine is quiet.
fn courses(suites: &[Suite]) -> miette::Result<Vec<Course>> {
    let mut courses = Vec::new();
    for suite in suites {
        let mut environment = vec![("PALPATE_STEADY_S", STEADY_S.to_string())];
        match suite {
            Suite::Browser => environment.extend(browser::set_up()?),
            Suite::Emulator => emulate::set_up()?,
            Suite::Device => environment.push(("PROPTEST_RNG_SEED", "1".into())),
        }
        let (files, ignored) = suite.files();
        let named: Vec<&str> = files.iter().flat_map(|file| ["--test", *file]).collect();
        let build = [&["test", "--workspace", "--no-run"][..], &named].concat();
        rust("tests", workspace(), &build, &[])?;
        courses.extend(files.iter().map(|file| Course {
            name: file,
            folder: workspace().into(),
            arguments: arguments(file, ignored, *suite == Suite::Browser),
            environment: environment.clone(),
        }));
        if *suite == Suite::Emulator {
            courses.push(modelled_course()?);
        }
    }
    Ok(courses)
}

fn arguments(file: &str, ignored: bool, in_browser: bool) -> Vec<String> {
    let threads = format!("--test-threads={}", if in_browser { browser::AT_ONCE } else { 1 });
    let tests = ["test", "--workspace", "--test", file, "--", &threads];
    let set_up: &[&str] = if ignored { &["--ignored", "--skip", "pictures::"] } else { &[] };
    tests.iter().chain(set_up).map(ToString::to_string).collect()
}

/// The modelled board is a workspace of its own.
fn modelled_course() -> miette::Result<Course> {
    let environment = modelled::set_up()?;
    let build = [("CARGO_TARGET_DIR", &*environment[0].1)];
    rust("tests of the modelled board", &modelled::folder(), &["test", "--no-run"], &build)?;
    Ok(Course {
        name: "modelled",
        folder: modelled::folder(),
        arguments: vec!["test".into()],
        environment,
    })
}

fn all_rounds(rounds: u32, courses: &[Course], folder: &Path) -> miette::Result<Vec<Vec<Outcome>>> {
    let heads: Vec<String> = courses.iter().map(|course| format!("{:>14}", course.name)).collect();
    println!("round{}", heads.concat());
    let mut outcomes = Vec::new();
    for round in 1..=rounds {
        let mut row = Vec::new();
        for course in courses {
            let log = folder.join(format!("{round}-{}.log", course.name));
            row.push(course.run(&log)?);
        }
        let cells: Vec<String> = row.iter().map(Outcome::cell).collect();
        println!("{round:>5}{}", cells.concat());
        for (outcome, course) in row.iter().zip(courses) {
            if let Some(failed) = &outcome.failed {
                let log = folder.join(format!("{round}-{}.log", course.name));
                println!("      {} failed: {} ({})", course.name, failed.join(", "), log.display());
            }
        }
        outcomes.push(row);
    }
    Ok(outcomes)
}

impl Course {
    /// What it says goes to a file.
    fn run(&self, log: &Path) -> miette::Result<Outcome> {
        let file = File::create(log).into_diagnostic()?;
        let began = Instant::now();
        let status = Command::new(env!("CARGO"))
            .args(&self.arguments)
            .envs(self.environment.iter().map(|(name, value)| (name, value)))
            .current_dir(&self.folder)
            .stdout(file.try_clone().into_diagnostic()?)
            .stderr(file)
            .status()
            .into_diagnostic()?;
        let seconds = began.elapsed().as_secs_f64();
        let said = fs::read(log).into_diagnostic()?;
        let failed = (!status.success()).then(|| failed(&String::from_utf8_lossy(&said)));
        Ok(Outcome { seconds, failed })
    }
}

impl Outcome {
    fn cell(&self) -> String {
        let seconds = format!("{:.0} s", self.seconds);
        format!("{:>14}", if self.failed.is_some() { "failed" } else { &seconds })
    }
}

/// The tests that failed: each has a line of its own.
fn failed(said: &str) -> Vec<String> {
    let lines = said.lines().filter_map(|line| line.strip_prefix("test "));
    let failed = lines.filter_map(|line| line.strip_suffix("... FAILED"));
    failed.map(|name| name.trim().to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failed_tests_are_told_by_name() {
        let said = "running 3 tests\ntest lab::a ... ok\ntest lab::b ... FAILED\ntest live::c ... ignored\n\
                    failures:\n    lab::b\n";
        assert_eq!(failed(said), ["lab::b"]);
    }
}
