//! Extents of tiles, of pieces of matrices and of cache lines.

use std::ops::Range;

use super::tuning::Tuning;

/// The extents of a kernel's tiles, and the constants of the loops around them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Geometry {
    /// Scalars of a vector.
    pub lanes: usize,
    /// Rows of a tile; a divisor of the width.
    pub rows: usize,
    /// Columns of a tile, and of a panel.
    pub width: usize,
    pub tuning: &'static Tuning,
}

/// Ranges of rows and columns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Area {
    pub rows: Range<usize>,
    pub cols: Range<usize>,
}

/// Returns the i-th piece of `range`, cut into pieces of `length`.
pub(super) fn piece(range: &Range<usize>, i: usize, length: usize) -> Range<usize> {
    let start = range.start + i * length;
    start..range.end.min(start + length)
}

/// Bytes of a cache line.
pub(super) const CACHE_LINE: usize = 64;

/// Returns the number of scalars of a cache line.
pub(super) const fn line_len<T>() -> usize {
    CACHE_LINE / size_of::<T>()
}
