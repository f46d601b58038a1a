//! The fast and slow adapting parts of signals as arrays.

use std::sync::Arc;

use numpy::PyArray1;
use palpate::cli::ask::Decomposed;
use palpate::decomposition::Channel;
use palpate::regions::{Regions, code, type_code};
use pyo3::exceptions::{PyIndexError, PyKeyError};
use pyo3::prelude::*;

use crate::array::view;

/// Every channel of every trace, decomposed.
#[pyclass(frozen, module = "palpate._palpate")]
pub struct Parts {
    /// What the filter gave.
    pub found: Arc<Decomposed>,
}

impl Parts {
    fn channel(&self, trace: usize, channel: usize) -> PyResult<&(Channel, Regions)> {
        let found = self.found.parts.get(trace).and_then(|channels| channels.get(channel));
        found.ok_or_else(|| PyIndexError::new_err("no such channel"))
    }
}

#[pymethods]
impl Parts {
    /// The signals of each trace.
    fn signals(&self) -> Vec<Vec<String>> {
        let names = |part: &Vec<(Channel, Regions)>| {
            part.iter().map(|(channel, _)| channel.signal.clone()).collect()
        };
        self.found.parts.iter().map(names).collect()
    }

    /// One unit of the device's integers, in the unit of the signal.
    fn lsb(&self, trace: usize, channel: usize) -> PyResult<f64> {
        self.channel(trace, channel).map(|(channel, _)| channel.lsb)
    }

    /// How many samples were beyond full scale.
    fn saturated(&self, trace: usize, channel: usize) -> PyResult<u32> {
        self.channel(trace, channel).map(|(channel, _)| channel.saturated)
    }

    /// A part of a channel by name, in the unit of the signal: no copy, read-only.
    fn part<'py>(
        this: &Bound<'py, Self>,
        trace: usize,
        channel: usize,
        name: &str,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (channel, _) = this.get().channel(trace, channel)?;
        let values = match name {
            "input" => &channel.input,
            "fa" => &channel.fa,
            "sa" => &channel.sa,
            "elastic" => &channel.elastic,
            "equilibrium" => &channel.equilibrium,
            "latent" => &channel.latent,
            _ => return Err(PyKeyError::new_err(name.to_owned())),
        };
        // SAFETY: the class is frozen, and what it shares is never written to.
        unsafe { view(this.clone().into_any(), values) }
    }

    /// The region of every sample: 0 rest, 1 OA, 2 AB, 3 BC, 4 CD, 5 DE, 6 EF.
    fn region<'py>(
        &self,
        py: Python<'py>,
        trace: usize,
        channel: usize,
    ) -> PyResult<Bound<'py, PyArray1<u8>>> {
        let regions = &self.channel(trace, channel)?.1.region;
        Ok(PyArray1::from_iter(py, regions.iter().map(|region| code(*region) as u8)))
    }

    /// The type of relaxation of every sample: 0 settled, 1 Type I, 2 Type II.
    fn relaxation<'py>(
        &self,
        py: Python<'py>,
        trace: usize,
        channel: usize,
    ) -> PyResult<Bound<'py, PyArray1<u8>>> {
        let types = &self.channel(trace, channel)?.1.relaxation;
        Ok(PyArray1::from_iter(py, types.iter().map(|one| type_code(*one) as u8)))
    }
}
