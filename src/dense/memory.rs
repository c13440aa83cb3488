//! Memory for matrices and for faer's work: refused memory is an error, not an abort.

use faer::dyn_stack::{MemBuffer, StackReq};
use faer::{Mat, MatRef};

use crate::base::{self, Error, Par, Result, SharedPtr, check_allocation};

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

/// Returns the columns `order` of a matrix, copied on the threads of `par`: a thread that writes to
/// fresh memory waits until the system has cleared it.
///
/// # Errors
/// [`Error::OutOfMemory`] when memory is refused.
pub fn columns(of: MatRef<'_, f64>, order: &[usize], par: Par) -> Result<Mat<f64>> {
    let (rows, cols) = (of.nrows(), order.len());
    let mut matrix = base::with_room::<f64>(rows, cols)?;
    let (start, stride) = (SharedPtr::new(matrix.as_ptr_mut()), matrix.col_stride());
    par.for_each(order.iter(), |j, &from| {
        for (i, &entry) in of.col(from).iter().enumerate() {
            // SAFETY: entry (i, j), for which there is room; each column is written by one thread.
            unsafe { start.at(i as isize + j as isize * stride).write(entry) };
        }
    });
    // SAFETY: all entries have been written.
    unsafe { matrix.set_dims(rows, cols) };
    Ok(matrix)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_copied_in_any_order_for_any_number_of_threads() {
        for (rows, cols) in [(0, 3), (1, 1), (7, 5), (1000, 9)] {
            let of = Mat::from_fn(rows, cols, |i, j| (i * cols + j) as f64);
            for order in [vec![], vec![cols - 1, 0, cols - 1]] {
                for par in [Par::Seq, Par::Threads(3)] {
                    for view in [of.as_ref(), of.as_ref().reverse_rows()] {
                        let found = columns(view, &order, par).unwrap();
                        let expected = |i: usize, j: usize| view[(i, order[j])];
                        assert_eq!(found, Mat::from_fn(rows, order.len(), expected));
                    }
                }
            }
        }
    }
}
