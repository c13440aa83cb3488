//! # Least squares, principal components, singular values
//!
//! Results from a Gram matrix in extended precision, computed in one or two passes over the rows,
//! as accurate as by an orthogonal factorization.
//!
//! ```c
//! double a[] = {1, 0, 1, 1, 1, 2}, b[] = {1, 3, 5}, x[2]; // b = 1 + 2 t
//! cata_lstsq(CATA_ROW_MAJOR, 3, 2, 1, a, 2, b, 1, NULL, x, 1, NULL, NULL);
//! printf("%g %g\n", x[0], x[1]); // 1 2
//! ```

use std::ffi::c_void;

use faer::{MatMut, MatRef};

use super::boundary::boundary;
use super::gram::extended;
use super::outputs::{fill, fill_slice};
use super::params::{Params, flag, init, or_default, params, read_or_zeros, results, versioned};
use super::pointer::{
    Layout, check_leading, matrix, optional_matrix_mut, optional_output, optional_slice,
    optional_slice_mut, put,
};
use super::progress::cata_progress;
use super::status::{Failure, cata_status};
use catamaran::base::zeros;
use catamaran::rows::{Center, DenseRows, RowOptions};
use catamaran::solve::{
    JoinedRows, LeastSquares, LeastSquaresOptions, RankDeficiency, check_weights,
};

/// How a least-squares problem is solved.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_lstsq_params {
    /// sizeof(cata_lstsq_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Progress callback; NULL: none. Fractions are those of the passes that form the Gram matrix;
    /// the work after them tells 1 again.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
    /// Multiple of |X|^2 that is added to the minimized sum; finite, at least 0. The intercept is
    /// not a part of X.
    pub ridge: f64,
    /// 1: a constant is fitted for each target too. 0: none.
    pub intercept: i32,
    /// 1: columns of A that depend on others are an error, CATA_ERR_ARGUMENT, whose message names
    /// them. 0: the solution of least norm is returned.
    pub refuse_dependent: i32,
    /// Confidence of `result.lower` and `result.upper`, below 1; 0: 0.95.
    pub confidence: f64,
}

params!(cata_lstsq_params, refuse_dependent: i32);

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_lstsq_params_init(
    params: *mut cata_lstsq_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Results of least squares beside X. The caller sets `struct_size` and the pointers, each to an
/// array of its own or to NULL where it is not wanted; the call writes the arrays and the fields
/// after them. `cata_lstsq_result result = {.struct_size = sizeof result};` requests those fields
/// alone.
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
    /// n x k, written, with the layout and the leading dimension of X: the standard error of
    /// each coefficient; NaN without degrees of freedom.
    pub standard_errors: *mut f64,
    /// k elements, written: the standard error of each constant; untouched without
    /// `params.intercept`.
    pub intercept_errors: *mut f64,
    /// n elements, of which the first n - `rank` are written: the columns of A, from 0, that
    /// depend on others.
    pub dependent: *mut usize,
    /// Written: columns of A that do not depend on others, as far as the precision can tell.
    pub rank: usize,
    /// Written: rows of a weight other than 0, less the rank, and less one more with an
    /// intercept; at least 0.
    pub degrees_of_freedom: usize,
    /// Written: an estimate of the condition number of A, about the mean with an intercept, and
    /// with sqrt(ridge) I below it.
    pub condition: f64,
    /// Written: decimal digits of X, relative to its largest entry when columns of A have norm
    /// 1, that agree with the exact solution; from 0 to 15.95.
    pub digits: f64,
    /// n x k, written, with the layout and the leading dimension of X: each coefficient over its
    /// standard error.
    pub t_statistics: *mut f64,
    /// n x k, written, with the layout and the leading dimension of X: the probability of a t
    /// statistic as far from 0, or farther, were the coefficient 0.
    pub p_values: *mut f64,
    /// n x k, written, with the layout and the leading dimension of X: the lower end of the
    /// confidence interval of each coefficient; see `params.confidence`.
    pub lower: *mut f64,
    /// n x k, written, with the layout and the leading dimension of X: the upper end.
    pub upper: *mut f64,
    /// k elements, written: the p value of each constant; untouched without `params.intercept`.
    pub intercept_p_values: *mut f64,
    /// k elements, written: the lower end of the confidence interval of each constant; untouched
    /// without `params.intercept`.
    pub intercept_lower: *mut f64,
    /// k elements, written: the upper end; untouched without `params.intercept`.
    pub intercept_upper: *mut f64,
    /// k elements, written: the standard deviation of the residuals of each target; NaN without
    /// degrees of freedom.
    pub residual_deviations: *mut f64,
    /// k elements, written: `r_squared`, adjusted for the number of coefficients.
    pub adjusted_r_squared: *mut f64,
    /// k elements, written: the F statistic of each target, that all coefficients but the
    /// constant are 0, with `rank` and `degrees_of_freedom` degrees of freedom; NaN with a ridge.
    pub f_statistics: *mut f64,
    /// k elements, written: the p value of each F statistic.
    pub f_p_values: *mut f64,
    /// k symmetric matrices (n + 1) x (n + 1), one after another without gaps, written: the
    /// covariance of the coefficients of each target, in row and column 0 of the constant; zeros
    /// there without `params.intercept`.
    pub covariances: *mut f64,
    /// One element, written: rows of a weight other than 0.
    pub observations: *mut usize,
}

