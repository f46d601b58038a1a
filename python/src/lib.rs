//! palpate from Python: the compiled half, `palpate._palpate`.
//!
//! Everything here calls what the command line calls (`palpate::cli::ask`), so that numbers and words are the same. What a
//! person sees, with names, defaults and documentation, is Python, in `python/package/palpate/`.
//!
//! - [`data`]: traces; their columns are numpy arrays over the very memory that is fitted.
//! - [`model`]: model files.
//! - [`ask`]: the questions, each answered while the interpreter is free.
//! - [`answer`]: what was found, as JSON, tables and figures.
//! - [`parts`]: the fast and slow adapting parts of signals as arrays.
//! - [`practice`]: data sets with a hidden effect.
//! - [`survey`]: a question put to every group of a large data set, here or by rows that others make.
//! - [`work`]: long work beside a live interpreter: Ctrl-C and progress.
//! - [`device`]: a fingertip, live.
//! - [`command`]: the command line.

mod answer;
mod array;
mod ask;
mod command;
mod data;
mod device;
mod error;
mod model;
mod parts;
mod practice;
mod survey;
mod work;

use pyo3::prelude::*;

#[pymodule]
mod _palpate {
    #[pymodule_export]
    use super::answer::Answer;
    #[pymodule_export]
    use super::ask::{
        add, compare, decompose, diagnose, discover, drop, explore, fit, grasp_friction,
        grasp_growth, grasp_margin, grasp_plan, grasp_surface, plan, relaxation, segment, simulate,
        simulate_file, simulate_force,
    };
    #[pymodule_export]
    use super::command::run;
    #[pymodule_export]
    use super::data::{DataSet, suggest};
    #[pymodule_export]
    use super::device::Device;
    #[pymodule_export]
    use super::error::Error;
    #[pymodule_export]
    use super::model::{Model, effects};
    #[pymodule_export]
    use super::parts::Parts;
    #[pymodule_export]
    use super::practice::{Practice, hide, truth};
    #[pymodule_export]
    use super::survey::{Survey, survey_gave_up, survey_rest, survey_rows, survey_work};
    use super::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        // What the Python half refuses is a wrong call.
        module.getattr("Error")?.setattr("status", 2)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
