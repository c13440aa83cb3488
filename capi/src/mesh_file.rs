//! # Mesh files
//!
//! Meshes with texture coordinates, normals, colours and names, from and to files (.obj, .ply,
//! .off, .stl, .glb, .gltf, .vtk, .gii and .3mf, also packed: .gz) and their bytes in memory; also
//! from .vtp, .vtu, .msh, surfaces of FreeSurfer, and what .xz, .bz2 and .zip pack.
//!
//! ```c
//! const char text[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
//! cata_mesh_file *file;
//! size_t n_vertices;
//! cata_mesh_file_read_bytes(sizeof text - 1, text, CATA_MESH_OBJ, &file);
//! cata_mesh_file_size(file, &n_vertices, NULL);
//! printf("%zu vertices\n", n_vertices); // 3 vertices
//! cata_mesh_file_free(file);
//! ```

use std::ffi::{c_char, c_void};

use super::boundary::{boundary, path};
use super::outputs::{copy, element, fill_mesh, tell, write_text};
use super::params::{Params, flag, init, params, read_or_zeros};
use super::pointer::{free, hand_over, known, known_mut, mesh_arrays, output, slice, slice_mut};
use super::progress::cata_progress;
use super::status::{Failure, cata_status};
use catamaran::io::{Output, Overwrite, SourceOptions};
use catamaran_geometry::mesh::io::{
    GltfEncoding, MeshFile, MeshFormat, PlyEncoding, StlEncoding, VtkEncoding, read_bytes,
    read_with, write_as, write_bytes,
};

/// `format`: what the name of the file says.
pub const CATA_MESH_BY_NAME: i32 = 0;
/// `format`: Wavefront OBJ.
pub const CATA_MESH_OBJ: i32 = 1;
/// `format`: PLY, binary.
pub const CATA_MESH_PLY: i32 = 2;
/// `format`: PLY as text.
pub const CATA_MESH_PLY_TEXT: i32 = 3;
/// `format`: Geomview OFF.
pub const CATA_MESH_OFF: i32 = 4;
/// `format`: STL, binary: coordinates are rounded to float.
pub const CATA_MESH_STL: i32 = 5;
/// `format`: STL as text.
pub const CATA_MESH_STL_TEXT: i32 = 6;
/// `format`: glTF, binary: coordinates are rounded to float.
pub const CATA_MESH_GLB: i32 = 7;
/// `format`: glTF as text: coordinates are rounded to float.
pub const CATA_MESH_GLTF: i32 = 8;
/// `format`: legacy VTK, binary.
pub const CATA_MESH_VTK: i32 = 9;
/// `format`: legacy VTK as text.
pub const CATA_MESH_VTK_TEXT: i32 = 10;
/// `format`: GIFTI: coordinates are rounded to float.
pub const CATA_MESH_GIFTI: i32 = 11;
/// `format`: 3MF, in millimetres.
pub const CATA_MESH_3MF: i32 = 12;
/// `format`: XML files of VTK, only read.
pub const CATA_MESH_VTK_XML: i32 = 13;
/// `format`: surfaces of FreeSurfer, only read.
pub const CATA_MESH_FREESURFER: i32 = 14;
/// `format`: Gmsh, only read.
pub const CATA_MESH_GMSH: i32 = 15;

/// How mesh files are read and written.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_mesh_file_params {
    /// sizeof(cata_mesh_file_params).
    pub struct_size: usize,
    /// Ignored.
    pub threads: usize,
    /// Progress callback; NULL: none.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
    /// For reading: bytes of memory that the file may take; 0: a hundred times its size, or 1 GiB
    /// if that is more.
    pub max_memory: u64,
    /// For writing: CATA_MESH_*.
    pub format: i32,
    /// For writing: 1: an existing file stays, and CATA_ERR_IO is returned. 0: it is replaced.
    pub keep: i32,
}

params!(cata_mesh_file_params, keep: i32);

/// A mesh with its attributes, as in a file.
pub struct cata_mesh_file {
    pub(super) file: MeshFile,
}

