//! A fingertip at the other end of a line, block by block.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use numpy::{PyArray1, PyArray2};
use palpate::device::answers::{IdentityAnswer, SettingsAnswer};
use palpate::device::heard::Said;
use palpate::device::session::{LinkError, Session};
use palpate::device::stream::Stream;
use palpate::regions::{code, type_code};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use shared::fixed::microstrain;
use shared::pipeline::GAUGES;
use shared::wire::{Columns, Row, Source, Start, ToDevice};

use crate::error::broken;

/// How long a device may take to answer.
const PATIENCE: Duration = Duration::from_millis(750);
/// Nothing came for so long: the converter stands still.
const SILENCE: Duration = Duration::from_secs(2);
/// How often signals are looked for.
const SLICE: Duration = Duration::from_millis(50);

/// A device and what it streams.
#[pyclass(frozen, module = "palpate._palpate")]
pub struct Device {
    link: Mutex<(Session, Stream)>,
}

/// What is wrong with a link is work that failed.
fn lost(error: LinkError) -> PyErr {
    broken(error)
}

impl Device {
    fn link(&self) -> MutexGuard<'_, (Session, Stream)> {
        self.link.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl Device {
    /// Opens a port and asks who is there.
    #[staticmethod]
    fn open(py: Python<'_>, port: PathBuf) -> PyResult<Self> {
        let session = py.detach(|| Session::open(&port, PATIENCE));
        let session = session.map_err(|error| broken(format!("{}: {error}", port.display())))?;
        Ok(Self { link: Mutex::new((session, Stream::default())) })
    }

    /// Who it is and how it is set, as JSON.
    fn about(&self) -> String {
        let link = self.link();
        let (identity, settings) = (link.0.identity(), link.0.settings().1);
        serde_json::json!({
            "device": IdentityAnswer::from(identity),
            "settings": SettingsAnswer::of(settings),
        })
        .to_string()
    }

    /// Begins a stream.
    fn start(&self, py: Python<'_>) -> PyResult<()> {
        py.detach(|| {
            let mut link = self.link();
            link.0.settle()?;
            let start = Start { source: Source::Converter, columns: Columns::Parts };
            link.0.command(&ToDevice::Start(start))?;
            link.1.start();
            Ok(())
        })
        .map_err(lost)
    }

    /// Ends the stream.
    fn stop(&self, py: Python<'_>) -> PyResult<()> {
        py.detach(|| self.link().0.quiet()).map_err(lost)
    }

    /// The next rows of the stream as arrays.
    fn block<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let began = Instant::now();
        loop {
            if began.elapsed() > SILENCE {
                return Err(lost(LinkError::NoRows));
            }
            let heard = py.detach(|| {
                let mut link = self.link();
                let (session, stream) = &mut *link;
                let Some(heard) = session.hear(Instant::now() + SLICE)? else { return Ok(None) };
                stream.take(&heard);
                let Ok((_, Said::Rows(rows))) = &heard.said else { return Ok(None) };
                Ok(session.rows(rows).map(|rows| (rows, stream.tally().rows_lost)))
            });
            if let Some((rows, missing)) = heard.map_err(lost)?.filter(|(rows, _)| !rows.is_empty())
            {
                return block(py, &rows, missing);
            }
            py.check_signals()?;
        }
    }
}

/// Rows as arrays: one column for each gauge.
fn block<'py>(py: Python<'py>, rows: &[Row], missing: u64) -> PyResult<Bound<'py, PyDict>> {
    let it = PyDict::new(py);
    it.set_item("number", PyArray1::from_iter(py, rows.iter().map(|row| row.number)))?;
    let time = rows.iter().map(|row| row.time_us as f64 * 1e-6);
    it.set_item("time_s", PyArray1::from_iter(py, time))?;
    let numbers = |of: fn(&Row, usize) -> f64| -> Vec<Vec<f64>> {
        rows.iter().map(|row| (0..GAUGES).map(|gauge| of(row, gauge)).collect()).collect()
    };
    for (name, of) in [
        ("fa_ustrain", (|row, gauge| microstrain(row.fa[gauge])) as fn(&Row, usize) -> f64),
        ("sa_ustrain", |row, gauge| microstrain(row.sa[gauge])),
        ("region", |row, gauge| code(row.states[gauge].region)),
        ("relaxation", |row, gauge| type_code(row.states[gauge].relaxation)),
    ] {
        it.set_item(name, PyArray2::from_vec2(py, &numbers(of)).map_err(broken)?)?;
    }
    it.set_item("lost", missing)?;
    Ok(it)
}
