//! # Distances
//!
//! Distances on a mesh: over its surface, exactly or by the heat method, and along its edges; the
//! shortest paths over faces and along edges, geodesics that the latter shorten to, and geodesics
//! from a point in a direction.
//!
//! ```c
//! double v[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, d[4], length; // a square
//! uint32_t f[] = {0, 1, 3, 1, 2, 3}, source = 0;
//! cata_path *path;
//! cata_distance_edges(4, v, 2, f, 1, &source, d, NULL, NULL, NULL);
//! cata_distance_path(4, v, 2, f, 0, 2, 0, NULL, &path);
//! cata_path_size(path, NULL, NULL, &length);
//! printf("%g away, by a path of %g\n", d[2], length); // 2 away, by a path of 2
//! cata_path_free(path);
//! ```

use std::ffi::c_void;

use super::boundary::boundary;
use super::curve::CATA_IN_SPACE;
use super::outputs::{copy_wanted, fill_slice, tell};
use super::params::{Params, flag, init, params, read_or_zeros};
use super::pointer::{
    check_size, free, hand_over, known, mesh, optional_output, optional_slice, optional_slice_mut,
    output, put, slice, slice_mut,
};
use super::progress::cata_progress;
use super::status::{CATA_ERR_ARGUMENT, CATA_ERR_NOT_CONVERGED, Failure, cata_status};
use catamaran_geometry::curve::{Curve, Waypoint, smooth};
use catamaran_geometry::mesh::{
    Dijkstra, Geodesics, Graph, HeatMethod, HeatOptions, LaplacianKind, SearchLimits, Site,
    SurfacePoint, TraceEnd, TriMesh,
};

/// `flow`: heat flows on the intrinsic Delaunay triangulation of any mesh (tufted cover).
pub const CATA_FLOW_TUFTED: i32 = 0;
/// `flow`: on that of a manifold.
pub const CATA_FLOW_INTRINSIC_DELAUNAY: i32 = 1;
/// `flow`: on the faces: wrong by half and more where they are long.
pub const CATA_FLOW_COTANGENT: i32 = 2;

/// Instead of a vertex: there is none.
pub const CATA_NO_VERTEX: u32 = u32::MAX;

/// `end`: the geodesic has the length that was asked for.
pub const CATA_TRACE_COMPLETE: i32 = 0;
/// `end`: it stopped at the boundary of the mesh.
pub const CATA_TRACE_BOUNDARY: i32 = 1;
/// `end`: it stopped where more than one way leads on: at an edge of more than two faces, or
/// where the surface meets itself.
pub const CATA_TRACE_NON_MANIFOLD: i32 = 2;

/// Joints that a path may be shortened at, for each of its vertices.
const JOINTS: usize = 1000;

/// How distances are computed.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_distance_params {
    /// sizeof(cata_distance_params).
    pub struct_size: usize,
    /// Threads of the heat method, at most; 0: all.
    pub threads: usize,
    /// Progress callback; NULL: none.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
    /// For the heat method: time of the flow, in units of the squared mean length of edges,
    /// positive; 0: 1. Longer times make distances smoother.
    pub time: f64,
    /// Along edges: vertices farther than this are not reached, positive; 0: all are.
    pub cutoff: f64,
    /// For the heat method: CATA_FLOW_*.
    pub flow: i32,
}

params!(cata_distance_params, flow: i32);

/// A mesh, prepared for the heat method. Made by cata_heat_new; constant.
pub struct cata_heat {
    heat: HeatMethod,
    /// Number of vertices of the mesh.
    n_vertices: usize,
}

