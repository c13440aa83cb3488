//! Triangular solves in double-double. Right-hand sides are kept by rows: column i of the
//! [`Columns`] is row i of X.

use std::ops::Range;

use super::cholesky::PivotedCholesky;
use super::columns::{Columns, LANES};
use super::double::DoubleDouble;
use crate::base::{Par, Result, widest};

/// Right-hand sides that one thread works on at a time: as many as the widest registers hold while
/// products are subtracted. Thousands of rows of so many stay in the second-level cache.
const BLOCK: usize = 4 * LANES;

/// Rows that are subtracted from others at a time where the factor is read by rows: so many of its
/// columns are read side by side.
const SIDE_BY_SIDE: usize = 32;

/// Operations that a product takes in twice the precision, and the difference with it.
const SUBTRACTED: f64 = 20.0;

/// Returns the operations that a block of right-hand sides takes, for this many rows.
fn operations(rows: usize) -> f64 {
    0.5 * SUBTRACTED * (BLOCK * rows * rows).max(1) as f64
}

impl PivotedCholesky {
    /// Computes `X := R^-T X`, for the first `rank` rows and columns of the scaled R; X has at
    /// least as many rows. The result is the same for every `par`, bit for bit.
    pub(super) fn solve_transposed(&self, x: &mut Columns<2>, par: Par) -> Result<()> {
        by_blocks(
            x,
            par,
            #[inline(always)]
            |x| {
                for first in (0..self.rank).step_by(SIDE_BY_SIDE) {
                    let end = self.rank.min(first + SIDE_BY_SIDE);
                    for i in first..self.rank {
                        let (before, mut row, _) = x.around(i, 0);
                        row.subtract(
                            before.starting(0, first),
                            i.min(end) - first,
                            #[inline(always)]
                            |k| self.lower.double(i, first + k),
                        );
                        if i < end {
                            self.divide(x, i);
                        }
                    }
                }
            },
        )
    }

    /// Computes `X := R^-1 X`, as [`PivotedCholesky::solve_transposed`].
    pub(super) fn solve(&self, x: &mut Columns<2>, par: Par) -> Result<()> {
        by_blocks(
            x,
            par,
            #[inline(always)]
            |x| self.substitute(x, self.rank),
        )
    }

    /// Computes `X := R^-1 X` for an X of which only the first `rows` rows are not zero.
    #[inline(always)]
    fn substitute(&self, x: &mut Columns<2>, rows: usize) {
        for j in (0..rows).rev() {
            let (_, mut row, behind) = x.around(j, 0);
            row.subtract(
                behind,
                rows - j - 1,
                #[inline(always)]
                |k| self.lower.double(j + 1 + k, j),
            );
            self.divide(x, j);
        }
    }

    #[inline(always)]
    fn divide(&self, x: &mut Columns<2>, j: usize) {
        let mut row = x.pairs_mut(j, 0);
        row.normalize();
        row.scale(DoubleDouble::ONE / self.lower.double(j, j));
    }

    /// Computes `X := C^-1 X` for a matrix C in its own order and scale, of full rank.
    pub(super) fn solve_symmetric(&self, x: &mut Columns<2>, par: Par) -> Result<()> {
        self.rescale(x);
        self.solve_transposed(x, par)?;
        self.solve(x, par)?;
        self.rescale(x);
        Ok(())
    }

    /// Divides row i of X by the scale of the i-th column.
    pub(super) fn rescale(&self, x: &mut Columns<2>) {
        for (i, &column) in self.order[..x.cols].iter().enumerate() {
            for q in 0..x.rows {
                x.set_double(q, i, x.double(q, i).scaled(-self.exponents[column]));
            }
        }
    }

    /// Returns `R^-1` of the first `rank` rows and columns of the scaled R, by rows.
    pub(super) fn inverse(&self, par: Par) -> Result<Columns<2>> {
        let mut inverse = Columns::new(self.rank, self.rank)?;
        let blocks = par.map_blocks_asking(self.rank, BLOCK, operations(self.rank), |cols| {
            let mut x = Columns::new(cols.len(), cols.end)?;
            for j in cols.clone() {
                x.set_double(j - cols.start, j, DoubleDouble::ONE);
            }
            widest(
                #[inline(always)]
                || self.substitute(&mut x, cols.end),
            );
            Ok((cols, x))
        })?;
        for block in blocks {
            let (cols, x) = block?;
            copy_into(&mut inverse, &x, &cols);
        }
        Ok(inverse)
    }
}

/// Copies the right-hand sides `cols` back.
fn copy_into(x: &mut Columns<2>, block: &Columns<2>, cols: &Range<usize>) {
    for (part, from) in x.parts.iter_mut().zip(&block.parts) {
        let from = from.chunks(block.stride.max(1));
        for (row, from) in part.chunks_mut(x.stride.max(1)).zip(from) {
            row[cols.clone()].copy_from_slice(&from[..cols.len()]);
        }
    }
}

/// Calls `work` for blocks of right-hand sides.
fn by_blocks(x: &mut Columns<2>, par: Par, work: impl Fn(&mut Columns<2>) + Sync) -> Result<()> {
    let solved = par.map_blocks_asking(x.rows, BLOCK, operations(x.cols), |cols| {
        let mut block = Columns::new(cols.len(), x.cols)?;
        for (part, from) in block.parts.iter_mut().zip(&x.parts) {
            let from = from.chunks(x.stride);
            for (row, from) in part.chunks_mut(block.stride).zip(from) {
                row[..cols.len()].copy_from_slice(&from[cols.clone()]);
            }
        }
        widest(
            #[inline(always)]
            || work(&mut block),
        );
        Ok((cols, block))
    })?;
    for block in solved {
        let (cols, block) = block?;
        copy_into(x, &block, &cols);
    }
    Ok(())
}
