//! Computes requests by Catamaran.

use std::sync::OnceLock;

use catamaran::faer::{Mat, MatMut, MatRef};
use catamaran::{AtaOptions, Par, Result, Uplo};

use crate::element::{Element, Planned};
use crate::request::Request;
use crate::threads;

/// Products of real numbers that are computed before another thread has woken up.
const WORK_OF_ONE_THREAD: f64 = 4e6;

/// Computes `request` by `plan` on so many threads.
///
/// # Errors
/// [`catamaran::Error::OutOfMemory`]; C is untouched then.
///
/// # Safety
/// The caller of BLAS owns the memory that it named for the length of this call, and C overlaps no
/// operand.
pub unsafe fn compute<T: Element>(
    request: &Request<T>,
    plan: &Planned,
    threads: usize,
) -> Result<()> {
    // SAFETY: the caller of BLAS owns the memory, and C overlaps no operand, by the contract, so
    // the view of C is the only one of its memory.
    let ((left, right), c) = unsafe { (request.operands(), request.result()) };
    let threads = if request.work() < WORK_OF_ONE_THREAD { 1 } else { threads };
    let Request { alpha, beta, triangle, .. } = *request;
    threads::run(threads, |par| run(plan, alpha, left, right, beta, c, triangle, par))
}

fn run<T: Element>(
    plan: &Planned,
    alpha: T,
    left: MatRef<'_, T>,
    right: Option<MatRef<'_, T>>,
    beta: T,
    c: MatMut<'_, T>,
    triangle: Option<Uplo>,
    par: Par,
) -> Result<()> {
    /// To create them takes as long as a tiny product.
    static DEFAULTS: OnceLock<AtaOptions<'static>> = OnceLock::new();
    let defaults = DEFAULTS.get_or_init(|| AtaOptions::new().par(Par::Seq));
    let uplo = triangle.unwrap_or(defaults.uplo);
    if (par, uplo) == (defaults.par, defaults.uplo) {
        return T::multiply(plan, alpha, left, right, beta, c, defaults);
    }
    let options = defaults.clone().par(par).uplo(uplo);
    T::multiply(plan, alpha, left, right, beta, c, &options)
}

/// Computes `request` by `plan` on the calling thread where C may overlap an operand.
///
/// # Errors
/// [`catamaran::Error::OutOfMemory`]; C is untouched then.
///
/// # Safety
/// The caller of BLAS owns the memory that it named for the length of this call.
pub unsafe fn compute_apart<T: Element>(request: &Request<T>, plan: &Planned) -> Result<()> {
    let [rows, cols, _] = request.sides();
    let mut product = Mat::from_fn(rows, cols, |_, _| T::ZERO);
    {
        // SAFETY: the caller of BLAS owns the memory, by the contract; C, which may overlap it, has
        // no view while these live.
        let (left, right) = unsafe { request.operands() };
        let Request { alpha, triangle, .. } = *request;
        run(plan, alpha, left, right, T::ZERO, product.as_mut(), triangle, Par::Seq)?;
    }
    // SAFETY: the caller of BLAS owns the memory, by the contract; the views of the operands have
    // ended with the block, so that this is the only one.
    let mut c = unsafe { request.result() };
    for j in 0..cols {
        let wanted = match request.triangle {
            None | Some(Uplo::Both) => 0..rows,
            Some(Uplo::Lower) => j..rows,
            Some(Uplo::Upper) => 0..j + 1,
        };
        for i in wanted {
            let real = request.is_hermitian() && i == j;
            let old = if real { c[(i, j)].real() } else { c[(i, j)] };
            let old = if request.beta == T::ZERO { T::ZERO } else { request.beta * old };
            c[(i, j)] = old + product[(i, j)];
        }
    }
    Ok(())
}
