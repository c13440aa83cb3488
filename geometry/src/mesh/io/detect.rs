//! What the content of a file tells about its format.

use super::stored::Kind;
use super::text::{LOOK, number, uncommented, without_mark, words};
use super::{freesurfer, off, text};

/// Least ratio of lines that are statements of OBJ to lines that are not: programs add statements
/// of their own.
const LEAST_KNOWN: usize = 8;

/// The beginning of a file.
pub(super) struct Head<'a> {
    /// Up to [`LOOK`] bytes, without a byte order mark.
    pub bytes: &'a [u8],
    /// The bytes of the whole file, if they are known.
    pub size: Option<u64>,
}

impl<'a> Head<'a> {
    pub fn new(bytes: &'a [u8], size: Option<u64>) -> Self {
        let bytes = without_mark(bytes);
        Self { bytes: &bytes[..bytes.len().min(LOOK)], size }
    }

    /// Returns the lines that have words, without comments after a #. A last line that may be
    /// incomplete is left out.
    fn lines(&self) -> impl Iterator<Item = &'a [u8]> {
        let text = self.bytes;
        let is_end = |byte: &u8| matches!(byte, b'\n' | b'\r');
        let end = match text.len() {
            LOOK.. => text.iter().rposition(is_end).unwrap_or_default(),
            length => length,
        };
        let lines = text[..end].split(is_end);
        lines.map(uncommented).filter(|line| !line.trim_ascii().is_empty())
    }
}

pub(super) fn is_gltf(head: &Head<'_>) -> bool {
    let is_json = || head.bytes.trim_ascii_start().starts_with(b"{") && !head.bytes.contains(&0);
    head.bytes.starts_with(b"glTF") || is_json()
}

pub(super) fn is_vtk(head: &Head<'_>) -> bool {
    let magic = b"# vtk datafile";
    head.bytes.get(..magic.len()).is_some_and(|start| start.eq_ignore_ascii_case(magic))
}

pub(super) fn is_vtk_xml(head: &Head<'_>) -> bool {
    has_element(head, b"<VTKFile")
}

pub(super) fn is_gifti(head: &Head<'_>) -> bool {
    has_element(head, b"<GIFTI")
}

/// Returns whether XML has this element in its first bytes: comments may come before.
fn has_element(head: &Head<'_>, start: &[u8]) -> bool {
    let text = head.bytes.trim_ascii_start();
    let text = &text[..text.len().min(1 << 12)];
    text.starts_with(b"<") && text.windows(start.len()).any(|bytes| bytes == start)
}

pub(super) fn is_freesurfer(head: &Head<'_>) -> bool {
    freesurfer::begins(head.bytes)
}

pub(super) fn is_gmsh(head: &Head<'_>) -> bool {
    let line = head.bytes.trim_ascii_start();
    [&b"$MeshFormat"[..], b"$NOD", b"$Comments"].iter().any(|start| line.starts_with(start))
}

/// Returns whether an archive (zip) has a file that packages of 3MF have among its first ones.
pub(super) fn is_threemf(head: &Head<'_>) -> bool {
    let mut rest = head.bytes;
    while let Some((name, after)) = first_of_archive(rest) {
        let is_model = name.starts_with(b"3D/") && name.ends_with(b".model");
        if is_model || name == b"[Content_Types].xml" || name == b"_rels/.rels" {
            return true;
        }
        rest = after;
    }
    false
}

/// Returns the name of the first file in the bytes of a zip archive, and the bytes after that file:
/// those of its content where its header lacks the size.
fn first_of_archive(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    /// The size of the header, without its signature and the name.
    const SIZE: usize = 26;
    let header = bytes.strip_prefix(b"PK\x03\x04")?;
    let number = |kind: Kind, at: usize| {
        Some(kind.number(header.get(at..at + kind.size())?, false) as usize)
    };
    let (size, name, extra) =
        (number(Kind::U32, 14)?, number(Kind::U16, 22)?, number(Kind::U16, 24)?);
    let after = header.get((SIZE + name + extra).saturating_add(size)..);
    Some((header.get(SIZE..SIZE + name)?, after.unwrap_or_default()))
}

pub(super) fn is_ply(head: &Head<'_>) -> bool {
    text::is_ply(head.bytes) && head.bytes.get(3).is_some_and(u8::is_ascii_whitespace)
}

pub(super) fn is_off(head: &Head<'_>) -> bool {
    let first = head.lines().next().and_then(|line| words(line).next());
    first.is_some_and(|word| off::kind_of(word).is_some())
}

/// Text has a line that begins a facet. The header of a binary file is arbitrary text, so its size
/// decides: a header of 80 bytes, a count and that many facets of 50 bytes.
pub(super) fn is_stl(head: &Head<'_>) -> bool {
    let count = head.bytes.get(80..84).and_then(|bytes| bytes.first_chunk::<4>());
    let expected = count.map(|&bytes| 84 + 50 * u64::from(u32::from_le_bytes(bytes)));
    let mut lines = head.lines().skip_while(|line| !begins(line, b"solid"));
    (expected.is_some() && expected == head.size)
        || lines.any(|line| begins(line, b"facet") || begins(line, b"endsolid"))
}

/// Returns whether the first word of a line is this one, in upper or lower case.
fn begins(line: &[u8], word: &[u8]) -> bool {
    words(line).next().is_some_and(|first| first.eq_ignore_ascii_case(word))
}

pub(super) fn is_obj(head: &Head<'_>) -> bool {
    let (mut known, mut unknown) = (0, 0);
    let mut vertices = false;
    for line in head.lines() {
        let mut words = words(line);
        let keyword = words.next().unwrap_or_default();
        let is_statement = match keyword {
            b"v" | b"vt" | b"vn" => words.next().is_some_and(|word| number(word).is_ok()),
            b"f" | b"g" | b"o" | b"s" | b"l" | b"p" | b"mtllib" | b"usemtl" => true,
            _ => false,
        };
        if is_statement {
            known += 1
        } else {
            unknown += 1
        }
        vertices |= keyword == b"v";
    }
    vertices && known >= LEAST_KNOWN * unknown
}

