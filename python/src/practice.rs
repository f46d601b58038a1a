//! Data sets with a hidden effect.

use std::path::PathBuf;

use palpate::answers::{self, TruthAnswer};
use palpate::cli::ask;
use palpate::practice::{Practice as Inner, check_empty, open, write_set};
use pyo3::prelude::*;

use crate::data::DataSet;
use crate::error::{broken, failed, wrong};
use crate::work::work;

/// Ten traces of a made-up specimen with a secret. They never change.
#[pyclass(frozen, module = "palpate._palpate")]
pub struct Practice {
    inner: Inner,
}

#[pymethods]
impl Practice {
    /// The traces.
    fn data(&self) -> DataSet {
        self.inner.traces.clone().into()
    }

    /// What was hidden, as JSON.
    fn truth(&self) -> String {
        answers::json(&TruthAnswer::from(&self.inner.truth)).to_string()
    }

    /// The seed of everything random in it.
    fn seed(&self) -> u64 {
        self.inner.truth.seed
    }

    /// Writes traces and sealed truth into a new or empty folder.
    fn write(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        py.detach(|| {
            check_empty(&folder).map_err(wrong)?;
            write_set(&folder, &self.inner).map_err(broken)
        })
    }
}

/// Makes a practice set.
#[pyfunction]
pub fn hide(
    py: Python<'_>,
    options: Vec<String>,
    tell: Option<Bound<'_, PyAny>>,
) -> PyResult<Practice> {
    let found = work(py, tell.as_ref(), move || ask::hide(&options))?;
    found.map(|inner| Practice { inner }).map_err(|failure| failed(&failure))
}

/// What is hidden in the practice set of a folder, as JSON.
#[pyfunction]
pub fn truth(folder: PathBuf) -> PyResult<String> {
    let truth = open(&folder).map_err(wrong)?;
    Ok(answers::json(&TruthAnswer::from(&truth)).to_string())
}
