//! Each rank has some rows of A: the sum over the ranks of their products, reduced and scattered.
//!
//! The triangle is cut in chunks of rows so that the reduction of one can overlap the computation
//! of the next. A chunk is reduced in `ceil(log2 P)` rounds on a circulant graph for any number P
//! of ranks, and each rank sends every entry that is not its own exactly once: `(1 - 1/P)` of the
//! triangle, which is the least possible. Source: J. L. Träff, "Optimal, non-pipelined
//! reduce-scatter and allreduce algorithms" (2024).

use std::ops::Range;

use super::segment::Segment;
use crate::base::{even_part, first_that, triangle_len};

/// The lower triangle of C as chunks of rows; each chunk is shared evenly among all ranks.
///
/// ```
/// use catamaran::base::triangle_len;
/// use catamaran::ranks::plan::Chunks;
///
/// let chunks = Chunks::with_count(100, 4, 5);
/// assert_eq!((chunks.count(), chunks.rows(4).end), (5, 100));
/// // Every rank holds a quarter of every chunk.
/// assert!((chunks.len(0) as f64 / triangle_len(100) as f64 - 0.25).abs() < 0.01);
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chunks {
    ranks: usize,
    /// Where each chunk begins, and the end: ascending rows of C, from 0 to n.
    bounds: Vec<usize>,
}

/// Entries of C above which there are several chunks: 8 MiB of f64, whose reduction is worth
/// hiding.
const WHOLE: usize = 1 << 20;
/// Rows of a chunk that products are still efficient on.
const SHORTEST: usize = 128;

impl Chunks {
    /// Creates chunks of about the same number of entries for A m x n on `ranks >= 1` ranks. Long
    /// products are faster, so there are as few chunks as possible while a rank needs no more extra
    /// memory than its share of A and C takes.
    ///
    /// ```
    /// use catamaran::ranks::plan::Chunks;
    ///
    /// // A small C is one chunk; several chunks of a large C overlap with its computation.
    /// assert_eq!(Chunks::new(1000, 100, 4).count(), 1);
    /// assert!(Chunks::new(4096, 4096, 2).count() > 1);
    /// ```
    pub fn new(m: usize, n: usize, ranks: usize) -> Self {
        let share = (m as f64 * n as f64 + triangle_len(n) as f64) / ranks as f64;
        let most = (n / (2 * SHORTEST)).max(1);
        let least = if triangle_len(n) > WHOLE { most.min(2) } else { 1 };
        let fits = |count| Self::with_count(n, ranks, count).scratch() as f64 <= share;
        // More chunks are shorter.
        let count = first_that(least..most, fits);
        Self::with_count(n, ranks, count)
    }

    /// Creates `count >= 1` chunks of about the same number of entries.
    pub fn with_count(n: usize, ranks: usize, count: usize) -> Self {
        // Rows up to n sqrt(k / count) hold k / count of the triangle.
        let bound = |k: usize| (n as f64 * (k as f64 / count as f64).sqrt()).round() as usize;
        let mut bounds: Vec<usize> = (0..=count).map(bound).collect();
        bounds[count] = n;
        Self { ranks, bounds }
    }

    /// Returns the number of rows, and of columns, of C.
    pub fn n(&self) -> usize {
        self.bounds[self.count()]
    }

    /// Returns the number of ranks.
    pub fn ranks(&self) -> usize {
        self.ranks
    }

    /// Returns the number of chunks.
    pub fn count(&self) -> usize {
        self.bounds.len() - 1
    }

    /// Returns the rows of C in `chunk`.
    pub fn rows(&self, chunk: usize) -> Range<usize> {
        self.bounds[chunk]..self.bounds[chunk + 1]
    }

    /// Returns the number of entries of the largest panel: the rows of a chunk up to the end of its
    /// diagonal.
    pub fn longest_panel(&self) -> usize {
        (0..self.count()).map(|c| self.rows(c).len() * self.rows(c).end).max().unwrap_or(0)
    }

    /// Returns the number of entries that a rank needs beside its share: the panel being computed,
    /// two chunks in flight, and half a chunk for incoming sums.
    pub fn scratch(&self) -> usize {
        let len = |chunk| triangle_len(self.rows(chunk).end) - triangle_len(self.rows(chunk).start);
        self.longest_panel() + (0..self.count()).map(len).max().unwrap_or(0) * 5 / 2
    }

    /// Returns the entries of `chunk` that `rank` holds, counted along the packed triangle.
    pub fn entries(&self, chunk: usize, rank: usize) -> Range<usize> {
        let rows = self.rows(chunk);
        even_part(triangle_len(rows.start)..triangle_len(rows.end), self.ranks, rank)
    }

    pub(super) fn segments(&self, rank: usize) -> impl Iterator<Item = Segment> {
        (0..self.count()).flat_map(move |chunk| Segment::of_packed(self.entries(chunk, rank)))
    }

