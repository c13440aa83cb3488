//! A^T A of rows that come in blocks: converted, centred or weighted on the way, A never copied
//! as a whole.

use faer::prelude::ReborrowMut;
use faer::{MatMut, MatRef};

use super::accumulator::Accumulator;
use super::exact::ExactSums;
use super::extended::ExtendedGram;
use super::float;
use super::grid::{RowBounds, Shift};
use super::moments::{Moments, check_weight};
use super::pass::{FIRST_PASS, for_each_block_of};
use super::source::RowBlocks;
use super::stream::stream;
use crate::base::{Error, Real, Result, Workspace, block_rows, finite_weights, options, zeros};
use crate::blas::BlasReal;
use crate::product::combine::in_lower;
use crate::product::{AtaOptions, ata_into};

/// What is subtracted from every row before the product.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Center<'a, T> {
    /// Nothing.
    No,
    /// The mean of the rows, weighted if there are weights: the result is the scatter matrix, and
    /// the covariance when `alpha` is 1 / (m - 1).
    Mean,
    /// This row of n entries.
    Given(&'a [T]),
}

options! {
    /// How [`ata_rows`] treats the rows. The default changes nothing.
    ///
    /// ```
    /// use catamaran::rows::{Center, RowOptions};
    ///
    /// let weights = vec![1.0, 0.5, 2.0];
    /// let options = RowOptions::new().weights(&weights[..]).center(Center::Mean);
    /// assert_eq!(options.weights, Some(&[1.0, 0.5, 2.0][..]));
    /// ```
    #[derive(Debug, Clone, Copy)]
    pub struct RowOptions<'a, T> {
        /// m finite weights W, negative ones too: the product is `A^T diag(W) A`.
        weights: Option<&'a [T]> = None, setter into;
        /// Subtracted first.
        center: Center<'a, T> = Center::No;
    }
}

impl<T: Real> RowOptions<'_, T> {
    /// Checks that the options fit m x n rows.
    fn check(&self, m: usize, n: usize) -> Result<()> {
        finite_weights(m, self.weights)?;
        match self.center {
            Center::Given(center) => {
                Error::check_shape("center", (n, 1), (center.len(), 1))?;
                match center.iter().position(|x| !x.is_finite()) {
                    Some(i) => Err(Error::NonFinite { what: "center", index: (i, 0) }),
                    None => Ok(()),
                }
            }
            Center::Mean if m > 0 => {
                let (total, size) = weight_sums(m, self.weights);
                check_weight(m as f64, total, size)
            }
            Center::Mean | Center::No => Ok(()),
        }
    }
}

/// Returns the sum of `m` weights, and of their absolute values.
fn weight_sums<T: Real>(m: usize, weights: Option<&[T]>) -> (f64, f64) {
    let weights = match weights {
        Some(weights) => weights,
        None => return (m as f64, m as f64),
    };
    let values = || weights.iter().map(|w| w.to_f64());
    (values().sum(), values().map(f64::abs).sum())
}

