//! Operators on functions: the Laplacian of a point cloud, gradient and divergence, energies.

use catamaran_geometry::mesh::{
    CloudOptions, cloud_laplacian as assemble, divergence, gradient as of_functions,
};
use catamaran_geometry::spectral::dirichlet_energies as energies;
use pyo3::prelude::*;

use crate::array::{Array, from_vec};
use crate::mesh::{mesh, positions};
use crate::options::{Threads, limits, par};
use crate::sparse::{Csr, Parts, mass as mass_of, mass_parts, parts};
use crate::task::{Length, run};

/// Returns stiffness, mass and the points of their rows; see `catamaran.cloud_laplacian`.
#[pyfunction]
#[pyo3(signature = (points, neighbours, boundary, threads, progress))]
pub fn cloud_laplacian<'py>(
    py: Python<'py>,
    points: &Bound<'py, PyAny>,
    neighbours: usize,
    boundary: &Bound<'py, PyAny>,
    threads: Threads,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Parts<'py>, Parts<'py>, Bound<'py, PyAny>)> {
    let points = positions("points", points)?;
    let options =
        CloudOptions::new().neighbours(neighbours).boundary(limits(boundary)?).par(par(threads)?);
    let found = run(py, Length::Long, progress, move |_| assemble(&points, &options))?;
    let kept: Vec<i64> = found.kept.iter().map(|&point| point as i64).collect();
    Ok((parts(py, found.stiffness), mass_parts(py, found.mass), from_vec(py, kept).into_any()))
}

/// Returns the gradient, or the divergence, as a matrix; see `catamaran.gradient`.
#[pyfunction]
#[pyo3(signature = (v, f, diverges))]
pub fn gradient<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    diverges: bool,
) -> PyResult<Parts<'py>> {
    let mesh = mesh(v, f)?;
    let found = run(py, Length::Long, None, move |_| match diverges {
        true => divergence(&mesh),
        false => of_functions(&mesh),
    })?;
    Ok(parts(py, found))
}

/// Returns the energy of each function; see `catamaran.dirichlet_energies`.
#[pyfunction]
#[pyo3(signature = (functions, stiffness, mass))]
pub fn dirichlet_energies<'py>(
    py: Python<'py>,
    functions: &Bound<'py, PyAny>,
    stiffness: Csr<'py>,
    mass: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let functions = Array::<f64>::new("functions", functions, &[1, 2])?;
    let stiffness = stiffness.matrix("stiffness")?.to_matrix()?;
    let mass = mass_of(mass, stiffness.rows())?;
    let view = functions.view();
    let found = run(py, Length::Long, None, move |_| energies(view, stiffness.view(), &mass))?;
    Ok(from_vec(py, found).into_any())
}
