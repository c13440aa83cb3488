//! Eigenpairs of Laplacians and of other sparse pencils.

use catamaran::base::Progress;
use catamaran::faer::Mat;
use catamaran::sparse::{
    CsMat, CsMatView, EigenOptions, Mass, count_below as below, eigs, eigs_sliced, eigs_two_level,
    free_components, select,
};
use catamaran::{Error, Par};
use catamaran_geometry::mesh::{free_components as free_components_on, laplacian};
#[cfg(not(feature = "mpi"))]
use pyo3::exceptions::PyNotImplementedError;
use pyo3::prelude::*;

use crate::array::{from_matrix, from_vec};
use crate::error::{raised, refused};
use crate::options::{Threads, arguments, laplacian as laplacian_options, limits, par};
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
        /// A matrix by rows, whose columns span the space that pairs are sought in.
        prolongation: Option<Py<PyAny>>,
        /// Bytes for a slice, and what takes slices.
        memory: Option<usize>,
        sink: Option<Py<PyAny>>,
        threads: Threads,
    }
}

/// How pairs are found, and where they go.
enum Way {
    Whole,
    Coarse(CsMat<f64>),
    Slices(usize, Py<PyAny>),
}

/// Gives the pairs of a slice to a function of Python.
fn give(sink: &Py<PyAny>, values: &[f64], vectors: &Mat<f64>) -> catamaran::Result<()> {
    let given = Python::try_attach(|py| -> PyResult<()> {
        let vectors = from_matrix(py, vectors.as_ref())?;
        sink.call1(py, (from_vec(py, values.to_vec()), vectors))?;
        Ok(())
    });
    // Without an interpreter nobody takes them.
    given.unwrap_or(Ok(())).map_err(raised)
}

impl Search {
    fn way(&self, py: Python<'_>) -> PyResult<Way> {
        Ok(match (&self.prolongation, self.memory, &self.sink) {
            (None, None, None) => Way::Whole,
            (Some(weights), None, None) => {
                let weights = weights.bind(py).extract::<Csr<'_>>()?;
                Way::Coarse(weights.matrix("prolongation")?.to_matrix()?)
            }
            (None, Some(memory), Some(sink)) => Way::Slices(memory, sink.clone_ref(py)),
            (Some(_), ..) => {
                return Err(refused("prolongation", "not together with memory and sink"));
            }
            _ => return Err(refused("memory", "together with sink, which takes the slices")),
        })
    }

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

    /// Values and vectors, which `extend` brings to the rows of the caller; no vectors where they
    /// went to a sink.
    fn pairs(
        &self,
        (stiffness, mass): (CsMatView<'_, f64>, &Mass),
        way: &Way,
        par: Par,
        progress: Progress<'_>,
        extend: impl Fn(Mat<f64>) -> catamaran::Result<Mat<f64>>,
    ) -> catamaran::Result<(Vec<f64>, Mat<f64>)> {
        let options = self.options(par, progress);
        let found = match way {
            Way::Whole => eigs(stiffness, mass, &options)?,
            Way::Coarse(weights) => eigs_two_level(stiffness, mass, weights.view(), &options)?,
            Way::Slices(memory, sink) => {
                let mut values = Vec::new();
                eigs_sliced(stiffness, mass, &options, *memory, |slice| {
                    give(sink, &slice.values, &extend(slice.vectors)?)?;
                    values.extend(slice.values);
                    Ok(())
                })?;
                return Ok((values, extend(Mat::zeros(stiffness.rows(), 0))?));
            }
        };
        Ok((found.values, extend(found.vectors)?))
    }
}

/// Values, vectors.
type Pairs<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>);

