//! Distances on meshes.

use catamaran_geometry::mesh::{
    Dijkstra, GeodesicPath, Geodesics, Graph, HeatMethod, HeatOptions, SearchLimits, Site,
    SurfacePoint, TraceEnd,
};
use pyo3::prelude::*;

use crate::array::{from_rows, from_vec};
use crate::error::refused;
use crate::mesh::{mesh, numbers, positions};
use crate::options::{Threads, face, faces, laplacian_kind, par, vertex, vertices, word};
use crate::task::{Length, run};

#[derive(Clone, Copy)]
enum Method {
    Heat,
    Exact,
    Edges,
}

/// Points of a mesh: vertices, or, with barycentric coordinates, points of faces.
fn sites(
    name: &str,
    points: &Bound<'_, PyAny>,
    weights: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<Site>> {
    let Some(weights) = weights else {
        return Ok(vertices(name, points)?.into_iter().map(Site::Vertex).collect());
    };
    let (faces, weights) = (faces(name, points)?, positions("weights", weights)?);
    if weights.len() != faces.len() {
        let why = format_args!("{} rows for {} faces ({name})", weights.len(), faces.len());
        return Err(refused("weights", why));
    }
    let points = faces.into_iter().zip(weights);
    Ok(points.map(|(face, weights)| Site::Face(SurfacePoint { face, weights })).collect())
}

/// Returns the distance of each vertex from the nearest source, by the heat method, exactly or
/// along edges; see `catamaran.distances`.
#[pyfunction]
#[pyo3(signature = (v, f, sources, weights, method, time, kind, threads, progress))]
pub fn distances<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    sources: &Bound<'py, PyAny>,
    weights: Option<&Bound<'py, PyAny>>,
    method: &str,
    time: f64,
    kind: &str,
    threads: Threads,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let methods = [("heat", Method::Heat), ("exact", Method::Exact), ("edges", Method::Edges)];
    let method = word("method", method, &methods)?;
    let options = HeatOptions::new().time(time).kind(laplacian_kind(kind)?).par(par(threads)?);
    let mesh = mesh(v, f)?;
    if let Method::Exact = method {
        let sources = sites("sources", sources, weights)?;
        let found =
            run(py, Length::Long, progress, move |_| Geodesics::new(&mesh)?.distances(&sources))?;
        return Ok(from_vec(py, found).into_any());
    }
    if weights.is_some() {
        return Err(refused("weights", "points of faces are for method=\"exact\""));
    }
    let sources = vertices("sources", sources)?;
    let found = run(py, Length::Long, progress, move |_| {
        if let Method::Heat = method {
            return HeatMethod::new(&mesh, &options)?.distances(&sources);
        }
        let graph = Graph::of_mesh(&mesh);
        let mut search = Dijkstra::new(&graph);
        let starts: Vec<(u32, f64)> = sources.iter().map(|&v| (v, 0.0)).collect();
        search.search(&starts, &SearchLimits::default())?;
        Ok(search.distances())
    })?;
    Ok(from_vec(py, found).into_any())
}

/// Returns the shortest path along edges between two vertices: its vertices, their positions, its
/// length.
#[pyfunction]
#[pyo3(signature = (v, f, start, end))]
pub fn shortest_path<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    start: i64,
    end: i64,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>, f64)> {
    let (mesh, start, end) = (mesh(v, f)?, vertex("start", start)?, vertex("end", end)?);
    for (name, end) in [("start", start), ("end", end)] {
        if end as usize >= mesh.vertices().len() {
            return Err(refused(name, format_args!("there is no vertex {end}")));
        }
    }
    let (path, points, length) = run(py, Length::Long, None, move |_| {
        let graph = Graph::of_mesh(&mesh);
        let mut search = Dijkstra::new(&graph);
        let limits = SearchLimits { targets: &[end], ..SearchLimits::default() };
        search.search(&[(start, 0.0)], &limits)?;
        let path = search.path(end);
        let points: Vec<[f64; 3]> = path.iter().map(|&v| mesh.vertices()[v as usize]).collect();
        Ok((path, points, search.distance(end)))
    })?;
    Ok((numbers(py, path), from_rows(py, points)?.into_any(), length))
}

/// Positions, faces, barycentric coordinates and the length of a path.
type Geodesic<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>, f64);

fn geodesic(
    py: Python<'_>,
    path: GeodesicPath,
    positions: Vec<[f64; 3]>,
) -> PyResult<Geodesic<'_>> {
    let weights: Vec<[f64; 3]> = path.points.iter().map(|point| point.weights).collect();
    let faces = numbers(py, path.points.iter().map(|point| point.face));
    let positions = from_rows(py, positions)?.into_any();
    Ok((positions, faces, from_rows(py, weights)?.into_any(), path.length))
}

/// Returns the shortest path over faces through points; see `catamaran.geodesic_path`.
#[pyfunction]
#[pyo3(signature = (v, f, through, weights, progress))]
pub fn geodesic_path<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    through: &Bound<'py, PyAny>,
    weights: Option<&Bound<'py, PyAny>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Geodesic<'py>> {
    let (mesh, through) = (mesh(v, f)?, sites("through", through, weights)?);
    let (path, positions) = run(py, Length::Long, progress, move |_| {
        let path = Geodesics::new(&mesh)?.path_through(&through)?;
        let positions = path.positions(&mesh);
        Ok((path, positions))
    })?;
    geodesic(py, path, positions)
}

/// Returns the geodesic from a point in a direction, how it ends, and its direction there; see
/// `catamaran.trace_geodesic`.
#[pyfunction]
#[pyo3(signature = (v, f, start, direction, length, weights, progress))]
pub fn trace_geodesic<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    start: i64,
    direction: [f64; 3],
    length: f64,
    weights: Option<[f64; 3]>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Geodesic<'py>, &'static str, Bound<'py, PyAny>)> {
    let mesh = mesh(v, f)?;
    let start = match weights {
        None => Site::Vertex(vertex("start", start)?),
        Some(weights) => Site::Face(SurfacePoint { face: face("start", start)?, weights }),
    };
    let (trace, positions) = run(py, Length::Long, progress, move |_| {
        let trace = Geodesics::new(&mesh)?.trace(start, direction, length)?;
        let positions = trace.path.positions(&mesh);
        Ok((trace, positions))
    })?;
    let end = match trace.end {
        TraceEnd::Complete => "complete",
        TraceEnd::Boundary => "boundary",
        _ => "non-manifold",
    };
    let direction = from_vec(py, trace.direction.to_vec()).into_any();
    Ok((geodesic(py, trace.path, positions)?, end, direction))
}
