//! Eigenpairs of Laplacians and of other sparse pencils.

use catamaran::base::Progress;
use catamaran::sparse::{CsMatView, EigenOptions, Eigenpairs, Mass, eigs, free_components};
use catamaran::{Error, Par};
use catamaran_geometry::mesh::laplacian;
#[cfg(not(feature = "mpi"))]
use pyo3::exceptions::PyNotImplementedError;
use pyo3::prelude::*;

use crate::array::{from_matrix, from_vec};
use crate::options::{Threads, arguments, laplacian as laplacian_options, par};
use crate::sparse::{Csr, mass as mass_of};
use crate::surface::{Pieces, Surface};
use crate::task::{Length, run};

arguments! {
    /// How eigenpairs are computed, as a dictionary.
    pub struct Search {
        k: usize,
        sigma: Option<f64>,
        tol: f64,
        verify_count: bool,
        seed: u64,
        threads: Threads,
    }
}

impl Search {
    fn options<'p>(&self, par: Par, progress: Progress<'p>) -> EigenOptions<'p> {
        EigenOptions::new()
            .k(self.k)
            .shift(self.sigma)
            .tolerance(self.tol)
            .verify_count(self.verify_count)
            .seed(self.seed)
            .par(par)
            .progress(progress)
    }

    fn pairs(
        &self,
        stiffness: CsMatView<'_, f64>,
        mass: &Mass,
        par: Par,
        progress: Progress<'_>,
    ) -> catamaran::Result<Eigenpairs> {
        eigs(stiffness, mass, &self.options(par, progress))
    }
}

/// Values, vectors.
type Pairs<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>);

fn arrays(py: Python<'_>, pairs: Eigenpairs) -> PyResult<Pairs<'_>> {
    let vectors = from_matrix(py, pairs.vectors.as_ref())?;
    Ok((from_vec(py, pairs.values).into_any(), vectors.into_any()))
}

/// Eigenpairs of the Laplacian of a mesh, and its components; see `catamaran.eigsh`.
#[pyfunction]
#[pyo3(signature = (v, f, search, kind, mass, boundary, weld, progress))]
pub fn eigsh<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    search: Search,
    kind: &str,
    mass: &str,
    boundary: &Bound<'py, PyAny>,
    weld: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Pairs<'py>, Pieces)> {
    let par = par(search.threads)?;
    let mut options = laplacian_options(kind, mass, boundary, par)?;
    let surface = Surface::new(v, f, weld)?;
    options.boundary = surface.boundary(options.boundary);
    let (pairs, pieces) = run(py, Length::Long, progress, move |progress| {
        let found = laplacian(&surface.mesh, &options)?;
        let mut pairs = search.pairs(found.stiffness.view(), &found.mass, par, progress)?;
        if found.kept.len() < found.vertices {
            pairs.vectors = found.extend(pairs.vectors.as_ref())?;
        }
        pairs.vectors = surface.extend(pairs.vectors);
        Ok::<_, Error>((pairs, surface.pieces(&options.boundary)?))
    })?;
    Ok((arrays(py, pairs)?, pieces))
}

/// Eigenpairs of a sparse symmetric matrix, and the number of components of its graph whose rows
/// sum to zero; see `catamaran.eigsh`.
#[pyfunction]
#[pyo3(signature = (a, mass, search, progress))]
pub fn eigsh_sparse<'py>(
    py: Python<'py>,
    a: Csr<'py>,
    mass: Option<&Bound<'py, PyAny>>,
    search: Search,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Pairs<'py>, usize)> {
    let par = par(search.threads)?;
    let a = a.matrix("a")?.to_matrix()?;
    let mass = mass_of(mass, a.rows())?;
    let (pairs, free) = run(py, Length::Long, progress, move |progress| {
        let pairs = search.pairs(a.view(), &mass, par, progress)?;
        Ok::<_, Error>((pairs, free_components(a.view(), &mass)?))
    })?;
    Ok((arrays(py, pairs)?, free))
}

/// Eigenpairs of a sparse symmetric matrix of which every rank of a communicator, named by its
/// Fortran handle, has some rows; see `catamaran.eigsh`. Vectors are those rows.
#[cfg(feature = "mpi")]
#[pyfunction]
#[pyo3(signature = (a, mass, search, comm))]
pub fn eigsh_ranks<'py>(
    py: Python<'py>,
    a: Csr<'py>,
    mass: Option<&Bound<'py, PyAny>>,
    search: Search,
    comm: i32,
) -> PyResult<Pairs<'py>> {
    let par = par(search.threads)?;
    let a = a.matrix("a")?.to_matrix()?;
    let mass = mass_of(mass, a.rows())?;
    // Short work stays on the thread of the caller, perhaps the only one that may call MPI.
    let pairs = run(py, Length::Short, None, move |progress| {
        let world = catamaran::ranks::World::from_fortran(comm)?;
        catamaran::ranks::eigs(&world, a.view(), &mass, &search.options(par, progress))
    })?;
    arrays(py, pairs)
}

/// Says that this package was built without MPI.
#[cfg(not(feature = "mpi"))]
#[pyfunction]
#[pyo3(signature = (a, mass, search, comm))]
pub fn eigsh_ranks(
    a: Csr<'_>,
    mass: Option<&Bound<'_, PyAny>>,
    search: Search,
    comm: i32,
) -> PyResult<()> {
    let _ = (a, mass, search, comm);
    let why = "comm: eigsh needs a package built with --features mpi";
    Err(PyNotImplementedError::new_err(why))
}
