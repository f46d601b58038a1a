//! The local page in a real browser.

use crate::check::{rust, workspace};
use crate::packages;

/// Installs the browser, then does everything that its user is promised; the Live room runs for so many seconds.
pub fn run(steady_s: u32) -> miette::Result<()> {
    let why = "to see the local page as its user does";
    packages::set_up("chromedriver", &["chromium", "chromium-driver"], why)?;
    let tests = [
        "test",
        "--workspace",
        "--test",
        "browser",
        "--",
        "--ignored",
        "--nocapture",
        "--test-threads=1",
    ];
    rust("page in a browser", workspace(), &tests, &[("PALPATE_STEADY_S", &steady_s.to_string())])
}
