//! What a device asks of its hardware.

use shared::wire::{ConverterFault, StoreFault};

use crate::front_end::Setting;
use crate::stream::Lost;

/// The hardware behind a device.
pub trait Board {
    /// Sets rate and gains of the converter; begins it if it was not begun. While samples are let through, the first one of
    /// the new setting says so ([`Lost::exchanged`]).
    ///
    /// # Errors
    /// What is wrong with the converter.
    fn configure(&mut self, setting: Setting) -> Result<(), ConverterFault>;

    /// Lets samples of the converter through, or not: what was lost that no sample told.
    fn listen(&mut self, to_converter: bool) -> Lost;

    /// Keeps a record over a loss of power. May stop everything else for seconds.
    ///
    /// # Errors
    /// What is wrong with the memory.
    fn store(&mut self, record: &[u8]) -> Result<(), StoreFault>;

    /// Whether [`Restart`] can be done.
    fn can_restart(&self, into: Restart) -> bool;
}

/// The line to a host: bytes in, frames out.
pub trait Link {
    /// The next byte of the host.
    fn receive(&mut self) -> Option<u8>;

    /// Whether a frame would find room.
    fn has_room(&self) -> bool;

    /// Takes a frame for the host; only with room for it.
    fn send(&mut self, frame: &[u8]);
}

/// How to begin again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Restart {
    /// As after power-on.
    Firmware,
    /// In the loader in ROM.
    Bootloader,
}

/// Where the log waits for the link.
pub trait Log {
    /// Whether anything does.
    fn is_waiting(&self) -> bool;

    /// Takes what was logged, as much as fits into `room`: how many bytes.
    fn take(&mut self, room: &mut [u8]) -> usize;
}

/// No log.
impl Log for () {
    fn is_waiting(&self) -> bool {
        false
    }

    fn take(&mut self, _: &mut [u8]) -> usize {
        0
    }
}
