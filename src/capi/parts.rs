use super::boundary::boundary;
use super::mesh_spectrum::{cata_laplacian_params, laplacian_options};
use super::params::{flag, par};
use super::pointer::{check_size, slice, slice_mut};
use super::status::{CATA_ERR_ARGUMENT, Failure, cata_status};
use crate::base::Error;
use crate::mesh::{Boundary, TriMesh};
use crate::unions::{PartSpectra, ShapeDnaOptions, retrieve, shape_dna};

/// The k smallest eigenvalues of the Laplacian of a part of a triangle mesh.
///
/// The part has the faces whose three vertices are in the mask. Under CATA_BOUNDARY_DIRICHLET functions are zero where the
/// part ends and at the boundary of the mesh: of two parts of which one lies in the other, the inner one then has no smaller
/// eigenvalue anywhere in the sequence. Under CATA_BOUNDARY_NEUMANN the part is a mesh of its own.
///
/// - `vertices`: their number.
/// - `positions`: 3 `vertices` elements, read: x, y, z of each vertex. May be NULL when there are none.
/// - `faces`: their number.
/// - `corners`: 3 `faces` elements, read: three vertices of each face, from 0. May be NULL when there are none.
/// - `mask`: `vertices` elements, read: 1 for a vertex of the part, 0 for any other. May be NULL when there are none.
/// - `k`: number of eigenvalues, at most the vertices of the part that are not held at zero.
/// - `eigenvalues`: k elements, written: ascending, in units of 1 / length^2. May be NULL when k is 0.
/// - `laplacian_params`: NULL for the defaults; else read during the call.
/// - `threads`: 0: all cores of the affinity mask.
///
/// Returns CATA_OK, CATA_ERR_NULL, CATA_ERR_SHAPE, CATA_ERR_ARGUMENT, CATA_ERR_MESH, CATA_ERR_NOT_CONVERGED,
/// CATA_ERR_OUT_OF_MEMORY or CATA_ERR_PANIC; outputs are untouched unless it is CATA_OK.
///
/// The result does not depend on the number of threads, bit for bit. Thread-safe.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_part_spectrum(
    vertices: usize,
    positions: *const f64,
    faces: usize,
    corners: *const u32,
    mask: *const u8,
    k: usize,
    eigenvalues: *mut f64,
    laplacian_params: *const cata_laplacian_params,
    threads: usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: the caller's promise.
        let (mesh, mask, eigenvalues, mut options) = unsafe {
            (
                mesh(vertices, positions, faces, corners)?,
                slice("mask", mask, vertices)?,
                slice_mut("eigenvalues", eigenvalues, k)?,
                laplacian_options(laplacian_params)?,
            )
        };
        options.par = par(threads);
        if let Some(v) = mask.iter().position(|&inside| inside > 1) {
            let why = format!("mask: element {v} is {}, where 0 or 1 is needed", mask[v]);
            return Err(Failure::new(CATA_ERR_ARGUMENT, why));
        }
        let mask: Vec<bool> = mask.iter().map(|&inside| inside == 1).collect();
        let parts = PartSpectra::new(&mesh, &options)?;
        let found = match options.boundary {
            Boundary::Dirichlet => parts.dirichlet(&mask, k)?,
            _ => parts.neumann(&mask, k)?,
        };
        eigenvalues.copy_from_slice(&found);
        Ok(())
    })
}

/// ShapeDNA: the k smallest eigenvalues of the Laplacian of a triangle mesh as its signature (Reuter, Wolter and Peinecke
/// 2006).
///
/// - `vertices`, `positions`, `faces`, `corners`, `laplacian_params`, `threads`: as those of cata_part_spectrum.
/// - `k`: number of eigenvalues, at most the vertices that are in a face and not held at zero.
/// - `normalized`: 1: they are multiplied by the area, so that they do not depend on the size of the mesh; 0: they are not.
/// - `signature`: k elements, written: ascending. May be NULL when k is 0.
///
/// Returns as cata_part_spectrum.
///
/// The result does not depend on the number of threads, bit for bit. Thread-safe.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_shape_dna(
    vertices: usize,
    positions: *const f64,
    faces: usize,
    corners: *const u32,
    k: usize,
    normalized: i32,
    signature: *mut f64,
    laplacian_params: *const cata_laplacian_params,
    threads: usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: the caller's promise.
        let (mesh, signature, mut laplacian) = unsafe {
            (
                mesh(vertices, positions, faces, corners)?,
                slice_mut("signature", signature, k)?,
                laplacian_options(laplacian_params)?,
            )
        };
        laplacian.par = par(threads);
        let normalized = flag("normalized", normalized)?;
        let found = shape_dna(&mesh, &ShapeDnaOptions { k, normalized, laplacian })?;
        signature.copy_from_slice(&found);
        Ok(())
    })
}

/// The signatures nearest to a query, in Euclidean distance; of equally near ones the first.
///
/// - `k`: numbers of a signature.
/// - `query`: k elements, read. May be NULL when k is 0.
/// - `count`: number of signatures.
/// - `signatures`: `count` x k elements, read, one after the other. May be NULL when there are none.
/// - `wanted`: how many are wanted, at most `count`.
/// - `indices`: `wanted` elements, written: numbers of signatures from 0, the nearest first. May be NULL when `wanted` is 0.
/// - `distances`: `wanted` elements, written: their distances. May be NULL when `wanted` is 0.
/// - `threads`: 0: all cores of the affinity mask.
///
/// Returns CATA_OK, CATA_ERR_NULL, CATA_ERR_SHAPE, CATA_ERR_ARGUMENT, CATA_ERR_NON_FINITE or CATA_ERR_PANIC; outputs are
/// untouched unless it is CATA_OK.
///
/// Thread-safe.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_shape_dna_retrieve(
    k: usize,
    query: *const f64,
    count: usize,
    signatures: *const f64,
    wanted: usize,
    indices: *mut usize,
    distances: *mut f64,
    threads: usize,
) -> cata_status {
    boundary(|| {
        check_size::<f64>("signatures", count, k)?;
        if wanted > count {
            let why = format!("wanted: must be at most count, is {wanted} of {count}");
            return Err(Failure::new(CATA_ERR_ARGUMENT, why));
        }
        // SAFETY: the caller's promise.
        let (query, signatures, indices, distances) = unsafe {
            (
                slice("query", query, k)?,
                slice("signatures", signatures, count * k)?,
                slice_mut("indices", indices, wanted)?,
                slice_mut("distances", distances, wanted)?,
            )
        };
        let rows: Vec<&[f64]> = (0..count).map(|i| &signatures[i * k..(i + 1) * k]).collect();
        let found = retrieve(query, &rows, wanted, par(threads))?;
        for (i, found) in found.iter().enumerate() {
            (indices[i], distances[i]) = (found.index, found.distance);
        }
        Ok(())
    })
}

/// A mesh of what C points to.
///
/// # Safety
/// The pointers are as the functions of this file say.
pub(super) unsafe fn mesh(
    vertices: usize,
    positions: *const f64,
    faces: usize,
    corners: *const u32,
) -> Result<TriMesh, Failure> {
    check_size::<f64>("positions", vertices, 3)?;
    check_size::<u32>("corners", faces, 3)?;
    // SAFETY: the caller's promise.
    let (positions, corners) = unsafe {
        (slice("positions", positions, 3 * vertices)?, slice("corners", corners, 3 * faces)?)
    };
    let made: Result<TriMesh, Error> =
        TriMesh::new(positions.as_chunks().0.to_vec(), corners.as_chunks().0.to_vec());
    Ok(made?)
}
