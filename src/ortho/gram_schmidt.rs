use std::ops::Range;

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Mat, MatMut, MatRef};

use super::inner::{Inner, check_finite};
use super::panel::pass;
use super::scale::ColumnPowers;
use crate::base::{Error, Par, Progress, Result, options};
use crate::dense::zeros;
use crate::sparse::{InnerSpace, Mass};

/// Columns that are projected together.
const PANEL: usize = 256;

options! {
    /// How [`gram_schmidt`] works; [`GramSchmidtOptions::reorthogonalized`] by default.
    ///
    /// ```
    /// use catamaran::{faer::mat, prelude::*, sparse::Mass};
    ///
    /// // The second column differs from the first by a thousandth.
    /// let a = mat![[1.0, 1.0], [0.0, 1e-3]];
    /// let rank = |options| {
    ///     gram_schmidt(a.as_ref(), &Mass::identity(2), &options).map(|found| found.kept.len())
    /// };
    /// assert_eq!(rank(GramSchmidtOptions::single_pass())?, 1);
    /// assert_eq!(rank(GramSchmidtOptions::reorthogonalized())?, 2);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    #[derive(Debug, Clone)]
    pub struct GramSchmidtOptions<'a> {
        /// A column is dropped if the part of it that is orthogonal to the columns before it is at
        /// most this fraction of its length. A column of zeros is always dropped.
        threshold: f64 = 1e-9, range "from 1e-13, and below 1";
        /// Whether columns are projected again until they no longer change.
        reorthogonalize: bool = true;
        /// Threads. Their number does not change the result.
        par: Par = Par::all();
        /// Progress callback, which may cancel.
        progress: Progress<'a> = Progress::none(), setter into;
    }
}

impl GramSchmidtOptions<'_> {
    /// Returns the thesis' mode `ours`: threshold 1e-2, one pass. `Q^T M Q` is the identity up to
    /// about 1e-13 / 1e-2 and the loss of orthogonality of the blocks before: accurate enough for
    /// least squares, but not for inner products.
    pub fn single_pass() -> Self {
        Self::new().threshold(1e-2).reorthogonalize(false)
    }

    /// Returns the thesis' mode `ours*`: threshold 1e-9, re-orthogonalized. `Q^T M Q` is the
    /// identity to rounding.
    pub fn reorthogonalized() -> Self {
        Self::new()
    }

    pub(super) fn check(&self) -> Result<()> {
        if (1e-13..1.0).contains(&self.threshold) {
            return Ok(());
        }
        let why = format!("{:e} is not between 1e-13 and 1", self.threshold);
        Err(Error::Argument { what: "threshold", why })
    }
}

/// The factor R of `A[:, kept] = Q R[:, kept]`. The other columns equal Q R up to the threshold.
#[derive(Debug, Clone)]
pub struct TriangularFactor {
    /// Rank x columns of A: coefficients of every column. Those of the kept columns form an upper
    /// triangle with a positive diagonal.
    pub r: Mat<f64>,
    /// The columns of A that Q is made of, ascending.
    pub kept: Vec<usize>,
}

/// An orthonormal basis Q and its [`TriangularFactor`].
#[derive(Debug, Clone)]
pub struct Orthonormal {
    /// n x rank, `Q^T M Q = I`.
    pub q: Mat<f64>,
    /// As [`TriangularFactor::r`].
    pub r: Mat<f64>,
    /// As [`TriangularFactor::kept`].
    pub kept: Vec<usize>,
}

