//! What a fingertip feels, as topics of ROS 2 that robots' tools understand: live over a WebSocket (the Foxglove protocol, which
//! Foxglove, PlotJuggler and Lichtblick speak), and into MCAP files.
//!
//! ```text
//! /palpate/finger_1/fingertip    palpate_msgs/msg/Fingertip     every row
//! /palpate/finger_1/events       palpate_msgs/msg/TouchEvent    touch, release, slip
//! /palpate/finger_1/margin       palpate_msgs/msg/GraspMargin   five times a second, where a grasp is watched
//! ```
//!
//! Messages are CDR, as ROS 2 sends them, and each topic carries its definition; the same definitions as a package to build
//! are in `palpate_msgs/`.

mod door;
mod messages;
#[cfg(test)]
mod tests;
mod topics;

pub use door::{Door, Error};
pub use messages::{Fingertip, GAUGES, GraspMargin, Header, Message, Stamp, TouchEvent};
pub use topics::Topics;