/// A path from one point to another. Made by cata_distance_path, cata_distance_path_exact and
/// cata_distance_trace; constant.
pub struct cata_path {
    vertices: Vec<u32>,
    points: Vec<[f64; 3]>,
    /// The points on the faces; `None` for a path of cata_distance_path.
    places: Option<Vec<SurfacePoint>>,
    length: f64,
}

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_distance_params_init(
    params: *mut cata_distance_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Prepares the distances over the surface of a mesh by the heat method (Crane, Weischedel and
/// Wardetzky 2013), by two factorizations. A mesh of fewer than 500 faces is refined for it.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_heat_new(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    params: *const cata_distance_params,
    heat: *mut *mut cata_heat,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `heat`, one
        // value), clause `structs` (`params`).
        let (mesh, params, place) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                read_or_zeros("params", params)?,
                output("heat", heat)?,
            )
        };
        let options = heat_options(&params)?;
        let heat = params.caller().reported(|_| Ok(HeatMethod::new(&mesh, &options)?))?;
        hand_over(place, cata_heat { heat, n_vertices });
        Ok(())
    })
}

/// Frees what was prepared.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_heat_free(heat: *mut cata_heat) {
    // SAFETY: clause `handles` (`heat`).
    unsafe { free(heat) };
}

/// Computes the distance of every vertex from the nearest source over the surface: not exact, at
/// least the straight distance through space, and at most that along edges.
///
/// - `count`, `sources`: vertices.
/// - `distances`: n_vertices elements, written: 0 at sources, INFINITY in components without one.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_heat_distances(
    heat: *const cata_heat,
    count: usize,
    sources: *const u32,
    distances: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`sources`, `count` elements; `distances`, `own.n_vertices`
        // elements), clause `handles` (`heat`).
        let (own, sources, distances) = unsafe {
            let own = known("heat", heat)?;
            let sources = slice("sources", sources, count)?;
            (own, sources, slice_mut("distances", distances, own.n_vertices)?)
        };
        distances.copy_from_slice(&own.heat.distances(sources)?);
        Ok(())
    })
}

/// Computes the length of the shortest path along edges from every vertex to the nearest source
/// (Dijkstra 1959), on the calling thread.
///
/// - `count`, `sources`: vertices.
/// - `distances`: n_vertices elements, written: INFINITY where no path leads.
/// - `nearest`: n_vertices elements, written: the vertex of the nearest source, CATA_NO_VERTEX
///   where no path leads. NULL where not wanted.
/// - `before`: n_vertices elements, written: the vertex before each on the path from its source,
///   CATA_NO_VERTEX at sources and where no path leads. NULL where not wanted.
/// - `params`: `cutoff` and `progress` are used, the rest is only checked.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_distance_edges(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    count: usize,
    sources: *const u32,
    distances: *mut f64,
    nearest: *mut u32,
    before: *mut u32,
    params: *const cata_distance_params,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `sources`,
        // `count` elements), clause `structs` (`params`).
        let (mesh, sources, params) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                slice("sources", sources, count)?,
                read_or_zeros("params", params)?,
            )
        };
        // SAFETY: clause `memory` (`distances`, `n_vertices` elements; `nearest`, `n_vertices`
        // elements; `before`, `n_vertices` elements).
        let (distances, nearest, before) = unsafe {
            (
                slice_mut("distances", distances, n_vertices)?,
                optional_slice_mut("nearest", nearest, n_vertices)?,
                optional_slice_mut("before", before, n_vertices)?,
            )
        };
        heat_options(&params)?;
        let cutoff = if params.cutoff == 0.0 { f64::INFINITY } else { params.cutoff };
        let graph = Graph::of_mesh(&mesh);
        let mut search = Dijkstra::new(&graph);
        params.caller().reported(|_| {
            let starts: Vec<(u32, f64)> = sources.iter().map(|&v| (v, 0.0)).collect();
            Ok(search.search(&starts, &SearchLimits { cutoff, ..SearchLimits::default() })?)
        })?;
        let all = 0..n_vertices as u32;
        distances.copy_from_slice(&search.distances());
        let found: Vec<u32> =
            all.clone().map(|v| search.origin(v).unwrap_or(CATA_NO_VERTEX)).collect();
        fill_slice(nearest, &found);
        let found: Vec<u32> =
            all.map(|v| search.predecessor(v).unwrap_or(CATA_NO_VERTEX)).collect();
        fill_slice(before, &found);
        Ok(())
    })
}

