//! An MCAP file beside a recording.

use std::path::{Path, PathBuf};
use std::time::Instant;

use palpate_robots::Door;
use shared::wire::{Felt, Row};

use super::topics::Finger;
use super::{Listener, RobotsError};
use palpate_contact::grasp::live::Reading;
use palpate_trace::files;

/// An MCAP file that begins with the first row: where none comes, none is made, and an older one stays. What goes wrong with it is
/// said at its end, and does not touch the recording.
pub struct McapFile {
    path: PathBuf,
    overwrite: bool,
    door: Door,
    finger: Finger,
    begun: Option<Result<(), RobotsError>>,
}

impl McapFile {
    /// A file at this path; one that is there is written over only if `overwrite` says so.
    ///
    /// # Errors
    /// [`RobotsError::Door`].
    pub fn at(path: &Path, overwrite: bool) -> Result<Self, RobotsError> {
        let door = Door::new();
        let finger = Finger::new(door.finger(1)?);
        Ok(Self { path: path.into(), overwrite, door, finger, begun: None })
    }

    /// What is published to it.
    pub fn listener(&mut self) -> &mut dyn Listener {
        self
    }

    /// Ends it.
    ///
    /// # Errors
    /// [`RobotsError`] if it could not be begun, or some of it could not be written.
    pub fn end(mut self) -> Result<(), RobotsError> {
        self.begun.take().unwrap_or(Ok(()))?;
        match self.door.end_file()? {
            Some(mut file) => files::keep(&mut file)
                .map_err(|source| RobotsError::File { path: self.path, source }),
            None => Ok(()),
        }
    }

    fn begin(&mut self) -> Result<(), RobotsError> {
        let failed = |source| RobotsError::File { path: self.path.clone(), source };
        let file = files::begin(&self.path, self.overwrite).map_err(failed)?;
        Ok(self.door.write(file)?)
    }
}

impl Listener for McapFile {
    fn rows(&mut self, rows: &[Row], at: Instant) {
        if self.begun.is_none() {
            self.begun = Some(self.begin());
        }
        self.finger.rows(rows, at);
    }

    fn event(&mut self, felt: &Felt) {
        self.finger.event(felt);
    }

    fn margin(&mut self, reading: &Reading) {
        self.finger.margin(reading);
    }
}
