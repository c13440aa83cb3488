//! # Sparse eigenpairs
//!
//! The smallest eigenvalues of sparse symmetric matrices, or those nearest to a shift, by
//! shift-invert block Lanczos; and orthonormal columns, in the inner product of a diagonal.
//!
//! ```c
//! size_t starts[] = {0, 1, 2}, columns[] = {0, 1};
//! double entries[] = {2, 1}, value, vector[2]; // diag(2, 1)
//! cata_eigs(2, starts, columns, entries, NULL, 1, &value, vector, 2, NULL, NULL);
//! printf("%g\n", value); // 1
//! ```

use std::ffi::c_void;

use faer::{MatMut, MatRef};

use super::boundary::boundary;
use super::outputs::fill_slice;
use super::params::{Params, flag, init, or_default, params, with_params};
use super::pointer::{
    Layout, check_leading, check_size, matrix_mut, optional_slice, optional_slice_mut, output,
    slice_mut, sparse,
};
use super::progress::{cata_progress, reported};
use super::status::{Failure, cata_status};
use catamaran::Error;
use catamaran::sparse::{
    CsMatView, EigenOptions, Eigenpairs, Mass, count_below, eigs, eigs_sliced, eigs_two_level,
};
use catamaran_geometry::mesh::{Boundary, LaplacianKind, LaplacianOptions, MassKind};

/// `laplacian`: of the faces.
pub const CATA_LAPLACIAN_COTANGENT: i32 = 0;
/// `laplacian`: no negative weights.
pub const CATA_LAPLACIAN_INTRINSIC_DELAUNAY: i32 = 1;
/// `laplacian`: the same for any mesh (tufted cover).
pub const CATA_LAPLACIAN_TUFTED: i32 = 2;

/// `mass`: a third of the area of a face to each vertex.
pub const CATA_MASS_BARYCENTRIC: i32 = 0;
/// `mass`: what is nearest to each vertex.
pub const CATA_MASS_MIXED_VORONOI: i32 = 1;
/// `mass`: the inner product of linear functions, a full matrix.
pub const CATA_MASS_CONSISTENT: i32 = 2;

/// `boundary`: the normal derivative is zero there.
pub const CATA_BOUNDARY_NEUMANN: i32 = 0;
/// `boundary`: functions are zero there.
pub const CATA_BOUNDARY_DIRICHLET: i32 = 1;

/// How eigenpairs are computed, and the Laplacian if they are those of a mesh.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_eigs_params {
    /// sizeof(cata_eigs_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Progress callback; NULL: none.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
    /// Restarts after which CATA_ERR_NOT_CONVERGED is returned; 0: 60.
    pub max_restarts: usize,
    /// Seed of the starting vectors.
    pub seed: u64,
    /// Residual that every pair must reach, 1e-14 to 1e-2; 0: 1e-9.
    pub tolerance: f64,
    /// With `has_shift` 1: the eigenvalues nearest to this finite number are computed, which may be
    /// an eigenvalue. Otherwise ignored.
    pub shift: f64,
    /// 1: `shift` is used; 0: the smallest eigenvalues are computed.
    pub has_shift: i32,
    /// 1: counts the eigenvalues by one or two more factorizations, and continues until none is
    /// missing. 0: does not.
    pub verify_count: i32,
    /// For meshes: CATA_LAPLACIAN_*.
    pub laplacian: i32,
    /// For meshes: CATA_MASS_*.
    pub mass: i32,
    /// For meshes: CATA_BOUNDARY_*.
    pub boundary: i32,
}

