//! Decimation and farthest points.

use catamaran_geometry::decimate::{
    DecimateOptions, FarthestPoints, Method, decimate as reduce, decimate_within,
};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::array::{from_rows, from_vec};
use crate::mesh::{arrays, first_vertex, mesh, numbers};
use crate::options::{Threads, arguments, par, vertex, word};
use crate::sparse::{Parts, parts};
use crate::task::{Length, run};

arguments! {
    /// How a mesh is decimated, as a dictionary.
    pub struct How {
        method: String,
        resample: bool,
        lloyd: usize,
        relaxation: usize,
        uniform: bool,
        cut_narrow_handles: bool,
        first: Option<i64>,
        locked: Vec<i64>,
        density: Vec<f64>,
        curvature: f64,
        threads: Threads,
    }
}

/// Vertices, faces, the face of the input at each vertex, its weights there, the matrix from
/// functions on the result to functions on the input, and the number of lost edges between locked
/// vertices.
type Decimated<'py> =
    (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>, Parts<'py>, usize);

/// The size of the result.
enum Size {
    Vertices(usize),
    /// Largest distance of the surfaces.
    Within(f64),
}

/// Implements `catamaran.decimate`.
#[pyfunction]
#[pyo3(signature = (v, f, n, error, how, progress))]
pub fn decimate<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    n: Option<usize>,
    error: Option<f64>,
    how: How,
    progress: Option<Py<PyAny>>,
) -> PyResult<Decimated<'py>> {
    let size = match (n, error) {
        (Some(n), None) => Size::Vertices(n),
        (None, Some(error)) => Size::Within(error),
        _ => return Err(PyTypeError::new_err("decimate: either n or error is needed")),
    };
    let method =
        word("method", &how.method, &[("uniform", Method::Uniform), ("thesis", Method::Thesis)])?;
    let locked = how.locked.iter().map(|&v| vertex("locked", v)).collect::<PyResult<Vec<_>>>()?;
    let (par, first, mesh) = (par(how.threads)?, first_vertex(how.first)?, mesh(v, f)?);
    let (found, weights) = run(py, Length::Long, progress, move |progress| {
        let options = DecimateOptions::new()
            .method(method)
            .resample(how.resample)
            .lloyd(how.lloyd)
            .relaxation(how.relaxation)
            .uniform(how.uniform)
            .cut_narrow_handles(how.cut_narrow_handles)
            .first(first)
            .locked(&locked)
            .density(&how.density)
            .curvature(how.curvature)
            .par(par)
            .progress(progress);
        let found = match size {
            Size::Vertices(n) => reduce(&mesh, n, &options)?,
            Size::Within(error) => decimate_within(&mesh, error, &options)?,
        };
        let weights = found.weights(&mesh, par)?;
        Ok((found, weights))
    })?;
    let of_faces = numbers(py, found.places.iter().map(|place| place.face));
    let inside = found.places.iter().map(|place| place.weights).collect();
    let lost = found.lost_edges;
    let (v, f) = arrays(py, found.mesh)?;
    let inside = from_rows(py, inside)?.into_any();
    Ok((v, f, of_faces, inside, parts(py, weights), lost))
}

/// Returns samples, the nearest sample of each vertex (-1 without), and its distance; see
/// `catamaran.farthest_points`.
#[pyfunction]
#[pyo3(signature = (v, f, n, first, progress))]
pub fn farthest_points<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    n: usize,
    first: Option<i64>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let (first, mesh) = (first_vertex(first)?, mesh(v, f)?);
    let (samples, cells) = run(py, Length::Long, progress, move |progress| {
        let mut points = FarthestPoints::new(&mesh, first)?;
        points.extend_to(n, progress)?;
        Ok((points.samples().to_vec(), points.cells()))
    })?;
    let number = |&v: &u32| if v == u32::MAX { -1 } else { i64::from(v) };
    Ok((
        from_vec(py, samples.iter().map(number).collect::<Vec<_>>()).into_any(),
        from_vec(py, cells.of_vertices().iter().map(number).collect::<Vec<_>>()).into_any(),
        from_vec(py, cells.lengths()).into_any(),
    ))
}
