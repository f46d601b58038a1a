//! Where a model fails: its residuals by trace, by region, and against what they could depend on.
//!
//! - [`residuals`]: what a model leaves, with everything it could depend on.
//! - [`region`]: the regions in which errors are counted.
//! - [`dependence`]: how much of the residual a quantity explains, and whether that is chance.
//! - [`compare`]: all of it for one model and one data set.
//! - [`signature`]: what an effect leaves of a base law that lacks it.
//! - [`foretold`]: what a candidate would make of the prediction, before anything is refitted.
//! - [`separation`]: how far a recording would set apart what the present ones do not tell apart.
//! - [`next_motion`]: the motion, within what a rig can do, that sets it furthest apart.
//! - [`outside`]: what is no effect and yet describes the misfit: a change at one [instant](incident), a slow
//!   [swing], what came before the [recording](past).
//! - [`change`]: an effect added or taken out, everything refitted.

pub mod adequacy;
pub mod agreement;
mod approach;
mod beside;
pub mod change;
pub mod character;
pub mod compare;
pub mod dependence;
pub mod diagnose;
pub mod evidence;
pub mod experiment;
pub mod explore;
pub mod fitted;
pub mod foretold;
pub mod held_out;
mod hum;
pub mod incident;
mod instead;
mod jumps;
pub mod leftover;
pub mod leftover_curve;
pub mod next_motion;
pub mod noise;
pub mod options;
pub mod outside;
pub mod past;
pub mod region;
pub mod residuals;
pub mod rest;
pub mod screen;
pub mod search;
pub mod separation;
pub mod signature;
mod slow_hum;
pub mod swing;
mod tail;
mod touch;
mod verdict;
pub mod vibration;

pub use palpate_model::covariate;
