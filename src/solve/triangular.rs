//! Triangular solves in double-double. Right-hand sides are kept by rows: column i of the
//! [`Columns`] is row i of X.

use std::ops::Range;

use super::cholesky::PivotedCholesky;
use super::columns::{Columns, LANES};
use super::double::DoubleDouble;
use crate::base::{PIECE, Par, Result, widest};

/// Most right-hand sides that one thread works on at a time.
const BLOCK: usize = 64;

/// Operations that a product takes in twice the precision, and the difference with it.
const SUBTRACTED: f64 = 20.0;

/// Returns how many right-hand sides a thread works on at a time, and the operations that it takes,
/// for this many rows.
fn block(rows: usize) -> (usize, f64) {
    let each = 0.5 * SUBTRACTED * (rows * rows).max(1) as f64;
    let width = ((PIECE as f64 / each) as usize / LANES * LANES).clamp(LANES, BLOCK);
    (width, width as f64 * each)
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
                for j in 0..self.rank {
                    self.divide(x, j);
                    for i in j + 1..self.rank {
                        let (read, mut write) = x.two(j, i, 0);
                        write.subtract(read, self.lower.double(i, j));
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
            for i in j + 1..rows {
                let (read, mut write) = x.two(i, j, 0);
                write.subtract(read, self.lower.double(i, j));
            }
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
        let (width, operations) = block(self.rank);
        let blocks = par.map_blocks_asking(self.rank, width, operations, |cols| {
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
    const { assert!(BLOCK.is_multiple_of(LANES)) };
    let (width, operations) = block(x.cols);
    let solved = par.map_blocks_asking(x.rows, width, operations, |cols| {
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
