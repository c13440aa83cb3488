use std::ffi::{c_char, c_void};

use super::boundary::{boundary, path};
use super::lstsq::{LeastSquaresOutputs, cata_lstsq_params, cata_lstsq_result};
use super::outputs::{fill_slice, tell};
use super::params::{Params, flag, init, params, read_or_zeros};
use super::pca::{ComponentOutputs, cata_pca_params};
use super::pointer::{
    self, Layout, free, hand_over, matrix, matrix_mut, optional_slice, optional_slice_mut, output,
    slice, uplo_from,
};
use super::progress::{self, Caller, cata_progress};
use super::status::{CATA_ERR_ARGUMENT, Failure, cata_status};
use catamaran::io::{Output, Overwrite, RowFile, read_accumulator, write_accumulator};
use catamaran::rows::{Accumulator, DenseRows, ExtendedGram, RowBlocks, RowBounds};
use catamaran::solve::{LeastSquares, PrincipalComponents};
use catamaran::{AtaOptions, Par, Uplo};

/// `sums`: in double, up to rounding.
pub const CATA_SUMS_FLOAT: i32 = 0;
/// `sums`: integers, within bounds that are given: the same bytes for any blocks, order, threads
/// and machines, and rows can be removed.
pub const CATA_SUMS_EXACT: i32 = 1;
/// `sums`: exact, for least squares and the like.
pub const CATA_SUMS_EXTENDED: i32 = 2;

/// The kind of sums of an accumulator, their bounds, and threads.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_accumulator_params {
    /// sizeof(cata_accumulator_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Progress callback of each call that adds or removes rows; NULL: none.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
    /// n elements, read unless CATA_SUMS_FLOAT: a lower bound of the entries of each column.
    pub lower: *const f64,
    /// n elements, read unless CATA_SUMS_FLOAT: an upper bound of the entries of each column.
    pub upper: *const f64,
    /// The most rows that are added, unless CATA_SUMS_FLOAT.
    pub rows: u64,
    /// The largest weight of a row, unless CATA_SUMS_FLOAT; 0: rows have no weights.
    pub largest_weight: f64,
    /// CATA_SUMS_*.
    pub sums: i32,
    /// 1: about the mean of the rows. 0: about 0.
    pub centered: i32,
}

params!(cata_accumulator_params, centered: i32);

/// The sums X^T W X of rows X that come in blocks, with weights W, and results from them at any
/// time. Made by cata_accumulator_new or cata_accumulator_read.
pub struct cata_accumulator {
    sum: Accumulator<f64>,
    par: Par,
    caller: Caller,
    /// Why it must not be used any more.
    broken: Option<String>,
}

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_accumulator_params_init(
    params: *mut cata_accumulator_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Creates an accumulator of no rows of n columns.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_accumulator_new(
    n: usize,
    params: *const cata_accumulator_params,
    accumulator: *mut *mut cata_accumulator,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`accumulator`, one value), clause `structs` (`params`).
        let (params, place) =
            unsafe { (read_or_zeros("params", params)?, output("accumulator", accumulator)?) };
        let centered = flag("params.centered", params.centered)?;
        let bounds = || {
            // SAFETY: clause `memory` (`params.lower`, `n` elements; `params.upper`, `n` elements).
            let (lower, upper) = unsafe {
                (slice("params.lower", params.lower, n)?, slice("params.upper", params.upper, n)?)
            };
            let bounds = RowBounds::new(lower.to_vec(), upper.to_vec(), params.rows)?;
            Ok::<_, Failure>(match params.largest_weight {
                0.0 => bounds,
                largest => bounds.with_weights(largest)?,
            })
        };
        let sum = match params.sums {
            CATA_SUMS_FLOAT => Accumulator::new(n, centered)?,
            CATA_SUMS_EXACT => Accumulator::exact(&bounds()?, centered)?,
            CATA_SUMS_EXTENDED => Accumulator::extended(&bounds()?, centered)?,
            other => return Err(Failure::argument("params.sums", "a CATA_SUMS_* value", other)),
        };
        hand_over(place, cata_accumulator::new(sum, &params));
        Ok(())
    })
}

/// Reads the accumulator of a file of cata_accumulator_write.
///
/// - `params`: threads and progress; the rest comes from the file.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_accumulator_read(
    path: *const c_char,
    params: *const cata_accumulator_params,
    accumulator: *mut *mut cata_accumulator,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`accumulator`, one value), clause `structs` (`params`), clause
        // `texts` (`path`).
        let (path, params, place) = unsafe {
            (
                self::path("path", path)?,
                read_or_zeros("params", params)?,
                output("accumulator", accumulator)?,
            )
        };
        hand_over(place, cata_accumulator::new(read_accumulator(&path)?, &params));
        Ok(())
    })
}

/// Writes an accumulator to a file, to continue elsewhere. A file of that name is replaced after
/// everything has been written, and stays otherwise.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_accumulator_write(
    accumulator: *const cata_accumulator,
    path: *const c_char,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `handles` (`accumulator`), clause `texts` (`path`).
        let (own, path) = unsafe { (known(accumulator)?, self::path("path", path)?) };
        Ok(write_accumulator(Output::create(&path, Overwrite::Replace)?, &own.sum)?)
    })
}

