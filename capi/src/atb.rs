use super::ata::scratch_len;
use super::ata_params::{cata_ata_params, with_options};
use super::boundary::boundary;
use super::pointer::{Layout, matrix, matrix_mut, slice_mut};
use super::status::{Failure, cata_status};
use catamaran::blas::BlasReal;
use catamaran::product::atb_planned;
use catamaran::{AtaOptions, Plan, Uplo, atb_into};
use faer::{MatMut, MatRef};

/// Computes C := alpha A^T B + beta C, for A m x n, B m x k and C n x k. A and B may overlap. The
/// rest as in cata_ata_f64, with NaN and infinities of columns of A and of B.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_atb_f64(
    layout: i32,
    m: usize,
    n: usize,
    k: usize,
    alpha: f64,
    a: *const f64,
    lda: usize,
    b: *const f64,
    ldb: usize,
    beta: f64,
    c: *mut f64,
    ldc: usize,
    params: *const cata_ata_params,
) -> cata_status {
    // SAFETY: clause `passed on` (`general`).
    unsafe {
        general(layout, (m, a, lda, n), (b, ldb, k), (c, ldc), params, |a, b, c, options| {
            atb_into(alpha, a, b, beta, c, options)
        })
    }
}

/// Computes cata_atb_f64 in float.
///
/// # Safety
/// The pointers are as described at `cata_atb_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_atb_f32(
    layout: i32,
    m: usize,
    n: usize,
    k: usize,
    alpha: f32,
    a: *const f32,
    lda: usize,
    b: *const f32,
    ldb: usize,
    beta: f32,
    c: *mut f32,
    ldc: usize,
    params: *const cata_ata_params,
) -> cata_status {
    // SAFETY: clause `passed on` (`general`).
    unsafe {
        general(layout, (m, a, lda, n), (b, ldb, k), (c, ldc), params, |a, b, c, options| {
            atb_into(alpha, a, b, beta, c, options)
        })
    }
}

/// Gets the length of the scratch of cata_atb_with_scratch_f64 for the same m, n, k and params.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_atb_scratch_len_f64(
    m: usize,
    n: usize,
    k: usize,
    params: *const cata_ata_params,
    len: *mut usize,
) -> cata_status {
    // SAFETY: clause `passed on` (`atb_scratch_len`).
    unsafe { atb_scratch_len::<f64>(m, n, k, params, len) }
}

/// Gets the length as cata_atb_scratch_len_f64 does, in float.
///
/// # Safety
/// The pointers are as described at `cata_atb_scratch_len_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_atb_scratch_len_f32(
    m: usize,
    n: usize,
    k: usize,
    params: *const cata_ata_params,
    len: *mut usize,
) -> cata_status {
    // SAFETY: clause `passed on` (`atb_scratch_len`).
    unsafe { atb_scratch_len::<f32>(m, n, k, params, len) }
}

/// Computes cata_atb_f64 in scratch of the caller, with any contents and at least the length from
/// cata_atb_scratch_len_f64. It is overwritten.
///
/// # Safety
/// The pointers are as described at `cata_atb_f64`. So is `scratch` here.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_atb_with_scratch_f64(
    layout: i32,
    m: usize,
    n: usize,
    k: usize,
    alpha: f64,
    a: *const f64,
    lda: usize,
    b: *const f64,
    ldb: usize,
    beta: f64,
    c: *mut f64,
    ldc: usize,
    scratch: *mut f64,
    scratch_len: usize,
    params: *const cata_ata_params,
) -> cata_status {
    // SAFETY: clause `memory` (`scratch`, `scratch_len` elements), clause `passed on` (`general`).
    unsafe {
        general(layout, (m, a, lda, n), (b, ldb, k), (c, ldc), params, |a, b, c, options| {
            let scratch = slice_mut("scratch", scratch, scratch_len)?;
            let plan = Plan::atb::<f64>(m, n, k, options)?;
            Ok::<_, Failure>(atb_planned(&plan, alpha, a, b, beta, c, options, Some(scratch))?)
        })
    }
}

/// Computes cata_atb_with_scratch_f64 in float.
///
/// # Safety
/// The pointers are as described at `cata_atb_with_scratch_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_atb_with_scratch_f32(
    layout: i32,
    m: usize,
    n: usize,
    k: usize,
    alpha: f32,
    a: *const f32,
    lda: usize,
    b: *const f32,
    ldb: usize,
    beta: f32,
    c: *mut f32,
    ldc: usize,
    scratch: *mut f32,
    scratch_len: usize,
    params: *const cata_ata_params,
) -> cata_status {
    // SAFETY: clause `memory` (`scratch`, `scratch_len` elements), clause `passed on` (`general`).
    unsafe {
        general(layout, (m, a, lda, n), (b, ldb, k), (c, ldc), params, |a, b, c, options| {
            let scratch = slice_mut("scratch", scratch, scratch_len)?;
            let plan = Plan::atb::<f32>(m, n, k, options)?;
            Ok::<_, Failure>(atb_planned(&plan, alpha, a, b, beta, c, options, Some(scratch))?)
        })
    }
}

/// Calls `work` with A (m x n), B (m x k) and C (n x k), each with its leading dimension, and the
/// options of the caller.
///
/// # Safety
/// The pointers are as the header describes them.
pub(super) unsafe fn general<T: Copy, X>(
    layout: i32,
    (m, a, lda, n): (usize, *const T, usize, usize),
    (b, ldb, k): (*const T, usize, usize),
    (c, ldc): (*mut T, usize),
    params: *const cata_ata_params,
    work: impl FnOnce(MatRef<'_, T>, MatRef<'_, T>, MatMut<'_, T>, &AtaOptions<'_>) -> Result<(), X>,
) -> cata_status
where
    Failure: From<X>,
{
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (`a`, m x n; `b`, m x k; `c`, n x k), clause `structs`
        // (`params`).
        unsafe {
            let a = matrix("a", layout, m, n, a, lda)?;
            let b = matrix("b", layout, m, k, b, ldb)?;
            let c = matrix_mut("c", layout, n, k, c, ldc)?;
            with_options(params, Uplo::Lower, |options| Ok(work(a, b, c, options)?))
        }
    })
}

/// Implements `cata_atb_scratch_len_*`.
///
/// # Safety
/// The pointers are as the header describes them.
unsafe fn atb_scratch_len<T: BlasReal>(
    m: usize,
    n: usize,
    k: usize,
    params: *const cata_ata_params,
    len: *mut usize,
) -> cata_status {
    // SAFETY: clause `passed on` (`scratch_len`).
    unsafe {
        scratch_len::<T>(&[("a", m, n), ("b", m, k), ("c", n, k)], params, len, |options| {
            Ok(Plan::atb::<T>(m, n, k, options)?.scratch_len::<T>(options.par))
        })
    }
}
