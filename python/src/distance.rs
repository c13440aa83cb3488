//! Distances on meshes.

use catamaran_geometry::mesh::{Dijkstra, Geodesics, Graph, HeatMethod, HeatOptions, SearchLimits};
use pyo3::prelude::*;

use crate::array::{from_rows, from_vec};
use crate::error::refused;
use crate::mesh::{mesh, numbers};
use crate::options::{Threads, laplacian_kind, par, vertex, vertices, word};
use crate::task::{Length, run};

#[derive(Clone, Copy)]
enum Method {
    Heat,
    Exact,
    Edges,
}

/// The distance of each vertex from the nearest source, by the heat method, exactly or along edges;
/// see `catamaran.distances`.
#[pyfunction]
#[pyo3(signature = (v, f, sources, method, time, kind, threads, progress))]
pub fn distances<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    sources: &Bound<'py, PyAny>,
    method: &str,
    time: f64,
    kind: &str,
    threads: Threads,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let methods = [("heat", Method::Heat), ("exact", Method::Exact), ("edges", Method::Edges)];
    let method = word("method", method, &methods)?;
    let options = HeatOptions::new().time(time).kind(laplacian_kind(kind)?).par(par(threads)?);
    let (mesh, sources) = (mesh(v, f)?, vertices("sources", sources)?);
    let found = run(py, Length::Long, progress, move |_| {
        match method {
            Method::Heat => return HeatMethod::new(&mesh, &options)?.distances(&sources),
            Method::Exact => return Geodesics::new(&mesh)?.distances(&sources),
            Method::Edges => {}
        }
        let graph = Graph::of_mesh(&mesh);
        let mut search = Dijkstra::new(&graph);
        let starts: Vec<(u32, f64)> = sources.iter().map(|&v| (v, 0.0)).collect();
        search.search(&starts, &SearchLimits::default())?;
        Ok(search.distances())
    })?;
    Ok(from_vec(py, found).into_any())
}

/// The shortest path along edges between two vertices: its vertices, their positions, its length.
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

/// The shortest path over faces through vertices; see `catamaran.geodesic_path`.
#[pyfunction]
#[pyo3(signature = (v, f, through, progress))]
pub fn geodesic_path<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    through: &Bound<'py, PyAny>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Geodesic<'py>> {
    let (mesh, through) = (mesh(v, f)?, vertices("through", through)?);
    if through.len() < 2 {
        let got = through.len();
        return Err(refused("through", format_args!("at least two are needed, got {got}")));
    }
    if let Some(beyond) = through.iter().find(|&&v| v as usize >= mesh.vertices().len()) {
        return Err(refused("through", format_args!("there is no vertex {beyond}")));
    }
    let (path, positions) = run(py, Length::Long, progress, move |_| {
        let (from, others) = through.split_at(1);
        let path = Geodesics::new(&mesh)?.path_through(from, others)?;
        let positions = path.positions(&mesh);
        Ok((path, positions))
    })?;
    let weights: Vec<[f64; 3]> = path.points.iter().map(|point| point.weights).collect();
    let faces = numbers(py, path.points.iter().map(|point| point.face));
    let positions = from_rows(py, positions)?.into_any();
    Ok((positions, faces, from_rows(py, weights)?.into_any(), path.length))
}
