//! Why the Lab cannot do something.

use std::path::PathBuf;

use palpate_analysis::decomposition::DecompositionError;
use palpate_diagnose::criticism::change::ChangeError;
use palpate_diagnose::criticism::compare::CompareError;
use palpate_diagnose::criticism::diagnose::DiagnoseError;
use palpate_diagnose::practice::{FolderError, HideError, SealError};
use palpate_fit::data::DataError;
use palpate_model::{FileError, OptionError};
use palpate_survey::ResultsError;
use palpate_trace as trace;

/// Why the Lab cannot do something.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum LabError {
    #[error("`{0}` is not in the folder that was opened")]
    Outside(String),
    #[error("{} of this survey lies outside the folder that was opened: open {}", path.display(), above.display())]
    Elsewhere { path: PathBuf, above: PathBuf },
    #[error("no trace of it can be read; {file}: {why}")]
    Unread { file: String, why: String },
    #[error("the same file as `{0}`")]
    Same(String),
    #[error("`{0}` is there, and is no model that palpate wrote: choose another name")]
    Foreign(String),
    #[error("{path}: {source}")]
    Io { path: PathBuf, source: std::io::Error },
    #[error("no folder was opened: `palpate serve traces/` opens one")]
    NoFolder,
    #[error("no trace is chosen")]
    NoTraces,
    #[error("there is no model yet: fit a base law, or open a model file")]
    NoModel,
    #[error("nothing is known of `{0}`: diagnose first")]
    NoForecast(String),
    #[error("no {what} is called `{name}`")]
    Unknown { what: &'static str, name: String },
    #[error("{other} is of {theirs}, the model at hand of {ours}: they cannot be compared")]
    OtherSignal { other: String, theirs: String, ours: String },
    #[error("nothing to undo")]
    NothingToUndo,
    #[error("something is being worked out: wait for it, or cancel it")]
    Busy,
    #[error("cancelled")]
    Cancelled,
    #[error("the work broke off without an answer")]
    BrokeOff,
    #[error("no threads to work on: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    #[error("{0}")]
    Law(String),
    #[error(transparent)]
    Trace(#[from] trace::Error),
    #[error(transparent)]
    Model(#[from] FileError),
    #[error(transparent)]
    Options(#[from] OptionError),
    #[error(transparent)]
    Data(#[from] DataError),
    #[error(transparent)]
    Compare(#[from] CompareError),
    #[error(transparent)]
    Diagnose(#[from] DiagnoseError),
    #[error(transparent)]
    Filter(#[from] DecompositionError),
    #[error(transparent)]
    Change(#[from] ChangeError),
    #[error(transparent)]
    Hide(#[from] HideError),
    #[error(transparent)]
    Written(#[from] FolderError),
    #[error(transparent)]
    Survey(#[from] ResultsError),
    #[error(transparent)]
    Seal(#[from] SealError),
}
