//! The way to a fingertip: over the line, and on to the tools of robots.
//!
//! - [`device`]: the line to a fingertip, the recorder that follows it, and one without hardware.
//! - [`robots`]: what a fingertip feels as topics for the tools of robots.
//!
//! ```no_run
//! use std::ops::ControlFlow;
//! use std::path::Path;
//! use std::time::Duration;
//!
//! use palpate_link::device::session::Session;
//! use palpate_link::device::watch::watch;
//!
//! # fn main() -> Result<(), palpate_link::device::session::LinkError> {
//! let mut session = Session::open(Path::new("/dev/ttyACM0"), Duration::from_secs(3))?;
//! watch(&mut session, || false, |row| {
//!     println!("{} {:?}", row.time_us, row.fa);
//!     if row.number < 1000 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
//! })?;
//! # Ok(())
//! # }
//! ```
#![forbid(unsafe_code)]

pub mod device;
pub mod robots;
