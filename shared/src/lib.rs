//! What the palpate fingertip and its host must agree on.
//!
//! A sample of four embedded strain gauges passes through these modules in order, on the device and, with the very same
//! bits, on the host when it replays a recording:
//!
//! ```text
//! counts ── calibration ── strain ── adaptation ── FA, SA, elastic input, equilibrium ── phase ── region of the grasp
//!                                                                        └ latent part ──────── Type I / Type II
//! ```
//!
//! - [`fixed`]: every number format and unit, in one place, and the arithmetic on them.
//! - [`calibration`]: counts of the converter → strain; tare and temperature.
//! - [`flags`]: warnings that travel with a sample.
//! - [`adaptation`]: the dual-exponential filter that splits strain into a fast and a slow adapting part.
//! - [`phase`]: the six regions of a grasp, found while streaming, and the type of relaxation.
//! - [`events`]: touch, release and incipient slip, found in FA.
//! - [`pipeline`]: the order in which one sample passes through the three above.
//! - [`wire`]: every message between fingertip and host, and the frames they travel in.
//! - [`latency`]: the latency model of the dissertation, linear and power law, as exact steps in `f64` and in fixed point.
//!
//! Configuration and state are separate types: a configuration is computed once in `f64`, validated, and serves any number
//! of channels; a state is a few integers. Only the pipeline owns both. Nothing here allocates, needs `std`, or panics on
//! any input: arithmetic that can leave its range saturates, and saturation is reported. "eq. 3.4" and the like refer to
//! the dissertation on which the project rests.
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

pub mod adaptation;
pub mod calibration;
pub mod events;
pub mod fixed;
pub mod flags;
pub mod latency;
pub mod phase;
pub mod pipeline;
pub mod wire;
