use super::blocks::Blocks;
use super::bricks::Bricks;
use super::chunks::Chunks;
use super::segment::Segment;

/// Which rank holds which entries of the lower triangle of C, each exactly once.
///
/// A rank keeps its entries one after another, in the order of [`TriangleLayout::segments`]. With
/// the layout alone they can be gathered, redistributed or multiplied without further
/// communication.
///
/// ```
/// use catamaran::base::triangle_len;
/// use catamaran::ranks::plan::{Blocks, Chunks, TriangleLayout};
///
/// // 10 columns on 3 ranks: every entry of the lower triangle is on one rank.
/// let (chunks, blocks) = (Chunks::new(50, 10, 3), Blocks::new(&[4, 3, 3]));
/// for layout in [TriangleLayout::Chunks(chunks), TriangleLayout::Blocks(blocks)] {
///     assert_eq!((0..3).map(|rank| layout.len(rank)).sum::<usize>(), triangle_len(10));
/// }
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TriangleLayout {
    /// Ranges of the packed triangle.
    Chunks(Chunks),
    /// Rectangular blocks and triangles on the diagonal.
    Blocks(Blocks),
    /// Such blocks, each cut evenly over several ranks.
    Bricks(Bricks),
}

impl TriangleLayout {
    /// Returns the number of rows, and of columns, of C.
    pub fn n(&self) -> usize {
        match self {
            Self::Chunks(chunks) => chunks.n(),
            Self::Blocks(blocks) => blocks.n(),
            Self::Bricks(bricks) => bricks.n(),
        }
    }

    /// Returns the number of ranks.
    pub fn ranks(&self) -> usize {
        match self {
            Self::Chunks(chunks) => chunks.ranks(),
            Self::Blocks(blocks) => blocks.ranks(),
            Self::Bricks(bricks) => bricks.ranks(),
        }
    }

    /// Returns the segments that `rank` holds, in the order in which it keeps them.
    pub fn segments(&self, rank: usize) -> Box<dyn Iterator<Item = Segment> + '_> {
        match self {
            Self::Chunks(chunks) => Box::new(chunks.segments(rank)),
            Self::Blocks(blocks) => Box::new(blocks.segments(rank)),
            Self::Bricks(bricks) => Box::new(bricks.segments(rank)),
        }
    }

    /// Returns the number of entries that `rank` holds.
    pub fn len(&self, rank: usize) -> usize {
        match self {
            Self::Chunks(chunks) => chunks.len(rank),
            Self::Blocks(blocks) => blocks.len(rank),
            Self::Bricks(bricks) => bricks.len(rank),
        }
    }
}
