//! Mesh files: reads and writes OBJ, PLY, OFF, STL, glTF, legacy VTK, GIFTI and 3MF, also gzipped
//! (`.gz`), reads VTK's XML, FreeSurfer and Gmsh, and `.xz`, `.bz2`, `.zip` and (feature `columnar`
//! of catamaran) `.zst`.
//!
//! A reader does not trust the file: counts in a header reserve no memory before the bytes are
//! read, an error names the file and the line or the element, and a file that needs more memory
//! than the limit is refused ([`SourceOptions::max_memory`]). The reader notes what it leaves out
//! or replaces ([`MeshFile::notes`]). A writer keeps every bit of the coordinates, except in binary
//! STL, GIFTI and glTF, which have single precision: there it returns a note with the largest
//! distance by which a vertex moves, and an error if a face would vanish. In glTF, coordinates
//! count from the middle of the mesh where that is more accurate, and a node moves them back. The
//! file appears when it is complete, or not at all ([`Output`]).

mod attributes;
mod beside;
mod colors;
mod cursor;
mod dataset;
mod detect;
mod draft;
mod format;
mod formats;
mod freesurfer;
mod gifti;
mod gltf;
mod gmsh;
mod labels;
mod mgh;
mod notes;
mod obj;
mod off;
mod ply;
mod polygon;
mod refined;
mod rounding;
mod stl;
mod stored;
mod text;
mod threemf;
mod vtk;
mod xml;

use std::io::{BufRead, Write};
use std::path::{Path, PathBuf};

pub use attributes::{Attribute, MeshFile, Scalars};
pub use format::MeshFormat;
#[doc(hidden)]
pub use gltf::write_glb;
pub use gltf::{GltfEncoding, Material, Picture};
pub use labels::Labels;
pub use ply::PlyEncoding;
pub use stl::StlEncoding;
pub use vtk::VtkEncoding;

use self::rounding::Rounding;
use catamaran::base::{Error, Result};
use catamaran::io::{Output, Packing, Source, SourceOptions};

