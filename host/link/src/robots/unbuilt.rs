//! In place of the topics of robots, where palpate was built without them.

use std::net::IpAddr;
use std::path::Path;

use super::{Listener, RobotsError};

/// Viewers, of which there are none.
#[derive(Debug)]
pub enum Viewers {}

impl Viewers {
    /// Refuses.
    ///
    /// # Errors
    /// [`RobotsError::Unbuilt`].
    pub const fn serve(_: IpAddr, _: u16) -> Result<Self, RobotsError> {
        Err(RobotsError::Unbuilt)
    }

    /// Address of a viewer's connection.
    #[must_use]
    pub fn url(&self) -> &str {
        match *self {}
    }

    /// The topics of a finger, from 1.
    ///
    /// # Errors
    /// None: there is no such value.
    pub fn finger(&self, _: usize) -> Result<Box<dyn Listener>, RobotsError> {
        match *self {}
    }
}

/// A file, of which there is none.
#[derive(Debug)]
pub enum McapFile {}

impl McapFile {
    /// Refuses.
    ///
    /// # Errors
    /// [`RobotsError::Unbuilt`].
    pub const fn at(_: &Path, _: bool) -> Result<Self, RobotsError> {
        Err(RobotsError::Unbuilt)
    }

    /// What is published to it.
    pub fn listener(&mut self) -> &mut dyn Listener {
        match *self {}
    }

    /// Ends it.
    ///
    /// # Errors
    /// None: there is no such value.
    pub fn end(self) -> Result<(), RobotsError> {
        match self {}
    }
}
