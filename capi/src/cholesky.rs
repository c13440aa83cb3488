//! # Sparse Cholesky factorizations
//!
//! Solutions of A X = B for a sparse symmetric matrix, positive definite or semidefinite: analysed
//! once for all matrices with entries in the same places, factorized for each, solved for any
//! number of right-hand sides.
//!
//! ```c
//! size_t starts[] = {0, 2, 4}, columns[] = {0, 1, 0, 1};
//! double entries[] = {2, -1, -1, 2}, x[] = {1, 1};
//! cata_cholesky *cholesky;
//! cata_cholesky_analyse(2, starts, columns, NULL, &cholesky);
//! cata_cholesky_factor(cholesky, starts, columns, entries);
//! cata_cholesky_solve(cholesky, CATA_COL_MAJOR, 1, x, 2);
//! printf("%g %g\n", x[0], x[1]); // 1 1
//! cata_cholesky_free(cholesky);
//! ```

use std::ffi::c_void;

use super::boundary::boundary;
use super::layout::{CATA_BOTH, CATA_LOWER, CATA_UPPER};
use super::outputs::{copy, tell};
use super::params::{Params, flag, init, params, read_or_zeros};
use super::pointer::{
    Layout, UPLO, free, hand_over, known, known_mut, matrix, matrix_mut, optional_slice, output,
    pattern, slice, sparse,
};
use super::progress::{Caller, cata_progress};
use super::status::{Failure, cata_status};
use catamaran::sparse::{Cholesky, CholeskyOptions, Triangle};

/// The factorization A = L L^T of a sparse symmetric matrix, or its analysis alone.
pub struct cata_cholesky {
    cholesky: Cholesky,
    caller: Caller,
}

/// What is read of a matrix, and which pivots are allowed.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_cholesky_params {
    /// sizeof(cata_cholesky_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Progress callback; NULL: none.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
    /// n elements: the rows in the order of elimination, from 0, each once, as that of METIS; NULL:
    /// approximate minimum degree, from 100,000 rows on after nested dissection.
    pub order: *const usize,
    /// Largest pivot that is zero, relative to the diagonal entry of its row, at most 0.01; 0: 8 n
    /// 2^-52 with `semidefinite`, and only zero itself without.
    pub tolerance: f64,
    /// The triangle that is read, the other one being ignored; 0: CATA_BOTH, which must agree.
    pub triangle: i32,
    /// 1: pivots may be zero: their rows are held (cata_cholesky_held). 0: all are positive.
    pub semidefinite: i32,
}

params!(cata_cholesky_params, semidefinite: i32);

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_cholesky_params_init(
    params: *mut cata_cholesky_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Finds the order of elimination and the pattern of L for the n x n matrices with entries in these
/// places. The diagonal is part of the pattern.
///
/// - `row_starts`: n + 1 elements: the entries of row i are those from `row_starts[i]` to
///   `row_starts[i + 1] - 1`, the first being 0.
/// - `columns`: `row_starts[n]` elements, ascending within a row, from 0. A matrix by columns is
///   given as its transpose: CATA_UPPER and CATA_LOWER change places.
/// - `cholesky`: a handle, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_cholesky_analyse(
    n: usize,
    row_starts: *const usize,
    columns: *const usize,
    params: *const cata_cholesky_params,
    cholesky: *mut *mut cata_cholesky,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the CSR arrays; `params.order`, `n` elements; `cholesky`, one
        // value), clause `structs` (`params`).
        let (places, params, order, handle) = unsafe {
            let places = pattern(n, n, row_starts, columns)?;
            let params = read_or_zeros("params", params)?;
            let order = optional_slice("params.order", params.order, n)?;
            (places, params, order, output("cholesky", cholesky)?)
        };
        let caller = params.caller();
        let options = options(&params)?.order(order);
        let cholesky = caller
            .with(|progress| Cholesky::analyse(places.view(), &options.progress(progress)))?;
        hand_over(handle, cata_cholesky { cholesky, caller });
        Ok(())
    })
}

/// Frees a factorization.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_cholesky_free(cholesky: *mut cata_cholesky) {
    // SAFETY: clause `handles` (`cholesky`).
    unsafe { free(cholesky) };
}

