//! The tests that wait for something, round after round beside other work: they must pass whatever the machine does meanwhile.
//! Those that draw run first and alone; the others side by side, each at its own pace.

use std::fs::{self, File};
use std::hint::spin_loop;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Instant;

use clap::ValueEnum;
use miette::{IntoDiagnostic, bail, miette};

use crate::check::{STEADY_S, rust, workspace};
use crate::{browser, emulate, modelled};

/// Loops that do nothing but take time, beside all rounds.
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
    /// Tests that run at the same time.
    const fn at_once(self) -> u32 {
        match self {
            Self::Browser => browser::AT_ONCE,
            Self::Emulator => emulate::AT_ONCE,
            Self::Device => 2,
        }
    }

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

/// Runs the tests of these suites, all where none is named, so many times in a row and prints a line for each round of each.
pub fn run(rounds: u32, suites: &[Suite]) -> miette::Result<()> {
    let all = Suite::value_variants();
    let suites = if suites.is_empty() { all } else { suites };
    // Set up and built while the machine is quiet.
    let mut lanes = Vec::new();
    for suite in suites {
        lanes.push((*suite, courses(*suite)?));
    }
    let folder = workspace().join("target/steady");
    fs::create_dir_all(&folder).into_diagnostic()?;
    let (drawn, others): (Vec<_>, Vec<_>) =
        lanes.iter().partition(|(suite, _)| *suite == Suite::Browser);
    let done = AtomicBool::new(false);
    let failures = thread::scope(|scope| {
        for _ in 0..BUSY_LOOPS {
            scope.spawn(|| {
                while !done.load(Ordering::Relaxed) {
                    spin_loop();
                }
            });
        }
        let failures = side_by_side(rounds, &drawn, &folder)
            .and_then(|failures| Ok(failures + side_by_side(rounds, &others, &folder)?));
        done.store(true, Ordering::Relaxed);
        failures
    })?;
    let runs = rounds as usize * lanes.iter().map(|(_, lane)| lane.len()).sum::<usize>();
    println!("{} of {runs} runs passed beside {BUSY_LOOPS} busy loops", runs - failures);
    if failures > 0 {
        bail!("{failures} of {runs} runs failed; what they said is in {}", folder.display());
    }
    Ok(())
}

/// Sets up and builds what a suite needs.
fn courses(suite: Suite) -> miette::Result<Vec<Course>> {
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
    let mut courses: Vec<Course> = files
        .iter()
        .map(|file| Course {
            name: file,
            folder: workspace().into(),
            arguments: arguments(file, ignored, suite.at_once()),
            environment: environment.clone(),
        })
        .collect();
    if suite == Suite::Emulator {
        courses.push(modelled_course()?);
    }
    Ok(courses)
}

fn arguments(file: &str, ignored: bool, at_once: u32) -> Vec<String> {
    let threads = format!("--test-threads={at_once}");
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

/// Runs suites beside each other; how many runs failed.
fn side_by_side(
    rounds: u32,
    lanes: &[&(Suite, Vec<Course>)],
    folder: &Path,
) -> miette::Result<usize> {
    thread::scope(|scope| {
        let lanes: Vec<_> = lanes
            .iter()
            .map(|(_, lane)| scope.spawn(|| all_rounds(rounds, lane, folder)))
            .collect();
        let failures = lanes.into_iter().map(|lane| {
            lane.join().unwrap_or_else(|_| Err(miette!("the rounds of a suite ended early")))
        });
        failures.sum()
    })
}

/// Runs one suite again and again; how many of its runs failed.
fn all_rounds(rounds: u32, courses: &[Course], folder: &Path) -> miette::Result<usize> {
    let mut failures = 0;
    for round in 1..=rounds {
        let mut row = format!("round {round:>2}");
        for course in courses {
            let log = folder.join(format!("{round}-{}.log", course.name));
            let outcome = course.run(&log)?;
            row += &format!("  {} {:.0} s", course.name, outcome.seconds);
            if let Some(failed) = &outcome.failed {
                row += &format!(" FAILED: {} ({})", failed.join(", "), log.display());
                failures += 1;
            }
        }
        println!("{row}");
    }
    Ok(failures)
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
