//! Memory of an array that Python owns, read without a copy.

use pyo3::buffer::PyBuffer;
use pyo3::exceptions::{PyBufferError, PyTypeError};
use pyo3::prelude::*;
use std::ops::Deref;

/// Bytes of a contiguous object, kept alive and in place while this lives.
///
/// The interpreter may run other threads meanwhile. One that writes into the array while it is read makes the result that of a
/// mixture; numbers are checked after they were read, so that nothing worse follows.
pub(crate) struct Bytes(PyBuffer<u8>);

impl Bytes {
    /// The memory of an object that is contiguous in the order of C.
    pub(crate) fn of(object: &Bound<'_, PyAny>) -> PyResult<Self> {
        let buffer = PyBuffer::<u8>::get(object)?;
        match buffer.is_c_contiguous() {
            true => Ok(Self(buffer)),
            false => Err(PyBufferError::new_err("the array is not contiguous")),
        }
    }
}

impl AsRef<[u8]> for Bytes {
    #[allow(
        unsafe_code,
        reason = "the view has to outlast the attachment to the interpreter, which the safe one does not"
    )]
    fn as_ref(&self) -> &[u8] {
        let (start, length) = (self.0.buf_ptr().cast::<u8>(), self.0.len_bytes());
        if length == 0 {
            return &[];
        }
        // SAFETY: an exported buffer is contiguous (checked when it was made), is not null where it has bytes, and stays where it
        // is until the buffer is released, which is when `self` is dropped.
        unsafe { std::slice::from_raw_parts(start, length) }
    }
}

/// Numbers of a contiguous array of float64, as [`Bytes`].
pub(crate) struct Numbers(PyBuffer<f64>);

impl Numbers {
    /// The numbers of an array that is contiguous in the order of C and lies as the processor wants it.
    pub(crate) fn of(object: &Bound<'_, PyAny>) -> PyResult<Self> {
        let buffer = PyBuffer::<f64>::get(object)
            .map_err(|_| PyTypeError::new_err("an array of float64 is needed"))?;
        let aligned = buffer.buf_ptr().cast::<f64>().is_aligned();
        match buffer.is_c_contiguous() && aligned {
            true => Ok(Self(buffer)),
            false => Err(PyBufferError::new_err("the array is not contiguous")),
        }
    }
}

impl Deref for Numbers {
    type Target = [f64];

    #[allow(unsafe_code, reason = "as for bytes")]
    fn deref(&self) -> &[f64] {
        let (start, length) = (self.0.buf_ptr().cast::<f64>(), self.0.item_count());
        if length == 0 {
            return &[];
        }
        // SAFETY: as for bytes; the start is aligned, which was checked when it was made, and any bits are a number.
        unsafe { std::slice::from_raw_parts(start, length) }
    }
}