/// Reads the mesh in the file at `path`, in the format that its name implies; where the content has
/// another format, the content decides.
///
/// - A polygon becomes a fan of triangles around its first corner where the fan covers it, as for a
///   convex polygon, and is cut into ears otherwise. Triangles that have a vertex twice are left
///   out ([`MeshFile::collapsed_faces`]).
/// - Numbers of colours, normals and texture coordinates that are not finite become 0. A vertex
///   whose position is not finite is left out (OBJ, PLY, OFF) unless a face has it: then it is an
///   error.
/// - Text may be in UTF-8, Latin-1 or UTF-16, with any line ends. An empty file is an error.
/// - `.obj`: `v` (with colours after the position, or those of `#MRGB`), `vt`, `vn`, `f` with
///   negative numbers too, names of materials, groups and objects; other statements, and texture
///   coordinates and normals that the file lacks, are skipped.
/// - `.ply`: ASCII and both binary encodings, properties of any type in any order; faces and
///   triangle strips. Elements of other names, and what the header does not announce, are skipped.
/// - `.off`: with the prefixes ST, C, N, 4 and n, or without a keyword; comments; lines may end
///   anywhere.
/// - `.stl`: binary and text. Vertices with equal coordinates become one. Where the header of a
///   binary file has no number of facets, its size decides.
/// - `.glb`, `.gltf`: the triangles of the scene, at the places of its nodes and their instances,
///   with the morph targets that have a weight; skinned meshes as they are modelled. Vertices of a
///   mesh with equal positions and colours become one. Numbers may be packed by Draco or
///   meshoptimizer. An extension that a file requires is supported or an error.
/// - `.vtk`, `.vtp`, `.vtu`: the faces of polygons and unstructured grids, and the values of their
///   points; text, binary, and XML packed by zlib, LZ4 or LZMA.
/// - `.gii`: points, triangles and values of vertices (GIFTI).
/// - `.white`, `.pial` and others: surfaces of FreeSurfer, of triangles and of quadrilaterals, also
///   as text (`.asc`).
/// - `.msh`: the faces of Gmsh's versions 2 and 4.1, text and binary, and of 1 and 4.0 as text, and
///   values of nodes.
/// - `.3mf`: the objects of the build in their places, in millimetres, without supports.
///
/// What is left out or replaced is in [`MeshFile::notes`].
///
/// ```
/// use catamaran::io::{Output, Overwrite};
/// use catamaran_geometry::mesh::{families, io};
///
/// let path = std::env::temp_dir().join(format!("catamaran-{}.ply", std::process::id()));
/// let sphere = families::icosphere(1)?;
/// io::write(Output::create(&path, Overwrite::Replace)?, &sphere.clone().into())?;
/// assert_eq!(io::read(&path)?.mesh.faces(), sphere.faces());
/// # std::fs::remove_file(path).unwrap();
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Io`] with the file and the line or element; [`Error::Mesh`], with the file, for
/// positions or faces that make no mesh; [`Error::OutOfMemory`].
pub fn read(path: &Path) -> Result<MeshFile> {
    read_with(path, &SourceOptions::new())
}

/// Reads as [`read()`] does, within a limit of memory, and with a callback that receives the
/// fraction of the file read and may cancel.
///
/// ```
/// use catamaran::Error;
/// use catamaran_geometry::mesh::{families, io};
/// use catamaran::io::{Output, Overwrite, SourceOptions};
/// use std::ops::ControlFlow;
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("sphere.obj");
/// io::write(Output::create(path, Overwrite::Never)?, &families::icosphere(1)?.into())?;
/// let cancel = |_| ControlFlow::Break(());
/// let stopped = io::read_with(path, &SourceOptions::new().progress(&cancel));
/// assert_eq!(stopped, Err(Error::Cancelled));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As those of [`read()`], and [`Error::Cancelled`].
pub fn read_with(path: &Path, options: &SourceOptions<'_>) -> Result<MeshFile> {
    if path.metadata().is_ok_and(|about| about.is_file() && about.len() == 0) {
        return Err(empty(path));
    }
    let (named, named_packing) = MeshFormat::named(path);
    let packing = |head: &[u8]| formats::packing(head, (named, named_packing));
    let mut source = Source::open_packed(path, packing, options)?;
    let head = source.peek(text::LOOK)?;
    if head.is_empty() {
        return Err(empty(path));
    }
    let found = formats::format(&head, source.size());
    if let (None, Some(what)) = (found, detect::other(&head)) {
        return Err(Error::file(
            path,
            format!("is no mesh of a known format: it seems to be {what}"),
        ));
    }
    let mut notes = Vec::new();
    if source.packing() != named_packing {
        notes.push(format!("{}, although its name says otherwise", source.packing()));
    }
    let format = match (named, found) {
        (Some(named), Some(detected)) if named.title() != detected.title() => {
            let (named, found) = (named.title(), detected.title());
            notes.push(format!("read as {found}, the format of its content, and not as {named}"));
            detected
        }
        (Some(named), _) => named,
        (None, Some(found)) => {
            notes.push(format!("read as {}, the format of its content", found.title()));
            found
        }
        (None, None) if names_values(&MeshFormat::ending(path)) => {
            let what = "has values of vertices by its name, but no surface: read the file of the \
                        surface, and this one as its functions (read_scalars, or filter \
                        --functions)";
            return Err(Error::file(path, what));
        }
        (None, None) => {
            let (known, read) = (formats::titles(), MeshFormat::readable());
            let what = format!(
                "unknown kind of mesh: name and content are not {known}; the name may end in {read}"
            );
            return Err(Error::file(path, what));
        }
    };
    let mut file = read_source(&mut source, format, path)?;
    notes.append(&mut file.notes);
    Ok(MeshFile { notes, ..file })
}

/// Returns the rows of the table of formats in the guide, in Markdown: name, endings, coordinates
/// and what else is stored.
#[doc(hidden)]
pub fn rows_of_guide() -> String {
    formats::rows()
}

fn empty(path: &Path) -> Error {
    Error::file(path, "is empty: it has 0 bytes")
}

