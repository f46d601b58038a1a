//! The truth of a practice set, sealed so that nobody reads it by accident.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use palpate_model::Model;

/// Name of the file in the folder of the set.
pub const SEALED: &str = "truth.sealed";
/// Major version of what is sealed.
pub const VERSION: i64 = 1;

/// First line of the file.
const HEAD: &str = "The truth of this practice set, in ROT47 so that nobody reads it by accident; `palpate hide --open .` shows it.";

/// What is in a practice set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Truth {
    /// Major version of the format.
    #[serde(rename = "palpate-practice")]
    pub version: i64,
    /// Seed it was made from.
    pub seed: u64,
    /// Misfit that each effect alone was to leave, over the noise.
    pub size: f64,
    /// Misfit that all of them leave after the base law is refitted, over the noise.
    pub misfit_over_noise: f64,
    /// Standard deviation of the noise, N.
    pub noise_rms: f64,
    /// Correlation of the noise from sample to sample.
    pub noise_correlation: f64,
    /// The specimen with everything that its base law lacks.
    pub model: Model,
}

/// Why a truth cannot be read.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum SealError {
    #[error("{path}: {source}; `palpate hide -o DIR` makes a practice set with it")]
    Io { path: PathBuf, source: std::io::Error },
    #[error("{path}: not the sealed truth of a practice set: {source}")]
    Toml { path: PathBuf, source: Box<toml::de::Error> },
    #[error(
        "{path}: a truth of version {found}; this palpate reads version {VERSION}: install a newer palpate"
    )]
    Newer { path: PathBuf, found: i64 },
    #[error("the truth cannot be written: {0}")]
    Write(#[from] toml::ser::Error),
}

/// The text of the sealed file.
///
/// # Errors
/// When the truth cannot be written as TOML.
pub fn seal(truth: &Truth) -> Result<String, SealError> {
    Ok(format!("{HEAD}\n{}", turned(&toml::to_string(truth)?)))
}

/// Reads the truth of the set in a folder.
///
/// # Errors
/// When the folder has none, or one of a newer version.
pub fn open(folder: &Path) -> Result<Truth, SealError> {
    let path = folder.join(SEALED);
    let text = std::fs::read_to_string(&path)
        .map_err(|source| SealError::Io { path: path.clone(), source })?;
    let text = turned(text.split_once('\n').map_or("", |(_, sealed)| sealed));
    let not_toml = |source| SealError::Toml { path: path.clone(), source: Box::new(source) };
    let table: toml::Table = toml::from_str(&text).map_err(not_toml)?;
    match table.get("palpate-practice").and_then(toml::Value::as_integer) {
        Some(found) if found > VERSION => Err(SealError::Newer { path: path.clone(), found }),
        _ => toml::from_str(&text).map_err(not_toml),
    }
}

/// ROT47: every printed ASCII character moved by half their number, so that twice is nothing.
fn turned(text: &str) -> String {
    let turn = |c: char| match c {
        '!'..='~' => char::from(b'!' + (c as u8 - b'!' + 47) % 94),
        other => other,
    };
    text.chars().map(turn).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twice_turned_is_as_it_was() {
        let text = "effect = \"mullins\" # 0.18 µε\n";
        assert_ne!(turned(text), text);
        assert!(!turned(text).contains("mullins"));
        assert_eq!(turned(&turned(text)), text);
    }
}