/// Computes `C := alpha X^T W X + beta C`, where X are the rows less their centre and W the
/// weights.
///
/// Rows are read once, block by block, the next block by another thread (unless `options.par` is
/// [`Par::Seq`](crate::Par::Seq)). For a product about the mean, the mean of the first block is
/// subtracted first, for stability. The extra memory is two blocks of rows, one more with weights,
/// and the scratch of [`ata_into`] for one. C is n x n. The result is the same, bit for
/// bit, for every `options.par`. [`stream`](super::stream()) can keep, resume and merge sums.
///
/// On the exact path, if the options request it, rows are read twice, once for their bounds, and 16
/// bytes for each entry of a triangle of C are needed. The result then does not depend on the order
/// of the rows either, as that of [`Accumulator::exact`](super::Accumulator::exact). It is rounded
/// differently from that of [`ata_into`], which knows the norms of the columns. With
/// `alpha == 0` no row is read.
///
/// ```
/// use catamaran::rows::{Center, DenseRows, RowOptions, ata_rows};
/// use catamaran::{AtaOptions, faer::{Mat, mat}};
///
/// let a = mat![[1.0, 8.0], [2.0, 6.0], [3.0, 1.0]];
/// let mean = RowOptions::new().center(Center::Mean);
/// let mut covariance = Mat::zeros(2, 2);
/// let (alpha, options) = (1.0 / 2.0, AtaOptions::new());
/// ata_rows(alpha, &mut DenseRows(a.as_ref()), &mean, 0.0, covariance.as_mut(), &options)?;
/// assert_eq!(covariance[(0, 0)], 1.0);
/// assert_eq!(covariance[(1, 0)], -3.5);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] for C, the weights or the centre; [`Error::NonFinite`] for a weight or a
/// centre; [`Error::Argument`] when the weights of a mean sum to zero; the errors of the source,
/// after which C holds the blocks before; else as [`ata_into`].
pub fn ata_rows<T: BlasReal>(
    alpha: T,
    rows: &mut (dyn RowBlocks<T> + Send),
    row_options: &RowOptions<'_, T>,
    mut beta: T,
    mut c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    let (m, n) = (rows.nrows(), rows.ncols());
    Error::check_shape("C", (n, n), c.shape())?;
    options.check()?;
    if n == 0 {
        return Ok(());
    }
    row_options.check(m, n)?;
    let weights = row_options.weights;
    if m == 0 || alpha == T::ZERO {
        // C is still scaled by beta, and NaN times 0 is not added to it.
        let none = MatRef::from_row_major_slice(&[], 0, n);
        return ata_into(alpha, none, beta, c, options);
    }
    let height = block_rows::<T>(n, weights.is_some());
    if options.asks_for_exact() {
        return exact_rows(alpha, rows, row_options, height, beta, c, options);
    }
    let mut moments = match row_options.center {
        Center::No => Moments::new(n, false)?,
        Center::Mean => Moments::new(n, true)?,
        Center::Given(center) => Moments::with_shift(center)?,
    };
    for_each_block_of(rows, weights, height, 0, options, |count, block, weights, pass| {
        let rows = (count, block, weights);
        float::add(&mut moments, rows, &(0..n), alpha, beta, None, c.rb_mut(), pass)?;
        beta = T::ONE;
        Ok(())
    })?;
    if !moments.centered {
        return Ok(());
    }
    in_lower(c, options.uplo, |lower| moments.correct(alpha.to_f64(), 0, lower))
}

/// Computes [`ata_rows`] in integers.
fn exact_rows<T: BlasReal>(
    alpha: T,
    rows: &mut (dyn RowBlocks<T> + Send),
    row_options: &RowOptions<'_, T>,
    height: usize,
    beta: T,
    c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    let weights = row_options.weights;
    let shift = match row_options.center {
        Center::No => Shift::No,
        Center::Mean => Shift::Near,
        Center::Given(center) => Shift::Given(center),
    };
    let [first, rest] = [0.0..FIRST_PASS, FIRST_PASS..1.0].map(|part| options.progress.part(part));
    let bounds = RowBounds::of(rows, weights, height, &options.clone().progress(first))?;
    let mut sums: ExactSums<T> = ExactSums::new(&bounds, 0..rows.ncols(), shift)?;
    let options = options.clone().progress(rest);
    for_each_block_of(rows, weights, height, 0, &options, |count, block, weights, pass| {
        sums.add(count, block, weights, false, pass)
    })?;
    in_lower(c, options.uplo, |mut lower| {
        sums.for_each_value(|i, j, value| {
            let value = T::from_f64(alpha.to_f64() * value);
            let c = &mut lower[(i, j)];
            *c = if beta == T::ZERO { value } else { value + beta * *c };
        })
    })
}