/// Reads the mesh in `bytes`, which are not packed, like a file.
///
/// ```
/// use catamaran_geometry::mesh::io::{MeshFormat, read_bytes};
///
/// let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
/// assert_eq!(read_bytes(text, MeshFormat::Obj)?.mesh.faces(), [[0, 1, 2]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As those of [`read()`]; the path is that of the format's usual name.
pub fn read_bytes(bytes: &[u8], format: MeshFormat) -> Result<MeshFile> {
    let path = &usual_name(format);
    if bytes.is_empty() {
        return Err(empty(path));
    }
    read_source(&mut Source::of_bytes(path, bytes), format, path)
}

/// Returns the name of a file of this format that errors about bytes in memory have.
fn usual_name(format: MeshFormat) -> PathBuf {
    let endings = format.description().endings;
    let own = endings.iter().find(|(_, known)| *known == format).or(endings.first());
    format!("mesh.{}", own.map_or("", |(ending, _)| *ending)).into()
}

fn read_source(source: &mut Source<'_>, format: MeshFormat, path: &Path) -> Result<MeshFile> {
    // Text of other encodings and line ends is rewritten; it is rare, so memory matters less.
    let unusual = source.fill_buf().map(|head| {
        let start = &head[..head.len().min(8)];
        (text::of_utf16(start).is_some(), text::ends_in_returns(head))
    });
    let (is_utf16, ends_in_returns) = unusual.map_err(|e| source.io_error(e))?;
    if is_utf16 || ends_in_returns {
        let bytes = source.read_all()?;
        let mut bytes = text::of_utf16(&bytes).unwrap_or(bytes);
        if text::ends_in_returns(&bytes) {
            text::returns_to_feeds(&mut bytes);
        }
        return read_lines(&mut source.rewritten(&bytes), format, path);
    }
    read_lines(source, format, path)
}

fn read_lines(source: &mut Source<'_>, format: MeshFormat, path: &Path) -> Result<MeshFile> {
    let read = (format.description().read)(source);
    read.map_err(|error| match error {
        Error::Mesh { what, element } => {
            Error::Mesh { what, element: format!("{}: {element}", path.display()) }
        }
        other => other,
    })
}

/// Reads the values of vertices in the file at `path`, within a limit of memory: those of a mesh,
/// of a GIFTI file without a surface, of a file of FreeSurfer (`.curv`, `.thickness` and others,
/// `.mgh`, `.mgz`), or the numbers of labels of its `.annot`, -1 for none.
///
/// ```
/// use catamaran::io::SourceOptions;
/// use catamaran_geometry::mesh::io::read_scalars;
///
/// # let folder = tempfile::tempdir().unwrap();
/// let path = &folder.path().join("lh.thickness");
/// // The number of vertices, of faces, and of values of a vertex.
/// let head = [&[255u8; 3][..], &[0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 1]].concat();
/// std::fs::write(path, [head, [2.5f32, 3.0].map(f32::to_be_bytes).concat()].concat()).unwrap();
/// let thickness = &read_scalars(path, &SourceOptions::new())?[0];
/// assert_eq!((&thickness.name[..], &thickness.values[..]), ("thickness", &[2.5, 3.0][..]));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As those of [`read_with()`], also when the file has no values of vertices.
pub fn read_scalars(path: &Path, options: &SourceOptions<'_>) -> Result<Vec<Scalars>> {
    let ending = MeshFormat::ending(path);
    let (mut source, content) = detected(path, options)?;
    let scalars = match content {
        _ if ending == "annot" => freesurfer::scalars(&mut source)?,
        Content::Mgh => mgh::scalars(&mut source, &name_of_values(path))?,
        Content::Mesh(MeshFormat::Gifti) => gifti::scalars(&mut source)?,
        Content::Mesh(MeshFormat::FreeSurfer) => freesurfer::scalars(&mut source)?,
        Content::Unknown if is_mgh(&ending) => {
            return Err(source.fail_at(None, "is no file of values (MGH): damaged, or another one"));
        }
        Content::Unknown if MeshFormat::named(path).0.is_none() => {
            freesurfer::scalars(&mut source)?
        }
        _ => {
            let MeshFile { scalars, notes, .. } = read_with(path, options)?;
            if scalars.is_empty() && !notes.is_empty() {
                let what = format!("has no values of vertices: {}", notes.join("; "));
                return Err(Error::file(path, what));
            }
            scalars
        }
    };
    match scalars.is_empty() {
        true => Err(Error::file(path, "has no values of vertices")),
        false => Ok(scalars),
    }
}

