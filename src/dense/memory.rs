//! Memory for matrices and for faer's work: refused memory is an error, not an abort.

use faer::Mat;
use faer::dyn_stack::{MemBuffer, StackReq};

use crate::base::{Error, Result};

/// Returns a zero matrix, or an error when memory is refused.
pub(crate) fn zeros(rows: usize, cols: usize) -> Result<Mat<f64>> {
    let bytes = rows.saturating_mul(cols).saturating_mul(size_of::<f64>());
    let refused = Error::OutOfMemory { bytes };
    if bytes > isize::MAX as usize {
        return Err(refused);
    }
    // faer's own zeros abort when memory is refused.
    let mut matrix = Mat::new();
    matrix.try_reserve(rows, cols).map_err(|_| refused)?;
    matrix.resize_with(rows, cols, |_, _| 0.0);
    Ok(matrix)
}

/// Allocates the memory that a function of faer asks for.
pub(crate) fn buffer(requirement: StackReq) -> Result<MemBuffer> {
    let bytes = requirement.unaligned_bytes_required();
    MemBuffer::try_new(requirement).map_err(|_| Error::OutOfMemory { bytes })
}
