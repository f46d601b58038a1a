//! Traces of one specimen, in memory.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use numpy::{PyArray1, PyReadonlyArray1};
use palpate::cli::ask::Set;
use palpate::files::plan::{Overwrite, Plan, TRACE};
use palpate::trace::{
    Column, Head, Mapping, Proposal, TIME, Trace, import_tests, order, read_set, write,
};
use pyo3::exceptions::{PyIndexError, PyKeyError};
use pyo3::prelude::*;

use crate::array::view;
use crate::error::{broken, wrong};

/// Columns of one trace by name, what its head says (JSON), and its file's name.
type Given<'py> = (Vec<(String, PyReadonlyArray1<'py, f64>)>, String, Option<PathBuf>);

/// Traces of one specimen in one set-up. They never change.
#[pyclass(frozen, module = "palpate._palpate")]
pub struct DataSet {
    /// The traces.
    pub set: Set,
}

impl DataSet {
    /// A trace by its place.
    pub fn trace(&self, index: usize) -> PyResult<&Trace> {
        self.set.get(index).ok_or_else(|| PyIndexError::new_err("no such trace"))
    }
}

impl From<Vec<Trace>> for DataSet {
    fn from(traces: Vec<Trace>) -> Self {
        Self { set: Arc::new(traces) }
    }
}

#[pymethods]
impl DataSet {
    /// Reads files and folders, as every command does.
    #[staticmethod]
    fn read(py: Python<'_>, paths: Vec<PathBuf>) -> PyResult<Self> {
        py.detach(|| read_set(&paths)).map(Self::from).map_err(wrong)
    }

    /// Makes a trace of one recording of another program, in one file or several, as a mapping says: its text, or its file, or what
    /// is proposed where that leaves nothing open.
    #[staticmethod]
    fn imported(
        py: Python<'_>,
        paths: Vec<PathBuf>,
        map: Option<PathBuf>,
        text: Option<String>,
        part: Option<String>,
        every: Option<usize>,
    ) -> PyResult<Self> {
        let Some(first) = paths.first() else { return Err(wrong("no file given")) };
        if every == Some(0) {
            return Err(wrong("`every` counts from 1"));
        }
        let mapping = match (map, text) {
            (Some(map), Some(text)) => Mapping::parse(&map, &text),
            (Some(map), None) => Mapping::read(&map),
            (None, _) => proposed(first, part.as_deref())?.mapping(),
        };
        let mut mapping = mapping.map_err(wrong)?;
        mapping.table.part = part.or(mapping.table.part);
        mapping.every = every.or(mapping.every);
        let found = py.detach(|| import_tests(&paths, &mapping)).map_err(wrong)?;
        in_order(found.into_iter().map(|imported| imported.trace).collect())
    }

    /// Takes traces from arrays; each column is copied once, since its owner may change it while the interpreter is free.
    #[staticmethod]
    fn from_columns(traces: Vec<Given<'_>>) -> PyResult<Self> {
        let traces = traces.into_iter().map(made).collect::<PyResult<Vec<_>>>()?;
        in_order(traces)
    }

    /// Several sets as one.
    #[staticmethod]
    fn joined(sets: Vec<PyRef<'_, Self>>) -> PyResult<Self> {
        in_order(sets.iter().flat_map(|set| set.set.iter().cloned()).collect())
    }

    fn __len__(&self) -> usize {
        self.set.len()
    }

    /// Some of the traces, by place.
    fn select(&self, places: Vec<usize>) -> PyResult<Self> {
        let traces = places.into_iter().map(|place| self.trace(place).cloned());
        Ok(traces.collect::<PyResult<Vec<_>>>()?.into())
    }

    /// What a trace is called.
    fn label(&self, index: usize) -> PyResult<String> {
        self.trace(index).map(Trace::label)
    }

    /// What its head says, as JSON.
    fn head(&self, index: usize) -> PyResult<String> {
        serde_json::to_string(&self.trace(index)?.head).map_err(broken)
    }

    /// The file that it came from.
    fn path(&self, index: usize) -> PyResult<Option<PathBuf>> {
        self.trace(index).map(|trace| trace.path.clone())
    }

    /// The names of its columns, time first.
    fn columns(&self, index: usize) -> PyResult<Vec<String>> {
        let others = self.trace(index)?.columns.iter().map(|column| column.name.clone());
        Ok(std::iter::once(TIME.to_owned()).chain(others).collect())
    }

    /// The values of a column, as they are fitted: no copy, read-only.
    fn column<'py>(
        this: &Bound<'py, Self>,
        index: usize,
        name: &str,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let trace = this.get().trace(index)?;
        let values = if name == TIME { Some(&trace.time[..]) } else { trace.column(name) };
        let values = values.ok_or_else(|| PyKeyError::new_err(name.to_owned()))?;
        // SAFETY: the class is frozen and nothing else writes to its traces: `Arc::make_mut` of a shared set copies it.
        unsafe { view(this.clone().into_any(), values) }
    }

    /// Writes one trace as CSV or Parquet, whole or not at all.
    fn write(&self, py: Python<'_>, index: usize, path: PathBuf, force: bool) -> PyResult<()> {
        let trace = self.trace(index)?;
        allowed(&path, &TRACE, force)?;
        py.detach(|| write(&path, trace)).map_err(broken)
    }
}

/// What names and units in a file say, where they say enough.
fn proposed(file: &Path, part: Option<&str>) -> PyResult<Proposal> {
    let proposal = palpate::trace::propose(file, part).map_err(wrong)?;
    if proposal.open.is_empty() {
        return Ok(proposal);
    }
    let open = proposal.open.join(", ");
    Err(wrong(format!(
        "{}: the file does not say {open}; complete the mapping that `palpate.suggest` proposes and give it as `map`",
        file.display()
    )))
}

/// A mapping proposed for a file of another program.
#[pyfunction]
pub fn suggest(py: Python<'_>, path: PathBuf, part: Option<&str>) -> PyResult<String> {
    py.detach(|| palpate::trace::suggest(&path, part)).map_err(wrong)
}

/// Refuses to write over what palpate did not write, unless that is allowed.
pub fn allowed(
    path: &Path,
    kind: &'static palpate::files::plan::Kind,
    force: bool,
) -> PyResult<()> {
    let over = Overwrite { allowed: force, option: "force=True" };
    Plan::reading([""; 0], over).writes(path, kind).map_err(wrong)
}

fn made((columns, head, path): Given<'_>) -> PyResult<Trace> {
    let head: Head =
        serde_json::from_str(&head).map_err(|what| wrong(format!("the head: {what}")))?;
    let columns = columns
        .into_iter()
        .map(|(name, values)| Ok(Column { name, values: values.as_slice()?.to_vec() }))
        .collect::<PyResult<Vec<_>>>()?;
    let trace = Trace::from_columns(head, columns).map_err(wrong)?;
    Ok(Trace { path, ..trace })
}

fn in_order(mut traces: Vec<Trace>) -> PyResult<DataSet> {
    if traces.is_empty() {
        return Err(wrong("no trace given"));
    }
    order(&mut traces).map_err(wrong)?;
    Ok(traces.into())
}
