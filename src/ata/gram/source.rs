//! Where rows come from.

use faer::{MatMut, MatRef};

use crate::base::{Real, Result};

/// A source of the rows of a matrix, block by block.
pub trait RowBlocks<T> {
    /// Number of rows.
    fn nrows(&self) -> usize;

    /// Number of columns.
    fn ncols(&self) -> usize;

    /// Fills `out` with the rows from `first` on; every entry of `out` is written. Rows may be
    /// asked for more than once, always in blocks of consecutive rows inside the matrix.
    ///
    /// # Errors
    /// Whatever keeps the rows from being read.
    fn read(&mut self, first: usize, out: MatMut<'_, T>) -> Result<()>;
}

/// The rows of a matrix in memory, converted to the scalar asked for (f32 to f64 is exact).
#[derive(Debug, Clone, Copy)]
pub struct DenseRows<'a, S>(pub MatRef<'a, S>);

impl<S: Real, T: Real> RowBlocks<T> for DenseRows<'_, S> {
    fn nrows(&self) -> usize {
        self.0.nrows()
    }

    fn ncols(&self) -> usize {
        self.0.ncols()
    }

    fn read(&mut self, first: usize, mut out: MatMut<'_, T>) -> Result<()> {
        for i in 0..out.nrows() {
            for j in 0..out.ncols() {
                out[(i, j)] = T::from_f64(self.0[(first + i, j)].to_f64());
            }
        }
        Ok(())
    }
}