/// Beginnings of files that hold no mesh, or one of a format that is not read: in lower case, what
/// they seem to be, and what helps. Those that begin with < may follow a declaration of XML.
const OTHERS: [(&[u8], &str); 28] = [
    (b"<!doctype html", "a web page: download the file itself"),
    (b"<html", "a web page: download the file itself"),
    (b"version https://git-lfs", "a pointer of Git LFS: `git lfs pull` fetches the file itself"),
    (b"kaydara fbx binary", "FBX: export OBJ, PLY or glTF, for example from Blender"),
    (b"; fbx", "FBX: export OBJ, PLY or glTF, for example from Blender"),
    (b"blender", "a scene of Blender: export OBJ, PLY or glTF from Blender"),
    (b"<collada", "COLLADA: export OBJ, PLY or glTF, for example from Blender"),
    (b"<x3d", "X3D: export OBJ, PLY or glTF, for example from MeshLab"),
    (b"#x3d", "X3D: export OBJ, PLY or glTF, for example from MeshLab"),
    (b"#vrml", "VRML: export OBJ, PLY or glTF, for example from MeshLab"),
    (b"octm", "OpenCTM: export OBJ, PLY or glTF, for example from MeshLab"),
    (b"draco", "Draco: `draco_decoder -i FILE -o mesh.ply` converts"),
    (b"<amf", "AMF: export 3MF or STL, for example from PrusaSlicer"),
    (b"<xdmf", "XDMF: save the surface as .vtp from ParaView, or `meshio convert FILE mesh.vtu`"),
    (b"<dolfin", "XML of DOLFIN: `meshio convert --input-format dolfin-xml FILE mesh.vtu`"),
    (b"(0 \"", "Fluent: `meshio convert --input-format ansys FILE mesh.vtu`"),
    (b"(1 \"", "Fluent: `meshio convert --input-format ansys FILE mesh.vtu`"),
    (b"iso-10303-21", "STEP: export STL or glTF from the CAD program"),
    (b"dbrep_drawableshape", "BREP: export STL or glTF from the CAD program"),
    (b"cascade topology", "BREP: export STL or glTF from the CAD program"),
    (b"title = \"", "Tecplot: `meshio convert --input-format tecplot FILE mesh.vtu`"),
    (b"#usda", "USD: export OBJ, PLY or glTF, for example from Blender"),
    (b"pxr-usdc", "USD: export OBJ, PLY or glTF, for example from Blender"),
    (
        b"\x89hdf",
        "HDF5: a table, or a mesh of VTKHDF, CGNS or MED, of which ParaView or Gmsh saves the \
         surface as .vtp or .msh",
    ),
    (b"\x93numpy", "an array of NumPy: a table, not a mesh"),
    (b"\x89png", "a picture"),
    (b"\xff\xd8\xff", "a picture"),
    (b"%pdf", "a PDF document"),
];

/// Beginnings of a line among the first ones of files of other formats, which comments and options
/// may come before: in lower case, what they seem to be, and what helps.
const OTHER_LINES: [(&[u8], &str); 10] = [
    // LS-DYNA has sections of Abaqus's names, after this one.
    (b"*keyword", "LS-DYNA: export STL from LS-PrePost"),
    (b"*heading", ABAQUS),
    (b"*node", ABAQUS),
    (b"begin bulk", NASTRAN),
    (b"grid,", NASTRAN),
    (b"grid*", NASTRAN),
    (b"grid  ", NASTRAN),
    (b"meshversionformatted", "Medit: `meshio convert --input-format medit FILE mesh.vtu`"),
    (b"ndime=", "SU2: `meshio convert --input-format su2 FILE mesh.vtu`"),
    (b"mesh3d", "Netgen: `meshio convert --input-format netgen FILE mesh.vtu`"),
];
const ABAQUS: &str = "Abaqus: `meshio convert --input-format abaqus FILE mesh.vtu`";
const NASTRAN: &str = "Nastran: `gmsh FILE.bdf -save -format msh41 -o mesh.msh` converts";

/// Returns what a file that fits no format seems to be, and what helps, where that is known.
pub(super) fn other(bytes: &[u8]) -> Option<&'static str> {
    if bytes.starts_with(b"MM") && bytes.get(6..8).is_some_and(|kind| kind == b"\x02\0") {
        return Some("3DS: export OBJ, PLY or glTF, for example from MeshLab");
    }
    // Lines of IGES have 80 columns, of which the last tell the section and count.
    if bytes.get(72) == Some(&b'S') && bytes.get(79) == Some(&b'1') {
        return Some("IGES: export STL or glTF from the CAD program");
    }
    let head = Head::new(bytes, None).bytes.trim_ascii_start();
    let head = head[..head.len().min(1 << 10)].to_ascii_lowercase();
    let is_xml = head.starts_with(b"<?xml") || head.starts_with(b"<!--");
    let begins = |start: &[u8]| {
        let within = || head.windows(start.len()).any(|window| window == start);
        head.starts_with(start) || (is_xml && start.starts_with(b"<") && within())
    };
    let line_begins = |start: &[u8]| {
        head.split(|&byte| byte == b'\n').any(|line| line.trim_ascii_start().starts_with(start))
    };
    let found = OTHERS.iter().find(|(start, _)| begins(start));
    let found = found.or_else(|| OTHER_LINES.iter().find(|(start, _)| line_begins(start)));
    found.map(|(_, what)| *what)
}
