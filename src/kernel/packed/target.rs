//! The targets of products: blocks of a matrix.

use std::ops::Range;

use faer::MatMut;

use super::vectors::low_bits;
use crate::base::{Disjoint, Real, SharedPtr};

/// The part of C that is wanted; other entries are neither read nor written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    All,
    /// On and below the diagonal.
    Lower,
    /// On and above the diagonal.
    Upper,
}

/// A block of C that receives `C := beta C + coefficient product`. Entries of the product outside
/// the block are dropped.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Target<T> {
    pub coefficient: T,
    pub beta: T,
    pub rows: usize,
    pub cols: usize,
    pub row_stride: isize,
    pub col_stride: isize,
    pub part: Part,
    /// Row minus column, in C, of the first entry of the block: the position of the diagonal.
    pub diagonal: isize,
    start: SharedPtr<T>,
    /// Divisors of the rows and columns of the product, by which its sources were multiplied.
    scales: Option<Scales<T>>,
}

/// Powers of two, one for each row and column of a target; borrowed by its [`Destination`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Scales<T> {
    pub rows: SharedPtr<T>,
    pub cols: SharedPtr<T>,
}

impl<T> Scales<T> {
    /// Returns the scales from this row and column on.
    #[inline(always)]
    pub fn at(self, row: usize, col: usize) -> Self {
        let from = |scales: SharedPtr<T>, i: usize| SharedPtr::new(scales.at(i as isize));
        Self { rows: from(self.rows, row), cols: from(self.cols, col) }
    }
}

/// The columns of a tile that are wanted, relative to its first column: between two diagonals and
/// the end of the target.
#[derive(Debug, Clone, Copy)]
pub(super) struct WantedColumns {
    /// First column of row 0; each row begins one column later.
    first: isize,
    /// End of row 0; each row ends one column later.
    limit: isize,
    /// Upper bound on the end of every row.
    end: isize,
}

impl WantedColumns {
    /// Returns the wanted columns of row `i` of the tile.
    #[inline(always)]
    pub fn of_row(self, i: usize) -> Range<usize> {
        let i = i as isize;
        let end = (self.limit + i).clamp(0, self.end);
        (self.first + i).clamp(0, end) as usize..end as usize
    }

    /// Returns a mask with one bit for each wanted column of row `i`.
    #[inline(always)]
    pub fn bits_of_row(self, i: usize) -> u64 {
        let wanted = self.of_row(i);
        low_bits(wanted.end) - low_bits(wanted.start)
    }
}

/// A matrix that targets are taken from. Targets may overlap, since products run one after
/// another.
pub(crate) struct Destination<'a, T> {
    matrix: Disjoint<'a, T>,
    part: Part,
    scales: Option<(&'a [T], &'a [T])>,
}

impl<'a, T: Real> Destination<'a, T> {
    /// Creates a destination of which only `part` is written.
    pub fn new(matrix: MatMut<'a, T>, part: Part) -> Self {
        Self { matrix: Disjoint::new(matrix), part, scales: None }
    }

    /// Divides rows and columns of products by these powers of two, the scales of the sources
    /// ([`super::Source`]); division by infinity gives zero.
    ///
    /// # Panics
    /// Unless there is one scale for each row and column.
    pub fn unscaling(mut self, rows: &'a [T], cols: &'a [T]) -> Self {
        assert_eq!((rows.len(), cols.len()), (self.matrix.nrows(), self.matrix.ncols()));
        self.scales = Some((rows, cols));
        self
    }

    /// Returns the target for the block of these rows and columns.
    #[inline]
    pub fn block(
        &self,
        rows: Range<usize>,
        cols: Range<usize>,
        coefficient: T,
        beta: T,
    ) -> Target<T> {
        // Never written, although the pointer is mutable.
        let scale = |s: &[T]| SharedPtr::new(s.as_ptr().cast_mut());
        Target {
            coefficient,
            beta,
            rows: rows.len(),
            cols: cols.len(),
            row_stride: self.matrix.row_stride(),
            col_stride: self.matrix.col_stride(),
            part: self.part,
            diagonal: rows.start as isize - cols.start as isize,
            start: self.matrix.pointer(&rows, &cols),
            scales: self
                .scales
                .map(|(r, c)| Scales { rows: scale(&r[rows]), cols: scale(&c[cols]) }),
        }
    }
}

