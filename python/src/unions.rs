//! Signatures of shapes, and spectra of unions of parts.

use std::io::Write as _;
use std::path::PathBuf;

use catamaran::base::FloatEnv;
use catamaran::io::{Output, Overwrite};
use catamaran_geometry::mesh::{Boundary, LaplacianOptions};
use catamaran_geometry::unions::{
    K, MetricOptions, PartSpectra, RetrievalMetric, ShapeDnaOptions, SpectralUnion, interpolate,
    shape_dna as signature,
};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::array::{Array, from_matrix, from_vec};
use crate::error::exception;
use crate::mesh::mesh;
use crate::options::{Threads, laplacian_kind, par};
use crate::surface::{Pieces, Surface};
use crate::task::{Length, run};

/// Returns a signature, and the components of the mesh; see `catamaran.shape_dna`.
#[pyfunction]
#[pyo3(signature = (v, f, k, normalized, kind, weld, threads, progress))]
pub fn shape_dna<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    k: usize,
    normalized: bool,
    kind: &str,
    weld: bool,
    threads: Threads,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyAny>, Pieces)> {
    let laplacian = LaplacianOptions::new().kind(laplacian_kind(kind)?).par(par(threads)?);
    let surface = Surface::new(v, f, weld)?;
    let options = ShapeDnaOptions::new().k(k).normalized(normalized).laplacian(laplacian);
    let (found, pieces) = run(py, Length::Long, progress, move |progress| {
        let pieces = surface.pieces(&options.laplacian.boundary)?;
        Ok::<_, catamaran::Error>((signature(&surface.mesh, &options.progress(progress))?, pieces))
    })?;
    Ok((from_vec(py, found).into_any(), pieces))
}

/// A metric for retrieval; see `catamaran.RetrievalMetric`.
#[pyclass(frozen, module = "catamaran._catamaran")]
pub struct MetricHandle {
    metric: RetrievalMetric,
}

/// Returns the rows of a matrix.
fn rows(name: &str, object: &Bound<'_, PyAny>) -> PyResult<Vec<Vec<f64>>> {
    let array = Array::<f64>::new(name, object, &[2])?;
    let view = array.view();
    let row = |i: usize| (0..view.ncols()).map(|j| view[(i, j)]).collect();
    Ok((0..view.nrows()).map(row).collect())
}

#[pymethods]
impl MetricHandle {
    #[new]
    #[pyo3(signature = (
        spectra, identities, errors, zeros, scale_free, shrinkage, poses_only, spectrum
    ))]
    fn new(
        py: Python<'_>,
        spectra: &Bound<'_, PyAny>,
        identities: Vec<usize>,
        errors: Option<&Bound<'_, PyAny>>,
        zeros: usize,
        scale_free: bool,
        shrinkage: f64,
        poses_only: bool,
        spectrum: String,
    ) -> PyResult<Self> {
        let spectra = rows("spectra", spectra)?;
        let errors = errors.map(|errors| rows("errors", errors)).transpose()?.unwrap_or_default();
        let options = MetricOptions::new()
            .zeros(zeros)
            .scale_free(scale_free)
            .shrinkage(shrinkage)
            .poses_only(poses_only)
            .spectrum(spectrum);
        let metric = run(py, Length::Long, None, move |_| {
            RetrievalMetric::fit(&spectra, &identities, &errors, &options)
        })?;
        Ok(Self { metric })
    }

    /// Returns the metric of the bytes of a file.
    #[staticmethod]
    fn from_bytes(content: &[u8]) -> PyResult<Self> {
        let metric = RetrievalMetric::from_bytes(content).map_err(exception)?;
        Ok(Self { metric })
    }

    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Self> {
        let metric = RetrievalMetric::read(&path).map_err(exception)?;
        Ok(Self { metric })
    }

    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &self.metric.to_bytes().map_err(exception)?))
    }

    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let metric = &self.metric;
        run(py, Length::Long, None, move |_| {
            let mut output = Output::create(&path, Overwrite::Replace)?;
            output.write_all(&metric.to_bytes()?).map_err(|e| output.error(e))?;
            output.commit()
        })
    }

    /// Returns a row of distances for each query.
    fn distances<'py>(
        &self,
        py: Python<'py>,
        queries: &Bound<'py, PyAny>,
        shapes: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (metric, queries, shapes) =
            (&self.metric, rows("queries", queries)?, rows("shapes", shapes)?);
        let found = run(py, Length::Long, None, move |_| metric.distances(&queries, &shapes))?;
        Ok(from_matrix(py, found.as_ref())?.into_any())
    }

    #[getter]
    fn k(&self) -> usize {
        self.metric.k()
    }

    #[getter]
    fn spectrum(&self) -> &str {
        self.metric.spectrum()
    }
}

/// A part: its spectrum, or the mesh that it is of.
enum Part {
    Spectrum(Vec<f64>),
    Mesh(Surface),
}

