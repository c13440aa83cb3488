//! The products of the pairs of column blocks that meet on a rank.

use std::ops::Range;

use faer::{MatMut, MatRef};

use super::memory::Buffer;
use super::stream::joined_bounds_of_columns;
use super::travel::{Exchange, Piece};
use super::world::{MpiReal, World};
use crate::base::{Progress, Result, block_rows, reserved, triangle_len, triangle_rows, zeros};
use crate::product::exact::Flags;
use crate::product::{AtaOptions, Uplo, ata_into, atb_into};
use crate::ranks::plan::Blocks;
use crate::rows::{DenseRows, ExactSums, RowBounds, add_exact, no_exact_sums};

/// Sums over the pieces of what a rank sees.
pub(super) trait Pairs<T: MpiReal> {
    /// Adds the products of a piece, in `share` of the progress.
    fn add(
        &mut self,
        exchange: &Exchange<'_, T>,
        seen: &Piece<'_, T>,
        share: Range<f64>,
        options: &AtaOptions<'_>,
    ) -> Result<()>;

    /// Receives all pieces and adds their products. After an error this rank continues to send, so
    /// that no rank waits for it.
    fn add_all(&mut self, exchange: &mut Exchange<'_, T>, options: &AtaOptions<'_>) -> Result<()> {
        let pieces = exchange.pieces();
        let mut done = Ok(());
        exchange.start(0);
        exchange.start(1);
        let mut piece = 0;
        while let Some(seen) = exchange.next() {
            if done.is_ok() {
                let share = |piece: usize| piece as f64 / pieces as f64;
                done = self.add(exchange, &seen, share(piece)..share(piece + 1), options);
            }
            exchange.recycle(seen);
            exchange.start(piece + 2);
            piece += 1;
        }
        done
    }
}

/// Sums the products of the pairs that meet on this rank, of which `part` is some columns of some
/// rows of A: the columns travel among the ranks of `blocks`, of which that of block 0 is `first`,
/// to the `sums` of no rows. All ranks call this function; `None` for a rank outside of blocks.
pub(super) fn summed<T: MpiReal, P: Pairs<T>>(
    world: &World,
    place: Option<(usize, &Blocks)>,
    part: MatRef<'_, T>,
    sums: impl FnOnce() -> Result<P>,
    options: &AtaOptions<'_>,
) -> Result<Option<P>> {
    let prepared = place
        .map(|(first, blocks)| Ok((Exchange::new(world, first, blocks, part)?, sums()?)))
        .transpose();
    let done = world.agree(prepared)?.map(|(mut exchange, mut pairs)| {
        pairs.add_all(&mut exchange, options)?;
        Ok(pairs)
    });
    world.agree(done.transpose())
}

/// Sums in floating point, alpha times.
pub(super) struct FloatPairs<T> {
    alpha: T,
    /// 0 before the first piece, else 1.
    beta: T,
    /// The products in the order of [`Blocks::products`].
    entries: Vec<T>,
    /// The block on the diagonal is computed as a square, of which a triangle is used.
    square: Buffer<T>,
    width: usize,
}

impl<T: MpiReal> FloatPairs<T> {
    /// Creates the sums of no rows on rank `own` of the blocks.
    pub(super) fn new(blocks: &Blocks, own: usize, alpha: T) -> Result<Self> {
        let width = blocks.columns(own).len();
        let (entries, square) = (zeros(blocks.len(own))?, Buffer::of_len(width * width)?);
        Ok(Self { alpha, beta: T::ZERO, entries, square, width })
    }

    /// Returns the entries, in the order of their segments.
    pub(super) fn into_entries(mut self) -> Vec<T> {
        let width = self.width;
        if self.beta == T::ZERO {
            self.square.fill(T::ZERO);
        }
        for (i, row) in triangle_rows(&mut self.entries, 0..width) {
            row.copy_from_slice(&self.square[i * width..=i * width + i]);
        }
        self.entries
    }
}

impl<T: MpiReal> Pairs<T> for FloatPairs<T> {
    fn add(
        &mut self,
        exchange: &Exchange<'_, T>,
        seen: &Piece<'_, T>,
        share: Range<f64>,
        options: &AtaOptions<'_>,
    ) -> Result<()> {
        let (world, blocks, alpha) = (exchange.world(), exchange.blocks(), self.alpha);
        let beta = std::mem::replace(&mut self.beta, T::ONE);
        let products: Vec<_> = blocks.products(exchange.own()).collect();
        let (start, step) = (share.start, (share.end - share.start) / products.len() as f64);
        let mut rest = &mut self.entries[triangle_len(self.width)..];
        for (i, product) in products.iter().enumerate() {
            let first = product.rows.start - blocks.columns(product.left).start;
            let left = seen.columns(product.left).subcols(first, product.rows.len());
            let right = seen.columns(product.right);
            let on_diagonal = product.left == product.right;
            let result = if on_diagonal {
                &mut self.square[..]
            } else {
                rest.split_off_mut(..left.ncols() * right.ncols()).unwrap_or_default()
            };
            let result = MatMut::from_row_major_slice_mut(result, left.ncols(), right.ncols());
            let share = start + step * i as f64..start + step * (i + 1) as f64;
            world.with_progress(options, share, &|| false, |options| {
                if on_diagonal {
                    let options = AtaOptions { uplo: Uplo::Lower, ..options.clone() };
                    ata_into(alpha, left, beta, result, &options)
                } else {
                    atb_into(alpha, left, right, beta, result, options)
                }
            })?;
        }
        Ok(())
    }
}

