//! Products of complex matrices, out of real ones: `A^H A` and `A^H B`.
//!
//! With `A = X + i Y` and `B = U + i V`, and `[X; Y]` for X above Y,
//! `A^H B = [X; Y]^T [U; V] + i [X; Y]^T [V; -U]`: the classical algorithm's four real products, as
//! two of twice the rows. Three products (Karatsuba) would lose the small parts beside the large
//! ones. For B = A the first is a symmetric product, and the second is `P - P^T` with `P = X^T Y`.

mod stack;
mod sums;
mod write;

use faer::complex::Complex;
use faer::prelude::Reborrow;
use faer::{MatMut, MatRef};

use self::sums::{Sums, Term, with_sums};
use self::write::{by_rows, times, write_general, write_hermitian};
use super::options::{AtaOptions, Uplo};
use super::plan::Op;
use crate::base::{Error, Result};
use crate::blas::BlasReal;

/// Computes `C := alpha A^H A + beta C`, the triangle or triangles of `options.uplo`; alpha and
/// beta are real and C is Hermitian.
///
/// A is m x n, C is n x n, of [`faer::c32`] or [`faer::c64`]; any strides; any sizes, 0 included.
/// With [`Uplo::Both`] the upper triangle is the conjugate of the lower one, bit for bit. The
/// imaginary parts of the diagonal are not read, and become zero. With `beta == 0` C is not read,
/// with `alpha == 0` A is not. The result is the same, bit for bit, for every `options.par`; with
/// [`AtaOptions::reproducible()`], [`Accuracy::Max`](super::Accuracy::Max) or
/// [`SchemeChoice::Exact`](super::SchemeChoice::Exact) on every machine too.
///
/// The extra memory is that of a matrix like C, a block of real and imaginary parts (64 MiB, or
/// 1024 rows if those are longer), and the scratch of [`ata`](super::ata()) for one block.
///
/// # Accuracy
/// With u the unit roundoff and `|a_i|` the Euclidean norm of a column, both parts of every entry
/// satisfy `|C_ij - exact| <= 8 m u |a_i| |a_j|` for beta = 0 and alpha = 1. On the exact path,
/// asked for by name, each block is rounded once: the error is then that of
/// [`Accuracy`](super::Accuracy), and u more for each block.
///
/// NaN and infinities have the effect of `(x - i y)(u + i v) = (x u + y v) + i (x v - y u)`, term
/// by term, in classical and exact products.
///
/// ```
/// use catamaran::{AtaOptions, Uplo, aha, faer::{Mat, c64}};
///
/// let a = Mat::from_fn(2, 2, |i, j| c64::new(i as f64, j as f64));
/// let mut c = Mat::zeros(2, 2);
/// aha(1.0, a.as_ref(), 0.0, c.as_mut(), &AtaOptions::new().uplo(Uplo::Both))?;
/// assert_eq!(c[(0, 0)], c64::new(1.0, 0.0));
/// assert_eq!((c[(0, 1)], c[(1, 0)]), (c64::new(1.0, 1.0), c64::new(1.0, -1.0)));
/// assert_eq!(c[(1, 1)], c64::new(3.0, 0.0));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when C is not n x n, [`Error::Argument`] for options out of range,
/// [`Error::OutOfMemory`] when the memory can't be had, [`Error::Cancelled`]. C is untouched then.
pub fn aha<T: BlasReal>(
    alpha: T,
    a: MatRef<'_, Complex<T>>,
    beta: T,
    c: MatMut<'_, Complex<T>>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    let (m, n) = a.shape();
    Error::check_shape("C", (n, n), c.shape())?;
    options.check()?;
    if n == 0 {
        return Ok(());
    }
    if m == 0 || alpha == T::ZERO {
        options.on_cores(|| write_hermitian(c, |_, _| None, beta, options.uplo, options.par));
        return options.progress.report(1.0);
    }
    // Antisymmetric, so that the fast schemes for symmetric products do not apply: a general one,
    // and its transpose. The exact path has no schemes, and rounds the difference once.
    let difference = !options.asks_for_exact();
    let imaginary = if difference {
        Term { op: Op::Gemm, left: 0..1, right: 1..2 }
    } else {
        Term { op: Op::Gemmt, left: 0..2, right: 1..3 }
    };
    let terms = [Term { op: Op::Syrk, left: 0..2, right: 0..2 }, imaginary];
    let rows_first = by_rows(c.rb()) != (options.uplo == Uplo::Upper);
    with_sums(a, None, &terms, rows_first, options, |Sums { re, im }| {
        let value = |i: usize, j: usize| {
            let im = if difference { im[(i, j)] - im[(j, i)] } else { im[(i, j)] };
            Some(Complex { re: alpha * re[(i, j)], im: alpha * im })
        };
        write_hermitian(c, value, beta, options.uplo, options.par);
    })
}

/// Computes `C := alpha A^H B + beta C`, all of it (`options.uplo` does not matter).
///
/// A is m x n, B is m x k, C is n x k, of [`faer::c32`] or [`faer::c64`]; any strides; any sizes, 0
/// included. With `beta == 0` C is not read, with `alpha == 0` A and B are not. A real alpha or
/// beta multiplies both parts. Otherwise as [`aha`], with the norms of columns of A and of B.
///
/// ```
/// use catamaran::{AtaOptions, ahb, faer::{Mat, c64}};
///
/// let (i, one) = (c64::new(0.0, 1.0), c64::new(1.0, 0.0));
/// let (a, b) = (Mat::full(3, 1, i), Mat::full(3, 2, one));
/// let mut c = Mat::zeros(1, 2);
/// ahb(i, a.as_ref(), b.as_ref(), c64::new(0.0, 0.0), c.as_mut(), &AtaOptions::new())?;
/// assert_eq!(c, Mat::full(1, 2, c64::new(3.0, 0.0)));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when B has not m rows or C is not n x k; else as [`aha`].
pub fn ahb<T: BlasReal>(
    alpha: Complex<T>,
    a: MatRef<'_, Complex<T>>,
    b: MatRef<'_, Complex<T>>,
    beta: Complex<T>,
    c: MatMut<'_, Complex<T>>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    let (m, n, k) = (a.nrows(), a.ncols(), b.ncols());
    Error::check_shape("B", (m, k), b.shape())?;
    Error::check_shape("C", (n, k), c.shape())?;
    options.check()?;
    if n == 0 || k == 0 {
        return Ok(());
    }
    if m == 0 || alpha == (Complex { re: T::ZERO, im: T::ZERO }) {
        options.on_cores(|| write_general(c, |_, _| None, beta, options.par));
        return options.progress.report(1.0);
    }
    let terms = [
        Term { op: Op::Gemm, left: 0..2, right: 0..2 },
        Term { op: Op::Gemm, left: 0..2, right: 1..3 },
    ];
    with_sums(a, Some(b), &terms, by_rows(c.rb()), options, |Sums { re, im }| {
        let value = |i, j| Some(times(alpha, Complex { re: re[(i, j)], im: im[(i, j)] }));
        write_general(c, value, beta, options.par);
    })
}