impl Orthonormal {
    /// Applies a method that works in the memory of A to a copy of A.
    pub(super) fn of(
        a: MatRef<'_, f64>,
        in_place: impl FnOnce(MatMut<'_, f64>) -> Result<TriangularFactor>,
    ) -> Result<Self> {
        let mut q = zeros(a.nrows(), a.ncols())?;
        q.copy_from(a);
        let TriangularFactor { r, kept } = in_place(q.as_mut())?;
        q.truncate(a.nrows(), kept.len());
        Ok(Self { q, r, kept })
    }
}

/// Computes an M-orthonormal basis of the columns of A (n x c, any strides), taken from left to
/// right, by blocked classical Gram-Schmidt with rank detection (thesis, section 1.3; Stewart 2008
/// for the blocks, Giraud et al. 2005 for why twice is enough). Overlaps of either sign are
/// projected away.
///
/// The result is the same, bit for bit, for every `options.par`. Memory: a copy of A, R, and three
/// panels.
///
/// ```
/// use catamaran::{prelude::*, sparse::Mass};
///
/// // The second column is twice the first.
/// let a = Mat::<f64>::from_fn(5, 3, |i, j| [1.0, 2.0, i as f64][j]);
/// let found = gram_schmidt(a.as_ref(), &Mass::identity(5), &GramSchmidtOptions::new())?;
/// assert_eq!(found.kept, [0, 2]);
/// assert!((found.q.transpose() * &found.q - Mat::<f64>::identity(2, 2)).norm_max() < 1e-14);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] and [`Error::Argument`] of "mass", which may also make squares of lengths
/// overflow; [`Error::NonFinite`] of "A", and [`Error::Argument`] of "A" when the length of a
/// column overflows; [`Error::Argument`] for a threshold out of range, [`Error::OutOfMemory`],
/// [`Error::Cancelled`].
pub fn gram_schmidt(
    a: MatRef<'_, f64>,
    mass: &Mass,
    options: &GramSchmidtOptions<'_>,
) -> Result<Orthonormal> {
    Orthonormal::of(a, |q| gram_schmidt_in_place(q, mass, options))
}

/// Computes [`gram_schmidt`] in the memory of A. Afterwards the first `kept.len()` columns are Q,
/// and the other columns are unspecified. It is fastest when the columns of A are contiguous.
///
/// ```
/// use catamaran::{ortho::gram_schmidt_in_place, prelude::*, sparse::Mass};
///
/// // The second column is twice the first.
/// let a = Mat::<f64>::from_fn(5, 3, |i, j| [1.0, 2.0, i as f64][j]);
/// let mut q = a.clone();
/// let options = GramSchmidtOptions::new();
/// let found = gram_schmidt_in_place(q.as_mut(), &Mass::identity(5), &options)?;
/// let q = q.subcols(0, found.kept.len());
/// assert_eq!(found.kept, [0, 2]);
/// assert!((q * &found.r - &a).norm_max() < 1e-13);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`gram_schmidt`]; A is unspecified after an error.
pub fn gram_schmidt_in_place(
    a: MatMut<'_, f64>,
    mass: &Mass,
    options: &GramSchmidtOptions<'_>,
) -> Result<TriangularFactor> {
    mass.check(a.nrows())?;
    options.progress.watch(|| gram_schmidt_of(a, mass, options))
}

/// Computes [`gram_schmidt_in_place`] of the rows that this process holds; the mass has been
/// checked.
pub(crate) fn gram_schmidt_of(
    mut a: MatMut<'_, f64>,
    space: &dyn InnerSpace,
    options: &GramSchmidtOptions<'_>,
) -> Result<TriangularFactor> {
    let c = a.ncols();
    options.check()?;
    check_finite(a.rb())?;
    let powers = ColumnPowers::bring_near_one(a.rb_mut(), space)?;
    let mut inner = Inner::new(space, PANEL.min(c), options.par)?;
    let mut basis = Growing { r: zeros(space.dimension().min(c), c)?, kept: Vec::new(), options };
    inner.enter(a.rb_mut());
    for start in (0..c).step_by(PANEL) {
        let end = (start + PANEL).min(c);
        basis.add(&mut inner, a.rb_mut(), start..end)?;
        let done = end as f64 / c as f64;
        options.progress.report(done * done)?;
    }
    let Growing { mut r, kept, .. } = basis;
    inner.leave(a.rb_mut().subcols_mut(0, kept.len()));
    r.truncate(kept.len(), c);
    powers.undo(r.as_mut())?;
    Ok(TriangularFactor { r, kept })
}

/// A basis in the first columns of A that grows panel by panel.
struct Growing<'o> {
    r: Mat<f64>,
    kept: Vec<usize>,
    options: &'o GramSchmidtOptions<'o>,
}

