use std::ops::Range;

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Mat, MatMut};

use super::inner::Inner;
use crate::base::Result;
use crate::dense::{cholesky, lower_solve_in_place, multiply_in_place, zeros};

/// Largest number of columns that are made orthonormal one by one.
const LEAF: usize = 8;

/// One pass of Gram-Schmidt over the columns of a panel.
pub(super) struct Pass {
    /// Columns that are kept, ascending. The first columns of the panel hold them, orthonormal to
    /// the accuracy of one pass.
    pub kept: Vec<usize>,
    /// The lengths of their parts that are orthogonal to the columns before them.
    pub lengths: Vec<f64>,
    /// Kept x columns of the panel: the coefficients of all columns.
    pub r: Mat<f64>,
    /// Columns that were dropped, and the lengths that were left of them.
    pub dropped: Vec<(usize, f64)>,
}

/// Makes the columns of a panel orthonormal, and drops column j if at most `limits[j]` is left of
/// it. Columns are processed at once where that is as accurate, otherwise by halves; the projection
/// onto the first half is removed from the second.
pub(super) fn pass(
    inner: &mut Inner<'_>,
    mut panel: MatMut<'_, f64>,
    limits: &[f64],
) -> Result<Pass> {
    let width = panel.ncols();
    let r = zeros(width, width)?;
    let mut pass = Pass { kept: vec![], lengths: vec![], r, dropped: vec![] };
    pass.columns(inner, panel.rb_mut(), limits, 0..width)?;
    pass.r.truncate(pass.kept.len(), width);
    Ok(pass)
}

impl Pass {
    /// Processes the columns of `range`, which are orthogonal to those kept before them.
    fn columns(
        &mut self,
        inner: &mut Inner<'_>,
        mut panel: MatMut<'_, f64>,
        limits: &[f64],
        range: Range<usize>,
    ) -> Result<()> {
        if self.at_once(inner, panel.rb_mut(), limits, &range)? {
            return Ok(());
        }
        if range.len() <= LEAF {
            return self.leaf(inner, panel, limits, range);
        }
        let middle = range.start + range.len() / 2;
        let before = self.kept.len();
        self.columns(inner, panel.rb_mut(), limits, range.start..middle)?;
        let after = self.kept.len();
        if after > before {
            let (left, right) = panel.rb_mut().split_at_col_mut(middle);
            let q = left.rb().subcols(before, after - before);
            let x = right.subcols_mut(0, range.end - middle);
            let coefficients = inner.project(q, x)?;
            let (rows, cols) = coefficients.shape();
            self.r.as_mut().submatrix_mut(before, middle, rows, cols).copy_from(&coefficients);
        }
        self.columns(inner, panel, limits, middle..range.end)
    }

    /// Computes Cholesky QR of the columns of `range`, if all are kept and their Gram matrix is
    /// accurate enough. Returns whether it was done.
    fn at_once(
        &mut self,
        inner: &mut Inner<'_>,
        mut panel: MatMut<'_, f64>,
        limits: &[f64],
        range: &Range<usize>,
    ) -> Result<bool> {
        /// Largest mean square of the singular values of the inverse, for columns of length 1:
        /// bounds the loss of accuracy in units of rounding.
        const SPREAD: f64 = 100.0;
        let (width, count) = (range.len(), self.kept.len());
        let mut l = inner.gram(panel.rb().subcols(range.start, width))?;
        let mut inverse = zeros(width, width)?;
        (0..width).for_each(|j| inverse[(j, j)] = l[(j, j)].sqrt());
        let lengths: Vec<f64> = (0..width).map(|j| inverse[(j, j)]).collect();
        if cholesky(l.as_mut())?.is_err() {
            return Ok(false);
        }
        lower_solve_in_place(l.as_ref(), inverse.as_mut());
        let kept = (0..width).all(|j| l[(j, j)] > limits[range.start + j]);
        if !(kept && inverse.squared_norm_l2() <= SPREAD * width as f64) {
            return Ok(false);
        }
        for j in 0..width {
            inverse.as_mut().col_mut(j).iter_mut().for_each(|x| *x /= lengths[j]);
        }
        let block = panel.rb_mut().subcols_mut(range.start, width);
        multiply_in_place(block, inverse.transpose(), inner.par())?;
        for j in 0..width {
            if count < range.start {
                scaled_move(panel.rb_mut(), range.start + j, 1.0, count + j);
            }
            (0..=j).for_each(|i| self.r[(count + i, range.start + j)] = l[(j, i)]);
            self.kept.push(range.start + j);
            self.lengths.push(l[(j, j)]);
        }
        Ok(true)
    }

    fn leaf(
        &mut self,
        inner: &mut Inner<'_>,
        mut panel: MatMut<'_, f64>,
        limits: &[f64],
        range: Range<usize>,
    ) -> Result<()> {
        let first = self.kept.len();
        for j in range {
            let count = self.kept.len();
            for q in first..count {
                let overlap = inner.overlap(panel.rb(), q, j)?;
                self.r[(q, j)] = overlap;
                add_multiple(panel.rb_mut(), j, -overlap, q);
            }
            let length = inner.lengths(panel.rb().subcols(j, 1))?[0];
            if length > limits[j] {
                scaled_move(panel.rb_mut(), j, length.recip(), count);
                self.r[(count, j)] = length;
                self.kept.push(j);
                self.lengths.push(length);
            } else {
                self.dropped.push((j, length));
            }
        }
        Ok(())
    }
}

/// Adds a multiple of column q to column j, `q < j`.
fn add_multiple(x: MatMut<'_, f64>, j: usize, factor: f64, q: usize) {
    let (left, right) = x.split_at_col_mut(j);
    let (from, to) = (left.rb().col(q), right.col_mut(0));
    to.iter_mut().zip(from.iter()).for_each(|(to, from)| *to += factor * from);
}

/// Writes a multiple of column j to column `to <= j`.
fn scaled_move(x: MatMut<'_, f64>, j: usize, factor: f64, to: usize) {
    if to == j {
        return x.col_mut(j).iter_mut().for_each(|x| *x *= factor);
    }
    let (left, right) = x.split_at_col_mut(j);
    let (from, to) = (right.rb().col(0), left.col_mut(to));
    to.iter_mut().zip(from.iter()).for_each(|(to, from)| *to = factor * from);
}
