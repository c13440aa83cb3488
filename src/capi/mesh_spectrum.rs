use std::mem::offset_of;

use super::boundary::boundary;
use super::params::{Versioned, init, read};
use super::pointer::{Layout, check_size, matrix_mut, slice, slice_mut};
use super::spectrum::{Outputs, cata_spectrum_params, eigenpairs};
use super::status::{CATA_ERR_ARGUMENT, Failure, cata_status};
use crate::mesh::{Boundary, LaplacianKind, LaplacianOptions, MassKind, TriMesh, laplacian};
use crate::sparse::Mass;

/// The triangles of the mesh: the cotangent Laplacian.
pub const CATA_LAPLACIAN_COTANGENT: i32 = 0;
/// Those of the intrinsic Delaunay triangulation: no negative weights, for surfaces.
pub const CATA_LAPLACIAN_INTRINSIC_DELAUNAY: i32 = 1;
/// Those of the intrinsic Delaunay triangulation of the tufted cover: for any mesh.
pub const CATA_LAPLACIAN_TUFTED: i32 = 2;

/// A diagonal mass: a third of the area of a face to each vertex.
pub const CATA_MASS_BARYCENTRIC: i32 = 0;
/// A diagonal mass: what is nearest to each vertex.
pub const CATA_MASS_MIXED_VORONOI: i32 = 1;
/// The inner product of linear functions, a full matrix.
pub const CATA_MASS_CONSISTENT: i32 = 2;

/// The normal derivative is zero at the boundary.
pub const CATA_BOUNDARY_NEUMANN: i32 = 0;
/// Functions are zero at the boundary.
pub const CATA_BOUNDARY_DIRICHLET: i32 = 1;

/// What the Laplacian of a mesh is made of. Every field but the first is 0 by default, so that
/// `cata_laplacian_params params = {.struct_size = sizeof params};` does what cata_laplacian_params_init
/// does.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_laplacian_params {
    /// sizeof(cata_laplacian_params) as the caller was compiled with. Later versions add fields at the
    /// end; one that this library does not know must be 0.
    pub struct_size: usize,
    /// CATA_LAPLACIAN_*.
    pub kind: i32,
    /// CATA_MASS_*.
    pub mass: i32,
    /// CATA_BOUNDARY_*.
    pub boundary: i32,
}

impl Versioned for cata_laplacian_params {
    const NAME: &'static str = "cata_laplacian_params";
    const FIRST_SIZE: usize = offset_of!(Self, boundary) + size_of::<i32>();
}

/// Fills a parameter struct with the defaults.
///
/// `params`: one struct, not NULL; `struct_size` bytes are written.
/// `struct_size`: sizeof(cata_laplacian_params).
/// Returns CATA_OK, CATA_ERR_NULL, or CATA_ERR_ARGUMENT for a size that no version has.
///
/// Thread-safe.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_laplacian_params_init(
    params: *mut cata_laplacian_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: the promises are the same.
    unsafe { init(params, struct_size) }
}

