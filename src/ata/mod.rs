//! A^T A: schemes as data, plans as data, one engine, rows from anywhere, and a check.
//!
//! `C := alpha A^T A + beta C` for any m x n matrix A in f32 or f64, with any strides. See
//! docs/algorithms/ata.md for the mathematics.

mod combine;
pub mod distributed;
mod exact;
mod exec;
mod fused;
mod native;
mod options;
mod plan;
mod recurse;
mod rows;
pub mod scheme;
mod stream;
mod tree;
mod verify;

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{MatMut, MatRef};

pub(crate) use combine::mirror_lower;
pub use exact::Stages;
pub use options::{Accuracy, AtaOptions, SchemeChoice, Uplo};
pub use plan::{Base, Plan, Recursion};
pub use rows::{Center, DenseRows, RowBlocks, RowOptions, ata_rows};
#[cfg(feature = "mpi")]
pub(crate) use stream::with_share;
pub use stream::{Accumulator, AfterBlock, StreamPlan, Strip, block_rows, scalar_of, stream};
pub use tree::{Node, Task, levels};
pub use verify::{Verification, verify, verify_rows};
#[cfg(feature = "mpi")]
pub(crate) use verify::{check_rounds, signs, verdict};

use crate::base::{Error, Result, Scratch};
use crate::blas::{BlasReal, Kernels};
use crate::kernel::int8::Isa;

/// `C := alpha A^T A + beta C`, the triangle or triangles of `options.uplo`.
///
/// A is m x n, C is n x n; any strides; any sizes, 0 included. With `beta == 0` C is not read.
/// The result is the same, bit for bit, for every `options.par`.
///
/// # Errors
/// [`Error::Shape`] when C is not n x n, [`Error::Argument`] for options out of range,
/// [`Error::OutOfMemory`] when the scratch can't be had, [`Error::Cancelled`].
pub fn ata<T: BlasReal>(
    alpha: T,
    a: MatRef<'_, T>,
    beta: T,
    c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    if let Some(kernels) = small(a, a, true, options)? {
        Error::check_shape("C", (a.ncols(), a.ncols()), c.shape())?;
        return symmetric(c, options.uplo, |c| {
            kernels.syrk(alpha, a, beta, c);
            report_end(options)
        });
    }
    let plan = plan_ata(a, c.rb(), options)?;
    let mut scratch = Scratch::new::<T>(plan.scratch_len::<T>(options.par.threads(), true))?;
    run_symmetric(&plan, alpha, a, None, beta, c, options, scratch.as_mut_slice())
}

/// [`ata`] in the caller's scratch of at least [`ata_scratch_len`] elements, whatever they hold.
///
/// # Errors
/// As [`ata`]; [`Error::Shape`] too when the scratch is short.
pub fn ata_with_scratch<T: BlasReal>(
    alpha: T,
    a: MatRef<'_, T>,
    beta: T,
    c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
    scratch: &mut [T],
) -> Result<()> {
    if small(a, a, true, options)?.is_some() {
        return ata(alpha, a, beta, c, options);
    }
    let plan = plan_ata(a, c.rb(), options)?;
    check_scratch(scratch, plan.scratch_len::<T>(options.par.threads(), true))?;
    run_symmetric(&plan, alpha, a, None, beta, c, options, scratch)
}

/// Elements of scratch that [`ata_with_scratch`] needs for A m x n.
///
/// # Errors
/// [`Error::Argument`] for options out of range.
pub fn ata_scratch_len<T: BlasReal>(m: usize, n: usize, options: &AtaOptions<'_>) -> Result<usize> {
    Ok(Plan::ata::<T>(m, n, options)?.scratch_len::<T>(options.par.threads(), true))
}

/// `C := alpha A A^T + beta C`: [`ata`] of the transposed view. A is m x n, C is m x m.
///
/// # Errors
/// As [`ata`].
pub fn aat<T: BlasReal>(
    alpha: T,
    a: MatRef<'_, T>,
    beta: T,
    c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    ata(alpha, a.transpose(), beta, c, options)
}

/// [`aat`] in the caller's scratch of at least [`aat_scratch_len`] elements.
///
/// # Errors
/// As [`ata_with_scratch`].
pub fn aat_with_scratch<T: BlasReal>(
    alpha: T,
    a: MatRef<'_, T>,
    beta: T,
    c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
    scratch: &mut [T],
) -> Result<()> {
    ata_with_scratch(alpha, a.transpose(), beta, c, options, scratch)
}

