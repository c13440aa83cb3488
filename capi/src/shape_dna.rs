use super::boundary::boundary;
use super::eigs::{cata_eigs_params, with_eigen_options};
use super::params::flag;
use super::pointer::{check_size, mesh, slice, slice_mut};
use super::status::{Failure, cata_status};
use catamaran::Par;
use catamaran::sparse::EigenOptions;
use catamaran_geometry::mesh::LaplacianOptions;
use catamaran_geometry::unions::{ShapeDnaOptions, retrieve, shape_dna};

/// Computes ShapeDNA: the k smallest eigenvalues of the Laplacian of a triangle mesh as its
/// signature (Reuter, Wolter and Peinecke 2006).
///
/// - `k`: number of eigenvalues, at most the vertices that are in a face and not held at zero, and
///   more than are 0 (cata_mesh_free_components).
/// - `normalized`: 1: they are multiplied by the area, so that they do not depend on the size of
///   the mesh; 0: they are not.
/// - `signature`: k elements, written: ascending.
/// - `params`: the Laplacian, `threads` and `progress` are used, the rest is only checked.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_shape_dna(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    k: usize,
    normalized: i32,
    signature: *mut f64,
    params: *const cata_eigs_params,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `signature`,
        // `k` elements).
        let (mesh, signature) = unsafe {
            (mesh(n_vertices, vertices, n_faces, faces)?, slice_mut("signature", signature, k)?)
        };
        let normalized = flag("normalized", normalized)?;
        let work = |options: &EigenOptions<'_>, laplacian: &LaplacianOptions| {
            let options = ShapeDnaOptions::new()
                .k(k)
                .normalized(normalized)
                .laplacian(laplacian.clone())
                .progress(options.progress);
            Ok(shape_dna(&mesh, &options)?)
        };
        // SAFETY: clause `structs` (`params`).
        signature.copy_from_slice(&unsafe { with_eigen_options(k, params, work) }?);
        Ok(())
    })
}

/// Finds the signatures nearest to a query, in Euclidean distance; of equally near ones the first.
/// It looks once at each number, on the calling thread.
///
/// - `query`: the k numbers of a signature; `signatures`: `count` x k, one after the other.
/// - `indices`, `distances`: `wanted` <= count elements each, written: numbers of signatures
///   from 0, the nearest first, and their distances.
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
) -> cata_status {
    boundary(|| {
        check_size::<f64>("signatures", count, k)?;
        if wanted > count {
            return Err(Failure::argument("wanted", format!("at most {count} (count)"), wanted));
        }
        // SAFETY: clause `memory` (`query`, `k` elements; `signatures`, `count * k` elements;
        // `indices`, `wanted` elements; `distances`, `wanted` elements).
        let (query, signatures, indices, distances) = unsafe {
            (
                slice("query", query, k)?,
                slice("signatures", signatures, count * k)?,
                slice_mut("indices", indices, wanted)?,
                slice_mut("distances", distances, wanted)?,
            )
        };
        let rows: Vec<&[f64]> = (0..count).map(|i| &signatures[i * k..(i + 1) * k]).collect();
        let found = retrieve(query, &rows, wanted, Par::Seq)?;
        for (i, found) in found.iter().enumerate() {
            (indices[i], distances[i]) = (found.index, found.distance);
        }
        Ok(())
    })
}
