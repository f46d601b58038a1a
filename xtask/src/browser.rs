//! The local page in a real browser.

use crate::check::set_up_tests;
use crate::packages;

/// Installs the browser, then does everything that its user is promised; the Live room runs for so many seconds.
pub fn run(steady_s: u32) -> miette::Result<()> {
    let why = "to see the local page as its user does";
    packages::set_up("chromedriver", &["chromium", "chromium-driver"], why)?;
    set_up_tests("page in a browser", "browser", steady_s)?;
    set_up_tests("page among what it should not trust", "hostile_page", steady_s)
}
