//! Repair of meshes.

use catamaran_geometry::mesh::{RepairOptions, Repaired, Weld, repair as repaired};
use pyo3::prelude::*;
use pyo3::types::PyString;

use crate::array::from_vec;
use crate::mesh::{Mesh, arrays, mesh};
use crate::options::{arguments, word};
use crate::task::{Length, run};

arguments! {
    /// The steps of a repair, as a dictionary.
    pub struct Steps {
        everything: bool,
        /// A word, or the distance of vertices that are joined.
        weld: Py<PyAny>,
        drop_duplicates: bool,
        drop_degenerate: bool,
        compact: bool,
        cut: bool,
        keep_largest: Option<usize>,
        drop_specks: Option<f64>,
        fill_holes: Option<usize>,
        orient: bool,
    }
}

impl Steps {
    fn options(&self, py: Python<'_>) -> PyResult<RepairOptions> {
        let (all, weld) = (self.everything, self.weld.bind(py));
        let weld = match weld.cast::<PyString>() {
            Ok(name) => {
                let known =
                    [("never", Weld::Never), ("exact", Weld::Exact), ("seams", Weld::Seams)];
                word("weld", name.to_cow()?.as_ref(), &known)?
            }
            Err(_) => Weld::Within(crate::options::extracted("weld", weld)?),
        };
        Ok(RepairOptions::new()
            .weld(if all && weld == Weld::Never { Weld::Seams } else { weld })
            .drop_duplicates(all || self.drop_duplicates)
            .drop_degenerate(all || self.drop_degenerate)
            .compact(all || self.compact)
            .cut(all || self.cut)
            .keep_largest(self.keep_largest)
            .drop_specks(self.drop_specks)
            .fill_holes(self.fill_holes)
            .orient(all || self.orient))
    }
}

/// Returns the mesh, its vertex for each one of the input (-1 where it is left out), and a line for
/// each step; see `catamaran.repair`.
#[pyfunction]
#[pyo3(signature = (v, f, steps, progress))]
pub fn repair<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    steps: Steps,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Mesh<'py>, Bound<'py, PyAny>, Vec<String>)> {
    let (options, mesh) = (steps.options(py)?, mesh(v, f)?);
    let count = mesh.vertices().len() as u32;
    let found = run(py, Length::Long, progress, move |_| repaired(mesh.into(), &options))?;
    let number = |v: u32| if v == Repaired::NONE { -1 } else { i64::from(v) };
    let places: Vec<i64> = match found.vertices {
        Some(places) => places.into_iter().map(number).collect(),
        None => (0..count).map(i64::from).collect(),
    };
    let lines = found.report.steps.iter().map(ToString::to_string).collect();
    Ok((arrays(py, found.file.mesh)?, from_vec(py, places).into_any(), lines))
}
