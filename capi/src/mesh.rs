//! # Meshes
//!
//! Triangle meshes are arrays: `n_vertices`, `vertices` (3 doubles each: x, y, z), `n_faces`,
//! `faces` (3 vertices each, from 0, counter-clockwise as seen from outside). Here:
//! eigenfunctions of their Laplacian.
//!
//! ```c
//! double v[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, values[2], functions[8]; // a tetrahedron
//! uint32_t f[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
//! cata_mesh_eigs(4, v, 4, f, 2, values, functions, 4, NULL, NULL, NULL);
//! printf("%.3f\n", values[1]); // 3.000
//! ```

use std::ffi::c_void;

use super::boundary::boundary;
use super::eigs::{Outputs, cata_eigs_params, cata_eigs_slice, sink, with_eigen_options};
use super::pointer::{self, mesh, optional_slice_mut, output, slice_mut};
use super::status::{CATA_ERR_ARGUMENT, Failure, cata_status};
use catamaran::sparse::{EigenOptions, Eigenpairs, Mass, eigs, eigs_sliced};
use catamaran_geometry::mesh::{
    Boundary, Laplacian, LaplacianOptions, MassKind, TriMesh, free_components, laplacian,
};
use catamaran_geometry::unions::PartSpectra;

/// Counts the eigenvalues of the Laplacian of a triangle mesh that are 0: one for each connected
/// component without a vertex that is held at zero, as all are under CATA_BOUNDARY_NEUMANN. More
/// than 1 are often pieces that belong together, such as those beside a seam of the texture.
///
/// - `count`: written.
/// - `params`: `boundary` is used, the rest is only checked.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_free_components(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    count: *mut usize,
    params: *const cata_eigs_params,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `count`, one
        // value).
        let (mesh, count) =
            unsafe { (mesh(n_vertices, vertices, n_faces, faces)?, output("count", count)?) };
        let work =
            |_: &EigenOptions<'_>, of: &LaplacianOptions| Ok(free_components(&mesh, &of.boundary)?);
        // SAFETY: clause `structs` (`params`).
        *count = unsafe { with_eigen_options(0, params, work) }?;
        Ok(())
    })
}

/// Computes the k smallest eigenvalues, or those nearest to a shift, of the Laplacian of a triangle
/// mesh, W phi = lambda M phi, and their eigenfunctions.
///
/// - `k`: number of pairs, at most the vertices that are in a face and not held at zero.
/// - `eigenvalues`: k elements, written: ascending, in units of 1 / length^2; the first ones are 0,
///   as many as cata_mesh_free_components counts.
/// - `eigenvectors`: n_vertices x k, written, column-major; orthonormal in the inner product of
///   M, 0 where functions are held at zero and at vertices in no face.
/// - `residuals`: k elements, written, as those of cata_eigs; NULL where not wanted.
/// - `masses`: n_vertices elements, written: the diagonal of M, 0 at vertices that it has no row
///   for; NULL where not wanted. CATA_MASS_CONSISTENT has none to give.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_eigs(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    k: usize,
    eigenvalues: *mut f64,
    eigenvectors: *mut f64,
    ldv: usize,
    residuals: *mut f64,
    masses: *mut f64,
    params: *const cata_eigs_params,
) -> cata_status {
    boundary(|| {
        let find = |operator: &Laplacian, _: &LaplacianOptions, options: &EigenOptions<'_>| {
            Ok(eigs(operator.stiffness.view(), &operator.mass, options)?)
        };
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face), clause
        // `passed on` (`write_eigs`).
        unsafe {
            let mesh = mesh(n_vertices, vertices, n_faces, faces)?;
            write_eigs(&mesh, k, eigenvalues, eigenvectors, ldv, residuals, masses, params, find)
        }
    })
}

/// Computes the k smallest eigenpairs of the Laplacian of a triangle mesh, as those of
/// cata_mesh_eigs, in slices: `memory`, `slice` and `user` are those of cata_eigs_sliced.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_eigs_sliced(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    k: usize,
    memory: usize,
    slice: cata_eigs_slice,
    user: *mut c_void,
    params: *const cata_eigs_params,
) -> cata_status {
    boundary(|| {
        let mut sink = sink(slice, user)?;
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face).
        let mesh = unsafe { mesh(n_vertices, vertices, n_faces, faces) }?;
        let work = |options: &EigenOptions<'_>, of: &LaplacianOptions| {
            let operator = laplacian(&mesh, of)?;
            let (stiffness, mass) = (operator.stiffness.view(), &operator.mass);
            eigs_sliced(stiffness, mass, options, memory, |mut pairs| {
                pairs.vectors = operator.extend(pairs.vectors.as_ref())?;
                sink(pairs)
            })?;
            Ok(())
        };
        // SAFETY: clause `structs` (`params`).
        unsafe { with_eigen_options(k, params, work) }
    })
}

