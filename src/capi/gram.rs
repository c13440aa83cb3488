//! # Least squares, principal components, singular values
//!
//! From a Gram matrix in extended precision, which one or two passes over the rows yield: as
//! accurate as an orthogonal factorisation.
//!
//! ```c
//! double a[] = {1, 0, 1, 1, 1, 2}, b[] = {1, 3, 5}, x[2]; // b = 1 + 2 t
//! cata_lstsq(CATA_ROW_MAJOR, 3, 2, 1, a, 2, b, 1, NULL, x, 1, NULL, NULL);
//! printf("%g %g\n", x[0], x[1]); // 1 2
//! ```

use std::ffi::c_void;
use std::mem::{MaybeUninit, offset_of};

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{MatMut, MatRef};

use super::boundary::boundary;
use super::params::{Versioned, flag, init, read};
use super::pointer::{Layout, matrix, matrix_mut, optional_output, slice, slice_mut};
use super::progress::{cata_progress, par, watcher};
use super::rows::{CATA_CENTER_MEAN, CATA_CENTER_NONE};
use super::status::{CATA_ERR_ARGUMENT, Failure, cata_status};
use crate::ata::{Center, DenseRows, ExtendedGram, RowBlocks, RowOptions, ata_extended};
use crate::base::Progress;
use crate::gram::{
    Components, GramQr, JoinedRows, LeastSquares, LeastSquaresOptions, PrincipalComponents,
    PrincipalComponentsOptions, RankDeficiency, SingularValues, check_weights, correlation,
    orthogonality,
};
use crate::{AtaOptions, Error};

/// How a Gram matrix in extended precision is computed.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_gram_params {
    /// sizeof(cata_gram_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Told of the progress of the passes that form the Gram matrix; NULL: nobody. The work after
    /// them cannot be cancelled.
    pub progress: cata_progress,
    /// Handed to `progress`.
    pub progress_user: *mut c_void,
}

impl Versioned for cata_gram_params {
    const NAME: &'static str = "cata_gram_params";
    const FIRST_SIZE: usize = offset_of!(Self, progress_user) + size_of::<*mut c_void>();
}

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_gram_params_init(
    params: *mut cata_gram_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: the promises are the same.
    unsafe { init(params, struct_size) }
}

/// How a least-squares problem is solved.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_lstsq_params {
    /// sizeof(cata_lstsq_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Told of the progress of the passes that form the Gram matrix; NULL: nobody. The work after
    /// them cannot be cancelled.
    pub progress: cata_progress,
    /// Handed to `progress`.
    pub progress_user: *mut c_void,
    /// Multiple of |X|^2 that is added to what is minimised; finite, at least 0. The intercept is
    /// not a part of X.
    pub ridge: f64,
    /// 1: a constant is fitted for each target too. 0: none.
    pub intercept: i32,
    /// 1: columns of A that depend on others are an error, CATA_ERR_ARGUMENT, whose message names
    /// them. 0: of all solutions the one of least norm is returned.
    pub refuse_dependent: i32,
}

impl Versioned for cata_lstsq_params {
    const NAME: &'static str = "cata_lstsq_params";
    const FIRST_SIZE: usize = offset_of!(Self, refuse_dependent) + size_of::<i32>();
}

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_lstsq_params_init(
    params: *mut cata_lstsq_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: the promises are the same.
    unsafe { init(params, struct_size) }
}

