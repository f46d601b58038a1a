//! What a fingertip feels, as the tools of robots read it: topics of ROS 2, live for viewers and in MCAP files.
//!
//! The messages and their way out are those of the crate `palpate-robots`, behind the feature `robots`; a palpate built without it
//! refuses what needs it, and says how to get it.

use std::io;
use std::path::PathBuf;
use std::time::Instant;

use shared::wire::{Felt, Row};

use palpate_contact::grasp::live::Reading;

#[cfg(feature = "robots")]
mod file;
#[cfg(feature = "robots")]
mod stamps;
#[cfg(feature = "robots")]
mod topics;
#[cfg(not(feature = "robots"))]
mod unbuilt;

#[cfg(feature = "robots")]
pub use {file::McapFile, topics::Viewers};
#[cfg(not(feature = "robots"))]
pub use {unbuilt::McapFile, unbuilt::Viewers};

/// What else hears a fingertip while it is recorded or shown.
pub trait Listener: Send {
    /// Rows of one block, whose last byte was read `at`.
    fn rows(&mut self, rows: &[Row], at: Instant);

    /// A touch, a release or a slip, as the device reports it.
    fn event(&mut self, felt: &Felt);

    /// The margin of the grasp, where one is watched.
    fn margin(&mut self, reading: &Reading);
}

/// Why nothing reaches the tools of robots.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum RobotsError {
    #[error(
        "this palpate was built without the topics of robots. Build it with them: \
         `cargo install --path host --features robots`."
    )]
    Unbuilt,
    #[cfg(feature = "robots")]
    #[error(transparent)]
    Door(#[from] palpate_robots::Error),
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: io::Error },
}
