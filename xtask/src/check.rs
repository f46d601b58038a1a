//! The whole check: what a change must pass, on any machine with rustup and git.

use std::path::Path;
use std::process::Command;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use miette::{IntoDiagnostic, bail, miette};

use crate::{browser, emulate, firmware, formats, modelled};

/// How long a device streams in the whole check, to the emulator's host and to a browser, s.
pub const STEADY_S: u32 = 20;

/// Courses of a line that are tried for each second that a target has, about as many as take that long.
const LINES_A_SECOND: u64 = 3_000;

/// The top of the workspace.
pub fn workspace() -> &'static Path {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    manifest.parent().unwrap_or(manifest)
}

/// Sets up what is missing, then runs every check; ends after the first that fails. Tests often wait, for a device or a page: others go
/// on beside them.
pub fn run() -> miette::Result<()> {
    component("rustfmt", "to check the format")?;
    component("clippy", "to check the lints")?;
    step("format", &["fmt", "--all", "--check"], &[])?;
    linted("lints and build of the tests", &["--all-targets", "--no-run"])?;
    // They compile what others wrote: beside them a simulated device would wait too long for its turn.
    installed_lints()?;
    documentation()?;
    beside(tests_of_the_product, tests_of_the_crates)?;
    linted("tests of the documentation", &["--doc"])?;
    // Before what goes on side by side: packages are installed one after the other.
    let axe = browser::set_up()?;
    emulate::install()?;
    let pages = || formats::run().and_then(|()| browser::check(axe.as_ref(), STEADY_S));
    beside(pages, boards)?;
    beside(|| emulate::check(STEADY_S), || modelled::run_linted(modelled::KILLS))
}

/// The same random cases on every machine; `cargo test` alone draws new ones each time.
const SEED: (&str, &str) = ("PROPTEST_RNG_SEED", "1");

/// Clippy compiles what is built, so that lints need no compiler run of their own.
pub const LINTED_BY: [&str; 2] = ["--config", "build.rustc-workspace-wrapper='clippy-driver'"];

/// Lints are errors: clippy's own separator of its arguments, as `cargo clippy -- -D warnings` passes them.
pub const STRICT: (&str, &str) = ("CLIPPY_ARGS", "-D__CLIPPY_HACKERY__warnings__CLIPPY_HACKERY__");

/// Runs tests of the workspace, with lints.
pub fn linted(name: &str, tests: &[&str]) -> miette::Result<()> {
    linted_with(name, tests, &[])
}

/// The same, with variables of the environment beside its own.
pub fn linted_with(name: &str, tests: &[&str], environment: &[(&str, &str)]) -> miette::Result<()> {
    let arguments = [&LINTED_BY[..], &["test", "--workspace"], tests].concat();
    step(name, &arguments, &[&[SEED, STRICT], environment].concat())
}

/// Runs two checks side by side.
fn beside(
    one: impl FnOnce() -> miette::Result<()>,
    other: impl FnOnce() -> miette::Result<()> + Send,
) -> miette::Result<()> {
    std::thread::scope(|scope| {
        let other = scope.spawn(other);
        let one = one();
        let other = other.join().unwrap_or_else(|_| Err(miette!("a check ended early")));
        one.and(other)
    })
}

/// In two halves of the alphabet: while a test of the one waits for a device, the other goes on.
fn tests_of_the_product() -> miette::Result<()> {
    let half = |name, files| linted(name, &["--test", files]);
    beside(
        || half("tests of the product, A to M", "[a-m]*"),
        || half("tests of the product, N to Z", "[!a-m]*"),
    )
}

fn tests_of_the_crates() -> miette::Result<()> {
    linted("tests of the crates", &["--lib", "--bins", "--examples"])
}

/// Lints of the program as it is installed and of one that depends on the library alone: without what the rest of the workspace
/// turns on.
fn installed_lints() -> miette::Result<()> {
    step("lints of the program", &["clippy", "--package", "palpate", "--", "-D", "warnings"], &[])?;
    let consumer =
        ["clippy", "--package", "palpate-consumer", "--all-targets", "--", "-D", "warnings"];
    step("lints of a program that links it", &consumer, &[])
}

