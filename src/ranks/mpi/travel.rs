//! Blocks of columns travel between the ranks whose columns meet, some rows at a time.

use std::collections::VecDeque;
use std::ops::Range;

use faer::MatRef;

use super::memory::{Buffer, append_rows};
use super::tags::COLUMNS;
use super::transfer::Transfer;
use super::world::{MpiReal, World};
use crate::base::Result;
use crate::ranks::plan::{Blocks, piece_height};

/// Sends the columns of this rank to the ranks that need them, some rows at a time, and receives
/// the columns that this rank needs. Ranks are numbered as in the blocks.
pub(super) struct Exchange<'w, T> {
    world: &'w World,
    /// The rank of the world that has the first block.
    first: usize,
    blocks: &'w Blocks,
    columns: MatRef<'w, T>,
    /// Number of rows that travel at once.
    height: usize,
    /// Buffers for two pieces.
    spare: Vec<Buffer<T>>,
    under_way: VecDeque<UnderWay<T>>,
}

/// A piece under way.
struct UnderWay<T> {
    piece: usize,
    sent: Option<Transfer<T>>,
    received: Vec<(usize, Transfer<T>)>,
}

/// A piece that has arrived: some rows of all columns that this rank needs.
pub(super) struct Piece<'w, T> {
    own: MatRef<'w, T>,
    sent: Option<Transfer<T>>,
    received: Vec<(usize, Buffer<T>)>,
}

impl<'w, T: MpiReal> Exchange<'w, T> {
    /// Allocates memory for two pieces. This rank has `columns` of the blocks, of which rank
    /// `first` has the first ones.
    pub(super) fn new(
        world: &'w World,
        first: usize,
        blocks: &'w Blocks,
        columns: MatRef<'w, T>,
    ) -> Result<Self> {
        let (own, m) = (world.rank() - first, columns.nrows());
        let seen = blocks.sources(own).count() + 1;
        let height = piece_height(m, blocks.n(), seen);
        let width = |rank: usize| blocks.columns(rank).len();
        let widest = blocks.sources(own).chain([own]).map(width).max().unwrap_or(0);
        let len = height.min(m) * widest;
        let spare = (0..2 * seen).map(|_| Buffer::with_room(len)).collect::<Result<_>>()?;
        Ok(Self { world, first, blocks, columns, height, spare, under_way: VecDeque::new() })
    }

    /// Returns the ranks of the world.
    pub(super) fn world(&self) -> &'w World {
        self.world
    }

    /// Returns which columns meet on which rank.
    pub(super) fn blocks(&self) -> &'w Blocks {
        self.blocks
    }

    /// Returns the number of this rank in the blocks.
    pub(super) fn own(&self) -> usize {
        self.world.rank() - self.first
    }

    /// Returns the number of pieces.
    pub(super) fn pieces(&self) -> usize {
        self.columns.nrows().div_ceil(self.height)
    }

    fn rows(&self, piece: usize) -> Range<usize> {
        let first = piece * self.height;
        first..(first + self.height).min(self.columns.nrows())
    }

    /// Starts the transfers of a piece, if there is one.
    pub(super) fn start(&mut self, piece: usize) {
        if piece >= self.pieces() {
            return;
        }
        let (own, rows, first) = (self.own(), self.rows(piece), self.first);
        let tag = COLUMNS.tag(piece % 2);
        let received = self.blocks.sources(own).map(|source| {
            let mut buffer = self.spare.pop().unwrap_or_default();
            buffer.set_len(rows.len() * self.blocks.columns(source).len());
            (source, Transfer::receive(self.world, buffer, first + source, tag))
        });
        let received = received.collect();
        let sent = (self.blocks.ranks() > 1).then(|| {
            let mut copy = self.spare.pop().unwrap_or_default();
            copy.set_len(0);
            append_rows(&mut copy, self.columns.subrows(rows.start, rows.len()));
            let to = self.blocks.destinations(own).map(|rank| first + rank);
            Transfer::send(self.world, copy, to, tag)
        });
        self.under_way.push_back(UnderWay { piece, sent, received });
    }

    /// Waits for the next piece that was started, and returns it.
    pub(super) fn next(&mut self) -> Option<Piece<'w, T>> {
        let UnderWay { piece, sent, received } = self.under_way.pop_front()?;
        let rows = self.rows(piece);
        let own = self.columns.subrows(rows.start, rows.len());
        let received =
            received.into_iter().map(|(rank, transfer)| (rank, transfer.wait())).collect();
        Some(Piece { own, sent, received })
    }

    /// Takes back the buffers of a piece.
    pub(super) fn recycle(&mut self, piece: Piece<'w, T>) {
        self.spare.extend(piece.sent.map(Transfer::wait));
        self.spare.extend(piece.received.into_iter().map(|(_, buffer)| buffer));
    }
}

impl<T: MpiReal> Piece<'_, T> {
    /// Returns the number of rows.
    pub(super) fn nrows(&self) -> usize {
        self.own.nrows()
    }

    /// Returns the columns of `rank`, which is this rank or a source of it.
    pub(super) fn columns(&self, rank: usize) -> MatRef<'_, T> {
        match self.received.iter().find(|(source, _)| *source == rank) {
            Some((_, buffer)) => {
                let rows = self.own.nrows();
                MatRef::from_row_major_slice(buffer, rows, buffer.len() / rows)
            }
            None => self.own,
        }
    }
}
