//! Surveys: one question put to every group of a large data set, one row of answers a group.
//!
//! - [`source`]: which traces there are, and which belong together; the names of files, heads and columns tell.
//! - [`run`]: the groups side by side, one thread a group; one that fails is a row with its reason.
//! - [`row`]: what an answer is as a row of a table.
//! - [`results`]: the folder that a survey fills, part by part, and takes up again after a kill.
//! - [`overview`]: what all rows say together.
//! - [`population`]: what the specimens have in common, and how much they differ.
//!
//! The rows do not depend on the number of threads, nor on how often the survey was interrupted: the same inputs and options
//! make the same bytes in `groups/`. What differs from run to run, the seconds, stands in `work/`.
//!
//! ```
//! # fn main() -> Result<(), palpate_survey::source::SourceError> {
//! # let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/traces");
//! use palpate_survey::source::{By, Sources, TRACE};
//!
//! // Every recording by itself, a group each.
//! let by = By { keys: vec![TRACE.into()], names: None, id: "id".into() };
//! let found = Sources::find(&[folder], &by)?;
//! assert_eq!(found.groups.len(), found.inputs.len());
//! # Ok(())
//! # }
//! ```
#![forbid(unsafe_code)]

mod columns;
mod feed;
mod flat;
pub mod group;
mod journal;
mod manifest;
mod names;
pub mod overview;
mod part;
pub mod population;
pub mod results;
pub mod row;
pub mod run;
pub mod source;

pub use feed::apart;
pub use group::{Group, Place};
pub use names::Names;
pub use results::{Plan, Results, ResultsError};
pub use row::{Asked, Estimate, Row, Status, Worked};
pub use source::{By, Contents, SourceError, Sources};