/// Frees an accumulator.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_accumulator_free(accumulator: *mut cata_accumulator) {
    // SAFETY: clause `handles` (`accumulator`).
    unsafe { free(accumulator) };
}

/// Adds the rows of A, m x n.
///
/// After an error within the rows, such as a cancelled call, the accumulator must not be used any
/// more, and its calls fail; a first row or weight that is invalid leaves it unchanged.
///
/// - `weights`: m finite numbers, read; NULL: all 1.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_accumulator_add(
    accumulator: *mut cata_accumulator,
    layout: i32,
    m: usize,
    a: *const f64,
    lda: usize,
    weights: *const f64,
) -> cata_status {
    // SAFETY: clause `passed on` (`change`).
    unsafe { change(accumulator, layout, m, a, lda, weights, false) }
}

/// Removes rows that were added, with the same weights, from sums of integers; the sums then have
/// the bytes of sums without these rows. Otherwise as cata_accumulator_add.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_accumulator_remove(
    accumulator: *mut cata_accumulator,
    layout: i32,
    m: usize,
    a: *const f64,
    lda: usize,
    weights: *const f64,
) -> cata_status {
    // SAFETY: clause `passed on` (`change`).
    unsafe { change(accumulator, layout, m, a, lda, weights, true) }
}

/// Adds the rows of a file, which may be larger than memory: NAME.npy, or NAME.h5:/dataset with
/// CATA_CAP_HDF5. Otherwise as cata_accumulator_add.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_accumulator_add_file(
    accumulator: *mut cata_accumulator,
    path: *const c_char,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `handles` (`accumulator`), clause `texts` (`path`).
        let (own, path) = unsafe { (known_mut(accumulator)?, self::path("path", path)?) };
        own.change(&mut RowFile::open(path)?, None, false)
    })
}

/// Adds the rows of another accumulator of the same kind, which is not changed.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_accumulator_merge(
    accumulator: *mut cata_accumulator,
    other: *const cata_accumulator,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `handles` (`other`); it is copied first, as `accumulator` may be the same.
        let others = unsafe { known(other) }?.sum.try_clone()?;
        // SAFETY: clause `handles` (`accumulator`).
        let own = unsafe { known_mut(accumulator) }?;
        // Checked on a copy, because sums that do not fit would be lost.
        let mut merged = own.sum.try_clone()?;
        merged.merge(others)?;
        own.sum = merged;
        Ok(())
    })
}

/// Gets the number of rows, the sum of their weights, and the mean of each column (n elements; 0
/// unless `centered`). NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_accumulator_rows(
    accumulator: *const cata_accumulator,
    rows: *mut u64,
    weight: *mut f64,
    mean: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`rows`, one value; `weight`, one value; `mean`, `sum.ncols()`
        // elements), clause `handles` (`accumulator`).
        unsafe {
            let sum = &known(accumulator)?.sum;
            let mean = optional_slice_mut("mean", mean, sum.ncols())?;
            tell!(rows: sum.rows(), weight: sum.weight());
            fill_slice(mean, &sum.mean());
        }
        Ok(())
    })
}

/// Computes C := alpha X^T W X, n x n, of the rows; 1 / (rows - 1) makes it a covariance matrix.
///
/// - `uplo`: the part of C that is written; the rest is neither read nor written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_accumulator_gram(
    accumulator: *const cata_accumulator,
    layout: i32,
    uplo: i32,
    alpha: f64,
    c: *mut f64,
    ldc: usize,
) -> cata_status {
    boundary(|| {
        let (layout, uplo) = (Layout::new(layout)?, uplo_from(uplo)?);
        // SAFETY: clause `memory` (`c`, `sum.ncols()` x `sum.ncols()`), clause `handles`
        // (`accumulator`).
        let (sum, mut c) = unsafe {
            let sum = &known(accumulator)?.sum;
            (sum, matrix_mut("c", layout, sum.ncols(), sum.ncols(), c, ldc)?)
        };
        let found = sum.try_clone()?.finish(alpha, Uplo::Lower)?;
        let found = found.as_ref();
        for j in 0..sum.ncols() {
            for i in j..sum.ncols() {
                if uplo != Uplo::Upper {
                    c[(i, j)] = found[(i, j)];
                }
                if uplo != Uplo::Lower {
                    c[(j, i)] = found[(i, j)];
                }
            }
        }
        Ok(())
    })
}

