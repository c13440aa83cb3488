//! # A^T A
//!
//! Dense products: symmetric, of two matrices, Hermitian; of a sparse matrix; and a
//! probabilistic check.
//!
//! ```c
//! double a[] = {1, 2, 3, 4, 5, 6}, c[4]; // 3 x 2
//! cata_ata_f64(CATA_ROW_MAJOR, CATA_BOTH, 3, 2, 1, a, 2, 0, c, 2, NULL);
//! printf("%g %g %g\n", c[0], c[1], c[3]); // 35 44 56
//! ```

use super::ata_params::{cata_ata_params, with_options};
use super::boundary::boundary;
use super::pointer::{Layout, check_size, matrix, matrix_mut, output, slice_mut, uplo_from};
use super::status::{Failure, cata_status};
use catamaran::blas::BlasReal;
use catamaran::product::ata_planned;
use catamaran::rows::{DenseRows, RowOptions, ata_rows};
use catamaran::{AtaOptions, Plan, Uplo, aat_into, ata_into};
use faer::{MatMut, MatRef};

/// Computes C := alpha A^T A + beta C, for A m x n and C n x n.
///
/// - `uplo`: the part of C that is wanted, CATA_UPPER, CATA_LOWER or CATA_BOTH; the rest is
///   neither read nor written.
/// - `alpha`: with 0, A is not read.
/// - `beta`: with 0, C is not read, so it may be uninitialized.
///
/// The workspace is allocated before C is first written: C is untouched after any error but
/// CATA_ERR_CANCELLED and CATA_ERR_PANIC, which leave unspecified values in its wanted part.
///
/// With u = 2^-53 (float: 2^-24) entry (i, j) of a classical product is wrong by at most about m
/// u (|A|^T |A|)(i, j); that of CATA_SCHEME_EXACT with the default `error_factor` by at most
/// (1.1e-16 sqrt(m) + u) |a_i| |a_j| (float: 1.7e-8 for 1.1e-16), the Euclidean norms of two
/// columns, far below which it may have no correct digit; fast products are bounded in the
/// maximum norm only. CATA_SCHEME_AUTO may take any of them unless `error_factor` is 1, which
/// allows only the first, or CATA_ERROR_LEAST. NaN and infinities reach the entries of C of
/// their columns, in classical and exact products; fast products spread them further.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ata_f64(
    layout: i32,
    uplo: i32,
    m: usize,
    n: usize,
    alpha: f64,
    a: *const f64,
    lda: usize,
    beta: f64,
    c: *mut f64,
    ldc: usize,
    params: *const cata_ata_params,
) -> cata_status {
    // SAFETY: clause `passed on` (`symmetric`).
    unsafe {
        symmetric(layout, uplo, (m, n, a, lda), (n, c, ldc), params, |a, c, options| {
            ata_into(alpha, a, beta, c, options)
        })
    }
}

/// Computes cata_ata_f64 in float.
///
/// # Safety
/// The pointers are as described at `cata_ata_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ata_f32(
    layout: i32,
    uplo: i32,
    m: usize,
    n: usize,
    alpha: f32,
    a: *const f32,
    lda: usize,
    beta: f32,
    c: *mut f32,
    ldc: usize,
    params: *const cata_ata_params,
) -> cata_status {
    // SAFETY: clause `passed on` (`symmetric`).
    unsafe {
        symmetric(layout, uplo, (m, n, a, lda), (n, c, ldc), params, |a, c, options| {
            ata_into(alpha, a, beta, c, options)
        })
    }
}

/// Computes cata_ata_f64 with A in float, in blocks: sums and products are in double. C holds
/// unspecified values in its wanted part after CATA_ERR_OUT_OF_MEMORY too.
///
/// # Safety
/// The pointers are as described at `cata_ata_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ata_f32_f64(
    layout: i32,
    uplo: i32,
    m: usize,
    n: usize,
    alpha: f64,
    a: *const f32,
    lda: usize,
    beta: f64,
    c: *mut f64,
    ldc: usize,
    params: *const cata_ata_params,
) -> cata_status {
    // SAFETY: clause `passed on` (`symmetric`).
    unsafe {
        symmetric(layout, uplo, (m, n, a, lda), (n, c, ldc), params, |a, c, options| {
            if n == 0 {
                return Ok(()); // m may exceed the address space
            }
            ata_rows(alpha, &mut DenseRows(a), &RowOptions::new(), beta, c, options)
        })
    }
}

/// Gets the length of the scratch of cata_ata_with_scratch_f64 for the same m, n and params.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ata_scratch_len_f64(
    m: usize,
    n: usize,
    params: *const cata_ata_params,
    len: *mut usize,
) -> cata_status {
    // SAFETY: clause `passed on` (`ata_scratch_len`).
    unsafe { ata_scratch_len::<f64>(m, n, params, len) }
}

/// Gets the length as cata_ata_scratch_len_f64 does, in float.
///
/// # Safety
/// The pointers are as described at `cata_ata_scratch_len_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ata_scratch_len_f32(
    m: usize,
    n: usize,
    params: *const cata_ata_params,
    len: *mut usize,
) -> cata_status {
    // SAFETY: clause `passed on` (`ata_scratch_len`).
    unsafe { ata_scratch_len::<f32>(m, n, params, len) }
}