params!(cata_eigs_params, boundary: i32);

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_eigs_params_init(
    params: *mut cata_eigs_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Computes the k smallest eigenvalues, or those nearest to a shift, of W phi = lambda M phi, and
/// their eigenvectors. W is n x n, sparse, symmetric, and positive semi-definite unless a shift is
/// given; M is a diagonal of positive masses.
///
/// - `row_starts`: n + 1 elements: the entries of row i are those from `row_starts[i]` to
///   `row_starts[i + 1] - 1`, the first being 0.
/// - `columns`, `entries`: `row_starts[n]` elements each: columns ascending within a row, from
///   0, and the entries of W there, both triangles.
/// - `masses`: n elements: the diagonal of M; NULL: all 1.
/// - `k`: number of pairs, at most n.
/// - `eigenvalues`: k elements, written: ascending.
/// - `eigenvectors`: n x k, written, column-major; orthonormal in the inner product of M.
/// - `residuals`: k elements, written: for each pair |W phi - lambda M phi| / max(|W phi|, s |M
///   phi|), n s being the median of W_ii / M_ii; NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_eigs(
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
    params: *const cata_eigs_params,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `passed on` (`pencil`, `Outputs::new`).
        let (stiffness, masses, outputs) = unsafe {
            let (stiffness, masses) = pencil(n, row_starts, columns, entries, masses)?;
            (stiffness, masses, Outputs::new(n, k, eigenvalues, eigenvectors, ldv, residuals)?)
        };
        // SAFETY: clause `structs` (`params`).
        let pairs = unsafe {
            with_eigen_options(k, params, |options, _| Ok(eigs(stiffness, &masses, options)?))
        }?;
        outputs.write(&pairs.values, pairs.vectors.as_ref(), &pairs.residuals);
        Ok(())
    })
}

/// Takes a slice of eigenpairs: `count` of them, as cata_eigs writes them, ascending within the
/// slice and from slice to slice; gone when it returns. It is called by the calling thread, and
/// returns 0 to continue, anything else to end the call with CATA_ERR_CANCELLED.
pub type cata_eigs_slice = Option<
    extern "C" fn(
        count: usize,
        eigenvalues: *const f64,
        eigenvectors: *const f64,
        ldv: usize,
        residuals: *const f64,
        user: *mut c_void,
    ) -> i32,
>;

/// Computes the k smallest eigenpairs as those of cata_eigs, in slices of the spectrum of which one
/// at a time is in memory. Each slice is complete (as with `verify_count`), and ends in a gap
/// between eigenvalues.
///
/// - `memory`: bytes that may be used beside W and M; where all pairs fit there is one slice.
///   Too few for any slice, or for k pairs around a shift, are CATA_ERR_ARGUMENT.
/// - `slice`, `user`: what takes the slices, and what is handed to it.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_eigs_sliced(
    n: usize,
    row_starts: *const usize,
    columns: *const usize,
    entries: *const f64,
    masses: *const f64,
    k: usize,
    memory: usize,
    slice: cata_eigs_slice,
    user: *mut c_void,
    params: *const cata_eigs_params,
) -> cata_status {
    boundary(|| {
        let mut sink = sink(slice, user)?;
        // SAFETY: clause `passed on` (`pencil`).
        let (stiffness, masses) = unsafe { pencil(n, row_starts, columns, entries, masses) }?;
        let work = |options: &EigenOptions<'_>, _: &LaplacianOptions| {
            Ok(eigs_sliced(stiffness, &masses, options, memory, &mut sink)?)
        };
        // SAFETY: clause `structs` (`params`).
        unsafe { with_eigen_options(k, params, work) }
    })
}

