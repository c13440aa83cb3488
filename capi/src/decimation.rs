//! # Decimation
//!
//! A mesh with a given number of vertices, spread evenly over the surface (thesis, chapter 5),
//! and what carries functions, attributes and textures from one to the other.
//!
//! ```c
//! double v[] = {1, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1}; // an octahedron
//! uint32_t f[] = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 1, 0, 5, 2, 1, 5, 3, 2, 5, 0, 3, 5};
//! cata_decimation *sphere;
//! size_t n_faces;
//! if (cata_decimation_new(6, v, 8, f, 100, NULL, &sphere) == CATA_OK) {
//!     cata_decimation_size(sphere, NULL, &n_faces, NULL);
//!     printf("%zu\n", n_faces); // 196
//!     cata_decimation_free(sphere);
//! }
//! ```

use std::ffi::c_void;

use super::boundary::boundary;
use super::eigs::{CATA_BOUNDARY_DIRICHLET, cata_eigs_params};
use super::mesh::write_eigs;
use super::outputs::{copy_wanted, fill_mesh, fill_slice, tell};
use super::params::{Params, flag, init, params, with_params};
use super::pointer::{
    check_size, free, hand_over, known, mesh, optional_slice_mut, output, slice, slice_mut,
};
use super::progress::cata_progress;
use super::status::{Failure, cata_status};
use catamaran::base::{Error, Par, Progress};
use catamaran::sparse::{EigenOptions, eigs_two_level, select};
use catamaran_geometry::decimate::{
    DecimateOptions, Decimation, Difference, FarthestPoints, Method, decimate, decimate_within,
};
use catamaran_geometry::mesh::io::{Attribute, MeshFile};
use catamaran_geometry::mesh::{Boundary, Laplacian, LaplacianOptions, TriMesh};

/// `method`: exactly n vertices, the topology of the input.
pub const CATA_DECIMATION_UNIFORM: i32 = 0;
/// `method`: algorithm 5.2, for comparison: no manifold.
pub const CATA_DECIMATION_THESIS: i32 = 1;

/// Passes: none, where 0 stands for the default.
pub const CATA_NO_PASSES: i32 = -1;

/// How a mesh is decimated.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_decimation_params {
    /// sizeof(cata_decimation_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Progress callback; NULL: none.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
    /// CATA_DECIMATION_*.
    pub method: i32,
    /// Passes that move samples to the centroids of their cells; 0: none.
    pub lloyd: i32,
    /// Passes that flip edges and move vertices of the result; 0: 12, or CATA_NO_PASSES.
    pub relaxation: i32,
    /// With `has_first` 1: the vertex of the first sample. Otherwise ignored.
    pub first: u32,
    /// 1: `first` is used; 0: the lowest vertex that a face has.
    pub has_first: i32,
    /// 1: handles too narrow for the triangles of the result are cut, and their ends closed. 0:
    /// they are kept.
    pub cut_narrow_handles: i32,
    /// 1: edges of the input stay whole, and n is at most its number of vertices. 0: those
    /// longer than the edges of the result are split first.
    pub keep_edges: i32,
    /// Vertices that stay, each once: the first of the result, in this order, at the same
    /// positions; edges between them stay, unless they are longer than those of the result and
    /// split (cata_decimation_locked_edges). NULL: none.
    pub locked: *const u32,
    /// Number of `locked`, at most n.
    pub n_locked: usize,
    /// 1: the relaxation ends with passes that make areas as equal as possible, at the cost of
    /// the shapes of triangles. 0: it does not.
    pub uniform: i32,
    /// Vertices of the result per area, relative to elsewhere: a positive number for each vertex
    /// of the input. NULL: the same everywhere.
    pub density: *const f64,
    /// Number of `density`: n_vertices, or 0.
    pub n_density: usize,
    /// Up to how many times as many vertices per area where the surface bends; 0: 1.
    pub curvature: f64,
}

params!(cata_decimation_params, keep_edges: i32);