/// Computes L for a matrix without entries outside of the pattern that was analysed, any number of
/// times: arrays as in cata_cholesky_analyse, and `entries`: `row_starts[n]` finite elements. After
/// an error there is no factor; CATA_ERR_ARGUMENT names the row at which elimination fails.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_cholesky_factor(
    cholesky: *mut cata_cholesky,
    row_starts: *const usize,
    columns: *const usize,
    entries: *const f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the CSR arrays), clause `handles` (`cholesky`).
        let (handle, a) = unsafe {
            let handle = known_mut("cholesky", cholesky)?;
            let n = handle.cholesky.n();
            let a = sparse(n, n, row_starts, columns, entries)?;
            (handle, a)
        };
        Ok(handle.caller.with(|progress| handle.cholesky.factor(a, progress))?)
    })
}

/// Solves A X = B: replaces B in `x` (n x count) by X.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_cholesky_solve(
    cholesky: *const cata_cholesky,
    layout: i32,
    count: usize,
    x: *mut f64,
    ldx: usize,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (`x`, `handle.cholesky.n()` x `count`), clause `handles`
        // (`cholesky`).
        let (handle, x) = unsafe {
            let handle = known("cholesky", cholesky)?;
            (handle, matrix_mut("x", layout, handle.cholesky.n(), count, x, ldx)?)
        };
        Ok(handle.caller.watch_the_end(|| handle.cholesky.solve_in_place(x))?)
    })
}

/// Computes some rows of the solution of A X = B, without memory for the others.
///
/// - `b`: n x count.
/// - `rows`: n_rows elements: the rows of X wanted, from 0, in any order.
/// - `x`: n_rows x count, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_cholesky_solve_rows(
    cholesky: *const cata_cholesky,
    layout: i32,
    count: usize,
    b: *const f64,
    ldb: usize,
    n_rows: usize,
    rows: *const usize,
    x: *mut f64,
    ldx: usize,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (`b`, `handle.cholesky.n()` x `count`; `rows`, `n_rows` elements;
        // `x`, `n_rows` x `count`), clause `handles` (`cholesky`).
        let (handle, b, rows, mut x) = unsafe {
            let handle = known("cholesky", cholesky)?;
            (
                handle,
                matrix("b", layout, handle.cholesky.n(), count, b, ldb)?,
                slice("rows", rows, n_rows)?,
                matrix_mut("x", layout, n_rows, count, x, ldx)?,
            )
        };
        x.copy_from(&handle.caller.watch_the_end(|| handle.cholesky.solve_rows(b, rows))?);
        Ok(())
    })
}

/// Gets the size of a factorization, each number NULL where not wanted: rows of A, entries of L,
/// zeros among them, and held rows, 0 without a factor.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_cholesky_size(
    cholesky: *const cata_cholesky,
    n: *mut usize,
    entries: *mut usize,
    held: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`n`, `entries`, `held`, one value each), clause `handles`
        // (`cholesky`).
        unsafe {
            let own = &known("cholesky", cholesky)?.cholesky;
            tell!(n: own.n(), entries: own.entries(), held: own.held().len());
        }
        Ok(())
    })
}

/// Copies the numbers of the held rows (cata_cholesky_size), ascending: X is 0 there, and the
/// equations of these rows follow from the others where there is a solution. A Laplacian has one in
/// each component.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_cholesky_held(
    cholesky: *const cata_cholesky,
    held: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`held`, one element for each), clause `handles` (`cholesky`).
        unsafe { copy("held", held, known("cholesky", cholesky)?.cholesky.held()) }
    })
}

/// Gets the row with the smallest pivot relative to its diagonal entry, and this ratio: at 1e-12,
/// solutions may lose 12 digits. Held rows do not count. Without other rows or a factor they are n
/// and 1. Each is NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_cholesky_weakest(
    cholesky: *const cata_cholesky,
    row: *mut usize,
    ratio: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`row`, one value; `ratio`, one value), clause `handles`
        // (`cholesky`).
        unsafe {
            let own = &known("cholesky", cholesky)?.cholesky;
            let (weakest, least) = own.weakest().unwrap_or((own.n(), 1.0));
            tell!(row: weakest, ratio: least);
        }
        Ok(())
    })
}

/// Returns the options of the caller, without the order and progress.
pub(super) fn options(params: &cata_cholesky_params) -> Result<CholeskyOptions<'static>, Failure> {
    let triangle = match params.triangle {
        0 | CATA_BOTH => Triangle::Both,
        CATA_LOWER => Triangle::Lower,
        CATA_UPPER => Triangle::Upper,
        other => return Err(Failure::argument("params.triangle", UPLO, other)),
    };
    let semidefinite = flag("params.semidefinite", params.semidefinite)?;
    let tolerance = (params.tolerance != 0.0).then_some(params.tolerance);
    Ok(CholeskyOptions::new()
        .triangle(triangle)
        .semidefinite(semidefinite)
        .tolerance(tolerance)
        .par(params.par()))
}
