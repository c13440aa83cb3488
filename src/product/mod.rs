//! A^T A: options, plans and their execution, and a probabilistic check.
//!
//! `C := alpha A^T A + beta C` for any m x n matrix A in f32 or f64, with any strides. A call makes
//! a [`Plan`] from the shape and the [`AtaOptions`], and runs it: `plan/` holds the data,
//! `execute/` one executor for each strategy. See docs/algorithms/ata.md for the mathematics.
//!
//! # Accuracy
//! With k rows, u the unit roundoff and `|a_i|` the Euclidean norm of a column, every entry of a
//! result of the default options satisfies `|C_ij - exact| <= 4 k u |a_i| |b_j|`, whatever the
//! norms of the other columns: columns whose norms differ are scaled by powers of two around fast
//! levels. The bound holds for [`ata_into`], [`atb_into`], [`ata_rows`](crate::rows::ata_rows),
//! streams and ranks, unless products of the norms leave the range of the numbers.

mod batched;
pub(crate) mod combine;
mod complex;
pub(crate) mod exact;
mod execute;
mod options;
pub(crate) mod plan;
mod planned;
pub mod schemes;
mod simple;
mod sparse;
mod verify;

use faer::{MatMut, MatRef};

pub use batched::ata_batched_into;
pub use complex::{ComplexPlan, aha_into, aha_planned, ahb_into, ahb_planned};
pub use options::{Accuracy, AtaOptions, SchemeChoice, Uplo};
pub use plan::{Node, Plan, Task, thread_levels};
use planned::run;
pub use planned::{ata_planned, atb_planned};
pub use simple::{aat, aha, ahb, ata, atb};
pub use sparse::{ata_sparse, sparse_is_faster, sparse_multiplications};
pub(crate) use verify::check_blocks;
pub use verify::{Verification, verify};
#[cfg(feature = "mpi")]
pub(crate) use verify::{check_rounds, refuse_non_finite, signs, verdict};

pub(crate) use execute::{Product, execute, execute_direct};

use crate::base::{Error, Result};
use crate::blas::BlasReal;
use plan::{Op, Problem};

/// Computes `C := alpha A^T A + beta C`, the triangle or triangles of `options.uplo`.
///
/// A is m x n, C is n x n; any strides; any sizes, 0 included. With `beta == 0` C is not read, with
/// `alpha == 0` A is not. The result is the same, bit for bit, for every `options.par`. [`ata`] is
/// the short form for defaults.
///
/// ```
/// use catamaran::{AtaOptions, Uplo, ata_into, faer::{Mat, mat}};
///
/// let a = mat![[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]];
/// let mut c = Mat::zeros(2, 2);
/// ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &AtaOptions::new().uplo(Uplo::Both))?;
/// assert_eq!(c, mat![[35.0, 44.0], [44.0, 56.0]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when C is not n x n, [`Error::Argument`] for options out of range,
/// [`Error::OutOfMemory`] when memory for the scratch is refused, [`Error::Cancelled`].
pub fn ata_into<T: BlasReal>(
    alpha: T,
    a: MatRef<'_, T>,
    beta: T,
    c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    let n = a.ncols();
    Error::check_shape("C", (n, n), c.shape())?;
    compute(Op::Syrk, Product { alpha, a, b: None, beta, c, uplo: Some(options.uplo) }, options)
}

/// Computes `C := alpha A A^T + beta C`: [`ata_into`] of the transposed view. A is m x n, C is
/// m x m.
///
/// ```
/// use catamaran::{AtaOptions, aat_into, faer::{Mat, mat}};
///
/// let mut c = Mat::zeros(1, 1);
/// aat_into(1.0, mat![[3.0, 4.0]].as_ref(), 0.0, c.as_mut(), &AtaOptions::new())?;
/// assert_eq!(c[(0, 0)], 25.0);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`ata_into`].
pub fn aat_into<T: BlasReal>(
    alpha: T,
    a: MatRef<'_, T>,
    beta: T,
    c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    ata_into(alpha, a.transpose(), beta, c, options)
}

/// Computes `C := alpha A^T B + beta C`, all of it (`options.uplo` does not matter). With
/// [`SchemeChoice::Ata2`] it is FastStrassen of the thesis' algorithm 8.1.
///
/// A is m x n, B is m x k, C is n x k; any strides; any sizes, 0 included. With `beta == 0` C is
/// not read, with `alpha == 0` A and B are not. The result is the same, bit for bit, for every
/// `options.par`.
///
/// ```
/// use catamaran::{AtaOptions, atb_into, faer::{Mat, mat}};
///
/// let (a, b) = (mat![[1.0, 2.0], [3.0, 4.0]], mat![[1.0], [10.0]]);
/// let mut c = Mat::zeros(2, 1);
/// atb_into(1.0, a.as_ref(), b.as_ref(), 0.0, c.as_mut(), &AtaOptions::new())?;
/// assert_eq!(c, mat![[31.0], [42.0]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when B has not m rows or C is not n x k; else as [`ata_into`].
pub fn atb_into<T: BlasReal>(
    alpha: T,
    a: MatRef<'_, T>,
    b: MatRef<'_, T>,
    beta: T,
    c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    Error::check_shape("B", (a.nrows(), b.ncols()), b.shape())?;
    Error::check_shape("C", (a.ncols(), b.ncols()), c.shape())?;
    compute(Op::Gemm, Product { alpha, a, b: Some(b), beta, c, uplo: None }, options)
}

/// Computes a product by a plan, or one that is too small for a plan directly: a plan takes as long
/// as a product of ten columns. Inlined, so that the smallest products copy no arguments.
#[inline(always)]
fn compute<T: BlasReal>(op: Op, product: Product<'_, T>, options: &AtaOptions<'_>) -> Result<()> {
    options.check()?;
    let (m, n, k) = (product.a.nrows(), product.c.nrows(), product.c.ncols());
    let problem = Problem::new(op, m, n, k)?;
    if let Some(native) = plan::direct_kernels(&problem, options) {
        execute_direct(native, op, product)?;
        return options.progress.report(1.0);
    }
    run(&Plan::new::<T>(op, m, n, k, options)?, product, options, None)
}
