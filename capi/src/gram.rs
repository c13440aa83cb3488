use std::ffi::c_void;

use faer::MatRef;
use faer::prelude::Reborrow;

use super::boundary::boundary;
use super::outputs::{fill, fill_slice};
use super::params::{Params, init, params, read_or_zeros};
use super::pointer::{
    Layout, matrix, matrix_mut, optional_matrix_mut, optional_output, optional_slice,
    optional_slice_mut, put,
};
use super::progress::cata_progress;
use super::rows::{CATA_CENTER_MEAN, CATA_CENTER_NONE};
use super::status::{Failure, cata_status};
use catamaran::rows::{Center, DenseRows, ExtendedGram, RowBlocks, RowOptions, ata_extended};
use catamaran::solve::{GramQr, SingularValues, correlation, orthogonality};
use catamaran::{AtaOptions, Error};

/// How a Gram matrix in extended precision is computed.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_gram_params {
    /// sizeof(cata_gram_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Progress callback; NULL: none. Fractions are those of the passes that form the Gram matrix;
    /// the work after them tells 1 again.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
}

params!(cata_gram_params, progress_user: *mut c_void);

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_gram_params_init(
    params: *mut cata_gram_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Computes the singular values of A (m x n), and its right singular vectors, from its Gram matrix
/// in extended precision: A = U diag(values) V^T, where column j of U is A v_j over the j-th value.
///
/// With K the condition number of A with columns of norm 1, the relative error of every value,
/// the smallest included, is a few n 2^-53 plus K^2 2^-106 (K^2 2^-80 where cata_gram_extended
/// is not exact).
///
/// - `m`, `n`: any, 0 included. Time and memory suit m >= n.
/// - `values`: min(m, n) elements, written: descending; zeros where columns depend on others as
///   far as the precision can tell. NULL where not wanted.
/// - `v`: V, n x min(m, n), written, with leading dimension `ldv`: an orthonormal column for
///   each value that is not 0, and zeros for the others. NULL where not wanted; `ldv` is then
///   ignored.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_svd(
    layout: i32,
    m: usize,
    n: usize,
    a: *const f64,
    lda: usize,
    values: *mut f64,
    v: *mut f64,
    ldv: usize,
    params: *const cata_gram_params,
) -> cata_status {
    boundary(|| {
        let (layout, most) = (Layout::new(layout)?, m.min(n));
        // SAFETY: clause `memory` (`values`, `most` elements; `v`, n x `most`), clause `structs`
        // (`params`), clause `passed on` (`rows_of`).
        let (a, values, v, params) = unsafe {
            let a = rows_of("a", layout, m, n, a, lda)?;
            let values = optional_slice_mut("values", values, most)?;
            let v = optional_matrix_mut("v", layout, n, most, v, ldv)?;
            (a, values, v, read_or_zeros("params", params)?)
        };
        if most == 0 {
            return Ok(());
        }
        let gram = of_matrix("a", a, Center::No, &params)?;
        let singular = || SingularValues::from_gram(&gram, params.par());
        let found = params.caller().watch_the_end(singular)?;
        fill_slice(values, &found.values[..most]);
        fill(v, found.v.subcols(0, found.rank().min(most)));
        Ok(())
    })
}

