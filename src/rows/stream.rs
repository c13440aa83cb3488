//! Adds the rows of a source to an accumulator.

#[cfg(feature = "mpi")]
use std::ops::Range;

use super::accumulator::Accumulator;
use super::blocks::check_block_rows;
use super::coded::for_each_block_as;
#[cfg(feature = "mpi")]
use super::exact::ExactSums;
use super::grid::RowBounds;
#[cfg(feature = "mpi")]
use super::grid::Shift;
use super::pass::FIRST_PASS;
#[cfg(feature = "mpi")]
use super::pass::for_each_block_of;
use super::source::RowBlocks;
#[cfg(feature = "mpi")]
use crate::base::block_rows;
use crate::base::{Error, Result, finite_weights};
use crate::blas::BlasReal;
use crate::product::AtaOptions;

/// A function that is called after each block; an error ends the pass.
pub type AfterBlock<'a, T> = &'a mut dyn FnMut(&Accumulator<T>) -> Result<()>;

/// Adds the m rows of a source, with m `weights` if there are any, to `accumulator`, in blocks of
/// `block_rows` ([`block_rows()`](crate::base::block_rows()) gives a good number). A thread reads
/// the next block meanwhile, unless `options.par` is [`Par::Seq`](crate::Par::Seq).
///
/// An accumulator of the first k blocks of this source, for instance one that `after_block` has
/// kept, continues with the next block, and ends with the same bytes as without a stop; any other
/// must be empty. The result is the same, bit for bit, for every `options.par`. `options.progress`
/// receives the fraction of all rows.
///
/// When the options request the exact path by name ([`AtaOptions::asks_for_exact`]), an empty
/// accumulator becomes an exact one, with the bounds that a first pass over the rows finds: C is
/// then the same bytes for any blocks. An accumulator that is exact already
/// ([`Accumulator::exact`]) stays exact, whatever the options are, and needs no such pass.
///
/// Memory beside the accumulator: two blocks, one more with weights, and the scratch of
/// [`ata_into`](crate::ata_into) for one.
///
/// ```
/// use catamaran::rows::{Accumulator, DenseRows, stream};
/// use catamaran::{AtaOptions, Uplo, faer::Mat};
///
/// let a = Mat::<f64>::from_fn(10, 2, |i, j| (i + j) as f64);
/// let (mut sum, mut blocks) = (Accumulator::<f64>::new(2, false)?, 0);
/// stream(&mut DenseRows(a.as_ref()), None, 4, &mut sum, &AtaOptions::new(), &mut |_| {
///     blocks += 1; // a checkpoint could be written here
///     Ok(())
/// })?;
/// assert_eq!((blocks, sum.rows()), (3, 10));
/// assert_eq!(sum.finish(1.0, Uplo::Both)?.as_ref(), a.transpose() * &a);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] and [`Error::NonFinite`] for the weights; [`Error::Argument`] when the
/// accumulator is of a source of another shape, or of other blocks; those of the source and of
/// `after_block`; else as [`ata_into`](crate::ata_into).
pub fn stream<T: BlasReal>(
    rows: &mut (dyn RowBlocks<T> + Send),
    weights: Option<&[T]>,
    block_rows: usize,
    accumulator: &mut Accumulator<T>,
    options: &AtaOptions<'_>,
    after_block: AfterBlock<'_, T>,
) -> Result<()> {
    let (m, n) = (rows.nrows(), rows.ncols());
    finite_weights(m, weights)?;
    let same = |what: &str, was: u64, is: usize| {
        if was == is as u64 {
            return Ok(());
        }
        let why = format!("{what} was {was}, and is {is} now");
        Err(Error::Argument { what: "accumulator", why })
    };
    same("the number of columns", accumulator.ncols as u64, n)?;
    check_block_rows(block_rows)?;
    if accumulator.rows() > 0 {
        same("the number of rows", accumulator.expected_rows, m)?;
        if accumulator.rows() > m as u64 {
            let why = format!("{} rows are summed already, of {m}", accumulator.rows());
            return Err(Error::Argument { what: "accumulator", why });
        }
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
    let coding = rows.coding().filter(|_| accumulator.is_extended());
    let coding = coding.as_ref();
    for_each_block_as(coding, rows, weights, block_rows, start, options, |count, block, w, pass| {
        accumulator.add(coding, count, block, w, pass)?;
        after_block(accumulator)
    })
}

/// Computes the exact sums of some rows of C, over all rows of a source.
#[cfg(feature = "mpi")]
pub(crate) fn exact_sums<T: BlasReal>(
    rows: &mut (dyn RowBlocks<T> + Send),
    bounds: &RowBounds<T>,
    strip: Range<usize>,
    options: &AtaOptions<'_>,
) -> Result<ExactSums<T>> {
    let mut sums = no_exact_sums(bounds, strip)?;
    add_exact(&mut sums, rows, options)?;
    Ok(sums)
}

/// Returns the exact sums of some rows of C, over no rows yet.
#[cfg(feature = "mpi")]
pub(crate) fn no_exact_sums<T: BlasReal>(
    bounds: &RowBounds<T>,
    strip: Range<usize>,
) -> Result<ExactSums<T>> {
    ExactSums::new(bounds, strip, Shift::No)
}

/// Adds all rows of a source to exact sums.
#[cfg(feature = "mpi")]
pub(crate) fn add_exact<T: BlasReal>(
    sums: &mut ExactSums<T>,
    rows: &mut (dyn RowBlocks<T> + Send),
    options: &AtaOptions<'_>,
) -> Result<()> {
    let height = block_rows::<T>(rows.ncols(), false);
    for_each_block_of(rows, None, height, 0, options, |count, block, weights, pass| {
        sums.add(count, block, weights, false, pass)
    })
}
