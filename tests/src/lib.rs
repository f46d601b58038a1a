//! What the whole-product tests share: the binary under test and the folders they read.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use assert_cmd::Command;

/// The real `palpate`, built as the tests are.
///
/// # Panics
/// If it does not build.
#[must_use]
pub fn palpate() -> Command {
    static BINARY: OnceLock<PathBuf> = OnceLock::new();
    let binary = BINARY.get_or_init(|| {
        escargot::CargoBuild::new()
            .package("palpate")
            .bin("palpate")
            .manifest_path(workspace().join("Cargo.toml"))
            .current_target()
            .run()
            .expect("palpate builds")
            .path()
            .to_path_buf()
    });
    let mut command = Command::new(binary);
    command.env("NO_COLOR", "1").env_remove("PALPATE_LOG");
    command
}

/// The top of the workspace.
#[must_use]
pub fn workspace() -> &'static Path {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    manifest.parent().unwrap_or(manifest)
}

/// A bundled recording of `tests/traces/`.
#[must_use]
pub fn bundled(name: &str) -> PathBuf {
    workspace().join("tests/traces").join(name)
}

/// Every bundled recording, sorted by name.
///
/// # Panics
/// If the folder cannot be listed.
#[must_use]
pub fn all_bundled() -> Vec<PathBuf> {
    let folder = workspace().join("tests/traces");
    let mut found: Vec<PathBuf> = std::fs::read_dir(&folder)
        .expect("tests/traces is there")
        .map(|entry| entry.expect("tests/traces can be listed").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "csv"))
        .collect();
    found.sort();
    found
}
