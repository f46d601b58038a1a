//! Why a recording cannot be read.

use std::io;

use shared::wire::{FrameError, SCHEMA};

use super::VERSION;

/// Why a recording cannot be read. After [`Error::Damaged`] reading can go on; all others are the end.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file system said no.
    #[error("cannot be read: {0}")]
    Read(#[from] io::Error),
    /// The file does not begin as a recording does.
    #[error("is not a recording of a device: it does not begin with `palpate-recording`")]
    NotARecording,
    /// Written by a later version of this program.
    #[error(
        "palpate-recording version {found}, this program reads up to version {VERSION}. Use a newer palpate."
    )]
    NewerVersion {
        /// Version in the file.
        found: u32,
    },
    /// Device or host had other messages.
    #[error(
        "made by {by} with messages of schema {schema:016x}; this is palpate {ours} with schema {SCHEMA:016x}. \
         Use that version of palpate to convert it.",
        ours = env!("CARGO_PKG_VERSION")
    )]
    Schema {
        /// Who made it, with its version.
        by: String,
        /// Hash of its messages.
        schema: u64,
    },
    /// A frame in the middle is damaged.
    #[error(
        "byte {offset}: {source}. Everything before it is whole; `palpate convert --skip-damaged` leaves such frames out."
    )]
    Damaged {
        /// Where in the file the frame begins.
        offset: u64,
        /// What is wrong with it.
        source: FrameError,
    },
}
