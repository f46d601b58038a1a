//! What the driver promises, on a scripted bus.

mod rate;
mod reading;
mod script;
mod start;
