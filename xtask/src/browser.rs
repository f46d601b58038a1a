//! The local page in a real browser.

use crate::check::{rust, set_up_tests, workspace};
use crate::packages;

/// Installs the browser, then writes the pictures of the local page to docs/.
pub fn pictures() -> miette::Result<()> {
    set_up()?;
    let tests = ["test", "--workspace", "--test", "browser"];
    let how = ["--", "--ignored", "--nocapture", "--test-threads=1", "pictures::"];
    rust("pictures", workspace(), &[&tests[..], &how].concat(), &[("PALPATE_PICTURES", "docs")])
}

/// Installs the browser, then does everything that its user is promised; the Live room runs for so many seconds.
pub fn run(steady_s: u32) -> miette::Result<()> {
    set_up()?;
    set_up_tests("page in a browser", "browser", steady_s)?;
    set_up_tests("page among what it should not trust", "hostile_page", steady_s)
}

fn set_up() -> miette::Result<()> {
    let why = "to see the local page as its user does";
    packages::set_up("chromedriver", &["chromium", "chromium-driver"], why)
}
