//! The bundled recordings as files.

use miette::{Context, IntoDiagnostic};
use palpate::bundled::{SEED, all};
use palpate::trace::write;

use crate::workspace;

/// Writes every bundled recording.
pub fn write_all() -> miette::Result<()> {
    let folder = workspace().join("tests/traces");
    println!("writing {} (noise seed {SEED})", folder.display());
    for trace in all() {
        let Some(name) = &trace.path else { continue };
        write(&folder.join(name), &trace).into_diagnostic().wrap_err("a bundled recording")?;
    }
    Ok(())
}