/// Elements of scratch that [`aat_with_scratch`] needs for A m x n.
///
/// # Errors
/// [`Error::Argument`] for options out of range.
pub fn aat_scratch_len<T: BlasReal>(m: usize, n: usize, options: &AtaOptions<'_>) -> Result<usize> {
    ata_scratch_len::<T>(n, m, options)
}

/// `C := alpha A^T B + beta C`, all of it (`options.uplo` does not matter); FastStrassen of the
/// thesis' algorithm 8.1 under [`SchemeChoice::Ata2`].
///
/// A is m x n, B is m x k, C is n x k; any strides; any sizes, 0 included. With `beta == 0` C is
/// not read. The result is the same, bit for bit, for every `options.par`.
///
/// # Errors
/// [`Error::Shape`] when B has not m rows or C is not n x k; else as [`ata`].
pub fn atb<T: BlasReal>(
    alpha: T,
    a: MatRef<'_, T>,
    b: MatRef<'_, T>,
    beta: T,
    c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    if let Some(kernels) = small(a, b, false, options)? {
        check_atb(a, b, c.rb())?;
        kernels.gemm(alpha, a, b, beta, c);
        return report_end(options);
    }
    let plan = plan_atb(a, b, c.rb(), options)?;
    let mut scratch = Scratch::new::<T>(plan.scratch_len::<T>(options.par.threads(), false))?;
    run(&plan, alpha, a, Some(b), beta, c, options, scratch.as_mut_slice())
}

/// [`atb`] in the caller's scratch of at least [`atb_scratch_len`] elements, whatever they hold.
///
/// # Errors
/// As [`atb`]; [`Error::Shape`] too when the scratch is short.
pub fn atb_with_scratch<T: BlasReal>(
    alpha: T,
    a: MatRef<'_, T>,
    b: MatRef<'_, T>,
    beta: T,
    c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
    scratch: &mut [T],
) -> Result<()> {
    if small(a, b, false, options)?.is_some() {
        return atb(alpha, a, b, beta, c, options);
    }
    let plan = plan_atb(a, b, c.rb(), options)?;
    check_scratch(scratch, plan.scratch_len::<T>(options.par.threads(), false))?;
    run(&plan, alpha, a, Some(b), beta, c, options, scratch)
}

/// Elements of scratch that [`atb_with_scratch`] needs for A m x n and B m x k.
///
/// # Errors
/// [`Error::Argument`] for options out of range.
pub fn atb_scratch_len<T: BlasReal>(
    m: usize,
    n: usize,
    k: usize,
    options: &AtaOptions<'_>,
) -> Result<usize> {
    Ok(Plan::atb::<T>(m, n, k, options)?.scratch_len::<T>(options.par.threads(), false))
}

fn plan_ata<T: BlasReal>(
    a: MatRef<'_, T>,
    c: MatRef<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<Plan> {
    let (m, n) = a.shape();
    Error::check_shape("C", (n, n), c.shape())?;
    Plan::ata::<T>(m, n, options)
}

/// The kernels that compute a product which is over before it could be planned, if it is one and
/// the options leave us the choice.
fn small<'o, T: BlasReal>(
    a: MatRef<'_, T>,
    b: MatRef<'_, T>,
    same: bool,
    options: &'o AtaOptions<'_>,
) -> Result<Option<&'o dyn Kernels<T>>> {
    plan::check(options)?;
    let ours = matches!(
        options.scheme,
        SchemeChoice::Auto | SchemeChoice::Float | SchemeChoice::Classical
    ) && options.accuracy != Accuracy::Max
        && !options.reproducible;
    let native = options.backend.native().filter(|_| ours);
    let found = native.filter(|n| n.is_small::<T>(a.nrows(), a.ncols(), b.ncols(), same));
    Ok(found.map(|_| T::kernels(options.backend.as_ref())))
}

/// All of a small product at once.
fn report_end(options: &AtaOptions<'_>) -> Result<()> {
    options.progress.report(1.0)
}