/// A decimated mesh, and how it lies on the input. Made by cata_decimation_new; constant.
pub struct cata_decimation {
    input: TriMesh,
    found: Decimation,
    par: Par,
}

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_decimation_params_init(
    params: *mut cata_decimation_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Decimates a triangle mesh to exactly n vertices, uniformly: a manifold with the components,
/// boundary loops and genus of the input. The input is cut along edges of more than two faces
/// first, and edges longer than those of the result are split, so that n may also be more than the
/// input has. No step makes faces intersect that did not. Impossible requests return an error, and
/// the message says why.
///
/// - `n`: vertices of the result. With fewer than the topology needs, CATA_ERR_ARGUMENT.
/// - `decimation`: one pointer, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_decimation_new(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    n: usize,
    params: *const cata_decimation_params,
    decimation: *mut *mut cata_decimation,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `decimation`,
        // one value).
        let (input, place) = unsafe {
            (mesh(n_vertices, vertices, n_faces, faces)?, output("decimation", decimation)?)
        };
        // SAFETY: clause `passed on` (`decimated`).
        let found =
            unsafe { decimated(input, params, |input, options| decimate(input, n, options)) }?;
        hand_over(place, found);
        Ok(())
    })
}

/// Decimates a triangle mesh as cata_decimation_new does, to the fewest vertices that a search
/// finds for which no point of either surface is farther from the other one than `error`: what
/// cata_decimation_bound returns is at most `error`. The number is at most 2 % (or 1) above one
/// that is too small.
///
/// - `error`: positive, in the unit of the mesh. If it can't be reached, CATA_ERR_ARGUMENT.
/// - `decimation`: one pointer, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_decimation_new_within(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    error: f64,
    params: *const cata_decimation_params,
    decimation: *mut *mut cata_decimation,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `decimation`,
        // one value).
        let (input, place) = unsafe {
            (mesh(n_vertices, vertices, n_faces, faces)?, output("decimation", decimation)?)
        };
        // SAFETY: clause `passed on` (`decimated`).
        let found = unsafe {
            decimated(input, params, |input, options| decimate_within(input, error, options))
        }?;
        hand_over(place, found);
        Ok(())
    })
}

/// Computes an upper bound of the distance of any point of the input or of the result from the
/// other surface: the Hausdorff distance, or at most 1 % more.
///
/// - `bound`: written, in the unit of the mesh.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_decimation_bound(
    decimation: *const cata_decimation,
    bound: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`bound`, one value), clause `handles` (`decimation`).
        let (own, place) = unsafe { (known("decimation", decimation)?, output("bound", bound)?) };
        let found = Difference::between(&own.input, &own.found.mesh, own.par)?;
        *place = found.hausdorff_bound;
        Ok(())
    })
}

/// Gets the number of edges of the input between locked vertices, and that of those which the
/// result does not have: edges longer than its own were split. NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_decimation_locked_edges(
    decimation: *const cata_decimation,
    n_edges: *mut usize,
    n_lost: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`n_edges`, one value; `n_lost`, one value), clause `handles`
        // (`decimation`).
        unsafe {
            let found = &known("decimation", decimation)?.found;
            tell! {
                n_edges: found.locked_edges,
                n_lost: found.lost_edges,
            }
        }
        Ok(())
    })
}

/// Frees a decimation.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_decimation_free(decimation: *mut cata_decimation) {
    // SAFETY: clause `handles` (`decimation`).
    unsafe { free(decimation) };
}

/// Gets the numbers of vertices and faces of the result, and whether the input had to be repaired
/// (repeated faces and vertices without a face left out, faces flipped, the mesh cut): 1, or 0.
/// NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_decimation_size(
    decimation: *const cata_decimation,
    n_vertices: *mut usize,
    n_faces: *mut usize,
    repaired: *mut i32,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`n_vertices`, one value; `n_faces`, one value; `repaired`, one
        // value), clause `handles` (`decimation`).
        unsafe {
            let found = &known("decimation", decimation)?.found;
            tell! {
                n_vertices: found.mesh.vertices().len(),
                n_faces: found.mesh.faces().len(),
                repaired: i32::from(found.repairs != Default::default()),
            }
        }
        Ok(())
    })
}

