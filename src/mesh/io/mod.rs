//! Mesh files: OBJ, PLY, OFF and STL in and out, each also gzipped (`.gz`), and `.xz` in.
//!
//! A reader trusts nothing: counts in a header reserve no memory before the bytes are there, what is broken is an error that
//! names the file and the line or the element, and a file that takes more memory than it may is refused
//! ([`SourceOptions::max_memory`]). A writer keeps every bit of the coordinates, but for binary STL, which has single precision, and shows
//! its file whole or not at all ([`Output`]).

mod attributes;
mod draft;
mod obj;
mod off;
mod ply;
mod stl;
mod text;

use std::io::Write;
use std::path::Path;

pub use attributes::{Attribute, MeshFile};
pub use ply::PlyEncoding;
pub use stl::StlEncoding;

use crate::base::{Error, Result};
use crate::io::{Output, Packing, Source, SourceOptions};

/// The format of a mesh file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshFormat {
    /// Wavefront OBJ: `v`, `vt`, `vn`, `f`; text.
    Obj,
    /// Stanford PLY. The encoding matters for writing only: a file says its own.
    Ply(PlyEncoding),
    /// Geomview OFF: text.
    Off,
    /// Stereolithography STL. The encoding matters for writing only: it is recognised.
    Stl(StlEncoding),
}

impl MeshFormat {
    /// What the name of a file says, and how it is packed: `.obj`, `.ply` (binary, little endian), `.off`, `.stl` (binary).
    fn of(path: &Path) -> Result<(Self, Packing)> {
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let (stem, packing) = Packing::of(&name);
        let format = match stem.rsplit_once('.').map(|(_, extension)| extension) {
            Some("obj") => Self::Obj,
            Some("ply") => Self::Ply(PlyEncoding::LittleEndian),
            Some("off") => Self::Off,
            Some("stl") => Self::Stl(StlEncoding::Binary),
            _ => {
                let what = "unknown kind of mesh: the name must end in .obj, .ply, .off or .stl, and may have .gz or \
                            (for reading) .xz after it";
                return Err(Error::file(path, what));
            }
        };
        Ok((format, packing))
    }
}

/// Reads the mesh in the file at `path`, of the format its name says.
///
/// - Polygons are cut into the triangles between their first corner and each of their other edges, which is right for convex
///   ones.
/// - `.obj`: `v` (with colours after the position), `vt`, `vn`, `f` with negative numbers too; other statements are skipped,
///   unknown ones refused.
/// - `.ply`: ASCII and both binary encodings, properties of any type in any order; elements other than `vertex` and `face`
///   are skipped.
/// - `.off`: with the prefixes ST, C and N; comments.
/// - `.stl`: binary and text. Vertices with equal coordinates become one; facets that lose their corners by that are left
///   out and counted ([`MeshFile::collapsed_faces`]).
///
/// ```
/// use catamaran::{io::{Output, Overwrite}, mesh::{families, io}};
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
/// [`Error::Io`] with file and line or element; [`Error::Mesh`], with the file, for positions or faces that make no mesh;
/// [`Error::OutOfMemory`].
pub fn read(path: &Path) -> Result<MeshFile> {
    read_with(path, &SourceOptions::new())
}

/// [`read()`] within a limit of memory, and with a callback that is told the fraction of the file read and may
/// cancel.
///
/// ```
/// use catamaran::{Error, mesh::{families, io}};
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
    let (format, packing) = MeshFormat::of(path)?;
    read_source(&mut Source::open(path, packing, options)?, format, path)
}

/// Reads the mesh in these bytes, not packed, as if they were a file.
///
/// ```
/// use catamaran::mesh::io::{MeshFormat, read_bytes};
///
/// let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
/// assert_eq!(read_bytes(text, MeshFormat::Obj)?.mesh.faces(), [[0, 1, 2]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As those of [`read()`]; the path is that of the format's usual name.
pub fn read_bytes(bytes: &[u8], format: MeshFormat) -> Result<MeshFile> {
    let path = Path::new(match format {
        MeshFormat::Obj => "mesh.obj",
        MeshFormat::Ply(_) => "mesh.ply",
        MeshFormat::Off => "mesh.off",
        MeshFormat::Stl(_) => "mesh.stl",
    });
    read_source(&mut Source::of_bytes(path, bytes), format, path)
}

fn read_source(source: &mut Source<'_>, format: MeshFormat, path: &Path) -> Result<MeshFile> {
    let read = match format {
        MeshFormat::Obj => obj::read(source),
        MeshFormat::Ply(_) => ply::read(source),
        MeshFormat::Off => off::read(source),
        MeshFormat::Stl(_) => stl::read(source),
    };
    read.map_err(|error| match error {
        Error::Mesh { what, element } => {
            Error::Mesh { what, element: format!("{}: {element}", path.display()) }
        }
        other => other,
    })
}

/// Writes `file` into `output`, in the format its name says, and lets it appear. What the format has no place for is left
/// out: STL takes positions only, PLY and OFF take normals of vertices only, OFF takes UV of vertices only.
///
/// ```
/// use catamaran::{io::{Output, Overwrite}, mesh::{families, io}};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("grid.off");
/// io::write(Output::create(path, Overwrite::Never)?, &families::grid(2, 1)?.into())?;
/// assert!(std::fs::read_to_string(path).unwrap().starts_with("OFF\n6 4 "));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Io`], [`Error::Shape`] when attributes do not fit the mesh; nothing is left behind then.
pub fn write(output: Output, file: &MeshFile) -> Result<()> {
    let (format, _) = MeshFormat::of(output.path())?;
    write_as(output, file, format)
}

/// [`write()`] in another format or encoding than that of the name; packed by `.gz` in the name all the same.
///
/// ```
/// use catamaran::io::{Output, Overwrite};
/// use catamaran::mesh::{families, io::{MeshFormat, PlyEncoding, read, write_as}};
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
pub fn write_as(mut output: Output, file: &MeshFile, format: MeshFormat) -> Result<()> {
    let name = output.path().to_string_lossy().to_ascii_lowercase();
    let (_, packing) = Packing::of(&name);
    file.check()?;
    let body = |sink: &mut dyn Write| match format {
        MeshFormat::Obj => obj::write(sink, file),
        MeshFormat::Ply(encoding) => ply::write(sink, file, encoding),
        MeshFormat::Off => off::write(sink, file),
        MeshFormat::Stl(encoding) => stl::write(sink, &file.mesh, encoding),
    };
    let written = match packing {
        Packing::None => body(&mut output),
        Packing::Gzip => {
            let mut encoder =
                flate2::write::GzEncoder::new(&mut output, flate2::Compression::default());
            body(&mut encoder).and_then(|()| encoder.finish().map(|_| ()))
        }
        Packing::Xz => Err(std::io::Error::other("files .xz can only be read; .gz can be written")),
    };
    written.map_err(|e| output.error(e))?;
    output.commit()
}

/// Whether [`write()`] knows what the name of this file says.
///
/// ```
/// use catamaran::mesh::io::check_name;
///
/// assert!(check_name("a.stl".as_ref()).is_ok());
/// assert!(check_name("a.doc".as_ref()).is_err());
/// ```
///
/// # Errors
/// [`Error::Io`] when it doesn't.
pub fn check_name(path: &Path) -> Result<()> {
    match MeshFormat::of(path)? {
        (_, Packing::Xz) => {
            Err(Error::file(path, "files .xz can only be read; .gz can be written"))
        }
        _ => Ok(()),
    }
}
