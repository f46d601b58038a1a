//! Data sets with a hidden effect: a simulator written apart from the library, with laws and an
//! integration of its own, so that naming the effect again is a test.
//!
//! - [`session`], [`motion`]: which traces are taken, when, how the machine moves, how warm it is.
//! - [`specimen`]: from the commanded motion to the signal, with the hidden laws at every fine step.
//! - [`laws`]: the reference law of every effect, other laws of the same physics, and what the
//!   library of effects does not hold.
//! - [`misfit`]: R, the misfit that the refitted base leaves.
//! - [`noise`]: correlated, white, 1/f.
//! - [`scenario`]: all of it together.
//! - [`folder`]: data sets as files, for the command.

pub mod folder;
pub mod laws;
pub mod misfit;
pub mod motion;
pub mod noise;
pub mod random;
pub mod scenario;
pub mod session;
pub mod specimen;

pub use laws::LawKind;
pub use noise::NoiseKind;
pub use scenario::{
    DataSet, Hidden, Scenario, Truth, generate, generate_with_fresh, one_short_trace,
};
pub use session::Day;
