//! The local page.

pub mod lab;
