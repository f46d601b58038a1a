//! palpate: fit viscoelastic contact models to recordings of touch, see where they fail.
//!
//! The library behind the `palpate` command. Dependencies between its modules point one way,
//! [`recording`] ← [`trace`] ← [`model`] ← [`effects`] ← [`fit`] ← [`analysis`], [`criticism`] ← [`discover`] ← [`summary`] ← [`cli`], and nothing
//! below `cli` prints.
//!
//! - [`recording`]: what a device says, kept as it comes, and the relation of its clock to the host's.
//! - [`trace`]: one recording and sets of them: read, write, import, find the phases.
//! - [`model`]: base laws, the chain that runs them with effects over a motion, and the model file.
//! - [`effects`]: the library of effects, one declaration each, and laws of one's own.
//! - [`fit`]: exponential sums, whole motions, bounded least squares, uncertainty, noise made white.
//! - [`analysis`]: regions, relaxation, creep, loading rates and strain rates of any recording.
//! - [`criticism`]: where a model fails, which effect is missing, how sure that is.
//! - [`discover`]: a formula for what no effect of the library explains.
//! - [`contact`]: a round tip on an elastic body, and the stress below it.
//! - [`events`]: touch, release and incipient slip, as a device finds them.
//! - [`sensor`]: a simulated fingertip.
//! - [`afm`]: force curves of a tip.
//! - [`grasp`]: what a soft contact can hold before it slips.
//! - [`robots`]: what a fingertip feels as topics for the tools of robots.
//! - [`held`]: what a law foretells of a held press from the signal alone.
//! - [`dissertation`]: the figures that the dissertation prints.
//! - [`practice`]: data sets with a hidden effect.
//! - [`serve`]: a local page over the same functions as the commands.
//! - [`report`]: vector plots and self-contained HTML.
//! - [`cli`]: one file for each subcommand: parse, call, print.
#![forbid(unsafe_code)]

pub mod afm;
pub mod analysis;
mod caught;
pub mod cli;
pub mod contact;
pub mod criticism;
pub mod decomposition;
pub mod device;
pub mod discover;
pub mod dissertation;
pub mod effects;
pub mod events;
pub mod files;
pub mod fit;
pub mod grasp;
pub mod held;
pub mod latency;
mod meant;
pub mod model;
pub mod practice;
pub mod press;
pub mod promises;
pub mod recording;
pub mod regions;
pub mod report;
pub mod robots;
pub mod sensor;
pub mod serve;
pub mod summary;
pub mod survey;
pub mod trace;
