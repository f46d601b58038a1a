//! The Lab: a model is put beside recordings, told what it lacks, and put right, step by step.
//!
//! A [`Session`] holds what the page shows; each of its functions answers with JSON and calls what the
//! command line calls, so that both say the same. Work that takes long runs in a `job` on threads of its
//! own and can be cancelled.
//!
//! - `folder`: the folder that was opened, and nothing outside it.
//! - `dropped`: files that were dropped on the page, and foreign recordings among them.
//! - `set`: a data set, and what was left out of it.
//! - `task`: what can be asked for, and the command that does the same.
//! - `work`: doing it.
//! - `job`: a task at work.
//! - `session`: traces, models, answers, undo.
//! - `choices`, `comparison`: what there is to choose from, and where the model fails.
//! - `closer`: one trace looked at more closely.
//! - `drawing`, `envelope`, `spans`: traces as few points as a plot is wide.
//! - `forecast`: what candidates would make of the prediction.
//! - `own_law`: a law of one's own, and what is wrong with it.
//! - `surveyed`: a survey, and the traces of one of its groups.
//! - `routes`: all of it over HTTP.

mod choices;
mod closer;
mod comparison;
mod drawing;
mod dropped;
mod envelope;
mod error;
mod folder;
mod forecast;
mod job;
mod own_law;
mod routes;
mod session;
mod set;
mod spans;
mod surveyed;
mod task;
#[cfg(test)]
mod tests;
mod work;

pub use drawing::View;
pub use error::LabError;
pub use folder::Folder;
pub use own_law::OwnLaw;
pub use routes::routes;
pub use session::Session;
pub use task::{FitTask, HideTask, Other, Task};
