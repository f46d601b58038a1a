//! Tells the linker where the memory is, and the program which commit it was made from.

use std::env;
use std::path::Path;
use std::process::Command;

/// Where the flash begins, as `memory/memory.x` has it; `PALPATE_ORIGIN` says otherwise where a loader has the first part.
const ORIGIN: &str = "0x08000000";

fn main() {
    let memory = std::fs::read_to_string("memory/memory.x").expect("memory/memory.x");
    let origin = env::var("PALPATE_ORIGIN").unwrap_or(ORIGIN.into());
    let out = env::var("OUT_DIR").expect("cargo says where");
    let moved = memory.replace(ORIGIN, &origin);
    std::fs::write(Path::new(&out).join("memory.x"), moved).expect("memory.x is written");
    println!("cargo:rustc-link-search={out}");
    println!("cargo:rerun-if-env-changed=PALPATE_ORIGIN");
    println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    println!("cargo:rerun-if-changed=memory/memory.x");
    println!("cargo:rerun-if-changed=../.git/HEAD");
    println!("cargo:rerun-if-changed=../.git/index");
    println!("cargo:rustc-env=PALPATE_GIT={}", git_state().unwrap_or("unknown".into()));
}

/// A short hash, and `+` if something is not committed.
fn git_state() -> Option<String> {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let hash = git(&["rev-parse", "--short=10", "HEAD"])?;
    let changed = !git(&["status", "--porcelain", "--untracked-files=no"])?.is_empty();
    Some(hash + if changed { "+" } else { "" })
}
