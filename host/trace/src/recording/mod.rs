//! A recording of a device: one file, written as it comes, readable whatever happened to it.
//!
//! # File
//! The line `palpate-recording 1` and its end, `\n` (2 where several devices share the file); a zero byte; then frames as on the line ([`shared::wire`]: COBS, CRC-32,
//! a zero byte behind each). They are of two kinds, told apart by the type in the frame's head:
//!
//! - What the device said, byte for byte: every frame that passed its CRC, types from 0.
//! - Notes of the host ([`Note`]), type [`NOTE`]: when a frame arrived, where something is missing, when the recording
//!   began and ended. The time in their head is the host's, µs since the recording was opened.
//!
//! Everything is only ever appended, in whole frames. After a kill or on a full disk the file ends in a torn frame or between
//! two; whatever is before that reads as if nothing had happened. The first entry is [`Note::Opened`]; a recording that was
//! ended in order has [`Note::Closed`] as its last. Of several devices in one file, [`Note::Device`] says whose frames follow; all
//! times of the host are of one clock.
//!
//! A [`Writer`] takes frames and notes, a [`Reader`] gives them back, a [`Clock`] relates the time of the device to that of
//! the host. Nothing here knows of traces; [`crate`] makes them.

mod clock;
mod error;
mod note;
mod parts;
mod reader;
mod writer;

pub use clock::{Clock, ClockFit};
pub use error::Error;
pub use note::{Gap, NOTE, Note, Opened};
pub use parts::parts;
pub use reader::{Entry, Reader};
pub use writer::{ANCHOR_US, Writer};

/// Extension of a recording's file name.
pub const EXTENSION: &str = "palpate";
/// Version of the file format: of several devices; of one alone it is 1.
pub const VERSION: u32 = 2;
/// How recordings begin, of one device and of several.
const BEGINNING: &[u8] = b"palpate-recording 1\n\0";
const BEGINNING_OF_SEVERAL: &[u8] = b"palpate-recording 2\n\0";
