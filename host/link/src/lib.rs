//! The way to a fingertip: over the line, and on to the tools of robots.
//!
//! - [`device`]: the line to a fingertip, the recorder that follows it, and one without hardware.
//! - [`robots`]: what a fingertip feels as topics for the tools of robots.
#![forbid(unsafe_code)]

pub mod device;
pub mod robots;