fn check_atb<T>(a: MatRef<'_, T>, b: MatRef<'_, T>, c: MatRef<'_, T>) -> Result<()> {
    Error::check_shape("B", (a.nrows(), b.ncols()), b.shape())?;
    Error::check_shape("C", (a.ncols(), b.ncols()), c.shape())
}

fn plan_atb<T: BlasReal>(
    a: MatRef<'_, T>,
    b: MatRef<'_, T>,
    c: MatRef<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<Plan> {
    check_atb(a, b, c)?;
    Plan::atb::<T>(a.nrows(), a.ncols(), b.ncols(), options)
}

fn check_scratch<T>(scratch: &[T], len: usize) -> Result<()> {
    if scratch.len() >= len {
        return Ok(());
    }
    Err(Error::Shape { what: "scratch", expected: (len, 1), got: (scratch.len(), 1) })
}

/// The lower triangle of `C := A^T A` by the exact path on `isa`, and what its stages took. For
/// benchmarks: [`ata`] does the same on the fastest isa.
///
/// # Errors
/// As [`ata`]; [`Error::Argument`] when the machine refuses the isa.
pub fn exact_stages<T: BlasReal>(
    isa: Isa,
    a: MatRef<'_, T>,
    c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<Stages> {
    if let Some(why) = isa.refusal() {
        return Err(Error::Argument { what: "isa", why: why.into() });
    }
    let options = AtaOptions { scheme: SchemeChoice::Exact, ..options.clone() };
    let plan = plan_ata(a, c.rb(), &options)?;
    let len = plan.scratch_len::<T>(options.par.threads(), true);
    let mut scratch = Scratch::new::<T>(len)?;
    let layout = plan.exact_layout::<T>(true).expect("asked for");
    let (kernel, scratch) = (isa.kernel(), scratch.as_mut_slice());
    exact::execute(kernel, &layout, T::ONE, a, None, T::ZERO, c, &options, scratch)
}

/// Runs a plan, along the way that it chose.
fn run<T: BlasReal>(
    plan: &Plan,
    alpha: T,
    a: MatRef<'_, T>,
    b: Option<MatRef<'_, T>>,
    beta: T,
    c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
    scratch: &mut [T],
) -> Result<()> {
    match plan.exact_layout::<T>(b.is_none()) {
        Some(layout) => {
            let kernel = Isa::best().kernel();
            exact::execute(kernel, &layout, alpha, a, b, beta, c, options, scratch).map(drop)
        }
        None => match plan.native {
            Some(isa) => native::execute(isa, plan, alpha, a, b, beta, c, options, scratch),
            None => exec::execute(plan, alpha, a, b, beta, c, options, scratch),
        },
    }
}

/// Runs a symmetric plan, B given or the same as A, into the triangle asked for.
fn run_symmetric<T: BlasReal>(
    plan: &Plan,
    alpha: T,
    a: MatRef<'_, T>,
    b: Option<MatRef<'_, T>>,
    beta: T,
    c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
    scratch: &mut [T],
) -> Result<()> {
    symmetric(c, options.uplo, |lower| run(plan, alpha, a, b, beta, lower, options, scratch))
}

/// `C := alpha X^T (W X) + beta C`, the triangle or triangles of `options.uplo`; [`ata`] without weights.
fn weighted_gram<T: BlasReal>(
    alpha: T,
    x: MatRef<'_, T>,
    wx: Option<MatRef<'_, T>>,
    beta: T,
    c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    if wx.is_none() {
        return ata(alpha, x, beta, c, options);
    }
    let plan = plan_ata(x, c.rb(), options)?;
    let mut scratch = Scratch::new::<T>(plan.scratch_len::<T>(options.par.threads(), false))?;
    run_symmetric(&plan, alpha, x, wx, beta, c, options, scratch.as_mut_slice())
}

/// Makes the triangles of `uplo` out of what `work` does to a lower one.
fn symmetric<T: BlasReal>(
    mut c: MatMut<'_, T>,
    uplo: Uplo,
    work: impl FnOnce(MatMut<'_, T>) -> Result<()>,
) -> Result<()> {
    match uplo {
        Uplo::Upper => work(c.rb_mut().transpose_mut())?,
        Uplo::Lower | Uplo::Both => work(c.rb_mut())?,
    }
    if uplo == Uplo::Both {
        mirror_lower(c);
    }
    Ok(())
}
