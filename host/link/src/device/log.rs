//! The device's log, which only the program that wrote it can put into words.

use std::path::{Path, PathBuf};

use defmt_decoder::{DecodeError, Table};

/// Why the log cannot be read with a file.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum LogError {
    #[error("{} cannot be read: {source}", path.display())]
    Read { path: PathBuf, source: std::io::Error },
    #[error("{} is no firmware with a log: {reason}", path.display())]
    NoLog { path: PathBuf, reason: String },
    #[error(
        "{} is not the firmware of this device, which was made from git state {git}; its log would be put into wrong \
         words. Build that state, or give --force",
        path.display()
    )]
    Another { path: PathBuf, git: String },
}

/// The words of a firmware's log.
pub struct Words {
    table: Table,
}

impl Words {
    /// Takes them from a firmware's ELF file. It must contain the git state of the device, where that is known.
    ///
    /// # Errors
    /// [`LogError`].
    pub fn read(elf: &Path, git: &str) -> Result<Self, LogError> {
        let path = || elf.to_owned();
        let bytes = std::fs::read(elf).map_err(|source| LogError::Read { path: path(), source })?;
        let none = |reason: String| LogError::NoLog { path: path(), reason };
        let table = Table::parse(&bytes)
            .map_err(|error| none(error.to_string()))?
            .ok_or_else(|| none("it has no section .defmt".into()))?;
        if !git.is_empty() && !bytes.windows(git.len()).any(|part| part == git.as_bytes()) {
            return Err(LogError::Another { path: path(), git: git.into() });
        }
        Ok(Self { table })
    }

    /// A stream that is put into words.
    #[must_use]
    pub fn stream(&self) -> Stream<'_> {
        Stream { decoder: self.table.new_stream_decoder() }
    }
}

/// A stream of log in pieces.
pub struct Stream<'w> {
    decoder: Box<dyn defmt_decoder::StreamDecoder + Send + Sync + 'w>,
}

/// What a piece of log completed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Line {
    /// A line of words.
    Words(String),
    /// Bytes without a meaning in these words.
    Malformed,
}

impl Stream<'_> {
    /// The lines that a piece completes.
    pub fn take(&mut self, piece: &[u8]) -> Vec<Line> {
        self.decoder.received(piece);
        let mut lines = Vec::new();
        loop {
            lines.push(match self.decoder.decode() {
                Ok(frame) => Line::Words(frame.display(false).to_string()),
                Err(DecodeError::Malformed) => Line::Malformed,
                Err(DecodeError::UnexpectedEof) => return lines,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_no_firmware_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("text.elf");
        std::fs::write(&path, "not an executable").unwrap();
        let refused = Words::read(&path, "").map(drop).unwrap_err().to_string();
        assert!(refused.contains("text.elf is no firmware with a log"), "{refused}");
        // This test is an executable, but of another kind.
        let test = std::env::current_exe().unwrap();
        let refused = Words::read(&test, "").map(drop).unwrap_err().to_string();
        assert!(refused.contains(".defmt"), "{refused}");
    }
}
