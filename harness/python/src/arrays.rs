//! Rust numbers as NumPy arrays.

use numpy::ndarray::{ArrayView, IxDyn};
use numpy::{Element, PyArray, PyArray1, PyArrayMethods as _};
use pyo3::prelude::*;
use vb_env::Pointer;

/// Returns a copy of the numbers as an array of this shape.
pub(crate) fn copied<'py, T: Element>(
    py: Python<'py>,
    numbers: &[T],
    shape: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    let array = PyArray1::from_slice(py, numbers);
    Ok(array.reshape(shape)?.into_any())
}

/// Returns an array of this shape over Rust memory, which `owner` keeps alive.
///
/// # Safety
/// The memory has as many numbers as the shape says, doesn't move, and lives as long as `owner`. It is written by other threads
/// only while nobody reads the array.
pub(crate) unsafe fn over<'py>(
    pointer: Pointer,
    shape: &[usize],
    owner: &Bound<'py, PyAny>,
) -> Bound<'py, PyAny> {
    /// # Safety
    /// As of [`over`].
    unsafe fn view<'py, T: Element>(
        at: *mut T,
        shape: &[usize],
        owner: &Bound<'py, PyAny>,
    ) -> Bound<'py, PyAny> {
        // SAFETY: as the caller promises.
        unsafe {
            let view = ArrayView::from_shape_ptr(IxDyn(shape), at);
            PyArray::borrow_from_array(&view, owner.clone()).into_any()
        }
    }
    // SAFETY: as the caller promises.
    unsafe {
        match pointer {
            Pointer::F32(at, _) => view(at, shape, owner),
            Pointer::U8(at, _) => view(at, shape, owner),
            Pointer::F64(at, _) => view(at, shape, owner),
            Pointer::Bool(at, _) => view(at, shape, owner),
        }
    }
}
