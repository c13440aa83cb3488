//! Meshes that are cut open, and regions: sets of faces.

use catamaran_geometry::curve::{Region, Side, cut as opened};
use pyo3::prelude::*;

use crate::array::{Array, from_rows, from_vec};
use crate::mesh::{PartArrays, mesh, part};
use crate::options::{pairs, vertices, word};
use crate::task::{Length, run};

/// Returns a mesh that is cut open along edges, and its vertices in the one before; see
/// `catamaran.cut`.
#[pyfunction]
#[pyo3(signature = (v, f, along))]
pub fn cut<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    along: &Bound<'py, PyAny>,
) -> PyResult<PartArrays<'py>> {
    let (mesh, along) = (mesh(v, f)?, pairs("along", along)?);
    part(py, run(py, Length::Long, None, move |_| opened(&mesh, &along))?)
}

/// For each face whether curves along edges enclose it; see `catamaran.enclosed_faces`.
#[pyfunction]
#[pyo3(signature = (v, f, along, side, seeds))]
pub fn enclosed_faces<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    along: &Bound<'py, PyAny>,
    side: &str,
    seeds: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let is_small = word("side", side, &[("small", true), ("large", false)])?;
    let side = match seeds {
        Some(seeds) => Side::Seeds(vertices("seeds", seeds)?),
        None if is_small => Side::Small,
        None => Side::Large,
    };
    let (mesh, along) = (mesh(v, f)?, pairs("along", along)?);
    let found = run(py, Length::Long, None, move |_| Region::enclosed(&mesh, &along, &side))?;
    Ok(from_vec(py, found.mask().to_vec()).into_any())
}

/// Returns the edges between a region, 0 or 1 for each face, and the rest; see
/// `catamaran.region_boundary`.
#[pyfunction]
#[pyo3(signature = (v, f, region))]
pub fn region_boundary<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    region: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let (mesh, mask) = (mesh(v, f)?, Array::<u8>::new("region", region, &[1])?);
    let region = Region::new(mask.entries().iter().map(|&inside| inside != 0).collect());
    let edges = run(py, Length::Long, None, move |_| region.boundary(&mesh))?;
    let edges = edges.into_iter().map(|ends| ends.map(i64::from)).collect();
    Ok(from_rows(py, edges)?.into_any())
}
