use std::ffi::c_void;

use faer::MatMut;

use super::boundary::boundary;
use super::gram::{of_matrix, rows_of};
use super::outputs::{fill, fill_slice};
use super::params::{Params, flag, init, params, read_or_zeros};
use super::pointer::{Layout, optional_matrix_mut, optional_slice_mut};
use super::progress::cata_progress;
use super::status::{Failure, cata_status};
use catamaran::rows::Center;
use catamaran::solve::{Components, PrincipalComponents, PrincipalComponentsOptions};

/// How principal components are computed.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_pca_params {
    /// sizeof(cata_pca_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Progress callback; NULL: none. Fractions are those of the passes that form the Gram matrix;
    /// the work after them tells 1 again.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
    /// 1: columns are divided by their standard deviations; those without variance are not. 0:
    /// none is.
    pub standardize: i32,
}

params!(cata_pca_params, standardize: i32);

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_pca_params_init(
    params: *mut cata_pca_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Computes the first principal components of the rows of A (m x n), from the Gram matrix of its
/// centred columns in extended precision. Components beyond the rank of the centred columns are
/// zeros, and so are their variances and singular values.
///
/// - `m`: at least 2. `n`: any, 0 included.
/// - `count`: number of components, at most n.
/// - `components`: count x n, written, with leading dimension `ldcomponents`: one row for each
///   component, orthonormal, the most variance first; the first of the largest entries of a row
///   is positive. NULL where not wanted; `ldcomponents` is then ignored.
/// - `explained_variance`: count elements, written: the variance along each component, with the
///   divisor m - 1; NULL where not wanted.
/// - `explained_variance_ratio`: count elements, written: the same, divided by the variance of
///   all columns; NULL where not wanted.
/// - `singular_values`: count elements, written: those of the centred (and standardized) rows;
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
        if m < 2 {
            return Err(Failure::argument("m", "at least 2 rows", m));
        }
        // SAFETY: clause `structs` (`params`), clause `passed on` (`rows_of`,
        // `ComponentOutputs::new`).
        let (a, outputs, params) = unsafe {
            let a = rows_of("a", layout, m, n, a, lda)?;
            let vectors =
                [explained_variance, explained_variance_ratio, singular_values, mean, scale];
            let outputs =
                ComponentOutputs::new(layout, n, count, components, ldcomponents, vectors)?;
            (a, outputs, read_or_zeros("params", params)?)
        };
        let options = outputs.options(&params)?;
        if n == 0 {
            return Ok(());
        }
        let gram = of_matrix("a", a, Center::Mean, &params)?;
        let components = || PrincipalComponents::from_gram(&gram, &options);
        outputs.write(&params.caller().watch_the_end(components)?);
        Ok(())
    })
}

/// The places for principal components.
pub(super) struct ComponentOutputs<'a> {
    count: usize,
    components: Option<MatMut<'a, f64>>,
    /// Variances, their ratios, singular values, means, scales.
    vectors: [Option<&'a mut [f64]>; 5],
}

impl<'a> ComponentOutputs<'a> {
    /// Creates the outputs of principal components from pointers.
    ///
    /// # Safety
    /// The pointers are as cata_pca describes them, and live as long as this.
    pub unsafe fn new(
        layout: Layout,
        n: usize,
        count: usize,
        components: *mut f64,
        ldcomponents: usize,
        [variance, ratio, singular_values, mean, scale]: [*mut f64; 5],
    ) -> Result<Self, Failure> {
        if count > n {
            return Err(Failure::argument("count", format!("at most {n} (columns of a)"), count));
        }
        // SAFETY: clause `memory` (`components`, `count` x n; `explained_variance`, `count`
        // elements; `explained_variance_ratio`, `count` elements; `singular_values`, `count`
        // elements; `mean`, `n` elements; `scale`, `n` elements).
        unsafe {
            let components =
                optional_matrix_mut("components", layout, count, n, components, ldcomponents)?;
            let vectors = [
                optional_slice_mut("explained_variance", variance, count)?,
                optional_slice_mut("explained_variance_ratio", ratio, count)?,
                optional_slice_mut("singular_values", singular_values, count)?,
                optional_slice_mut("mean", mean, n)?,
                optional_slice_mut("scale", scale, n)?,
            ];
            Ok(Self { count, components, vectors })
        }
    }

    /// Returns the options for these parameters.
    pub fn options(&self, params: &cata_pca_params) -> Result<PrincipalComponentsOptions, Failure> {
        Ok(PrincipalComponentsOptions::new()
            .components(Components::Count(self.count))
            .standardize(flag("params.standardize", params.standardize)?)
            .par(params.par()))
    }

    /// Writes the components and the other results that are wanted.
    pub fn write(self, found: &PrincipalComponents) {
        fill(self.components, found.components.as_ref());
        let values = [
            &found.explained_variance,
            &found.explained_variance_ratio,
            &found.singular_values,
            &found.mean,
            &found.scale,
        ];
        self.vectors.into_iter().zip(values).for_each(|(place, values)| fill_slice(place, values));
    }
}
