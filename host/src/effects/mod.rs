//! The library of effects: what a base law can lack, one declaration in one file each.
//!
//! An effect has a name, a stage of the chain, one or more laws with few parameters, the sign that
//! physics allows, what its residual looks like, what it can be mistaken for and the experiment that
//! separates it. A new effect is one file here and one line in [`LIBRARY`]; nothing else knows effects
//! by name.

mod candidates;
mod contact_offset;
mod declaration;
mod fast_mode;
mod library;
mod mullins;
mod stored;
mod zero_shift;

pub use candidates::{Candidate, Form, candidates};
pub use declaration::{
    Count, Effect, Grid, Law, Needs, Role, Scales, Setting, Shape, Sign, Strength,
};
pub use library::{LIBRARY, find};
pub use stored::{EffectError, applied, chain_of, store};
