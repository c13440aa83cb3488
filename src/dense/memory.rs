//! Memory for matrices and for faer's work: refused memory is an error, not an abort.

use faer::Mat;
use faer::dyn_stack::{MemBuffer, StackReq};

use crate::base::{self, Error, Result, check_allocation};

/// Returns a zero matrix.
///
/// # Errors
/// [`Error::OutOfMemory`] when memory is refused.
pub fn zeros(rows: usize, cols: usize) -> Result<Mat<f64>> {
    filled(rows, cols, |_, _| 0.0)
}

/// Returns the matrix of `entry(i, j)`.
///
/// # Errors
/// [`Error::OutOfMemory`] when memory is refused.
pub fn filled(
    rows: usize,
    cols: usize,
    entry: impl FnMut(usize, usize) -> f64,
) -> Result<Mat<f64>> {
    base::filled(rows, cols, entry)
}

/// Allocates the memory that a function of faer asks for.
///
/// # Errors
/// [`Error::OutOfMemory`] when memory is refused.
pub fn buffer(requirement: StackReq) -> Result<MemBuffer> {
    let bytes = requirement.unaligned_bytes_required();
    check_allocation(bytes)?;
    MemBuffer::try_new(requirement).map_err(|_| Error::OutOfMemory { bytes })
}