/// Computes the k smallest eigenpairs as those of cata_eigs, approximately, from those of a smaller
/// problem, P^T W P and P^T M P, which are smoothed. Eigenvalues are never too small; `residuals`
/// bound how far they are too large, widely. cata_decimation_eigs does this for meshes.
///
/// - `coarse`: columns of P, at least k.
/// - `p_row_starts`, `p_columns`, `p_entries`: P, n x coarse, by rows as W: the vectors of the
///   problem that those of the smaller one stand for.
/// - `params`: `has_shift` and `verify_count` must be 0, and `tolerance` is not used.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_eigs_two_level(
    n: usize,
    row_starts: *const usize,
    columns: *const usize,
    entries: *const f64,
    masses: *const f64,
    coarse: usize,
    p_row_starts: *const usize,
    p_columns: *const usize,
    p_entries: *const f64,
    k: usize,
    eigenvalues: *mut f64,
    eigenvectors: *mut f64,
    ldv: usize,
    residuals: *mut f64,
    params: *const cata_eigs_params,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the CSR arrays), clause `passed on` (`pencil`, `Outputs::new`).
        let ((stiffness, masses), p, outputs) = unsafe {
            (
                pencil(n, row_starts, columns, entries, masses)?,
                sparse(n, coarse, p_row_starts, p_columns, p_entries)
                    .map_err(|failure| failure.of("P"))?,
                Outputs::new(n, k, eigenvalues, eigenvectors, ldv, residuals)?,
            )
        };
        let work = |options: &EigenOptions<'_>, _: &LaplacianOptions| {
            Ok(eigs_two_level(stiffness, &masses, p, options)?)
        };
        // SAFETY: clause `structs` (`params`).
        let pairs = unsafe { with_eigen_options(k, params, work) }?;
        outputs.write(&pairs.values, pairs.vectors.as_ref(), &pairs.residuals);
        Ok(())
    })
}

/// Counts the eigenvalues below `value`, which may not be one, by a factorization: so many k give
/// cata_eigs all of them. In an interval there are as many as the difference of two counts, and
/// these are nearest to its middle as `shift`.
///
/// - `count`: one size_t, written.
/// - `params`: only `progress` is used, before and after the work.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_eigs_count(
    n: usize,
    row_starts: *const usize,
    columns: *const usize,
    entries: *const f64,
    masses: *const f64,
    value: f64,
    count: *mut usize,
    params: *const cata_eigs_params,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`count`, one value), clause `passed on` (`pencil`).
        let (count, (stiffness, masses)) =
            unsafe { (output("count", count)?, pencil(n, row_starts, columns, entries, masses)?) };
        let work = |options: &EigenOptions<'_>, _: &LaplacianOptions| {
            reported(options.progress, || count_below(stiffness, &masses, value))
        };
        // SAFETY: clause `structs` (`params`).
        *count = unsafe { with_eigen_options(0, params, work) }?;
        Ok(())
    })
}

/// Returns W and M of the caller.
///
/// # Safety
/// The pointers are as the header describes them, during `'a`.
unsafe fn pencil<'a>(
    n: usize,
    row_starts: *const usize,
    columns: *const usize,
    entries: *const f64,
    masses: *const f64,
) -> Result<(CsMatView<'a, f64>, Mass), Failure> {
    // SAFETY: clause `memory` (the CSR arrays), clause `passed on` (`mass`).
    unsafe { Ok((sparse(n, n, row_starts, columns, entries)?, mass(n, masses)?)) }
}

/// Returns the masses of the caller, or the identity.
///
/// # Safety
/// `masses` is NULL or has n elements.
pub(super) unsafe fn mass(n: usize, masses: *const f64) -> Result<Mass, Failure> {
    // SAFETY: clause `memory` (`masses`, `n` elements).
    let masses = unsafe { optional_slice("masses", masses, n) }?;
    Ok(masses.map_or_else(|| Mass::identity(n), |masses| Mass::Lumped(masses.to_vec())))
}

/// Returns a sink that passes slices to the caller.
pub(super) fn sink(
    slice: cata_eigs_slice,
    user: *mut c_void,
) -> Result<impl FnMut(Eigenpairs) -> catamaran::Result<()>, Failure> {
    let slice = slice.ok_or_else(|| Failure::null("slice"))?;
    // Clause `callbacks`: on this thread, one call at a time.
    Ok(move |pairs: Eigenpairs| {
        let Eigenpairs { values, vectors, residuals, .. } = pairs;
        let ldv = vectors.col_stride().unsigned_abs().max(1);
        let (values, vectors) = (&values, vectors.as_ptr());
        match slice(values.len(), values.as_ptr(), vectors, ldv, residuals.as_ptr(), user) {
            0 => Ok(()),
            _ => Err(Error::Cancelled),
        }
    })
}

