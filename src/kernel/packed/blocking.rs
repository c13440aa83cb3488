//! How the work on a product is cut: what stays in which cache. The depth and the chunk decide on
//! sums, so they depend on the shape alone; the rest may depend on the machine.

use super::geometry::Geometry;
use super::operands::Shape;
use crate::base::data_caches;

/// Extents of the pieces of a product.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Blocking {
    /// Rows of the sources that a tile takes without a pause: the left side of a row of tiles stays
    /// in the first-level cache, and sums stay short.
    pub depth: usize,
    /// Panels along each side of an item, the piece of a product that one thread takes: its sums
    /// and its right side stay in the second-level cache.
    pub panels: usize,
    /// Rows of the sources that are packed at a time.
    pub chunk: usize,
}

/// The most rows that a tile takes without a pause.
pub(super) const DEPTH: usize = 320;

/// Items along the longer side, at least, if there are as many panels: work for several threads.
const PARTS: usize = 5;

impl Blocking {
    /// Chooses the extents for a product of this shape, packed into at most `budget` scalars if
    /// that is possible.
    pub fn new(geometry: Geometry, scalar_bytes: usize, shape: Shape, budget: usize) -> Self {
        // Pieces of equal length, as short ones are slow.
        let even = |length: usize, most: usize| length.div_ceil(length.div_ceil(most).max(1));
        let depth = even(shape.depth, DEPTH).max(1);
        let longest = shape.rows.max(shape.cols).div_ceil(geometry.width);
        let panels = item_side(scalar_bytes) / geometry.width;
        let panels = panels.min(longest.div_ceil(PARTS)).max(1);
        let blocks = shape.depth.div_ceil(depth).max(1);
        let most = budget / Self::packed_columns(geometry, shape).max(1) / depth;
        Self { depth, panels, chunk: even(blocks, most.max(1)) * depth }
    }

    /// Columns of both sides, whole panels.
    pub fn packed_columns(geometry: Geometry, shape: Shape) -> usize {
        let left = shape.rows.next_multiple_of(geometry.width);
        let right = if shape.same { 0 } else { shape.cols.next_multiple_of(geometry.width) };
        left + right
    }

    /// Scalars that a chunk is packed into.
    pub fn packed_len(&self, geometry: Geometry, shape: Shape) -> usize {
        self.chunk.min(shape.depth) * Self::packed_columns(geometry, shape)
    }

    /// Scalars of the sums of an item: those of one tile where no block of rows follows another.
    pub fn sums_len(&self, geometry: Geometry) -> usize {
        let side = self.panels * geometry.width;
        if self.chunk <= self.depth { geometry.rows * geometry.width } else { side * side }
    }

    /// Chunks of a product: at least one.
    pub fn chunks(&self, shape: Shape) -> usize {
        shape.depth.div_ceil(self.chunk).max(1)
    }
}

/// Side of an item whose sums and right side, `s (s + DEPTH)` scalars, leave an eighth of the
/// second-level cache to the left side.
fn item_side(scalar_bytes: usize) -> usize {
    let [_, cache] = data_caches();
    let (scalars, half) = (cache / 8 * 7 / scalar_bytes, DEPTH / 2);
    (scalars + half * half).isqrt() - half
}