/// Gets the vertices and faces of the result, as many as cata_decimation_size returns; NULL where
/// not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_decimation_get(
    decimation: *const cata_decimation,
    vertices: *mut f64,
    faces: *mut u32,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `handles` (`decimation`), clause `passed on` (`fill_mesh`).
        unsafe { fill_mesh(&known("decimation", decimation)?.found.mesh, vertices, faces) }
    })
}

/// Gets where the result lies on the input; NULL where not wanted.
///
/// - `cells`: for each vertex of the input the nearest one of the result along edges, written;
///   UINT32_MAX for those that no face has.
/// - `distances`: for each vertex of the input how far that is, written.
/// - `places`: for each vertex of the result the face of the input at it, written.
/// - `weights`: 3 for each vertex of the result, written: its barycentric coordinates there.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_decimation_places(
    decimation: *const cata_decimation,
    cells: *mut u32,
    distances: *mut f32,
    places: *mut u32,
    weights: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`cells` and `distances`, one element a vertex of the input;
        // `places`, one a vertex of the result; `weights`, 3), clause `handles` (`decimation`).
        unsafe {
            let found = &known("decimation", decimation)?.found;
            let of_faces: Vec<u32> = found.places.iter().map(|place| place.face).collect();
            let inside: Vec<[f64; 3]> = found.places.iter().map(|place| place.weights).collect();
            copy_wanted! {
                cells: found.cells.of_vertices(),
                distances: found.cells.distances(),
                places: &of_faces,
                weights: inside.as_flattened(),
            }
        }
        Ok(())
    })
}

/// Computes values of the input's vertices at the vertices of the result: `width` for each, one
/// vertex after the other.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_decimation_carry(
    decimation: *const cata_decimation,
    width: usize,
    values: *const f64,
    carried: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`values`, `before * width` elements; `carried`, `after * width`
        // elements), clause `handles` (`decimation`).
        let (own, values, carried) = unsafe {
            let own = known("decimation", decimation)?;
            let (before, after) = (own.input.vertices().len(), own.found.mesh.vertices().len());
            check_size::<f64>("values", before, width)?;
            check_size::<f64>("carried", after, width)?;
            let values = slice("values", values, before * width)?;
            (own, values, slice_mut("carried", carried, after * width)?)
        };
        carried.copy_from_slice(&own.found.carry_values(&own.input, width, values)?);
        Ok(())
    })
}

/// Computes values of the result's vertices at the vertices of the input: each is the mean of those
/// of a face near it, 0 at vertices without a face.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_decimation_prolong(
    decimation: *const cata_decimation,
    width: usize,
    values: *const f64,
    prolonged: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`values`, `after * width` elements; `prolonged`, `before *
        // width` elements), clause `handles` (`decimation`).
        let (own, values, prolonged) = unsafe {
            let own = known("decimation", decimation)?;
            let (before, after) = (own.input.vertices().len(), own.found.mesh.vertices().len());
            check_size::<f64>("values", after, width)?;
            check_size::<f64>("prolonged", before, width)?;
            let values = slice("values", values, after * width)?;
            (own, values, slice_mut("prolonged", prolonged, before * width)?)
        };
        let weights = own.found.weights(&own.input, own.par)?;
        prolonged.fill(0.0);
        for (to, row) in weights.outer_iterator().enumerate() {
            for (from, weight) in row.iter() {
                for k in 0..width {
                    prolonged[to * width + k] += weight * values[from * width + k];
                }
            }
        }
        Ok(())
    })
}