/// Computes the exact distance of every vertex from the nearest source over the surface, up to
/// rounding: the length of the shortest path over faces (Mitchell, Mount and Papadimitriou 1987;
/// Xin and Wang 2009), on the calling thread. Edges may have any number of faces; none may be
/// without length.
///
/// - `count`, `sources`: vertices; with `weights`, the faces of points, or CATA_IN_SPACE: the
///   nearest vertex.
/// - `weights`: 3 `count` elements, read: barycentric coordinates in the faces, or x, y, z. NULL:
///   the sources are vertices.
/// - `distances`: n_vertices elements, written: 0 at sources, INFINITY in components without one.
/// - `params`: `progress` is used, the rest is only checked.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_distance_exact(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    count: usize,
    sources: *const u32,
    weights: *const f64,
    distances: *mut f64,
    params: *const cata_distance_params,
) -> cata_status {
    boundary(|| {
        check_size::<f64>("weights", count, 3)?;
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `sources`,
        // `count` elements; `weights`, `3 * count` elements; `distances`, `n_vertices` elements),
        // clause `structs` (`params`).
        let (mesh, sources, weights, params, distances) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                slice("sources", sources, count)?,
                optional_slice("weights", weights, 3 * count)?,
                read_or_zeros("params", params)?,
                slice_mut("distances", distances, n_vertices)?,
            )
        };
        heat_options(&params)?;
        let sources = sites(sources, weights);
        let found =
            params.caller().reported(|_| Ok(Geodesics::new(&mesh)?.distances(&sources)?))?;
        distances.copy_from_slice(&found);
        Ok(())
    })
}

/// Finds the shortest path over faces that leads through points in their order: from the first to
/// the last. Without a path, the sizes are 0, and the length is INFINITY.
///
/// - `count`, `through`: vertices, at least two; with `weights`, the faces of points, or
///   CATA_IN_SPACE: the nearest vertex.
/// - `weights`: 3 `count` elements, read: barycentric coordinates in the faces, or x, y, z. NULL:
///   the points are vertices.
/// - `params`: `progress` is used, the rest is only checked.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_distance_path_exact(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    count: usize,
    through: *const u32,
    weights: *const f64,
    params: *const cata_distance_params,
    path: *mut *mut cata_path,
) -> cata_status {
    boundary(|| {
        check_size::<f64>("weights", count, 3)?;
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `through`,
        // `count` elements; `weights`, `3 * count` elements; `path`, one value), clause `structs`
        // (`params`).
        let (mesh, through, weights, params, place) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                slice("through", through, count)?,
                optional_slice("weights", weights, 3 * count)?,
                read_or_zeros("params", params)?,
                output("path", path)?,
            )
        };
        heat_options(&params)?;
        let sites = sites(through, weights);
        let found =
            params.caller().reported(|_| Ok(Geodesics::new(&mesh)?.path_through(&sites)?))?;
        let of_vertices = if weights.is_none() { through } else { &[] };
        let is_there = found.length.is_finite();
        hand_over(
            place,
            cata_path {
                vertices: if is_there { of_vertices.to_vec() } else { Vec::new() },
                points: found.positions(&mesh),
                places: Some(found.points),
                length: found.length,
            },
        );
        Ok(())
    })
}

