//! Surfaces of functions and labels on lattices.

use catamaran_geometry::mesh::{
    Lattice, Rim, isosurface as surface, label_surface as surface_of_label,
};
use pyo3::prelude::*;

use crate::array::Array;
use crate::mesh::{Mesh, arrays};
use crate::options::{Threads, arguments, par};
use crate::task::{Length, run};

arguments! {
    /// A lattice and how its values are read, as a dictionary.
    pub struct Sampled {
        counts: [usize; 3],
        origin: [f64; 3],
        step: [f64; 3],
        open: bool,
        threads: Threads,
    }
}

impl Sampled {
    fn lattice(&self) -> (Lattice, Rim) {
        let Self { counts, origin, step, .. } = *self;
        (Lattice { counts, origin, step }, if self.open { Rim::Open } else { Rim::Closed })
    }
}

/// Returns where values, x fastest, exceed a level; see `catamaran.isosurface`.
#[pyfunction]
#[pyo3(signature = (values, level, lattice, progress))]
pub fn isosurface<'py>(
    py: Python<'py>,
    values: &Bound<'py, PyAny>,
    level: f32,
    lattice: Sampled,
    progress: Option<Py<PyAny>>,
) -> PyResult<Mesh<'py>> {
    let values = Array::<f32>::new("values", values, &[1])?;
    let (values, (of, rim), par) = (values.entries(), lattice.lattice(), par(lattice.threads)?);
    let found = run(py, Length::Long, progress, |progress| {
        surface(&of, &values, level, rim, par, progress)
    })?;
    arrays(py, found)
}

/// Returns where a mask, x fastest, is 1; see `catamaran.label_surface`.
#[pyfunction]
#[pyo3(signature = (mask, lattice, progress))]
pub fn label_surface<'py>(
    py: Python<'py>,
    mask: &Bound<'py, PyAny>,
    lattice: Sampled,
    progress: Option<Py<PyAny>>,
) -> PyResult<Mesh<'py>> {
    let mask = Array::<u8>::new("labels", mask, &[1])?;
    let (mask, (of, rim), par) = (mask.entries(), lattice.lattice(), par(lattice.threads)?);
    let found = run(py, Length::Long, progress, move |progress| {
        let labels: Vec<u16> = mask.iter().map(|&inside| u16::from(inside)).collect();
        surface_of_label(&of, &labels, 1, rim, par, progress)
    })?;
    arrays(py, found)
}
