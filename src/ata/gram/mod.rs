//! A^T A of rows that come in blocks, from memory, files, sparse matrices or other ranks: one accumulator for all. What
//! is there so far can be kept, gone on with, and merged. See docs/algorithms/ata.md, "Streaming".

mod accumulator;
mod blocks;
mod exact;
mod float;
mod format;
mod grid;
mod moments;
mod plan;
mod product;
mod rows;
mod source;
#[cfg(feature = "geometry")]
mod sparse;
mod strip;
#[cfg(test)]
mod tests;
mod wide;

pub use accumulator::Accumulator;
pub use blocks::block_rows;
pub use format::scalar_of;
pub use grid::RowBounds;
pub use plan::StreamPlan;
pub use rows::{Center, RowOptions, ata_rows};
pub use source::{DenseRows, RowBlocks};
#[cfg(feature = "geometry")]
pub use sparse::{ata_sparse, sparse_is_faster, sparse_multiplications};
pub use strip::Strip;

#[cfg(feature = "mpi")]
pub(crate) use exact::ExactSums;
pub(crate) use rows::AdjustedRows;

use std::ops::Range;

use self::accumulator::check_weights;
use self::blocks::for_each_block;
#[cfg(feature = "mpi")]
use self::grid::Shift;
use self::product::Pass;
use super::options::AtaOptions;
use crate::base::{Error, Result};
use crate::blas::BlasReal;

/// The share of a pass for bounds among two passes, as progress counts.
const FIRST_PASS: f64 = 0.1;

/// Called after each block; an error ends the pass.
pub type AfterBlock<'a, T> = &'a mut dyn FnMut(&Accumulator<T>) -> Result<()>;

/// Adds the m rows of a source, with m `weights` if there are any, to `accumulator`, in blocks of `block_rows`
/// ([`block_rows()`] gives a good number). A thread reads the next block meanwhile, unless `options.par` is
/// [`Par::Seq`](crate::Par::Seq).
///
/// An accumulator of the first k blocks of this source, such as `after_block` may have kept, goes on with the
/// next one, and ends as the same bytes as if it had never stopped; any other must be empty. The result is the same,
/// bit for bit, for every `options.par`. `options.progress` is told the fraction of all rows.
///
/// Memory beside the accumulator: two blocks, one more with weights, and the scratch of [`ata`](super::ata) for one.
///
/// # Errors
/// [`Error::Shape`] and [`Error::NonFinite`] for the weights; [`Error::Argument`] when the accumulator is of a source
/// of another shape, or of other blocks; those of the source and of `after_block`; else as [`ata`](super::ata).
pub fn stream<T: BlasReal>(
    rows: &mut (dyn RowBlocks<T> + Send),
    weights: Option<&[T]>,
    block_rows: usize,
    accumulator: &mut Accumulator<T>,
    options: &AtaOptions<'_>,
    after_block: AfterBlock<'_, T>,
) -> Result<()> {
    let (m, n) = (rows.nrows(), rows.ncols());
    check_weights(m, weights)?;
    let same = |what: &str, was: u64, is: usize| {
        if was == is as u64 {
            return Ok(());
        }
        let why = format!("{what} was {was}, and is {is} now");
        Err(Error::Argument { what: "accumulator", why })
    };
    same("the number of columns", accumulator.ncols as u64, n)?;
    if block_rows == 0 {
        return Err(Error::Argument { what: "block rows", why: "must be at least 1".into() });
    }
    if accumulator.rows() > 0 {
        same("the number of rows", accumulator.expected_rows, m)?;
        if !accumulator.is_exact() {
            same("the number of rows of a block", accumulator.block_rows, block_rows)?;
        }
    }
    let mut progress = options.progress;
    if options.asks_for_exact() && !accumulator.is_exact() {
        let [first, rest] = [0.0..FIRST_PASS, FIRST_PASS..1.0].map(|part| progress.part(part));
        accumulator.make_exact(|| {
            RowBounds::of(rows, weights, block_rows, &options.clone().progress(first))
        })?;
        progress = rest;
    }
    accumulator.expected_rows = m as u64;
    accumulator.block_rows = block_rows as u64;
    let start = accumulator.rows() as usize;
    let options = &options.clone().progress(progress);
    for_each_block_of(rows, weights, block_rows, start, options, |count, block, weights, pass| {
        accumulator.add(count, block, weights, pass)?;
        after_block(accumulator)
    })
}

/// Calls `work(count, block, weights, pass)` for each block of `height` rows from row `start` on.
fn for_each_block_of<'o, T: BlasReal>(
    rows: &mut (dyn RowBlocks<T> + Send),
    weights: Option<&[T]>,
    height: usize,
    start: usize,
    options: &AtaOptions<'o>,
    mut work: impl FnMut(usize, &mut [T], Option<&[T]>, &mut Pass<'o, T>) -> Result<()>,
) -> Result<()> {
    let m = rows.nrows();
    let mut pass = Pass::new(options)?;
    for_each_block(rows, start, height, options.par, |first, block| {
        let count = height.min(m - first);
        let weights = weights.map(|weights| &weights[first..first + count]);
        pass.progress = options.progress.part(share_of_rows(first, count, m));
        work(count, block, weights, &mut pass)
    })
}

/// The share that `count` rows from `first` on, of `m`, have of the whole.
fn share_of_rows(first: usize, count: usize, m: usize) -> Range<f64> {
    let part = |rows: usize| rows as f64 / m.max(1) as f64;
    part(first)..part(first + count)
}

/// The exact sums of some rows of C, of all rows of a source.
#[cfg(feature = "mpi")]
pub(crate) fn exact_sums<T: BlasReal>(
    rows: &mut (dyn RowBlocks<T> + Send),
    bounds: &RowBounds<T>,
    strip: Range<usize>,
    options: &AtaOptions<'_>,
) -> Result<ExactSums<T>> {
    let mut sums = ExactSums::new(bounds, strip, Shift::No)?;
    let height = block_rows::<T>(rows.ncols(), false);
    for_each_block_of(rows, None, height, 0, options, |count, block, weights, pass| {
        sums.add(count, block, weights, false, pass)
    })?;
    Ok(sums)
}