impl Growing<'_> {
    /// Adds the part of a panel that is orthogonal to the basis: all columns at once or, where that
    /// would lose too much of them, by halves. The panel still holds columns of A.
    fn add(
        &mut self,
        inner: &mut Inner<'_>,
        mut a: MatMut<'_, f64>,
        range: Range<usize>,
    ) -> Result<()> {
        let (start, width) = (range.start, range.len());
        let copied = if self.options.reorthogonalize && width > 1 { width } else { 0 };
        let mut columns = zeros(a.nrows(), copied)?;
        columns.copy_from(a.rb().subcols(start, copied));
        let (mut left, right) = a.rb_mut().split_at_col_mut(start);
        let mut panel = right.subcols_mut(0, width);
        let q = left.rb().subcols(0, self.kept.len());
        let Some(block) = orthonormalize(inner, q, panel.rb_mut(), self.options)? else {
            panel.copy_from(&columns);
            drop(columns);
            let middle = start + width / 2;
            self.add(inner, a.rb_mut(), start..middle)?;
            return self.add(inner, a, middle..range.end);
        };
        // No more columns are independent than the space has dimensions, whatever rounding leaves.
        let before = self.kept.len();
        let rank = block.kept.len().min(self.r.nrows() - before);
        self.r.as_mut().submatrix_mut(0, start, before, width).copy_from(&block.above);
        self.r
            .as_mut()
            .submatrix_mut(before, start, rank, width)
            .copy_from(block.own.as_ref().subrows(0, rank));
        // Columns move left, one by one: they may overlap.
        for j in 0..rank {
            let to = before + j;
            match to < start {
                true => left.rb_mut().col_mut(to).copy_from(panel.rb().col(j)),
                false if to - start != j => {
                    let (mut to_part, from_part) = panel.rb_mut().split_at_col_mut(j);
                    to_part.rb_mut().col_mut(to - start).copy_from(from_part.rb().col(0));
                }
                false => {}
            }
        }
        self.kept.extend(block.kept[..rank].iter().map(|j| start + j));
        Ok(())
    }
}

/// The result of [`orthonormalize`] for one panel.
struct PanelFactors {
    kept: Vec<usize>,
    /// Coefficients of the panel's columns in the basis before it; `own`: in its own columns.
    above: Mat<f64>,
    own: Mat<f64>,
}

/// Makes the first columns of the panel orthonormal, and orthogonal to Q. Returns `None` when too
/// much of a column is lost with others: the part along a column that a later pass drops has
/// already been removed from the columns after it.
fn orthonormalize(
    inner: &mut Inner<'_>,
    q: MatRef<'_, f64>,
    mut panel: MatMut<'_, f64>,
    options: &GramSchmidtOptions<'_>,
) -> Result<Option<PanelFactors>> {
    /// A pass is the last one if it leaves this much of normalized columns (Giraud et al.).
    const ENOUGH: f64 = 0.5;
    const PASSES: usize = 5;
    /// Part of a kept column that may be lost.
    const ROUNDING: f64 = 1e-14;
    let width = panel.ncols();
    let sizes = inner.lengths(panel.rb())?;
    let mut limits: Vec<f64> = sizes.iter().map(|size| size * options.threshold).collect();
    let mut lost = vec![0.0; width];
    let mut above = inner.project(q, panel.rb_mut())?;
    let first = pass(inner, panel.rb_mut(), &limits)?;
    let (mut kept, mut own, mut lengths) = (first.kept, first.r, first.lengths);
    limits = kept.iter().map(|&j| limits[j]).collect();
    for _ in 1..PASSES {
        if !options.reorthogonalize || kept.is_empty() {
            break;
        }
        // The columns have length 1 now, so the limits become relative to that length.
        limits.iter_mut().zip(&lengths).for_each(|(limit, length)| *limit /= length);
        let mut x = panel.rb_mut().subcols_mut(0, kept.len());
        let more = inner.project(q, x.rb_mut())?;
        inner.add_product(above.as_mut(), more.as_ref(), own.as_ref())?;
        let again = pass(inner, x.rb_mut(), &limits)?;
        for &(j, length) in &again.dropped {
            for (k, lost) in lost.iter_mut().enumerate().filter(|&(k, _)| k != kept[j]) {
                *lost += length * own[(j, k)].abs();
            }
        }
        let mut next = zeros(again.kept.len(), width)?;
        inner.add_product(next.as_mut(), again.r.as_ref(), own.as_ref())?;
        own = next;
        kept = again.kept.iter().map(|&i| kept[i]).collect();
        let mut allowed = vec![options.threshold; width];
        kept.iter().for_each(|&k| allowed[k] = ROUNDING);
        if (0..width).any(|k| lost[k] > allowed[k] * sizes[k]) {
            return Ok(None);
        }
        limits = again.kept.iter().map(|&i| limits[i]).collect();
        lengths = again.lengths;
        if lengths.iter().all(|length| *length >= ENOUGH) {
            break;
        }
    }
    Ok(Some(PanelFactors { kept, above, own }))
}
