//! A data set, as a program has it.

use std::path::Path;
use std::sync::Arc;

use palpate_trace::{Trace, read_set};

use crate::Error;

/// Traces of one specimen, which are fitted and diagnosed together. Clones share them.
#[derive(Clone, Debug, PartialEq)]
pub struct DataSet(Arc<Vec<Trace>>);

impl DataSet {
    /// Reads a trace, or all traces of a folder by name.
    ///
    /// # Errors
    /// [`Error::Trace`], with file, line and cell.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        Ok(Self(Arc::new(read_set(&[path])?)))
    }

    /// Its traces.
    #[must_use]
    pub fn traces(&self) -> &[Trace] {
        &self.0
    }
}

impl From<Vec<Trace>> for DataSet {
    fn from(traces: Vec<Trace>) -> Self {
        Self(Arc::new(traces))
    }
}
