//! Each rank has a brick of A, some rows of some columns: the three-dimensional distribution.
//!
//! Rows are cut into q slices, and columns into as many blocks as a slice has ranks. In each slice
//! the columns meet as in [`Blocks`]; the q sums of a part of C are reduced and scattered. With p
//! blocks of columns a rank receives `(|D| - 1) m n / (p q)` words of A and
//! `(1 - 1/q) n (n + 1) / (2 p)` sums, D a [`difference_cover`](super::difference_cover). This is
//! algorithm 3 of Al Daas, Ballard, Grigori, Kumar and Rouse (2023) with the lines of projective
//! planes and other cyclic covers in place of triangle blocks: there is one for any number of
//! ranks, all ranks of a slice have equal work, and each holds one piece of A. Triangle blocks need
//! up to 7 % fewer words on the numbers of ranks that they exist for.

use std::ops::Range;

use super::blocks::Blocks;
use super::chunks::rounds;
use super::cover::cover_len;
use super::segment::Segment;
use crate::base::{Error, Result, even_part, triangle_len};

/// The least share of the ranks that have a brick, as a quotient: the busiest rank computes at most
/// 8/7 of an even share.
const USED: (usize, usize) = (7, 8);

/// Bricks of A, m x n, and the parts of C that follow from them.
///
/// Slice s of the rows and block b of the columns belong to rank `s * columns + b`. Ranks beyond
/// the last brick have nothing of A and C.
///
/// ```
/// use catamaran::base::triangle_len;
/// use catamaran::ranks::plan::{Bricks, TriangleLayout};
///
/// // 17 ranks: three slices of five blocks, and two ranks without a brick.
/// let bricks = Bricks::new(17, 1000, 1000);
/// assert_eq!((bricks.slices(), bricks.blocks().ranks(), bricks.used()), (3, 5, 15));
/// assert_eq!((bricks.rows(6), bricks.columns(6)), (333..666, 200..400));
/// // Every entry of the lower triangle is on one rank.
/// let layout = TriangleLayout::Bricks(bricks);
/// assert_eq!((0..17).map(|rank| layout.len(rank)).sum::<usize>(), triangle_len(1000));
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bricks {
    ranks: usize,
    m: usize,
    slices: usize,
    blocks: Blocks,
}

impl Bricks {
    /// Creates the bricks for A m x n on `ranks >= 1` ranks with which a rank accesses the fewest
    /// words, its own and those it receives, while at least 7/8 of the ranks have a brick.
    pub fn new(ranks: usize, m: usize, n: usize) -> Self {
        let (columns, slices) = fewest_accessed(ranks, m, n);
        Self::on(ranks, (m, n), columns, slices)
    }

    /// Creates the bricks of `columns` blocks of columns and `slices` slices of rows.
    ///
    /// # Errors
    /// [`Error::Argument`] unless there are from 1 to `ranks` bricks.
    pub fn with_counts(
        ranks: usize,
        (m, n): (usize, usize),
        columns: usize,
        slices: usize,
    ) -> Result<Self> {
        let count = columns.saturating_mul(slices);
        if !(1..=ranks).contains(&count) {
            let why =
                format!("must be from 1 to {ranks}, one for a rank, are {columns} x {slices}");
            return Err(Error::Argument { what: "bricks", why });
        }
        Ok(Self::on(ranks, (m, n), columns, slices))
    }

    fn on(ranks: usize, (m, n): (usize, usize), columns: usize, slices: usize) -> Self {
        let widths: Vec<usize> = (0..columns).map(|b| even_part(0..n, columns, b).len()).collect();
        Self { ranks, m, slices, blocks: Blocks::new(&widths) }
    }

    /// Returns the number of rows of A.
    pub fn m(&self) -> usize {
        self.m
    }

    /// Returns the number of columns of A, and of rows of C.
    pub fn n(&self) -> usize {
        self.blocks.n()
    }

    /// Returns the number of ranks, with and without a brick.
    pub fn ranks(&self) -> usize {
        self.ranks
    }

    /// Returns the number of slices of rows.
    pub fn slices(&self) -> usize {
        self.slices
    }

    /// Returns how the columns of a slice meet: its ranks are numbered from 0 there.
    pub fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    /// Returns the number of ranks with a brick, which are the first ones.
    pub fn used(&self) -> usize {
        self.slices * self.blocks.ranks()
    }

    /// Returns the slice and the block of a rank; `None` if it has no brick.
    pub fn place(&self, rank: usize) -> Option<(usize, usize)> {
        let columns = self.blocks.ranks();
        (rank < self.used()).then_some((rank / columns, rank % columns))
    }

    /// Returns the rank in a slice and a block, the inverse of [`Bricks::place`].
    pub fn rank(&self, slice: usize, block: usize) -> usize {
        slice * self.blocks.ranks() + block
    }

