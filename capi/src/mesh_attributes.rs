use std::ffi::c_char;

use super::boundary::{boundary, utf8};
use super::mesh_file::cata_mesh_file;
use super::outputs::{copy_wanted, element, tell, write_text};
use super::pointer::{
    known, known_mut, optional_slice, optional_slice_mut, output, slice, slice_mut,
};
use super::status::{CATA_ERR_ARGUMENT, Failure, cata_status};
use catamaran::base::Error;
use catamaran_geometry::mesh::io::{Attribute, Labels, MeshFile};

/// `kind` of names: the materials of faces.
pub const CATA_MESH_MATERIALS: i32 = 0;
/// `kind` of names: the groups of faces.
pub const CATA_MESH_GROUPS: i32 = 1;
/// `kind` of names: the objects of faces.
pub const CATA_MESH_OBJECTS: i32 = 2;

/// Instead of the number of a name: the face has none.
pub const CATA_MESH_NO_NAME: u32 = u32::MAX;

/// Gets which attributes a mesh has: 1, or 0. NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_has(
    file: *const cata_mesh_file,
    uv: *mut i32,
    normals: *mut i32,
    colors: *mut i32,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`uv`, `normals`, `colors`, one value each), clause `handles`
        // (`file`).
        unsafe {
            let own = &known("file", file)?.file;
            tell! {
                uv: own.uv.is_some().into(),
                normals: own.normals.is_some().into(),
                colors: own.colors.is_some().into(),
            }
        }
        Ok(())
    })
}

/// Gets the texture coordinates: 6 for each face, u and v at its three corners, NaN where a face
/// has none. CATA_ERR_ARGUMENT when the mesh has none.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_get_uv(
    file: *const cata_mesh_file,
    uv: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`uv`, `6 * file.mesh.faces().len()` elements), clause `handles`
        // (`file`).
        let (file, uv) = unsafe {
            let file = &known("file", file)?.file;
            (file, slice_mut("uv", uv, 6 * file.mesh.faces().len())?)
        };
        uv.copy_from_slice(&corners("uv", file, file.uv.as_ref())?);
        Ok(())
    })
}

/// Gets the normals: 9 for each face, x, y, z at its three corners, as long as in the file; NaN
/// where a face has none. CATA_ERR_ARGUMENT when the mesh has none.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_get_normals(
    file: *const cata_mesh_file,
    normals: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`normals`, `9 * file.mesh.faces().len()` elements), clause
        // `handles` (`file`).
        let (file, normals) = unsafe {
            let file = &known("file", file)?.file;
            (file, slice_mut("normals", normals, 9 * file.mesh.faces().len())?)
        };
        normals.copy_from_slice(&corners("normals", file, file.normals.as_ref())?);
        Ok(())
    })
}

/// Gets the colours: 4 for each vertex, red, green, blue and opacity, usually from 0 to 1.
/// CATA_ERR_ARGUMENT when the mesh has none.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_get_colors(
    file: *const cata_mesh_file,
    colors: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`colors`, `4 * file.mesh.vertices().len()` elements), clause
        // `handles` (`file`).
        let (file, colors) = unsafe {
            let file = &known("file", file)?.file;
            (file, slice_mut("colors", colors, 4 * file.mesh.vertices().len())?)
        };
        let found = file.colors.as_ref().ok_or_else(|| none("colors"))?;
        colors.copy_from_slice(found.as_flattened());
        Ok(())
    })
}

/// Sets the texture coordinates: as cata_mesh_file_get_uv returns them; NULL: none.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_set_uv(
    file: *mut cata_mesh_file,
    uv: *const f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`uv`, `6 * file.mesh.faces().len()` elements), clause `handles`
        // (`file`).
        let (file, uv) = unsafe {
            let file = &mut known_mut("file", file)?.file;
            let uv = optional_slice("uv", uv, 6 * file.mesh.faces().len())?;
            (file, uv)
        };
        file.uv = uv.map(|uv| attribute("uv", uv)).transpose()?;
        Ok(())
    })
}

