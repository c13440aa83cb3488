//! Curves through samples on a mesh, several of them drawn into it, and points as vertices.

use catamaran::Error;
use catamaran_geometry::curve::{
    Count, Curve, CurveOptions, CurveSolver, Drawing, Mode, Placement, Reconstruction, Site,
    place as placed, places, with_steiner,
};
use catamaran_geometry::mesh::{Refined, SurfacePoint};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::array::from_rows;
use crate::error::refused;
use crate::mesh::{RefinedArrays, mesh, numbers, positions, refined};
use crate::options::{arguments, faces, vertices, word};
use crate::task::{Length, run};

arguments! {
    /// How a curve is found, as a dictionary.
    pub struct How {
        mode: String,
        open: bool,
        single: bool,
        steiner: bool,
        drop_outliers: bool,
        candidates: usize,
        start: usize,
    }
}

impl How {
    fn options(&self) -> PyResult<CurveOptions<'static>> {
        let known = [("robust", Mode::Robust), ("faithful", Mode::Faithful)];
        Ok(CurveOptions::new()
            .mode(word("mode", &self.mode, &known)?)
            .open(self.open)
            .count(if self.single { Count::One } else { Count::Automatic })
            .steiner(self.steiner)
            .drop_outliers(self.drop_outliers)
            .candidates(self.candidates)
            .start(self.start))
    }
}

/// The outcome, whether it is complete, the curves as dictionaries, the samples that are left out,
/// and the outliers.
type Found<'py> = (String, bool, Vec<Bound<'py, PyDict>>, Bound<'py, PyAny>, Bound<'py, PyAny>);

/// Returns what was found as Python takes it; `on_faces` has the places of the points of each curve
/// on the mesh of the caller.
fn found(
    py: Python<'_>,
    all: Reconstruction,
    on_faces: Vec<Vec<SurfacePoint>>,
) -> PyResult<Found<'_>> {
    let mut entries = Vec::new();
    for (curve, places) in all.curves.into_iter().zip(on_faces) {
        let entry = PyDict::new(py);
        let weights: Vec<[f64; 3]> = places.iter().map(|at| at.weights).collect();
        entry.set_item("faces", numbers(py, places.iter().map(|at| at.face)))?;
        entry.set_item("barycentric", from_rows(py, weights)?)?;
        entry.set_item("order", numbers(py, curve.order))?;
        entry.set_item("path", numbers(py, curve.path))?;
        entry.set_item("points", from_rows(py, curve.points)?)?;
        entry.set_item("closed", curve.closed)?;
        entry.set_item("length", curve.length)?;
        entries.push(entry);
    }
    let (left_out, outliers) = (numbers(py, all.left_out), numbers(py, all.outliers));
    Ok((all.outcome.to_string(), all.outcome.is_complete(), entries, left_out, outliers))
}

/// Implements `catamaran.curve`.
#[pyfunction]
#[pyo3(signature = (v, f, samples, how, smooth, progress))]
pub fn curve<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    samples: &Bound<'py, PyAny>,
    how: How,
    smooth: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<Found<'py>> {
    let options = how.options()?;
    let (mesh, samples) = (mesh(v, f)?, vertices("samples", samples)?);
    let (all, on_faces) = run(py, Length::Long, progress, move |progress| {
        let options = options.progress(progress);
        let mut all = CurveSolver::new(&mesh)?.reconstruct(&samples, &options)?;
        if smooth {
            all.smooth(&mesh, &samples)?;
        }
        let on_faces = places(&all.curves, &with_steiner(&mesh, &all.steiner)?, &mesh)?;
        Ok((all, on_faces))
    })?;
    found(py, all, on_faces)
}

/// Returns a mesh with curves along its edges, and what was found of each layer; see
/// `catamaran.draw`.
#[pyfunction]
#[pyo3(signature = (v, f, layers, smooth, progress))]
pub fn draw<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    layers: Vec<(Bound<'py, PyAny>, How)>,
    smooth: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<(RefinedArrays<'py>, Vec<Found<'py>>)> {
    let layer = |(samples, how): &(Bound<'py, PyAny>, How)| -> PyResult<_> {
        Ok((vertices("layers", samples)?, how.options()?))
    };
    let layers: Vec<(Vec<u32>, CurveOptions<'static>)> =
        layers.iter().map(layer).collect::<PyResult<_>>()?;
    let mesh = mesh(v, f)?;
    let (finer, layers) = run(py, Length::Long, progress, move |progress| {
        let mut drawing = Drawing::new(mesh.clone())?;
        let share = 1.0 / layers.len() as f64;
        for (i, (samples, options)) in layers.into_iter().enumerate() {
            let part = progress.part(i as f64 * share..(i + 1) as f64 * share);
            drawing.add(&samples, &options.progress(part))?;
        }
        if smooth {
            drawing.smooth()?;
        }
        let drawn = drawing.inscribe()?;
        let layer = |(own, curves): (&Reconstruction, Vec<Curve>)| -> catamaran::Result<_> {
            let on_faces = places(&curves, &drawn.refined, &mesh)?;
            Ok((Reconstruction { curves, ..own.clone() }, on_faces))
        };
        let layers = drawing.found().zip(drawn.layers).map(layer);
        let layers = layers.collect::<catamaran::Result<Vec<_>>>()?;
        Ok((drawn.refined, layers))
    })?;
    let layers = layers.into_iter().map(|(all, on_faces)| found(py, all, on_faces));
    Ok((refined(py, finer)?, layers.collect::<PyResult<_>>()?))
}

/// Points of faces as vertices of a mesh, which is finer where they are inserted; see
/// `catamaran.place`.
#[pyfunction]
#[pyo3(signature = (v, f, of_faces, barycentric, insert))]
pub fn place<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    of_faces: &Bound<'py, PyAny>,
    barycentric: &Bound<'py, PyAny>,
    insert: bool,
) -> PyResult<(RefinedArrays<'py>, Bound<'py, PyAny>)> {
    let (mesh, of_faces) = (mesh(v, f)?, faces("faces", of_faces)?);
    let weights = positions("barycentric", barycentric)?;
    if weights.len() != of_faces.len() {
        let why = format_args!("{} rows for {} faces", weights.len(), of_faces.len());
        return Err(refused("barycentric", why));
    }
    let points = of_faces.into_iter().zip(weights);
    let points = points.map(|(face, weights)| Site::Face(SurfacePoint { face, weights }));
    let sites: Vec<Site> = points.collect();
    let placement = if insert { Placement::Insert } else { Placement::Snap };
    let (finer, vertices) = run(py, Length::Long, None, move |_| {
        let found = placed(&mesh, &sites, placement).map_err(|error| match error {
            Error::Argument { what: "sites", why } => Error::Argument { what: "faces", why },
            error => error,
        })?;
        Ok((found.mesh.unwrap_or_else(|| Refined::new(mesh)), found.vertices))
    })?;
    Ok((refined(py, finer)?, numbers(py, vertices)))
}
