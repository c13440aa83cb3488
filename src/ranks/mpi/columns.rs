//! Columns of A on every rank: blocks of columns travel so that each pair of blocks meets once.

use std::collections::VecDeque;
use std::ops::Range;

use faer::{MatMut, MatRef};

use super::memory::append_rows;
use super::symmetric::Symmetric;
use super::tags::COLUMNS;
use super::transfer::Transfer;
use super::world::{MpiReal, Operation, World, fact, number_fact, scalar_fact};
use crate::base::{Result, reserved, triangle_len, triangle_rows, zeros};
use crate::product::{AtaOptions, Uplo, ata_into, atb_into};
use crate::ranks::plan::{Blocks, TriangleLayout, piece_height};

/// Computes `C = alpha A^T A` where every rank has some `columns` of A, possibly none, in the order
/// of the ranks.
///
/// This is the two-dimensional distribution, for matrices that are not much longer than wide. With
/// about equal numbers of columns, each rank receives `m n / sqrt(P)` words (at most 1.5 times
/// that, see [`difference_cover`](crate::ranks::plan::difference_cover)), piece by piece of
/// rows, while it multiplies the previous piece. The columns of a rank are m x n_r with any
/// strides. Beside these columns and its part of C, a rank holds two pieces of the columns that it
/// multiplies, not more than its share of A and C together. `options.uplo` does not matter. The
/// result depends, by rounding, on the number of ranks and the widths.
///
/// ```no_run
/// use catamaran::ranks::{World, ata_columns};
/// use catamaran::{AtaOptions, faer::Mat};
///
/// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// # let (universe, _) = start.expect("MPI is started once");
/// # let world = World::new(&universe.world())?;
/// // Every rank has 8 columns.
/// let own = Mat::<f64>::from_fn(100, 8, |i, j| (world.rank() + i * j % 7) as f64);
/// let result = ata_columns(&world, 1.0, own.as_ref(), &AtaOptions::new())?;
/// assert_eq!(result.n(), 8 * world.size());
/// result.for_each_segment(|i, j, entries| println!("C[{i}, {j}..] = {entries:?}"));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Rank`](crate::Error::Rank) when m, alpha or the precision differ, or another rank
/// failed; else as [`ata_into`].
pub fn ata_columns<T: MpiReal>(
    world: &World,
    alpha: T,
    columns: MatRef<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<Symmetric<T>> {
    let _guard = world.abort_on_panic();
    let (m, own) = (columns.nrows(), world.rank());
    let facts = [fact("m", m), scalar_fact::<T>(), number_fact("alpha", alpha)];
    world.begin(Operation::Columns, &facts, Ok(()))?;
    let blocks = Blocks::new(&world.gather_numbers(columns.ncols()));
    let width = columns.ncols();
    // The block on the diagonal is computed as a square, of which a triangle is used.
    let prepared = Exchange::new(world, &blocks, columns)
        .and_then(|exchange| Ok((exchange, zeros(blocks.len(own))?, zeros(width * width)?)));
    let (mut exchange, mut entries, mut square) = world.agree(prepared)?;

    let products: Vec<_> = blocks.products(own).collect();
    let total = (exchange.pieces() * products.len()) as f64;
    let mut done = Ok(());
    exchange.start(0);
    exchange.start(1);
    let mut piece = 0;
    while let Some(seen) = exchange.next() {
        let beta = if piece == 0 { T::ZERO } else { T::ONE };
        let mut rest = &mut entries[triangle_len(width)..];
        for (i, product) in products.iter().enumerate() {
            let first = product.rows.start - blocks.columns(product.left).start;
            let left = seen.columns(product.left).subcols(first, product.rows.len());
            let right = seen.columns(product.right);
            let on_diagonal = product.left == product.right;
            let result = if on_diagonal {
                &mut square[..]
            } else {
                rest.split_off_mut(..left.ncols() * right.ncols()).unwrap_or_default()
            };
            let result = MatMut::from_row_major_slice_mut(result, left.ncols(), right.ncols());
            // A rank that fails continues to send, so that no rank waits for it.
            if done.is_ok() {
                let share = |i: usize| (piece * products.len() + i) as f64 / total;
                done = world.with_progress(options, share(i)..share(i + 1), &|| false, |options| {
                    if on_diagonal {
                        let options = AtaOptions { uplo: Uplo::Lower, ..options.clone() };
                        ata_into(alpha, left, beta, result, &options)
                    } else {
                        atb_into(alpha, left, right, beta, result, options)
                    }
                });
            }
        }
        exchange.recycle(seen);
        exchange.start(piece + 2);
        piece += 1;
    }
    for (i, row) in triangle_rows(&mut entries, 0..width) {
        row.copy_from_slice(&square[i * width..=i * width + i]);
    }
    world.agree(done)?;
    drop(exchange);
    Ok(Symmetric::new(TriangleLayout::Blocks(blocks), own, entries))
}

/// Sends the columns of this rank to the ranks that need them, some rows at a time, and receives
/// the columns that this rank needs.
struct Exchange<'w, T> {
    world: &'w World,
    blocks: &'w Blocks,
    columns: MatRef<'w, T>,
    /// Number of rows that travel at once.
    height: usize,
    /// Buffers for two pieces.
    spare: Vec<Vec<T>>,
    under_way: VecDeque<UnderWay<T>>,
}

