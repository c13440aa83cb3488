//! Signatures of shapes, and spectra of unions of parts.

use std::path::PathBuf;

use catamaran::mesh::{LaplacianOptions, TriMesh};
use catamaran::unions::{K, PartSpectra, ShapeDnaOptions, SpectralUnion, shape_dna as signature};
use pyo3::prelude::*;

use crate::array::{Array, from_vec};
use crate::mesh::mesh;
use crate::options::{laplacian_kind, par};
use crate::task::{Length, run};

/// See `catamaran.shape_dna`.
#[pyfunction]
#[pyo3(signature = (v, f, k, normalized, kind, threads, progress))]
pub fn shape_dna<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    k: usize,
    normalized: bool,
    kind: &str,
    threads: Option<i64>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let laplacian = LaplacianOptions::new().kind(laplacian_kind(kind)?).par(par(threads)?);
    let mesh = mesh(v, f)?;
    let options = ShapeDnaOptions::new().k(k).normalized(normalized).laplacian(laplacian);
    let found = run(py, Length::Long, progress, move |progress| {
        signature(&mesh, &options.progress(progress))
    })?;
    Ok(from_vec(py, found).into_any())
}

/// A part: its spectrum, or the mesh that it is of.
enum Part {
    Spectrum(Vec<f64>),
    Mesh(TriMesh),
}

impl Part {
    fn new(object: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Ok((v, f)) = object.extract::<(Bound<'_, PyAny>, Bound<'_, PyAny>)>()
            && v.len().is_ok()
        {
            return Ok(Self::Mesh(mesh(&v, &f)?));
        }
        let values = Array::<f64>::new("parts", object, &[1])?;
        Ok(Self::Spectrum(values.entries().into_owned()))
    }

    fn spectrum(self) -> catamaran::Result<Vec<f64>> {
        match self {
            Self::Spectrum(values) => Ok(values),
            Self::Mesh(mesh) => {
                let all = vec![true; mesh.vertices().len()];
                PartSpectra::new(&mesh, &LaplacianOptions::default())?.dirichlet(&all, K)
            }
        }
    }
}

/// The spectrum of the union, those of the parts, and how unlike the training the parts are; see
/// `catamaran.union_spectrum`.
#[pyfunction]
#[pyo3(signature = (parts, model, progress))]
pub fn union_spectrum<'py>(
    py: Python<'py>,
    parts: Vec<Bound<'py, PyAny>>,
    model: Option<PathBuf>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyAny>, Vec<Bound<'py, PyAny>>, f64)> {
    let parts: Vec<Part> = parts.iter().map(Part::new).collect::<PyResult<_>>()?;
    let (union, spectra, ood_score) = run(py, Length::Long, progress, move |_| {
        let model = match model {
            Some(path) => SpectralUnion::read(&path)?,
            None => SpectralUnion::pretrained()?,
        };
        let spectra: Vec<_> =
            parts.into_iter().map(Part::spectrum).collect::<catamaran::Result<_>>()?;
        let views: Vec<&[f64]> = spectra.iter().map(Vec::as_slice).collect();
        let (union, ood_score) = (model.predict_all(&views)?, model.ood_score(&views)?);
        Ok((union.to_vec(), spectra, ood_score))
    })?;
    let spectra = spectra.into_iter().map(|values| from_vec(py, values).into_any()).collect();
    Ok((from_vec(py, union).into_any(), spectra, ood_score))
}
