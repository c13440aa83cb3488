use faer::complex::Complex;

use super::ata::symmetric;
use super::ata_params::cata_ata_params;
use super::atb::general;
use super::pointer::array;
use super::status::{Failure, cata_status};
use catamaran::blas::BlasReal;
use catamaran::{aha_into, ahb_into};

/// Computes C := alpha A^H A + beta C, for complex A m x n and Hermitian C n x n; alpha and beta
/// are real.
///
/// A complex element is two doubles, the real part and then the imaginary one, as `double
/// complex` of C99 and `std::complex<double>` of C++: pointers to those can be cast. Leading
/// dimensions count complex elements.
///
/// - `uplo`: as in cata_ata_f64. With CATA_BOTH the upper triangle is the conjugate of the lower
///   one, bit for bit; with beta != 0 the old lower one is what is read.
/// - `c`: imaginary parts of its diagonal are not read, and become 0. C is untouched after any
///   error but CATA_ERR_PANIC, which leaves unspecified values in its wanted part.
///
/// The extra memory is that of a matrix like C, 64 MiB (or 1024 rows of A if those are longer),
/// and the scratch of cata_ata_f64 for as many rows.
///
/// With u = 2^-53 (float: 2^-24) both parts of entry (i, j) of a product with the default params
/// are wrong by at most 8 m u |a_i| |a_j|, the Euclidean norms of two columns. NaN and
/// infinities have the effect of (x - i y)(u + i v) = (x u + y v) + i (x v - y u), term by term,
/// in classical and exact products; fast products spread them further.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_aha_c64(
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
    let (a, c) = (a.cast::<Complex<f64>>(), c.cast::<Complex<f64>>());
    // SAFETY: clause `passed on` (`symmetric`); a Complex is two reals, without more alignment.
    unsafe {
        symmetric(layout, uplo, (m, n, a, lda), (n, c, ldc), params, |a, c, options| {
            aha_into(alpha, a, beta, c, options)
        })
    }
}

/// Computes cata_aha_c64 in float: `float complex` and `std::complex<float>`.
///
/// # Safety
/// The pointers are as described at `cata_aha_c64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_aha_c32(
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
    let (a, c) = (a.cast::<Complex<f32>>(), c.cast::<Complex<f32>>());
    // SAFETY: clause `passed on` (`symmetric`); a Complex is two reals, without more alignment.
    unsafe {
        symmetric(layout, uplo, (m, n, a, lda), (n, c, ldc), params, |a, c, options| {
            aha_into(alpha, a, beta, c, options)
        })
    }
}

/// Computes C := alpha A^H B + beta C, complex, for A m x n, B m x k, C n x k. A and B may overlap.
///
/// - `alpha`, `beta`: one complex element each, read; with beta == 0 C is not read. A real one
///   multiplies both parts.
///
/// The rest as in cata_aha_c64.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ahb_c64(
    layout: i32,
    m: usize,
    n: usize,
    k: usize,
    alpha: *const f64,
    a: *const f64,
    lda: usize,
    b: *const f64,
    ldb: usize,
    beta: *const f64,
    c: *mut f64,
    ldc: usize,
    params: *const cata_ata_params,
) -> cata_status {
    // SAFETY: clause `passed on` (`ahb`).
    unsafe { ahb(layout, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc, params) }
}

/// Computes cata_ahb_c64 in float: `float complex` and `std::complex<float>`.
///
/// # Safety
/// The pointers are as described at `cata_ahb_c64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ahb_c32(
    layout: i32,
    m: usize,
    n: usize,
    k: usize,
    alpha: *const f32,
    a: *const f32,
    lda: usize,
    b: *const f32,
    ldb: usize,
    beta: *const f32,
    c: *mut f32,
    ldc: usize,
    params: *const cata_ata_params,
) -> cata_status {
    // SAFETY: clause `passed on` (`ahb`).
    unsafe { ahb(layout, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc, params) }
}

/// Implements `cata_ahb_*`.
///
/// # Safety
/// The pointers are as the header describes them.
unsafe fn ahb<T: BlasReal>(
    layout: i32,
    m: usize,
    n: usize,
    k: usize,
    alpha: *const T,
    a: *const T,
    lda: usize,
    b: *const T,
    ldb: usize,
    beta: *const T,
    c: *mut T,
    ldc: usize,
    params: *const cata_ata_params,
) -> cata_status {
    let (a, b, c) = (a.cast::<Complex<T>>(), b.cast(), c.cast());
    // SAFETY: clause `memory` (`alpha` and `beta`, 2 elements each), clause `passed on`
    // (`general`); a Complex is two reals, without more alignment.
    unsafe {
        general(layout, (m, a, lda, n), (b, ldb, k), (c, ldc), params, |a, b, c, options| {
            let [alpha, beta] = [array("alpha", alpha)?, array("beta", beta)?]
                .map(|[re, im]: [T; 2]| Complex { re, im });
            Ok::<_, Failure>(ahb_into(alpha, a, b, beta, c, options)?)
        })
    }
}