impl<T> Target<T> {
    /// Returns the columns of row `i` that are wanted.
    #[inline(always)]
    pub fn wanted(&self, i: usize) -> Range<usize> {
        let cols = self.cols as isize;
        let diagonal = (i as isize + self.diagonal).clamp(-1, cols);
        match self.part {
            Part::All => 0..self.cols,
            Part::Lower => 0..(diagonal + 1).min(cols) as usize,
            Part::Upper => diagonal.max(0) as usize..self.cols,
        }
    }

    /// Returns the columns that any row of `rows` wants, from the first to the last; `0..0` if none
    /// is wanted, so that no tile is computed.
    #[inline(always)]
    pub fn wanted_of(&self, rows: Range<usize>) -> Range<usize> {
        let end = rows.end.min(self.rows);
        if rows.start >= end {
            return 0..0;
        }
        let (first, last) = (self.wanted(rows.start), self.wanted(end - 1));
        let wanted = first.start.min(last.start)..first.end.max(last.end);
        if wanted.is_empty() { 0..0 } else { wanted }
    }

    /// Returns the wanted columns of each row of a tile with this corner and width.
    #[inline(always)]
    pub(super) fn columns_from(&self, row: usize, col: usize, width: usize) -> WantedColumns {
        let diagonal = row as isize + self.diagonal - col as isize;
        let end = (self.cols.saturating_sub(col)).min(width) as isize;
        let (first, limit) = match self.part {
            Part::All => (isize::MIN / 2, isize::MAX / 2),
            Part::Lower => (isize::MIN / 2, diagonal + 1),
            Part::Upper => (diagonal, isize::MAX / 2),
        };
        WantedColumns { first, limit, end }
    }

    /// Returns whether all of these entries are wanted, without scales and row by row.
    #[inline(always)]
    pub(super) fn takes_whole(&self, rows: Range<usize>, cols: Range<usize>) -> bool {
        let inside = rows.end <= self.rows && cols.end <= self.cols;
        let corner = |i: usize, j: usize| i as isize + self.diagonal - j as isize;
        inside
            && self.is_plain()
            && match self.part {
                Part::All => true,
                Part::Lower => corner(rows.start, cols.end) >= -1,
                Part::Upper => corner(rows.end, cols.start) <= 1,
            }
    }

    /// Returns whether the rows of the block are contiguous and the block has no scales.
    #[inline(always)]
    pub(super) fn is_plain(&self) -> bool {
        self.col_stride == 1 && self.scales.is_none()
    }

    /// Returns the divisors of rows and columns, if any.
    #[inline(always)]
    pub(super) fn scales(&self) -> Option<Scales<T>>
    where
        T: Copy,
    {
        self.scales
    }

    /// Returns the address of entry `(i, j)`.
    #[inline(always)]
    pub fn at(&self, i: usize, j: usize) -> *mut T {
        self.start.at(i as isize * self.row_stride + j as isize * self.col_stride)
    }

    /// Returns the same block with beta 1, for products that are added to the first one.
    pub fn accumulating(self) -> Self
    where
        T: Real,
    {
        Self { beta: T::ONE, ..self }
    }

    /// Returns the same block of the transposed matrix.
    pub fn transposed(self) -> Self {
        Self {
            rows: self.cols,
            cols: self.rows,
            row_stride: self.col_stride,
            col_stride: self.row_stride,
            part: match self.part {
                Part::All => Part::All,
                Part::Lower => Part::Upper,
                Part::Upper => Part::Lower,
            },
            diagonal: -self.diagonal,
            scales: self.scales.map(|s| Scales { rows: s.cols, cols: s.rows }),
            ..self
        }
    }
}

/// Returns the columns of these rows that any target wants, from the first to the last.
pub(super) fn wanted_of<T>(targets: &[Target<T>], rows: Range<usize>) -> Range<usize> {
    let wanted = targets.iter().map(|t| t.wanted_of(rows.clone())).filter(|w| !w.is_empty());
    wanted.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)).unwrap_or(0..0)
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::*;

    /// Checks that empty ranges begin at 0: one further on made small products compute a tile
    /// beyond its memory.
    #[test]
    fn nothing_is_wanted_from_column_zero_on() {
        let mut c = Mat::<f32>::zeros(40, 40);
        for (part, rows, cols) in [(Part::Upper, 24..40, 0..16), (Part::Lower, 0..16, 24..40)] {
            let destination = Destination::new(c.as_mut(), part);
            let target = destination.block(rows, cols, 1.0, 0.0);
            assert_eq!(target.wanted_of(0..8), 0..0, "{part:?}");
            assert_eq!(target.wanted_of(8..16), 0..0, "{part:?}");
            assert_eq!(target.wanted_of(16..24), 0..0, "{part:?}");
        }
    }
}
