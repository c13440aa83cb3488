use std::ops::Range;

use faer::MatRef;

use super::memory::{Buffer, append_rows};
use super::tags::{MOST_ROUNDS, ROUNDS};
use super::transfer::Transfer;
use super::world::{MpiReal, World};
use crate::base::Result;
use crate::ranks::plan::{Chunks, rounds};

/// Sums chunks over the ranks and scatters the sums, one chunk after another, in memory that is
/// allocated once.
pub(super) struct Reduction<'c, T> {
    chunks: &'c Chunks,
    rank: usize,
    /// Parts of the pieces, counted from the rank's own part: first that alone, then what the rank
    /// sends in the last round, ..., in the first round.
    parts: Vec<Range<usize>>,
    pieces: Vec<Buffer<T>>,
    /// Where the sums of other ranks arrive.
    incoming: Buffer<T>,
    chunk: usize,
    /// Pieces that are still to be sent, the last one first; `None` when no sum was started.
    left: Option<usize>,
    under_way: Option<(Transfer<T>, Transfer<T>)>,
}

impl<'c, T: MpiReal> Reduction<'c, T> {
    /// Allocates memory for the largest chunk.
    pub(super) fn new(chunks: &'c Chunks, rank: usize) -> Result<Self> {
        let rounds = rounds(chunks.ranks()).into_iter().rev().map(|round| round.parts);
        let parts: Vec<_> = std::iter::once(0..1).chain(rounds).collect();
        let most = |parts: &Range<usize>| {
            let all = 0..chunks.count();
            all.map(|chunk| entries(chunks, chunk, rank, parts)).max().unwrap_or(0)
        };
        let pieces =
            parts.iter().map(|parts| Buffer::with_room(most(parts))).collect::<Result<_>>()?;
        let longest = parts.iter().map(|parts| most(&(0..parts.len()))).max().unwrap_or(0);
        let incoming = Buffer::with_room(longest)?;
        Ok(Self { chunks, rank, parts, pieces, incoming, chunk: 0, left: None, under_way: None })
    }

    /// Takes this rank's sums: `panel` holds the rows of `chunk`, up to the diagonal.
    pub(super) fn fill(&mut self, chunk: usize, panel: MatRef<'_, T>) {
        let first = self.chunks.rows(chunk).start;
        for (parts, piece) in self.parts.iter().zip(&mut self.pieces) {
            piece.set_len(0);
            for part in parts.clone() {
                let rank = (self.rank + part) % self.chunks.ranks();
                for segment in self.chunks.segments_of(chunk, rank) {
                    let (row, first_col) = (segment.row - first, segment.cols.start);
                    append_rows(piece, panel.submatrix(row, first_col, 1, segment.cols.len()));
                }
            }
        }
    }

    /// Starts the rounds for `chunk`, with unspecified entries if it was not filled.
    pub(super) fn start(&mut self, world: &World, chunk: usize) {
        for (parts, piece) in self.parts.iter().zip(&mut self.pieces) {
            piece.set_len(entries(self.chunks, chunk, self.rank, parts));
        }
        self.chunk = chunk;
        self.left = Some(self.pieces.len() - 1);
        self.next_round(world);
    }

    /// Continues as far as possible without waiting.
    pub(super) fn advance(&mut self, world: &World) {
        while let Some((sent, received)) = &mut self.under_way {
            if !(sent.has_ended() && received.has_ended()) {
                return;
            }
            self.end_round();
            self.next_round(world);
        }
    }

    /// Waits for the end, and returns the sum of this rank's part of the chunk, or nothing if none
    /// was started.
    pub(super) fn finish(&mut self, world: &World) -> &[T] {
        while self.under_way.is_some() {
            self.end_round();
            self.next_round(world);
        }
        if self.left.take().is_some() { &self.pieces[0] } else { &[] }
    }

    fn next_round(&mut self, world: &World) {
        let Some(piece @ 1..) = self.left else { return };
        let (ranks, parts) = (self.chunks.ranks(), &self.parts[piece]);
        let tag = ROUNDS.tag(self.chunk % 2 * MOST_ROUNDS + piece);
        let to = (self.rank + parts.start) % ranks;
        let from = (self.rank + ranks - parts.start) % ranks;
        let mut incoming = std::mem::take(&mut self.incoming);
        incoming.set_len(entries(self.chunks, self.chunk, self.rank, &(0..parts.len())));
        let outgoing = std::mem::take(&mut self.pieces[piece]);
        let received = Transfer::receive(world, incoming, from, tag);
        self.under_way = Some((Transfer::send(world, outgoing, [to], tag), received));
    }

    /// Waits for the round, and adds what has arrived.
    fn end_round(&mut self) {
        let (Some((sent, received)), Some(piece)) = (self.under_way.take(), self.left) else {
            return;
        };
        self.incoming = received.wait();
        let sums = self.pieces.iter_mut().flat_map(|piece| piece.iter_mut());
        sums.zip(self.incoming.iter()).for_each(|(sum, &term)| *sum += term);
        self.pieces[piece] = sent.wait();
        self.left = Some(piece - 1);
    }
}

/// Returns the number of entries of `chunk` in the parts of `rank + i`, `i` in `parts`.
fn entries(chunks: &Chunks, chunk: usize, rank: usize, parts: &Range<usize>) -> usize {
    parts.clone().map(|i| chunks.entries(chunk, (rank + i) % chunks.ranks()).len()).sum()
}
