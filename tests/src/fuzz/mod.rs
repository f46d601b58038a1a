//! Hostile bytes for every parser and for the device: what is tried, and how it is made.
//!
//! Each [`Target`] has a folder of inputs in `tests/corpus/`. They are tried as they are, then changed at random by a
//! [`Mutator`]. An input that was found to break something is kept there, and so is tried from then on.
#![allow(clippy::missing_panics_doc)]

mod device;
mod line;
mod mutate;
mod targets;

use std::path::PathBuf;

pub use device::{Desk, desk};
pub use line::{frame, resealed};
pub use mutate::Mutator;
pub use targets::TARGETS;

use crate::workspace;

/// Something that takes bytes from outside.
pub struct Target {
    /// Its name, and that of its folder of inputs.
    pub name: &'static str,
    /// Takes an input; it may refuse it, and must not panic.
    pub run: fn(&[u8]),
    /// Pieces that such inputs are made of.
    pub words: &'static [&'static str],
}

impl Target {
    /// The folder of its inputs.
    #[must_use]
    pub fn folder(&self) -> PathBuf {
        workspace().join("tests/corpus").join(self.name)
    }

    /// Its inputs, by name.
    #[must_use]
    pub fn corpus(&self) -> Vec<Vec<u8>> {
        let folder = self.folder();
        let entries = std::fs::read_dir(&folder)
            .unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
        let mut files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
        files.sort();
        files.iter().map(|file| std::fs::read(file).unwrap()).collect()
    }
}
