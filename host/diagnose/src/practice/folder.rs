//! A practice set as files in a folder of its own.

use std::io;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use super::hidden::Practice;
use super::sealed::{SEALED, SealError, seal};
use palpate_trace::files::write_whole;
use palpate_trace::{Error, write};

/// Why a practice set was not written.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum FolderError {
    #[error("{0} is not empty; name a new folder")]
    NotEmpty(String),
    #[error("{0} is not a folder that can be read; name a new folder")]
    Unreadable(String),
    #[error("{path} was not written: {source}")]
    Io { path: PathBuf, source: io::Error },
    #[error(transparent)]
    Trace(#[from] Error),
    #[error(transparent)]
    Seal(#[from] SealError),
}

/// Refuses a folder with something in it.
///
/// # Errors
/// When it is not empty, or no folder.
pub fn check_empty(folder: &Path) -> Result<(), FolderError> {
    let shown = || folder.display().to_string();
    match std::fs::read_dir(folder).map(Iterator::count) {
        Ok(0) => Ok(()),
        Ok(_) => Err(FolderError::NotEmpty(shown())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(_) => Err(FolderError::Unreadable(shown())),
    }
}

/// Writes the traces, then the sealed truth: a folder without it was not finished.
///
/// # Errors
/// When a file cannot be written.
pub fn write_set(folder: &Path, practice: &Practice) -> Result<(), FolderError> {
    let failed = |path: &Path, source| FolderError::Io { path: path.into(), source };
    std::fs::create_dir_all(folder).map_err(|source| failed(folder, source))?;
    for trace in &practice.traces {
        write(&folder.join(trace.label()), trace)?;
    }
    let (sealed, path) = (seal(&practice.truth)?, folder.join(SEALED));
    write_whole(&path, |file| file.write_all(sealed.as_bytes()))
        .map_err(|source| failed(&path, source))
}

/// A seed that nobody has seen yet, short enough to type.
#[must_use]
pub fn seed_from_clock() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(1, |since| since.as_micros() as u64 % 1_000_000)
}