/// Sets the normals: as cata_mesh_file_get_normals returns them; NULL: none.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_set_normals(
    file: *mut cata_mesh_file,
    normals: *const f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`normals`, `9 * file.mesh.faces().len()` elements), clause
        // `handles` (`file`).
        let (file, normals) = unsafe {
            let file = &mut known_mut("file", file)?.file;
            let normals = optional_slice("normals", normals, 9 * file.mesh.faces().len())?;
            (file, normals)
        };
        file.normals = normals.map(|normals| attribute("normals", normals)).transpose()?;
        Ok(())
    })
}

/// Sets the colours: as cata_mesh_file_get_colors returns them; NULL: none.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_set_colors(
    file: *mut cata_mesh_file,
    colors: *const f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`colors`, `4 * file.mesh.vertices().len()` elements), clause
        // `handles` (`file`).
        let (file, colors) = unsafe {
            let file = &mut known_mut("file", file)?.file;
            let colors = optional_slice("colors", colors, 4 * file.mesh.vertices().len())?;
            (file, colors)
        };
        if let Some(i) = colors.unwrap_or_default().iter().position(|x| !x.is_finite()) {
            return Err(Error::NonFinite { what: "colors", index: (i / 4, i % 4) }.into());
        }
        file.colors = colors.map(|colors| colors.as_chunks().0.to_vec());
        Ok(())
    })
}

/// Gets the number of names of faces, 0 when the mesh has none.
///
/// - `kind`: CATA_MESH_MATERIALS, CATA_MESH_GROUPS or CATA_MESH_OBJECTS.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_names(
    file: *const cata_mesh_file,
    kind: i32,
    count: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`count`, one value), clause `handles` (`file`).
        let (file, count) = unsafe { (&known("file", file)?.file, output("count", count)?) };
        *count = names(file, kind)?.len();
        Ok(())
    })
}

/// Gets the name `index` (from 0): `size` elements of `name`, cut to fit, and NUL; in UTF-8. `kind`
/// as in cata_mesh_file_names.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_name(
    file: *const cata_mesh_file,
    kind: i32,
    index: usize,
    size: usize,
    name: *mut c_char,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`name`, `size` elements), clause `handles` (`file`).
        let (file, name) = unsafe { (&known("file", file)?.file, slice_mut("name", name, size)?) };
        write_text(name, element("index", names(file, kind)?, "names", index)?);
        Ok(())
    })
}

/// Gets the number of the name of each face, CATA_MESH_NO_NAME where it has none: n_faces elements.
/// `kind` as in cata_mesh_file_names.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_get_names(
    file: *const cata_mesh_file,
    kind: i32,
    of_faces: *mut u32,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`of_faces`, `file.mesh.faces().len()` elements), clause
        // `handles` (`file`).
        let (file, of_faces) = unsafe {
            let file = &known("file", file)?.file;
            (file, slice_mut("of_faces", of_faces, file.mesh.faces().len())?)
        };
        let labels = labels(file, kind)?;
        match labels {
            Some(labels) => of_faces.copy_from_slice(&labels.of_faces),
            None => of_faces.fill(CATA_MESH_NO_NAME),
        }
        Ok(())
    })
}

/// Sets the names of faces, in place of those that the mesh has. `kind` as in cata_mesh_file_names.
///
/// - `count`: number of names; 0: none.
/// - `names`: `count` texts in UTF-8, NUL-terminated; they are copied.
/// - `of_faces`: n_faces elements, read: the number of the name of each face, or
///   CATA_MESH_NO_NAME.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_set_names(
    file: *mut cata_mesh_file,
    kind: i32,
    count: usize,
    names: *const *const c_char,
    of_faces: *const u32,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`names`, `count` elements), clause `handles` (`file`).
        let (file, texts) = unsafe {
            let file = &mut known_mut("file", file)?.file;
            (file, slice("names", names, count)?)
        };
        labels(file, kind)?;
        let faces = if count == 0 { 0 } else { file.mesh.faces().len() };
        // SAFETY: clause `memory` (`of_faces`, `faces` elements).
        let of_faces = unsafe { slice("of_faces", of_faces, faces) }?;
        let mut names = Vec::with_capacity(count);
        for &name in texts {
            // SAFETY: clause `texts` (`names`).
            names.push(unsafe { utf8("names", name) }?);
        }
        let beyond = |&i: &u32| i != CATA_MESH_NO_NAME && i as usize >= count;
        if let Some(f) = of_faces.iter().position(beyond) {
            let why = format!("of_faces: face {f} has name {}, of {count} names", of_faces[f]);
            return Err(Failure::new(CATA_ERR_ARGUMENT, why));
        }
        let found = (count > 0).then(|| Labels { names, of_faces: of_faces.to_vec() });
        match kind {
            CATA_MESH_MATERIALS => file.materials = found,
            CATA_MESH_GROUPS => file.groups = found,
            _ => file.objects = found,
        }
        Ok(())
    })
}

