//! What is known about a mesh: measures, topology, problems, its parts, differences from another.

use catamaran::{Error, Par};
use catamaran_geometry::decimate::{Difference, Quality};
use catamaran_geometry::mesh::{
    Comparison, Components, Edges, Genus, OneSided, Problem, TriMesh, needs_repair, vertex_areas,
};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat, PyList};

use crate::array::{from_rows, from_vec};
use crate::mesh::{Mesh, PartArrays, mesh, mesh_file, numbers, part};
use crate::options::{Threads, faces, par};
use crate::task::{Length, run};

/// What [`measure`] finds.
enum Found {
    None,
    Number(f64),
    Numbers(Vec<f64>),
    Vectors(Vec<[f64; 3]>),
    Labels(Vec<u32>),
    Edges(Vec<[u32; 2]>),
    Loops(Vec<Vec<u32>>),
}

impl Found {
    fn of(mesh: &TriMesh, what: &str, par: Par) -> catamaran::Result<Self> {
        let topology = ["components", "intersecting_faces", "edges", "boundary_loops"];
        if !topology.contains(&what) {
            mesh.check_size()?;
        }
        Ok(match what {
            "area" => Self::Number(mesh.area()),
            "volume" => mesh.volume().map_or(Self::None, Self::Number),
            "face_areas" => Self::Numbers(mesh.face_areas()),
            "vertex_areas" => Self::Numbers(vertex_areas(mesh)),
            "qualities" => Self::Numbers(mesh.qualities()),
            "face_normals" => Self::Vectors(mesh.face_normals()),
            "vertex_normals" => Self::Vectors(mesh.vertex_normals()),
            "components" => Self::Labels(Components::new(mesh).of_faces().to_vec()),
            "intersecting_faces" => Self::Labels(mesh.intersecting_faces(par)),
            "edges" => Self::Edges(Edges::new(mesh).ends().to_vec()),
            "boundary_loops" => Self::Loops(mesh.boundary_loops(&Edges::new(mesh))?),
            _ => return Err(Error::Argument { what: "what", why: format!("unknown: {what}") }),
        })
    }

    fn into_object(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        Ok(match self {
            Self::None => py.None().into_bound(py),
            Self::Number(x) => PyFloat::new(py, x).into_any(),
            Self::Numbers(all) => from_vec(py, all).into_any(),
            Self::Vectors(all) => from_rows(py, all)?.into_any(),
            Self::Labels(all) => numbers(py, all),
            Self::Edges(all) => {
                let ends = all.into_iter().map(|ends| ends.map(i64::from)).collect();
                from_rows(py, ends)?.into_any()
            }
            Self::Loops(all) => {
                PyList::new(py, all.into_iter().map(|walk| numbers(py, walk)))?.into_any()
            }
        })
    }
}

/// Returns one of the measures of a mesh; see the methods of `catamaran.Mesh`.
#[pyfunction]
#[pyo3(signature = (v, f, what, threads))]
pub fn measure<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    what: &str,
    threads: Threads,
) -> PyResult<Bound<'py, PyAny>> {
    let (mesh, par) = (mesh(v, f)?, par(threads)?);
    run(py, Length::Long, None, move |_| Found::of(&mesh, what, par))?.into_object(py)
}

