//! Arrays over memory that Rust owns.

use numpy::ndarray::ArrayView1;
use numpy::{Element, PyArray1, PyArrayMethods as _};
use pyo3::prelude::*;

/// A read-only array over a slice that its owner holds, without a copy. The owner lives as long as the array.
///
/// # Safety
/// The slice must be of memory that `owner` holds, and that does not move or change while it lives.
pub unsafe fn view<'py, T: Element>(
    owner: Bound<'py, PyAny>,
    values: &[T],
) -> PyResult<Bound<'py, PyArray1<T>>> {
    // SAFETY: the caller's promise; the array keeps a reference to its owner as its base.
    let array = unsafe { PyArray1::borrow_from_array(&ArrayView1::from(values), owner) };
    let _ = array.try_readwrite().map(|array| array.make_nonwriteable());
    Ok(array)
}
