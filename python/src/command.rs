//! The command line.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs `palpate` with these words, the name of the program first, and gives the exit status.
#[pyfunction]
pub fn run(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| palpate::cli::run_with(words))
}
