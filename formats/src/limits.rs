//! How much is taken into memory.

use crate::Error;

/// Most numbers that one file gives: 128 MiB of them.
pub const NUMBERS: usize = 16 << 20;
/// Most bytes of text that one file gives.
pub const TEXT_LIMIT: u64 = 128 << 20;

/// Numbers that may still be taken.
pub(crate) struct Budget {
    format: &'static str,
    left: usize,
}

impl Budget {
    pub(crate) fn new(format: &'static str) -> Self {
        Self { format, left: NUMBERS }
    }

    /// Counts `count` more numbers at `place`.
    pub(crate) fn take(&mut self, count: usize, place: &str) -> Result<(), Error> {
        self.left = self.left.checked_sub(count).ok_or_else(|| Error::TooLarge {
            format: self.format,
            place: place.into(),
            limit: format!("{} million numbers", NUMBERS >> 20),
        })?;
        Ok(())
    }
}

/// The error of more text than [`TEXT_LIMIT`].
pub(crate) fn too_much_text(format: &'static str, place: &str) -> Error {
    let limit = format!("{} MiB of text", TEXT_LIMIT >> 20);
    Error::TooLarge { format, place: place.into(), limit }
}
