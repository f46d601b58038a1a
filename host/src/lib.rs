//! palpate: fit viscoelastic contact models to recordings of touch, see where they fail.
//!
//! The library behind the `palpate` command: what other programs depend on. Without default features it fits and diagnoses, and
//! has no server, no serial port, no Parquet and no command line.
//!
//! ```
//! # fn main() -> Result<(), palpate::Error> {
//! # let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/traces/press.csv");
//! use palpate::{DataSet, Law};
//!
//! let set = DataSet::read(folder)?;
//! let fit = palpate::fit(Law::fung().terms(2), &set).run()?;
//! let found = palpate::diagnose(fit.model(), &set).run()?;
//! println!("{}: {:?}", found.verdict().word(), found.effects());
//! # Ok(())
//! # }
//! ```
//!
//! [`fit`](fit()), [`rank`] and [`diagnose`] are the short way; the rooms below have everything else. Each is a crate of its own, and
//! dependencies between them point one way (`docs/architecture.md` draws them).
//!
//! - [`trace`]: one recording and sets of them: read, write, import, find the phases. [`recording`]: what a device says, kept as
//!   it comes. [`files`]: results that are whole or not there.
//! - [`model`]: base laws, the chain that runs them with effects over a motion, and the model file. [`effects`]: the library of
//!   effects, one declaration each, and laws of one's own. [`latency`]: the latency law.
//! - [`mod@fit`]: exponential sums, whole motions, bounded least squares, uncertainty, noise made white.
//! - [`analysis`]: relaxation, creep, loading rates and strain rates of any recording; [`regions`] of a grasp, FA and SA
//!   ([`decomposition`]), [`events`], the summary of a [`press`].
//! - [`criticism`]: where a model fails, which effect is missing, how sure that is; [`discover`]: a formula for what no effect of
//!   the library explains; [`practice`]: data sets with a hidden effect; [`promises`]: what every law is held to.
//! - [`contact`]: a round tip on an elastic body; [`grasp`]: what a soft contact can hold; [`afm`]: force curves of a tip;
//!   [`sensor`]: a simulated fingertip.
//! - [`device`]: the line to a fingertip, and one without hardware; [`robots`]: what it feels as topics.
//! - [`survey`]: one question, many groups of traces.
//! - [`report`]: vector plots and self-contained HTML; [`answers`]: results as types with a JSON schema each, [`summary`]: in
//!   words, tables and plots; [`dissertation`]: the
//!   figures that the dissertation prints; [`bundled`]: the recordings that come with the program.
//! - [`serve`]: a local page over the same functions as the commands, [`held`]: what a law predicts of a held press.
//! - [`cli`]: one file for each subcommand: parse, call, print.
#![forbid(unsafe_code)]

#[cfg(feature = "analysis")]
pub use palpate_analysis as analysis;
#[cfg(feature = "analysis")]
pub use palpate_analysis::{decomposition, events, press, regions};
#[cfg(feature = "cli")]
pub use palpate_cli as cli;
#[cfg(feature = "contact")]
pub use palpate_contact as contact;
#[cfg(feature = "contact")]
pub use palpate_contact::{afm, grasp, sensor};
pub use palpate_diagnose::{criticism, discover, practice, promises};
pub use palpate_fit as fit;
#[cfg(feature = "device")]
pub use palpate_link::{device, robots};
pub use palpate_model as model;
pub use palpate_model::{effects, latency};
#[cfg(feature = "report")]
pub use palpate_present::{answers, bundled, dissertation, summary};
#[cfg(feature = "report")]
pub use palpate_report as report;
#[cfg(feature = "cli")]
pub use palpate_serve as serve;
#[cfg(feature = "cli")]
pub use palpate_serve::held;
#[cfg(feature = "cli")]
pub use palpate_survey as survey;
pub use palpate_trace as trace;
pub use palpate_trace::{files, recording};

/// What runs on the fingertip itself: filter, calibration, messages; the same code as in the firmware.
#[cfg(feature = "device")]
pub use shared as fingertip;

mod data_set;
mod diagnosing;
mod error;
mod fitting;
mod law;
mod ranking;
mod work;

pub use data_set::DataSet;
pub use diagnosing::{Diagnosing, Found, diagnose};
pub use error::Error;
pub use fitting::{Fit, Fitting, fit};
pub use law::Law;
pub use palpate_fit::watch::Stage;
pub use palpate_model::effects::{Effect, Effects};
pub use palpate_model::{Elastic, Family, Kernel, Laws, Model, Separation};
pub use ranking::{EveryLaw, rank};
pub use work::{Asked, Cancel, Question};