    /// Returns the segments of the part of `chunk` that `rank` holds.
    pub fn segments_of(&self, chunk: usize, rank: usize) -> impl Iterator<Item = Segment> {
        Segment::of_packed(self.entries(chunk, rank))
    }

    /// Returns the number of entries that `rank` holds.
    pub fn len(&self, rank: usize) -> usize {
        (0..self.count()).map(|chunk| self.entries(chunk, rank).len()).sum()
    }
}

/// One round of the reduction, for every rank r: it sends its sums for the ranks `r + i mod P`, `i`
/// in `parts`, to rank `r + parts.start mod P`, and receives as many from rank
/// `r - parts.start mod P`, which it adds to its sums for the ranks `r + i mod P`, `i` in
/// `0..parts.len()`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Round {
    /// Which sums are sent, counted from the rank's own.
    pub parts: Range<usize>,
}

/// Returns the `ceil(log2 P)` rounds after which each of P = `ranks` ranks has the complete sum of
/// its own part.
///
/// ```
/// use catamaran::ranks::plan::rounds;
///
/// assert_eq!(rounds(8).len(), 3);
/// ```
pub fn rounds(ranks: usize) -> Vec<Round> {
    let mut rounds = Vec::new();
    let mut end = ranks;
    while end > 1 {
        let start = end.div_ceil(2);
        rounds.push(Round { parts: start..end });
        end = start;
    }
    rounds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_few_chunks_as_possible_are_found() {
        for (m, n) in [(1000, 3000), (3000, 3001), (50, 9999), (40_000, 12_000), (1, 30_000)] {
            for ranks in [1, 2, 3, 7, 16, 64, 500, 4096] {
                let share = (m as f64 * n as f64 + triangle_len(n) as f64) / ranks as f64;
                let fits = |count| Chunks::with_count(n, ranks, count).scratch() as f64 <= share;
                let most = n / 256;
                let first = (2..most).find(|&count| fits(count)).unwrap_or(most);
                assert_eq!(Chunks::new(m, n, ranks).count(), first, "{m} x {n}, {ranks} ranks");
            }
        }
    }

    #[test]
    fn every_entry_belongs_to_one_rank() {
        for (n, ranks) in [(0, 1), (1, 3), (7, 2), (64, 7), (127, 16), (500, 4), (1031, 5)] {
            for count in [1, 2, 5] {
                let chunks = Chunks::with_count(n, ranks, count);
                let mut seen = vec![0; triangle_len(n)];
                for rank in 0..ranks {
                    let mut len = 0;
                    for segment in chunks.segments(rank) {
                        for j in segment.cols {
                            seen[triangle_len(segment.row) + j] += 1;
                            len += 1;
                        }
                    }
                    assert_eq!(len, chunks.len(rank));
                }
                assert!(seen.iter().all(|&count| count == 1), "n = {n}, {ranks} ranks");
            }
        }
    }

    #[test]
    fn every_rank_gets_every_term_of_its_part_once() {
        for ranks in (1..=70).chain([127, 128, 129, 1000]) {
            // terms[r][i]: the ranks whose products are in the sum that rank r has for rank r + i
            let mut terms: Vec<Vec<Vec<usize>>> =
                (0..ranks).map(|r| (0..ranks).map(|_| vec![r]).collect()).collect();
            let rounds = rounds(ranks);
            assert_eq!(rounds.len(), ranks.next_power_of_two().ilog2() as usize);
            let mut sent = 0;
            for Round { parts } in rounds {
                let before = terms.clone();
                for r in 0..ranks {
                    let from = (r + ranks - parts.start) % ranks;
                    for i in 0..parts.len() {
                        terms[r][i].extend_from_slice(&before[from][parts.start + i]);
                    }
                }
                sent += parts.len();
            }
            assert_eq!(sent, ranks - 1);
            for own in terms.iter_mut().map(|t| &mut t[0]) {
                own.sort_unstable();
                assert!(own.iter().copied().eq(0..ranks), "{ranks} ranks");
            }
        }
    }

    #[test]
    fn chunks_are_even_and_as_few_as_memory_allows() {
        for (m, n, ranks, count) in [
            (4096, 4096, 2, 4),
            (4096, 4096, 16, 16),
            (20_000, 20_000, 100, 78),
            (600_000, 500, 4, 1),
            (1_000_000, 4096, 4, 2),
        ] {
            let chunks = Chunks::new(m, n, ranks);
            assert_eq!(chunks.count(), count, "{m} x {n} on {ranks} ranks");
            let sizes: Vec<usize> = (0..chunks.count())
                .map(|c| triangle_len(chunks.rows(c).end) - triangle_len(chunks.rows(c).start))
                .collect();
            let (least, most) = (sizes.iter().min().unwrap(), sizes.iter().max().unwrap());
            assert!(most - least <= 2 * n, "{sizes:?}");
            let lens: Vec<usize> = (0..ranks).map(|r| chunks.len(r)).collect();
            let spread = lens.iter().max().unwrap() - lens.iter().min().unwrap();
            assert!(spread <= chunks.count(), "{lens:?}");
        }
    }
}