/// Computes the lower triangle of C = X^T W X as unevaluated sums of two doubles, high + low, where
/// X is A (m x n), or A with the mean of its rows subtracted from every row, and W = diag(weights).
///
/// C is the same for any order of the rows. Where `exact` is 1, no entry of A was rounded, and
/// the two parts together are C rounded to about 106 bits; else entries were rounded to about
/// 2^-80 of the largest of their column.
///
/// - `weights`: m finite numbers, negative ones too, read; NULL: all 1.
/// - `centering`: CATA_CENTER_NONE or CATA_CENTER_MEAN (weighted if there are weights).
/// - `high`: n x n, with leading dimension `ldhigh`: the triangle on and below the diagonal is
///   written, with C rounded to double; the rest is neither read nor written. NULL where not
///   wanted; `ldhigh` is then ignored.
/// - `low`: the same, with leading dimension `ldlow`: what that rounding took away.
/// - `exact`: one int32_t, written: 1 or 0; NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_gram_extended(
    layout: i32,
    m: usize,
    n: usize,
    a: *const f64,
    lda: usize,
    weights: *const f64,
    centering: i32,
    high: *mut f64,
    ldhigh: usize,
    low: *mut f64,
    ldlow: usize,
    exact: *mut i32,
    params: *const cata_gram_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        let center = match centering {
            CATA_CENTER_NONE => Center::No,
            CATA_CENTER_MEAN => Center::Mean,
            other => {
                let any = "CATA_CENTER_NONE (0) or CATA_CENTER_MEAN (1)";
                return Err(Failure::argument("centering", any, other));
            }
        };
        // SAFETY: clause `memory` (`a`, m x n; `weights`, `m` elements; `high`, n x n; `low`, n x
        // n; `exact`, one value), clause `structs` (`params`).
        let (a, weights, parts, exact, params) = unsafe {
            let a = matrix("a", layout, m, n, a, lda)?;
            let weights = optional_slice("weights", weights, m);
            let parts = [
                optional_matrix_mut("high", layout, n, n, high, ldhigh)?,
                optional_matrix_mut("low", layout, n, n, low, ldlow)?,
            ];
            let exact = optional_output("exact", exact)?;
            (a, weights?, parts, exact, read_or_zeros("params", params)?)
        };
        // Without columns m may exceed the address space.
        let (a, weights) = if n == 0 { (a.subrows(0, 0), None) } else { (a, weights) };
        let row_options = RowOptions::new().weights(weights).center(center);
        let gram = extended(&mut DenseRows(a), &row_options, &params, |j| ("a", j))?;
        for (part, place) in parts.into_iter().enumerate() {
            let Some(mut place) = place else { continue };
            for j in 0..n {
                (j..n).for_each(|i| place[(i, j)] = gram.entry(i, j)[part]);
            }
        }
        put(exact, gram.is_exact().into());
        Ok(())
    })
}

/// Computes C := the correlation matrix (n x n) of the columns of A (m x n), from their Gram matrix
/// about the mean in extended precision: entries are within [-1, 1], and wrong by little more than
/// one rounding. Both triangles are written; rows and columns of a column without variance are NaN.
///
/// - `c`: C, written, with leading dimension `ldc`; must not overlap A.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_gram_correlation(
    layout: i32,
    m: usize,
    n: usize,
    a: *const f64,
    lda: usize,
    c: *mut f64,
    ldc: usize,
    params: *const cata_gram_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (`c`, n x n), clause `structs` (`params`), clause `passed on`
        // (`rows_of`).
        let (a, c, params) = unsafe {
            let a = rows_of("a", layout, m, n, a, lda)?;
            (a, matrix_mut("c", layout, n, n, c, ldc)?, read_or_zeros("params", params)?)
        };
        let gram = of_matrix("a", a, Center::Mean, &params)?;
        fill(c, correlation(&gram)?.as_ref());
        Ok(())
    })
}

/// Computes how far the columns of Q (m x n) are from orthonormal: Q^T Q - I is formed in extended
/// precision, and no digits are lost to cancellation.
///
/// - `q`: Q, read, with leading dimension `ldq` as A in cata_ata_f64.
/// - `max`: one double, written: the largest entry of Q^T Q - I by size; NULL where not wanted.
/// - `frobenius`: one double, written: the Frobenius norm of Q^T Q - I; NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_gram_orthogonality(
    layout: i32,
    m: usize,
    n: usize,
    q: *const f64,
    ldq: usize,
    max: *mut f64,
    frobenius: *mut f64,
    params: *const cata_gram_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (`max`, one value; `frobenius`, one value), clause `structs`
        // (`params`), clause `passed on` (`rows_of`).
        let (q, max, frobenius, params) = unsafe {
            let q = rows_of("q", layout, m, n, q, ldq)?;
            let max = optional_output("max", max)?;
            (q, max, optional_output("frobenius", frobenius)?, read_or_zeros("params", params)?)
        };
        let found = orthogonality(&of_matrix("q", q, Center::No, &params)?)?;
        put(max, found.max);
        put(frobenius, found.frobenius);
        Ok(())
    })
}

