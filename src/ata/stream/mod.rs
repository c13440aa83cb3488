//! A^T A of rows that are read once, block by block, while the last block is multiplied; what is there so far can be
//! kept, gone on with, and merged. See docs/algorithms/ata.md, "Streaming".

mod accumulator;
mod blocks;
mod format;
mod moments;
mod plan;

pub use accumulator::{Accumulator, Strip};
pub use blocks::block_rows;
pub use format::scalar_of;
pub use plan::StreamPlan;

pub(crate) use accumulator::check_weights;
pub(crate) use blocks::for_each_block;
pub(crate) use moments::{Moments, check_weight};

use std::ops::Range;

use super::options::AtaOptions;
use super::rows::RowBlocks;
use crate::base::{Error, Result};
use crate::blas::BlasReal;

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
        same("the number of rows of a block", accumulator.block_rows, block_rows)?;
    }
    accumulator.expected_rows = m as u64;
    accumulator.block_rows = block_rows as u64;
    let start = accumulator.rows() as usize;
    for_each_block(rows, start, block_rows, options.par, |first, block| {
        let count = block_rows.min(m - first);
        let weights = weights.map(|weights| &weights[first..first + count]);
        with_share(options, share_of_rows(first, count, m), |options| {
            accumulator.add_block(count, block, weights, options)
        })?;
        after_block(accumulator)
    })
}

/// Calls `work` with options whose progress is part `share` of the whole.
pub(crate) fn with_share<R>(
    options: &AtaOptions<'_>,
    share: Range<f64>,
    work: impl FnOnce(&AtaOptions<'_>) -> R,
) -> R {
    work(&AtaOptions { progress: options.progress.part(share), ..options.clone() })
}

/// The share that `count` rows from `first` on, of `m`, have of the whole.
pub(crate) fn share_of_rows(first: usize, count: usize, m: usize) -> Range<f64> {
    let part = |rows: usize| rows as f64 / m.max(1) as f64;
    part(first)..part(first + count)
}
