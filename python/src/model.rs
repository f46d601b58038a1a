//! Model files.

use std::path::PathBuf;

use palpate::answers::{self, LibraryAnswer};
use palpate::files::plan::MODEL;
use palpate::model::Model as Inner;
use pyo3::prelude::*;

use crate::data::allowed;
use crate::error::{broken, wrong};

/// A model: a base law with its parameters, effects, and how they were found. It never changes.
#[pyclass(frozen, module = "palpate._palpate")]
pub struct Model {
    /// The model.
    pub inner: Inner,
}

#[pymethods]
impl Model {
    /// Reads a model file.
    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Self> {
        Inner::read(&path).map(|inner| Self { inner }).map_err(wrong)
    }

    /// Reads the text of a model file.
    #[staticmethod]
    fn from_toml(text: &str) -> PyResult<Self> {
        Inner::parse("model".as_ref(), text).map(|inner| Self { inner }).map_err(wrong)
    }

    /// Takes a model from its keys as JSON, held to the same as a file.
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        let inner: Inner = serde_json::from_str(text).map_err(wrong)?;
        Self::from_toml(&inner.to_toml().map_err(wrong)?)
    }

    /// The text of the model file.
    fn to_toml(&self) -> PyResult<String> {
        self.inner.to_toml().map_err(broken)
    }

    /// The keys of the model file as JSON.
    fn json(&self) -> PyResult<String> {
        serde_json::to_string(&self.inner).map_err(broken)
    }

    /// Writes the model file, whole or not at all.
    fn write(&self, path: PathBuf, force: bool) -> PyResult<()> {
        allowed(&path, &MODEL, force)?;
        self.inner.write(&path).map_err(broken)
    }
}

/// The library of effects as JSON, as `palpate effects --json` prints it.
#[pyfunction]
pub fn effects() -> String {
    answers::json(&LibraryAnswer::whole()).to_string()
}
