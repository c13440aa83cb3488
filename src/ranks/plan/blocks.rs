//! Each rank has some columns of A: blocks of them travel so that each pair meets on one rank.
//!
//! Rank p sees the column blocks `p + D mod P`, D a [`difference_cover`], and computes for every
//! difference one block of C (half of one for the difference P / 2, which two ranks see): all
//! compute the same, and receive `(|D| - 1) m n / P` words, `m n / sqrt(P)` for perfect covers,
//! which is the lower bound of the two-dimensional case. The triangle-block distribution of Al
//! Daas, Ballard, Grigori, Kumar and Rouse (2023) is the same with affine planes, for P = c (c + 1)
//! only.

use std::ops::Range;

use super::cover::difference_cover;
use super::segment::Segment;
use crate::base::triangle_len;

/// The lower triangle of C as blocks of the products of column blocks.
///
/// ```
/// use catamaran::base::triangle_len;
/// use catamaran::ranks::plan::Blocks;
///
/// let blocks = Blocks::new(&[4, 3, 3]);
/// assert_eq!(blocks.columns(1), 4..7);
/// // Every entry of the lower triangle is on one rank.
/// assert_eq!((0..3).map(|rank| blocks.len(rank)).sum::<usize>(), triangle_len(10));
/// // The first product of a rank is the triangle of its own columns.
/// assert!(blocks.products(2).next().is_some_and(|first| (first.left, first.right) == (2, 2)));
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Blocks {
    /// Where each rank's columns of A begin, and the end: from 0 to n.
    starts: Vec<usize>,
    cover: Vec<usize>,
    /// For the difference d, from 0 to P / 2: two residues of the cover with that difference.
    pairs: Vec<(usize, usize)>,
}

/// Rows of the block of C that is the product of the column blocks `left >= right`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BlockPair {
    /// Rank whose columns are the rows of the block.
    pub left: usize,
    /// Rank whose columns are the columns of the block; the same for a triangle on the diagonal.
    pub right: usize,
    /// Rows of C: all those of the block, or half of them.
    pub rows: Range<usize>,
}

impl Blocks {
    /// Creates the blocks when rank p has `widths[p]` columns of A.
    pub fn new(widths: &[usize]) -> Self {
        let ranks = widths.len();
        let mut starts = vec![0];
        for width in widths {
            starts.push(starts[starts.len() - 1] + width);
        }
        let cover = difference_cover(ranks);
        let mut pairs = vec![(0, 0); ranks / 2 + 1];
        for &a in &cover {
            for &b in &cover {
                let d = (b + ranks - a) % ranks;
                if 0 < d && d <= ranks / 2 {
                    pairs[d] = (a, b);
                }
            }
        }
        Self { starts, cover, pairs }
    }

    /// Returns the number of rows, and of columns, of C.
    pub fn n(&self) -> usize {
        self.starts[self.ranks()]
    }

    /// Returns the number of ranks.
    pub fn ranks(&self) -> usize {
        self.starts.len() - 1
    }

    /// Returns the columns of A that `rank` has at the start.
    pub fn columns(&self, rank: usize) -> Range<usize> {
        self.starts[rank]..self.starts[rank + 1]
    }