/// The places for eigenpairs.
pub(super) struct Outputs<'a> {
    values: &'a mut [f64],
    vectors: MatMut<'a, f64>,
    residuals: Option<&'a mut [f64]>,
}

impl<'a> Outputs<'a> {
    /// Creates the outputs of eigenpairs from pointers.
    ///
    /// # Safety
    /// The pointers are as the header describes them, during `'a`.
    pub unsafe fn new(
        n: usize,
        k: usize,
        eigenvalues: *mut f64,
        eigenvectors: *mut f64,
        ldv: usize,
        residuals: *mut f64,
    ) -> Result<Self, Failure> {
        check_size::<f64>("eigenvectors", n, k)?;
        check_leading("ldv", "eigenvectors", Layout::ColMajor, [n, k], ldv)?;
        // SAFETY: clause `memory` (`eigenvalues`, `k` elements; `eigenvectors`, n x k; `residuals`,
        // `k` elements).
        unsafe {
            Ok(Self {
                values: slice_mut("eigenvalues", eigenvalues, k)?,
                vectors: matrix_mut("eigenvectors", Layout::ColMajor, n, k, eigenvectors, ldv)?,
                residuals: optional_slice_mut("residuals", residuals, k)?,
            })
        }
    }

    /// Writes the pairs.
    pub fn write(mut self, values: &[f64], vectors: MatRef<'_, f64>, residuals: &[f64]) {
        self.values.copy_from_slice(values);
        self.vectors.copy_from(vectors);
        fill_slice(self.residuals, residuals);
    }
}

/// Returns what `work` returns for the options of the caller.
///
/// # Safety
/// `params` is NULL or points to a struct as the header describes it.
pub(super) unsafe fn with_eigen_options<X>(
    k: usize,
    params: *const cata_eigs_params,
    work: impl FnOnce(&EigenOptions<'_>, &LaplacianOptions) -> Result<X, Failure>,
) -> Result<X, Failure> {
    let default = EigenOptions::default();
    // SAFETY: clause `structs` (`params`).
    unsafe {
        with_params(params, |params, progress| {
            let options = EigenOptions::new()
                .k(k)
                .par(params.par())
                .seed(params.seed)
                .verify_count(flag("params.verify_count", params.verify_count)?)
                .shift(flag("params.has_shift", params.has_shift)?.then_some(params.shift))
                .max_restarts(or_default(params.max_restarts, default.max_restarts))
                .tolerance(or_default(params.tolerance, default.tolerance))
                .progress(progress);
            work(&options, &laplacian_options(params)?)
        })
    }
}

fn laplacian_options(params: &cata_eigs_params) -> Result<LaplacianOptions, Failure> {
    let unknown = |what: &str, value: i32| {
        let any = format!("a CATA_{}_* value", what.to_uppercase());
        Failure::argument(&format!("params.{what}"), any, value)
    };
    Ok(LaplacianOptions::new()
        .kind(match params.laplacian {
            CATA_LAPLACIAN_COTANGENT => LaplacianKind::Cotangent,
            CATA_LAPLACIAN_INTRINSIC_DELAUNAY => LaplacianKind::IntrinsicDelaunay,
            CATA_LAPLACIAN_TUFTED => LaplacianKind::Tufted,
            other => return Err(unknown("laplacian", other)),
        })
        .mass(match params.mass {
            CATA_MASS_BARYCENTRIC => MassKind::Barycentric,
            CATA_MASS_MIXED_VORONOI => MassKind::MixedVoronoi,
            CATA_MASS_CONSISTENT => MassKind::Consistent,
            other => return Err(unknown("mass", other)),
        })
        .boundary(match params.boundary {
            CATA_BOUNDARY_NEUMANN => Boundary::Neumann,
            CATA_BOUNDARY_DIRICHLET => Boundary::Dirichlet,
            other => return Err(unknown("boundary", other)),
        })
        .par(params.par()))
}
