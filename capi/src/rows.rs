//! # Streams of rows
//!
//! Products of weighted and centred rows, which are read in blocks.
//!
//! ```c
//! double a[] = {1, 2, 3, 4, 5, 6}, c[4]; // 3 x 2, its covariance
//! cata_ata_rows_f64(CATA_ROW_MAJOR, CATA_BOTH, 3, 2, 0.5, a, 2, NULL, CATA_CENTER_MEAN, NULL, 0,
//!     c, 2, NULL);
//! printf("%g\n", c[1]); // 4
//! ```

use super::ata::symmetric;
use super::ata_params::cata_ata_params;
use super::pointer::{optional_slice, slice};
use super::status::{Failure, cata_status};
use catamaran::blas::BlasReal;
use catamaran::rows::{Center, DenseRows, RowOptions, ata_rows};

/// `centering`: nothing is subtracted from the rows.
pub const CATA_CENTER_NONE: i32 = 0;
/// `centering`: the (weighted) mean of the rows is subtracted.
pub const CATA_CENTER_MEAN: i32 = 1;
/// `centering`: the row given is subtracted.
pub const CATA_CENTER_GIVEN: i32 = 2;

/// Computes C := alpha X^T W X + beta C, where X is A with a row subtracted from every row, and W =
/// diag(weights). A is read in blocks of rows, about 32 MiB each. With CATA_CENTER_MEAN and alpha =
/// 1 / (m - 1) C is the covariance matrix of the columns of A.
///
/// - `weights`: m finite numbers, negative ones too, read; NULL: all 1.
/// - `centering`: CATA_CENTER_NONE, CATA_CENTER_MEAN or CATA_CENTER_GIVEN.
/// - `center`: with CATA_CENTER_GIVEN n finite numbers, read; else ignored.
///
/// The rest as in cata_ata_f64, but that C holds unspecified values after CATA_ERR_OUT_OF_MEMORY
/// too. CATA_ERR_ARGUMENT when the weights of a mean sum to 0.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ata_rows_f64(
    layout: i32,
    uplo: i32,
    m: usize,
    n: usize,
    alpha: f64,
    a: *const f64,
    lda: usize,
    weights: *const f64,
    centering: i32,
    center: *const f64,
    beta: f64,
    c: *mut f64,
    ldc: usize,
    params: *const cata_ata_params,
) -> cata_status {
    // SAFETY: clause `passed on` (`rows`).
    unsafe {
        rows(layout, uplo, m, n, alpha, a, lda, weights, centering, center, beta, c, ldc, params)
    }
}

/// Computes cata_ata_rows_f64 in float; the mean is summed in double.
///
/// # Safety
/// The pointers are as described at `cata_ata_rows_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ata_rows_f32(
    layout: i32,
    uplo: i32,
    m: usize,
    n: usize,
    alpha: f32,
    a: *const f32,
    lda: usize,
    weights: *const f32,
    centering: i32,
    center: *const f32,
    beta: f32,
    c: *mut f32,
    ldc: usize,
    params: *const cata_ata_params,
) -> cata_status {
    // SAFETY: clause `passed on` (`rows`).
    unsafe {
        rows(layout, uplo, m, n, alpha, a, lda, weights, centering, center, beta, c, ldc, params)
    }
}

/// Implements `cata_ata_rows_*`.
///
/// # Safety
/// The pointers are as the header describes them.
unsafe fn rows<T: BlasReal>(
    layout: i32,
    uplo: i32,
    m: usize,
    n: usize,
    alpha: T,
    a: *const T,
    lda: usize,
    weights: *const T,
    centering: i32,
    center: *const T,
    beta: T,
    c: *mut T,
    ldc: usize,
    params: *const cata_ata_params,
) -> cata_status {
    // SAFETY: clause `memory` (`weights`, `m` elements; `center`, `n` elements), clause `passed on`
    // (`symmetric`).
    unsafe {
        symmetric(layout, uplo, (m, n, a, lda), (n, c, ldc), params, |a, c, options| {
            let weights = optional_slice("weights", weights, m)?;
            let center = match centering {
                CATA_CENTER_NONE => Center::No,
                CATA_CENTER_MEAN => Center::Mean,
                CATA_CENTER_GIVEN => Center::Given(slice("center", center, n)?),
                other => {
                    let any = "a CATA_CENTER_* value";
                    return Err(Failure::argument("centering", any, other));
                }
            };
            if n == 0 {
                return Ok(()); // m may exceed the address space
            }
            let row_options = RowOptions::new().weights(weights).center(center);
            Ok(ata_rows(alpha, &mut DenseRows(a), &row_options, beta, c, options)?)
        })
    }
}
