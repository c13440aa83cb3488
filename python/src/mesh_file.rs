//! Files of meshes.

use std::path::PathBuf;

use catamaran::io::{Output, Overwrite, SourceOptions};
use catamaran_geometry::mesh::io::{
    Attribute, GltfEncoding, MeshFile, MeshFormat, PlyEncoding, Scalars, StlEncoding, VtkEncoding,
    read, read_bytes, read_scalars as read_values, write_as, write_bytes,
};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::array::{Array, from_rows, from_vec};
use crate::error::{exception, refused};
use crate::mesh::{arrays, mesh};
use crate::options::word;
use crate::task::{Length, run};

/// Values of the corners of faces: three for each face, NaN where a face has none.
fn corners<const N: usize>(file: &MeshFile, attribute: &Attribute<N>) -> Vec<[f64; N]> {
    let faces = file.mesh.faces().len();
    let none = [[f64::NAN; N]; 3];
    (0..faces).flat_map(|f| attribute.of_face(&file.mesh, f).unwrap_or(none)).collect()
}

/// Vertices, faces and a dictionary of attributes.
type FileParts<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyDict>);

/// Returns the content of a file; see `catamaran.read_mesh`.
#[pyfunction]
#[pyo3(signature = (path))]
pub fn read_mesh(py: Python<'_>, path: PathBuf) -> PyResult<FileParts<'_>> {
    content(py, run(py, Length::Long, None, move |_| read(&path))?)
}

/// Returns the content of a file in memory; see `catamaran.mesh_from_bytes`.
#[pyfunction]
#[pyo3(signature = (data, format))]
pub fn mesh_from_bytes<'py>(
    py: Python<'py>,
    data: &[u8],
    format: &str,
) -> PyResult<FileParts<'py>> {
    let format = format_of(format)?;
    content(py, run(py, Length::Long, None, move |_| read_bytes(data, format))?)
}

/// Returns the values of vertices in a file; see `catamaran.read_scalars`.
#[pyfunction]
#[pyo3(signature = (path))]
pub fn read_scalars(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let scalars = run(py, Length::Long, None, move |_| read_values(&path, &SourceOptions::new()))?;
    by_name(py, scalars)
}

fn by_name(py: Python<'_>, scalars: Vec<Scalars>) -> PyResult<Bound<'_, PyDict>> {
    let named = PyDict::new(py);
    for Scalars { name, values } in scalars {
        named.set_item(name, from_vec(py, values))?;
    }
    Ok(named)
}

fn format_of(name: &str) -> PyResult<MeshFormat> {
    let known = [
        ("obj", MeshFormat::Obj),
        ("ply", MeshFormat::Ply(PlyEncoding::LittleEndian)),
        ("off", MeshFormat::Off),
        ("stl", MeshFormat::Stl(StlEncoding::Binary)),
        ("glb", MeshFormat::Gltf(GltfEncoding::Binary)),
        ("gltf", MeshFormat::Gltf(GltfEncoding::Text)),
        ("vtk", MeshFormat::Vtk(VtkEncoding::Binary)),
        ("vtp", MeshFormat::VtkXml),
        ("vtu", MeshFormat::VtkXml),
        ("gii", MeshFormat::Gifti),
        ("white", MeshFormat::FreeSurfer),
        ("msh", MeshFormat::Gmsh),
        ("3mf", MeshFormat::ThreeMf),
    ];
    word("format", name, &known)
}

fn content(py: Python<'_>, mut file: MeshFile) -> PyResult<FileParts<'_>> {
    let more = PyDict::new(py);
    let faces = file.mesh.faces().len();
    if let Some(uv) = &file.uv {
        let values = from_rows(py, corners(&file, uv))?;
        more.set_item("uv", values.call_method1("reshape", ((faces, 3, 2),))?)?;
    }
    if let Some(normals) = &file.normals {
        let values = from_rows(py, corners(&file, normals))?;
        more.set_item("normals", values.call_method1("reshape", ((faces, 3, 3),))?)?;
    }
    if let Some(colors) = file.colors.take() {
        more.set_item("colors", from_rows(py, colors)?)?;
    }
    if !file.scalars.is_empty() {
        more.set_item("scalars", by_name(py, std::mem::take(&mut file.scalars))?)?;
    }
    for (name, labels) in
        [("materials", &file.materials), ("groups", &file.groups), ("objects", &file.objects)]
    {
        if let Some(labels) = labels {
            let of_faces: Vec<i64> =
                labels.of_faces.iter().map(|&label| i64::from(label)).collect();
            more.set_item(name, (labels.names.clone(), from_vec(py, of_faces)))?;
        }
    }
    more.set_item("notes", file.notes.clone())?;
    let (v, f) = arrays(py, file.mesh)?;
    Ok((v, f, more))
}

/// Writes a mesh, and returns notes about what the file does not hold as it is given; see
/// `catamaran.write_mesh`.
#[pyfunction]
#[pyo3(signature = (path, v, f, colors, uv, overwrite, text))]
pub fn write_mesh<'py>(
    py: Python<'py>,
    path: PathBuf,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    colors: Option<&Bound<'py, PyAny>>,
    uv: Option<&Bound<'py, PyAny>>,
    overwrite: bool,
    text: bool,
) -> PyResult<Vec<String>> {
    let file = file_of((v, f), colors, uv)?;
    let overwrite = if overwrite { Overwrite::Replace } else { Overwrite::Never };
    let format = as_text(MeshFormat::of(&path).map_err(exception)?, text)?;
    run(py, Length::Long, None, move |_| write_as(Output::create(&path, overwrite)?, &file, format))
}

/// Returns a file in memory, and the notes of [`write_mesh`]; see `catamaran.mesh_to_bytes`.
#[pyfunction]
#[pyo3(signature = (v, f, format, colors, uv, text))]
pub fn mesh_to_bytes<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    format: &str,
    colors: Option<&Bound<'py, PyAny>>,
    uv: Option<&Bound<'py, PyAny>>,
    text: bool,
) -> PyResult<(Bound<'py, PyBytes>, Vec<String>)> {
    let (file, format) = (file_of((v, f), colors, uv)?, as_text(format_of(format)?, text)?);
    let (bytes, notes) = run(py, Length::Long, None, move |_| write_bytes(&file, format))?;
    Ok((PyBytes::new(py, &bytes), notes))
}

