//! Generated recordings and pages; called by `cargo xtask traces`, `effects` and `sbom`.

mod effects;
mod sbom;
mod traces;

use std::path::Path;

use clap::Parser;

/// What to write anew.
#[derive(Parser)]
enum Task {
    /// The bundled recordings of tests/traces/; the same bytes on every run.
    Traces,
    /// The pages of docs/effects/, from the library's own declarations.
    Effects,
    /// The bill of materials of the program.
    Sbom,
}

/// The top of the workspace.
fn workspace() -> &'static Path {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    manifest.ancestors().nth(2).unwrap_or(manifest)
}

fn main() -> miette::Result<()> {
    match Task::parse() {
        Task::Traces => traces::write_all(),
        Task::Effects => effects::write_all(),
        Task::Sbom => sbom::write(),
    }
}