versioned!(cata_lstsq_result, digits: f64);

/// Computes the X (n x k) that minimizes |W^(1/2) (A X - B)|^2 + ridge |X|^2, for A m x n, B m x k
/// and W = diag(weights), from the Gram matrix of [A B] in extended precision.
///
/// Where cata_gram_extended is exact, X is at least as accurate as by an orthogonal
/// factorization of A in double, up to condition numbers of about 2^48 of A with columns of norm
/// 1; see `result.digits`. Rows are read twice, in blocks; neither A nor B is copied as a whole.
///
/// - `m`, `n`: any, 0 included. `k`: number of targets, at least 1.
/// - `b`: B, m x k, read, with leading dimension `ldb`.
/// - `weights`: m finite numbers, at least 0, read; NULL: all 1.
/// - `x`: X, n x k, written, with leading dimension `ldx`; NULL where not wanted, `ldx` is then
///   used for `result.standard_errors` only.
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
        // SAFETY: clause `passed on` (`LeastSquaresCall::new`).
        let call = unsafe {
            LeastSquaresCall::new(layout, m, n, k, a, lda, b, ldb, weights, x, ldx, result, params)
        }?;
        check_weights(call.weights)?;
        let center = if call.options.intercept { Center::Mean } else { Center::No };
        let row_options = RowOptions::new().weights(call.weights).center(center);
        let (mut a, mut b) = (DenseRows(call.a), DenseRows(call.b));
        let rows = &mut JoinedRows::new(&mut a, &mut b)?;
        let name = |j: usize| if j < n { ("a", j) } else { ("b", j - n) };
        let gram = extended(rows, &row_options, &call.params, name)?;
        let solution = || LeastSquares::from_gram(&gram, k, &call.options);
        let found = call.params.caller().watch_the_end(solution)?;
        call.finish(&found)
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
    /// Creates a call of least squares from its arguments.
    ///
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
            return Err(Failure::argument("k", "at least 1", k));
        }
        // SAFETY: clause `memory` (`a`, m x n; `b`, m x k; `weights`, `m` elements), clause
        // `structs` (`params`), clause `passed on` (`LeastSquaresOutputs::new`).
        unsafe {
            let a = matrix("a", layout, m, n, a, lda)?;
            let b = matrix("b", layout, m, k, b, ldb)?;
            let weights = optional_slice("weights", weights, m)?;
            let outputs = LeastSquaresOutputs::new(layout, n, k, x, ldx, result)?;
            let params = read_or_zeros("params", params)?;
            let options = outputs.options(&params)?;
            Ok(Self { a, b, weights, options, params, outputs })
        }
    }

    /// Writes the solution.
    pub fn finish(self, found: &LeastSquares) -> Result<(), Failure> {
        self.outputs.write(found, &self.options, &self.params)
    }
}

