//! A^T A of rows that come in blocks: converted, centred or weighted on the way, A never copied
//! as a whole.

use faer::prelude::{IntoConst, Reborrow, ReborrowMut};
use faer::{MatMut, MatRef};

use super::options::AtaOptions;
use super::plan::Plan;
use super::run_symmetric;
use crate::base::{Error, Flow, Progress, Real, Result, Scratch, Workspace};
use crate::blas::BlasReal;

/// A source of the rows of a matrix, block by block.
pub trait RowBlocks<T> {
    /// Number of rows.
    fn nrows(&self) -> usize;

    /// Number of columns.
    fn ncols(&self) -> usize;

    /// Fills `out` with the rows from `first` on; every entry of `out` is written. Rows may be
    /// asked for more than once, always in blocks of consecutive rows inside the matrix.
    ///
    /// # Errors
    /// Whatever keeps the rows from being read.
    fn read(&mut self, first: usize, out: MatMut<'_, T>) -> Result<()>;
}

/// The rows of a matrix in memory, converted to the scalar asked for (f32 to f64 is exact).
#[derive(Debug, Clone, Copy)]
pub struct DenseRows<'a, S>(pub MatRef<'a, S>);

impl<S: Real, T: Real> RowBlocks<T> for DenseRows<'_, S> {
    fn nrows(&self) -> usize {
        self.0.nrows()
    }

    fn ncols(&self) -> usize {
        self.0.ncols()
    }

    fn read(&mut self, first: usize, mut out: MatMut<'_, T>) -> Result<()> {
        for i in 0..out.nrows() {
            for j in 0..out.ncols() {
                out[(i, j)] = T::from_f64(self.0[(first + i, j)].to_f64());
            }
        }
        Ok(())
    }
}

/// What is subtracted from every row before the product.
#[derive(Debug, Clone, Copy, Default)]
pub enum Center<'a, T> {
    /// Nothing.
    #[default]
    No,
    /// The mean of the rows, weighted if there are weights: the result is the scatter matrix, and
    /// the covariance when `alpha` is 1 / (m - 1).
    Mean,
    /// This row of n entries.
    Given(&'a [T]),
}

/// How [`ata_rows`] treats the rows. The default changes nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct RowOptions<'a, T> {
    /// m finite weights W, negative ones too: the product is `A^T diag(W) A`.
    pub weights: Option<&'a [T]>,
    /// Subtracted first.
    pub center: Center<'a, T>,
}

/// `C := alpha X^T W X + beta C`, where X are the rows less their centre and W the weights.
///
/// Rows are read block by block (twice for [`Center::Mean`]: the mean first, for stability), so the
/// extra memory is two blocks of rows and the scratch of [`ata`](super::ata) for one. C is n x n.
/// The result is the same, bit for bit, for every `options.par`.
///
/// # Errors
/// [`Error::Shape`] for C, the weights or the centre; [`Error::NonFinite`] for a weight or a centre;
/// [`Error::Argument`] when the weights of a mean sum to zero; the errors of the source, after which
/// C holds the blocks before; else as [`ata`](super::ata).
pub fn ata_rows<T: BlasReal>(
    alpha: T,
    rows: &mut dyn RowBlocks<T>,
    row_options: &RowOptions<'_, T>,
    mut beta: T,
    mut c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    let (m, n) = (rows.nrows(), rows.ncols());
    Error::check_shape("C", (n, n), c.shape())?;
    if n == 0 {
        return Ok(());
    }
    let mut blocks = AdjustedRows::new(rows, row_options)?;
    let height = block_height(m, n);
    let weighted = row_options.weights.is_some();
    let plan_for = |rows: usize| Plan::ata::<T>(rows, n, options);
    let scratch_for = |plan: &Plan| plan.scratch_len::<T>(options.par.threads(), !weighted);
    let mut plan = plan_for(height)?;
    let mut scratch = Scratch::new::<T>(scratch_for(&plan))?;
    let mut memory = Workspace::new(height * n * if weighted { 2 } else { 1 })?;
    let mut first = 0;
    // Once even without rows: C still gets its beta.
    loop {
        let count = height.min(m - first);
        if count != height {
            plan = plan_for(count)?;
            scratch.reserve::<T>(scratch_for(&plan))?;
        }
        let (x, wx) = memory.as_mut_slice().split_at_mut(height * n);
        let mut x = MatMut::from_row_major_slice_mut(&mut x[..count * n], count, n);
        blocks.read(first, x.rb_mut())?;
        let wx = row_options.weights.map(|weights| {
            let mut wx = MatMut::from_row_major_slice_mut(&mut wx[..count * n], count, n);
            for (i, &w) in weights[first..first + count].iter().enumerate() {
                for j in 0..n {
                    wx[(i, j)] = w * x[(i, j)];
                }
            }
            wx.into_const()
        });
        // The fraction of a block, told as that of all rows.
        let tell = |fraction: f64| {
            let all = (first as f64 + fraction * count as f64) / m.max(1) as f64;
            options.progress.map_or(Flow::Continue, |progress| progress(all))
        };
        let progress = options.progress.map(|_| &tell as Progress<'_>);
        let options = AtaOptions { progress, ..options.clone() };
        let scratch = scratch.as_mut_slice();
        run_symmetric(&plan, alpha, x.rb(), wx, beta, c.rb_mut(), &options, scratch)?;
        beta = T::ONE;
        first += count;
        if first >= m {
            return Ok(());
        }
    }
}

/// Rows of a block: about 4 million elements, and enough rows for the product to dominate its
/// addition to C. Not a matter of threads, or results would be.
pub(crate) fn block_height(m: usize, n: usize) -> usize {
    ((1 << 22) / n.max(1)).max(1024).min(m)
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
        let (m, n) = (rows.nrows(), rows.ncols());
        let finite = |what, values: &[T]| match values.iter().position(|v| !v.is_finite()) {
            Some(i) => Err(Error::NonFinite { what, index: (i, 0) }),
            None => Ok(()),
        };
        if let Some(weights) = options.weights {
            Error::check_shape("weights", (m, 1), (weights.len(), 1))?;
            finite("weights", weights)?;
        }
        let center = match options.center {
            Center::No => Vec::new(),
            Center::Given(center) => {
                Error::check_shape("center", (n, 1), (center.len(), 1))?;
                finite("center", center)?;
                center.to_vec()
            }
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

/// The (weighted) mean row. Sums are in f64, block by block.
fn mean<T: BlasReal>(rows: &mut dyn RowBlocks<T>, weights: Option<&[T]>) -> Result<Vec<T>> {
    let (m, n) = (rows.nrows(), rows.ncols());
    if m == 0 {
        return Ok(vec![T::ZERO; n]);
    }
    let weight = |i: usize| weights.map_or(1.0, |w| w[i].to_f64());
    let total: f64 = (0..m).map(weight).sum();
    let size: f64 = (0..m).map(|i| weight(i).abs()).sum();
    if total.abs() <= m as f64 * f64::EPSILON * size {
        return Err(Error::Argument { what: "weights", why: "they sum to zero: no mean".into() });
    }
    let height = block_height(m, n).min(4096);
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
