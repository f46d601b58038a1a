//! What the whole-product tests share: the binary under test and the folders they read.

#[cfg(unix)]
pub mod browser;
pub mod device;
#[cfg(unix)]
pub mod emulator;
pub mod fuzz;
pub mod held_press;
pub mod hidden;
pub mod lab;
#[cfg(unix)]
pub mod server;
pub mod specimens;
pub mod tip;

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use boon::{Compiler, Schemas};
use palpate::model::{Hold, Motion, Move, Profile, Step};
use serde_json::Value;

/// The `palpate` command: `src/main.rs` here is the same line as that of the product, so that cargo
/// builds it, fresh and once, for whichever tests are run.
///
/// # Panics
/// If the running test cannot find itself.
#[must_use]
pub fn palpate() -> Command {
    let test = std::env::current_exe().expect("a test knows where it is");
    let folder = test.ancestors().nth(2).expect("tests are built in target/PROFILE/deps");
    let binary = folder.join(format!("palpate-tests{}", std::env::consts::EXE_SUFFIX));
    let mut command = Command::new(binary);
    command.env("NO_COLOR", "1").env_remove("PALPATE_LOG");
    command
}

/// The JSON that a call in a folder prints.
///
/// # Panics
/// If the call fails, or prints something else.
pub fn answer(folder: &Path, arguments: &[&str]) -> Value {
    let output = palpate().current_dir(folder).args(arguments).output().expect("palpate runs");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {error}");
    serde_json::from_slice(&output.stdout).expect("it prints JSON")
}

/// The schema of an answer in `docs/schema/`.
#[must_use]
pub fn schema_file(name: &str) -> PathBuf {
    workspace().join("docs/schema").join(name).with_extension("json")
}

/// Holds an answer to its schema in `docs/schema/`.
///
/// # Panics
/// If it does not follow the schema.
pub fn follows_schema(name: &str, answer: &Value) {
    let (mut known, mut compiler) = (Schemas::new(), Compiler::new());
    let file = schema_file(name).to_string_lossy().into_owned();
    let schema = compiler.compile(&file, &mut known).expect("the schema is one");
    if let Err(wrong) = known.validate(answer, schema) {
        panic!("{name}: {wrong:#}\n{answer:#}");
    }
}

/// The top of the workspace.
#[must_use]
pub fn workspace() -> &'static Path {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    manifest.parent().unwrap_or(manifest)
}

/// A bundled recording of `tests/traces/`.
#[must_use]
pub fn bundled(name: &str) -> PathBuf {
    workspace().join("tests/traces").join(name)
}

/// Every bundled recording, sorted by name.
///
/// # Panics
/// If the folder cannot be listed.
#[must_use]
pub fn all_bundled() -> Vec<PathBuf> {
    let folder = workspace().join("tests/traces");
    let mut found: Vec<PathBuf> = std::fs::read_dir(&folder)
        .expect("tests/traces is there")
        .map(|entry| entry.expect("tests/traces can be listed").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "csv"))
        .collect();
    found.sort();
    found
}

/// Load, hold for 4 s and unload, with rounded corners, 200 Hz: from 0.5 mm off the specimen to
/// `to_mm` at `speed` mm/s, and `after` seconds off the specimen at the end.
#[must_use]
pub fn press(to_mm: f64, speed: f64, after: f64) -> Motion<'static> {
    moved(speed, Some(800.0), vec![stay(0.5), go(to_mm), stay(4.0), go(-0.5), stay(after)])
}

/// Loads and unloads without a hold, one after the other, with sharp corners, from 1 s of rest 0.5 mm off the specimen on.
#[must_use]
pub fn cycles(to_mm: f64, speed: f64, count: usize) -> Motion<'static> {
    let cycle = [go(to_mm), go(-0.5)];
    let cycles = (0..count).flat_map(|_| cycle);
    moved(speed, None, [stay(1.0)].into_iter().chain(cycles).chain([stay(1.0)]).collect())
}

fn go(to_mm: f64) -> Step {
    Step::Move(Move { to_mm, speed_mm_per_s: None })
}

fn stay(hold_s: f64) -> Step {
    Step::Hold(Hold { hold_s })
}

fn moved(speed: f64, acceleration: Option<f64>, steps: Vec<Step>) -> Motion<'static> {
    Profile {
        version: 1,
        rate_hz: 200.0,
        start_mm: -0.5,
        speed_mm_per_s: speed,
        acceleration_mm_per_s2: acceleration,
        repeat: 1,
        steps,
    }
    .motion()
}
