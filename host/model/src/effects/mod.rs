//! The library of effects: what a base law can lack, one declaration in one file each.
//!
//! An effect has a name, a stage of the chain, one or more laws with few parameters, the sign that
//! physics allows, what its residual looks like, what it can be mistaken for and the experiment that
//! separates it. A new effect is one file here and one line in [`LIBRARY`]; nothing else knows effects
//! by name.

mod adhesion;
mod amplitude_dependent_relaxation;
mod backlash;
mod candidates;
mod contact_offset;
mod coulomb_friction;
mod crosstalk;
mod cyclic_softening;
mod declaration;
mod drift;
mod elastic_stiffening;
mod fast_mode;
mod fixture_compliance;
mod gauge_nonlinearity;
mod hysteresis;
mod inertia;
mod latency_law;
mod library;
mod line_around;
mod load_friction;
mod mains_hum;
mod memory;
mod mullins;
mod permanent_set;
mod published;
mod rate_drag;
mod saturation;
mod sensor_lag;
mod shapes;
mod slow_relaxation;
mod stored;
mod sync_delay;
mod thermal_output;
mod thermal_stiffness;
mod time_temperature;
pub mod units;
mod viscous_drag;
mod warm_up;
mod zero_shift;

pub use candidates::{Candidate, Form, candidates};
pub use declaration::{
    Count, Effect, FOLLOWED, Grid, Law, Needs, RECOVERED, Role, Scales, Setting, Shape, Sign,
    Strength,
};
pub use library::{Effects, LIBRARY, find, meant};
pub use line_around::shown;
pub use published::{PublishedError, read_laws};
pub use stored::{EffectError, applied, chain_of, store};

use crate::covariate::Covariate;