/// What is known of a least-squares solution beside X. The caller sets `struct_size` and the
/// pointers, each to an array of its own or to NULL where it is not wanted; the call writes the
/// arrays and the fields after them. `cata_lstsq_result result = {.struct_size = sizeof result};`
/// asks for those fields alone.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_lstsq_result {
    /// sizeof(cata_lstsq_result).
    pub struct_size: usize,
    /// k elements, written: |A x - b| of each target, weighted; 0 where it is below the rounding
    /// of the Gram matrix.
    pub residual_norms: *mut f64,
    /// k elements, written: 1 - |A x - b|^2 / |b|^2 of each target, with b about its mean where
    /// there is an intercept; 1 for a residual of 0.
    pub r_squared: *mut f64,
    /// k elements, written: the constant of each target; zeros without `params.intercept`.
    pub intercepts: *mut f64,
    /// n x k, written, with the layout and the leading dimension of X: the standard error of each
    /// coefficient; NaN without degrees of freedom.
    pub standard_errors: *mut f64,
    /// k elements, written: the standard error of each constant; untouched without
    /// `params.intercept`.
    pub intercept_errors: *mut f64,
    /// n elements, of which the first n - `rank` are written: the columns of A, from 0, that
    /// depend on others.
    pub dependent: *mut usize,
    /// Written: columns of A that do not depend on others, as far as the precision can tell.
    pub rank: usize,
    /// Written: m less the rank, and less one more with an intercept; at least 0.
    pub degrees_of_freedom: usize,
    /// Written: an estimate of the condition number of A, about the mean with an intercept, and
    /// with sqrt(ridge) I below it.
    pub condition: f64,
    /// Written: decimal digits of X, relative to its largest entry when columns of A have norm 1,
    /// that agree with the exact solution; from 0 to 15.95.
    pub digits: f64,
}

impl Versioned for cata_lstsq_result {
    const NAME: &'static str = "cata_lstsq_result";
    const FIRST_SIZE: usize = offset_of!(Self, digits) + size_of::<f64>();
}

/// The X (n x k) that minimises |W^(1/2) (A X - B)|^2 + ridge |X|^2, for A m x n, B m x k and
/// W = diag(weights), from the Gram matrix of [A B] in extended precision.
///
/// Where cata_gram_extended is exact, X is at least as accurate as by an orthogonal factorisation
/// of A in double, up to condition numbers of about 2^48 of A with columns of norm 1; see
/// `result.digits`. Rows are read twice, in blocks; neither A nor B is copied as a whole.
///
/// - `m`, `n`: any, 0 included. `k`: number of targets, at least 1.
/// - `b`: B, m x k, read, with leading dimension `ldb`.
/// - `weights`: m finite numbers, at least 0, read; NULL: all 1.
/// - `x`: X, n x k, written, with leading dimension `ldx`; NULL where not wanted, `ldx` is then
///   looked at for `result.standard_errors` only.
/// - `result`: one struct, read and written: see cata_lstsq_result; NULL where not wanted.
///   Standard errors take a few times as long as X, and no time when they are not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_lstsq(
    layout: i32,
    m: usize,
    n: usize,
    k: usize,
    a: *const f64,
    lda: usize,
    b: *const f64,
    ldb: usize,
    weights: *const f64,
    x: *mut f64,
    ldx: usize,
    result: *mut cata_lstsq_result,
    params: *const cata_lstsq_params,
) -> cata_status {
    boundary(|| {
        // SAFETY: the caller's promise.
        let call = unsafe {
            LeastSquaresCall::new(layout, m, n, k, a, lda, b, ldb, weights, x, ldx, result, params)
        }?;
        check_weights(call.weights)?;
        let center = if call.options.intercept { Center::Mean } else { Center::No };
        let row_options = RowOptions::new().weights(call.weights).center(center);
        let (mut a, mut b) = (DenseRows(call.a), DenseRows(call.b));
        let rows = &mut JoinedRows::new(&mut a, &mut b)?;
        let name = |j: usize| if j < n { ("a", j) } else { ("b", j - n) };
        let gram = extended(rows, &row_options, &call.params.watched(), name)?;
        let found = LeastSquares::from_gram(&gram, k, &call.options)?;
        call.finish(&found);
        Ok(())
    })
}

/// How principal components are computed.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_pca_params {
    /// sizeof(cata_pca_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Told of the progress of the passes that form the Gram matrix; NULL: nobody. The work after
    /// them cannot be cancelled.
    pub progress: cata_progress,
    /// Handed to `progress`.
    pub progress_user: *mut c_void,
    /// 1: columns are divided by their standard deviations; those without variance are not. 0:
    /// none is.
    pub standardize: i32,
}