/// Computes the k smallest eigenpairs of the Laplacian of the input, approximately, from those of
/// the result, as cata_eigs_two_level does. Eigenvalues are about 0.1 % too large where the
/// triangles of the input are even, and several per cent where they are long and thin.
///
/// - `k`: at most the vertices of the result.
/// - `eigenvalues`, `eigenvectors`, `residuals`, `masses`: as those of cata_mesh_eigs.
/// - `params`: as for cata_eigs_two_level, with CATA_BOUNDARY_NEUMANN.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_decimation_eigs(
    decimation: *const cata_decimation,
    k: usize,
    eigenvalues: *mut f64,
    eigenvectors: *mut f64,
    ldv: usize,
    residuals: *mut f64,
    masses: *mut f64,
    params: *const cata_eigs_params,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `handles` (`decimation`).
        let own = unsafe { known("decimation", decimation) }?;
        let find = |operator: &Laplacian, of: &LaplacianOptions, options: &EigenOptions<'_>| {
            if of.boundary == Boundary::Dirichlet {
                let is = CATA_BOUNDARY_DIRICHLET;
                return Err(Failure::argument("params.boundary", "CATA_BOUNDARY_NEUMANN (0)", is));
            }
            let weights = own.found.weights(&own.input, own.par)?;
            let columns: Vec<_> = (0..weights.cols()).map(Some).collect();
            let p = select(weights.view(), &operator.kept, &columns, columns.len());
            Ok(eigs_two_level(operator.stiffness.view(), &operator.mass, p.view(), options)?)
        };
        let input = &own.input;
        // SAFETY: clause `passed on` (`write_eigs`).
        unsafe {
            write_eigs(input, k, eigenvalues, eigenvectors, ldv, residuals, masses, params, find)
        }
    })
}

/// Computes the texture of the result, from that of the input, with its seams.
///
/// - `uv`: 6 for each face of the input, read: u and v at its three corners.
/// - `carried`: 6 for each face of the result, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_decimation_carry_uv(
    decimation: *const cata_decimation,
    uv: *const f64,
    carried: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`uv`, `6 * own.input.faces().len()` elements; `carried`, `6 *
        // own.found.mesh.faces().len()` elements), clause `handles` (`decimation`).
        let (own, uv, carried) = unsafe {
            let own = known("decimation", decimation)?;
            let uv = slice("uv", uv, 6 * own.input.faces().len())?;
            (own, uv, slice_mut("carried", carried, 6 * own.found.mesh.faces().len())?)
        };
        if let Some(i) = uv.iter().position(|x| !x.is_finite()) {
            return Err(Error::NonFinite { what: "uv", index: (i / 6, i % 6) }.into());
        }
        let mut file = MeshFile::from(own.input.clone());
        let corners = (0..own.input.faces().len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]);
        let values = uv.as_chunks().0.to_vec();
        file.uv = Some(Attribute { values, corners: Some(corners.collect()) });
        let found = own.found.carry(&file)?;
        for (f, place) in carried.as_chunks_mut::<6>().0.iter_mut().enumerate() {
            let of_face = found.uv.as_ref().and_then(|uv| uv.of_face(&found.mesh, f));
            place.copy_from_slice(of_face.unwrap_or_default().as_flattened());
        }
        Ok(())
    })
}

