use std::ffi::c_void;
use std::mem::offset_of;

use super::boundary::boundary;
use super::params::{Versioned, flag, init, read};
use super::pointer::{Layout, matrix_mut, output, slice, slice_mut};
use super::progress::{cata_progress, par, watcher};
use super::status::cata_status;
use crate::base::Progress;
use crate::ortho::{Factors, GramSchmidtOptions, gram_schmidt_in_place};
use crate::sparse::Mass;

/// How columns are made orthonormal.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_ortho_params {
    /// sizeof(cata_ortho_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Told of progress; NULL: nobody.
    pub progress: cata_progress,
    /// Handed to `progress`.
    pub progress_user: *mut c_void,
    /// A column is dropped when no more of it is left, relative to its length before, after what
    /// the columns before it span was taken away: 1e-13 to 1; 0: 1e-9, or 1e-2 with
    /// `single_pass`.
    pub threshold: f64,
    /// 1: columns are projected once, and are orthogonal as far as that goes. 0: until they are
    /// orthogonal to rounding.
    pub single_pass: i32,
}

impl Versioned for cata_ortho_params {
    const NAME: &'static str = "cata_ortho_params";
    const FIRST_SIZE: usize = offset_of!(Self, single_pass) + size_of::<i32>();
}

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ortho_params_init(
    params: *mut cata_ortho_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: the promises are the same.
    unsafe { init(params, struct_size) }
}

/// Gram-Schmidt with rank detection, in place: A (n x c) = Q R with Q^T M Q = I, for a diagonal
/// M. Columns that depend on those before them are dropped.
///
/// - `n`, `c`: any, 0 included.
/// - `a`: A, read and written, with leading dimension `lda` as in cata_ata_f64: its first `*rank`
///   columns are Q afterwards, the others unspecified.
/// - `masses`: n elements, read: the diagonal of M, positive; NULL: all 1.
/// - `r`: min(n, c) x c with leading dimension `ldr`, written: R in its first `*rank` rows, zeros
///   below; coefficients of every column of A. NULL where not wanted; `ldr` is then not looked
///   at.
/// - `kept`: c elements, written: the first `*rank` are the columns that Q is made of, ascending,
///   from 0; the others are untouched. NULL where not wanted.
/// - `rank`: one size_t, not NULL, written.
///
/// A is unspecified after CATA_ERR_OUT_OF_MEMORY, CATA_ERR_CANCELLED and CATA_ERR_PANIC.
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
        // SAFETY: the caller's promise.
        let (a, r, kept, rank, mass) = unsafe {
            let a = matrix_mut("a", layout, n, c, a, lda)?;
            let r = match r.is_null() {
                true => None,
                false => Some(matrix_mut("r", layout, n.min(c), c, r, ldr)?),
            };
            let kept = match kept.is_null() {
                true => None,
                false => Some(slice_mut("kept", kept, c)?),
            };
            let mass = match masses.is_null() {
                true => Mass::identity(n),
                false => Mass::Lumped(slice("masses", masses, n)?.to_vec()),
            };
            (a, r, kept, output("rank", rank)?, mass)
        };
        let mut options = GramSchmidtOptions::reorthogonalised();
        let mut watch = None;
        if !params.is_null() {
            // SAFETY: the caller's promise.
            let params = unsafe { read(params) }?;
            if flag("params.single_pass", params.single_pass)? {
                options = GramSchmidtOptions::single_pass();
            }
            if params.threshold != 0.0 {
                options.threshold = params.threshold;
            }
            options.par = par(params.threads);
            watch = watcher(params.progress, params.progress_user);
        }
        options.progress = watch.as_ref().map_or(Progress::none(), Progress::from);
        let factors = gram_schmidt_in_place(a, &mass, &options)?;
        let Factors { r: found, kept: columns } = factors;
        if let Some(mut r) = r {
            r.fill(0.0);
            r.subrows_mut(0, columns.len()).copy_from(&found);
        }
        if let Some(kept) = kept {
            kept[..columns.len()].copy_from_slice(&columns);
        }
        *rank = columns.len();
        Ok(())
    })
}
