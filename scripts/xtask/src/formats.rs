//! `docs/guide/mesh-files.md`: the formats of mesh files, from the table of the library.

use std::path::Path;

use crate::generated::Generated;

/// `docs/guide/mesh-files.md`.
pub const FORMATS: Generated = Generated {
    name: "docs/guide/mesh-files.md",
    source: "the table of formats in geometry/src/mesh/io/formats.rs",
    command: "cargo xtask options",
    generate,
};

const INTRODUCTION: &str = "\
# Formats of mesh files

Written by `cargo xtask options` from the table in geometry/src/mesh/io/formats.rs. Every command
and every function that takes a mesh file reads all of these formats, also with `.gz`, `.xz`, `.bz2`
or `.zip` (of one file) after the ending, or `.zst` where the feature `columnar` is built in, as in
the command line and in Python. They write those that are not marked \"read only\", also with `.gz`.
The content of a file decides its format; the ending is a hint.

| Format | Endings | Coordinates | Beside positions and faces |
|---|---|---|---|
";

const READERS: &str = "
What a reader leaves out or reads differently is a note with a count: on stderr, in
`cata_mesh_file_notes` of C, as a warning in Python. A reader needs positions and faces:

- A line, an element or bytes that a format does not know, or that follow what the header
  announces, are left out.
- Texture coordinates and normals that a file names and lacks are left out.
- A vertex whose position is not finite is left out if it is in no face.
- Where the header of a binary STL file has no number of facets, or one that is too small, the size
  of the file decides.
- Text may be in UTF-8, Latin-1 or UTF-16, and its lines may end in any way.
- Files that a file names, such as buffers of glTF and numbers of GIFTI, lie beside it or in folders
  there.
- Surfaces of FreeSurfer are also read as text (`.asc`), Gmsh's versions 2 and 4.1 as text and
  binary, 1 and 4.0 as text, XML of VTK packed by zlib, LZ4 or LZMA, and glTF packed by Draco and
  meshoptimizer (`KHR_draco_mesh_compression`, `EXT_meshopt_compression`).
- Supports of 3MF, which only hold objects while they are printed, are left out, and so are slices,
  with a note where the mesh is a coarse one beside them. Beams that a file requires are an error.
- Corners of glTF behind the last whole triangle are left out.
- Values of vertices come from the mesh file, from GIFTI without a surface, or from FreeSurfer:
  `.curv`, `.thickness` and others, `.annot`, `.mgh` and `.mgz` (`--functions` of commands,
  `read_scalars` of the libraries).

A file that ends too early, a face with a vertex that is not there, and a file of zero bytes are
errors. An error about a file that holds no mesh says what the file seems to be.
";

fn generate(_: &Path) -> Result<String, String> {
    let rows = catamaran_geometry::mesh::io::rows_of_guide();
    Ok(format!("{INTRODUCTION}{rows}{READERS}"))
}
