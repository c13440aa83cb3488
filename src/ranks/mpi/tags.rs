//! The tags of all messages between two ranks.
//!
//! Every kind of message has tags of its own: a call may send several kinds, and a rank may begin
//! the next call while another rank is still in the previous one.

use crate::ranks::plan::STRIPS as MOST_STRIPS;

/// The tag of a message; only this module makes tags.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Tag(i32);

impl Tag {
    /// Returns the number that MPI gets.
    pub(super) fn number(self) -> i32 {
        self.0
    }
}

/// The consecutive tags of one kind of message.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tags {
    first: i32,
    count: usize,
}

impl Tags {
    /// Returns `count` tags after those of the kind before.
    const fn after(before: Self, count: usize) -> Self {
        Self { first: before.first + before.count as i32, count }
    }

    /// Returns tag `i` of this kind, below their number.
    pub(super) fn tag(self, i: usize) -> Tag {
        assert!(i < self.count, "tag {i} of {}", self.count);
        Tag(self.first + i as i32)
    }
}

/// No message has tag 0, the tag of rsmpi's calls without a tag.
const NONE: Tags = Tags { first: 0, count: 1 };
const GATHERED: Tags = Tags::after(NONE, 1);
const GATHERED_ROWS: Tags = Tags::after(GATHERED, 1);
const EXCHANGED: Tags = Tags::after(GATHERED_ROWS, 1);
const STREAMED: Tags = Tags::after(EXCHANGED, 1);
const DEALT_ROWS: Tags = Tags::after(STREAMED, 1);
const CYCLIC_PIECES: Tags = Tags::after(DEALT_ROWS, 1);
const TREE_RESULTS: Tags = Tags::after(CYCLIC_PIECES, 1);

/// The entries of a symmetric matrix, on their way to the root.
pub(super) const GATHER: Tag = Tag(GATHERED.first);
/// The rows of a matrix, on their way to the root.
pub(super) const GATHER_ROWS: Tag = Tag(GATHERED_ROWS.first);
/// Entries of vectors that other ranks need.
pub(super) const EXCHANGE: Tag = Tag(EXCHANGED.first);
/// The bytes of an accumulator.
pub(super) const STREAM: Tag = Tag(STREAMED.first);
/// The rows that the root deals.
pub(super) const DEALT: Tag = Tag(DEALT_ROWS.first);
/// Pieces of block-cyclic matrices.
pub(super) const CYCLIC: Tag = Tag(CYCLIC_PIECES.first);
/// Parts of C, on their way up the tree.
pub(super) const RESULT: Tag = Tag(TREE_RESULTS.first);
/// The strips of a part of A, on their way down the tree.
pub(super) const STRIPS: Tags = Tags::after(TREE_RESULTS, MOST_STRIPS);
/// Rows of columns: those of two pieces that are under way at the same time differ.
pub(super) const COLUMNS: Tags = Tags::after(STRIPS, 2);
/// Most rounds of a reduction, about the binary logarithm of the number of ranks.
pub(super) const MOST_ROUNDS: usize = 64;
/// The rounds of a reduction: those of successive chunks differ.
pub(super) const ROUNDS: Tags = Tags::after(COLUMNS, 2 * MOST_ROUNDS);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_message_has_tags_of_its_own_that_every_mpi_library_allows() {
        let single = [GATHER, GATHER_ROWS, EXCHANGE, STREAM, DEALT, CYCLIC, RESULT];
        let several =
            [STRIPS, COLUMNS, ROUNDS].map(|tags| (0..tags.count).map(move |i| tags.tag(i)));
        let all = single.into_iter().chain(several.into_iter().flatten());
        let mut numbers: Vec<i32> = all.map(Tag::number).collect();
        let count = numbers.len();
        numbers.sort_unstable();
        numbers.dedup();
        assert_eq!(numbers.len(), count);
        // MPI_TAG_UB is at least 32767.
        assert!(numbers[0] > 0 && numbers[count - 1] <= 32767, "{numbers:?}");
    }
}
