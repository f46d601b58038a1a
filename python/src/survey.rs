//! Surveys: a question put to every group of a large data set, in this process or by rows that are made in others.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use palpate::cli::Failure;
use palpate::cli::survey::apart::{self, Call, Open};
use palpate::survey::results::{about, read_rows};
use pyo3::prelude::*;

use crate::answer::Answer;
use crate::error::{broken, failed, wrong};
use crate::work::work;

/// A call of `palpate survey`, and the folder of its results while rows are made elsewhere.
#[pyclass(frozen, module = "palpate._palpate")]
pub struct Survey {
    call: Arc<Call>,
    open: Mutex<Option<Open>>,
}

impl Survey {
    fn folder(&self) -> MutexGuard<'_, Option<Open>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does work of the call while the interpreter is free.
    fn done<T: Send + 'static>(
        &self,
        py: Python<'_>,
        tell: Option<&Bound<'_, PyAny>>,
        job: impl FnOnce(&Call) -> Result<T, Failure> + Send + 'static,
    ) -> PyResult<T> {
        let call = self.call.clone();
        work(py, tell, move || job(&call))?.map_err(|failure| failed(&failure))
    }
}

#[pymethods]
impl Survey {
    /// The call of these words, which stand after `palpate survey`.
    #[staticmethod]
    fn called(words: Vec<String>) -> PyResult<Self> {
        let call = Call::new(&words).map_err(|failure| failed(&failure))?;
        Ok(Self { call: call.into(), open: Mutex::default() })
    }

    /// Asks every group that has no row yet, here.
    fn ask(&self, py: Python<'_>, tell: Option<Bound<'_, PyAny>>) -> PyResult<()> {
        self.done(py, tell.as_ref(), Call::ask)
    }

    /// What was given as data.
    fn data(&self) -> PyResult<Vec<String>> {
        self.call.data().map_err(|failure| failed(&failure))
    }

    /// A task that says what each of these files holds.
    fn look(&self, files: Vec<PathBuf>) -> PyResult<String> {
        self.call.look(files).map_err(|failure| failed(&failure))
    }

    /// Opens the folder of the results, and gives the number of groups that have no row yet. `files` is what the tasks of
    /// `look` gave, where the files are seen elsewhere alone.
    #[pyo3(signature = (files=None))]
    fn open(&self, py: Python<'_>, files: Option<Vec<String>>) -> PyResult<usize> {
        let open = self.done(py, None, move |call| match files {
            Some(files) => call.open_of(&files),
            None => call.open(),
        })?;
        let left = open.left();
        *self.folder() = Some(open);
        Ok(left)
    }

    /// Closes the folder: others may write into it.
    fn close(&self) {
        *self.folder() = None;
    }

    /// The next task of at most so many groups.
    fn next_task(&self, most: usize) -> PyResult<Option<String>> {
        let mut open = self.folder();
        let next = open.as_mut().map(|open| open.next_task(most));
        next.transpose().map(Option::flatten).map_err(|failure| failed(&failure))
    }

    /// Keeps rows that were made elsewhere, and gives the number of those that were not there yet, and the processor time
    /// that all of them took.
    fn keep(&self, py: Python<'_>, rows: Vec<String>) -> PyResult<(usize, f64)> {
        py.detach(|| {
            let mut open = self.folder();
            let open = open.as_mut().ok_or_else(|| broken("the folder is closed"))?;
            let (mut kept, mut seconds) = (0, 0.0);
            for row in &rows {
                let (is_new, worked) = open.keep(row).map_err(|failure| failed(&failure))?;
                kept += usize::from(is_new);
                seconds += worked.seconds;
            }
            Ok((kept, seconds))
        })
    }

    /// What all rows say.
    fn found(&self, py: Python<'_>) -> PyResult<Answer> {
        Ok(Answer { found: self.done(py, None, Call::found)?.into() })
    }

    /// Prints what all rows say and writes the report, as the command does at its end.
    fn tell(&self, py: Python<'_>) -> PyResult<()> {
        self.done(py, None, Call::tell)
    }
}

/// Works off a task, and prints a row of each group, or what each file holds.
#[pyfunction]
pub fn survey_work(py: Python<'_>, task: String) -> PyResult<()> {
    let done = work(py, None, move || apart::work(&task, std::io::stdout()))?;
    done.map_err(|failure| failed(&failure))
}

/// A task without the groups whose rows are there.
#[pyfunction]
pub fn survey_rest(task: &str, rows: usize, tried: u64) -> PyResult<Option<String>> {
    apart::rest(task, rows, tried).map_err(|failure| failed(&failure))
}

/// The row of the first group of a task that ended every process that tried it.
#[pyfunction]
pub fn survey_gave_up(task: &str, attempts: u64, why: &str) -> PyResult<String> {
    apart::gave_up(task, attempts, why).map_err(|failure| failed(&failure))
}

/// The keys of the rows in a folder, and each row as JSON.
#[pyfunction]
pub fn survey_rows(py: Python<'_>, folder: PathBuf) -> PyResult<(Vec<String>, Vec<String>)> {
    py.detach(|| {
        let about = about(&folder).map_err(wrong)?;
        let mut rows = Vec::new();
        read_rows(&folder, &about, |row, _| rows.push(serde_json::to_string(&row)))
            .map_err(wrong)?;
        Ok((about.by, rows.into_iter().collect::<Result<_, _>>().map_err(broken)?))
    })
}
