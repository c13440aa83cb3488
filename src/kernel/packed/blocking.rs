//! How the work on a product is cut: what stays in which cache.

use super::{Geometry, Shape};

/// Extents of the pieces of a product.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Blocking {
    /// Rows of the sources that a tile takes without a pause: a third of a tile's operands has to
    /// stay in the first-level cache.
    pub depth: usize,
    /// Panels along each side of an item, the piece of a product that one thread takes: its sums and
    /// its right side stay in the second-level cache.
    pub panels: usize,
    /// Rows of the sources that are packed at a time.
    pub chunk: usize,
}

/// Rows of the sources that a tile takes without a pause.
const DEPTH: usize = 256;

/// Items along the longer side, at least, if there are as many panels.
const PARTS: usize = 5;

/// Bytes of the second-level cache that the pieces are made for.
const CACHE: usize = 2 << 20;

impl Blocking {
    /// For a product of this shape, packed into at most `budget` scalars if that is possible.
    pub fn new(geometry: Geometry, scalar_bytes: usize, shape: Shape, budget: usize) -> Self {
        // Pieces of equal length, as short ones are slow.
        let even = |length: usize, most: usize| length.div_ceil(length.div_ceil(most).max(1));
        let env=|n:&str,d:usize| std::env::var(n).ok().and_then(|v|v.parse().ok()).unwrap_or(d);
 let budget=env("BUDGET",budget);        let depth = even(shape.depth, env("DEPTH",DEPTH)).max(1);
        // The right panels and the sums of an item take half of the cache: s (s + DEPTH) scalars.
        let scalars = (CACHE / 2 / scalar_bytes) as f64;
        let half = DEPTH as f64 / 2.0;
        let side = (scalars + half * half).sqrt() - half;
        let longest = shape.rows.max(shape.cols).div_ceil(geometry.width);
        // Enough items for several threads, whatever their number.
        let panels = (side as usize / geometry.width).min(longest.div_ceil(PARTS)).max(1);
        let panels = env("PANELS",panels);
        let width = Self::packed_columns(geometry, shape).max(1);
        let blocks = (budget / width / depth).max(1);
        let chunks = shape.depth.div_ceil(blocks * depth).max(1);
        let chunk = shape.depth.div_ceil(depth).div_ceil(chunks) * depth;
        Self { depth, panels, chunk: chunk.min(shape.depth) }
    }

    /// Columns of both sides, whole panels.
    pub fn packed_columns(geometry: Geometry, shape: Shape) -> usize {
        let left = shape.rows.next_multiple_of(geometry.width);
        let right = if shape.same { 0 } else { shape.cols.next_multiple_of(geometry.width) };
        left + right
    }

    /// Scalars that a chunk is packed into.
    pub fn packed_len(&self, geometry: Geometry, shape: Shape) -> usize {
        self.chunk * Self::packed_columns(geometry, shape)
    }
}
