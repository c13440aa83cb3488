//! Signatures of shapes, and spectra of unions of parts.

use std::path::PathBuf;

use catamaran::mesh::{Boundary, LaplacianOptions, TriMesh, free_components};
use catamaran::unions::{K, PartSpectra, ShapeDnaOptions, SpectralUnion, shape_dna as signature};
use pyo3::prelude::*;

use crate::array::{Array, from_vec};
use crate::options::{laplacian_kind, par};
use crate::surface::{Pieces, Surface};
use crate::task::{Length, run};

/// A signature, and the components of the mesh; see `catamaran.shape_dna`.
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
    threads: Option<i64>,
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

/// A part: its spectrum, or the mesh that it is of.
enum Part {
    Spectrum(Vec<f64>),
    Mesh(TriMesh),
}

impl Part {
    fn new(object: &Bound<'_, PyAny>, weld: bool) -> PyResult<Self> {
        if let Ok((v, f)) = object.extract::<(Bound<'_, PyAny>, Bound<'_, PyAny>)>()
            && v.len().is_ok()
        {
            return Ok(Self::Mesh(Surface::new(&v, &f, weld)?.mesh));
        }
        let values = Array::<f64>::new("parts", object, &[1])?;
        Ok(Self::Spectrum(values.entries().into_owned()))
    }

    fn spectrum(self) -> catamaran::Result<Vec<f64>> {
        match self {
            Self::Spectrum(values) => Ok(values),
            Self::Mesh(mesh) => {
                if free_components(&mesh, &Boundary::Dirichlet)? > 0 {
                    let why = "a component is closed: each component of a part needs a boundary";
                    return Err(catamaran::Error::Argument { what: "parts", why: why.into() });
                }
                let all = vec![true; mesh.vertices().len()];
                PartSpectra::new(&mesh, &LaplacianOptions::default())?.dirichlet(&all, K)
            }
        }
    }
}

/// The spectrum of the union, those of the parts, and how unlike the training the parts are; see
/// `catamaran.union_spectrum`.
#[pyfunction]
#[pyo3(signature = (parts, model, weld, progress))]
pub fn union_spectrum<'py>(
    py: Python<'py>,
    parts: Vec<Bound<'py, PyAny>>,
    model: Option<PathBuf>,
    weld: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyAny>, Vec<Bound<'py, PyAny>>, f64)> {
    let parts: Vec<Part> =
        parts.iter().map(|part| Part::new(part, weld)).collect::<PyResult<_>>()?;
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
