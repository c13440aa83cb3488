use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Mat, MatMut};

use super::inner::{Inner, check_finite, check_squares};
use super::scale::ColumnPowers;
use crate::base::{Error, Par, Progress, Result};
use crate::dense::{cholesky, divide_by_upper, zeros};
use crate::sparse::{InnerSpace, Mass};

/// Computes `A = Q R` with `Q^T M Q = I` by shifted Cholesky QR (Fukaya et al. 2020), for columns
/// that are independent. A (n x c, any strides) becomes Q; R (c x c), upper triangular with a
/// positive diagonal, is returned.
///
/// It takes two passes over A if the condition of A allows, up to six otherwise. This is about
/// half the work of [`gram_schmidt`](super::gram_schmidt()), which also accepts columns that depend
/// on others. The result is the same, bit for bit, for every `par`.
///
/// ```
/// use catamaran::{prelude::*, sparse::Mass};
///
/// let a = Mat::<f64>::from_fn(6, 2, |i, j| ((i + 1) as f64).powi(j as i32));
/// let mut q = a.clone();
/// let r = cholesky_qr(q.as_mut(), &Mass::identity(6), Par::Seq)?;
/// assert!((&q * &r - &a).norm_max() < 1e-13);
/// assert!((q.transpose() * &q - Mat::<f64>::identity(2, 2)).norm_max() < 1e-13);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] of "A" when its columns are linearly dependent to working precision, or when
/// the length of one is no finite number, and of "mass" when masses make squares of lengths
/// overflow; A is then unspecified. Other errors are those of
/// [`gram_schmidt`](super::gram_schmidt()).
pub fn cholesky_qr(a: MatMut<'_, f64>, mass: &Mass, par: Par) -> Result<Mat<f64>> {
    mass.check(a.nrows())?;
    cholesky_qr_of(a, mass, par, Progress::none())
}

/// Computes [`cholesky_qr`] of the rows that this process holds; the mass has been checked. Reports
/// progress before each pass.
///
/// # Errors
/// Those of [`cholesky_qr`], and [`Error::Cancelled`].
pub fn cholesky_qr_of(
    mut a: MatMut<'_, f64>,
    space: &dyn InnerSpace,
    par: Par,
    progress: Progress<'_>,
) -> Result<Mat<f64>> {
    /// Distance of the Gram matrix from the identity below which a pass is the last one.
    const NEAR: f64 = 1e-4;
    /// Remainder of a column, relative to its length, that may consist of rounding errors.
    const DEPENDENT: f64 = 1e-14;
    const PASSES: usize = 6;
    let (n, c) = (space.dimension(), a.ncols());
    let refuse = |why: String| Err(Error::Argument { what: "A", why });
    if c > n {
        return refuse(format!("{c} columns of {n} rows can't be independent"));
    }
    check_finite(a.rb())?;
    let powers = ColumnPowers::bring_near_one(a.rb_mut(), space)?;
    let mut inner = Inner::new(space, c, par)?;
    inner.enter(a.rb_mut());
    let mut r = Mat::<f64>::identity(c, c);
    for pass in 0..PASSES {
        progress.report(pass as f64 / PASSES as f64)?;
        let gram = inner.gram(a.rb())?;
        // The columns of later passes are not longer than about 1.
        if pass == 0 {
            check_squares((0..c).map(|j| gram[(j, j)]))?;
        }
        let far = (0..c).flat_map(|j| (j..c).map(move |i| (i, j)));
        let far = far.map(|p| (gram[p] - f64::from(p.0 == p.1)).abs()).fold(0.0, f64::max);
        let mut l = gram.clone();
        if cholesky(l.as_mut())?.is_err() {
            // At least what rounding may have taken from the smallest eigenvalue.
            let trace = (0..c).map(|j| gram[(j, j)]).sum::<f64>();
            let shift = 11.0 * (n + c + 1) as f64 * f64::EPSILON / 2.0 * trace;
            l = gram;
            (0..c).for_each(|j| l[(j, j)] += shift);
            if let Err(j) = cholesky(l.as_mut())? {
                return refuse(format!("column {j} depends on those before it"));
            }
        }
        for j in 0..c {
            (0..j).for_each(|i| l[(i, j)] = 0.0);
        }
        divide_by_upper(a.rb_mut(), l.as_ref(), par)?;
        let mut next = zeros(c, c)?;
        inner.add_product(next.as_mut(), l.transpose(), r.as_ref())?;
        r = next;
        if far < NEAR {
            inner.leave(a.rb_mut());
            progress.report(1.0)?;
            // The shift turns a dependent column into a direction that consists of rounding errors.
            if let Some(j) = (0..c).find(|&j| r[(j, j)] <= DEPENDENT * r.col(j).norm_l2()) {
                return refuse(format!("column {j} depends on those before it"));
            }
            powers.undo(r.as_mut())?;
            return Ok(r);
        }
    }
    refuse("its columns are linearly dependent to working precision".into())
}