    /// Returns the rows of A in the brick of `rank`; none if it has no brick.
    pub fn rows(&self, rank: usize) -> Range<usize> {
        self.place(rank).map_or(0..0, |(slice, _)| even_part(0..self.m, self.slices, slice))
    }

    /// Returns the columns of A in the brick of `rank`; none if it has no brick.
    pub fn columns(&self, rank: usize) -> Range<usize> {
        self.place(rank).map_or(0..0, |(_, block)| self.blocks.columns(block))
    }

    /// Returns the sums of block `block` of C, counted in the order of its segments, that are
    /// reduced on the rank in `slice`.
    pub fn part(&self, slice: usize, block: usize) -> Range<usize> {
        even_part(0..self.blocks.len(block), self.slices, slice)
    }

    /// Returns the number of entries of C that `rank` holds.
    pub fn len(&self, rank: usize) -> usize {
        self.place(rank).map_or(0, |(slice, block)| self.part(slice, block).len())
    }

    pub(super) fn segments(&self, rank: usize) -> impl Iterator<Item = Segment> {
        let place = self.place(rank).into_iter();
        place.flat_map(move |(slice, block)| {
            let part = self.part(slice, block);
            let mut at = 0;
            self.blocks.segments(block).filter_map(move |segment| {
                let (start, end) = (at, at + segment.cols.len());
                at = end;
                let both = start.max(part.start)..end.min(part.end);
                let first = segment.cols.start;
                (!both.is_empty()).then(|| Segment {
                    row: segment.row,
                    cols: first + both.start - start..first + both.end - start,
                })
            })
        })
    }

    /// Returns the words that `rank` sends and that it receives.
    ///
    /// ```
    /// use catamaran::ranks::plan::Bricks;
    ///
    /// // Seven blocks of columns in two slices: each rank gets two blocks, and halves of sums.
    /// let bricks = Bricks::with_counts(14, (100, 70), 7, 2)?;
    /// assert_eq!(bricks.words(0), (2 * 50 * 10 + 178, 2 * 50 * 10 + 177));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn words(&self, rank: usize) -> (usize, usize) {
        let Some((slice, block)) = self.place(rank) else { return (0, 0) };
        let (rows, blocks) = (self.rows(rank).len(), &self.blocks);
        let width = |block: usize| blocks.columns(block).len();
        let seen: usize = blocks.sources(block).map(width).sum();
        let part = |i: usize| self.part((slice + i) % self.slices, block).len();
        let sums = blocks.len(block) - part(0);
        let terms = rounds(self.slices).into_iter().flat_map(|round| 0..round.parts.len());
        (
            rows * width(block) * blocks.destinations(block).count() + sums,
            rows * seen + terms.map(part).sum::<usize>(),
        )
    }
}

/// Returns the words that a rank receives with `columns` blocks of columns and `slices` slices of
/// rows, those of A and the sums, when parts are even.
pub(super) fn even_words(columns: usize, slices: usize, m: usize, n: usize) -> [f64; 2] {
    let (height, width) = (m.div_ceil(slices) as f64, n.div_ceil(columns) as f64);
    let others = (cover_len(columns) - 1) as f64;
    [others * height * width, even_sums(columns, n) * (1.0 - 1.0 / slices as f64)]
}

/// Returns the number of entries of C that a rank computes with `columns` blocks of columns, when
/// parts are even.
pub(super) fn even_sums(columns: usize, n: usize) -> f64 {
    let width = n.div_ceil(columns) as f64;
    width * (width + 1.0) / 2.0 + (columns - 1) as f64 / 2.0 * width * width
}

/// Returns the numbers of blocks of columns and of slices with which a rank accesses the fewest
/// words, its own and those that it receives, among those that use enough ranks.
pub(super) fn fewest_accessed(ranks: usize, m: usize, n: usize) -> (usize, usize) {
    let ranks = ranks.max(1);
    let least = (ranks * USED.0).div_ceil(USED.1);
    let all = m as f64 * n as f64 + triangle_len(n) as f64;
    let counts = (1..=ranks).flat_map(|slices| {
        let columns = least.div_ceil(slices)..=ranks / slices;
        columns.rev().map(move |columns| (columns, slices))
    });
    let accessed = |(columns, slices): (usize, usize)| {
        let [of_a, sums] = even_words(columns, slices, m, n);
        of_a + sums + all / (columns * slices) as f64
    };
    let weighed = counts.map(|counts| (counts, accessed(counts)));
    weighed.min_by(|x, y| x.1.total_cmp(&y.1)).map_or((1, 1), |(counts, _)| counts)
}

#[cfg(test)]
mod tests {
    use super::super::cost::lower_bound;
    use super::*;

