//! Products of complex matrices, computed by real ones: `A^H A` and `A^H B`.
//!
//! With `A = X + i Y` and `B = U + i V`, and `[X; Y]` for X above Y,
//! `A^H B = [X; Y]^T [U; V] + i [X; Y]^T [V; -U]`: the classical algorithm's four real products, as
//! two of twice the rows. Three products (Karatsuba) would lose the small parts beside the large
//! ones. For B = A the first is a symmetric product, and the second is `P - P^T` with `P = X^T Y`.
//! `A^T B = [X; Y]^T [U; -V] + i [X; Y]^T [V; U]`.

mod plan;
mod stack;
mod sums;
mod write;

use faer::complex::Complex;
use faer::prelude::Reborrow;
use faer::{MatMut, MatRef};

pub use self::plan::ComplexPlan;
use self::plan::Kind;
use self::sums::{Sums, with_sums};
use self::write::{by_rows, times, write_general, write_hermitian};
use super::options::{AtaOptions, Uplo};
use super::plan::Op;
use super::planned::of_another;
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
/// 1024 rows if those are longer), and the scratch of [`ata_into`](super::ata_into) for one block.
/// With [`AtaOptions::memory()`] blocks are smaller: see [`ComplexPlan`].
///
/// # Accuracy
/// With u the unit roundoff and `|a_i|` the Euclidean norm of a column, both parts of every entry
/// satisfy `|C_ij - exact| <= 8 m u |a_i| |a_j|` for beta = 0 and alpha = 1. On the exact path, if
/// it is requested by name, each block is rounded once: the error is then that of
/// [`Accuracy`](super::Accuracy), and u more for each block.
///
/// NaN and infinities have the effect of `(x - i y)(u + i v) = (x u + y v) + i (x v - y u)`, term
/// by term, in classical and exact products.
///
/// ```
/// use catamaran::{AtaOptions, Uplo, aha_into, faer::{Mat, c64}};
///
/// let a = Mat::from_fn(2, 2, |i, j| c64::new(i as f64, j as f64));
/// let mut c = Mat::zeros(2, 2);
/// aha_into(1.0, a.as_ref(), 0.0, c.as_mut(), &AtaOptions::new().uplo(Uplo::Both))?;
/// assert_eq!(c[(0, 0)], c64::new(1.0, 0.0));
/// assert_eq!((c[(0, 1)], c[(1, 0)]), (c64::new(1.0, 1.0), c64::new(1.0, -1.0)));
/// assert_eq!(c[(1, 1)], c64::new(3.0, 0.0));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when C is not n x n, [`Error::Argument`] for options out of range,
/// [`Error::OutOfMemory`] when memory is refused, [`Error::Cancelled`]. C is untouched then.
pub fn aha_into<T: BlasReal>(
    alpha: T,
    a: MatRef<'_, Complex<T>>,
    beta: T,
    c: MatMut<'_, Complex<T>>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    let (m, n) = a.shape();
    Error::check_shape("C", (n, n), c.shape())?;
    let plan = ComplexPlan::aha::<T>(m, n, options)?;
    aha_planned(&plan, alpha, a, beta, c, options)
}

/// Computes [`aha_into`] by a plan of [`ComplexPlan::aha`] for the shape of A, or `A^T conj(A)` by
/// a conjugated one.
///
/// Of the options only triangle, threads, pinning, back end and progress matter: the rest is in the
/// plan.
///
/// ```
/// use catamaran::{AtaOptions, product::{ComplexPlan, aha_planned}, faer::{Mat, c64}};
///
/// let options = AtaOptions::new();
/// let plan = ComplexPlan::aha::<f64>(3, 1, &options)?;
/// let (a, mut c) = (Mat::full(3, 1, c64::new(3.0, 4.0)), Mat::zeros(1, 1));
/// aha_planned(&plan, 1.0, a.as_ref(), 0.0, c.as_mut(), &options)?;
/// assert_eq!(c[(0, 0)], c64::new(75.0, 0.0));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] for a plan of another product or scalar, [`Error::Shape`] for one of another
/// shape; else as [`aha_into`].
pub fn aha_planned<T: BlasReal>(
    plan: &ComplexPlan,
    alpha: T,
    a: MatRef<'_, Complex<T>>,
    beta: T,
    c: MatMut<'_, Complex<T>>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    check::<T>(plan, &[Kind::Aha], [a.shape(), a.shape(), c.shape()])?;
    let (m, n) = a.shape();
    if n == 0 {
        return Ok(());
    }
    if m == 0 || alpha == T::ZERO {
        // Before C is written, as with products.
        options.progress.report(1.0)?;
        options.on_cores(|| write_hermitian(c, |_, _| None, beta, options.uplo, options.par));
        return Ok(());
    }
    let difference = plan.terms[1].op == Op::Gemm;
    let sign = if plan.conjugated { -T::ONE } else { T::ONE };
    let rows_first = by_rows(c.rb()) != (options.uplo == Uplo::Upper);
    with_sums(plan, a, None, rows_first, options, |Sums { re, im }| {
        let value = |i: usize, j: usize| {
            let im = if difference { im[(i, j)] - im[(j, i)] } else { im[(i, j)] };
            Some(Complex { re: alpha * re[(i, j)], im: alpha * (sign * im) })
        };
        write_hermitian(c, value, beta, options.uplo, options.par);
    })
}

