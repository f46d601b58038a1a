//! What the fingertip does, without its hardware: it takes samples and commands and gives frames.
//!
//! The firmware wraps it in interrupts and a serial line, the host's simulated device in a pseudo-terminal; both behave
//! alike because this is all there is to behave.
//!
//! ```text
//! converter ── Sample ──┐                                  ┌── answers, status, settings, log
//!                       ├─ pipeline ── rows ── blocks ─────┴── frames ── line
//! line ── Inject ───────┘
//! ```
//!
//! Nothing waits for the host. Where something finds no room it is dropped and counted, and the numbers of rows and frames
//! go on, so that the host sees every loss: [`shared::wire::Counters`] says at which stage.
//!
//! - [`Device`]: the conversation, and what the parts below do in it.
//! - [`Board`], [`Link`], [`Log`]: what a device asks of its hardware, and [`Runner`], which turns all of it where nothing else does.
//! - [`FrontEnd`], [`Converter`]: how a converter is read, and what is done when it fails; [`converters`] has those there are.
//! - [`Lamp`]: how a device shows how it is.
//! - [`Sample`], [`Room`]: what comes in, and where it waits on its way out.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![cfg_attr(
    not(test),
    deny(
        clippy::arithmetic_side_effects,
        clippy::indexing_slicing,
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable
    )
)]

mod blocks;
mod board;
mod commands;
mod conversation;
pub mod converters;
mod felt;
mod front_end;
mod lamp;
mod outgoing;
mod room;
mod runner;
mod self_test;
mod stream;
mod temperature;

pub use board::{Board, Link, Log, Restart};
pub use conversation::{Beginning, Device, Identity, begin_with};
pub use front_end::{Converter, Found, FrontEnd, ReadError, Setting};
pub use lamp::Lamp;
pub use room::Room;
pub use runner::Runner;
pub use stream::{INJECTED_ROWS, Lost, Sample};
pub use temperature::Smoothed;