/// Traces the geodesic that leaves a point in a direction, for a length: the exponential map of the
/// surface. It is straight over faces and edges, and passes vertices with equal angles on both
/// sides (Polthier and Schmies 1998). It stops at the boundary, and where more than one way leads
/// on.
///
/// - `start`: a vertex; with `weights`, the face of the point, or CATA_IN_SPACE: the nearest
///   vertex.
/// - `weights`: 3 elements, read: barycentric coordinates in the face, or x, y, z. NULL: the start
///   is a vertex.
/// - `direction`: 3 elements, read: of any length, not 0. It is projected onto the plane of the
///   face; at an edge or a vertex it may point out of the face. At a start that is a vertex it
///   stands for the nearest direction over a face.
/// - `length`: at least 0.
/// - `params`: `progress` is used, the rest is only checked.
/// - `path`: the geodesic, whose length is less than `length` if it stops, and which has no
///   vertices; see cata_path_places for its end.
/// - `end`: how it ends, CATA_TRACE_*. NULL where not wanted.
/// - `heading`: 3 elements, written: the direction at its end, of length 1, in the plane of the
///   face of the last point. NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_distance_trace(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    start: u32,
    weights: *const f64,
    direction: *const f64,
    length: f64,
    params: *const cata_distance_params,
    path: *mut *mut cata_path,
    end: *mut i32,
    heading: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `weights`, 3
        // elements; `direction`, 3 elements), clause `structs` (`params`).
        let (mesh, weights, direction, params) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                optional_slice("weights", weights, 3)?,
                slice("direction", direction, 3)?,
                read_or_zeros("params", params)?,
            )
        };
        // SAFETY: clause `memory` (`path`, one value; `end`, one value; `heading`, 3 elements).
        let (place, end, heading) = unsafe {
            (
                output("path", path)?,
                optional_output("end", end)?,
                optional_slice_mut("heading", heading, 3)?,
            )
        };
        heat_options(&params)?;
        let start = sites(&[start], weights)[0];
        let direction = [direction[0], direction[1], direction[2]];
        let found = params
            .caller()
            .reported(|_| Ok(Geodesics::new(&mesh)?.trace(start, direction, length)?))?;
        let how = match found.end {
            TraceEnd::Complete => CATA_TRACE_COMPLETE,
            TraceEnd::Boundary => CATA_TRACE_BOUNDARY,
            _ => CATA_TRACE_NON_MANIFOLD,
        };
        put(end, how);
        fill_slice(heading, &found.direction);
        hand_over(
            place,
            cata_path {
                vertices: Vec::new(),
                points: found.path.positions(&mesh),
                places: Some(found.path.points),
                length: found.path.length,
            },
        );
        Ok(())
    })
}

/// Finds the shortest path along edges from one vertex to another. Without a path, all sizes are 0,
/// and the length is INFINITY.
///
/// - `straight`: 1: the path is shortened, over faces, until it is straight but for vertices on the
///   boundary of the mesh, where it stays (Sharp and Crane 2020): a geodesic, which need not be the
///   shortest. The mesh must be a manifold whose faces agree about which side is outside. 0: the
///   path along edges.
/// - `params`: `progress` is used, the rest is only checked.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_distance_path(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    from: u32,
    to: u32,
    straight: i32,
    params: *const cata_distance_params,
    path: *mut *mut cata_path,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `path`, one
        // value), clause `structs` (`params`).
        let (mesh, params, place) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                read_or_zeros("params", params)?,
                output("path", path)?,
            )
        };
        let straight = flag("straight", straight)?;
        heat_options(&params)?;
        for (what, vertex) in [("from", from), ("to", to)] {
            if vertex as usize >= n_vertices {
                return Err(Failure::beyond(what, n_vertices, "n_vertices", vertex));
            }
        }
        let found = params.caller().reported(|_| {
            let found = along_edges(&mesh, from, to)?;
            if straight { straightened(&mesh, found) } else { Ok(found) }
        })?;
        hand_over(place, found);
        Ok(())
    })
}

/// Gets the numbers of vertices and of points of a path, and its length. NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_path_size(
    path: *const cata_path,
    n_vertices: *mut usize,
    n_points: *mut usize,
    length: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`n_vertices`, one value; `n_points`, one value; `length`, one
        // value), clause `handles` (`path`).
        unsafe {
            let own = known("path", path)?;
            tell! {
                n_vertices: own.vertices.len(),
                n_points: own.points.len(),
                length: own.length,
            }
        }
        Ok(())
    })
}

/// Gets a path; NULL where not wanted.
///
/// - `vertices`: n_vertices elements, written: those of the path along edges, both ends included;
///   of an exact path those that it was asked to lead through, none where it was asked for points.
/// - `points`: 3 n_points elements, written: where the path goes, the positions of `vertices`
///   unless it is straight.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_path_get(
    path: *const cata_path,
    vertices: *mut u32,
    points: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`vertices`, `own.vertices.len()` elements; `points`, 3 numbers a
        // point), clause `handles` (`path`).
        unsafe {
            let own = known("path", path)?;
            copy_wanted!(vertices: &own.vertices, points: own.points.as_flattened());
        }
        Ok(())
    })
}

