//! Base laws, the motion they run over, and the model file.
//!
//! A model predicts a recording by walking the chain *motion → elasticity → relaxation → contact →
//! sensor*: a base law, and the effects that act on it at their stage.
//!
//! ```
//! use palpate_model::{BaseLaw, Motion, Separation};
//!
//! // 4 mm at 4 mm/s, then held for 2 s.
//! let time: Vec<f64> = (0..300).map(|k| 0.01 * f64::from(k)).collect();
//! let x: Vec<f64> = time.iter().map(|t| (4.0 * t).min(4.0)).collect();
//! let motion = Motion { time: time.into(), displacement: x.into(), rest_before: None };
//! let law = BaseLaw::fung(1, Separation::Clamp);
//! // p, q, c1, v1
//! let force = law.predict(&[0.3, 0.5, 0.4, 1.0], &[motion]).remove(0);
//! assert!(force[299] < force[100]);
//! ```
#![forbid(unsafe_code)]

mod act;
mod base_law;
mod chain;
mod coordinate;
pub mod covariate;
pub mod effects;
pub mod elastic;
mod expression;
mod file;
mod force_control;
mod gauge;
mod growth;
mod hereditary;
pub mod kernel;
pub mod latency;
pub mod laws;
mod motion;
mod options;
mod parameter;
mod profile;
#[cfg(test)]
mod radau;
mod relaxation;
mod response;
mod scene;
mod segments;
mod separation;
mod settling;
mod tangent;
mod widened;
mod yielding;

pub use act::{Act, Remembered, Stage};
pub use base_law::{BaseLaw, Constants, MAX_TERMS, TERMS};
pub use chain::{Applied, Chain, Elasticity, History};
pub use coordinate::Coordinate;
pub use elastic::{Elastic, ElasticLaw, elastic_response};
pub use expression::{Expression, ExpressionError, MAX_LAW_CHARS, VARIABLES, low_pass};
pub use file::{Base, FileError, FitRecord, Model, Rung, StoredEffect, StoredParameter, VERSION};
pub use force_control::{Controlled, ForceProfile, ForceProfileError, ForceStep, Loading};
pub use gauge::{Deformation, Gauge, GaugeError};
pub use growth::Growth;
pub use hereditary::{Hereditary, HereditaryState, speed};
pub use kernel::{Kernel, Span};
pub use laws::{EXPONENTS_N, Family, LawOption, Laws};
pub use motion::{Motion, MotionError};
pub use options::OptionError;
pub use parameter::Parameter;
pub use profile::{Hold, Move, Profile, ProfileError, Step};
pub use relaxation::mean_decay;
pub use relaxation::{Branch, EQUATION_3_6, Memory, Relaxation};
pub use response::{Form, Response};
pub use scene::{Channel, Past, Scene};
pub use segments::{Equilibrium, Segments};
pub use separation::Separation;
pub use widened::widened;