/// Computes cata_ata_f64 in scratch of the caller, with any contents and at least the length from
/// cata_ata_scratch_len_f64. It is overwritten.
///
/// # Safety
/// The pointers are as described at `cata_ata_f64`. So is `scratch` here.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ata_with_scratch_f64(
    layout: i32,
    uplo: i32,
    m: usize,
    n: usize,
    alpha: f64,
    a: *const f64,
    lda: usize,
    beta: f64,
    c: *mut f64,
    ldc: usize,
    scratch: *mut f64,
    scratch_len: usize,
    params: *const cata_ata_params,
) -> cata_status {
    // SAFETY: clause `memory` (`scratch`, `scratch_len` elements), clause `passed on`
    // (`symmetric`).
    unsafe {
        symmetric(layout, uplo, (m, n, a, lda), (n, c, ldc), params, |a, c, options| {
            let scratch = slice_mut("scratch", scratch, scratch_len)?;
            ata_in(alpha, a, beta, c, options, scratch)
        })
    }
}

/// Computes cata_ata_with_scratch_f64 in float.
///
/// # Safety
/// The pointers are as described at `cata_ata_with_scratch_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ata_with_scratch_f32(
    layout: i32,
    uplo: i32,
    m: usize,
    n: usize,
    alpha: f32,
    a: *const f32,
    lda: usize,
    beta: f32,
    c: *mut f32,
    ldc: usize,
    scratch: *mut f32,
    scratch_len: usize,
    params: *const cata_ata_params,
) -> cata_status {
    // SAFETY: clause `memory` (`scratch`, `scratch_len` elements), clause `passed on`
    // (`symmetric`).
    unsafe {
        symmetric(layout, uplo, (m, n, a, lda), (n, c, ldc), params, |a, c, options| {
            let scratch = slice_mut("scratch", scratch, scratch_len)?;
            ata_in(alpha, a, beta, c, options, scratch)
        })
    }
}

/// Computes C := alpha A A^T + beta C, for A m x n and C m x m. The rest as in cata_ata_f64.
///
/// # Safety
/// The pointers are as described at `cata_ata_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_aat_f64(
    layout: i32,
    uplo: i32,
    m: usize,
    n: usize,
    alpha: f64,
    a: *const f64,
    lda: usize,
    beta: f64,
    c: *mut f64,
    ldc: usize,
    params: *const cata_ata_params,
) -> cata_status {
    // SAFETY: clause `passed on` (`symmetric`).
    unsafe {
        symmetric(layout, uplo, (m, n, a, lda), (m, c, ldc), params, |a, c, options| {
            aat_into(alpha, a, beta, c, options)
        })
    }
}

/// Computes cata_aat_f64 in float.
///
/// # Safety
/// The pointers are as described at `cata_aat_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_aat_f32(
    layout: i32,
    uplo: i32,
    m: usize,
    n: usize,
    alpha: f32,
    a: *const f32,
    lda: usize,
    beta: f32,
    c: *mut f32,
    ldc: usize,
    params: *const cata_ata_params,
) -> cata_status {
    // SAFETY: clause `passed on` (`symmetric`).
    unsafe {
        symmetric(layout, uplo, (m, n, a, lda), (m, c, ldc), params, |a, c, options| {
            aat_into(alpha, a, beta, c, options)
        })
    }
}

/// Calls `work` with A (m x n), a square C, each with its leading dimension, and the options of the
/// caller.
///
/// # Safety
/// The pointers are as the header describes them.
pub(super) unsafe fn symmetric<A: Copy, C: Copy, X>(
    layout: i32,
    uplo: i32,
    (m, n, a, lda): (usize, usize, *const A, usize),
    (side, c, ldc): (usize, *mut C, usize),
    params: *const cata_ata_params,
    work: impl FnOnce(MatRef<'_, A>, MatMut<'_, C>, &AtaOptions<'_>) -> Result<(), X>,
) -> cata_status
where
    Failure: From<X>,
{
    boundary(|| {
        let (layout, uplo) = (Layout::new(layout)?, uplo_from(uplo)?);
        // SAFETY: clause `memory` (`a`, m x n; `c`, `side` x `side`), clause `structs` (`params`).
        unsafe {
            let a = matrix("a", layout, m, n, a, lda)?;
            let c = matrix_mut("c", layout, side, side, c, ldc)?;
            with_options(params, uplo, |options| Ok(work(a, c, options)?))
        }
    })
}

/// Computes A^T A in scratch of the caller.
fn ata_in<T: BlasReal>(
    alpha: T,
    a: MatRef<'_, T>,
    beta: T,
    c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
    scratch: &mut [T],
) -> Result<(), Failure> {
    let plan = Plan::ata::<T>(a.nrows(), a.ncols(), options)?;
    Ok(ata_planned(&plan, alpha, a, beta, c, options, Some(scratch))?)
}

/// Implements `cata_ata_scratch_len_*`.
///
/// # Safety
/// The pointers are as the header describes them.
unsafe fn ata_scratch_len<T: BlasReal>(
    m: usize,
    n: usize,
    params: *const cata_ata_params,
    len: *mut usize,
) -> cata_status {
    // SAFETY: clause `passed on` (`scratch_len`).
    unsafe {
        scratch_len::<T>(&[("a", m, n), ("c", n, n)], params, len, |options| {
            Ok(Plan::ata::<T>(m, n, options)?.scratch_len::<T>(options.par))
        })
    }
}

/// Writes the length of the scratch of a product of matrices of these sizes.
///
/// # Safety
/// The pointers are as the header describes them.
pub(super) unsafe fn scratch_len<T>(
    matrices: &[(&str, usize, usize)],
    params: *const cata_ata_params,
    len: *mut usize,
    find: impl FnOnce(&AtaOptions<'_>) -> catamaran::Result<usize>,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`len`, one value).
        let len = unsafe { output("len", len) }?;
        for &(what, rows, columns) in matrices {
            check_size::<T>(what, rows, columns)?;
        }
        let work = |options: &AtaOptions<'_>| {
            *len = find(options)?;
            Ok(())
        };
        // SAFETY: clause `structs` (`params`).
        unsafe { with_options(params, Uplo::Lower, work) }
    })
}