/// A piece under way.
struct UnderWay<T> {
    piece: usize,
    sent: Option<Transfer<T>>,
    received: Vec<(usize, Transfer<T>)>,
}

/// A piece that has arrived: some rows of all columns that this rank needs.
struct Piece<'w, T> {
    own: MatRef<'w, T>,
    sent: Option<Transfer<T>>,
    received: Vec<(usize, Vec<T>)>,
}

impl<'w, T: MpiReal> Exchange<'w, T> {
    fn new(world: &'w World, blocks: &'w Blocks, columns: MatRef<'w, T>) -> Result<Self> {
        let (own, m) = (world.rank(), columns.nrows());
        let seen = blocks.sources(own).count() + 1;
        let height = piece_height(m, blocks.n(), seen);
        let width = |rank: usize| blocks.columns(rank).len();
        let widest = blocks.sources(own).chain([own]).map(width).max().unwrap_or(0);
        let len = height.min(m) * widest;
        let spare = (0..2 * seen).map(|_| reserved(len)).collect::<Result<_>>()?;
        Ok(Self { world, blocks, columns, height, spare, under_way: VecDeque::new() })
    }

    /// Returns the number of pieces.
    fn pieces(&self) -> usize {
        self.columns.nrows().div_ceil(self.height)
    }

    fn rows(&self, piece: usize) -> Range<usize> {
        let first = piece * self.height;
        first..(first + self.height).min(self.columns.nrows())
    }

    /// Starts the transfers of a piece, if there is one.
    fn start(&mut self, piece: usize) {
        if piece >= self.pieces() {
            return;
        }
        let (own, rows) = (self.world.rank(), self.rows(piece));
        let tag = COLUMNS.tag(piece % 2);
        let received = self.blocks.sources(own).map(|source| {
            let mut buffer = self.spare.pop().unwrap_or_default();
            buffer.resize(rows.len() * self.blocks.columns(source).len(), T::ZERO);
            (source, Transfer::receive(self.world, buffer, source, tag))
        });
        let received = received.collect();
        let sent = (self.world.size() > 1).then(|| {
            let mut copy = self.spare.pop().unwrap_or_default();
            copy.clear();
            append_rows(&mut copy, self.columns.subrows(rows.start, rows.len()));
            Transfer::send(self.world, copy, self.blocks.destinations(own), tag)
        });
        self.under_way.push_back(UnderWay { piece, sent, received });
    }

    /// Waits for the next piece that was started, and returns it.
    fn next(&mut self) -> Option<Piece<'w, T>> {
        let UnderWay { piece, sent, received } = self.under_way.pop_front()?;
        let rows = self.rows(piece);
        let own = self.columns.subrows(rows.start, rows.len());
        let received =
            received.into_iter().map(|(rank, transfer)| (rank, transfer.wait())).collect();
        Some(Piece { own, sent, received })
    }

    /// Takes back the buffers of a piece.
    fn recycle(&mut self, piece: Piece<'w, T>) {
        self.spare.extend(piece.sent.map(Transfer::wait));
        self.spare.extend(piece.received.into_iter().map(|(_, buffer)| buffer));
    }
}

impl<T> Piece<'_, T> {
    /// Returns the columns of `rank`, which is this rank or a source of it.
    fn columns(&self, rank: usize) -> MatRef<'_, T> {
        match self.received.iter().find(|(source, _)| *source == rank) {
            Some((_, buffer)) => {
                let rows = self.own.nrows();
                MatRef::from_row_major_slice(buffer, rows, buffer.len() / rows)
            }
            None => self.own,
        }
    }
}