/// Computes the k smallest eigenvalues of the Laplacian of a part of a triangle mesh, which has the
/// faces whose three vertices are in the mask.
///
/// Under CATA_BOUNDARY_DIRICHLET functions are zero where the part ends and at the boundary of
/// the mesh: of two parts of which one lies in the other, the inner one then has no smaller
/// eigenvalue anywhere in the sequence. Under CATA_BOUNDARY_NEUMANN the part is a mesh of its
/// own.
///
/// - `mask`: n_vertices elements: 1 for a vertex of the part, 0 for any other.
/// - `k`: number of eigenvalues, at most the vertices of the part that are not held at zero.
/// - `eigenvalues`: k elements, written: ascending, in units of 1 / length^2.
/// - `params`: the Laplacian, `threads` and `progress` are used, the rest is only checked.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_part_eigenvalues(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    mask: *const u8,
    k: usize,
    eigenvalues: *mut f64,
    params: *const cata_eigs_params,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `mask`,
        // `n_vertices` elements; `eigenvalues`, `k` elements).
        let (mesh, mask, eigenvalues) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                pointer::mask("mask", mask, n_vertices)?,
                slice_mut("eigenvalues", eigenvalues, k)?,
            )
        };
        let work = |options: &EigenOptions<'_>, of: &LaplacianOptions| {
            let parts = PartSpectra::new(&mesh, of)?.progress(options.progress);
            Ok(match of.boundary {
                Boundary::Dirichlet => parts.dirichlet(&mask, k)?,
                _ => parts.neumann(&mask, k)?,
            })
        };
        // SAFETY: clause `structs` (`params`).
        eigenvalues.copy_from_slice(&unsafe { with_eigen_options(k, params, work) }?);
        Ok(())
    })
}

/// Writes the pairs that `find` returns for the Laplacian of a mesh, as cata_mesh_eigs does.
///
/// # Safety
/// The pointers are as the header describes them there.
pub(super) unsafe fn write_eigs(
    mesh: &TriMesh,
    k: usize,
    eigenvalues: *mut f64,
    eigenvectors: *mut f64,
    ldv: usize,
    residuals: *mut f64,
    masses: *mut f64,
    params: *const cata_eigs_params,
    find: impl FnOnce(&Laplacian, &LaplacianOptions, &EigenOptions<'_>) -> Result<Eigenpairs, Failure>,
) -> Result<(), Failure> {
    let n = mesh.vertices().len();
    // SAFETY: clause `memory` (`masses`, `n` elements), clause `passed on` (`Outputs::new`).
    let (outputs, masses) = unsafe {
        (
            Outputs::new(n, k, eigenvalues, eigenvectors, ldv, residuals)?,
            optional_slice_mut("masses", masses, n)?,
        )
    };
    let wants_masses = masses.is_some();
    let work = |options: &EigenOptions<'_>, of: &LaplacianOptions| {
        if wants_masses && of.mass == MassKind::Consistent {
            let why = "masses: must be NULL with CATA_MASS_CONSISTENT, which is no diagonal";
            return Err(Failure::new(CATA_ERR_ARGUMENT, why));
        }
        let operator = laplacian(mesh, of)?;
        let pairs = find(&operator, of, options)?;
        Ok((operator, pairs))
    };
    // SAFETY: clause `structs` (`params`).
    let (operator, pairs) = unsafe { with_eigen_options(k, params, work) }?;
    let vectors = operator.extend(pairs.vectors.as_ref())?;
    outputs.write(&pairs.values, vectors.as_ref(), &pairs.residuals);
    if let (Some(masses), Mass::Lumped(found)) = (masses, &operator.mass) {
        masses.fill(0.0);
        operator.kept.iter().zip(found).for_each(|(&vertex, mass)| masses[vertex] = *mass);
    }
    Ok(())
}
