use super::ata_params::{cata_ata_params, with_options};
use super::boundary::boundary;
use super::pointer::{Layout, matrix_mut, optional_slice, sparse, uplo_from};
use super::status::cata_status;
use catamaran::blas::BlasReal;
use catamaran::product::ata_sparse;

/// Computes C := alpha A^T W A + beta C, for a sparse A, m x n, weights W or none, and C n x n,
/// dense. The sums are those of the classical algorithm, in double and in the order of the rows.
///
/// - `row_starts`: m + 1 elements, read: the entries of row i are those from `row_starts[i]` to
///   `row_starts[i + 1] - 1`, the first being 0.
/// - `columns`, `entries`: `row_starts[m]` elements each, read: columns ascending within a row,
///   from 0, each at most once, and the entries of A there.
/// - `weights`: m finite elements, read; NULL: all 1.
/// - `params`: `threads` and `progress` are used, the rest is only checked.
///
/// The rest as in cata_ata_f64.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ata_sparse_f64(
    layout: i32,
    uplo: i32,
    m: usize,
    n: usize,
    alpha: f64,
    row_starts: *const usize,
    columns: *const usize,
    entries: *const f64,
    weights: *const f64,
    beta: f64,
    c: *mut f64,
    ldc: usize,
    params: *const cata_ata_params,
) -> cata_status {
    // SAFETY: clause `passed on` (`product`).
    unsafe {
        product(
            layout, uplo, m, n, alpha, row_starts, columns, entries, weights, beta, c, ldc, params,
        )
    }
}

/// Computes cata_ata_sparse_f64 with A and C in float; weights and sums are in double.
///
/// # Safety
/// The pointers are as described at `cata_ata_sparse_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ata_sparse_f32(
    layout: i32,
    uplo: i32,
    m: usize,
    n: usize,
    alpha: f32,
    row_starts: *const usize,
    columns: *const usize,
    entries: *const f32,
    weights: *const f64,
    beta: f32,
    c: *mut f32,
    ldc: usize,
    params: *const cata_ata_params,
) -> cata_status {
    // SAFETY: clause `passed on` (`product`).
    unsafe {
        product(
            layout, uplo, m, n, alpha, row_starts, columns, entries, weights, beta, c, ldc, params,
        )
    }
}

/// Implements `cata_ata_sparse_*`.
///
/// # Safety
/// The pointers are as the header describes them.
unsafe fn product<T: BlasReal>(
    layout: i32,
    uplo: i32,
    m: usize,
    n: usize,
    alpha: T,
    row_starts: *const usize,
    columns: *const usize,
    entries: *const T,
    weights: *const f64,
    beta: T,
    c: *mut T,
    ldc: usize,
    params: *const cata_ata_params,
) -> cata_status {
    boundary(|| {
        let (layout, uplo) = (Layout::new(layout)?, uplo_from(uplo)?);
        // SAFETY: clause `memory` (the CSR arrays; `weights`, `m` elements; `c`, n x n), clause
        // `structs` (`params`).
        unsafe {
            let a = sparse(m, n, row_starts, columns, entries)?;
            let weights = optional_slice("weights", weights, m)?;
            let c = matrix_mut("c", layout, n, n, c, ldc)?;
            with_options(params, uplo, |options| {
                Ok(ata_sparse(alpha, a, weights, beta, c, options)?)
            })
        }
    })
}