/// Solves least squares, as cata_lstsq, with the first n - k columns of the rows for A and the last
/// k for B. The sums must be CATA_SUMS_EXTENDED, and `centered` with `params.intercept`.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_accumulator_lstsq(
    accumulator: *const cata_accumulator,
    k: usize,
    layout: i32,
    x: *mut f64,
    ldx: usize,
    result: *mut cata_lstsq_result,
    params: *const cata_lstsq_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `handles` (`accumulator`), clause `structs` (`params`), clause `passed on`
        // (`LeastSquaresOutputs::new`).
        let (own, outputs, params) = unsafe {
            let own = known(accumulator)?;
            let n = own.sum.ncols();
            if k == 0 || k > n {
                let any = format!("from 1 to {n} (columns of the rows)");
                return Err(Failure::argument("k", any, k));
            }
            (
                own,
                LeastSquaresOutputs::new(layout, n - k, k, x, ldx, result)?,
                read_or_zeros("params", params)?,
            )
        };
        let par = own.threads(params.threads);
        let options = outputs.options(&params)?.par(par);
        let found = params.caller().reported(|_| {
            let gram = own.extended(par)?;
            Ok(LeastSquares::from_gram(&gram, k, &options)?)
        })?;
        outputs.write(&found, &options, &params)
    })
}

/// Computes principal components of the rows, as cata_pca. The sums must be CATA_SUMS_EXTENDED and
/// `centered`.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_accumulator_pca(
    accumulator: *const cata_accumulator,
    layout: i32,
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
        // SAFETY: clause `handles` (`accumulator`), clause `structs` (`params`), clause `passed on`
        // (`ComponentOutputs::new`).
        let (own, outputs, params) = unsafe {
            let own = known(accumulator)?;
            let n = own.sum.ncols();
            let vectors =
                [explained_variance, explained_variance_ratio, singular_values, mean, scale];
            let outputs =
                ComponentOutputs::new(layout, n, count, components, ldcomponents, vectors)?;
            (own, outputs, read_or_zeros("params", params)?)
        };
        let par = own.threads(params.threads);
        let options = outputs.options(&params)?.par(par);
        let found = params.caller().reported(|_| {
            let gram = own.extended(par)?;
            Ok(PrincipalComponents::from_gram(&gram, &options)?)
        })?;
        outputs.write(&found);
        Ok(())
    })
}

impl cata_accumulator {
    fn new(sum: Accumulator<f64>, params: &cata_accumulator_params) -> Self {
        Self { sum, par: params.par(), caller: params.caller(), broken: None }
    }

    fn change(
        &mut self,
        rows: &mut (dyn RowBlocks<f64> + Send),
        weights: Option<&[f64]>,
        remove: bool,
    ) -> Result<(), Failure> {
        let before = self.sum.rows();
        // Unless the call returns: a panic leaves a part of the rows in the sums.
        self.broken = Some("a panic".to_owned());
        let done = self.caller.with(|progress| {
            let options = AtaOptions::new().par(self.par).progress(progress);
            match remove {
                false => self.sum.add_rows(rows, weights, &options),
                true => self.sum.remove_rows(rows, weights, &options),
            }
        });
        self.broken = done.as_ref().err().and_then(|error| {
            use catamaran::Error::{Argument, Io, NonFinite, Shape};
            let refused =
                matches!(error, Argument { .. } | NonFinite { .. } | Shape { .. } | Io { .. });
            (!refused || self.sum.rows() != before).then(|| error.to_string())
        });
        Ok(done?)
    }

    /// Returns the threads of a call that has parameters of its own: those of the accumulator
    /// for 0.
    fn threads(&self, threads: usize) -> Par {
        if threads == 0 { self.par } else { progress::par(threads) }
    }

    fn extended(&self, par: Par) -> Result<ExtendedGram, Failure> {
        Ok(self.sum.try_clone()?.finish_extended(par)?)
    }

    fn check(&self) -> Result<(), Failure> {
        match &self.broken {
            None => Ok(()),
            Some(why) => {
                let why = format!("accumulator: must not be used after an error: {why}");
                Err(Failure::new(CATA_ERR_ARGUMENT, why))
            }
        }
    }
}

/// Adds or removes rows.
///
/// # Safety
/// The pointers are as cata_accumulator_add describes them.
unsafe fn change(
    accumulator: *mut cata_accumulator,
    layout: i32,
    m: usize,
    a: *const f64,
    lda: usize,
    weights: *const f64,
    remove: bool,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (`a`, m x `own.sum.ncols()`; `weights`, `m` elements), clause
        // `handles` (`accumulator`).
        let (own, a, weights) = unsafe {
            let own = known_mut(accumulator)?;
            let a = matrix("a", layout, m, own.sum.ncols(), a, lda)?;
            let weights = optional_slice("weights", weights, m)?;
            (own, a, weights)
        };
        own.change(&mut DenseRows(a), weights, remove)
    })
}

/// Returns an accumulator that may still be used.
///
/// # Safety
/// NULL or alive.
unsafe fn known<'a>(accumulator: *const cata_accumulator) -> Result<&'a cata_accumulator, Failure> {
    // SAFETY: clause `handles` (`accumulator`).
    let own = unsafe { pointer::known("accumulator", accumulator) }?;
    own.check()?;
    Ok(own)
}

/// Returns an accumulator that may still be used, to be changed.
///
/// # Safety
/// NULL or alive, and no other thread uses it.
unsafe fn known_mut<'a>(
    accumulator: *mut cata_accumulator,
) -> Result<&'a mut cata_accumulator, Failure> {
    // SAFETY: clause `handles` (`accumulator`).
    let own = unsafe { pointer::known_mut("accumulator", accumulator) }?;
    own.check()?;
    Ok(own)
}