/// Gets the points of a path of cata_distance_path_exact or cata_distance_trace as points of faces;
/// NULL where not wanted.
///
/// - `faces`: n_points elements, written.
/// - `weights`: 3 n_points elements, written: barycentric coordinates at the corners of faces.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_path_places(
    path: *const cata_path,
    faces: *mut u32,
    weights: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `handles` (`path`), clause `memory` (`faces`, one index a point;
        // `weights`, 3 numbers a point).
        unsafe {
            let own = known("path", path)?;
            let Some(places) = &own.places else {
                let why = "path: a path of cata_distance_path has no places, other than one of \
                           cata_distance_path_exact or cata_distance_trace";
                return Err(Failure::new(CATA_ERR_ARGUMENT, why));
            };
            let of_faces: Vec<u32> = places.iter().map(|place| place.face).collect();
            let all: Vec<[f64; 3]> = places.iter().map(|place| place.weights).collect();
            copy_wanted!(faces: &of_faces, weights: all.as_flattened());
        }
        Ok(())
    })
}

/// Frees a path.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_path_free(path: *mut cata_path) {
    // SAFETY: clause `handles` (`path`).
    unsafe { free(path) };
}

/// Returns vertices, or, with barycentric coordinates, points of faces.
fn sites(of: &[u32], weights: Option<&[f64]>) -> Vec<Site> {
    let Some(weights) = weights else {
        return of.iter().copied().map(Site::Vertex).collect();
    };
    let points = of.iter().zip(weights.as_chunks().0);
    let site = |(&face, &weights): (&u32, &[f64; 3])| match face {
        CATA_IN_SPACE => Site::Near(weights),
        face => Site::Face(SurfacePoint { face, weights }),
    };
    points.map(site).collect()
}

/// Returns the options of the caller for the heat method.
pub(super) fn heat_options(params: &cata_distance_params) -> Result<HeatOptions, Failure> {
    let kind = match params.flow {
        CATA_FLOW_TUFTED => LaplacianKind::Tufted,
        CATA_FLOW_INTRINSIC_DELAUNAY => LaplacianKind::IntrinsicDelaunay,
        CATA_FLOW_COTANGENT => LaplacianKind::Cotangent,
        other => return Err(Failure::argument("params.flow", "a CATA_FLOW_* value", other)),
    };
    let options = HeatOptions::new().kind(kind).par(params.par());
    Ok(if params.time == 0.0 { options } else { options.time(params.time) })
}

fn along_edges(mesh: &TriMesh, from: u32, to: u32) -> Result<cata_path, Failure> {
    let graph = Graph::of_mesh(mesh);
    let mut search = Dijkstra::new(&graph);
    let limits = SearchLimits { targets: &[to], ..SearchLimits::default() };
    search.search(&[(from, 0.0)], &limits)?;
    let vertices = search.path(to);
    let points = vertices.iter().map(|&v| mesh.vertices()[v as usize]).collect();
    Ok(cata_path { vertices, points, places: None, length: search.distance(to) })
}

/// Returns the path as a geodesic between its ends.
fn straightened(mesh: &TriMesh, path: cata_path) -> Result<cata_path, Failure> {
    let (Some(&from), Some(&to)) = (path.vertices.first(), path.vertices.last()) else {
        return Ok(path);
    };
    let most = JOINTS * path.vertices.len();
    let curve = Curve {
        order: Vec::new(),
        path: path.vertices.clone(),
        points: path.points.clone(),
        waypoints: path.vertices.iter().map(|&v| Waypoint::Vertex(v)).collect(),
        closed: false,
        length: path.length,
    };
    let mut found = smooth(mesh, &[curve], &[from, to], most)?;
    if !found.converged {
        let why = format!("path: not straight after {most} joints were shortened");
        return Err(Failure::new(CATA_ERR_NOT_CONVERGED, why));
    }
    match (found.points.pop(), found.lengths.pop()) {
        (Some(points), Some(length)) => Ok(cata_path { points, length, ..path }),
        _ => Ok(path),
    }
}