/// The places for a least-squares solution.
pub(super) struct LeastSquaresOutputs<'a> {
    x: Option<MatMut<'a, f64>>,
    standard_errors: Option<MatMut<'a, f64>>,
    t: Option<MatMut<'a, f64>>,
    p: Option<MatMut<'a, f64>>,
    /// Lower and upper ends.
    ends: [Option<MatMut<'a, f64>>; 2],
    residual_norms: Option<&'a mut [f64]>,
    r_squared: Option<&'a mut [f64]>,
    intercepts: Option<&'a mut [f64]>,
    intercept_errors: Option<&'a mut [f64]>,
    intercept_p: Option<&'a mut [f64]>,
    intercept_ends: [Option<&'a mut [f64]>; 2],
    deviations: Option<&'a mut [f64]>,
    adjusted_r_squared: Option<&'a mut [f64]>,
    f: Option<&'a mut [f64]>,
    f_p: Option<&'a mut [f64]>,
    covariances: Option<&'a mut [f64]>,
    dependent: Option<&'a mut [usize]>,
    observations: Option<&'a mut usize>,
    /// NULL, or a struct that has the fields of its first version.
    result: *mut cata_lstsq_result,
}

impl LeastSquaresOutputs<'_> {
    /// Creates the outputs of least squares from pointers.
    ///
    /// # Safety
    /// `x` and `result` are as cata_lstsq describes them, and live as long as this.
    pub unsafe fn new(
        layout: Layout,
        n: usize,
        k: usize,
        x: *mut f64,
        ldx: usize,
        result: *mut cata_lstsq_result,
    ) -> Result<Self, Failure> {
        // SAFETY: clause `memory` (`x`, n x k; the arrays of `result`, as cata_lstsq_result
        // describes them), clause `structs` (`result`).
        unsafe {
            let arrays = results("result", result)?;
            let matrix = |what, place: *mut f64| {
                if !place.is_null() {
                    check_leading("ldx", what, layout, [n, k], ldx)?;
                }
                optional_matrix_mut(what, layout, n, k, place, ldx)
            };
            let numbers = |what, place| optional_slice_mut(what, place, k);
            // More than that exceed the address space, which is then said.
            let size = (n + 1).saturating_mul(n + 1).saturating_mul(k);
            Ok(Self {
                standard_errors: matrix("result.standard_errors", arrays.standard_errors)?,
                x: matrix("x", x)?,
                t: matrix("result.t_statistics", arrays.t_statistics)?,
                p: matrix("result.p_values", arrays.p_values)?,
                ends: [
                    matrix("result.lower", arrays.lower)?,
                    matrix("result.upper", arrays.upper)?,
                ],
                residual_norms: numbers("result.residual_norms", arrays.residual_norms)?,
                r_squared: numbers("result.r_squared", arrays.r_squared)?,
                intercepts: numbers("result.intercepts", arrays.intercepts)?,
                intercept_errors: numbers("result.intercept_errors", arrays.intercept_errors)?,
                intercept_p: numbers("result.intercept_p_values", arrays.intercept_p_values)?,
                intercept_ends: [
                    numbers("result.intercept_lower", arrays.intercept_lower)?,
                    numbers("result.intercept_upper", arrays.intercept_upper)?,
                ],
                deviations: numbers("result.residual_deviations", arrays.residual_deviations)?,
                adjusted_r_squared: numbers(
                    "result.adjusted_r_squared",
                    arrays.adjusted_r_squared,
                )?,
                f: numbers("result.f_statistics", arrays.f_statistics)?,
                f_p: numbers("result.f_p_values", arrays.f_p_values)?,
                covariances: optional_slice_mut("result.covariances", arrays.covariances, size)?,
                dependent: optional_slice_mut("result.dependent", arrays.dependent, n)?,
                observations: optional_output("result.observations", arrays.observations)?,
                result,
            })
        }
    }

    /// Returns the options for these parameters.
    pub fn options(&self, params: &cata_lstsq_params) -> Result<LeastSquaresOptions, Failure> {
        let deficiency = match flag("params.refuse_dependent", params.refuse_dependent)? {
            true => RankDeficiency::Refuse,
            false => RankDeficiency::MinimumNorm,
        };
        Ok(LeastSquaresOptions::new()
            .ridge(params.ridge)
            .intercept(flag("params.intercept", params.intercept)?)
            .rank_deficiency(deficiency)
            .standard_errors(self.need_errors())
            .par(params.par()))
    }

    /// Returns whether a result is wanted that takes standard errors.
    fn need_errors(&self) -> bool {
        let matrices = [&self.standard_errors, &self.t, &self.p];
        let numbers = [&self.intercept_errors, &self.intercept_p, &self.covariances];
        matrices.into_iter().any(Option::is_some)
            || numbers.into_iter().any(Option::is_some)
            || self.need_ends()
    }

    /// Returns whether a confidence interval is wanted.
    fn need_ends(&self) -> bool {
        let of_intercept = self.intercept_ends.iter().any(Option::is_some);
        of_intercept || self.ends.iter().any(Option::is_some)
    }

    /// Writes the solution and the results that are wanted, when all of them are computed: an error
    /// leaves all outputs as they were.
    pub fn write(
        self,
        found: &LeastSquares,
        options: &LeastSquaresOptions,
        params: &cata_lstsq_params,
    ) -> Result<(), Failure> {
        /// What a confidence of 0 stands for.
        const CONFIDENCE: f64 = 0.95;
        let t = self.t.is_some().then(|| found.t_statistics()).transpose()?;
        let p = self.p.is_some().then(|| found.p_values()).transpose()?;
        let confidence = or_default(params.confidence, CONFIDENCE);
        let ends = self.need_ends().then(|| -> Result<_, Failure> {
            let of_intercept = found.intercept_intervals(confidence)?;
            Ok((found.confidence_intervals(confidence)?, of_intercept))
        });
        let ends = ends.transpose()?;
        let covariances = self.covariances.is_some().then(|| covariances(found)).transpose()?;

        fill(self.x, found.coefficients.as_ref());
        fill(self.standard_errors, found.standard_errors.as_ref());
        for (place, numbers) in [(self.t, t), (self.p, p)] {
            if let Some(numbers) = numbers {
                fill(place, numbers.as_ref());
            }
        }
        if options.intercept {
            fill_slice(self.intercept_errors, &found.intercept_errors);
            fill_slice(self.intercept_p, &found.intercept_p_values());
        }
        if let Some((ends, of_intercept)) = ends {
            self.ends.into_iter().zip(ends).for_each(|(place, ends)| fill(place, ends.as_ref()));
            for (which, place) in self.intercept_ends.into_iter().enumerate() {
                let ends: Vec<f64> = of_intercept.iter().map(|ends| ends[which]).collect();
                fill_slice(place.filter(|_| options.intercept), &ends);
            }
        }
        fill_slice(self.residual_norms, &found.residual_norms);
        fill_slice(self.r_squared, &found.r_squared);
        fill_slice(self.intercepts, &found.intercepts);
        fill_slice(self.deviations, &found.residual_deviations());
        fill_slice(self.adjusted_r_squared, &found.adjusted_r_squared());
        fill_slice(self.f, &found.f_statistics);
        fill_slice(self.f_p, &found.f_p_values());
        fill_slice(self.covariances, covariances.as_deref().unwrap_or_default());
        if let Some(dependent) = self.dependent {
            dependent[..found.dependent.len()].copy_from_slice(&found.dependent);
        }
        put(self.observations, found.observations as usize);
        let result = self.result;
        if result.is_null() {
            return Ok(());
        }
        // SAFETY: clause `structs` (`result`): `results` has checked the alignment and the size of
        // the first version, whose fields these are, and `regions` keeps the struct apart from the
        // arrays.
        unsafe {
            (&raw mut (*result).rank).write(found.rank);
            (&raw mut (*result).degrees_of_freedom).write(found.degrees_of_freedom as usize);
            (&raw mut (*result).condition).write(found.condition);
            (&raw mut (*result).digits).write(found.digits);
        }
        Ok(())
    }
}

/// Returns the covariances of all targets, with the constant first, or zeros in its place.
fn covariances(found: &LeastSquares) -> Result<Vec<f64>, Failure> {
    let (n, k) = found.coefficients.shape();
    let size = n + 1;
    let mut all = zeros((size * size).saturating_mul(k))?;
    for q in 0..k {
        let covariance = found.covariance(q)?;
        let first = size - covariance.nrows();
        let target = &mut all[q * size * size..][..size * size];
        for j in first..size {
            for i in first..size {
                target[j * size + i] = covariance[(i - first, j - first)];
            }
        }
    }
    Ok(all)
}
