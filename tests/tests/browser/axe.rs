//! axe-core, where `PALPATE_AXE` names its file: `cargo xtask browser` sets it up.

use std::sync::Once;

use palpate_tests::browser::Browser;

use crate::pictures::words;

static TOLD: Once = Once::new();

/// What axe-core says of the page as it is; nothing where it is not there.
pub fn axe(browser: &Browser) -> Vec<String> {
    let Ok(file) = std::env::var("PALPATE_AXE") else {
        TOLD.call_once(|| println!("without axe-core: PALPATE_AXE names no axe.min.js"));
        return Vec::new();
    };
    let source = std::fs::read_to_string(&file).expect("axe can be read");
    let _ = browser.script(&format!("{source}; return 0"));
    let found = browser.later(
        "const { violations } = await window.axe.run(document, { resultTypes: ['violations'] });
         return violations.flatMap((of) => of.nodes.map((node) => `${of.id}: ${node.target} ${node.failureSummary}`))",
    );
    words(&found)
}
