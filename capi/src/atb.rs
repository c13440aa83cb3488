use super::ata_params::{cata_ata_params, with_options};
use super::boundary::boundary;
use super::pointer::{Layout, check_size, matrix, matrix_mut, output, slice_mut};
use super::status::cata_status;
use catamaran::blas::BlasReal;
use catamaran::product::atb_planned;
use catamaran::{AtaOptions, Plan, Uplo};

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
    // SAFETY: the promises are the same.
    unsafe { atb(layout, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc, params) }
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
    // SAFETY: the promises are the same.
    unsafe { atb(layout, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc, params) }
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
    // SAFETY: the promises are the same.
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
    // SAFETY: the promises are the same.
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
    // SAFETY: the promises are the same.
    unsafe {
        atb_with_scratch(
            layout,
            m,
            n,
            k,
            alpha,
            a,
            lda,
            b,
            ldb,
            beta,
            c,
            ldc,
            scratch,
            scratch_len,
            params,
        )
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
    // SAFETY: the promises are the same.
    unsafe {
        atb_with_scratch(
            layout,
            m,
            n,
            k,
            alpha,
            a,
            lda,
            b,
            ldb,
            beta,
            c,
            ldc,
            scratch,
            scratch_len,
            params,
        )
    }
}

/// Implements `cata_atb_*`.
///
/// # Safety
/// The pointers are as the header describes them.
unsafe fn atb<T: BlasReal>(
    layout: i32,
    m: usize,
    n: usize,
    k: usize,
    alpha: T,
    a: *const T,
    lda: usize,
    b: *const T,
    ldb: usize,
    beta: T,
    c: *mut T,
    ldc: usize,
    params: *const cata_ata_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: the caller's promise.
        let (a, b, c) = unsafe {
            (
                matrix("a", layout, m, n, a, lda)?,
                matrix("b", layout, m, k, b, ldb)?,
                matrix_mut("c", layout, n, k, c, ldc)?,
            )
        };
        let work =
            |options: &AtaOptions<'_>| Ok(catamaran::atb_into(alpha, a, b, beta, c, options)?);
        // SAFETY: the caller's promise.
        unsafe { with_options(params, Uplo::Both, work) }
    })
}

/// Implements `cata_atb_with_scratch_*`.
///
/// # Safety
/// The pointers are as the header describes them.
unsafe fn atb_with_scratch<T: BlasReal>(
    layout: i32,
    m: usize,
    n: usize,
    k: usize,
    alpha: T,
    a: *const T,
    lda: usize,
    b: *const T,
    ldb: usize,
    beta: T,
    c: *mut T,
    ldc: usize,
    scratch: *mut T,
    scratch_len: usize,
    params: *const cata_ata_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: the caller's promise.
        let (a, b, c) = unsafe {
            (
                matrix("a", layout, m, n, a, lda)?,
                matrix("b", layout, m, k, b, ldb)?,
                matrix_mut("c", layout, n, k, c, ldc)?,
            )
        };
        // SAFETY: the caller's promise.
        let scratch = unsafe { slice_mut("scratch", scratch, scratch_len) }?;
        let work = |options: &AtaOptions<'_>| {
            let plan = Plan::atb::<T>(m, n, k, options)?;
            Ok(atb_planned(&plan, alpha, a, b, beta, c, options, Some(scratch))?)
        };
        // SAFETY: the caller's promise.
        unsafe { with_options(params, Uplo::Both, work) }
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
    boundary(|| {
        // SAFETY: the caller's promise.
        let len = unsafe { output("len", len) }?;
        check_size::<T>("a", m, n)?;
        check_size::<T>("b", m, k)?;
        check_size::<T>("c", n, k)?;
        let work = |options: &AtaOptions<'_>| {
            *len = Plan::atb::<T>(m, n, k, options)?.scratch_len::<T>(options.par);
            Ok(())
        };
        // SAFETY: the caller's promise.
        unsafe { with_options(params, Uplo::Both, work) }
    })
}
