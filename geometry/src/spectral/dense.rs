//! Dense matrices: products by the kernels of this crate, factorizations by faer.
//!
//! faer's factorizations run on the calling thread, because parallel factorizations may round
//! differently for every number of threads; the matrices here have as many rows as there are basis
//! functions, not vertices.

use faer::prelude::ReborrowMut;
use faer::{Mat, MatMut, MatRef};

use catamaran::base::{Error, Par, Result};
use catamaran::dense::{self, Svd, zeros};
use catamaran::product::{Accuracy, AtaOptions, atb_into};

/// Computes `A^T B` by the classical algorithm, whose error is bounded entry by entry.
pub(super) fn transposed_product(
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    par: Par,
) -> Result<Mat<f64>> {
    let mut c = zeros(a.ncols(), b.ncols())?;
    transposed_product_into(a, b, c.as_mut(), par)?;
    Ok(c)
}

/// Computes `A^T B` into the caller's matrix.
pub(super) fn transposed_product_into(
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    c: MatMut<'_, f64>,
    par: Par,
) -> Result<()> {
    let options = AtaOptions::new().par(par).accuracy(Accuracy::Classical);
    atb_into(1.0, a, b, 0.0, c, &options)
}

/// Computes `A B`.
pub(super) fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>, par: Par) -> Result<Mat<f64>> {
    transposed_product(a.transpose(), b, par)
}

/// Returns an error that names the matrix and its first NaN or infinity, if there is one.
pub(super) fn check_finite(what: &'static str, a: MatRef<'_, f64>) -> Result<()> {
    for j in 0..a.ncols() {
        if let Some(i) = (0..a.nrows()).find(|&i| !a[(i, j)].is_finite()) {
            return Err(Error::NonFinite { what, index: (i, j) });
        }
    }
    Ok(())
}

/// Returns the Cholesky factor L, lower, of a symmetric matrix, whose lower triangle is read, or
/// the index of the first pivot that is not positive.
pub(super) fn cholesky(mut a: Mat<f64>) -> Result<std::result::Result<Mat<f64>, usize>> {
    Ok(dense::cholesky(a.as_mut())?.map(|()| a))
}

/// Solves `L L^T X = B` in place.
pub(super) fn solve_cholesky(l: MatRef<'_, f64>, mut b: MatMut<'_, f64>) {
    dense::lower_solve_in_place(l, b.rb_mut());
    dense::upper_solve_in_place(l.transpose(), b);
}

/// Computes the thin singular value decomposition of a matrix, and names it where it is not finite.
pub(super) fn thin_svd(what: &'static str, a: MatRef<'_, f64>) -> Result<Svd> {
    check_finite(what, a)?;
    dense::thin_svd(a)
}