/// The bytes of a file. Made by cata_mesh_file_write_bytes; constant.
pub struct cata_mesh_bytes {
    bytes: Vec<u8>,
}

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_params_init(
    params: *mut cata_mesh_file_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Creates a mesh without attributes, of which it keeps a copy. Triangles that have a vertex twice
/// are left out, as those of files are; cata_mesh_file_notes counts them.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_new(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    file: *mut *mut cata_mesh_file,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `file`, one
        // value).
        let ((vertices, faces), place) =
            unsafe { (mesh_arrays(n_vertices, vertices, n_faces, faces)?, output("file", file)?) };
        let file = MeshFile::from_arrays(vertices.to_vec(), faces.to_vec())?;
        hand_over(place, cata_mesh_file { file });
        Ok(())
    })
}

/// Reads a mesh in the format that the name of the file says; where its content has another one,
/// that of the content. Polygons are cut into triangles, and the triangles that have a vertex twice
/// are left out. CATA_ERR_IO: the message names the file, the line, and what is wrong with it.
///
/// - `path`: NUL-terminated; with .gz, .xz or .bz2 at its end, packed.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_read(
    path: *const c_char,
    params: *const cata_mesh_file_params,
    file: *mut *mut cata_mesh_file,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`file`, one value), clause `structs` (`params`), clause `texts`
        // (`path`).
        let (path, params, place) = unsafe {
            (self::path("path", path)?, read_or_zeros("params", params)?, output("file", file)?)
        };
        params.chosen()?;
        let found = params.caller().reported(|progress| {
            let memory = (params.max_memory > 0).then_some(params.max_memory);
            let options = SourceOptions::new().max_memory(memory).progress(progress);
            Ok(read_with(&path, &options)?)
        })?;
        hand_over(place, cata_mesh_file { file: found });
        Ok(())
    })
}

/// Reads a mesh as cata_mesh_file_read does, from the bytes of a file that is not packed.
///
/// - `size`: number of bytes; `format`: CATA_MESH_* but CATA_MESH_BY_NAME: of both variants of a
///   format, either.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_read_bytes(
    size: usize,
    bytes: *const c_void,
    format: i32,
    file: *mut *mut cata_mesh_file,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`bytes`, `size` elements; `file`, one value).
        let (bytes, place) =
            unsafe { (slice("bytes", bytes.cast::<u8>(), size)?, output("file", file)?) };
        let file = read_bytes(bytes, self::format("format", format)?)?;
        hand_over(place, cata_mesh_file { file });
        Ok(())
    })
}

/// Writes a mesh; the file appears whole or not at all. The notes of `file` become those about what
/// the new file does not hold as it is here, such as attributes that its format can't store.
///
/// - `path`: NUL-terminated; with .gz at its end the file is packed.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_write(
    file: *mut cata_mesh_file,
    path: *const c_char,
    params: *const cata_mesh_file_params,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `handles` (`file`), clause `structs` (`params`), clause `texts` (`path`).
        let (file, path, params) = unsafe {
            let file = &mut known_mut("file", file)?.file;
            (file, self::path("path", path)?, read_or_zeros("params", params)?)
        };
        let (format, overwrite) = params.chosen()?;
        file.notes = params.caller().reported(|_| {
            let format = format.map_or_else(|| MeshFormat::of(&path), Ok)?;
            Ok(write_as(Output::create(&path, overwrite)?, file, format)?)
        })?;
        Ok(())
    })
}

/// Writes a mesh into memory, as cata_mesh_file_write does into a file that is not packed.
///
/// - `format`: CATA_MESH_* but CATA_MESH_BY_NAME.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_write_bytes(
    file: *mut cata_mesh_file,
    format: i32,
    bytes: *mut *mut cata_mesh_bytes,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`bytes`, one value), clause `handles` (`file`).
        let (file, place) =
            unsafe { (&mut known_mut("file", file)?.file, output("bytes", bytes)?) };
        let (bytes, notes) = write_bytes(file, self::format("format", format)?)?;
        file.notes = notes;
        hand_over(place, cata_mesh_bytes { bytes });
        Ok(())
    })
}

/// Frees a mesh.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_free(file: *mut cata_mesh_file) {
    // SAFETY: clause `handles` (`file`).
    unsafe { free(file) };
}

/// Gets the numbers of vertices and faces. NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_size(
    file: *const cata_mesh_file,
    n_vertices: *mut usize,
    n_faces: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`n_vertices`, one value; `n_faces`, one value), clause `handles`
        // (`file`).
        unsafe {
            let mesh = &known("file", file)?.file.mesh;
            tell!(n_vertices: mesh.vertices().len(), n_faces: mesh.faces().len());
        }
        Ok(())
    })
}

