//! Why a question cannot be answered.

use palpate_diagnose::criticism::diagnose::DiagnoseError;
use palpate_fit::data::DataError;
use palpate_model::OptionError;

/// Why a question cannot be answered.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A trace cannot be read; its words name file, line and cell.
    #[error(transparent)]
    Trace(#[from] palpate_trace::Error),
    /// The law does not have these options.
    #[error(transparent)]
    Law(#[from] OptionError),
    /// These traces cannot be fitted.
    #[error(transparent)]
    Data(#[from] DataError),
    /// The model cannot be diagnosed on these traces.
    #[error(transparent)]
    Diagnose(#[from] DiagnoseError),
    /// The search found nothing better than a constant.
    #[error(
        "the search found nothing better than a constant: R² is {r_squared:.3}. Is the signal zero off the specimen, and its sign right?"
    )]
    NoBetter {
        /// Coefficient of determination.
        r_squared: f64,
    },
    /// The work was ended by its [`Cancel`](crate::Cancel).
    #[error("the work was cancelled")]
    Cancelled,
    /// The system gives no threads.
    #[error("the system gives no threads: {0}")]
    Threads(#[source] rayon::ThreadPoolBuildError),
}