/// Computes `X^T W X` in extended precision, where X are the rows (m x n) or the rows less their
/// mean, and W the weights.
///
/// Rows are read twice, block by block: once for their bounds, once for the sums of an
/// [`Accumulator::extended`](super::Accumulator::extended). The result is the same, bit for bit,
/// for every `options.par`, any order of the rows and any instruction set. Beside two blocks and
/// the scratch of a product, 32 bytes for each entry of a triangle are needed, which the result
/// keeps.
///
/// ```
/// use catamaran::rows::{DenseRows, RowOptions, ata_extended};
/// use catamaran::{AtaOptions, faer::mat};
///
/// // The classical example whose Gram matrix in f64 is singular.
/// let e = 2f64.powi(-30);
/// let a = mat![[1.0, 1.0], [e, 0.0], [0.0, e]];
/// let (rows, plain) = (&mut DenseRows(a.as_ref()), RowOptions::<f64>::new());
/// let gram = ata_extended(rows, &plain, &AtaOptions::new())?;
/// assert_eq!(gram.entry(0, 0), [1.0, e * e, 0.0]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::NonFinite`] for the weights and for the rows, before any product; [`Error::Shape`] for
/// weights; [`Error::Argument`] for a given centre and for weights of a mean that sum to zero; the
/// errors of the source; [`Error::OutOfMemory`], [`Error::Cancelled`].
pub fn ata_extended<T: BlasReal>(
    rows: &mut (dyn RowBlocks<T> + Send),
    row_options: &RowOptions<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<ExtendedGram> {
    options.check()?;
    let weights = row_options.weights;
    row_options.check(rows.nrows(), rows.ncols())?;
    let centered = match row_options.center {
        Center::No => false,
        Center::Mean => true,
        Center::Given(_) => {
            let why = "must be none or the mean for extended sums";
            return Err(Error::Argument { what: "center", why: why.into() });
        }
    };
    // The residues of a block are recombined once: few rows do not pay for that where C is large.
    // No block is larger than the sums.
    let width = rows.coding().map_or(rows.ncols(), |coding| coding.width());
    let height = block_rows::<T>(width, weights.is_some()).max(width);
    let [first, rest] = [0.0..FIRST_PASS, FIRST_PASS..1.0].map(|part| options.progress.part(part));
    let bounds = RowBounds::of_finite(rows, weights, height, &options.clone().progress(first))?;
    let mut sum = Accumulator::extended(&bounds, centered)?;
    let options = options.clone().progress(rest);
    stream(rows, weights, height, &mut sum, &options, &mut |_| Ok(()))?;
    sum.finish_extended(options.par)
}

/// Rows less their centre.
pub(crate) struct AdjustedRows<'r, T> {
    rows: &'r mut dyn RowBlocks<T>,
    /// n entries, or none.
    center: Vec<T>,
}

impl<'r, T: BlasReal> AdjustedRows<'r, T> {
    /// Checks the options and computes the mean if asked to.
    pub(crate) fn new(rows: &'r mut dyn RowBlocks<T>, options: &RowOptions<'_, T>) -> Result<Self> {
        options.check(rows.nrows(), rows.ncols())?;
        let center = match options.center {
            Center::No => Vec::new(),
            Center::Given(center) => center.to_vec(),
            Center::Mean => mean(rows, options.weights)?,
        };
        Ok(Self { rows, center })
    }

    pub(crate) fn read(&mut self, first: usize, mut out: MatMut<'_, T>) -> Result<()> {
        self.rows.read(first, out.rb_mut())?;
        if !self.center.is_empty() {
            for i in 0..out.nrows() {
                for (j, &center) in self.center.iter().enumerate() {
                    out[(i, j)] -= center;
                }
            }
        }
        Ok(())
    }
}

/// Returns the (weighted) mean row. Sums are in f64, block by block.
fn mean<T: BlasReal>(rows: &mut dyn RowBlocks<T>, weights: Option<&[T]>) -> Result<Vec<T>> {
    let (m, n) = (rows.nrows(), rows.ncols());
    if m == 0 || n == 0 {
        return zeros(n);
    }
    let weight = |i: usize| weights.map_or(1.0, |w| w[i].to_f64());
    let (total, _) = weight_sums(m, weights);
    let height = block_rows::<T>(n, true).min(m).min(4096);
    let mut memory = Workspace::new(height * n)?;
    let mut sums = vec![0.0; n];
    for first in (0..m).step_by(height) {
        let count = height.min(m - first);
        let memory = &mut memory.as_mut_slice()[..count * n];
        let mut block = MatMut::from_row_major_slice_mut(memory, count, n);
        rows.read(first, block.rb_mut())?;
        let mut block_sums = vec![0.0; n];
        for i in 0..count {
            let w = weight(first + i);
            for (j, sum) in block_sums.iter_mut().enumerate() {
                *sum += w * block[(i, j)].to_f64();
            }
        }
        for (sum, block_sum) in sums.iter_mut().zip(block_sums) {
            *sum += block_sum;
        }
    }
    Ok(sums.into_iter().map(|s| T::from_f64(s / total)).collect())
}
