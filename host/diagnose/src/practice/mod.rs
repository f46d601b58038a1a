//! Practice: data sets with a hidden effect, made with the library's own laws, and their sealed truth.
//!
//! - [`session`]: which traces are taken, in which order, and the air around them.
//! - [`hidden`]: a specimen, what its model lacks, and noise.
//! - `folder`: a set as files.
//! - [`sealed`]: the truth, readable only on purpose.

mod folder;
pub mod hidden;
mod left;
pub mod sealed;
pub mod session;

pub use folder::{FolderError, check_empty, seed_from_clock, write_set};
pub use hidden::{Choice, HideError, Practice, hide, record};
pub use left::Ground;
pub use sealed::{SEALED, SealError, Truth, open, seal};
