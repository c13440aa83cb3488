use super::boundary::boundary;
use super::pointer::{Layout, matrix, optional_output, output, put, uplo_from};
use super::status::{Failure, cata_status};
use catamaran::Real;
use catamaran::product::verify;

/// Checks that C = alpha A^T A for A m x n and C n x n, up to rounding, with `rounds` random
/// vectors (Freivalds 1977), in time proportional to rounds (m n + n^2), on the calling thread.
/// CATA_OK whether C passed or not; CATA_ERR_NON_FINITE where A holds a NaN or an infinity, whose
/// place the message names.
///
/// - `uplo`: the part of C that is checked.
/// - `rounds`: 1 to 1000. A C with an entry wrong by more than twice the tolerance passes with
///   probability at most 2^-rounds.
/// - `seed`: of the random vectors; the same seed gives the same answer.
/// - `passed`: written: 1 if C passed, else 0.
/// - `residual`, `tolerance`: written: the largest entry of |C X - alpha A^T (A X)|, and how
///   large rounding may make it; NULL where not wanted. If the tolerance overflows, no C passes,
///   and `passed` = 0 says nothing about C.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_verify_f64(
    layout: i32,
    uplo: i32,
    m: usize,
    n: usize,
    alpha: f64,
    a: *const f64,
    lda: usize,
    c: *const f64,
    ldc: usize,
    rounds: i32,
    seed: u64,
    passed: *mut i32,
    residual: *mut f64,
    tolerance: *mut f64,
) -> cata_status {
    // SAFETY: clause `passed on` (`check`).
    unsafe {
        check(layout, uplo, m, n, alpha, a, lda, c, ldc, rounds, seed, passed, residual, tolerance)
    }
}

/// Checks a product in float as cata_verify_f64. The check itself is in double.
///
/// # Safety
/// The pointers are as described at `cata_verify_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_verify_f32(
    layout: i32,
    uplo: i32,
    m: usize,
    n: usize,
    alpha: f64,
    a: *const f32,
    lda: usize,
    c: *const f32,
    ldc: usize,
    rounds: i32,
    seed: u64,
    passed: *mut i32,
    residual: *mut f64,
    tolerance: *mut f64,
) -> cata_status {
    // SAFETY: clause `passed on` (`check`).
    unsafe {
        check(layout, uplo, m, n, alpha, a, lda, c, ldc, rounds, seed, passed, residual, tolerance)
    }
}

/// Implements `cata_verify_*`.
///
/// # Safety
/// The pointers are as the header describes them.
unsafe fn check<T: Real>(
    layout: i32,
    uplo: i32,
    m: usize,
    n: usize,
    alpha: f64,
    a: *const T,
    lda: usize,
    c: *const T,
    ldc: usize,
    rounds: i32,
    seed: u64,
    passed: *mut i32,
    residual: *mut f64,
    tolerance: *mut f64,
) -> cata_status {
    boundary(|| {
        let (layout, uplo) = (Layout::new(layout)?, uplo_from(uplo)?);
        if !(1..=1000).contains(&rounds) {
            return Err(Failure::argument("rounds", "1 to 1000", rounds));
        }
        // SAFETY: clause `memory` (`a`, m x n; `c`, n x n).
        let (a, c) =
            unsafe { (matrix("a", layout, m, n, a, lda)?, matrix("c", layout, n, n, c, ldc)?) };
        // SAFETY: clause `memory` (`passed`, one value; `residual`, one value; `tolerance`, one
        // value).
        let (passed, residual, tolerance) = unsafe {
            (
                output("passed", passed)?,
                optional_output("residual", residual)?,
                optional_output("tolerance", tolerance)?,
            )
        };
        // Without columns there is nothing to check, and m may exceed the address space.
        let a = if n == 0 { a.subrows(0, 0) } else { a };
        let found = verify(alpha, a, c, uplo, rounds as u32, seed)?;
        *passed = found.passed.into();
        put(residual, found.residual);
        put(tolerance, found.tolerance);
        Ok(())
    })
}