/// Computes `C := alpha A^H B + beta C`, all of it (`options.uplo` does not matter).
///
/// A is m x n, B is m x k, C is n x k, of [`faer::c32`] or [`faer::c64`]; any strides; any sizes, 0
/// included. With `beta == 0` C is not read, with `alpha == 0` A and B are not. A real alpha or
/// beta multiplies both parts. Otherwise as [`aha_into`], with the norms of columns of A and of B.
///
/// ```
/// use catamaran::{AtaOptions, ahb_into, faer::{Mat, c64}};
///
/// let (i, one) = (c64::new(0.0, 1.0), c64::new(1.0, 0.0));
/// let (a, b) = (Mat::full(3, 1, i), Mat::full(3, 2, one));
/// let mut c = Mat::zeros(1, 2);
/// ahb_into(i, a.as_ref(), b.as_ref(), c64::new(0.0, 0.0), c.as_mut(), &AtaOptions::new())?;
/// assert_eq!(c, Mat::full(1, 2, c64::new(3.0, 0.0)));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when B has not m rows or C is not n x k; else as [`aha_into`].
pub fn ahb_into<T: BlasReal>(
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
    let plan = ComplexPlan::ahb::<T>(m, n, k, options)?;
    ahb_planned(&plan, alpha, a, b, beta, c, options)
}

/// Computes [`ahb_into`] by a plan of [`ComplexPlan::ahb`] for the shapes of A and B, `A^T B` by
/// one of [`ComplexPlan::atb`], or the conjugate of either by a conjugated one.
///
/// Of the options only threads, pinning, back end and progress matter: the rest is in the plan.
///
/// ```
/// use catamaran::{AtaOptions, product::{ComplexPlan, ahb_planned}, faer::{Mat, c64}};
///
/// let options = AtaOptions::new();
/// let plan = ComplexPlan::atb::<f64>(3, 1, 2, &options)?;
/// let (i, zero) = (c64::new(0.0, 1.0), c64::new(0.0, 0.0));
/// let (a, b, mut c) = (Mat::full(3, 1, i), Mat::full(3, 2, i), Mat::zeros(1, 2));
/// ahb_planned(&plan, i, a.as_ref(), b.as_ref(), zero, c.as_mut(), &options)?;
/// assert_eq!(c, Mat::full(1, 2, c64::new(0.0, -3.0)));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] for a plan of another product or scalar, [`Error::Shape`] for one of other
/// shapes; else as [`ahb_into`].
pub fn ahb_planned<T: BlasReal>(
    plan: &ComplexPlan,
    alpha: Complex<T>,
    a: MatRef<'_, Complex<T>>,
    b: MatRef<'_, Complex<T>>,
    beta: Complex<T>,
    c: MatMut<'_, Complex<T>>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    check::<T>(plan, &[Kind::Ahb, Kind::Atb], [a.shape(), b.shape(), c.shape()])?;
    let (m, n, k) = (a.nrows(), a.ncols(), b.ncols());
    if n == 0 || k == 0 {
        return Ok(());
    }
    if m == 0 || alpha == (Complex { re: T::ZERO, im: T::ZERO }) {
        options.progress.report(1.0)?;
        options.on_cores(|| write_general(c, |_, _| None, beta, options.par));
        return Ok(());
    }
    let sign = if plan.conjugated { -T::ONE } else { T::ONE };
    with_sums(plan, a, Some(b), by_rows(c.rb()), options, |Sums { re, im }| {
        let value = |i, j| Some(times(alpha, Complex { re: re[(i, j)], im: sign * im[(i, j)] }));
        write_general(c, value, beta, options.par);
    })
}

/// Returns an error for a plan of another product, or for other shapes of A, B and C.
fn check<T: BlasReal>(
    plan: &ComplexPlan,
    kinds: &[Kind],
    [a, b, c]: [(usize, usize); 3],
) -> Result<()> {
    if !kinds.contains(&plan.kind) {
        return Err(of_another(if kinds == [Kind::Aha] { "A^H A" } else { "A^H B" }));
    }
    if !plan.plans[0][0].is_of::<T>() {
        return Err(of_another(T::NAME));
    }
    let [m, n, k] = plan.sides;
    Error::check_shape("A", (m, n), a)?;
    Error::check_shape("B", (m, k), b)?;
    Error::check_shape("C", (n, k), c)
}