impl Versioned for cata_pca_params {
    const NAME: &'static str = "cata_pca_params";
    const FIRST_SIZE: usize = offset_of!(Self, standardize) + size_of::<i32>();
}

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_pca_params_init(
    params: *mut cata_pca_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: the promises are the same.
    unsafe { init(params, struct_size) }
}

/// The first principal components of the rows of A (m x n), from the Gram matrix of its centred
/// columns in extended precision. Components beyond the rank of the centred columns are zeros,
/// and so are their variances and singular values.
///
/// - `m`: at least 2. `n`: any, 0 included.
/// - `count`: number of components, at most n.
/// - `components`: count x n, written, with leading dimension `ldcomponents`: one row for each
///   component, orthonormal, the most variance first; the first of the largest entries of a row
///   is positive. NULL where not wanted; `ldcomponents` is then not looked at.
/// - `explained_variance`: count elements, written: the variance along each component, with the
///   divisor m - 1; NULL where not wanted.
/// - `explained_variance_ratio`: count elements, written: the same, divided by the variance of
///   all columns; NULL where not wanted.
/// - `singular_values`: count elements, written: those of the centred (and standardised) rows;
///   NULL where not wanted.
/// - `mean`: n elements, written: the mean of each column; NULL where not wanted.
/// - `scale`: n elements, written: the divisor of each column, its standard deviation or 1; NULL
///   where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_pca(
    layout: i32,
    m: usize,
    n: usize,
    a: *const f64,
    lda: usize,
    count: usize,
    components: *mut f64,
    ldcomponents: usize,
    explained_variance: *mut f64,
    explained_variance_ratio: *mut f64,
    singular_values: *mut f64,
    mean: *mut f64,
    scale: *mut f64,
    params: *const cata_pca_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        at_least_two(m)?;
        if count > n {
            let why = format!("count: must be at most {n} (columns of a), is {count}");
            return Err(Failure::new(CATA_ERR_ARGUMENT, why));
        }
        // SAFETY: the caller's promise.
        let (a, components, vectors, params) = unsafe {
            let a = rows_of("a", layout, m, n, a, lda)?;
            let components =
                wanted_matrix("components", layout, count, n, components, ldcomponents)?;
            let vectors = [
                wanted("explained_variance", explained_variance, count)?,
                wanted("explained_variance_ratio", explained_variance_ratio, count)?,
                wanted("singular_values", singular_values, count)?,
                wanted("mean", mean, n)?,
                wanted("scale", scale, n)?,
            ];
            (a, components, vectors, read_or_zeros(params)?)
        };
        let options = PrincipalComponentsOptions::new()
            .components(Components::Count(count))
            .standardize(flag("params.standardize", params.standardize)?)
            .par(par(params.threads));
        if n == 0 {
            return Ok(());
        }
        let gram = of_matrix("a", a, Center::Mean, &params.watched())?;
        let found = PrincipalComponents::from_gram(&gram, &options)?;
        if let Some(components) = components {
            fill(components, found.components.as_ref());
        }
        let values = [
            &found.explained_variance,
            &found.explained_variance_ratio,
            &found.singular_values,
            &found.mean,
            &found.scale,
        ];
        vectors.into_iter().zip(values).for_each(|(place, values)| fill_slice(place, values));
        Ok(())
    })
}

