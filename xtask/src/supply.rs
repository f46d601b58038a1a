//! What the product is made of: licences, sources, versions and known faults of every crate.

use std::path::PathBuf;
use std::process::Command;

use miette::{IntoDiagnostic, bail};

use crate::check::{rust, workspace};
use crate::{firmware, python};

/// The version of cargo-deny that is run.
const VERSION: &str = "0.20.2";

/// Installs cargo-deny where it is missing, then checks all workspaces by `deny.toml`. Known faults are looked up where their
/// list can be fetched.
pub fn run() -> miette::Result<()> {
    let tool = set_up()?;
    let config = workspace().join("deny.toml");
    let fetched = Command::new(&tool)
        .arg("--config")
        .arg(&config)
        .args(["fetch", "db"])
        .current_dir(workspace())
        .output()
        .is_ok_and(|out| out.status.success());
    let mut checks = vec!["bans", "licenses", "sources"];
    if fetched {
        checks.push("advisories");
    } else {
        println!("==> the list of known faults could not be fetched: advisories are not checked");
    }
    for folder in [workspace().to_path_buf(), firmware::folder(), python::folder()] {
        println!("==> supply chain of {}: cargo deny check {}", folder.display(), checks.join(" "));
        let status = Command::new(&tool)
            .args(["--locked", "--log-level", "error", "--config"])
            .arg(&config)
            .args(["check", "--hide-inclusion-graph"])
            .args(&checks)
            .current_dir(&folder)
            .status()
            .into_diagnostic()?;
        if !status.success() {
            bail!("supply chain of {} failed", folder.display());
        }
    }
    Ok(())
}

/// Where cargo-deny is; built without optimisation, which takes half the time and is fast enough.
fn set_up() -> miette::Result<PathBuf> {
    let root = workspace().join("target/tools");
    let tool = root.join("bin").join(format!("cargo-deny{}", std::env::consts::EXE_SUFFIX));
    let present = Command::new(&tool)
        .arg("--version")
        .output()
        .is_ok_and(|out| String::from_utf8_lossy(&out.stdout).contains(VERSION));
    if !present {
        let root = root.display().to_string();
        let install =
            ["install", "cargo-deny", "--version", VERSION, "--locked", "--debug", "--root", &root];
        rust("cargo-deny", workspace(), &install, &[])?;
    }
    Ok(tool)
}