impl Part {
    fn new(object: &Bound<'_, PyAny>, weld: bool) -> PyResult<Self> {
        if let Ok((v, f)) = object.extract::<(Bound<'_, PyAny>, Bound<'_, PyAny>)>()
            && v.len().is_ok()
        {
            return Ok(Self::Mesh(Surface::new(&v, &f, weld)?));
        }
        let values = Array::<f64>::new("parts", object, &[1])?;
        Ok(Self::Spectrum(values.entries().into_owned()))
    }

    /// Returns the spectrum of part `i`, and the components of its mesh.
    fn spectrum(self, i: usize) -> catamaran::Result<(Vec<f64>, Option<Pieces>)> {
        let surface = match self {
            Self::Spectrum(values) => return Ok((values, None)),
            Self::Mesh(surface) => surface,
        };
        let pieces = surface.pieces(&Boundary::Dirichlet)?;
        let (_, closed, ..) = pieces;
        if closed > 0 {
            let what = "a component is closed: each component of a part needs a boundary";
            let element = format!("part {i}");
            return Err(catamaran::Error::Mesh { what: what.into(), element });
        }
        let all = vec![true; surface.mesh.vertices().len()];
        let spectra = PartSpectra::new(&surface.mesh, &LaplacianOptions::default())?;
        Ok((spectra.dirichlet(&all, K)?, Some(pieces)))
    }
}

/// Parts as they come.
fn read_parts(parts: &[Bound<'_, PyAny>], weld: bool) -> PyResult<Vec<Part>> {
    parts.iter().map(|part| Part::new(part, weld)).collect()
}

/// The spectra of parts, and the components of those that are meshes.
type Spectra = (Vec<Vec<f64>>, Vec<Option<Pieces>>);

/// Computes them.
fn spectra(parts: Vec<Part>) -> catamaran::Result<Spectra> {
    let found = (0..).zip(parts).map(|(i, part)| part.spectrum(i));
    let found: Vec<_> = found.collect::<catamaran::Result<_>>()?;
    Ok(found.into_iter().unzip())
}

/// Returns the network of a file, or that of the library.
fn network(path: Option<PathBuf>) -> catamaran::Result<SpectralUnion> {
    match path {
        Some(path) => SpectralUnion::read(&path),
        None => SpectralUnion::pretrained(),
    }
}

/// The spectrum of the union, those of the parts, the components of the parts that are meshes, and
/// how unlike the training the parts are.
type Union<'py> = (Bound<'py, PyAny>, Vec<Bound<'py, PyAny>>, Vec<Option<Pieces>>, f64);

/// Returns the spectrum of a union; see `catamaran.union_spectrum`.
#[pyfunction]
#[pyo3(signature = (parts, model, weld, progress))]
pub fn union_spectrum<'py>(
    py: Python<'py>,
    parts: Vec<Bound<'py, PyAny>>,
    model: Option<PathBuf>,
    weld: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<Union<'py>> {
    let parts = read_parts(&parts, weld)?;
    let (union, spectra, pieces, ood_score) = run(py, Length::Long, progress, move |_| {
        let (model, (spectra, pieces)) = (network(model)?, spectra(parts)?);
        let views: Vec<&[f64]> = spectra.iter().map(Vec::as_slice).collect();
        let (union, ood_score) = (model.predict_all(&views)?, model.ood_score(&views)?);
        Ok((union.to_vec(), spectra, pieces, ood_score))
    })?;
    let spectra = spectra.into_iter().map(|values| from_vec(py, values).into_any()).collect();
    Ok((from_vec(py, union).into_any(), spectra, pieces, ood_score))
}

/// Returns a spectrum between two; see `catamaran.interpolate_spectra`.
#[pyfunction]
#[pyo3(signature = (first, second, t))]
pub fn interpolate_spectra<'py>(
    py: Python<'py>,
    first: &Bound<'py, PyAny>,
    second: &Bound<'py, PyAny>,
    t: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let _nearest = FloatEnv::nearest();
    let first = Array::<f64>::new("first", first, &[1])?;
    let second = Array::<f64>::new("second", second, &[1])?;
    let found = interpolate(&first.entries(), &second.entries(), t).map_err(exception)?;
    Ok(from_vec(py, found.to_vec()).into_any())
}

/// Returns where a union is on the template, and the components of the parts that are meshes; see
/// `catamaran.locate_union`.
#[pyfunction]
#[pyo3(signature = (parts, v, f, model, weld, threads, progress))]
pub fn locate_union<'py>(
    py: Python<'py>,
    parts: Vec<Bound<'py, PyAny>>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    model: Option<PathBuf>,
    weld: bool,
    threads: Threads,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyAny>, Vec<Option<Pieces>>)> {
    let (parts, template, par) = (read_parts(&parts, weld)?, mesh(v, f)?, par(threads)?);
    let (inside, pieces) = run(py, Length::Long, progress, move |progress| {
        let (model, (spectra, pieces)) = (network(model)?, spectra(parts)?);
        let views: Vec<&[f64]> = spectra.iter().map(Vec::as_slice).collect();
        let region = model.locate(&views)?;
        let on = model.localizer().on_mesh_watched(&template, par, progress)?;
        Ok((on.indicator(&region)?, pieces))
    })?;
    Ok((from_vec(py, inside).into_any(), pieces))
}