/// The singular values of A (m x n), and its right singular vectors, from its Gram matrix in
/// extended precision: A = U diag(values) V^T, where column j of U is A v_j over the j-th value.
///
/// With K the condition number of A with columns of norm 1, the relative error of every value,
/// the smallest included, is a few n 2^-53 plus K^2 2^-106 (K^2 2^-80 where cata_gram_extended is
/// not exact).
///
/// - `m`, `n`: any, 0 included. Time and memory suit m >= n.
/// - `values`: min(m, n) elements, written: descending; zeros where columns depend on others as
///   far as the precision can tell. NULL where not wanted.
/// - `v`: V, n x min(m, n), written, with leading dimension `ldv`: an orthonormal column for each
///   value that is not 0, and zeros for the others. NULL where not wanted; `ldv` is then not
///   looked at.
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
        // SAFETY: the caller's promise.
        let (a, values, v, params) = unsafe {
            let a = rows_of("a", layout, m, n, a, lda)?;
            let values = wanted("values", values, most)?;
            let v = wanted_matrix("v", layout, n, most, v, ldv)?;
            (a, values, v, read_or_zeros(params)?)
        };
        if most == 0 {
            return Ok(());
        }
        let gram = of_matrix("a", a, Center::No, &params)?;
        let found = SingularValues::from_gram(&gram, par(params.threads))?;
        fill_slice(values, &found.values[..most]);
        if let Some(v) = v {
            fill(v, found.v.subcols(0, found.rank().min(most)));
        }
        Ok(())
    })
}

/// The lower triangle of C = X^T W X as unevaluated sums of two doubles, high + low, where X is A
/// (m x n), or A with the mean of its rows subtracted from every row, and W = diag(weights).
///
/// C is the same for any order of the rows. Where `exact` is 1, no entry of A was rounded, and
/// the two parts together are C rounded to about 106 bits; else entries were rounded to about
/// 2^-80 of the largest of their column.
///
/// - `weights`: m finite numbers, negative ones too, read; NULL: all 1.
/// - `centering`: CATA_CENTER_NONE or CATA_CENTER_MEAN (weighted if there are weights).
/// - `high`: n x n, with leading dimension `ldhigh`: the triangle on and below the diagonal is
///   written, with C rounded to double; the rest is neither read nor written. NULL where not
///   wanted; `ldhigh` is then not looked at.
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
                let why = format!(
                    "centering: must be CATA_CENTER_NONE (0) or CATA_CENTER_MEAN (1), is {other}"
                );
                return Err(Failure::new(CATA_ERR_ARGUMENT, why));
            }
        };
        // SAFETY: the caller's promise.
        let (a, weights, parts, exact, params) = unsafe {
            let a = matrix("a", layout, m, n, a, lda)?;
            let weights = (!weights.is_null()).then(|| slice("weights", weights, m));
            let parts = [
                wanted_matrix("high", layout, n, n, high, ldhigh)?,
                wanted_matrix("low", layout, n, n, low, ldlow)?,
            ];
            let exact = optional_output("exact", exact)?;
            (a, weights.transpose()?, parts, exact, read_or_zeros(params)?)
        };
        // Without columns m may be beyond counting.
        let (a, weights) = if n == 0 { (a.subrows(0, 0), None) } else { (a, weights) };
        let row_options = RowOptions::new().weights(weights).center(center);
        let gram = extended(&mut DenseRows(a), &row_options, &params, |j| ("a", j))?;
        for (part, place) in parts.into_iter().enumerate() {
            let Some(mut place) = place else { continue };
            for j in 0..n {
                (j..n).for_each(|i| place[(i, j)] = gram.entry(i, j)[part]);
            }
        }
        if let Some(exact) = exact {
            *exact = gram.is_exact().into();
        }
        Ok(())
    })
}

/// C := the correlation matrix (n x n) of the columns of A (m x n), from their Gram matrix about
/// the mean in extended precision: entries are within [-1, 1], and wrong by little more than one
/// rounding. Both triangles are written; rows and columns of a column without variance are NaN.
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
        // SAFETY: the caller's promise.
        let (a, c, params) = unsafe {
            let a = rows_of("a", layout, m, n, a, lda)?;
            (a, matrix_mut("c", layout, n, n, c, ldc)?, read_or_zeros(params)?)
        };
        let gram = of_matrix("a", a, Center::Mean, &params)?;
        fill(c, correlation(&gram)?.as_ref());
        Ok(())
    })
}

