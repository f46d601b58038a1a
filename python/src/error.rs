//! Errors of the library as exceptions, with the same words as the command's.

use palpate::cli::Failure;
use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;

create_exception!(
    palpate,
    Error,
    PyException,
    "What the command would say, with `status`: 2 where the input or the call was wrong, 1 where the work failed."
);

/// The exception for a failure of a command.
pub fn failed(failure: &Failure) -> PyErr {
    with_status(failure.words(), failure.status())
}

/// The exception for wrong input.
pub fn wrong(what: impl ToString) -> PyErr {
    with_status(what.to_string(), 2)
}

/// The exception for work that failed.
pub fn broken(what: impl ToString) -> PyErr {
    with_status(what.to_string(), 1)
}

fn with_status(words: String, status: u8) -> PyErr {
    let error = Error::new_err(words);
    // An instance of a class made in Python takes any attribute.
    match Python::attach(|py| error.value(py).setattr("status", status)) {
        Ok(()) => error,
        Err(other) => other,
    }
}
