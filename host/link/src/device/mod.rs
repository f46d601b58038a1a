//! A fingertip at the other end of a line.
//!
//! ```text
//! port ── reader thread ── frames ── Session ── what was heard ──┬── Stream: what is missing
//!      └─ writer ───────── commands, answered ─┘                 └── recording, log, live line
//! ```
//!
//! - [`discover`]: which ports have a device.
//! - [`mod@line`]: a thread that does nothing but read, so that nothing else can make it lose bytes.
//! - [`session`]: handshake, commands and their answers, what comes meanwhile.
//! - [`stream`]: frames and rows that are missing.
//! - [`record`]: into a file, through whatever happens to the line; [`hand`]: from several devices into one.
//! - [`replay`]: rows put into a device as if its converter had given them.
//! - [`change`]: settings, checked before they are sent.
//! - [`measure`]: short streams, to read zero and to average.
//! - [`mod@watch`]: rows as they come.
//! - [`calibrate`]: gain and offset of a gauge.
//! - [`self_test`]: what the device's test of itself found.
//! - [`release`]: whether firmware and program go together.
//! - [`share`]: a file that several devices write.
//! - [`log`]: the device's log in words.
//! - [`describe`]: everything else in words.
//! - [`answers`]: what commands answer, as types.
//! - [`simulate`]: a device without hardware, behind a pseudo-terminal.

pub mod answers;
pub mod calibrate;
pub mod change;
pub mod describe;
pub mod discover;
pub mod hand;
pub mod heard;
pub mod line;
pub mod log;
pub mod measure;
#[cfg(unix)]
pub mod pty;
pub mod record;
pub mod refusal;
pub mod release;
pub mod replay;
pub mod self_test;
pub mod session;
pub mod share;
#[cfg(unix)]
pub mod simulate;
pub mod stream;
pub mod watch;

mod handshake;

#[cfg(test)]
mod tests;