/// How far the columns of Q (m x n) are from orthonormal: Q^T Q - I is formed in extended
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
        // SAFETY: the caller's promise.
        let (q, max, frobenius, params) = unsafe {
            let q = rows_of("q", layout, m, n, q, ldq)?;
            let max = optional_output("max", max)?;
            (q, max, optional_output("frobenius", frobenius)?, read_or_zeros(params)?)
        };
        let found = orthogonality(&of_matrix("q", q, Center::No, &params)?)?;
        if let Some(max) = max {
            *max = found.max;
        }
        if let Some(frobenius) = frobenius {
            *frobenius = found.frobenius;
        }
        Ok(())
    })
}

/// A = Q R with orthonormal columns of Q, in place, by Cholesky QR with a Gram matrix in extended
/// precision: A (m x n) becomes Q. For columns that are independent; cata_ortho_gram_schmidt
/// takes any.
///
/// Let K be the condition number of A with columns of norm 1. The columns of Q are orthonormal up
/// to rounding for K up to 10^14 where cata_gram_extended is exact, and up to an error of n K^2
/// 2^-79 otherwise.
///
/// - `m`, `n`: any, 0 included; m >= n, or the columns depend on each other.
/// - `a`: A, read and written, with leading dimension `lda` as in cata_ata_f64.
/// - `r`: R, n x n, written, with leading dimension `ldr`: upper triangular with a positive
///   diagonal, zeros below; must not overlap A. NULL where not wanted; `ldr` is then not looked
///   at.
///
/// Returns CATA_ERR_ARGUMENT when columns depend on those before them, which the message names. A
/// and R are unspecified after CATA_ERR_PANIC.
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
        // SAFETY: the caller's promise.
        let (a, r, params) = unsafe {
            let a = matrix_mut("a", layout, m, n, a, lda)?;
            (a, wanted_matrix("r", layout, n, n, r, ldr)?, read_or_zeros(params)?)
        };
        if n == 0 {
            return Ok(());
        }
        let par = par(params.threads);
        let qr = GramQr::from_gram(&of_matrix("a", a.rb(), Center::No, &params)?, par)?;
        qr.apply(a, par)?;
        if let Some(r) = r {
            fill(r, qr.r().as_ref());
        }
        Ok(())
    })
}

/// The arguments of a call for least squares, checked.
pub(super) struct LeastSquaresCall<'a> {
    pub a: MatRef<'a, f64>,
    pub b: MatRef<'a, f64>,
    pub weights: Option<&'a [f64]>,
    pub options: LeastSquaresOptions,
    pub params: cata_lstsq_params,
    outputs: LeastSquaresOutputs<'a>,
}

impl LeastSquaresCall<'_> {
    /// # Safety
    /// The pointers are as cata_lstsq describes them, and live as long as this.
    pub unsafe fn new(
        layout: i32,
        m: usize,
        n: usize,
        k: usize,
        a: *const f64,
        lda: usize,
        b: *const f64,
        ldb: usize,
        weights: *const f64,
        x: *mut f64,
        ldx: usize,
        result: *mut cata_lstsq_result,
        params: *const cata_lstsq_params,
    ) -> Result<Self, Failure> {
        let layout = Layout::new(layout)?;
        if k == 0 {
            return Err(Failure::new(CATA_ERR_ARGUMENT, "k: must be at least 1, is 0"));
        }
        // SAFETY: the caller's promise.
        unsafe {
            let a = matrix("a", layout, m, n, a, lda)?;
            let b = matrix("b", layout, m, k, b, ldb)?;
            let weights = (!weights.is_null()).then(|| slice("weights", weights, m)).transpose()?;
            let outputs = LeastSquaresOutputs::new(layout, n, k, x, ldx, result)?;
            let params = read_or_zeros(params)?;
            let options = outputs.options(&params)?;
            Ok(Self { a, b, weights, options, params, outputs })
        }
    }

    /// Writes the solution.
    pub fn finish(self, found: &LeastSquares) {
        self.outputs.write(found, self.options.intercept);
    }
}

