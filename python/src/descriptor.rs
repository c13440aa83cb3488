//! Descriptors that are computed from the mesh.

use catamaran_geometry::spectral::descriptors::{
    RingOptions, ShotOptions, geodesic_rings as means, shot as histograms,
};
use pyo3::prelude::*;

use crate::array::{Array, from_matrix};
use crate::mesh::mesh;
use crate::options::{Threads, par};
use crate::task::{Length, run};

/// Histograms of normals; see `catamaran.shot`.
#[pyfunction]
#[pyo3(signature = (v, f, radius, threads, progress))]
pub fn shot<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    radius: f64,
    threads: Threads,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (mesh, par) = (mesh(v, f)?, par(threads)?);
    let found = run(py, Length::Long, progress, move |progress| {
        histograms(&mesh, &ShotOptions::new(radius).par(par).progress(progress))
    })?;
    Ok(from_matrix(py, found.as_ref())?.into_any())
}

/// Means of functions over rings; see `catamaran.geodesic_rings`.
#[pyfunction]
#[pyo3(signature = (v, f, functions, radius, rings, threads, progress))]
pub fn geodesic_rings<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    functions: &Bound<'py, PyAny>,
    radius: f64,
    rings: usize,
    threads: Threads,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (mesh, par) = (mesh(v, f)?, par(threads)?);
    let functions = Array::<f64>::new("functions", functions, &[1, 2])?;
    let view = functions.view();
    let found = run(py, Length::Long, progress, move |progress| {
        means(&mesh, view, &RingOptions::new(radius, rings).par(par).progress(progress))
    })?;
    Ok(from_matrix(py, found.as_ref())?.into_any())
}