/// What the beginning of a file tells about its content.
enum Content {
    Mesh(MeshFormat),
    /// Values of vertices.
    Mgh,
    Unknown,
}

impl Content {
    fn is_known(&self) -> bool {
        !matches!(self, Self::Unknown)
    }
}

/// Opens a file, and returns what its content is.
fn detected<'a>(path: &Path, options: &SourceOptions<'a>) -> Result<(Source<'a>, Content)> {
    let named = MeshFormat::named(path);
    let mut source = Source::open_packed(path, |head| formats::packing(head, named), options)?;
    let head = source.peek(text::LOOK)?;
    let content = match formats::format(&head, source.size()) {
        _ if mgh::begins(&head) => Content::Mgh,
        Some(format) => Content::Mesh(format),
        None => Content::Unknown,
    };
    Ok((source, content))
}

/// Returns the name of the values in a file such as `lh.thickness.mgz`: thickness.
fn name_of_values(path: &Path) -> String {
    let name = format::name(path);
    let (name, _) = Packing::of(&name);
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    stem.rsplit('.').next().unwrap_or_default().to_owned()
}

/// Returns whether [`read_scalars`] reads this file, and not the reader of tables: its name is that
/// of values of FreeSurfer or of a mesh format that stores values of vertices (VTK, GIFTI, Gmsh),
/// or its content is that of FreeSurfer or of a mesh.
///
/// ```
/// use catamaran_geometry::mesh::io::holds_scalars;
///
/// # let folder = tempfile::tempdir().unwrap();
/// let path = &folder.path().join("lh.area.pial");
/// std::fs::write(path, [255u8, 255, 255, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1]).unwrap();
/// assert!(holds_scalars(path) && holds_scalars("lh.thickness".as_ref()));
/// assert!(!holds_scalars("a.csv".as_ref()));
/// ```
pub fn holds_scalars(path: &Path) -> bool {
    let ending = MeshFormat::ending(path);
    // What is read from a pipe is gone.
    let by_content = || {
        path.is_file()
            && detected(path, &SourceOptions::new()).is_ok_and(|(_, content)| content.is_known())
    };
    formats::has_functions(&ending) || names_values(&ending) || by_content()
}

/// Returns whether files whose names end so are values of vertices, of FreeSurfer.
fn names_values(ending: &str) -> bool {
    let is_freesurfer =
        matches!(ending, "annot" | "area" | "avg_curv" | "curv" | "sulc" | "thickness" | "volume");
    is_freesurfer || is_mgh(ending)
}

/// Returns whether files whose names end so are MGH.
fn is_mgh(ending: &str) -> bool {
    matches!(ending, "mgh" | "mgz")
}

/// Writes `file` into `output` in the format that its name implies; the file appears when it is
/// complete. Returns notes, one line each, about what the file does not hold as it is here:
/// attributes that the format can't store ([`MeshFormat::left_out`]), and numbers that it rounds.
///
/// ```
/// use catamaran::io::{Output, Overwrite};
/// use catamaran_geometry::mesh::{families, io};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("grid.off");
/// let notes = io::write(Output::create(path, Overwrite::Never)?, &families::grid(2, 1)?.into())?;
/// assert!(std::fs::read_to_string(path).unwrap().starts_with("OFF\n6 4 "));
/// assert!(notes.is_empty());
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Io`], also for a coordinate that the format can't store and for faces that would vanish
/// when their corners are rounded, [`Error::Shape`] when attributes do not fit the mesh, and
/// [`Error::NonFinite`] for their numbers; no file is left behind then.
pub fn write(output: Output, file: &MeshFile) -> Result<Vec<String>> {
    let format = MeshFormat::of(output.path())?;
    write_as(output, file, format)
}

/// Writes as [`write()`] does, in the format or encoding `format`, whatever the name; a file whose
/// name ends in `.gz` is packed.
///
/// ```
/// use catamaran::io::{Output, Overwrite};
/// use catamaran_geometry::mesh::{families, io::{MeshFormat, PlyEncoding, read, write_as}};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("sphere.ply");
/// let sphere = families::icosphere(1)?;
/// let output = Output::create(path, Overwrite::Never)?;
/// write_as(output, &sphere.clone().into(), MeshFormat::Ply(PlyEncoding::Ascii))?;
/// assert!(std::fs::read(path).unwrap().starts_with(b"ply\nformat ascii"));
/// assert_eq!(read(path)?.mesh.faces(), sphere.faces());
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As those of [`write()`].
pub fn write_as(output: Output, file: &MeshFile, format: MeshFormat) -> Result<Vec<String>> {
    write_file(output, file, format, |sink, rounding| encode(sink, file, format, rounding))
}