fn arrays(py: Python<'_>, (values, vectors): (Vec<f64>, Mat<f64>)) -> PyResult<Pairs<'_>> {
    Ok((from_vec(py, values).into_any(), from_matrix(py, vectors.as_ref())?.into_any()))
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
    let (mut way, surface) = (search.way(py)?, Surface::new(v, f, weld)?);
    options.boundary = surface.boundary(options.boundary);
    if let Way::Coarse(weights) = &way
        && weights.rows() != surface.vertices()
    {
        let (n, rows) = (surface.vertices(), weights.rows());
        let why = format_args!("expected a row for each of {n} vertices, got {rows}");
        return Err(refused("prolongation", why));
    }
    let (pairs, pieces) = run(py, Length::Long, progress, move |progress| {
        let found = laplacian(&surface.mesh, &options)?;
        if let Way::Coarse(weights) = &mut way {
            *weights = of_rows(weights, &found.kept, surface.firsts());
        }
        let extend = |mut vectors: Mat<f64>| -> catamaran::Result<Mat<f64>> {
            if found.kept.len() < found.vertices {
                vectors = found.extend(vectors.as_ref())?;
            }
            Ok(surface.extend(vectors))
        };
        let pencil = (found.stiffness.view(), &found.mass);
        let pairs = search.pairs(pencil, &way, par, progress, extend)?;
        Ok::<_, Error>((pairs, surface.pieces(&options.boundary)?))
    })?;
    Ok((arrays(py, pairs)?, pieces))
}

/// Returns the rows of a prolongation that belong to the rows of the matrices: `kept` vertices of
/// the mesh, which are the `firsts` of the caller.
fn of_rows(weights: &CsMat<f64>, kept: &[usize], firsts: impl Fn(usize) -> usize) -> CsMat<f64> {
    let rows: Vec<usize> = kept.iter().map(|&v| firsts(v)).collect();
    let all: Vec<Option<usize>> = (0..weights.cols()).map(Some).collect();
    select(weights.view(), &rows, &all, all.len())
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
    let (par, way) = (par(search.threads)?, search.way(py)?);
    let a = a.matrix("a")?.to_matrix()?;
    let mass = mass_of(mass, a.rows())?;
    let (pairs, free) = run(py, Length::Long, progress, move |progress| {
        let pairs = search.pairs((a.view(), &mass), &way, par, progress, Ok)?;
        Ok::<_, Error>((pairs, free_components(a.view(), &mass)?))
    })?;
    Ok((arrays(py, pairs)?, free))
}

/// Returns the number of eigenvalues of a sparse symmetric matrix below a value; see
/// `catamaran.count_below`.
#[pyfunction]
#[pyo3(signature = (a, mass, value))]
pub fn count_below_sparse<'py>(
    py: Python<'py>,
    a: Csr<'py>,
    mass: Option<&Bound<'py, PyAny>>,
    value: f64,
) -> PyResult<usize> {
    let a = a.matrix("a")?.to_matrix()?;
    let mass = mass_of(mass, a.rows())?;
    run(py, Length::Long, None, move |_| below(a.view(), &mass, value))
}

/// Returns the number of eigenvalues of the Laplacian of a mesh below a value; see
/// `catamaran.count_below`.
#[pyfunction]
#[pyo3(signature = (v, f, kind, mass, boundary, weld, threads, value))]
pub fn count_below_mesh<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    kind: &str,
    mass: &str,
    boundary: &Bound<'py, PyAny>,
    weld: bool,
    threads: Threads,
    value: f64,
) -> PyResult<usize> {
    let mut options = laplacian_options(kind, mass, boundary, par(threads)?)?;
    let surface = Surface::new(v, f, weld)?;
    options.boundary = surface.boundary(options.boundary);
    run(py, Length::Long, None, move |_| {
        let found = laplacian(&surface.mesh, &options)?;
        below(found.stiffness.view(), &found.mass, value)
    })
}

/// Returns the number of components of the graph of a matrix whose rows sum to zero; see
/// `catamaran.free_components`.
#[pyfunction]
#[pyo3(signature = (a, mass))]
pub fn free_components_sparse<'py>(
    py: Python<'py>,
    a: Csr<'py>,
    mass: Option<&Bound<'py, PyAny>>,
) -> PyResult<usize> {
    let a = a.matrix("a")?.to_matrix()?;
    let mass = mass_of(mass, a.rows())?;
    run(py, Length::Long, None, move |_| free_components(a.view(), &mass))
}

/// Returns the number of components of a mesh without a vertex held at zero; see
/// `catamaran.free_components`.
#[pyfunction]
#[pyo3(signature = (v, f, boundary, weld))]
pub fn free_components_mesh<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    boundary: &Bound<'py, PyAny>,
    weld: bool,
) -> PyResult<usize> {
    let surface = Surface::new(v, f, weld)?;
    let boundary = surface.boundary(limits(boundary)?);
    run(py, Length::Long, None, move |_| free_components_on(&surface.mesh, &boundary))
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
    arrays(py, (pairs.values, pairs.vectors))
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