/// Gets the vertices and faces, as many as cata_mesh_file_size tells. NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_get(
    file: *const cata_mesh_file,
    vertices: *mut f64,
    faces: *mut u32,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `handles` (`file`), clause `passed on` (`fill_mesh`).
        unsafe { fill_mesh(&known("file", file)?.file.mesh, vertices, faces) }
    })
}

/// Gets the numbers of notes and of triangles that are left out because two of their corners are
/// one vertex. A note says what the reader left out or replaced, or what the file that was written
/// last does not hold. NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_notes(
    file: *const cata_mesh_file,
    notes: *mut usize,
    collapsed_faces: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`notes`, one value; `collapsed_faces`, one value), clause
        // `handles` (`file`).
        unsafe {
            let own = &known("file", file)?.file;
            tell!(notes: own.notes.len(), collapsed_faces: own.collapsed_faces);
        }
        Ok(())
    })
}

/// Gets the note `index` (from 0): `size` elements of `text`, cut to fit, and NUL; in UTF-8.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_file_note(
    file: *const cata_mesh_file,
    index: usize,
    size: usize,
    text: *mut c_char,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`text`, `size` elements), clause `handles` (`file`).
        let (notes, text) =
            unsafe { (&known("file", file)?.file.notes, slice_mut("text", text, size)?) };
        write_text(text, element("index", notes, "notes", index)?);
        Ok(())
    })
}

/// Gets the number of bytes.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_bytes_size(
    bytes: *const cata_mesh_bytes,
    size: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`size`, one value), clause `handles` (`bytes`).
        let (own, size) = unsafe { (&known("bytes", bytes)?.bytes, output("size", size)?) };
        *size = own.len();
        Ok(())
    })
}

/// Gets the bytes, as many as cata_mesh_bytes_size tells.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_bytes_get(
    bytes: *const cata_mesh_bytes,
    to: *mut c_void,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`to`, one element for each), clause `handles` (`bytes`).
        unsafe { copy("to", to.cast::<u8>(), &known("bytes", bytes)?.bytes) }
    })
}

/// Frees bytes.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_bytes_free(bytes: *mut cata_mesh_bytes) {
    // SAFETY: clause `handles` (`bytes`).
    unsafe { free(bytes) };
}

impl cata_mesh_file_params {
    /// Returns the format, `None` for that of the name, and what becomes of a file that is there.
    fn chosen(&self) -> Result<(Option<MeshFormat>, Overwrite), Failure> {
        let format = match self.format {
            CATA_MESH_BY_NAME => None,
            other => Some(format("params.format", other)?),
        };
        let overwrite = match flag("params.keep", self.keep)? {
            true => Overwrite::Never,
            false => Overwrite::Replace,
        };
        Ok((format, overwrite))
    }
}

/// Returns the format that a constant stands for.
fn format(what: &str, value: i32) -> Result<MeshFormat, Failure> {
    Ok(match value {
        CATA_MESH_OBJ => MeshFormat::Obj,
        CATA_MESH_PLY => MeshFormat::Ply(PlyEncoding::LittleEndian),
        CATA_MESH_PLY_TEXT => MeshFormat::Ply(PlyEncoding::Ascii),
        CATA_MESH_OFF => MeshFormat::Off,
        CATA_MESH_STL => MeshFormat::Stl(StlEncoding::Binary),
        CATA_MESH_STL_TEXT => MeshFormat::Stl(StlEncoding::Ascii),
        CATA_MESH_GLB => MeshFormat::Gltf(GltfEncoding::Binary),
        CATA_MESH_GLTF => MeshFormat::Gltf(GltfEncoding::Text),
        CATA_MESH_VTK => MeshFormat::Vtk(VtkEncoding::Binary),
        CATA_MESH_VTK_TEXT => MeshFormat::Vtk(VtkEncoding::Ascii),
        CATA_MESH_GIFTI => MeshFormat::Gifti,
        CATA_MESH_3MF => MeshFormat::ThreeMf,
        CATA_MESH_VTK_XML => MeshFormat::VtkXml,
        CATA_MESH_FREESURFER => MeshFormat::FreeSurfer,
        CATA_MESH_GMSH => MeshFormat::Gmsh,
        other => return Err(Failure::argument(what, "a format, CATA_MESH_*", other)),
    })
}