/// The k smallest eigenvalues, or those nearest to a shift, of the Laplacian of a triangle mesh,
/// W phi = lambda M phi, and their eigenfunctions.
///
/// - `vertices`: their number n, 0 included.
/// - `positions`: 3 n elements, read: x, y, z of each vertex. May be NULL when n is 0.
/// - `faces`: their number.
/// - `corners`: 3 faces elements, read: three vertices of each face, from 0, counter-clockwise as seen from
///   outside. May be NULL when there are no faces.
/// - `k`: number of pairs, at most the vertices that are in a face and not held at zero.
/// - `eigenvalues`: k elements, written: ascending. May be NULL when k is 0.
/// - `eigenvectors`: n x k, written, column-major: k columns of `ldv` >= max(1, n) elements, the last one
///   of n; orthonormal in the inner product of M, 0 where functions are held at zero and at vertices in no
///   face. May be NULL when n or k is 0.
/// - `residuals`: k elements, written, as those of cata_spectrum; NULL where not wanted.
/// - `masses`: n elements, written: the diagonal of M, 0 at vertices that it has no row for; NULL where not
///   wanted. CATA_MASS_CONSISTENT has none to give.
/// - `laplacian_params`, `spectrum_params`: NULL for the defaults; else read during the call.
///
/// Returns CATA_OK, CATA_ERR_NULL, CATA_ERR_SHAPE, CATA_ERR_ARGUMENT, CATA_ERR_MESH, CATA_ERR_NOT_CONVERGED,
/// CATA_ERR_OUT_OF_MEMORY, CATA_ERR_UNSUPPORTED, CATA_ERR_CANCELLED or CATA_ERR_PANIC; outputs are untouched
/// unless it is CATA_OK.
///
/// The result does not depend on the number of threads, bit for bit.
///
/// Thread-safe: calls may run at the same time as long as no output is shared.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_spectrum(
    vertices: usize,
    positions: *const f64,
    faces: usize,
    corners: *const u32,
    k: usize,
    eigenvalues: *mut f64,
    eigenvectors: *mut f64,
    ldv: usize,
    residuals: *mut f64,
    masses: *mut f64,
    laplacian_params: *const cata_laplacian_params,
    spectrum_params: *const cata_spectrum_params,
) -> cata_status {
    boundary(|| {
        check_size::<f64>("positions", vertices, 3)?;
        check_size::<u32>("corners", faces, 3)?;
        // SAFETY: the caller's promise.
        let (positions, corners, mut outputs, masses) = unsafe {
            (
                slice("positions", positions, 3 * vertices)?,
                slice("corners", corners, 3 * faces)?,
                Outputs {
                    values: slice_mut("eigenvalues", eigenvalues, k)?,
                    vectors: matrix_mut("v", Layout::ColMajor, vertices, k, eigenvectors, ldv)?,
                    residuals: match residuals.is_null() {
                        true => None,
                        false => Some(slice_mut("residuals", residuals, k)?),
                    },
                },
                match masses.is_null() {
                    true => None,
                    false => Some(slice_mut("masses", masses, vertices)?),
                },
            )
        };
        // SAFETY: the caller's promise.
        let mut options = unsafe { laplacian_options(laplacian_params) }?;
        if masses.is_some() && options.mass == MassKind::Consistent {
            let why = "masses: must be NULL with CATA_MASS_CONSISTENT, which is no diagonal";
            return Err(Failure::new(CATA_ERR_ARGUMENT, why));
        }
        let (positions, corners) = (positions.as_chunks().0, corners.as_chunks().0);
        let mesh = TriMesh::new(positions.to_vec(), corners.to_vec())?;
        // SAFETY: the caller's promise.
        let pairs = unsafe {
            eigenpairs(k, spectrum_params, |spectrum| {
                options.par = spectrum.par;
                let operator = laplacian(&mesh, &options)?;
                let pairs =
                    crate::sparse::eigs(operator.stiffness.view(), &operator.mass, spectrum)?;
                Ok((operator, pairs))
            })
        };
        let (operator, pairs) = pairs?;
        let vectors = operator.extend(pairs.vectors.as_ref())?;
        outputs.write(&pairs.values, vectors.as_ref(), &pairs.residuals);
        if let (Some(masses), Mass::Lumped(found)) = (masses, &operator.mass) {
            masses.fill(0.0);
            operator.kept.iter().zip(found).for_each(|(&vertex, mass)| masses[vertex] = *mass);
        }
        Ok(())
    })
}

/// What the caller asks for.
///
/// # Safety
/// `params` is NULL or points to a struct as the header describes it.
pub(super) unsafe fn laplacian_options(
    params: *const cata_laplacian_params,
) -> Result<LaplacianOptions, Failure> {
    let mut options = LaplacianOptions::default();
    if params.is_null() {
        return Ok(options);
    }
    // SAFETY: the caller's promise.
    let params = unsafe { read(params) }?;
    let unknown = |what: &str, value: i32| {
        Failure::new(CATA_ERR_ARGUMENT, format!("params.{what}: {value} is not known"))
    };
    options.kind = match params.kind {
        CATA_LAPLACIAN_COTANGENT => LaplacianKind::Cotangent,
        CATA_LAPLACIAN_INTRINSIC_DELAUNAY => LaplacianKind::IntrinsicDelaunay,
        CATA_LAPLACIAN_TUFTED => LaplacianKind::Tufted,
        other => return Err(unknown("kind", other)),
    };
    options.mass = match params.mass {
        CATA_MASS_BARYCENTRIC => MassKind::Barycentric,
        CATA_MASS_MIXED_VORONOI => MassKind::MixedVoronoi,
        CATA_MASS_CONSISTENT => MassKind::Consistent,
        other => return Err(unknown("mass", other)),
    };
    options.boundary = match params.boundary {
        CATA_BOUNDARY_NEUMANN => Boundary::Neumann,
        CATA_BOUNDARY_DIRICHLET => Boundary::Dirichlet,
        other => return Err(unknown("boundary", other)),
    };
    Ok(options)
}
