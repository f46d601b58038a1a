//! Base laws, the motion they run over, and the model file.
//!
//! A law predicts a recording by walking the chain *motion → elasticity → relaxation → contact*.
//! Everything on that way is written once, over a [`Number`] that is either `f64` or a dual number,
//! so that a prediction and its derivatives come from the same lines.

mod elastic;
mod file;
mod fung;
mod motion;
mod number;
mod parameter;
mod profile;
mod relaxation;

pub use elastic::elastic_response;
pub use file::{Base, FileError, FitRecord, Model, Rung, StoredParameter, VERSION};
pub use fung::{Fung, MAX_TERMS, Separation, TERMS};
pub use motion::{Motion, MotionError};
pub use number::{CHUNK, Dual, Number, constants, seeded};
pub use parameter::Parameter;
pub use profile::{Hold, Move, Profile, ProfileError, Step};
pub use relaxation::{Branch, Memory, Relaxation};
