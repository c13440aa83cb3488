use std::ffi::c_void;
use std::mem::offset_of;

use faer::{MatMut, MatRef};

use super::boundary::boundary;
use super::params::{Versioned, cata_progress, flag, init, par, read, watcher};
use super::pointer::{Layout, check_size, matrix_mut, slice, slice_mut, sparse};
use super::status::{Failure, cata_status};
use crate::base::Progress;
use crate::sparse::{EigenOptions, Mass, eigs};

/// How eigenpairs are computed. Every field but the first is 0 (NULL) by default, so that
/// `cata_spectrum_params params = {.struct_size = sizeof params};` does what cata_spectrum_params_init does.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_spectrum_params {
    /// sizeof(cata_spectrum_params) as the caller was compiled with. Later versions add fields at the
    /// end; one that this library does not know must be 0.
    pub struct_size: usize,
    /// Threads, at most; 0: all cores of the affinity mask of the process. The result is the same,
    /// bit for bit, for every value.
    pub threads: usize,
    /// Restarts after which CATA_ERR_NOT_CONVERGED is returned; 0: 60.
    pub max_restarts: usize,
    /// Seed of the starting vectors.
    pub seed: u64,
    /// Residual that every pair must reach, 1e-14 to 1e-2; 0: 1e-9.
    pub tolerance: f64,
    /// With `has_shift` 1: the eigenvalues nearest to this finite number are wanted. Else not looked at.
    pub shift: f64,
    /// Told of progress; NULL: nobody.
    pub progress: cata_progress,
    /// Handed to `progress` as it is; may be NULL.
    pub progress_user: *mut c_void,
    /// 1: `shift` counts; 0: the smallest eigenvalues are wanted.
    pub has_shift: i32,
    /// 1: counts, by one or two more factorisations, the eigenvalues that are there, and goes on until none is
    /// missing. 0: not asked for.
    pub verify_count: i32,
}

impl Versioned for cata_spectrum_params {
    const NAME: &'static str = "cata_spectrum_params";
    const FIRST_SIZE: usize = offset_of!(Self, verify_count) + size_of::<i32>();
}

/// Fills a parameter struct with the defaults.
///
/// `params`: one struct, not NULL; `struct_size` bytes are written.
/// `struct_size`: sizeof(cata_spectrum_params).
/// Returns CATA_OK, CATA_ERR_NULL, or CATA_ERR_ARGUMENT for a size that no version has.
///
/// Thread-safe.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_spectrum_params_init(
    params: *mut cata_spectrum_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: the promises are the same.
    unsafe { init(params, struct_size) }
}

/// The k smallest eigenvalues, or those nearest to a shift, of W phi = lambda M phi, and their
/// eigenvectors. W is n x n, sparse, symmetric, and positive semi-definite unless a shift is given; M is
/// a diagonal of positive masses.
///
/// - `n`: any, 0 included.
/// - `row_starts`: n + 1 elements, read: the entries of row i are those from `row_starts[i]` to
///   `row_starts[i + 1] - 1`, the first being 0. May be NULL when n is 0.
/// - `columns`, `entries`: `row_starts[n]` elements each, read: columns ascending within a row, from 0,
///   and the entries of W there, both triangles. May be NULL when there are none.
/// - `masses`: n elements, read: the diagonal of M; NULL: all 1.
/// - `k`: number of pairs, at most n.
/// - `eigenvalues`: k elements, written: ascending. May be NULL when k is 0.
/// - `eigenvectors`: n x k, written, column-major: k columns of `ldv` >= max(1, n) elements, the last one
///   of n; orthonormal in the inner product of M. May be NULL when n or k is 0.
/// - `residuals`: k elements, written: for each pair |W phi - lambda M phi| / max(|W phi|, s |M phi|),
///   n s being the median of W_ii / M_ii; NULL where not wanted.
/// - `params`: NULL for the defaults; else read during the call.
///
/// Returns CATA_OK, CATA_ERR_NULL, CATA_ERR_SHAPE, CATA_ERR_ARGUMENT, CATA_ERR_NON_FINITE,
/// CATA_ERR_NOT_CONVERGED, CATA_ERR_OUT_OF_MEMORY, CATA_ERR_UNSUPPORTED, CATA_ERR_CANCELLED or
/// CATA_ERR_PANIC; outputs are untouched unless it is CATA_OK.
///
/// The result does not depend on the number of threads, bit for bit.
///
/// Thread-safe: calls may run at the same time as long as no output is shared.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_spectrum(
    n: usize,
    row_starts: *const usize,
    columns: *const usize,
    entries: *const f64,
    masses: *const f64,
    k: usize,
    eigenvalues: *mut f64,
    eigenvectors: *mut f64,
    ldv: usize,
    residuals: *mut f64,
    params: *const cata_spectrum_params,
) -> cata_status {
    boundary(|| {
        check_size::<f64>("eigenvectors", n, k)?;
        // SAFETY: the caller's promise.
        let (stiffness, masses, mut outputs) = unsafe {
            let stiffness = sparse(n, n, row_starts, columns, entries)?;
            let masses = match masses.is_null() {
                true => Mass::identity(n),
                false => Mass::Lumped(slice("masses", masses, n)?.to_vec()),
            };
            let residuals = match residuals.is_null() {
                true => None,
                false => Some(slice_mut("residuals", residuals, k)?),
            };
            let vectors = matrix_mut("v", Layout::ColMajor, n, k, eigenvectors, ldv)?;
            let outputs =
                Outputs { values: slice_mut("eigenvalues", eigenvalues, k)?, vectors, residuals };
            (stiffness, masses, outputs)
        };
        // SAFETY: the caller's promise.
        let pairs = unsafe { eigenpairs(k, params, |options| eigs(stiffness, &masses, options)) }?;
        outputs.write(&pairs.values, pairs.vectors.as_ref(), &pairs.residuals);
        Ok(())
    })
}

/// Where results go.
pub(super) struct Outputs<'a> {
    pub values: &'a mut [f64],
    pub vectors: MatMut<'a, f64>,
    pub residuals: Option<&'a mut [f64]>,
}

impl Outputs<'_> {
    /// Writes the pairs.
    pub fn write(&mut self, values: &[f64], vectors: MatRef<'_, f64>, residuals: &[f64]) {
        self.values.copy_from_slice(values);
        self.vectors.copy_from(vectors);
        if let Some(to) = &mut self.residuals {
            to.copy_from_slice(residuals);
        }
    }
}

/// What `work` finds with the options of the caller.
///
/// # Safety
/// `params` is NULL or points to a struct as the header describes it.
pub(super) unsafe fn eigenpairs<X>(
    k: usize,
    params: *const cata_spectrum_params,
    work: impl FnOnce(&EigenOptions<'_>) -> crate::base::Result<X>,
) -> Result<X, Failure> {
    let mut options = EigenOptions { k, ..EigenOptions::default() };
    let mut watch = None;
    if !params.is_null() {
        // SAFETY: the caller's promise.
        let params = unsafe { read(params) }?;
        options.par = par(params.threads);
        options.seed = params.seed;
        options.verify_count = flag("params.verify_count", params.verify_count)?;
        options.shift = flag("params.has_shift", params.has_shift)?.then_some(params.shift);
        if params.max_restarts > 0 {
            options.max_restarts = params.max_restarts;
        }
        if params.tolerance != 0.0 {
            options.tolerance = params.tolerance;
        }
        watch = watcher(params.progress, params.progress_user);
    }
    options.progress = watch.as_ref().map_or(Progress::none(), Progress::from);
    Ok(work(&options)?)
}