    /// Returns the ranks whose columns must be sent to `rank`, without `rank` itself.
    pub fn sources(&self, rank: usize) -> impl Iterator<Item = usize> + '_ {
        self.cover[1..].iter().map(move |c| (rank + c) % self.ranks()).filter(move |&r| r != rank)
    }

    /// Returns the ranks to which the columns of `rank` must be sent, without `rank` itself: the
    /// opposite direction of [`Blocks::sources`].
    ///
    /// ```
    /// use catamaran::ranks::plan::Blocks;
    ///
    /// let blocks = Blocks::new(&[2; 7]);
    /// assert_eq!(blocks.sources(0).count(), 2);
    /// for source in blocks.sources(0) {
    ///     assert!(blocks.destinations(source).any(|rank| rank == 0));
    /// }
    /// ```
    pub fn destinations(&self, rank: usize) -> impl Iterator<Item = usize> + '_ {
        let ranks = self.ranks();
        self.cover[1..].iter().map(move |c| (rank + ranks - c) % ranks).filter(move |&r| r != rank)
    }

    /// Returns the products that `rank` computes and holds, in order; the triangle on the diagonal
    /// comes first.
    pub fn products(&self, rank: usize) -> impl Iterator<Item = BlockPair> + '_ {
        let ranks = self.ranks();
        self.pairs.iter().enumerate().map(move |(d, &(a, b))| {
            let (x, y) = ((rank + a) % ranks, (rank + b) % ranks);
            let (left, right) = (x.max(y), x.min(y));
            let mut rows = self.columns(left);
            // Half way around, the ranks p and p + P/2 have the same pair, one of them in the
            // opposite order.
            if d > 0 && 2 * d == ranks {
                let middle = rows.start.midpoint(rows.end);
                rows = if x < y { rows.start..middle } else { middle..rows.end };
            }
            BlockPair { left, right, rows }
        })
    }

    /// Returns the number of entries of a product.
    fn product_len(&self, product: &BlockPair) -> usize {
        let rows = product.rows.len();
        let on_diagonal = product.left == product.right;
        if on_diagonal { triangle_len(rows) } else { rows * self.columns(product.right).len() }
    }

    pub(crate) fn segments(&self, rank: usize) -> impl Iterator<Item = Segment> {
        self.products(rank).flat_map(move |product| {
            let cols = self.columns(product.right);
            product
                .rows
                .map(move |row| Segment { row, cols: cols.start..cols.end.min(row + 1) })
                .filter(|segment| !segment.cols.is_empty())
        })
    }

    /// Returns the number of entries that `rank` holds.
    pub fn len(&self, rank: usize) -> usize {
        self.products(rank).map(|product| self.product_len(&product)).sum()
    }
}

/// Least number of rows that travel at once: products with fewer are slow.
const SHORTEST: usize = 256;

/// Returns the number of rows that travel at once, at least 1, when A is m x n and each rank sees
/// the columns of `seen` ranks.
pub(crate) fn piece_height(m: usize, n: usize, seen: usize) -> usize {
    // Two pieces of all that is seen are as much as m + n / 2 rows of the own columns: its share of
    // A and C.
    let height = (m + n / 2) / (2 * seen);
    // Several pieces, so that the transfer of one can overlap the product of another.
    height.min(m.div_ceil(4)).max(SHORTEST).next_multiple_of(64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_entry_belongs_to_one_rank_that_sees_its_columns() {
        for ranks in 1..=23 {
            let widths: Vec<usize> = (0..ranks).map(|r| [3, 0, 5, 1][r % 4]).collect();
            let blocks = Blocks::new(&widths);
            let mut seen = vec![0; triangle_len(blocks.n())];
            for rank in 0..ranks {
                let sources: Vec<usize> = blocks.sources(rank).chain([rank]).collect();
                for product in blocks.products(rank) {
                    assert!(sources.contains(&product.left) && sources.contains(&product.right));
                }
                let mut len = 0;
                for segment in blocks.segments(rank) {
                    assert!(segment.cols.end <= segment.row + 1);
                    for j in segment.cols {
                        seen[triangle_len(segment.row) + j] += 1;
                        len += 1;
                    }
                }
                assert_eq!(len, blocks.len(rank));
            }
            assert!(seen.iter().all(|&count| count == 1), "{ranks} ranks");
        }
    }

    #[test]
    fn sources_and_destinations_are_opposite() {
        for ranks in 1..=40 {
            let blocks = Blocks::new(&vec![1; ranks]);
            for rank in 0..ranks {
                for source in blocks.sources(rank) {
                    assert!(blocks.destinations(source).any(|d| d == rank));
                }
                assert_eq!(blocks.sources(rank).count(), blocks.destinations(rank).count());
            }
        }
    }

    #[test]
    fn work_is_even() {
        for ranks in 2..=64 {
            let blocks = Blocks::new(&vec![10; ranks]);
            let lens: Vec<usize> = (0..ranks).map(|r| blocks.len(r)).collect();
            assert!(lens.iter().all(|&len| len == lens[0]), "{ranks}: {lens:?}");
        }
    }
}
