use std::ffi::c_void;

use super::boundary::boundary;
use super::eigs::mass;
use super::outputs::fill;
use super::params::{Params, init, or_default, params, with_params};
use super::pointer::{Layout, matrix_mut, optional_matrix_mut, optional_slice_mut, output};
use super::progress::cata_progress;
use super::status::{Failure, cata_status};
use catamaran::ortho::{
    GramSchmidtOptions, TriangularFactor, cholesky_qr_of, gram_schmidt_in_place,
    rank_revealing_in_place,
};

/// `method`: orthogonal to rounding; threshold 1e-9.
pub const CATA_ORTHO_REORTHOGONALIZED: i32 = 1;
/// `method`: one projection; threshold 1e-2.
pub const CATA_ORTHO_SINGLE_PASS: i32 = 2;
/// `method`: as many columns as the numerical rank: singular values above the threshold, 1e-9,
/// times the largest one, columns scaled to length 1; orthogonal to rounding.
pub const CATA_ORTHO_RANK_REVEALING: i32 = 3;

/// How columns are made orthonormal.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_ortho_params {
    /// sizeof(cata_ortho_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Progress callback; NULL: none.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
    /// A column is dropped if its part orthogonal to the columns before it is at most this fraction
    /// of its length: 1e-13 to 1; 0: that of `method`.
    pub threshold: f64,
    /// CATA_ORTHO_*; 0: CATA_ORTHO_REORTHOGONALIZED.
    pub method: i32,
}

params!(cata_ortho_params, method: i32);

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ortho_params_init(
    params: *mut cata_ortho_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Runs Gram-Schmidt with rank detection, in place: A (n x c) = Q R with Q^T M Q = I, for a
/// diagonal M. Columns that depend on those before them are dropped.
///
/// - `a`: A, read and written: its first `*rank` columns are Q afterwards, the others
///   unspecified.
/// - `masses`: n elements: the diagonal of M, positive; NULL: all 1.
/// - `r`: min(n, c) x c, written: R in its first `*rank` rows, zeros below; coefficients of
///   every column of A. NULL where not wanted; `ldr` is then ignored.
/// - `kept`: c elements; the first `*rank` are written: the columns that Q is made of,
///   ascending, from 0. NULL where not wanted.
/// - `rank`: one size_t, written.
///
/// A is unspecified after an error.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ortho_gram_schmidt(
    layout: i32,
    n: usize,
    c: usize,
    a: *mut f64,
    lda: usize,
    masses: *const f64,
    r: *mut f64,
    ldr: usize,
    kept: *mut usize,
    rank: *mut usize,
    params: *const cata_ortho_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (`a`, n x c), clause `passed on` (`FactorsOut::new`, `mass`).
        let (a, results, mass) = unsafe {
            let a = matrix_mut("a", layout, n, c, a, lda)?;
            (a, FactorsOut::new(layout, n.min(c), c, r, ldr, kept, rank)?, mass(n, masses)?)
        };
        let work = |options: &GramSchmidtOptions<'_>, method: i32| match method {
            CATA_ORTHO_RANK_REVEALING => Ok(rank_revealing_in_place(a, &mass, options)?),
            _ => Ok(gram_schmidt_in_place(a, &mass, options)?),
        };
        // SAFETY: clause `structs` (`params`).
        let found = unsafe { with_ortho_options(params, work) }?;
        results.write(&found);
        Ok(())
    })
}

/// Factorizes A (n x c) = Q R with Q^T M Q = I, in place, by shifted Cholesky QR: about half the
/// work of cata_ortho_gram_schmidt, for independent columns. Dependent columns are
/// CATA_ERR_ARGUMENT. A is unspecified after an error. cata_gram_cholesky_qr does the same from a
/// Gram matrix in extended precision.
///
/// - `a`, `masses`: as in cata_ortho_gram_schmidt; A becomes Q.
/// - `r`: c x c, written: R, upper triangular with a positive diagonal. NULL where not wanted;
///   `ldr` is then ignored.
/// - `params`: `threads` and `progress` are used.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ortho_cholesky_qr(
    layout: i32,
    n: usize,
    c: usize,
    a: *mut f64,
    lda: usize,
    masses: *const f64,
    r: *mut f64,
    ldr: usize,
    params: *const cata_ortho_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (`a`, n x c; `r`, c x c), clause `passed on` (`mass`).
        let (a, r, mass) = unsafe {
            let a = matrix_mut("a", layout, n, c, a, lda)?;
            let r = optional_matrix_mut("r", layout, c, c, r, ldr)?;
            (a, r, mass(n, masses)?)
        };
        mass.check(n)?;
        let work = |options: &GramSchmidtOptions<'_>, _: i32| {
            Ok(cholesky_qr_of(a, &mass, options.par, options.progress)?)
        };
        // SAFETY: clause `structs` (`params`).
        let found = unsafe { with_ortho_options(params, work) }?;
        fill(r, found.as_ref());
        Ok(())
    })
}

/// The places for R, the columns kept and their number.
pub(super) struct FactorsOut<'a> {
    r: Option<faer::MatMut<'a, f64>>,
    kept: Option<&'a mut [usize]>,
    rank: &'a mut usize,
}

impl<'a> FactorsOut<'a> {
    /// Creates the outputs of a factorization from pointers.
    ///
    /// # Safety
    /// The pointers are as the header describes them, R of so many rows and columns, during
    /// `'a`.
    pub unsafe fn new(
        layout: Layout,
        rows: usize,
        c: usize,
        r: *mut f64,
        ldr: usize,
        kept: *mut usize,
        rank: *mut usize,
    ) -> Result<Self, Failure> {
        // SAFETY: clause `memory` (`r`, `rows` x c; `kept`, `c` elements; `rank`, one value).
        unsafe {
            let r = optional_matrix_mut("r", layout, rows, c, r, ldr)?;
            let kept = optional_slice_mut("kept", kept, c)?;
            Ok(Self { r, kept, rank: output("rank", rank)? })
        }
    }

    /// Writes R, the kept columns and the rank.
    pub fn write(self, TriangularFactor { r, kept }: &TriangularFactor) {
        fill(self.r, r.as_ref());
        if let Some(to) = self.kept {
            to[..kept.len()].copy_from_slice(kept);
        }
        *self.rank = kept.len();
    }
}

/// Returns what `work` returns for the options of the caller, and the method.
///
/// # Safety
/// `params` is NULL or points to a struct as the header describes it.
pub(super) unsafe fn with_ortho_options<X>(
    params: *const cata_ortho_params,
    work: impl FnOnce(&GramSchmidtOptions<'_>, i32) -> Result<X, Failure>,
) -> Result<X, Failure> {
    // SAFETY: clause `structs` (`params`).
    unsafe {
        with_params(params, |params, progress| {
            let method = known_method(params.method, CATA_ORTHO_REORTHOGONALIZED)?;
            let mut options = match method {
                CATA_ORTHO_SINGLE_PASS => GramSchmidtOptions::single_pass(),
                _ => GramSchmidtOptions::reorthogonalized(),
            };
            options.threshold = or_default(params.threshold, options.threshold);
            work(&options.par(params.par()).progress(progress), method)
        })
    }
}

/// Returns a method of the caller, or the default.
pub(super) fn known_method(method: i32, default: i32) -> Result<i32, Failure> {
    match method {
        0 => Ok(default),
        CATA_ORTHO_REORTHOGONALIZED | CATA_ORTHO_SINGLE_PASS | CATA_ORTHO_RANK_REVEALING => {
            Ok(method)
        }
        other => Err(Failure::argument("params.method", "a CATA_ORTHO_* value", other)),
    }
}