/// Returns the bytes of a file of this format, which are not packed, and the notes that
/// [`write()`] returns.
///
/// ```
/// use catamaran_geometry::mesh::{families, io::{MeshFormat, read_bytes, write_bytes}};
///
/// let sphere = families::icosphere(1)?;
/// let (bytes, notes) = write_bytes(&sphere.clone().into(), MeshFormat::Off)?;
/// assert!(bytes.starts_with(b"OFF\n42 80 ") && notes.is_empty());
/// assert_eq!(read_bytes(&bytes, MeshFormat::Off)?.mesh, sphere);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As those of [`write()`]; the path is that of the format's usual name.
pub fn write_bytes(file: &MeshFile, format: MeshFormat) -> Result<(Vec<u8>, Vec<String>)> {
    let path = &usual_name(format);
    let rounding = rounding_of(path, file, format)?;
    let mut bytes = Vec::new();
    encode(&mut bytes, file, format, &rounding).map_err(|e| Error::io(path, e))?;
    Ok((bytes, notes_about(file, format, &rounding)))
}

/// Writes the bytes of a file of this format.
fn encode(
    sink: &mut dyn Write,
    file: &MeshFile,
    format: MeshFormat,
    rounding: &Rounding,
) -> std::io::Result<()> {
    match format {
        MeshFormat::Obj => obj::write(sink, file),
        MeshFormat::Ply(encoding) => ply::write(sink, file, encoding),
        MeshFormat::Off => off::write(sink, file),
        MeshFormat::Stl(encoding) => stl::write(sink, &file.mesh, encoding),
        MeshFormat::Gltf(encoding) => gltf::write(sink, file, encoding, rounding),
        MeshFormat::Vtk(encoding) => vtk::write(sink, file, encoding),
        MeshFormat::Gifti => gifti::write(sink, file, rounding),
        MeshFormat::ThreeMf => threemf::write(sink, &file.mesh),
        MeshFormat::VtkXml | MeshFormat::FreeSurfer | MeshFormat::Gmsh => {
            let what = format!("{} files can only be read", format.title());
            Err(std::io::Error::new(std::io::ErrorKind::Unsupported, what))
        }
    }
}

/// Writes a file by `body`, which is told how the format rounds coordinates. Returns the notes.
fn write_file(
    output: Output,
    file: &MeshFile,
    format: MeshFormat,
    body: impl FnOnce(&mut dyn Write, &Rounding) -> std::io::Result<()>,
) -> Result<Vec<String>> {
    let rounding = rounding_of(output.path(), file, format)?;
    write_packed(output, |sink| body(sink, &rounding))?;
    Ok(notes_about(file, format, &rounding))
}

/// Returns how the format rounds coordinates, or an error that names `path` for what it can't
/// store.
fn rounding_of(path: &Path, file: &MeshFile, format: MeshFormat) -> Result<Rounding> {
    file.check()?;
    file.check_finite()?;
    match format {
        MeshFormat::Stl(StlEncoding::Binary) | MeshFormat::Gifti => {
            Rounding::from_zero(&file.mesh, path)
        }
        MeshFormat::Gltf(_) => Rounding::from_middle(&file.mesh, path),
        _ => Ok(Rounding::default()),
    }
}

