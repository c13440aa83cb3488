//! Dense matrices: products by the kernels of this crate, factorizations by faer.
//!
//! faer's factorizations run on the calling thread, because parallel factorizations may round
//! differently for every number of threads; the matrices here have as many rows as there are basis
//! functions, not vertices.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::qr::no_pivoting as qr;
use faer::linalg::svd;
use faer::prelude::ReborrowMut;
use faer::{Mat, MatMut, MatRef, Spec};

use catamaran::base::{Error, Par, Result, apart};
use catamaran::dense::{self, zeros};
use catamaran::product::{Accuracy, AtaOptions, atb_into};

const SEQ: faer::Par = faer::Par::Seq;

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

/// A thin singular value decomposition `A = U diag(s) V^T`, s descending.
#[derive(Debug, Clone)]
pub(super) struct Svd {
    pub u: Mat<f64>,
    pub s: Vec<f64>,
    pub v: Mat<f64>,
}

/// Computes the singular value decomposition of a finite matrix.
pub(super) fn thin_svd(what: &'static str, a: MatRef<'_, f64>) -> Result<Svd> {
    check_finite(what, a)?;
    let (m, n) = a.shape();
    let mut owned = zeros(m, n)?;
    owned.copy_from(a);
    let operations = 20.0 * m.max(n) as f64 * (m.min(n) as f64).powi(2);
    apart(operations, move || decompose(owned.as_ref()))?
}

fn decompose(a: MatRef<'_, f64>) -> Result<Svd> {
    let (m, n) = a.shape();
    let size = m.min(n);
    let (mut u, mut v, mut s) = (zeros(m, size)?, zeros(n, size)?, Diag::zeros(size));
    let params = Spec::<svd::SvdParams, f64>::default();
    let thin = svd::ComputeSvdVectors::Thin;
    let mut memory = MemBuffer::new(svd::svd_scratch::<f64>(m, n, thin, thin, SEQ, params));
    let stack = MemStack::new(&mut memory);
    svd::svd(a, s.as_mut(), Some(u.as_mut()), Some(v.as_mut()), SEQ, stack, params)
        .map_err(|_| Error::NotConverged { iterations: 0, residual: f64::NAN })?;
    let s = s.column_vector().iter().copied().collect();
    Ok(Svd { u, s, v })
}

/// Returns the X that minimizes `|A X - B|`, for A of full column rank, by Householder's QR.
pub(super) fn least_squares(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Result<Mat<f64>> {
    let (m, n) = a.shape();
    let mut basis = zeros(m, n)?;
    basis.copy_from(a);
    let mut x = zeros(m, b.ncols())?;
    x.copy_from(b);
    let operations = 2.0 * m as f64 * n as f64 * (n + 2 * b.ncols()) as f64;
    apart(operations, move || solve_least_squares(basis, x))?
}

fn solve_least_squares(mut basis: Mat<f64>, mut x: Mat<f64>) -> Result<Mat<f64>> {
    let ((m, n), columns) = (basis.shape(), x.ncols());
    let block = qr::factor::recommended_block_size::<f64>(m, n).min(m.min(n)).max(1);
    let mut coefficients = zeros(block, m.min(n))?;
    let scratch = StackReq::any_of(&[
        qr::factor::qr_in_place_scratch::<f64>(m, n, block, SEQ, Spec::default()),
        qr::solve::solve_lstsq_in_place_scratch::<f64>(m, n, block, columns, SEQ),
    ]);
    let mut memory = MemBuffer::new(scratch);
    let stack = MemStack::new(&mut memory);
    qr::factor::qr_in_place(basis.as_mut(), coefficients.as_mut(), SEQ, stack, Spec::default());
    let upper = basis.get(..m.min(n), ..);
    qr::solve::solve_lstsq_in_place(
        basis.as_ref(),
        coefficients.as_ref(),
        upper,
        x.as_mut(),
        SEQ,
        stack,
    );
    Ok(x.subrows(0, n).to_owned())
}
