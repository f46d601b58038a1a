//! Why a file gives no tables.

use std::io;
use std::panic::{UnwindSafe, catch_unwind};

/// Why a file gives no tables. The message names the format and the place, not the file.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file system said no.
    #[error("cannot be read: {0}")]
    Open(#[from] io::Error),
    /// The bytes are not what the format asks for.
    #[error("{format}, {place}: damaged or cut off ({message})")]
    Damaged {
        /// The format, in print.
        format: &'static str,
        /// Sheet, group, record or byte.
        place: String,
        /// What is wrong.
        message: String,
    },
    /// Something the format allows and this reader does not take.
    #[error("{format}, {place}: {what}")]
    Unread {
        /// The format, in print.
        format: &'static str,
        /// Sheet, group, record or byte.
        place: String,
        /// What it is, and what to do instead.
        what: String,
    },
    /// More than is taken into memory.
    #[error(
        "{format}, {place}: more than {limit}; take a part of it with the program that wrote it"
    )]
    TooLarge {
        /// The format, in print.
        format: &'static str,
        /// Where it is too much.
        place: String,
        /// What is taken at most, in words.
        limit: String,
    },
}

impl Error {
    pub(crate) fn damaged(
        format: &'static str,
        place: impl Into<String>,
        message: impl std::fmt::Display,
    ) -> Self {
        Self::Damaged { format, place: place.into(), message: format!("{message}") }
    }

    pub(crate) fn unread(
        format: &'static str,
        place: impl Into<String>,
        what: impl Into<String>,
    ) -> Self {
        Self::Unread { format, place: place.into(), what: what.into() }
    }
}

/// What `work` returns; libraries that take some damage for impossible give up by panicking.
pub(crate) fn guarded<T>(
    format: &'static str,
    work: impl FnOnce() -> Result<T, Error> + UnwindSafe,
) -> Result<T, Error> {
    catch_unwind(work).unwrap_or_else(|_| Err(Error::damaged(format, "file", "not readable")))
}