/// Returns the notes about what a file of this format does not hold as it is here.
fn notes_about(file: &MeshFile, format: MeshFormat, rounding: &Rounding) -> Vec<String> {
    let mut notes = Vec::new();
    let left_out = format.left_out(file);
    if !left_out.is_empty() {
        notes.push(format!("this format can't store {}", left_out.join(", ")));
    }
    rounding.note(&file.mesh, &mut notes);
    format.note_rounded(file, &mut notes);
    notes
}

/// Writes a mesh as glTF (`.glb` or `.gltf`, and `.gz` after it) with this material on all faces,
/// its pictures as PNG in the same file. The names of the materials of `file` are left out. Returns
/// notes as [`write()`] does.
///
/// Viewers that light a mesh smoothly use its normals from [`MeshFile::normals`]. Tangents are not
/// written; glTF recommends that viewers compute them from normals and texture coordinates
/// (MikkTSpace).
///
/// ```
/// use catamaran::io::{Output, Overwrite};
/// use catamaran_geometry::mesh::families;
/// use catamaran_geometry::mesh::io::{Attribute, Material, MeshFile, Picture, write_with_material};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("chequered.glb");
/// let mut file = MeshFile::from(families::grid(2, 2)?);
/// let values = file.mesh.vertices().iter().map(|p| [p[0], p[1]]).collect();
/// file.uv = Some(Attribute { values, corners: None });
/// let chequers = Picture::rgb(2, &[[250; 3], [20; 3], [20; 3], [250; 3]])?;
/// let material = Material::new().name("chequers").base_color(chequers).roughness(0.3);
/// write_with_material(Output::create(path, Overwrite::Never)?, &file, &material)?;
/// assert!(std::fs::read(path).unwrap().starts_with(b"glTF"));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Io`] when the name does not end in `.glb` or `.gltf`, and as [`write()`];
/// [`Error::Argument`] for a material with pictures when a face of the mesh has no texture
/// coordinates, and for numbers of the material out of their range.
pub fn write_with_material(
    output: Output,
    file: &MeshFile,
    material: &Material,
) -> Result<Vec<String>> {
    let format = MeshFormat::of(output.path())?;
    let MeshFormat::Gltf(encoding) = format else {
        return Err(Error::file(output.path(), "only .glb and .gltf store a material"));
    };
    file.check()?;
    material.check(file)?;
    let mut notes = write_file(output, file, format, |sink, rounding| {
        gltf::write_with_material(sink, file, encoding, rounding, material)
    })?;
    if file.materials.is_some() {
        notes.push("left out the names of materials, in place of which is the given one".into());
    }
    Ok(notes)
}

fn write_packed(
    mut output: Output,
    body: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<()> {
    let name = output.path().to_string_lossy().to_ascii_lowercase();
    let (_, packing) = Packing::of(&name);
    let written = match packing {
        Packing::None => body(&mut output),
        Packing::Gzip => {
            let mut encoder =
                flate2::write::GzEncoder::new(&mut output, flate2::Compression::default());
            body(&mut encoder).and_then(|()| encoder.finish().map(|_| ()))
        }
        other => Err(std::io::Error::other(only_read(other))),
    };
    written.map_err(|e| output.error(e))?;
    output.commit()
}

/// Returns an error unless [`write()`] knows the format that the name of the file implies.
///
/// ```
/// use catamaran_geometry::mesh::io::check_name;
///
/// assert!(check_name("a.stl".as_ref()).is_ok());
/// assert!(check_name("a.doc".as_ref()).is_err());
/// ```
///
/// # Errors
/// [`Error::Io`] when it does not.
pub fn check_name(path: &Path) -> Result<()> {
    MeshFormat::of(path)?;
    match MeshFormat::named(path) {
        (_, Packing::None | Packing::Gzip) => Ok(()),
        (_, other) => Err(Error::file(path, only_read(other))),
    }
}

fn only_read(packing: Packing) -> String {
    format!("{} files can only be read; write .gz instead", packing.ending())
}
