//! Buffers whose allocation may fail, and copies of matrices in them.

use faer::prelude::ReborrowMut;
use faer::{MatMut, MatRef};

use crate::base::{Real, Result, reserved};

/// Appends the rows of `matrix`, one after another.
pub(super) fn append_rows<T: Real>(buffer: &mut Vec<T>, matrix: MatRef<'_, T>) {
    /// Rows copied together: a cache line or two of each column.
    const ROWS: usize = 16;
    let width = matrix.ncols();
    if matrix.col_stride() == 1 {
        for i in 0..matrix.nrows() {
            if let Some(row) = matrix.row(i).try_as_row_major() {
                buffer.extend_from_slice(row.as_slice());
            }
        }
        return;
    }
    for first in (0..matrix.nrows()).step_by(ROWS) {
        let rows = matrix.subrows(first, ROWS.min(matrix.nrows() - first));
        let start = buffer.len();
        buffer.resize(start + rows.nrows() * width, T::ZERO);
        let copy = &mut buffer[start..];
        for j in 0..width {
            for i in 0..rows.nrows() {
                copy[i * width + j] = rows[(i, j)];
            }
        }
    }
}

/// Returns the columns of a matrix, one after another.
pub(super) fn entries(matrix: MatRef<'_, f64>) -> Result<Vec<f64>> {
    let mut entries = reserved(matrix.nrows() * matrix.ncols())?;
    for column in matrix.col_iter() {
        entries.extend(column.iter());
    }
    Ok(entries)
}

/// Undoes [`entries`].
pub(super) fn put_entries(mut matrix: MatMut<'_, f64>, entries: &[f64]) {
    for (j, column) in entries.chunks_exact(matrix.nrows().max(1)).enumerate() {
        matrix.rb_mut().col_mut(j).iter_mut().zip(column).for_each(|(to, from)| *to = *from);
    }
}
