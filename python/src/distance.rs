//! Distances on meshes.

use catamaran_geometry::mesh::{Dijkstra, Graph, HeatMethod, HeatOptions, SearchLimits};
use pyo3::prelude::*;

use crate::array::{from_rows, from_vec};
use crate::error::refused;
use crate::mesh::{mesh, numbers};
use crate::options::{Threads, laplacian_kind, par, vertex, vertices, word};
use crate::task::{Length, run};

/// The distance of each vertex from the nearest source, by the heat method or along edges; see
/// `catamaran.distances`.
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
    let is_heat = word("method", method, &[("heat", true), ("edges", false)])?;
    let options = HeatOptions::new().time(time).kind(laplacian_kind(kind)?).par(par(threads)?);
    let (mesh, sources) = (mesh(v, f)?, vertices("sources", sources)?);
    let found = run(py, Length::Long, progress, move |_| {
        if is_heat {
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
