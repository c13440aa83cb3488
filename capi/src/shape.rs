use std::ffi::c_void;

use super::boundary::boundary;
use super::outputs::fill_slice;
use super::params::{Params, init, or_default, params, with_params};
use super::pointer::{mesh, optional_output, optional_slice_mut, put, slice, slice_mut};
use super::progress::cata_progress;
use super::status::cata_status;
use catamaran_geometry::spectral::{ShapeOptions, shape_from_spectrum};

/// How a template is deformed.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_shape_params {
    /// sizeof(cata_shape_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Progress callback; NULL: none.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
    /// Steps, at most; 0: 60.
    pub steps: usize,
    /// Mean relative difference of eigenvalues at which it ends, positive; 0: 0.001.
    pub tolerance: f64,
}

params!(cata_shape_params, tolerance: f64);

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_shape_params_init(
    params: *mut cata_shape_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Deforms a triangle mesh, the template, until the first eigenvalues of its Laplacian are those
/// given (Cosmo et al. 2019): with CATA_BOUNDARY_DIRICHLET, or CATA_BOUNDARY_NEUMANN if the
/// template is closed, whose zeros are left out. Many surfaces have the same eigenvalues; it is one
/// near the template, or falls short of the tolerance, and `error` says so.
///
/// - `k`, `eigenvalues`: positive, ascending, in units of 1 / length^2.
/// - `positions`: 3 n_vertices elements, written: the vertices, moved.
/// - `found`: k elements, written: the eigenvalues of the result. NULL where not wanted.
/// - `error`: written: their mean relative difference. NULL where not wanted.
/// - `steps`: written: how many were taken. NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_shape_from_spectrum(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    k: usize,
    eigenvalues: *const f64,
    positions: *mut f64,
    found: *mut f64,
    error: *mut f64,
    steps: *mut usize,
    params: *const cata_shape_params,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face;
        // `eigenvalues`, `k` elements; `positions`, `3 * n_vertices` elements; `found`, `k`
        // elements; `error`, one value; `steps`, one value).
        let (template, wanted, positions, values, error, steps) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                slice("eigenvalues", eigenvalues, k)?,
                slice_mut("positions", positions, 3 * n_vertices)?,
                optional_slice_mut("found", found, k)?,
                optional_output("error", error)?,
                optional_output("steps", steps)?,
            )
        };
        // SAFETY: clause `structs` (`params`).
        let shape = unsafe {
            with_params(params, |params, progress| {
                let options = options(params).progress(progress);
                Ok(shape_from_spectrum(&template, wanted, &options)?)
            })
        }?;
        positions.copy_from_slice(shape.mesh.vertices().as_flattened());
        fill_slice(values, &shape.eigenvalues);
        put(error, shape.error);
        put(steps, shape.steps);
        Ok(())
    })
}

/// Returns the options of the caller.
pub(super) fn options(params: &cata_shape_params) -> ShapeOptions<'static> {
    let default = ShapeOptions::default();
    ShapeOptions::new()
        .par(params.par())
        .steps(or_default(params.steps, default.steps))
        .tolerance(or_default(params.tolerance, default.tolerance))
}
