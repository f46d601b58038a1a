//! Laws of one's own in files of their own, for others to try: a file, or a folder of such files.

use std::io;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::StoredEffect;

/// Major version of the file that this program reads.
const VERSION: i64 = 1;

/// Laws that can be tried.
///
/// ```toml
/// palpate-effects = 1
/// [[candidate]]
/// name = "teeth"
/// stage = "contact"
/// expression = "height * sin(TAU * x / period)"
/// [candidate.parameters]
/// height = { value = 0.02, unit = "N" }
/// period = { value = 0.8, unit = "mm" }
/// ```
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Laws {
    #[serde(rename = "palpate-effects")]
    _version: i64,
    #[serde(rename = "candidate")]
    candidates: Vec<StoredEffect>,
}

/// Why laws cannot be read.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum PublishedError {
    #[error("{path}: {source}")]
    Io { path: PathBuf, source: io::Error },
    #[error("{path}: no laws of one's own: {source}")]
    Toml { path: PathBuf, source: Box<toml::de::Error> },
    #[error(
        "{path}: laws of version {found}; this palpate reads version {VERSION}: install a newer palpate"
    )]
    Newer { path: PathBuf, found: i64 },
    #[error("{path}: a folder without a `.toml` file")]
    Empty { path: PathBuf },
    #[error("`{name}` stands in {path} and once more before: give one of them another name")]
    Twice { name: String, path: PathBuf },
}

/// The laws in a file, or in all `.toml` files of a folder in the order of their names.
///
/// # Errors
/// When a file cannot be read or holds something else, or two laws have one name.
pub fn read_laws(path: &Path) -> Result<Vec<StoredEffect>, PublishedError> {
    let files = if path.is_dir() { files_of(path)? } else { vec![path.into()] };
    let mut found: Vec<StoredEffect> = Vec::new();
    for file in files {
        for law in read_file(&file)? {
            if found.iter().any(|known| known.name == law.name) {
                return Err(PublishedError::Twice { name: law.name, path: file });
            }
            found.push(law);
        }
    }
    Ok(found)
}

fn files_of(folder: &Path) -> Result<Vec<PathBuf>, PublishedError> {
    let failed = |source| PublishedError::Io { path: folder.into(), source };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            files.push(path);
        }
    }
    files.sort();
    if files.is_empty() {
        return Err(PublishedError::Empty { path: folder.into() });
    }
    Ok(files)
}

fn read_file(path: &Path) -> Result<Vec<StoredEffect>, PublishedError> {
    let text = std::fs::read_to_string(path)
        .map_err(|source| PublishedError::Io { path: path.into(), source })?;
    let not_toml = |source| PublishedError::Toml { path: path.into(), source: Box::new(source) };
    let table: toml::Table = toml::from_str(&text).map_err(not_toml)?;
    match table.get("palpate-effects").and_then(toml::Value::as_integer) {
        Some(found) if found > VERSION => Err(PublishedError::Newer { path: path.into(), found }),
        _ => toml::from_str::<Laws>(&text).map(|laws| laws.candidates).map_err(not_toml),
    }
}