/// Where a least-squares solution goes.
struct LeastSquaresOutputs<'a> {
    x: Option<MatMut<'a, f64>>,
    residual_norms: Option<&'a mut [f64]>,
    r_squared: Option<&'a mut [f64]>,
    intercepts: Option<&'a mut [f64]>,
    standard_errors: Option<MatMut<'a, f64>>,
    intercept_errors: Option<&'a mut [f64]>,
    dependent: Option<&'a mut [usize]>,
    /// NULL, or a struct that has the fields of its first version.
    result: *mut cata_lstsq_result,
}

impl LeastSquaresOutputs<'_> {
    /// # Safety
    /// `x` and `result` are as cata_lstsq describes them, and live as long as this.
    unsafe fn new(
        layout: Layout,
        n: usize,
        k: usize,
        x: *mut f64,
        ldx: usize,
        result: *mut cata_lstsq_result,
    ) -> Result<Self, Failure> {
        // SAFETY: the caller's promise.
        unsafe {
            let arrays = read_or_zeros(result.cast_const()).map_err(|failure| {
                Failure::new(failure.status, failure.message.replace("params", "result"))
            })?;
            let errors = arrays.standard_errors;
            // A failure of the leading dimension names that of X, which it is.
            let standard_errors = wanted_matrix("x", layout, n, k, errors, ldx)?;
            Ok(Self {
                x: wanted_matrix("x", layout, n, k, x, ldx)?,
                residual_norms: wanted("result.residual_norms", arrays.residual_norms, k)?,
                r_squared: wanted("result.r_squared", arrays.r_squared, k)?,
                intercepts: wanted("result.intercepts", arrays.intercepts, k)?,
                standard_errors,
                intercept_errors: wanted("result.intercept_errors", arrays.intercept_errors, k)?,
                dependent: wanted("result.dependent", arrays.dependent, n)?,
                result,
            })
        }
    }

    fn options(&self, params: &cata_lstsq_params) -> Result<LeastSquaresOptions, Failure> {
        let deficiency = match flag("params.refuse_dependent", params.refuse_dependent)? {
            true => RankDeficiency::Refuse,
            false => RankDeficiency::MinimumNorm,
        };
        Ok(LeastSquaresOptions::new()
            .ridge(params.ridge)
            .intercept(flag("params.intercept", params.intercept)?)
            .rank_deficiency(deficiency)
            .standard_errors(self.standard_errors.is_some() || self.intercept_errors.is_some())
            .par(par(params.threads)))
    }

    fn write(self, found: &LeastSquares, intercept: bool) {
        if let Some(x) = self.x {
            fill(x, found.coefficients.as_ref());
        }
        fill_slice(self.residual_norms, &found.residual_norms);
        fill_slice(self.r_squared, &found.r_squared);
        fill_slice(self.intercepts, &found.intercepts);
        if let Some(errors) = self.standard_errors {
            fill(errors, found.standard_errors.as_ref());
        }
        if intercept {
            fill_slice(self.intercept_errors, &found.intercept_errors);
        }
        if let Some(dependent) = self.dependent {
            dependent[..found.dependent.len()].copy_from_slice(&found.dependent);
        }
        if self.result.is_null() {
            return;
        }
        let result = self.result;
        // SAFETY: `new` has seen to alignment and to the size of the first version, whose fields
        // these are; the caller promises that they can be written.
        unsafe {
            (&raw mut (*result).rank).write(found.rank);
            (&raw mut (*result).degrees_of_freedom).write(found.degrees_of_freedom as usize);
            (&raw mut (*result).condition).write(found.condition);
            (&raw mut (*result).digits).write(found.digits);
        }
    }
}

impl cata_lstsq_params {
    fn watched(&self) -> cata_gram_params {
        let &Self { struct_size, threads, progress, progress_user, .. } = self;
        cata_gram_params { struct_size, threads, progress, progress_user }
    }
}

impl cata_pca_params {
    fn watched(&self) -> cata_gram_params {
        let &Self { struct_size, threads, progress, progress_user, .. } = self;
        cata_gram_params { struct_size, threads, progress, progress_user }
    }
}