/// Counts and problems of a mesh, as a dictionary; see `catamaran.Mesh.validate`.
#[pyfunction]
#[pyo3(signature = (v, f))]
pub fn validate<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyDict>> {
    let file = mesh_file(v, f)?;
    let (report, repair) =
        run(py, Length::Long, None, move |_| Ok((file.validate(), needs_repair(&file.mesh))))?;
    let collapsed = report.problems.first().filter(|p| matches!(p, Problem::CollapsedFaces { .. }));
    let repair = match collapsed {
        Some(problem) => Some(format!("{}: {problem}", problem.kind())),
        None => repair,
    };
    let genus = report.genus.map(|(Genus::Orientable(n) | Genus::NonOrientable(n))| n);
    let is_twisted = |problem: &Problem| matches!(problem, Problem::NotOrientable { .. });
    let problems = report.problems.iter().map(|problem| (problem.kind(), problem.to_string()));
    let found = PyDict::new(py);
    found.set_item("vertices", report.vertices)?;
    found.set_item("edges", report.edges)?;
    found.set_item("faces", report.faces)?;
    found.set_item("components", report.components)?;
    found.set_item("boundary_edges", report.boundary_edges)?;
    found.set_item("boundary_loops", report.boundary_loops)?;
    found.set_item("euler_characteristic", report.euler_characteristic)?;
    found.set_item("genus", genus)?;
    found.set_item("is_orientable", !report.problems.iter().any(is_twisted))?;
    found.set_item("problems", problems.collect::<Vec<(&str, String)>>())?;
    found.set_item("needs_repair", repair)?;
    found.set_item("report", report.to_string())?;
    Ok(found)
}

/// Returns the part of these faces; see `catamaran.Mesh.submesh`.
#[pyfunction]
#[pyo3(signature = (v, f, chosen))]
pub fn submesh<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    chosen: &Bound<'py, PyAny>,
) -> PyResult<PartArrays<'py>> {
    let (mesh, chosen) = (mesh(v, f)?, faces("faces", chosen)?);
    part(py, run(py, Length::Long, None, move |_| mesh.submesh(&chosen))?)
}

/// Returns a component; see `catamaran.Mesh.component`.
#[pyfunction]
#[pyo3(signature = (v, f, number))]
pub fn component<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    number: usize,
) -> PyResult<PartArrays<'py>> {
    let mesh = mesh(v, f)?;
    let found =
        run(py, Length::Long, None, move |_| mesh.component(&Components::new(&mesh), number))?;
    part(py, found)
}

/// Distances out and back, each the largest one, the mean and the angle; see
/// `catamaran.Mesh.compare`.
#[pyfunction]
#[pyo3(signature = (first, second, threads))]
pub fn compare<'py>(
    py: Python<'py>,
    first: Mesh<'py>,
    second: Mesh<'py>,
    threads: Threads,
) -> PyResult<[(f64, f64, f64); 2]> {
    let [first, second] = [mesh(&first.0, &first.1)?, mesh(&second.0, &second.1)?];
    let par = par(threads)?;
    let found = run(py, Length::Long, None, move |_| Comparison::between(&first, &second, par))?;
    let numbers = |side: OneSided| (side.largest, side.mean, side.angle);
    Ok([numbers(found.out), numbers(found.back)])
}

/// Returns Hausdorff and chamfer distances, both as the thesis prints them, and an upper bound of
/// the first for all points; see `catamaran.Decimated.difference`.
#[pyfunction]
#[pyo3(signature = (first, second, threads))]
pub fn difference<'py>(
    py: Python<'py>,
    first: Mesh<'py>,
    second: Mesh<'py>,
    threads: Threads,
) -> PyResult<[f64; 5]> {
    let [first, second] = [mesh(&first.0, &first.1)?, mesh(&second.0, &second.1)?];
    let par = par(threads)?;
    let found = run(py, Length::Long, None, move |_| Difference::between(&first, &second, par))?;
    let Difference { hausdorff, hausdorff_bound, chamfer, printed_hausdorff, printed_chamfer } =
        found;
    Ok([hausdorff, chamfer, printed_hausdorff, printed_chamfer, hausdorff_bound])
}

/// Measures of uniformity, in the order of `catamaran.Mesh.quality`.
#[pyfunction]
#[pyo3(signature = (v, f))]
pub fn quality<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
) -> PyResult<([f64; 7], usize)> {
    let mesh = mesh(v, f)?;
    let found = run(py, Length::Long, None, move |_| {
        mesh.check_size()?;
        Ok(Quality::of(&mesh))
    })?;
    let numbers = [
        found.mean_area,
        found.area_variation,
        found.mean_quality,
        found.quality_deviation,
        found.least_quality,
        found.mean_valence,
        found.regular_vertices,
    ];
    Ok((numbers, found.non_manifold_edges))
}