fn as_text(format: MeshFormat, text: bool) -> PyResult<MeshFormat> {
    let why = "this format has no text with every digit";
    if text { format.as_text().ok_or_else(|| refused("text", why)) } else { Ok(format) }
}

/// Returns a mesh with colours of vertices and texture coordinates of corners.
fn file_of(
    (v, f): (&Bound<'_, PyAny>, &Bound<'_, PyAny>),
    colors: Option<&Bound<'_, PyAny>>,
    uv: Option<&Bound<'_, PyAny>>,
) -> PyResult<MeshFile> {
    let mut file = MeshFile::from(mesh(v, f)?);
    if let Some(colors) = colors {
        let colors = Array::<f64>::new("colors", colors, &[2])?;
        let view = colors.view();
        if !matches!(view.ncols(), 3 | 4) {
            return Err(refused(
                "colors",
                format_args!("expected 3 or 4 columns, got {}", view.ncols()),
            ));
        }
        let row = |i| [0, 1, 2, 3].map(|j| if j < view.ncols() { view[(i, j)] } else { 1.0 });
        file.colors = Some((0..view.nrows()).map(row).collect());
    }
    if let Some(uv) = uv {
        file.uv = Some(texture_coordinates(uv, file.mesh.faces().len())?);
    }
    Ok(file)
}

/// Returns texture coordinates of the corners of faces, faces x 3 x 2; a face of NaN alone has
/// none.
pub fn texture_coordinates(uv: &Bound<'_, PyAny>, faces: usize) -> PyResult<Attribute<2>> {
    let rows = Array::<f64>::new("uv", &uv.call_method1("reshape", ((3 * faces, 2),))?, &[2])?;
    let view = rows.view();
    let mut values: Vec<[f64; 2]> =
        (0..view.nrows()).map(|i| [view[(i, 0)], view[(i, 1)]]).collect();
    let mut corners = Vec::with_capacity(faces);
    for f in 0..faces as u32 {
        let numbers = [3 * f, 3 * f + 1, 3 * f + 2];
        let of_face = numbers.map(|i| values[i as usize]);
        corners.push(match of_face.as_flattened().iter().filter(|x| x.is_nan()).count() {
            0 => numbers,
            6 => [Attribute::<2>::ABSENT; 3],
            _ => {
                let why = format!("face {f}: NaN at some of its corners only");
                return Err(refused("uv", why));
            }
        });
    }
    // The values of no face.
    values
        .iter_mut()
        .filter(|value| value[0].is_nan() || value[1].is_nan())
        .for_each(|value| *value = [0.0; 2]);
    Ok(Attribute { values, corners: Some(corners) })
}
