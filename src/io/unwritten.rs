//! Matrices that are written block by block.

use crate::base::{Error, Result};

/// A matrix of which some rows, or some columns, are not yet written.
#[derive(Default)]
pub(super) struct Unwritten {
    pub by_rows: bool,
    pub shape: (usize, usize),
    /// Rows or columns so far.
    pub written: usize,
}

impl Unwritten {
    /// Checks that the next rows or columns, a block of this shape, are of this matrix.
    pub fn check(&self, by_rows: bool, next: (usize, usize)) -> Result<()> {
        let (rows, columns) = if by_rows == self.by_rows { self.missing() } else { (0, 0) };
        match by_rows {
            true => Error::check_shape("rows", (rows.min(next.0), columns), next),
            false => Error::check_shape("columns", (rows, columns.min(next.1)), next),
        }
    }

    /// Checks that all of the matrix is written.
    pub fn check_end(&self) -> Result<()> {
        let (rows, columns) = self.missing();
        match self.by_rows {
            true => Error::check_shape("rows", (rows, columns), (0, columns)),
            false => Error::check_shape("columns", (rows, columns), (rows, 0)),
        }
    }

    /// Returns the rows and columns of the part that is missing.
    fn missing(&self) -> (usize, usize) {
        let (rows, columns) = self.shape;
        match self.by_rows {
            true => (rows - self.written, columns),
            false => (rows, columns - self.written),
        }
    }
}