/// Gets the number of functions on the vertices in the file (VTK, GIFTI, Gmsh).
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_scalars(
    file: *const cata_mesh_file,
    count: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`count`, one value), clause `handles` (`file`).
        let (file, count) = unsafe { (&known("file", file)?.file, output("count", count)?) };
        *count = file.scalars.len();
        Ok(())
    })
}

/// Gets a function on the vertices. NULL where not wanted.
///
/// - `index`: its number, from 0, less than that of cata_mesh_file_scalars.
/// - `name`: `size` elements, written: the name, cut to fit, and NUL; in UTF-8.
/// - `values`: n_vertices elements, written: NaN where there is no value.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_get_scalars(
    file: *const cata_mesh_file,
    index: usize,
    size: usize,
    name: *mut c_char,
    values: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`name`, `size` elements; `values`, `found.values.len()`
        // elements), clause `handles` (`file`).
        unsafe {
            let all = &known("file", file)?.file.scalars;
            let found = element("index", all, "functions", index)?;
            let name = optional_slice_mut("name", name, size)?;
            copy_wanted!(values: &found.values);
            write_text(name.unwrap_or_default(), &found.name);
        }
        Ok(())
    })
}

/// Returns the names of a kind.
fn labels(file: &MeshFile, kind: i32) -> Result<Option<&Labels>, Failure> {
    match kind {
        CATA_MESH_MATERIALS => Ok(file.materials.as_ref()),
        CATA_MESH_GROUPS => Ok(file.groups.as_ref()),
        CATA_MESH_OBJECTS => Ok(file.objects.as_ref()),
        other => Err(Failure::argument("kind", "a kind of names, CATA_MESH_*", other)),
    }
}

fn names(file: &MeshFile, kind: i32) -> Result<&[String], Failure> {
    Ok(match labels(file, kind)? {
        Some(labels) => &labels.names,
        None => &[],
    })
}

fn none(what: &str) -> Failure {
    Failure::new(CATA_ERR_ARGUMENT, format!("{what}: the mesh has none"))
}

/// Returns the values of the corners of faces, NaN where a face has none.
fn corners<const N: usize>(
    what: &str,
    file: &MeshFile,
    attribute: Option<&Attribute<N>>,
) -> Result<Vec<f64>, Failure> {
    let attribute = attribute.ok_or_else(|| none(what))?;
    let of_face = |f| attribute.of_face(&file.mesh, f).unwrap_or([[f64::NAN; N]; 3]);
    Ok((0..file.mesh.faces().len()).flat_map(of_face).flatten().collect())
}

/// Returns the attribute with these values of the corners of faces; a face of NaN alone has none.
fn attribute<const N: usize>(what: &'static str, values: &[f64]) -> Result<Attribute<N>, Failure> {
    let mut values: Vec<[f64; N]> = values.as_chunks().0.to_vec();
    let mut corners = Vec::with_capacity(values.len() / 3);
    for (f, of_face) in values.as_chunks_mut::<3>().0.iter_mut().enumerate() {
        let numbers = of_face.as_flattened_mut();
        if numbers.iter().all(|x| x.is_nan()) {
            numbers.fill(0.0);
            corners.push([Attribute::<N>::ABSENT; 3]);
            continue;
        }
        if let Some(i) = numbers.iter().position(|x| !x.is_finite()) {
            return Err(Error::NonFinite { what, index: (f, i) }.into());
        }
        let first = 3 * f as u32;
        corners.push([first, first + 1, first + 2]);
    }
    Ok(Attribute { values, corners: Some(corners) })
}
