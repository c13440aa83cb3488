use faer::prelude::{Reborrow, ReborrowMut};
use faer::{ColMut, Mat, MatMut};

use super::inner::{Inner, check_finite};
use crate::base::{Error, Par, Progress, Result};
use crate::dense::{cholesky, divide_by_upper, zeros};
use crate::kernel::int8::scaled;
use crate::sparse::{InnerSpace, Mass};

/// Computes `A = Q R` with `Q^T M Q = I` by shifted Cholesky QR (Fukaya et al. 2020), for columns
/// that are independent. A (n x c, any strides) becomes Q; R (c x c), upper triangular with a
/// positive diagonal, is returned.
///
/// It takes two passes over A if the condition of A allows, up to five otherwise. This is about
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
pub(crate) fn cholesky_qr_of(
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
    let exponents = bring_near_one(a.rb_mut(), space)?;
    let mut inner = Inner::new(space, c, par)?;
    inner.enter(a.rb_mut());
    let mut r = Mat::<f64>::identity(c, c);
    for pass in 0..PASSES {
        progress.report(pass as f64 / PASSES as f64)?;
        let gram = inner.gram(a.rb())?;
        // The columns of later passes are not longer than about 1.
        if pass == 0 && (0..c).any(|j| !gram[(j, j)].is_finite()) {
            let why = "so large that squares of lengths overflow".into();
            return Err(Error::Argument { what: "mass", why });
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
        divide_by_upper(a.rb_mut(), l.as_ref(), par);
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
            for (j, &exponent) in exponents.iter().enumerate() {
                multiply_by_power(r.col_mut(j), exponent);
                if r.col(j).iter().any(|x| !x.is_finite()) {
                    return refuse(format!("column {j} is too long: its length overflows"));
                }
            }
            return Ok(r);
        }
    }
    refuse("its columns are linearly dependent to working precision".into())
}

/// Multiplies columns whose largest entry is far from 1 by powers of two, so that squares of
/// lengths neither overflow nor underflow. Returns the exponents that undo it, the same on all
/// processes.
fn bring_near_one(a: MatMut<'_, f64>, space: &dyn InnerSpace) -> Result<Vec<i32>> {
    /// Exponents of a bin: columns whose largest entry is between 2^-128 and 2^128 do not change.
    const WIDTH: i32 = 256;
    /// Bins below and above that one: exponents lie between -1074 and 1023.
    const BESIDE: i32 = 4;
    const BINS: usize = 2 * BESIDE as usize + 1;
    // How many processes have the largest entry of a column in each bin.
    let mut counts = zeros(BINS, a.ncols())?;
    for (j, column) in a.rb().col_iter().enumerate() {
        let largest = column.norm_max();
        if largest > 0.0 {
            let bin = (largest.log2() as i32 + WIDTH / 2).div_euclid(WIDTH) + BESIDE;
            counts[(bin as usize, j)] = 1.0;
        }
    }
    space.sum(counts.as_mut())?;
    let exponent = |j: usize| {
        let highest = (0..BINS).rev().find(|&bin| counts[(bin, j)] > 0.0);
        highest.map_or(0, |bin| (bin as i32 - BESIDE) * WIDTH)
    };
    let exponents: Vec<i32> = (0..a.ncols()).map(exponent).collect();
    for (column, &exponent) in a.col_iter_mut().zip(&exponents) {
        multiply_by_power(column, -exponent);
    }
    Ok(exponents)
}

/// Multiplies a column by `2^exponent`.
fn multiply_by_power(column: ColMut<'_, f64>, exponent: i32) {
    if exponent != 0 {
        column.iter_mut().for_each(|x| *x = scaled(*x, exponent));
    }
}