/// The Gram matrix of rows; `name` gives the argument that a column is of, and its number there.
fn extended(
    rows: &mut (dyn RowBlocks<f64> + Send),
    row_options: &RowOptions<'_, f64>,
    params: &cata_gram_params,
    name: impl Fn(usize) -> (&'static str, usize),
) -> Result<ExtendedGram, Failure> {
    let watch = watcher(params.progress, params.progress_user);
    let progress = watch.as_ref().map_or(Progress::none(), Progress::from);
    let options = AtaOptions::new().par(par(params.threads)).progress(progress);
    ata_extended(rows, row_options, &options).map_err(|error| match error {
        Error::NonFinite { what: "rows", index: (i, j) } => {
            let (what, j) = name(j);
            Error::NonFinite { what, index: (i, j) }.into()
        }
        other => other.into(),
    })
}

/// The Gram matrix of a matrix that the caller calls `what`.
fn of_matrix(
    what: &'static str,
    a: MatRef<'_, f64>,
    center: Center<'_, f64>,
    params: &cata_gram_params,
) -> Result<ExtendedGram, Failure> {
    extended(&mut DenseRows(a), &RowOptions::new().center(center), params, |j| (what, j))
}

/// A matrix that is read; without columns it has no rows either, as m may be beyond counting.
///
/// # Safety
/// As [`matrix`].
unsafe fn rows_of<'a>(
    what: &str,
    layout: Layout,
    m: usize,
    n: usize,
    a: *const f64,
    lda: usize,
) -> Result<MatRef<'a, f64>, Failure> {
    // SAFETY: passed on to the caller.
    let a = unsafe { matrix(what, layout, m, n, a, lda) }?;
    Ok(if n == 0 { a.subrows(0, 0) } else { a })
}

/// A struct of the caller, or one of zeros for NULL.
///
/// # Safety
/// `params` is NULL or as [`read`] has it.
unsafe fn read_or_zeros<T: Versioned>(params: *const T) -> Result<T, Failure> {
    if params.is_null() {
        // SAFETY: all fields of such a struct may be 0.
        return Ok(unsafe { MaybeUninit::zeroed().assume_init() });
    }
    // SAFETY: passed on to the caller.
    unsafe { read(params) }
}

/// A place for `len` results that the caller may not want.
///
/// # Safety
/// NULL, or as [`slice_mut`].
unsafe fn wanted<'a, T: Copy>(
    what: &str,
    pointer: *mut T,
    len: usize,
) -> Result<Option<&'a mut [T]>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: passed on to the caller.
    unsafe { slice_mut(what, pointer, len) }.map(Some)
}

/// A place for a matrix that the caller may not want.
///
/// # Safety
/// NULL, or as [`matrix_mut`].
unsafe fn wanted_matrix<'a>(
    what: &str,
    layout: Layout,
    rows: usize,
    cols: usize,
    pointer: *mut f64,
    ld: usize,
) -> Result<Option<MatMut<'a, f64>>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: passed on to the caller.
    unsafe { matrix_mut(what, layout, rows, cols, pointer, ld) }.map(Some)
}

/// Writes a matrix into the upper left of another one, and zeros into the rest.
fn fill(mut place: MatMut<'_, f64>, found: MatRef<'_, f64>) {
    place.fill(0.0);
    place.rb_mut().submatrix_mut(0, 0, found.nrows(), found.ncols()).copy_from(found);
}

/// Writes values, and zeros after them.
fn fill_slice(place: Option<&mut [f64]>, found: &[f64]) {
    if let Some(place) = place {
        place[found.len()..].fill(0.0);
        place[..found.len()].copy_from_slice(found);
    }
}

fn at_least_two(m: usize) -> Result<(), Failure> {
    if m >= 2 {
        return Ok(());
    }
    Err(Failure::new(CATA_ERR_ARGUMENT, format!("m: must be at least 2 rows, is {m}")))
}
