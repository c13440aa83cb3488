//! Curves through samples on a mesh.

use catamaran_geometry::curve::{Count, CurveOptions, CurveSolver, Mode, Outcome};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::array::{from_rows, from_vec};
use crate::mesh::mesh;
use crate::options::{arguments, vertices, word};
use crate::task::{Length, run};

arguments! {
    /// How a curve is found, as a dictionary.
    pub struct How {
        mode: String,
        open: bool,
        single: bool,
        steiner: bool,
        candidates: usize,
        start: usize,
        smooth: bool,
    }
}

/// The outcome, whether it is complete, the curves as dictionaries, the samples that are left out.
type Found<'py> = (String, bool, Vec<Bound<'py, PyDict>>, Bound<'py, PyAny>);

/// See `catamaran.curve`.
#[pyfunction]
#[pyo3(signature = (v, f, samples, how, progress))]
pub fn curve<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    samples: &Bound<'py, PyAny>,
    how: How,
    progress: Option<Py<PyAny>>,
) -> PyResult<Found<'py>> {
    let mode = word("mode", &how.mode, &[("robust", Mode::Robust), ("faithful", Mode::Faithful)])?;
    let (mesh, samples) = (mesh(v, f)?, vertices("samples", samples)?);
    let found = run(py, Length::Long, progress, move |progress| {
        let options = CurveOptions::new()
            .mode(mode)
            .open(how.open)
            .count(if how.single { Count::One } else { Count::Automatic })
            .steiner(how.steiner)
            .candidates(how.candidates)
            .start(how.start)
            .progress(progress);
        let mut found = CurveSolver::new(&mesh)?.reconstruct(&samples, &options)?;
        if how.smooth {
            found.smooth(&mesh, &samples)?;
        }
        Ok(found)
    })?;
    let numbers =
        |all: Vec<u32>| from_vec(py, all.into_iter().map(i64::from).collect::<Vec<_>>()).into_any();
    let mut curves = Vec::new();
    for curve in found.curves {
        let entry = PyDict::new(py);
        entry.set_item("order", numbers(curve.order))?;
        entry.set_item("path", numbers(curve.path))?;
        entry.set_item("points", from_rows(py, curve.points)?)?;
        entry.set_item("closed", curve.closed)?;
        entry.set_item("length", curve.length)?;
        curves.push(entry);
    }
    let outcome: Outcome = found.outcome;
    Ok((outcome.to_string(), outcome.is_complete(), curves, numbers(found.left_out)))
}