/// Sums in integers: the same for any distribution of A.
pub(super) struct ExactPairs<T> {
    /// The sums of all pairs of columns that this rank sees.
    sums: ExactSums<T>,
    /// The blocks that it sees, ascending, and where their columns begin among all that it sees.
    seen: Vec<(usize, usize)>,
    /// The entries that it computes, as places in `sums`; in the order of their segments.
    places: Vec<(usize, usize)>,
    /// A piece of all columns, row by row.
    joined: Vec<T>,
}

impl<T: MpiReal> ExactPairs<T> {
    /// Creates the sums of no rows within these bounds, which are of the columns of
    /// [`columns_seen`].
    pub(super) fn new(blocks: &Blocks, own: usize, bounds: &RowBounds<T>) -> Result<Self> {
        let mut seen: Vec<(usize, usize)> = Vec::new();
        let mut width = 0;
        for block in blocks_seen(blocks, own) {
            seen.push((block, width));
            width += blocks.columns(block).len();
        }
        let place_of = |column: usize| {
            let is_before = |&&(block, _): &&(usize, usize)| blocks.columns(block).end <= column;
            let (block, start) = seen[seen.iter().take_while(is_before).count()];
            start + column - blocks.columns(block).start
        };
        let mut places = reserved(blocks.len(own))?;
        for segment in blocks.segments(own) {
            let (row, first) = (place_of(segment.row), place_of(segment.cols.start));
            places.extend((first..first + segment.cols.len()).map(|col| (row, col)));
        }
        Ok(Self { sums: no_exact_sums(bounds, 0..width)?, seen, places, joined: Vec::new() })
    }

    /// Returns the number of entries that this rank computes.
    pub(super) fn len(&self) -> usize {
        self.places.len()
    }

    /// Returns the sum of entry k over the rows of this rank, in units of the grid.
    pub(super) fn sum(&self, k: usize) -> (i128, Flags) {
        let (i, j) = self.places[k];
        self.sums.entry(i, j)
    }

    /// Returns alpha times the value of a sum of entry k, rounded to T.
    pub(super) fn value(&self, k: usize, alpha: T, (c, flags): (i128, Flags)) -> T {
        let (i, j) = self.places[k];
        T::from_f64(alpha.to_f64() * self.sums.value(i, j, c, flags))
    }
}

impl<T: MpiReal> Pairs<T> for ExactPairs<T> {
    fn add(
        &mut self,
        exchange: &Exchange<'_, T>,
        seen: &Piece<'_, T>,
        share: Range<f64>,
        options: &AtaOptions<'_>,
    ) -> Result<()> {
        let blocks = exchange.blocks();
        let widths = self.seen.iter().map(|&(block, _)| blocks.columns(block).len());
        let width: usize = widths.sum();
        let rows = seen.nrows();
        if self.joined.len() < rows * width {
            self.joined = zeros(rows * width)?;
        }
        let joined = &mut self.joined[..rows * width];
        let parts: Vec<_> =
            self.seen.iter().map(|&(block, start)| (start, seen.columns(block))).collect();
        for (i, row) in joined.chunks_exact_mut(width.max(1)).enumerate() {
            for &(start, part) in &parts {
                let place = row[start..].iter_mut();
                place.zip(part.row(i).iter()).for_each(|(to, &x)| *to = x);
            }
        }
        let (sums, joined) = (&mut self.sums, MatRef::from_row_major_slice(joined, rows, width));
        exchange.world().with_progress(options, share, &|| false, |options| {
            add_exact(sums, &mut DenseRows(joined), options)
        })
    }
}

/// Returns the blocks that rank `own` of the blocks sees, ascending.
fn blocks_seen(blocks: &Blocks, own: usize) -> Vec<usize> {
    let mut seen: Vec<usize> = blocks.sources(own).chain([own]).collect();
    seen.sort_unstable();
    seen
}

/// Returns the columns of A that rank `own` of the blocks sees, ascending.
fn columns_seen(blocks: &Blocks, own: usize) -> Vec<usize> {
    blocks_seen(blocks, own).into_iter().flat_map(|block| blocks.columns(block)).collect()
}

/// Returns the bounds of the columns that this rank sees, over all rows of A, which is m x n; of no
/// columns for a rank outside of the blocks. All ranks call this function; each has its `part` of
/// A, which has these `columns`.
pub(super) fn bounds_of_seen<T: MpiReal>(
    world: &World,
    place: Option<(&Blocks, usize)>,
    part: MatRef<'_, T>,
    columns: Range<usize>,
    (m, n): (usize, usize),
    options: &AtaOptions<'_>,
) -> Result<RowBounds<T>> {
    let height = block_rows::<T>(part.ncols(), false);
    let quiet = options.clone().progress(Progress::none());
    let bounds = RowBounds::of(&mut DenseRows(part), None, height, &quiet);
    let bounds = world.agree(bounds)?;
    let seen = place.map_or_else(Vec::new, |(blocks, own)| columns_seen(blocks, own));
    Ok(joined_bounds_of_columns(world, &bounds, columns, (m, n), &seen))
}
