//! The operands and extents of products.

use faer::MatRef;

use super::geometry::Geometry;
use super::target::Target;
use super::tile::Side;
use crate::base::Real;

/// A signed block: one term of the sum that is packed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Source<'a, T> {
    pub coefficient: T,
    pub matrix: MatRef<'a, T>,
    /// Factors of the columns: powers of two, so that nothing is rounded.
    pub scale: Option<&'a [T]>,
}

impl<T: Real> Source<'_, T> {
    /// Returns whether tiles can read the block in place: it has at least `depth` rows of at least
    /// `width` contiguous entries, a coefficient of 1 and no scale.
    pub fn is_plain(&self, depth: usize, width: usize) -> bool {
        let Self { coefficient, matrix, scale } = self;
        let complete = matrix.nrows() >= depth && matrix.ncols() >= width;
        complete && matrix.col_stride() == 1 && *coefficient == T::ONE && scale.is_none()
    }

    /// Returns the side that tiles read in place from the matrix, from `first_row` on, in panels of
    /// `width` columns.
    pub fn in_place(&self, first_row: usize, width: usize) -> Side<T> {
        Side {
            start: self
                .matrix
                .as_ptr()
                .wrapping_offset(first_row as isize * self.matrix.row_stride()),
            row_stride: self.matrix.row_stride(),
            panel_stride: width,
        }
    }
}

/// `targets += (sum left)^T (sum right)`, over all rows of the sources.
#[derive(Debug, Clone)]
pub(crate) struct KernelProduct<'a, T> {
    /// Sources whose columns are the rows of the product; `shape` gives their number.
    pub left: Vec<Source<'a, T>>,
    /// Sources of the right side; empty if it is the same as the left side.
    pub right: Vec<Source<'a, T>>,
    pub targets: Vec<Target<T>>,
    pub shape: Shape,
}

/// Extents of a product. Entries that a source lacks are zero; entries that a target lacks are
/// dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Shape {
    /// Rows of the sources.
    pub depth: usize,
    /// Rows of the product.
    pub rows: usize,
    /// Columns of the product.
    pub cols: usize,
    /// Whether the left side is also the right side.
    pub same: bool,
}

impl<'a, T: Real> KernelProduct<'a, T> {
    /// Returns the sources of the left (0) or right (1) side.
    pub fn sources(&self, side: usize) -> &[Source<'a, T>] {
        if side == 0 || self.shape.same { &self.left } else { &self.right }
    }

    /// Returns whether tiles read both sides in place.
    pub fn in_place(&self, geometry: Geometry) -> bool {
        let Shape { depth, rows, cols, .. } = self.shape;
        let plain = |side, width| matches!(self.sources(side), [s] if s.is_plain(depth, width));
        let most = geometry.tuning.in_place * geometry.width;
        plain(0, rows) && plain(1, cols) && rows.max(cols) <= most
    }
}

impl<T: Real> KernelProduct<'_, T> {
    /// Returns the same product for the transposed targets.
    pub fn transposed(self) -> Self {
        let Self { left, right, targets, shape } = self;
        let (left, right) = if shape.same { (left, right) } else { (right, left) };
        let targets = targets.into_iter().map(Target::transposed).collect();
        Self { left, right, targets, shape: Shape { rows: shape.cols, cols: shape.rows, ..shape } }
    }
}
