//! Meshes as arrays of vertices and faces, generated ones, and their Laplacians.

use catamaran_geometry::mesh::io::MeshFile;
use catamaran_geometry::mesh::{Part, Refined, TriMesh, families, laplacian as assemble};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::array::{Array, from_rows, from_vec, untyped};
use crate::error::{exception, refused};
use crate::options::{Threads, laplacian as options, par, vertex};
use crate::sparse::{Parts, mass_parts, parts};
use crate::surface::Surface;
use crate::task::{Length, run};

/// Vertices and faces.
pub type Mesh<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>);

/// Returns the mesh of two arrays, which are copied.
pub fn mesh(vertices: &Bound<'_, PyAny>, faces: &Bound<'_, PyAny>) -> PyResult<TriMesh> {
    let (positions, faces) = (positions("v", vertices)?, triangles("f", faces)?);
    TriMesh::new(positions, faces).map_err(exception)
}

/// Returns the mesh of two arrays without the faces that have a vertex twice, which it counts.
pub fn mesh_file(vertices: &Bound<'_, PyAny>, faces: &Bound<'_, PyAny>) -> PyResult<MeshFile> {
    let (positions, faces) = (positions("v", vertices)?, triangles("f", faces)?);
    MeshFile::from_arrays(positions, faces).map_err(exception)
}

/// Rows of three coordinates.
pub fn positions(name: &str, vertices: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; 3]>> {
    let array = Array::<f64>::new(name, vertices, &[2])?;
    let view = array.view();
    if view.ncols() != 3 {
        return Err(refused(name, format_args!("expected 3 columns, got {}", view.ncols())));
    }
    Ok((0..view.nrows()).map(|i| [0, 1, 2].map(|j| view[(i, j)])).collect())
}

/// Rows of three numbers of vertices.
fn triangles(name: &str, faces: &Bound<'_, PyAny>) -> PyResult<Vec<[u32; 3]>> {
    use numpy::{PyArrayDescrMethods, PyUntypedArrayMethods};
    let array = untyped(name, faces)?;
    let kind = array.dtype().kind();
    // Any type will do for no faces.
    if !matches!(kind, b'i' | b'u') && !array.is_empty() {
        return Err(PyTypeError::new_err(format!(
            "{name}: expected integers, got {}",
            array.dtype()
        )));
    }
    let array = Array::<i64>::new(name, &array, &[2])?;
    let view = array.view();
    if view.ncols() != 3 {
        return Err(refused(name, format_args!("expected 3 columns, got {}", view.ncols())));
    }
    let row = |f: usize| -> PyResult<[u32; 3]> {
        let mut face = [0; 3];
        for (corner, j) in face.iter_mut().zip(0..) {
            let vertex = view[(f, j)];
            *corner = u32::try_from(vertex).map_err(|_| {
                refused(&format!("face {f}"), format_args!("there is no vertex {vertex}"))
            })?;
        }
        Ok(face)
    };
    (0..view.nrows()).map(row).collect()
}

/// Returns a mesh as two arrays.
pub fn arrays(py: Python<'_>, mesh: TriMesh) -> PyResult<Mesh<'_>> {
    let (vertices, faces) = mesh.into_parts();
    let faces = faces.into_iter().map(|face| face.map(i64::from)).collect();
    Ok((from_rows(py, vertices)?.into_any(), from_rows(py, faces)?.into_any()))
}

/// Numbers of vertices or faces as an array.
pub fn numbers(py: Python<'_>, all: impl IntoIterator<Item = u32>) -> Bound<'_, PyAny> {
    from_vec(py, all.into_iter().map(i64::from).collect::<Vec<i64>>()).into_any()
}

/// A part of a mesh, and the numbers that its vertices and faces have there.
pub type PartArrays<'py> = (Mesh<'py>, Bound<'py, PyAny>, Bound<'py, PyAny>);

/// Returns a part of a mesh as arrays.
pub fn part(py: Python<'_>, part: Part) -> PyResult<PartArrays<'_>> {
    let Part { mesh, vertices, faces } = part;
    Ok((arrays(py, mesh)?, numbers(py, vertices), numbers(py, faces)))
}

/// A finer mesh; for each of its faces the coarse one, for each vertex three coarse ones and their
/// weights.
pub type RefinedArrays<'py> = (Mesh<'py>, Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>);

/// Returns a finer mesh as arrays.
pub fn refined(py: Python<'_>, refined: Refined) -> PyResult<RefinedArrays<'_>> {
    let Refined { mesh, faces, vertices } = refined;
    let corners = vertices.iter().map(|origin| origin.vertices.map(i64::from)).collect();
    let weights = vertices.iter().map(|origin| origin.weights).collect();
    let origins = (from_rows(py, corners)?.into_any(), from_rows(py, weights)?.into_any());
    Ok((arrays(py, mesh)?, numbers(py, faces), origins.0, origins.1))
}

/// Returns a generated mesh; see `catamaran.shapes`.
#[pyfunction]
#[pyo3(signature = (name, counts, sizes))]
pub fn shape<'py>(
    py: Python<'py>,
    name: &str,
    counts: Vec<usize>,
    sizes: Vec<f64>,
) -> PyResult<Mesh<'py>> {
    let made = run(py, Length::Long, None, |_| families::by_name(name, &counts, &sizes))?;
    arrays(py, made)
}

/// Returns stiffness, mass and the vertices of their rows; see `catamaran.laplacian`.
#[pyfunction]
#[pyo3(signature = (v, f, kind, mass, boundary, weld, threads, progress))]
pub fn laplacian<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    kind: &str,
    mass: &str,
    boundary: &Bound<'py, PyAny>,
    weld: bool,
    threads: Threads,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Parts<'py>, Parts<'py>, Bound<'py, PyAny>)> {
    let mut options = options(kind, mass, boundary, par(threads)?)?;
    let surface = Surface::new(v, f, weld)?;
    options.boundary = surface.boundary(options.boundary);
    let (found, kept) = run(py, Length::Long, progress, move |_| {
        let found = assemble(&surface.mesh, &options)?;
        let firsts = surface.firsts();
        let kept: Vec<i64> = found.kept.iter().map(|&v| firsts(v) as i64).collect();
        Ok::<_, catamaran::Error>((found, kept))
    })?;
    Ok((parts(py, found.stiffness), mass_parts(py, found.mass), from_vec(py, kept).into_any()))
}

/// Returns the vertex that sampling starts at.
pub fn first_vertex(first: Option<i64>) -> PyResult<Option<u32>> {
    first.map(|v| vertex("first", v)).transpose()
}