    #[test]
    fn every_entry_of_a_and_c_is_on_one_rank() {
        for (columns, slices) in [(1, 1), (1, 4), (4, 1), (2, 3), (3, 3), (6, 2), (7, 3)] {
            for (m, n) in [(0, 3), (5, 0), (1, 1), (13, 17), (20, 42)] {
                let bricks = Bricks::with_counts(22, (m, n), columns, slices).unwrap();
                let mut of_a = vec![0; m * n];
                let mut of_c = vec![0; triangle_len(n)];
                for rank in 0..22 {
                    for i in bricks.rows(rank) {
                        bricks.columns(rank).for_each(|j| of_a[i * n + j] += 1);
                    }
                    let mut len = 0;
                    for Segment { row, cols } in bricks.segments(rank) {
                        assert!(!cols.is_empty() && cols.end <= row + 1);
                        len += cols.len();
                        cols.for_each(|j| of_c[triangle_len(row) + j] += 1);
                    }
                    assert_eq!(len, bricks.len(rank));
                }
                assert!(of_a.iter().chain(&of_c).all(|&count| count == 1), "{bricks:?}");
            }
        }
    }

    #[test]
    fn bricks_for_more_ranks_than_there_are_are_refused() {
        assert!(Bricks::with_counts(20, (5, 5), 7, 3).is_err());
        assert!(Bricks::with_counts(20, (5, 5), 0, 3).is_err());
        assert!(Bricks::with_counts(21, (5, 5), 7, 3).is_ok());
    }

    #[test]
    fn what_is_sent_is_received() {
        for (columns, slices) in [(2, 3), (3, 5), (7, 2), (13, 4)] {
            let bricks = Bricks::with_counts(60, (37, 101), columns, slices).unwrap();
            let words: Vec<_> = (0..60).map(|rank| bricks.words(rank)).collect();
            let [sent, received] =
                [words.iter().map(|w| w.0).sum::<usize>(), words.iter().map(|w| w.1).sum()];
            assert_eq!(sent, received, "{columns} x {slices}");
        }
    }

    /// Returns the words of the planner for a large square over the lower bound.
    fn ratio(ranks: usize) -> f64 {
        let n = 10_000_000;
        let (columns, slices) = fewest_accessed(ranks, n, n);
        let [of_a, sums] = even_words(columns, slices, n, n);
        (of_a + sums) / lower_bound(ranks, n, n).words
    }

    #[test]
    fn squares_are_near_the_lower_bound_on_any_number_of_ranks() {
        for ranks in 16..=4096 {
            let most = match ranks {
                17 => 1.45,
                20 => 1.37,
                16..=25 => 1.27,
                _ if ranks < 256 => 1.23,
                _ => 1.14,
            };
            assert!(ratio(ranks) <= most, "{ranks}: {}", ratio(ranks));
        }
        // One and two dimensions give 2.05 and 2.81 here.
        assert!(ratio(96) <= 1.14 && ratio(1024) <= 1.06);
    }

    #[test]
    fn ranks_that_fit_triangle_blocks_have_at_most_a_quarter_more_than_the_bound() {
        // c (c + 1) q ranks, c a power of a prime and q near c, as a square needs them.
        for c in [2, 3, 4, 5, 7, 8, 9, 11, 13] {
            for slices in c - 1..=c + 2 {
                let ranks = c * (c + 1) * slices;
                // Triangle blocks: n^2 / ((c + 1) q) words of A, and a reduction over q ranks of
                // n^2 / (2 c (c + 1)) sums.
                let (c, q) = (c as f64, slices as f64);
                let triangles = 1.0 / ((c + 1.0) * q) + (1.0 - 1.0 / q) / (2.0 * c * (c + 1.0));
                let p = ranks as f64;
                let theirs = triangles / (1.5 * (p.powf(-2.0 / 3.0) - 1.0 / p));
                if (16..=4096).contains(&ranks) {
                    assert!(ratio(ranks) <= 1.25, "{ranks}: {}", ratio(ranks));
                    assert!(ratio(ranks) <= 1.07 * theirs, "{ranks}: {} {theirs}", ratio(ranks));
                }
            }
        }
    }

    #[test]
    fn even_words_are_those_of_the_busiest_rank() {
        for (columns, slices) in [(1, 4), (2, 3), (7, 2), (8, 3), (43, 2)] {
            let (m, n) = (slices * 8, columns * 12);
            let bricks = Bricks::with_counts(100, (m, n), columns, slices).unwrap();
            let most = (0..100).map(|rank| bricks.words(rank).0).max().unwrap();
            let planned: f64 = even_words(columns, slices, m, n).iter().sum();
            assert!((most as f64 - planned).abs() < 1.0, "{columns} x {slices}: {most} {planned}");
        }
    }
}
