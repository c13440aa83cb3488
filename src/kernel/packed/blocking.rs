//! Cuts a product into pieces that stay in caches. The depth and the chunk determine how sums are
//! rounded, so they depend on the shape, the budget and the kernel only; the panels also depend on
//! the caches of the machine and on the number of threads.

use super::geometry::Geometry;
use super::operands::Shape;
use super::tuning::Tuning;
use crate::base::data_caches;

/// Extents of the pieces of a product.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Blocking {
    /// Rows of the sources that a tile sums in registers, at most [`Tuning::depth`].
    pub depth: usize,
    /// Panels along each side of an item, the piece of a product that one thread takes. The sums
    /// and the right side of an item stay in the second-level cache.
    pub panels: usize,
    /// Rows of the sources that are packed at a time.
    pub chunk: usize,
}

/// Items to aim for along the longer side, at least.
const PARTS: usize = 5;

/// Items of a triangle to aim for, for each thread, so that threads end at about the same time.
const SHARE: usize = 4;

impl Blocking {
    /// Chooses the extents for a product of this shape on `threads` threads, packed into at most
    /// `budget` scalars if one block of `depth` rows fits.
    pub fn new(
        geometry: Geometry,
        scalar_bytes: usize,
        shape: Shape,
        budget: usize,
        threads: usize,
    ) -> Self {
        // Pieces of about equal length, since short ones are slow.
        let even = |length: usize, most: usize| length.div_ceil(length.div_ceil(most).max(1));
        let depth = even(shape.depth, geometry.tuning.depth).max(1);
        let longest = shape.rows.max(shape.cols).div_ceil(geometry.width);
        let parts = (2 * SHARE * threads).isqrt().max(PARTS);
        let most = item_side(geometry.tuning, scalar_bytes) / geometry.width;
        let panels = match threads {
            // Nobody to share with: a product that fits is one item, which reads a chunk once.
            1 if longest <= most => longest,
            _ => most.min(longest.div_ceil(parts)),
        };
        let panels = panels.max(1);
        let blocks = shape.depth.div_ceil(depth).max(1);
        let most = budget / Self::packed_columns(geometry, shape).max(1) / depth;
        Self { depth, panels, chunk: even(blocks, most.max(1)) * depth }
    }

    /// Returns the number of columns of both sides, padded to whole panels.
    pub fn packed_columns(geometry: Geometry, shape: Shape) -> usize {
        let left = shape.rows.next_multiple_of(geometry.width);
        let right = if shape.same { 0 } else { shape.cols.next_multiple_of(geometry.width) };
        left + right
    }

    /// Returns the number of scalars that a chunk is packed into.
    pub fn packed_len(&self, geometry: Geometry, shape: Shape) -> usize {
        self.chunk.min(shape.depth) * Self::packed_columns(geometry, shape)
    }

    /// Returns the number of scalars of the sums of an item, or of one tile if a chunk is a single
    /// block of rows.
    pub fn sums_len(&self, geometry: Geometry) -> usize {
        let side = self.panels * geometry.width;
        if self.chunk <= self.depth { geometry.rows * geometry.width } else { side * side }
    }

    /// Returns the number of chunks of a product, at least 1.
    pub fn chunks(&self, shape: Shape) -> usize {
        shape.depth.div_ceil(self.chunk).max(1)
    }
}

/// Returns the side of an item, in columns, whose sums and right side, `s (s + depth)` scalars, fit
/// their part of the second-level cache.
fn item_side(tuning: &Tuning, scalar_bytes: usize) -> usize {
    let [_, cache] = data_caches();
    let (scalars, half) = (cache / 8 * tuning.item / scalar_bytes, tuning.depth / 2);
    (scalars + half * half).isqrt() - half
}
