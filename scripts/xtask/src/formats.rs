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

`catamaran mesh` describes a file and converts it:

```console
$ catamaran generate torus 20 12 2 0.8 -o torus.ply
written     torus.ply: 240 vertices, 480 faces
$ catamaran mesh torus.ply -o torus.stl
mesh        torus.ply, read in 225.3 us
vertices    240
edges       720, 0 on the boundary
faces       480
components  1
loops       0
Euler       0
genus       1
problems    none
area        61.80766652444585
volume      23.732505167995985
box         [-2.8, -2.8, -0.8] to [2.8, 2.8, 0.8]
intersect   0 faces with others
quality     0.655 mean, 0.573 least, 0.00 % below 0.1 (1: equilateral)
note: torus.stl: rounded coordinates to single precision: vertices move by up to 1.2e-7 (vertex 239), 2.1e-8 of the longest side of the mesh
written     torus.stl: 240 vertices, 480 faces
```

Every command and every function that takes a mesh file reads all of these formats, also with `.gz`,
`.xz`, `.bz2` or `.zip` (of one file) after the ending, or `.zst` where the feature `columnar` is
built in, as in the command line and in Python. They write those that are not marked \"read only\",
also with `.gz`. The content of a file decides its format; the ending is a hint. (This page is
written by `cargo xtask options` from the table in geometry/src/mesh/io/formats.rs.)

| Format | Endings | Coordinates | Beside positions and faces |
|---|---|---|---|
";

const READERS: &str = "
What a reader leaves out or reads differently is a note with a count: on stderr, in
`cata_mesh_file_notes` of C, as a warning in Python. A reader needs positions and faces:

- A line, an element, a property of PLY or bytes that a format does not know, or that follow what
  the header announces, are left out; so are smoothing groups of OBJ.
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
- Coordinates stay in the unit of the file. Of 3MF they become millimetres, with a note if the file
  has another unit, and `.3mf` is written in millimetres; no other format is converted.
- Supports of 3MF, which only hold objects while they are printed, are left out, and so are slices,
  with a note where the mesh is a coarse one beside them. Beams that a file requires are an error.
- Corners of glTF behind the last whole triangle are left out.
- Values of vertices come from the mesh file, from GIFTI without a surface, or from FreeSurfer:
  `.curv`, `.thickness` and others, `.annot`, `.mgh` and `.mgz` (`--functions` of commands,
  `read_scalars` of the libraries).

A file that ends too early, a face with a vertex that is not there, and a file of zero bytes are
errors. An error about a file without a mesh says what the file seems to be, such as a web page or
a STEP file, where its first bytes show that.
";

fn generate(_: &Path) -> Result<String, String> {
    let rows = catamaran_geometry::mesh::io::rows_of_guide();
    Ok(format!("{INTRODUCTION}{rows}{READERS}"))
}