/// Of every crate that is published.
fn documentation() -> miette::Result<()> {
    let strict = [("RUSTDOCFLAGS", "-D warnings")];
    let own = ["palpate-tests", "palpate-consumer", "palpate-generate", "xtask"];
    let but = own.iter().flat_map(|name| ["--exclude", name]);
    let documented: Vec<&str> =
        ["doc", "--workspace", "--no-deps"].into_iter().chain(but).collect();
    step("documentation", &documented, &strict)
}

/// Format, lints and builds of what runs on a board or models one.
fn boards() -> miette::Result<()> {
    firmware::set_up()?;
    firmware::cargo("format of the firmware", &["fmt", "--all", "--check"])?;
    for features in ["", "rtt"] {
        let lints = ["clippy", "--workspace", "--release", "--features", features];
        let strict = [&lints[..], &["--", "-D", "warnings"]].concat();
        firmware::cargo("lints of the firmware", &strict)?;
    }
    firmware::check_pico2()?;
    emulate::measure(false)?;
    modelled::check()
}

/// Installs a component of the toolchain where it is missing.
fn component(name: &str, why: &str) -> miette::Result<()> {
    let tool = if name == "clippy" { "clippy-driver" } else { name };
    let present =
        Command::new(tool).arg("--version").output().is_ok_and(|out| out.status.success());
    if present { Ok(()) } else { rustup("component", name, why) }
}

/// Adds a component or a target to the toolchain.
pub fn rustup(kind: &str, name: &str, why: &str) -> miette::Result<()> {
    println!("==> installing the {kind} {name} with rustup, {why}");
    let status = Command::new("rustup").args([kind, "add", name]).status();
    match status {
        Ok(status) if status.success() => Ok(()),
        _ => bail!("{name} is missing and `rustup {kind} add {name}` failed; install it {why}"),
    }
}

fn step(name: &str, arguments: &[&str], environment: &[(&str, &str)]) -> miette::Result<()> {
    rust(name, workspace(), arguments, environment)
}

/// Tries every target with hostile bytes for so many seconds, and the line with as many more losses; or one target alone.
pub fn fuzz(seconds: u32, seed: Option<u64>, target: Option<&str>) -> miette::Result<()> {
    let clock = SystemTime::now().duration_since(UNIX_EPOCH).into_diagnostic()?;
    let seed = seed.unwrap_or(clock.as_secs()).to_string();
    let line = ["--test", "line"];
    let more = if target.is_none() { &line[..] } else { &[] };
    let tests = [&["test", "--workspace", "--test", "fuzz"], more, &["--", "--nocapture"]].concat();
    let (time, lines) = (seconds.to_string(), (u64::from(seconds) * LINES_A_SECOND).to_string());
    let mut environment = vec![
        ("PALPATE_FUZZ_S", time.as_str()),
        ("PALPATE_FUZZ_SEED", &seed),
        ("PROPTEST_RNG_SEED", &seed),
        ("PROPTEST_CASES", &lines),
    ];
    environment.extend(target.map(|name| ("PALPATE_FUZZ_TARGET", name)));
    step("hostile bytes", &tests, &environment)
}

/// Runs the tests of a file that need what was set up for them, so many at once, with a stream of so many seconds.
pub fn set_up_tests(
    name: &str,
    file: &str,
    at_once: u32,
    steady_s: u32,
    environment: &[(&str, &str)],
) -> miette::Result<()> {
    // Pictures have a task of their own.
    let threads = format!("--test-threads={at_once}");
    let how = ["--", "--ignored", "--nocapture", &threads, "--skip", "pictures::"];
    let steady_s = steady_s.to_string();
    let environment = [&[("PALPATE_STEADY_S", &*steady_s)], environment].concat();
    linted_with(name, &[&["--test", file], &how[..]].concat(), &environment)
}

/// Runs cargo in a folder.
pub fn rust(
    name: &str,
    folder: &Path,
    arguments: &[&str],
    environment: &[(&str, &str)],
) -> miette::Result<()> {
    println!("==> {name}: cargo {}", arguments.join(" "));
    let began = Instant::now();
    let status = Command::new(env!("CARGO"))
        .args(arguments)
        .envs(environment.iter().copied())
        .current_dir(folder)
        .status()
        .into_diagnostic()?;
    if !status.success() {
        bail!("{name} failed: cargo {}", arguments.join(" "));
    }
    println!("==> {name} passed in {:.0} s", began.elapsed().as_secs_f64());
    Ok(())
}