/// Factorizes A = Q R with orthonormal columns of Q, in place, by Cholesky QR with a Gram matrix in
/// extended precision: A (m x n) becomes Q. For columns that are independent;
/// cata_ortho_gram_schmidt takes any.
///
/// Let K be the condition number of A with columns of norm 1. The columns of Q are orthonormal
/// up to rounding for K up to 10^14 where cata_gram_extended is exact, and up to an error of n
/// K^2 2^-79 otherwise.
///
/// - `m`, `n`: any, 0 included; m >= n, or the columns depend on each other.
/// - `a`: A, read and written, with leading dimension `lda` as in cata_ata_f64.
/// - `r`: R, n x n, written, with leading dimension `ldr`: upper triangular with a positive
///   diagonal, zeros below; must not overlap A. NULL where not wanted; `ldr` is then ignored.
///
/// Returns CATA_ERR_ARGUMENT when columns depend on those before them, which the message names.
/// A and R are unspecified after CATA_ERR_PANIC.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_gram_cholesky_qr(
    layout: i32,
    m: usize,
    n: usize,
    a: *mut f64,
    lda: usize,
    r: *mut f64,
    ldr: usize,
    params: *const cata_gram_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (`a`, m x n; `r`, n x n), clause `structs` (`params`).
        let (a, r, params) = unsafe {
            let a = matrix_mut("a", layout, m, n, a, lda)?;
            (a, optional_matrix_mut("r", layout, n, n, r, ldr)?, read_or_zeros("params", params)?)
        };
        if n == 0 {
            return Ok(());
        }
        let gram = of_matrix("a", a.rb(), Center::No, &params)?;
        let qr = params.caller().watch_the_end(|| GramQr::from_gram(&gram, params.par()))?;
        // Not to be stopped between rows of A and rows of Q.
        qr.apply(a, params.par())?;
        fill(r, qr.r().as_ref());
        Ok(())
    })
}

/// Returns the Gram matrix of rows; `name` gives the argument of a column and its number there.
pub(super) fn extended(
    rows: &mut (dyn RowBlocks<f64> + Send),
    row_options: &RowOptions<'_, f64>,
    params: &impl Params,
    name: impl Fn(usize) -> (&'static str, usize),
) -> Result<ExtendedGram, Failure> {
    let found = params.caller().with(|progress| {
        let options = AtaOptions::new().par(params.par()).progress(progress);
        ata_extended(rows, row_options, &options)
    });
    found.map_err(|error| match error {
        Error::NonFinite { what: "rows", index: (i, j) } => {
            let (what, j) = name(j);
            Error::NonFinite { what, index: (i, j) }.into()
        }
        other => other.into(),
    })
}

/// Returns the Gram matrix of a matrix that the caller calls `what`.
pub(super) fn of_matrix(
    what: &'static str,
    a: MatRef<'_, f64>,
    center: Center<'_, f64>,
    params: &impl Params,
) -> Result<ExtendedGram, Failure> {
    extended(&mut DenseRows(a), &RowOptions::new().center(center), params, |j| (what, j))
}

/// Returns a matrix to read; without columns it has no rows, as m may exceed the address space.
///
/// # Safety
/// As [`matrix`].
pub(super) unsafe fn rows_of<'a>(
    what: &'static str,
    layout: Layout,
    m: usize,
    n: usize,
    a: *const f64,
    lda: usize,
) -> Result<MatRef<'a, f64>, Failure> {
    // SAFETY: clause `passed on` (`matrix`).
    let a = unsafe { matrix(what, layout, m, n, a, lda) }?;
    Ok(if n == 0 { a.subrows(0, 0) } else { a })
}
