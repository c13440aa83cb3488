//! Pivots that are zero up to rounding, in factors of semidefinite matrices.

use faer::MatMut;
use faer::prelude::ReborrowMut;

use crate::base::{Result, count};
use crate::dense;

/// The entry of L on the diagonal of a row that is held, in units of the largest possible entry of
/// L. All that is divided by it is far below the rounding of the rest, so that solutions are zero
/// there. A power of two, which leaves the digits of what it multiplies.
const HELD: f64 = f64::from_bits((1023 + 500) << 52);

/// Most columns of a triangle that are factorized one by one, not by a blocked factorization.
const NARROW: usize = 8;

/// Which pivots are zero, and whether a factorization goes on after one.
#[derive(Debug)]
pub(super) struct Limits {
    /// The diagonal of the matrix, by rows of the factor.
    pub diagonal: Vec<f64>,
    /// A pivot is zero if it is at most so many times the diagonal entry of its row.
    pub tolerance: f64,
    /// Whether the rows of zero pivots are held; otherwise they end the factorization.
    pub holds: bool,
    /// The rows of the factor that are held, ascending.
    pub held: Vec<usize>,
    /// The entry of L on the diagonal of rows that are held.
    hold: f64,
}

impl Limits {
    /// Creates the limits for a matrix with this diagonal, by rows of the factor.
    pub fn new(diagonal: Vec<f64>, tolerance: f64, holds: bool) -> Self {
        let largest = diagonal.iter().copied().fold(0.0, f64::max);
        // A power of two near the root of the largest entry.
        let unit = if largest > 0.0 { (largest.log2() / 2.0).round().exp2() } else { 1.0 };
        Self { diagonal, tolerance, holds, held: Vec::new(), hold: HELD * unit }
    }

    /// Returns the largest zero pivot of a row.
    fn zero(&self, row: usize) -> f64 {
        (self.tolerance * self.diagonal[row]).max(0.0)
    }

    /// Returns whether an entry below a zero pivot is more than rounding: with a pivot p and a
    /// diagonal entry d of the other row, a semidefinite matrix has `x^2 <= p d`.
    fn is_coupled(&self, x: f64, held: usize, row: usize) -> bool {
        let bound = 2.0 * self.zero(held).sqrt() * self.diagonal[row].max(0.0).sqrt();
        x.is_nan() || x.abs() > bound
    }

    /// Computes L in the lower triangle of a supernode that begins at row `start` of the factor.
    /// Returns `Ok(Err(j))` when its j-th pivot is negative, or zero where that ends the
    /// factorization.
    pub fn factorize(
        &mut self,
        mut triangle: MatMut<'_, f64>,
        start: usize,
    ) -> Result<std::result::Result<(), usize>> {
        let n = triangle.nrows();
        if n <= NARROW {
            return Ok(self.by_columns(triangle, start));
        }
        // Columns one by one find the first zero pivot, blocks some pivot.
        let before = match self.holds || self.tolerance > 0.0 {
            true => Some(dense::filled(n, n, |i, j| triangle[(i, j)])?),
            false => None,
        };
        let failed = dense::cholesky(triangle.rb_mut())?.err();
        let is_zero = |&j: &usize| triangle[(j, j)].powi(2) <= self.zero(start + j);
        let failed = failed.or_else(|| (0..n).find(is_zero));
        Ok(match (failed, before) {
            (None, _) => Ok(()),
            (Some(j), None) => Err(j),
            (Some(_), Some(before)) => {
                triangle.copy_from(&before);
                count((n * n * n / 3) as f64);
                self.by_columns(triangle, start)
            }
        })
    }

    /// Computes [`Limits::factorize`] column by column.
    fn by_columns(
        &mut self,
        mut l: MatMut<'_, f64>,
        start: usize,
    ) -> std::result::Result<(), usize> {
        let n = l.nrows();
        for j in 0..n {
            let (pivot, zero) = (l[(j, j)], self.zero(start + j));
            if pivot.is_nan() || pivot < -zero || (pivot <= zero && !self.holds) {
                return Err(j);
            }
            if pivot <= zero {
                if (j + 1..n).any(|i| self.is_coupled(l[(i, j)], start + j, start + i)) {
                    return Err(j);
                }
                (j + 1..n).for_each(|i| l[(i, j)] = 0.0);
                l[(j, j)] = self.hold;
                self.held.push(start + j);
                continue;
            }
            let root = pivot.sqrt();
            l[(j, j)] = root;
            (j + 1..n).for_each(|i| l[(i, j)] /= root);
            for k in j + 1..n {
                let factor = l[(k, j)];
                (k..n).for_each(|i| l[(i, k)] -= l[(i, j)] * factor);
            }
        }
        Ok(())
    }

    /// Replaces rounding by zeros in the columns of a supernode that are held, which are those from
    /// index `first` of the list on; `rows` are the rows below its triangle. Returns `Err(i)` when
    /// column i of the factor is more than rounding: then the matrix is not semidefinite.
    pub fn clear_below(
        &self,
        first: usize,
        start: usize,
        rows: &[u32],
        mut below: MatMut<'_, f64>,
    ) -> std::result::Result<(), usize> {
        for &held in &self.held[first..] {
            let j = held - start;
            for (i, &row) in rows.iter().enumerate() {
                if self.is_coupled(self.hold * below[(i, j)], held, row as usize) {
                    return Err(held);
                }
                below[(i, j)] = 0.0;
            }
        }
        Ok(())
    }
}
