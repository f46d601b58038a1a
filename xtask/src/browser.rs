//! The local page in a real browser.

use std::process::Command;

use crate::check::{linted_with, set_up_tests, workspace};
use crate::packages;

/// Installs the browser, then writes the pictures of the local page to docs/.
pub fn pictures() -> miette::Result<()> {
    let axe = set_up()?;
    let how = ["--", "--ignored", "--nocapture", "--test-threads=1", "pictures::"];
    let mut environment = vec![("PALPATE_PICTURES", "docs")];
    environment.extend(axe.iter().map(|(name, file)| (*name, file.as_str())));
    linted_with("pictures", &[&["--test", "browser"], &how[..]].concat(), &environment)
}

/// Installs the browser, then does everything that its user is promised; the Live room runs for so many seconds.
pub fn run(steady_s: u32) -> miette::Result<()> {
    check(set_up()?.as_ref(), steady_s)
}

/// The same with what was [set up](set_up).
pub fn check(axe: Option<&(&'static str, String)>, steady_s: u32) -> miette::Result<()> {
    let environment: Vec<_> = axe.iter().map(|(name, file)| (*name, file.as_str())).collect();
    set_up_tests("page in a browser", "browser", AT_ONCE, steady_s, &environment)?;
    set_up_tests("hostile page", "hostile_page", AT_ONCE, steady_s, &environment)
}

/// Tests at once: each waits most of its time, for a press, a replay or a fit.
pub const AT_ONCE: u32 = 2;

/// Where the tests are told that axe-core lies.
const AXE: &str = "PALPATE_AXE";
/// The package of PyPI that brings its file; nothing of it is in this repository.
const AXE_PACKAGE: &str = "axe-playwright-python==0.1.8";

/// The file of axe-core: what the environment names, or what pip puts into `target/`. Where neither is there, the tests go without it
/// and say so.
fn axe() -> Option<String> {
    if let Ok(file) = std::env::var(AXE) {
        return Some(file);
    }
    let folder = workspace().join("target/axe");
    let file = folder.join("axe_playwright_python/axe.min.js");
    if !file.is_file() {
        println!("==> axe-core into {}, to look for what hinders readers", folder.display());
        let pip = ["-m", "pip", "install", "--quiet", "--no-deps", "--target"];
        let python = if cfg!(windows) { "python" } else { "python3" };
        let installed = Command::new(python).args(pip).arg(&folder).arg(AXE_PACKAGE).status();
        if !installed.is_ok_and(|status| status.success()) {
            println!(
                "    pip could not fetch {AXE_PACKAGE}: the page is not checked with axe-core"
            );
        }
    }
    file.is_file().then(|| file.display().to_string())
}

/// Installs what is missing; the environment of the tests, which tells them where axe-core is if it is there.
pub fn set_up() -> miette::Result<Option<(&'static str, String)>> {
    let why = "to see the local page as its user does";
    packages::set_up("chromedriver", &["chromium", "chromium-driver"], why)?;
    Ok(axe().map(|file| (AXE, file)))
}
