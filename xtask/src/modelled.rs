//! The firmware on the modelled board: its emulator fetched and mended, then everything that the board is for.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use miette::{IntoDiagnostic, WrapErr, bail, miette};

use crate::check::{LINTED_BY, STRICT, rust, workspace};

/// The emulator underneath, as `emulator/Cargo.toml` wants it.
const EMULATOR: (&str, &str) = ("rsemu", "0.0.7");
/// Its one defect that must be mended, which `emulator/README.md` describes: the file, what it says, and what it must say.
const MEND: (&str, &str, &str) = (
    "src/cpu/arm/v7m/exec.rs",
    "(self.state.xpsr & !(xpsr::EXCEPTION | 0x0600_fc00)) |",
    "(self.state.xpsr & !(xpsr::EXCEPTION | 1 << 9)) |",
);
/// Killed hosts in the whole check; `cargo xtask emulate` kills a thousand.
pub const KILLS: u32 = 20;

/// Sets up, then runs the tests with so many killed hosts.
pub fn run(kills: u32) -> miette::Result<()> {
    fetch()?;
    tests(kills, &[])
}

/// The same after [`check`], which built them.
pub fn run_linted(kills: u32) -> miette::Result<()> {
    tests(kills, &LINTED_BY)
}

fn tests(kills: u32, built: &[&str]) -> miette::Result<()> {
    let kills = kills.to_string();
    let arguments = [built, &["test", "--", "--nocapture"]].concat();
    cargo("modelled board", &arguments, &[("PALPATE_KILLS", &kills), STRICT])
}

/// Format, lints and the build of the tests.
pub fn check() -> miette::Result<()> {
    fetch()?;
    cargo("format of the modelled board", &["fmt", "--check"], &[])?;
    let lints = [&LINTED_BY[..], &["test", "--all-targets", "--no-run"]].concat();
    cargo("lints and build of the modelled board", &lints, &[STRICT])
}

/// The workspace of the modelled board.
pub fn folder() -> PathBuf {
    workspace().join("emulator")
}

/// Fetches what is missing; the environment of the tests: where they are built, and how many hosts are killed.
pub fn set_up() -> miette::Result<Vec<(&'static str, String)>> {
    fetch()?;
    Ok(vec![("CARGO_TARGET_DIR", target()), ("PALPATE_KILLS", KILLS.to_string())])
}

fn target() -> String {
    folder().join("target").to_string_lossy().into_owned()
}

fn cargo(name: &str, arguments: &[&str], more: &[(&str, &str)]) -> miette::Result<()> {
    let target = target();
    let environment = [&[("CARGO_TARGET_DIR", &*target)], more].concat();
    rust(name, &folder(), arguments, &environment)
}

/// Fetches the emulator's source with cargo and leaves a mended copy where `emulator/Cargo.toml` looks for it.
fn fetch() -> miette::Result<()> {
    let (name, version) = EMULATOR;
    let target = folder().join("target");
    let copy = target.join(name);
    let mark = copy.join(format!("mended-{version}"));
    if mark.exists() {
        return Ok(());
    }
    println!("==> fetching {name} {version}, to run the firmware on a modelled board");
    let source = fetched(&target.join("fetch"))?;
    if copy.exists() {
        fs::remove_dir_all(&copy).into_diagnostic()?;
    }
    copy_folder(&source, &copy)?;
    let (file, before, after) = MEND;
    let file = copy.join(file);
    let text = fs::read_to_string(&file).into_diagnostic()?;
    if text.matches(before).count() != 1 {
        bail!("{} is not what it was when its defect was found", file.display());
    }
    fs::write(&file, text.replace(before, after)).into_diagnostic()?;
    fs::write(mark, "").into_diagnostic()
}

/// Where cargo keeps the emulator's source: a package that wants it makes cargo fetch it.
fn fetched(package: &Path) -> miette::Result<PathBuf> {
    let (name, version) = EMULATOR;
    fs::create_dir_all(package).into_diagnostic()?;
    let manifest = format!(
        "[workspace]\n[package]\nname = \"fetch\"\nedition = \"2024\"\n[lib]\npath = \"lib.rs\"\n[dependencies]\n{name} = \
         {{ version = \"={version}\", default-features = false }}\n"
    );
    fs::write(package.join("Cargo.toml"), manifest).into_diagnostic()?;
    fs::write(package.join("lib.rs"), "").into_diagnostic()?;
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1"])
        .current_dir(package)
        .output()
        .into_diagnostic()?;
    if !output.status.success() {
        bail!("{name} cannot be fetched: {}", String::from_utf8_lossy(&output.stderr));
    }
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).into_diagnostic()?;
    let packages = metadata["packages"].as_array().into_iter().flatten();
    let manifest = packages
        .filter(|package| package["name"] == name)
        .find_map(|package| package["manifest_path"].as_str());
    let manifest = manifest.ok_or_else(|| miette!("cargo does not say where {name} is"))?;
    Path::new(manifest).parent().map(Into::into).ok_or_else(|| miette!("{manifest} has no folder"))
}

fn copy_folder(from: &Path, to: &Path) -> miette::Result<()> {
    fs::create_dir_all(to).into_diagnostic()?;
    for entry in fs::read_dir(from).into_diagnostic()? {
        let entry = entry.into_diagnostic()?;
        let (source, target) = (entry.path(), to.join(entry.file_name()));
        if source.is_dir() {
            copy_folder(&source, &target)?;
        } else {
            let copied = fs::copy(&source, &target).into_diagnostic();
            copied.wrap_err_with(|| source.display().to_string())?;
        }
    }
    Ok(())
}
