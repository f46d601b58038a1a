//! The way to a fingertip: over the line, and on to the tools of robots.
//!
//! - [`device`]:
//! - [`robots`]: what a fingertip feels as topics for the tools of robots.
#![forbid(unsafe_code)]

pub mod device;
pub mod robots;
