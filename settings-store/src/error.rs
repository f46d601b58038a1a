//! What can go wrong, and what it means for the record.

use core::fmt;

/// Why a record could not be loaded or saved. `E` is the error of the flash driver.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StoreError<E> {
    /// The range is not two sectors of this flash with room for two slots each.
    BadRange,
    /// The flash driver reported an error.
    Flash(E),
    /// The record is longer than [`MAX_RECORD_BYTES`](crate::MAX_RECORD_BYTES); nothing was written.
    RecordTooLong {
        /// Length of the record, bytes.
        length: usize,
    },
    /// The newest record does not fit the buffer.
    BufferTooSmall {
        /// Length of the record, bytes.
        needed: usize,
    },
    /// The flash accepted the record without an error, yet it does not read back. What was stored before is still
    /// there, as far as it could be read.
    NotWritten,
}

impl<E: fmt::Debug> fmt::Display for StoreError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BadRange => {
                write!(f, "the range is not two flash sectors with room for two records each")
            }
            Self::Flash(error) => write!(f, "the flash reports {error:?}"),
            Self::RecordTooLong { length } => write!(
                f,
                "a record of {length} bytes is longer than the {} that fit",
                crate::MAX_RECORD_BYTES
            ),
            Self::BufferTooSmall { needed } => {
                write!(f, "the stored record needs a buffer of {needed} bytes")
            }
            Self::NotWritten => write!(f, "the record does not read back from the flash"),
        }
    }
}

impl<E: fmt::Debug> core::error::Error for StoreError<E> {}
