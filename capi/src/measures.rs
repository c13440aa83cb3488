use std::ffi::c_void;

use super::boundary::boundary;
use super::outputs::{fill_slice, tell};
use super::params::{Params, init, params, with_params};
use super::pointer::{mesh, optional_output, optional_slice_mut, put};
use super::progress::{cata_progress, reported};
use super::status::cata_status;
use catamaran::base::{Error, Progress};
use catamaran_geometry::decimate::{Difference, Quality};
use catamaran_geometry::mesh::Comparison;

/// How meshes are compared, or made of a lattice.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_mesh_params {
    /// sizeof(cata_mesh_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Progress callback; NULL: none.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
}

params!(cata_mesh_params, progress_user: *mut c_void);

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_params_init(
    params: *mut cata_mesh_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Measures a mesh; NULL where not wanted.
///
/// - `area`, `volume`: written; the volume is negative where faces are seen clockwise from outside,
///   and NaN unless the mesh has faces, is closed (every edge has two faces) and oriented.
/// - `face_areas`, `qualities`: n_faces elements each, written. The quality of a face is 2 sqrt(3)
///   area / (half the perimeter x the longest edge): 1 for equilateral triangles, 0 for flat ones.
/// - `face_normals`: 3 for each face, written: of length 1, or 0 for faces without area.
/// - `vertex_normals`: 3 for each vertex, written: the directions of the means of the normals of
///   its faces by area, of length 1, or 0 where the mean is 0.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_measures(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    area: *mut f64,
    volume: *mut f64,
    face_areas: *mut f64,
    qualities: *mut f64,
    face_normals: *mut f64,
    vertex_normals: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `area`, one
        // value; `volume`, one value; `face_areas`, `n_faces` elements; `qualities`, `n_faces`
        // elements; `face_normals`, `3 * n_faces` elements; `vertex_normals`, `3 * n_vertices`
        // elements).
        let (mesh, area, volume, areas, qualities, of_faces, of_vertices) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                optional_output("area", area)?,
                optional_output("volume", volume)?,
                optional_slice_mut("face_areas", face_areas, n_faces)?,
                optional_slice_mut("qualities", qualities, n_faces)?,
                optional_slice_mut("face_normals", face_normals, 3 * n_faces)?,
                optional_slice_mut("vertex_normals", vertex_normals, 3 * n_vertices)?,
            )
        };
        mesh.check_size()?;
        put(area, mesh.area());
        if let Some(volume) = volume {
            *volume = mesh.volume().unwrap_or(f64::NAN);
        }
        fill_wanted(areas, || mesh.face_areas());
        fill_wanted(qualities, || mesh.qualities());
        fill_wanted(of_faces, || mesh.face_normals().into_flattened());
        fill_wanted(of_vertices, || mesh.vertex_normals().into_flattened());
        Ok(())
    })
}

/// Measures how uniform a mesh is, such as one that was decimated; NULL where not wanted.
///
/// - `mean_area`: of the faces; `area_variation`: the standard deviation of their areas over it.
/// - `mean_quality`, `quality_deviation`, `least_quality`: of the qualities of the faces, as
///   cata_mesh_measures has them, with their standard deviation.
/// - `mean_valence`: edges at a vertex with a face, in the mean; `regular_vertices`: the share of
///   these vertices that have 6, or 4 at the boundary.
/// - `non_manifold_edges`: the number of edges with more than two faces.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_quality(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    mean_area: *mut f64,
    area_variation: *mut f64,
    mean_quality: *mut f64,
    quality_deviation: *mut f64,
    least_quality: *mut f64,
    mean_valence: *mut f64,
    regular_vertices: *mut f64,
    non_manifold_edges: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; the others,
        // one value each).
        unsafe {
            let mesh = mesh(n_vertices, vertices, n_faces, faces)?;
            mesh.check_size()?;
            let found = Quality::of(&mesh);
            tell! {
                mean_area: found.mean_area,
                area_variation: found.area_variation,
                mean_quality: found.mean_quality,
                quality_deviation: found.quality_deviation,
                least_quality: found.least_quality,
                mean_valence: found.mean_valence,
                regular_vertices: found.regular_vertices,
                non_manifold_edges: found.non_manifold_edges,
            }
        }
        Ok(())
    })
}

/// Compares two meshes; NULL where not wanted.
///
/// - `out`, `back`: 3 numbers each, written: from the mesh to the other one, and back: the largest
///   distance, of vertices and of 100,000 points spread by area, from the other surface; the mean
///   distance of these points; and the mean angle between the normals there, in degrees.
/// - `hausdorff`: written: the largest distance of a vertex of either mesh from the other surface.
/// - `chamfer`: written: the mean square of the distances of the vertices of one mesh from the
///   other surface, plus the same in the other direction.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_compare(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    other_n_vertices: usize,
    other_vertices: *const f64,
    other_n_faces: usize,
    other_faces: *const u32,
    out: *mut f64,
    back: *mut f64,
    hausdorff: *mut f64,
    chamfer: *mut f64,
    params: *const cata_mesh_params,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `out`, `3`
        // elements; `back`, `3` elements; `hausdorff`, one value; `chamfer`, one value).
        let (first, second, sides, [hausdorff, chamfer]) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                mesh(other_n_vertices, other_vertices, other_n_faces, other_faces)
                    .map_err(|failure| failure.of("other"))?,
                [optional_slice_mut("out", out, 3)?, optional_slice_mut("back", back, 3)?],
                [optional_output("hausdorff", hausdorff)?, optional_output("chamfer", chamfer)?],
            )
        };
        let wants = (sides.iter().any(Option::is_some), hausdorff.is_some() || chamfer.is_some());
        let work = |params: &cata_mesh_params, progress: Progress<'_>| {
            let par = params.par();
            reported(progress, || {
                let spread = wants.0.then(|| Comparison::between(&first, &second, par));
                let distances = wants.1.then(|| Difference::between(&first, &second, par));
                Ok::<_, Error>((spread.transpose()?, distances.transpose()?))
            })
        };
        // SAFETY: clause `structs` (`params`).
        let (spread, distances) = unsafe { with_params(params, work) }?;
        let found = spread.iter().flat_map(|all| [all.out, all.back]);
        for (place, side) in sides.into_iter().zip(found) {
            fill_slice(place, &[side.largest, side.mean, side.angle]);
        }
        if let Some(distances) = distances {
            put(hausdorff, distances.hausdorff);
            put(chamfer, distances.chamfer);
        }
        Ok(())
    })
}

/// Computes elements where they are wanted.
fn fill_wanted(place: Option<&mut [f64]>, found: impl FnOnce() -> Vec<f64>) {
    if let Some(place) = place {
        place.copy_from_slice(&found());
    }
}
