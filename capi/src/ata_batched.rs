//! Many products of one shape at once.

use super::ata_params::{cata_ata_params, with_options};
use super::boundary::boundary;
use super::pointer::{Layout, Starts, matrices, matrices_mut, uplo_from};
use super::regions::check_batch;
use super::status::cata_status;
use catamaran::blas::BlasReal;
use catamaran::product::ata_batched_into;

/// Computes C_i := alpha A_i^T A_i + beta C_i for each of `count` matrices, with the bytes of
/// cata_ata_f64. Threads share the products; `progress` is called after some of them. The C_i hold
/// unspecified values in their wanted parts after CATA_ERR_OUT_OF_MEMORY too.
///
/// - `stride_a`: elements from one A_i to the next; the A_i may overlap.
/// - `stride_c`: the same of C, at least the elements from the first to the last entry of a C_i,
///   all of which count as its memory.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ata_batched_f64(
    layout: i32,
    uplo: i32,
    count: usize,
    m: usize,
    n: usize,
    alpha: f64,
    a: *const f64,
    lda: usize,
    stride_a: usize,
    beta: f64,
    c: *mut f64,
    ldc: usize,
    stride_c: usize,
    params: *const cata_ata_params,
) -> cata_status {
    let (a, c) = (Starts::Every(a, stride_a), Starts::Every(c.cast_const(), stride_c));
    // SAFETY: clause `passed on` (`batched`).
    unsafe { batched(layout, uplo, [count, m, n], alpha, (a, lda), beta, (c, ldc), params) }
}

/// Computes cata_ata_batched_f64 in float.
///
/// # Safety
/// The pointers are as described at `cata_ata_batched_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ata_batched_f32(
    layout: i32,
    uplo: i32,
    count: usize,
    m: usize,
    n: usize,
    alpha: f32,
    a: *const f32,
    lda: usize,
    stride_a: usize,
    beta: f32,
    c: *mut f32,
    ldc: usize,
    stride_c: usize,
    params: *const cata_ata_params,
) -> cata_status {
    let (a, c) = (Starts::Every(a, stride_a), Starts::Every(c.cast_const(), stride_c));
    // SAFETY: clause `passed on` (`batched`).
    unsafe { batched(layout, uplo, [count, m, n], alpha, (a, lda), beta, (c, ldc), params) }
}

/// Computes cata_ata_batched_f64 for matrices at `count` pointers each. No C_i may overlap another
/// matrix; blocks of one matrix do not.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ata_batched_pointers_f64(
    layout: i32,
    uplo: i32,
    count: usize,
    m: usize,
    n: usize,
    alpha: f64,
    a: *const *const f64,
    lda: usize,
    beta: f64,
    c: *const *mut f64,
    ldc: usize,
    params: *const cata_ata_params,
) -> cata_status {
    let (a, c) = (Starts::At(a), Starts::At(c.cast()));
    // SAFETY: clause `passed on` (`batched`).
    unsafe { batched(layout, uplo, [count, m, n], alpha, (a, lda), beta, (c, ldc), params) }
}

/// Computes cata_ata_batched_pointers_f64 in float.
///
/// # Safety
/// The pointers are as described at `cata_ata_batched_pointers_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ata_batched_pointers_f32(
    layout: i32,
    uplo: i32,
    count: usize,
    m: usize,
    n: usize,
    alpha: f32,
    a: *const *const f32,
    lda: usize,
    beta: f32,
    c: *const *mut f32,
    ldc: usize,
    params: *const cata_ata_params,
) -> cata_status {
    let (a, c) = (Starts::At(a), Starts::At(c.cast()));
    // SAFETY: clause `passed on` (`batched`).
    unsafe { batched(layout, uplo, [count, m, n], alpha, (a, lda), beta, (c, ldc), params) }
}

/// Implements `cata_ata_batched_*`.
///
/// # Safety
/// The pointers are as the header describes them.
unsafe fn batched<T: BlasReal>(
    layout: i32,
    uplo: i32,
    [count, m, n]: [usize; 3],
    alpha: T,
    (a, lda): (Starts<T>, usize),
    beta: T,
    (c, ldc): (Starts<T>, usize),
    params: *const cata_ata_params,
) -> cata_status {
    boundary(|| {
        let (layout, uplo) = (Layout::new(layout)?, uplo_from(uplo)?);
        let mut all = Vec::new();
        // SAFETY: clause `structs` (`params`), clause `passed on` (`matrices`, `matrices_mut`).
        unsafe {
            let a = matrices("a", layout, [count, m, n], a, lda, &mut all)?;
            let mut c = matrices_mut("c", layout, [count, n, n], c, ldc, &mut all)?;
            check_batch(&all, count)?;
            with_options(params, uplo, |options| {
                Ok(ata_batched_into(alpha, &a, beta, &mut c, options)?)
            })
        }
    })
}
