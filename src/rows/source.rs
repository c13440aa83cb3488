//! Sources of rows.

use faer::{MatMut, MatRef};

use super::coding::Coding;
use crate::base::{Real, Result};
use crate::product::combine::convert;

/// A source of the rows of a matrix, block by block.
///
/// ```
/// use catamaran::rows::{RowBlocks, RowOptions, ata_rows};
/// use catamaran::faer::{Mat, MatMut};
/// use catamaran::{AtaOptions, Result};
///
/// /// The powers 1, x, x^2 of x = 0, 1, 2, ..., which are never stored.
/// struct Powers(usize);
///
/// impl RowBlocks<f64> for Powers {
///     fn nrows(&self) -> usize {
///         self.0
///     }
///
///     fn ncols(&self) -> usize {
///         3
///     }
///
///     fn read(&mut self, first: usize, mut out: MatMut<'_, f64>) -> Result<()> {
///         for i in 0..out.nrows() {
///             for j in 0..3 {
///                 out[(i, j)] = ((first + i) as f64).powi(j as i32);
///             }
///         }
///         Ok(())
///     }
/// }
///
/// let mut c = Mat::zeros(3, 3);
/// let (rows, options) = (&mut Powers(5), AtaOptions::new());
/// ata_rows(1.0, rows, &RowOptions::new(), 0.0, c.as_mut(), &options)?;
/// assert_eq!(c[(2, 0)], 0.0 + 1.0 + 4.0 + 9.0 + 16.0);
/// # Ok::<(), catamaran::Error>(())
/// ```
pub trait RowBlocks<T> {
    /// Returns the number of rows.
    fn nrows(&self) -> usize;

    /// Returns the number of columns.
    fn ncols(&self) -> usize;

    /// Fills `out` with the rows from `first` on; every entry of `out` is written. Rows may be
    /// requested more than once, always in blocks of consecutive rows inside the matrix.
    ///
    /// # Errors
    /// Whatever keeps the rows from being read.
    fn read(&mut self, first: usize, out: MatMut<'_, T>) -> Result<()>;

    /// Returns which columns [`RowBlocks::read_coded`] replaces by codes; by default there are
    /// none. A source that passes rows on as they are passes these two on, too.
    fn coding(&self) -> Option<Coding> {
        None
    }

    /// Fills `out` with coded rows (see [`Coding`]) from `first` on, as [`RowBlocks::read`] does
    /// with whole rows.
    ///
    /// # Errors
    /// Whatever keeps the rows from being read.
    fn read_coded(&mut self, first: usize, out: MatMut<'_, T>) -> Result<()> {
        self.read(first, out)
    }
}

/// The rows of a matrix in memory, converted to the requested scalar (f32 to f64 is exact).
///
/// ```
/// use catamaran::rows::{DenseRows, RowBlocks};
/// use catamaran::faer::{Mat, mat};
///
/// let a = mat![[1.5_f32, 2.0], [3.0, 4.0]];
/// let mut row = Mat::<f64>::zeros(1, 2);
/// DenseRows(a.as_ref()).read(1, row.as_mut())?;
/// assert_eq!(row, mat![[3.0, 4.0]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct DenseRows<'a, S>(pub MatRef<'a, S>);

impl<S: Real, T: Real> RowBlocks<T> for DenseRows<'_, S> {
    fn nrows(&self) -> usize {
        self.0.nrows()
    }

    fn ncols(&self) -> usize {
        self.0.ncols()
    }

    fn read(&mut self, first: usize, out: MatMut<'_, T>) -> Result<()> {
        convert(self.0.subrows(first, out.nrows()), out);
        Ok(())
    }
}