/// Computes the farthest points of a mesh: each new sample is the vertex farthest along edges from
/// those before, so that the first ones are the same for every n.
///
/// - `n`: samples, at most the vertices that have a face.
/// - `samples`: n vertices, written, in their order.
/// - `nearest`: n_vertices elements, written: the number of the sample nearest to each vertex,
///   UINT32_MAX for those that no face has. NULL where not wanted.
/// - `distances`: n_vertices elements, written: how far it is. NULL where not wanted.
/// - `params`: `first` and `progress` are used, the rest is only checked. On the calling thread.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_decimation_farthest_points(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    n: usize,
    samples: *mut u32,
    nearest: *mut u32,
    distances: *mut f32,
    params: *const cata_decimation_params,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `samples`,
        // `n` elements; `nearest`, `n_vertices` elements; `distances`, `n_vertices` elements).
        let (mesh, samples, nearest, distances) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                slice_mut("samples", samples, n)?,
                optional_slice_mut("nearest", nearest, n_vertices)?,
                optional_slice_mut("distances", distances, n_vertices)?,
            )
        };
        if n == 0 {
            return Err(Failure::argument("n", "at least 1", 0));
        }
        let work = |options: &DecimateOptions<'_>| {
            let mut points = FarthestPoints::new(&mesh, options.first)?;
            points.extend_to(n, options.progress)?;
            Ok((points.samples().to_vec(), points.cells()))
        };
        // SAFETY: clause `structs` (`params`).
        let (found, cells) = unsafe { with_options(params, work) }?;
        samples.copy_from_slice(&found);
        fill_slice(nearest, cells.of_vertices());
        fill_slice(distances, cells.distances());
        Ok(())
    })
}

/// Decimates a mesh by `work`, with the options of `params`.
///
/// # Safety
/// As [`with_options`].
unsafe fn decimated(
    input: TriMesh,
    params: *const cata_decimation_params,
    work: impl FnOnce(&TriMesh, &DecimateOptions<'_>) -> catamaran::Result<Decimation>,
) -> Result<cata_decimation, Failure> {
    // SAFETY: clause `passed on` (`with_options`).
    let (found, par) =
        unsafe { with_options(params, |options| Ok((work(&input, options)?, options.par))) }?;
    Ok(cata_decimation { input, found, par })
}

/// Returns what `work` returns for the options of the caller.
///
/// # Safety
/// `params` is NULL or points to a struct as the header describes it.
pub(super) unsafe fn with_options<X>(
    params: *const cata_decimation_params,
    work: impl FnOnce(&DecimateOptions<'_>) -> catamaran::Result<X>,
) -> Result<X, Failure> {
    let default = DecimateOptions::default();
    let work = |params: &cata_decimation_params, progress: Progress<'_>| {
        let method = match params.method {
            CATA_DECIMATION_UNIFORM => Method::Uniform,
            CATA_DECIMATION_THESIS => Method::Thesis,
            other => {
                let any = "a CATA_DECIMATION_* value";
                return Err(Failure::argument("params.method", any, other));
            }
        };
        let locked: &[u32] = match params.n_locked {
            0 => &[],
            // SAFETY: clause `memory` (`params.locked`, `n_locked` elements).
            count => unsafe { slice("params.locked", params.locked, count) }?,
        };
        let density: &[f64] = match params.n_density {
            0 => &[],
            // SAFETY: clause `memory` (`params.density`, `n_density` elements).
            count => unsafe { slice("params.density", params.density, count) }?,
        };
        let curvature = if params.curvature == 0.0 { default.curvature } else { params.curvature };
        let options = DecimateOptions::new()
            .par(params.par())
            .method(method)
            .resample(!flag("params.keep_edges", params.keep_edges)?)
            .lloyd(passes("params.lloyd", params.lloyd, default.lloyd)?)
            .relaxation(passes("params.relaxation", params.relaxation, default.relaxation)?)
            .cut_narrow_handles(flag("params.cut_narrow_handles", params.cut_narrow_handles)?)
            .locked(locked)
            .density(density)
            .curvature(curvature)
            .uniform(flag("params.uniform", params.uniform)?)
            .first(flag("params.has_first", params.has_first)?.then_some(params.first))
            .progress(progress);
        Ok(work(&options)?)
    };
    // SAFETY: clause `structs` (`params`).
    unsafe { with_params(params, work) }
}

/// Returns a number of passes: 0 is the default, -1 is none.
fn passes(what: &str, value: i32, default: usize) -> Result<usize, Failure> {
    match value {
        0 => Ok(default),
        CATA_NO_PASSES => Ok(0),
        _ => {
            usize::try_from(value).map_err(|_| Failure::argument(what, "-1, 0 or positive", value))
        }
    }
}
