//! What is multiplied, and where the product goes.

use std::ops::Range;

use faer::{MatMut, MatRef};

use super::generic::{Stream, line_len};
use crate::base::{Disjoint, Real, SharedPtr};

/// A signed block: one term of the sum that is packed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Source<'a, T> {
    pub coefficient: T,
    pub matrix: MatRef<'a, T>,
    /// What each column is multiplied by: powers of two, so that nothing is rounded.
    pub scale: Option<&'a [T]>,
}

/// Which entries of C exist for us.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    All,
    /// On and below the diagonal.
    Lower,
    /// On and above the diagonal.
    Upper,
}

/// A block of C that receives `C := beta C + coefficient product`, as much of the product as fits.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Target<T> {
    pub coefficient: T,
    pub beta: T,
    pub rows: usize,
    pub cols: usize,
    pub row_stride: isize,
    pub col_stride: isize,
    pub part: Part,
    /// Row less column of the block's corner in C: where the diagonal runs.
    pub diagonal: isize,
    start: SharedPtr<T>,
    /// What rows and columns of the product are divided by, having been scaled in the sources.
    scales: Option<Scales<T>>,
}

/// Powers of two, one for each row and column of a target, which keeps them alive.
#[derive(Debug, Clone, Copy)]
struct Scales<T> {
    rows: SharedPtr<T>,
    cols: SharedPtr<T>,
}

/// A matrix, to take targets from: they may overlap, the products that write them are in order.
pub(crate) struct Destination<'a, T> {
    matrix: Disjoint<'a, T>,
    part: Part,
    scales: Option<(&'a [T], &'a [T])>,
}

impl<'a, T: Real> Destination<'a, T> {
    pub fn new(matrix: MatMut<'a, T>, part: Part) -> Self {
        Self { matrix: Disjoint::new(matrix), part, scales: None }
    }

    /// Divides rows and columns of products by these powers of two.
    pub fn unscaling(mut self, rows: &'a [T], cols: &'a [T]) -> Self {
        assert_eq!((rows.len(), cols.len()), (self.matrix.nrows(), self.matrix.ncols()));
        self.scales = Some((rows, cols));
        self
    }

    /// The block of these rows and columns.
    pub fn block(
        &self,
        rows: Range<usize>,
        cols: Range<usize>,
        coefficient: T,
        beta: T,
    ) -> Target<T> {
        // Read only; the type is for its address.
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
    /// The columns of row `i` that are wanted.
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

    /// The columns wanted of any row of `rows`.
    #[inline(always)]
    pub fn wanted_of(&self, rows: Range<usize>) -> Range<usize> {
        let end = rows.end.min(self.rows);
        if rows.start >= end {
            return 0..0;
        }
        let (first, last) = (self.wanted(rows.start), self.wanted(end - 1));
        first.start.min(last.start)..first.end.max(last.end)
    }

    /// Whether all of these entries are wanted.
    #[inline(always)]
    pub fn wants_all(&self, rows: Range<usize>, cols: Range<usize>) -> bool {
        let inside = rows.end <= self.rows && cols.end <= self.cols;
        let corner = |i: usize, j: usize| i as isize + self.diagonal - j as isize;
        inside
            && match self.part {
                Part::All => true,
                Part::Lower => corner(rows.start, cols.end) >= -1,
                Part::Upper => corner(rows.end, cols.start) <= 1,
            }
    }

    /// Whether rows of it are written as they are.
    #[inline(always)]
    pub fn is_plain(&self) -> bool {
        self.col_stride == 1 && self.scales.is_none()
    }

    /// `sum`, entry `(i, j)` of the product, less the scales.
    #[inline(always)]
    pub fn unscaled(&self, i: usize, j: usize, sum: T) -> T
    where
        T: Real,
    {
        match self.scales {
            // SAFETY: entry (i, j) is inside the target, and the scales are those of its extents.
            Some(s) => unsafe { sum / *s.rows.at(i as isize) / *s.cols.at(j as isize) },
            None => sum,
        }
    }

    /// The address of entry `(i, j)`.
    #[inline(always)]
    pub fn at(&self, i: usize, j: usize) -> *mut T {
        self.start.at(i as isize * self.row_stride + j as isize * self.col_stride)
    }

    /// What writing a tile of `height` x `width` at `(row, col)` will read.
    #[inline(always)]
    pub fn stream(&self, height: usize, width: usize, row: usize, col: usize) -> Stream<T> {
        let lines = if self.col_stride == 1 { width.div_ceil(line_len::<T>()) + 1 } else { 0 };
        Stream { start: self.at(row, col), stride: self.row_stride, count: height, lines }
    }

    /// The same block, whose entries have a first product.
    pub fn accumulating(self) -> Self
    where
        T: Real,
    {
        Self { beta: T::ONE, ..self }
    }

    /// The same block of the transposed matrix.
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

/// `targets += (sum left)^T (sum right)`, over all rows of the sources.
#[derive(Debug, Clone)]
pub(crate) struct Product<'a, T> {
    /// The columns are rows of the product; `shape` says how many.
    pub left: Vec<Source<'a, T>>,
    /// Empty when it is the same as the left side.
    pub right: Vec<Source<'a, T>>,
    pub targets: Vec<Target<T>>,
    pub shape: Shape,
}

/// Extents of a product: what a source or a target lacks counts as zero, or is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Shape {
    /// Rows of the sources.
    pub depth: usize,
    /// Rows of the product.
    pub rows: usize,
    /// Columns of the product.
    pub cols: usize,
    /// One side serves as both.
    pub same: bool,
}

impl<T: Real> Product<'_, T> {
    /// The same for the transposed targets.
    pub fn transposed(self) -> Self {
        let Self { left, right, targets, shape } = self;
        let (left, right) = if shape.same { (left, right) } else { (right, left) };
        let targets = targets.into_iter().map(Target::transposed).collect();
        Self { left, right, targets, shape: Shape { rows: shape.cols, cols: shape.rows, ..shape } }
    }
}
