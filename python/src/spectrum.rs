//! Eigenpairs of Laplacians and of other sparse pencils.

use catamaran::base::Progress;
use catamaran::mesh::laplacian;
use catamaran::sparse::{CsMatView, EigenOptions, Eigenpairs, Mass, eigs};
use catamaran::{Error, Par};
use pyo3::prelude::*;

use crate::array::{from_matrix, from_vec};
use crate::mesh::mesh;
use crate::options::{laplacian as laplacian_options, par};
use crate::sparse::{Csr, mass as mass_of};
use crate::task::{Length, run};

/// How eigenpairs are computed, as a dictionary.
#[derive(FromPyObject)]
pub struct Search {
    #[pyo3(item)]
    k: usize,
    #[pyo3(item)]
    sigma: Option<f64>,
    #[pyo3(item)]
    tol: f64,
    #[pyo3(item)]
    verify_count: bool,
    #[pyo3(item)]
    seed: u64,
    #[pyo3(item)]
    threads: Option<i64>,
}

impl Search {
    fn pairs(
        &self,
        stiffness: CsMatView<'_, f64>,
        mass: &Mass,
        par: Par,
        progress: Progress<'_>,
    ) -> catamaran::Result<Eigenpairs> {
        let options = EigenOptions::new()
            .k(self.k)
            .shift(self.sigma)
            .tolerance(self.tol)
            .verify_count(self.verify_count)
            .seed(self.seed)
            .par(par)
            .progress(progress);
        eigs(stiffness, mass, &options)
    }
}

/// Values, vectors, residuals.
type Pairs<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>);

fn arrays(py: Python<'_>, pairs: Eigenpairs) -> PyResult<Pairs<'_>> {
    Ok((
        from_vec(py, pairs.values).into_any(),
        from_matrix(py, pairs.vectors.as_ref())?.into_any(),
        from_vec(py, pairs.residuals).into_any(),
    ))
}

/// Eigenpairs of the Laplacian of a mesh; see `catamaran.eigsh`.
#[pyfunction]
#[pyo3(signature = (v, f, search, kind, mass, boundary, progress))]
pub fn eigsh<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    search: Search,
    kind: &str,
    mass: &str,
    boundary: &Bound<'py, PyAny>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Pairs<'py>> {
    let par = par(search.threads)?;
    let options = laplacian_options(kind, mass, boundary, par)?;
    let mesh = mesh(v, f)?;
    let pairs = run(py, Length::Long, progress, move |progress| {
        let found = laplacian(&mesh, &options)?;
        let mut pairs = search.pairs(found.stiffness.view(), &found.mass, par, progress)?;
        if found.kept.len() < found.vertices {
            pairs.vectors = found.extend(pairs.vectors.as_ref())?;
        }
        Ok::<_, Error>(pairs)
    })?;
    arrays(py, pairs)
}

/// Eigenpairs of a sparse symmetric matrix; see `catamaran.eigsh`.
#[pyfunction]
#[pyo3(signature = (a, mass, search, progress))]
pub fn eigsh_sparse<'py>(
    py: Python<'py>,
    a: Csr<'py>,
    mass: Option<&Bound<'py, PyAny>>,
    search: Search,
    progress: Option<Py<PyAny>>,
) -> PyResult<Pairs<'py>> {
    let par = par(search.threads)?;
    let a = a.matrix("a")?.to_matrix()?;
    let mass = mass_of(mass, a.rows())?;
    let pairs = run(py, Length::Long, progress, move |progress| {
        search.pairs(a.view(), &mass, par, progress)
    })?;
    arrays(py, pairs)
}
