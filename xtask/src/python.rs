//! Python: the wheel, and its tests in an environment of their own.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use miette::{Context, IntoDiagnostic, bail};

use crate::check::{rust, workspace};

/// The folder of the package.
pub fn folder() -> PathBuf {
    workspace().join("python")
}

/// An environment of Python under `target/`, and the file in the package's folder that says what is in it.
struct Environment {
    name: &'static str,
    requirements: &'static str,
}

/// Builds the wheel, and has nothing else: whoever wants only the wheel waits for nothing else.
const BUILDER: Environment = Environment { name: "maturin-env", requirements: "requirements.txt" };
/// Tests it.
const OWN: Environment = Environment { name: "python-env", requirements: "tests/requirements.txt" };
/// Has LeRobot, which is too large for the other.
const LEROBOT: Environment =
    Environment { name: "lerobot-env", requirements: "tests-lerobot/requirements.txt" };

/// Where wheels are left.
fn wheels() -> PathBuf {
    workspace().join("target/wheels")
}

/// Builds the wheel of this platform, for every Python from 3.10 on, and leaves it in `target/wheels/`.
pub fn wheel() -> miette::Result<()> {
    let wheel = build("release")?;
    let bytes = fs::metadata(&wheel).into_diagnostic()?.len();
    println!("{}: {:.1} MB", wheel.display(), bytes as f64 / 1e6);
    println!("pip install {}", wheel.display());
    Ok(())
}

/// Checks the package: format and lints of its compiled half, the wheel, and all tests with what it installs.
pub fn check(profile: &str) -> miette::Result<()> {
    OWN.set_up()?;
    cargo("format of the Python package", &["fmt", "--check"])?;
    cargo("lints of the Python package", &["clippy", "--", "-D", "warnings"])?;
    OWN.install(&build(profile)?)?;
    OWN.run("pytest", &["-q", "--durations=5", "tests"])
}

/// Tests what the package does with data sets of LeRobot, on one that LeRobot itself writes.
pub fn lerobot(profile: &str) -> miette::Result<()> {
    let wheel = build(profile)?;
    LEROBOT.set_up()?;
    LEROBOT.install(&wheel)?;
    LEROBOT.run("pytest", &["-q", "tests-lerobot"])
}

/// Runs cargo in the folder of the package; it is built beside the workspace, which has the same crates.
fn cargo(name: &str, arguments: &[&str]) -> miette::Result<()> {
    let target = workspace().join("target");
    rust(name, &folder(), arguments, &[("CARGO_TARGET_DIR", &target.to_string_lossy())])
}

impl Environment {
    fn path(&self) -> PathBuf {
        workspace().join("target").join(self.name)
    }

    /// A program of the environment.
    fn program(&self, name: &str) -> PathBuf {
        let (folder, end) = if cfg!(windows) { ("Scripts", ".exe") } else { ("bin", "") };
        self.path().join(folder).join(format!("{name}{end}"))
    }

    /// Makes it where it is missing or needs other packages than those it has.
    fn set_up(&self) -> miette::Result<()> {
        let wanted = folder().join(self.requirements);
        let wanted_text = fs::read_to_string(&wanted).into_diagnostic()?;
        let has = self.path().join("requirements.txt");
        if fs::read_to_string(&has).is_ok_and(|has| has == wanted_text) {
            return Ok(());
        }
        let path = self.path().display().to_string();
        println!("==> an environment for Python in {path}");
        let python = if cfg!(windows) { "python" } else { "python3" };
        let made = Command::new(python).args(["-m", "venv", &path]).status();
        if !made.is_ok_and(|status| status.success()) {
            bail!("`{python} -m venv` failed: install Python 3.10 or later with its venv module");
        }
        let requirements = wanted.display().to_string();
        self.run("python", &["-m", "pip", "install", "--quiet", "-r", &requirements])?;
        fs::write(has, wanted_text).into_diagnostic()
    }

    /// Puts a wheel into it, in place of the one before.
    fn install(&self, wheel: &Path) -> miette::Result<()> {
        let wheel = wheel.display().to_string();
        let pip = ["-m", "pip", "install", "--quiet", "--force-reinstall", "--no-deps", &wheel];
        self.run("python", &pip)
    }

    /// Runs a program of it in the folder of the package.
    fn run(&self, name: &str, arguments: &[&str]) -> miette::Result<()> {
        println!("==> {name} {}", arguments.join(" "));
        let status = Command::new(self.program(name))
            .args(arguments)
            .current_dir(folder())
            .status()
            .into_diagnostic()
            .wrap_err_with(|| format!("{name} of the environment cannot be run"))?;
        if status.success() { Ok(()) } else { bail!("{name} {} failed", arguments.join(" ")) }
    }
}

/// Builds the wheel, alone in its folder, and says where it is.
fn build(profile: &str) -> miette::Result<PathBuf> {
    BUILDER.set_up()?;
    let (wheels, target) = (wheels(), workspace().join("target"));
    if wheels.exists() {
        fs::remove_dir_all(&wheels).into_diagnostic()?;
    }
    let out = wheels.display().to_string();
    println!("==> the wheel, in the profile {profile}");
    let status = Command::new(BUILDER.program("maturin"))
        .args(["build", "--locked", "--profile", profile, "--out", &out])
        .current_dir(folder())
        .env("CARGO_TARGET_DIR", target)
        .status()
        .into_diagnostic()?;
    if !status.success() {
        bail!("the wheel could not be built");
    }
    let mut found = fs::read_dir(&wheels).into_diagnostic()?.filter_map(Result::ok);
    let wheel = found.next().map(|entry| entry.path()).filter(|path| is_wheel(path));
    wheel.ok_or_else(|| miette::miette!("maturin left no wheel in {out}"))
}

fn is_wheel(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "whl")
}
