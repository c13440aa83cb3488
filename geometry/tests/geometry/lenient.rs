//! Files as other programs write them: what is needed is read, what is not is left out with a note,
//! and what can't be read is named.

use std::fs;

use catamaran_geometry::mesh::io::{
    GltfEncoding, MeshFile, MeshFormat, PlyEncoding, StlEncoding, read, read_bytes, write_bytes,
};
use catamaran_geometry::mesh::{TriMesh, families};

use crate::common::data;
use crate::mesh_files::{Folder, note, refusal};

const OBJ: MeshFormat = MeshFormat::Obj;
const OFF: MeshFormat = MeshFormat::Off;
const PLY: MeshFormat = MeshFormat::Ply(PlyEncoding::Ascii);
const STL: MeshFormat = MeshFormat::Stl(StlEncoding::Binary);
const STL_TEXT: MeshFormat = MeshFormat::Stl(StlEncoding::Ascii);
const GLTF: MeshFormat = MeshFormat::Gltf(GltfEncoding::Text);

/// A closed mesh whose numbers are whole in single precision, in STL too.
fn solid() -> TriMesh {
    let (points, faces) = families::torus(5, 4, 1.0, 0.25).unwrap().into_parts();
    let points = points.into_iter().map(|p| p.map(|x| (x * 64.0).round() / 64.0)).collect();
    TriMesh::new(points, faces).unwrap()
}

fn bytes_of(format: MeshFormat) -> Vec<u8> {
    write_bytes(&solid().into(), format).unwrap().0
}

fn text_of(format: MeshFormat) -> String {
    String::from_utf8(bytes_of(format)).unwrap()
}

/// The file of these bytes, whose mesh must be that of [`solid`] up to the order of vertices.
fn whole(bytes: &[u8], format: MeshFormat) -> MeshFile {
    let file = read_bytes(bytes, format)
        .unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&bytes[..200])));
    let corners = |mesh: &TriMesh| {
        let faces = mesh.faces().iter();
        faces.map(|face| face.map(|v| mesh.vertices()[v as usize])).collect::<Vec<_>>()
    };
    assert_eq!(file.mesh.vertices().len(), solid().vertices().len());
    assert_eq!(corners(&file.mesh), corners(&solid()));
    file
}

/// The text with each old part replaced by a new one.
fn changed(text: &str, old: &str, new: &str) -> String {
    assert!(text.contains(old), "{old:?}");
    text.replace(old, new)
}

/// Bytes of PLY with vertices of floats, and faces whose corners have 8 bytes.
fn wide_ply(kind: &str) -> Vec<u8> {
    let mesh = solid();
    let (vertices, faces) = (mesh.vertices().len(), mesh.faces().len());
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\n\
         property float y\nproperty float z\nproperty {kind} label\nelement face {faces}\n\
         property list uchar {kind} vertex_indices\nend_header\n"
    )
    .into_bytes();
    for p in mesh.vertices() {
        p.iter().for_each(|&x| bytes.extend((x as f32).to_le_bytes()));
        bytes.extend(7u64.to_le_bytes());
    }
    for face in mesh.faces() {
        bytes.push(3);
        face.iter().for_each(|&v| bytes.extend(u64::from(v).to_le_bytes()));
    }
    bytes
}

#[test]
fn ply_has_the_types_of_numpy() {
    for kind in ["int64", "uint64", "<i8"] {
        let said = "left out properties of vertices: 1, the first at \"label\"";
        assert_eq!(whole(&wide_ply(kind), PLY).notes, [said]);
    }
    let text = changed(&text_of(PLY), "uchar int vertex", "bool int64 vertex");
    whole(text.as_bytes(), PLY);
    // One half, minus two, the smallest number, and zeros with a label.
    let mut bytes = b"ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float16 x\n\
                      property half y\nproperty bool label\nproperty float16 z\nend_header\n"
        .to_vec();
    bytes.extend([0x38, 0, 0xc0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    let mesh = read_bytes(&bytes, PLY).unwrap().mesh;
    assert_eq!(mesh.vertices()[0], [0.5, -2.0, 2f64.powi(-24)]);
}

#[test]
fn what_ply_does_not_announce_is_left_out() {
    let text = text_of(PLY);
    let file = whole(format!("{text}3 0 1 2\n\n3 0 2 1\n").as_bytes(), PLY);
    let last = text.lines().count() + 1;
    let said = format!("left out lines after the last element: 2, the first at line {last}");
    assert_eq!(file.notes, [said]);
    // A last row of vertices without a line end.
    let points = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
                  property float z\nelement face 0\nproperty list uchar int vertex_indices\n\
                  end_header\n1 2 3 \n4 5 6";
    let file = read_bytes(points.as_bytes(), PLY).unwrap();
    assert_eq!(file.mesh.vertices(), [[1.0, 2.0, 3.0]]);
    assert_eq!(file.notes.len(), 1);
    for encoding in [PlyEncoding::LittleEndian, PlyEncoding::BigEndian] {
        let format = MeshFormat::Ply(encoding);
        let file = whole(&[&bytes_of(format)[..], b"tail\n"].concat(), format);
        assert_eq!(file.notes, ["left out bytes after the last element: 5"]);
    }
}

#[test]
fn rows_of_ply_may_be_longer_than_declared() {
    let text = text_of(PLY);
    let (header, rows) = text.split_once("end_header\n").unwrap();
    let rows: String = rows.lines().map(|row| format!("{row} 9 1 1\n")).collect();
    let file = whole(format!("{header}end_header\n{rows}").as_bytes(), PLY);
    let said = note(&file, "left out numbers after those that the header declares");
    let count = solid().vertices().len() + solid().faces().len();
    assert!(said.contains(&format!(": {count}, the first at line ")), "{said}");
    assert_eq!(file.notes.len(), 1, "{:?}", file.notes);
}

#[test]
fn rows_of_ply_may_go_on_in_the_next_lines() {
    let text = text_of(PLY);
    let (header, rest) = text.split_once("end_header\n").unwrap();
    let split = format!("{header}end_header\n{}", rest.replace(' ', "\n"));
    assert!(whole(split.as_bytes(), PLY).notes.is_empty());
    // A row that lacks numbers takes none of a whole row.
    let lacks = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n\
                 property float z\nend_header\n0 0\n1 0 0\n";
    assert_eq!(refusal(lacks.as_bytes(), PLY), (Some(8), "too few numbers".into()));
}

#[test]
fn elements_of_ply_with_vertices_that_are_no_faces_are_noted() {
    let text = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
                property float z\nelement range_grid 2\nproperty list uchar int vertex_indices\n\
                element camera 1\nproperty float angle\nend_header\n0 0 0\n1 0\n0\n0.5\n";
    let notes = read_bytes(text.as_bytes(), PLY).unwrap().notes;
    let said = [
        "left out elements of vertices that are no faces: 2, the first at range_grid",
        "left out elements that are no part of a mesh: 1, the first at camera",
    ];
    assert_eq!(notes, said);
}

#[test]
fn what_ply_has_beside_the_mesh_is_noted() {
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                property float z\nproperty float nx\nproperty float quality\nelement face 2\n\
                property uchar red\nproperty uchar green\nproperty uchar blue\n\
                property uchar alpha\nproperty list uchar int vertex_indices\n\
                property list uchar int flags\nelement edge 2\nproperty int vertex1\n\
                property int vertex2\nelement none 0\nproperty int a\nend_header\n\
                0 0 0 1 2\n1 0 0 1 2\n0 1 0 1 2\n\
                9 9 9 9 3 0 1 2 1 7\n9 9 9 9 3 2 1 0 0\n0 1\n1 2\n";
    let file = read_bytes(text.as_bytes(), PLY).unwrap();
    assert_eq!(file.mesh.faces(), [[0, 1, 2], [2, 1, 0]]);
    let said = [
        "left out properties of vertices: 2, the first at \"nx\"",
        "left out colours of faces: 2, the first at face 0",
        "left out properties of faces: 1, the first at \"flags\"",
        "left out elements that are no part of a mesh: 2, the first at edge",
    ];
    assert_eq!(file.notes, said);
}

#[test]
fn statements_of_obj_about_appearance_are_noted() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let text = format!("{triangle}s off\nf 1 2 3\ns 1\nusemap m\nf 1 3 2\ns 0\ns\ns 2\nlod 3\n");
    let file = read_bytes(text.as_bytes(), OBJ).unwrap();
    let said = [
        "left out smoothing groups: statements: 2, the first at line 6",
        "left out statements about the appearance of triangles: 2, the first at line 7 \
         (\"usemap\")",
    ];
    assert_eq!(file.notes, said);
    let off = read_bytes(format!("{triangle}s off\nf 1 2 3\n").as_bytes(), OBJ).unwrap();
    assert!(off.notes.is_empty(), "{:?}", off.notes);
}

#[test]
fn an_error_about_a_vertex_that_is_not_there_names_the_statement_that_may_be_it() {
    let text = b"v 0 0 0\nv1 0 0\nv 0 1 0\nf 1 2 3\n";
    let said =
        "vertex 3 is out of range: the file has 2; \"v1\" in line 2 is not a statement of OBJ";
    assert_eq!(refusal(text, OBJ), (Some(4), said.into()));
}

#[test]
fn headers_of_ply_may_have_other_line_ends_blanks_and_lines() {
    for format in [PLY, MeshFormat::Ply(PlyEncoding::LittleEndian)] {
        let bytes = bytes_of(format);
        let end = bytes.windows(11).position(|part| part == b"end_header\n").unwrap() + 11;
        let (header, rest) = bytes.split_at(end);
        let header = String::from_utf8(header.to_vec()).unwrap();
        let with = |header: String, rest: &[u8]| [header.as_bytes(), rest].concat();
        let returned = |rest: &[u8]| match format {
            PLY => String::from_utf8(rest.to_vec()).unwrap().replace('\n', "\r").into_bytes(),
            _ => rest.to_vec(),
        };
        for (header, rest) in [
            (header.replace('\n', "\r"), returned(rest)),
            (header.replace('\n', " \r"), returned(rest)),
            (header.replace('\n', "\r\n"), rest.to_vec()),
            (header.replace('\n', " \n"), rest.to_vec()),
            (header.replace('\n', "\t \r\n"), rest.to_vec()),
            (header.replacen("ply", "PLY", 1), rest.to_vec()),
            (header.replacen("ply", "PLY", 1).replace('\n', "\r"), returned(rest)),
            (changed(&header, " 1.0\n", "\n"), rest.to_vec()),
            (changed(&header, " 1.0\n", " 1\n"), rest.to_vec()),
            (header.replace("float ", "FLOAT ").replace("double ", "Double "), rest.to_vec()),
        ] {
            assert!(whole(&with(header, &rest), format).notes.is_empty());
        }
        let more = "made by a program\nTextureFile a b.jpg\nelement face";
        let file = whole(&with(header.replace("element face", more), rest), format);
        let said = note(&file, "skipped lines of the header that are not of PLY: 2, the first at");
        assert!(said.ends_with("(\"made\")"), "{said}");
    }
    let (_, said) = refusal(b"ply\nformat ascii 1.0\nelement vertex\nend_header\n", PLY);
    assert!(said.contains("invalid statement \"element\""), "{said}");
}

#[test]
fn attributes_that_obj_lacks_are_left_out_and_positions_are_read() {
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    for (text, said, normals) in [
        ("f 1/1/1 2/2/2 3/3/3 4/4/4\n", "left out normals that the file lacks", false),
        ("f 1/9 2/9 3/9\nf 1/9 3/9 4/9\n", "left out texture coordinates that the file", false),
        ("vn 0 0 1\nf 1//0 2//0 3//0\nf 1//1 3//1 4//1\n", "left out normals that the", true),
        ("vn 0 0 1\nf 1//-2 2//1 3//1\nf 1//1 3//1 4//1\n", "left out normals that the", true),
        ("vn 0 0 1\nf 1//1 2//1 3//2\nf 1//1 3//1 4//1\n", "left out normals that the", true),
    ] {
        let file = read_bytes(format!("{square}{text}").as_bytes(), OBJ).unwrap();
        assert_eq!(file.mesh.faces(), [[0, 1, 2], [0, 2, 3]], "{text}");
        note(&file, said);
        assert!(file.uv.is_none() && file.normals.is_some() == normals, "{text}");
        if let Some(normals) = &file.normals {
            assert_eq!(normals.of_face(&file.mesh, 0), None, "{text}");
            assert_eq!(normals.of_face(&file.mesh, 1), Some([[0.0, 0.0, 1.0]; 3]), "{text}");
        }
        // What was read can be written.
        write_bytes(&file, OBJ).unwrap();
    }
    let missing = format!("{square}vt 0 0\nf 1/1 2/1 3/1\nf 1/2 3/2 4/2\n");
    let file = read_bytes(missing.as_bytes(), OBJ).unwrap();
    let said = note(&file, "left out texture coordinates that the file lacks, of triangles");
    assert!(said.ends_with(": 1, the first at line 7"), "{said}");
    // An attribute may follow the faces that have it.
    let later = format!("{square}f 1//1 2//1 3//1\nvn 0 0 1\n");
    let file = read_bytes(later.as_bytes(), OBJ).unwrap();
    assert!(file.notes.is_empty() && file.normals.is_some());
    let broken = format!("{square}vn 0 0\nvt a\nf 1/1/1 2/1/1 3/1/1\n");
    let said = read_bytes(broken.as_bytes(), OBJ).unwrap();
    note(&said, "took 0 for numbers of normals and texture coordinates that are missing: 2");
    // What follows positions and is no colour.
    let text = square.replace("v 0 0 0", "v 0 0 0 1 1").replace("v 1 0 0", "v 1 0 0 1 2 x 4 5");
    let file = read_bytes(format!("{text}f 1 2 3\n").as_bytes(), OBJ).unwrap();
    assert!(file.colors.is_none());
    assert!(note(&file, "left out numbers after positions").ends_with(": 2, the first at line 1"));
}

#[test]
fn vertices_that_no_face_has_may_lack_a_position() {
    let mesh = solid();
    let (v, faces) = (mesh.vertices().len(), mesh.faces().len());
    // The first vertex is the one without a position, so all numbers change.
    let face = |[a, b, c]: [u32; 3], from: u32| format!("{} {} {}\n", a + from, b + from, c + from);
    let of = |start: &str, from: u32| -> String {
        mesh.faces().iter().map(|&f| format!("{start} {}", face(f, from))).collect()
    };
    let point = |[x, y, z]: &[f64; 3]| format!("{x:?} {y:?} {z:?} 0.5 0.25 1.0\n");
    let points: String = mesh.vertices().iter().map(point).collect();
    let obj: String = points.lines().map(|line| format!("v {line}\n")).collect();
    let obj = format!("v nan 0 -inf 1 1 1\n{obj}{}", of("f", 2));
    let off = format!("COFF\n{} {faces} 0\n0 nan 0 1 1 1\n{points}{}", v + 1, of("3", 1));
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nproperty float red\nproperty float green\nproperty float blue\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n\
         nan nan nan 1 1 1\n{points}{}",
        v + 1,
        of("3", 1)
    );
    let cases = [(obj, OBJ, "line 1"), (off, OFF, "line 3"), (ply, PLY, "vertex 0")];
    for (text, format, place) in cases {
        let file = whole(text.as_bytes(), format);
        assert_eq!(file.colors.as_ref().unwrap(), &vec![[0.5, 0.25, 1.0, 1.0]; v]);
        let said = note(&file, "left out vertices without a face whose position is not finite");
        assert!(said.ends_with(&format!(": 1, the first at {place}")), "{said}");
    }
    // A face needs its corners.
    let (_, said) = refusal(b"v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n", OBJ);
    assert_eq!(said, "mesh.obj: line 3: the position of a vertex of a face is not finite");
}

#[test]
fn planar_obj_and_numbers_of_windows_are_read() {
    let file = read_bytes(b"v 0 0\nv 1 0\nv 0 1\nf 1 2 3\n", OBJ).unwrap();
    assert_eq!(file.mesh.vertices()[2], [0.0, 1.0, 0.0]);
    assert!(file.notes[0].starts_with("took 0 for z"), "{:?}", file.notes);
    // In no face; the # is part of a number. A comment may follow a number at once, too.
    let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 1.#top\nv 1.#IND 0 0\nf 1 2 3 # one\n";
    let off = b"OFF\n4 1 0\n0 0 0\n1 0 0\n0 1 1.#top\n-1.#QNAN 0 0\n3 0 1 2 # one\n";
    for (bytes, format) in [(&obj[..], OBJ), (&off[..], OFF)] {
        let vertices = read_bytes(bytes, format).unwrap().mesh.into_parts().0;
        assert_eq!(vertices, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 1.0]]);
    }
}

#[test]
fn statements_of_obj_continue_after_a_backslash_and_comments_do_not() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    for face in [
        "f 1 2 \\\n3 4\n",
        "f 1 2 \\ \t\n  3\\\r\n 4\n",
        // The last line may continue on none.
        "f 1 2 3 4 \\",
        "# made in C:\\meshes\\\nf 1 2 3 4\n",
        "g a # C:\\meshes\\\nf 1 2 3 4\n",
        "f 1 2 \\\n# C:\\\nf 1 2 3 4\n",
    ] {
        let file = read_bytes(format!("{vertices}{face}").as_bytes(), OBJ).unwrap();
        assert_eq!(file.mesh.faces(), [[0, 1, 2], [0, 2, 3]], "{face:?}");
    }
}

#[test]
fn numbers_of_fortran_are_read_and_decimal_commas_named() {
    let text = b"v 1.5D+0 -2d-1 1.D2\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    assert_eq!(read_bytes(text, OBJ).unwrap().mesh.vertices()[0], [1.5, -0.2, 100.0]);
    for (number, said) in [
        ("1,5", "\"1,5\" is not a number: it needs a point in place of the comma"),
        ("1,5,2", "\"1,5,2\" is not a number"),
        ("D5", "\"D5\" is not a number"),
        ("2D", "\"2D\" is not a number"),
    ] {
        let (line, found) = refusal(format!("v 0 0 {number}\n").as_bytes(), OBJ);
        assert_eq!((line, &found[..]), (Some(1), said));
    }
}

#[test]
fn colours_of_zbrush_are_read() {
    let v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let text = format!("#MRGB ffff0000ff00ff00\n{v}#MRGB ff0000ff\nf 1 2 3\n");
    let file = read_bytes(text.as_bytes(), OBJ).unwrap();
    let colors = [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]];
    assert_eq!((file.colors.as_deref(), file.notes.len()), (Some(&colors[..]), 0));
    for (wrong, said) in [
        ("#MRGB ffff00\n", "left out colours (#MRGB) that are not hexadecimal"),
        ("#MRGB ff00ff00\n", "left out colours, which only some"),
    ] {
        let file = read_bytes(format!("{v}{wrong}f 1 2 3\n").as_bytes(), OBJ).unwrap();
        assert!(file.colors.is_none() && file.mesh.faces().len() == 1);
        note(&file, said);
    }
}

#[test]
fn text_may_be_in_utf16_and_end_its_lines_in_carriage_returns() {
    let folder = Folder::new();
    for format in [OBJ, OFF, STL_TEXT, PLY] {
        let text = text_of(format);
        let returns = text.replace('\n', "\r");
        let wide = |text: &str, unit: fn(u16) -> [u8; 2]| -> Vec<u8> {
            "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(unit).collect()
        };
        for (i, bytes) in [
            returns.clone().into_bytes(),
            wide(&text, u16::to_le_bytes),
            wide(&returns, u16::to_be_bytes),
            wide(&text.replace('\n', "\r\n"), u16::to_be_bytes),
            format!("\u{feff}{text}").into_bytes(),
        ]
        .into_iter()
        .enumerate()
        {
            assert!(whole(&bytes, format).notes.is_empty(), "{format:?}, {i}");
            // The content decides here, too.
            let path = folder.path("mesh");
            fs::write(&path, &bytes).unwrap();
            note(&read(&path).unwrap_or_else(|e| panic!("{format:?}, {i}: {e}")), "read as ");
        }
    }
    // A line number is that of the file, and a few returns within lines are none.
    assert_eq!(refusal(b"v 0 0 0\rv 1 0 0\r\rv x 0 0\rv 0 0 0\r", OBJ).0, Some(4));
    let stray = "# a\rb\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    assert_eq!(read_bytes(stray.as_bytes(), OBJ).unwrap().mesh.faces(), [[0, 1, 2]]);
}

#[test]
fn stl_as_text_may_have_capitals_comments_colours_and_no_end() {
    let text = text_of(STL_TEXT);
    let clean = [
        text.to_ascii_uppercase(),
        changed(&text, "facet normal", "Facet Normal"),
        changed(&text, "solid\nfacet", "solid a b\n\n\n  facet"),
        changed(&text, "solid\nfacet", "solid a\nendsolid a\nfacet"),
        changed(&text, "solid\nfacet", "solid a facet normal\nfacet"),
        // In one line, also with a second solid, or a line for each facet.
        text.replace('\n', " "),
        changed(&text, "solid\nfacet", "solid facet of a\nendsolid a solid b\nfacet")
            .replace('\n', " "),
        text.replace("\nendsolid", "\tendsolid")
            .replace("\nouter", " outer")
            .replace(
                "\nvertex",
                " \
            vertex",
            )
            .replace("\nend", " end"),
    ];
    for text in clean {
        assert!(whole(text.as_bytes(), STL_TEXT).notes.is_empty(), "{}", &text[..90]);
    }
    let skipped = "skipped lines that are not of STL";
    let comments = "# made by a program\n; on a day\n".repeat(60);
    for (text, said) in [
        (format!("{comments}{text}"), skipped),
        (changed(&text, "solid\nfacet", "solid\ncolor 0.5 0.5 0.5\nfacet"), skipped),
        (changed(&text, "endloop\n", "endloop\n color 1 0 0\n"), skipped),
        (changed(&text, "endsolid", ""), "the last solid has no endsolid"),
        (text.lines().map(|line| vertex_colour(line) + "\n").collect(), "left out words after"),
        (text.replace("endfacet\n", ""), "took facets without an endfacet"),
    ] {
        let file = whole(text.as_bytes(), STL_TEXT);
        note(&file, said);
        assert_eq!(file.notes.len(), 1, "{:?}", file.notes);
    }
    // A facet that the end of the file cuts is an error.
    let cut = text.trim_end().rfind("endfacet").unwrap();
    assert!(refusal(&text.as_bytes()[..cut], STL_TEXT).1.contains("truncated: the last facet"));
    assert!(refusal(b"hello\n", STL_TEXT).1.contains("\"hello\" is not a statement of STL"));
}

fn vertex_colour(line: &str) -> String {
    let more = if line.starts_with("vertex") { " 0.5 0.5 0.5" } else { "" };
    format!("{line}{more}")
}

#[test]
fn the_size_of_a_binary_stl_decides() {
    let bytes = bytes_of(STL);
    let faces = solid().faces().len();
    let with_count = |count: u32| {
        let mut bytes = bytes.clone();
        bytes[80..84].copy_from_slice(&count.to_le_bytes());
        bytes
    };
    for count in [0, u32::MAX, 1, faces as u32 - 3] {
        let file = whole(&with_count(count), STL);
        let said =
            format!("took the number of facets from the size, not {count} of the header: {faces}");
        assert_eq!(file.notes, [said]);
    }
    // More than there are: the rest is lost.
    let said = refusal(&with_count(faces as u32 + 1), STL).1;
    assert!(said.starts_with(&format!("truncated: facet {faces} of ")), "{said}");
    for (tail, begins) in [(1, &b"stl"[..]), (7, b"solid part"), (49, b"solid"), (84, b" ")] {
        let mut bytes = [&bytes[..], &vec![b'\n'; tail]].concat();
        bytes[..80].fill(b' ');
        bytes[..begins.len()].copy_from_slice(begins);
        let file = whole(&bytes, STL);
        assert_eq!(file.notes, [format!("left out bytes after the last facet: {tail}")]);
    }
    // Zeros fill a block, also of the size of facets.
    let file = whole(&[&bytes[..], &[0; 100]].concat(), STL);
    assert_eq!(file.notes, ["left out bytes after the last facet: 100"]);
    // Both: no number, and a byte too many.
    let file = whole(&[&with_count(0)[..], b"\n"].concat(), STL);
    assert_eq!(file.notes.len(), 2);
    // Colours in the place of attributes.
    let mut colored = bytes.clone();
    colored[84 + 48] = 0x80;
    assert!(note(&whole(&colored, STL), "left out colours, or other numbers").ends_with(": 1"));
}

#[test]
fn off_is_read_with_counts_after_its_name_and_with_any_dimension() {
    let text = text_of(OFF);
    let (vertices, faces) = (solid().vertices().len(), solid().faces().len());
    let head = format!("OFF\n{vertices} {faces} 0\n");
    let (_, rest) = text.split_once(&head).unwrap();
    let rows: Vec<&str> = rest.lines().collect();
    let with = |head: String, change: &dyn Fn(&str) -> String| {
        let points: String = rows[..vertices].iter().map(|row| change(row) + "\n").collect();
        format!("{head}{points}{}\n", rows[vertices..].join("\n"))
    };
    let same = |row: &str| row.to_owned();
    for text in [
        with(format!("OFF{vertices} {faces} 0\n"), &same),
        with(format!("\t  OFF{vertices} {faces} 0 # so\n"), &same),
        with(format!("OFF {vertices} {faces} 0\n"), &same),
        with(format!("OFF\n{vertices} {faces} -1\n"), &same),
        with(format!("4OFF\n{vertices} {faces} 0\n"), &|row| format!("{row} 1.0")),
        with(format!("nOFF\n3\n{vertices} {faces} 0\n"), &same),
        with(format!("nOFF 3\n{vertices} {faces} 0\n"), &same),
        with(format!("n4OFF 3\n{vertices} {faces} 0\n"), &|row| format!("{row} 1")),
        with(format!("off\n{vertices} {faces} 0\n"), &same),
    ] {
        assert!(whole(text.as_bytes(), OFF).notes.is_empty(), "{}", &text[..30]);
    }
    for (text, said) in [
        (with(head.clone(), &|row| format!("{row} 7")), "left out numbers after the others"),
        (with(head.clone(), &|row| format!("{row} 7 8")), "left out numbers after the others"),
        (with(head.replace(" 0\n", " 0 0\n"), &same), "left out a number after the counts"),
        (format!("{text}3 0 1 2\n"), "left out lines after the last face"),
        (changed(&text, "OFF\n", ""), "took OFF for the keyword, which is missing"),
        (
            with(format!("nOFF 5\n{vertices} {faces} 0\n"), &|row| format!("{row} 8 9")),
            "left out coordinates beyond the third",
        ),
    ] {
        let file = whole(text.as_bytes(), OFF);
        note(&file, said);
        assert!(file.notes.len() == 1 && file.colors.is_none(), "{:?}", file.notes);
    }
    // A weight divides, a plane has no third coordinate, and texture coordinates come first.
    let mesh = read_bytes(b"4OFF\n1 0 0\n2 4 6 2\n", OFF).unwrap().mesh;
    assert_eq!(mesh.vertices(), [[1.0, 2.0, 3.0]]);
    let mesh = read_bytes(b"nOFF 2\n2 0 0\n2 4\n1 2\n", OFF).unwrap().mesh;
    assert_eq!(mesh.vertices(), [[2.0, 4.0, 0.0], [1.0, 2.0, 0.0]]);
    let file = read_bytes(b"STOFF\n1 0 0\n0 0 0 0.5 0.25 9\n", OFF).unwrap();
    assert_eq!(file.uv.unwrap().values, [[0.5, 0.25]]);
    let colored = b"COFF\n2 0 0\n0 0 0 1.0 0 0 1 9\n1 0 0 0 0.5 0 1 9\n";
    let file = read_bytes(colored, OFF).unwrap();
    assert_eq!(file.colors.as_ref().unwrap()[1], [0.0, 0.5, 0.0, 1.0]);
    assert!(note(&file, "left out numbers after the others").ends_with(": 2, the first at line 3"));
    assert!(refusal(b"nOFF 0\n1 0 0\n\n", OFF).1.contains("without coordinates"));
    // Where vertices share a line, nothing tells 4 numbers of colours from 3.
    let shared = |color: &str| {
        format!("COFF\n3 1 0\n0 0 0 {color} 1 0 0 {color} 0 1 0 {color}\n3 0 1 2\n").into_bytes()
    };
    let file = read_bytes(&shared("255 0 0"), OFF).unwrap();
    assert_eq!((file.mesh.area(), file.colors.unwrap()[2]), (0.5, [1.0, 0.0, 0.0, 1.0]));
    assert!(refusal(&shared("255 0 0 255"), OFF).1.starts_with("numbers follow the last face"));
}

#[test]
fn files_without_a_mesh_say_what_they_are() {
    let folder = Folder::new();
    for (name, content, said) in [
        ("a.obj", &b""[..], "is empty"),
        ("a.stl", b"", "is empty"),
        ("a.ply.gz", b"", "is empty"),
        ("a", b"", "is empty"),
        ("b.stl", b"<!DOCTYPE html>\n<html></html>", "a web page: download the file itself"),
        ("b.obj", b"version https://git-lfs.github.com/spec/v1\noid", "`git lfs pull`"),
        ("b.ply", b"Kaydara FBX Binary  \0", "FBX: export"),
        ("b.off", b"<?xml version='1.0'?>\n<COLLADA version='1'>", "COLLADA: export"),
        ("b.glb", b"\x89PNG\r\n", "a picture"),
        ("c.xyz", b"some text\n", "name and content are not OBJ, PLY"),
        ("c.inp", b"** by hand\n*Heading\n*Node\n1, 0, 0, 0\n", "Abaqus: `meshio convert"),
        ("c.k", b"$ by hand\n*KEYWORD\n*NODE\n", "LS-DYNA: export STL"),
        ("c.bdf", b"$ by hand\nGRID           1\n", "Nastran: `gmsh"),
        ("c.nas", b"SOL 101\nCEND\nBEGIN BULK\nGRID,1,,0.,0.,0.\n", "Nastran: `gmsh"),
        ("c.mesh", b" MeshVersionFormatted 2\n Dimension 3\n", "Medit: `meshio convert"),
        ("c.su2", b"NDIME= 3\nNELEM= 933\n", "SU2: `meshio convert"),
        ("c.vol", b"# by hand\nmesh3d\n", "Netgen: `meshio convert"),
        ("c.xml", b"<dolfin nsmap='a'>\n", "XML of DOLFIN: `meshio convert"),
        ("c.xdmf", b"<?xml version='1.0'?><Xdmf Version='3.0'>", "XDMF: save the surface"),
        ("c.msh", b"(1 \"by hand\")\n(0 \"a comment\")\n", "Fluent: `meshio convert"),
        ("c.dat", b"TITLE = \"by hand\"\n", "Tecplot: `meshio convert"),
        ("c.amf", b"<?xml version='1.0'?>\n<amf unit='inch'>", "AMF: export 3MF or STL"),
        ("c.x3dv", b"#X3D V3.0 utf8\n", "X3D: export"),
        ("c.drc", b"DRACO\x02\x02\x01\x01\0\0", "Draco: `draco_decoder"),
        ("c.ctm", b"OCTM\x05\0\0\0RAW\0", "OpenCTM: export"),
        ("c.3ds", b"MM\x64\0\0\0\x02\0\x0a\0\0\0\x03\0\0\0", "3DS: export"),
        ("c.brep", b"DBRep_DrawableShape\n\nCASCADE Topology V1\n", "BREP: export STL"),
        ("c.igs", &[b' '; 72].iter().chain(b"S0000001\n").copied().collect::<Vec<u8>>(), "IGES"),
        ("lh.aparc.annot", b"\0\0\0\x01\0\0\0\0\0\0\0\0", "has values of vertices by its name"),
        ("c.gltf", b"{\"type\": \"FeatureCollection\"}", "JSON, but not of glTF"),
    ] {
        let path = folder.path(name);
        fs::write(&path, content).unwrap();
        let refused = read(&path).unwrap_err().to_string();
        assert!(refused.contains(name) && refused.contains(said), "{refused}");
    }
    assert!(refusal(b"", OBJ).1.contains("is empty"));
    // An empty mesh is written so that it can be read back.
    let nothing = TriMesh::new(vec![], vec![]).unwrap();
    let (bytes, _) = write_bytes(&nothing.clone().into(), OBJ).unwrap();
    assert_eq!(read_bytes(&bytes, OBJ).unwrap().mesh, nothing);
}

#[test]
fn version_1_of_gltf_and_compressed_numbers_are_refused_by_name() {
    for version in ["\"1.0\"", "1"] {
        let first = format!(
            r#"{{"meshes": {{"a": {{"primitives": []}}}}, "asset": {{"version": {version}}}}}"#
        );
        let said = refusal(first.as_bytes(), GLTF).1;
        assert!(
            said.starts_with("version \"1") && said.contains("of glTF is not supported"),
            "{said}"
        );
    }
    let broken = r#"{"asset": {"version": "2.0"}, "meshes": {"a": {"primitives": []}}}"#;
    assert!(refusal(broken.as_bytes(), GLTF).1.contains("not the JSON of a glTF file"));
    for name in ["KHR_meshopt_compression", "KHR_draco_mesh_compression"] {
        // The buffer has no content outside of the extension, and does not name it.
        let used = format!(
            r#"{{"asset": {{"version": "2.0"}}, "extensionsUsed": ["{name}"],
            "buffers": [{{"byteLength": 9}}]}}"#
        );
        let said = refusal(used.as_bytes(), GLTF).1;
        assert!(said.contains(&format!("compressed by the extension {name}")), "{said}");
        assert!(said.contains("export without compression"), "{said}");
    }
}

#[test]
fn files_of_other_programs_are_read() {
    let cube = (8, 12);
    for (name, size) in [
        ("catmark_torus_creases0.obj", (32, 64)),
        ("cubevt.obj", (24, 12)),
        ("fuze_ascii.ply", (502, 1000)),
        ("HalfDonut.stl", (144, 288)),
        ("obj_normal0.obj", (4, 2)),
        ("obj_unref_nan.obj", cube),
        ("off_modelnet.off", cube),
        ("ply_int64.ply", cube),
        ("ply_toomany.ply", (8, 11)),
        ("ply_trailspace.ply", cube),
        ("plyb_cr.ply", cube),
        ("plyb_int64.ply", cube),
        ("plyb_tail.ply", cube),
        ("points_emptyascii.ply", (12, 0)),
        ("smoothing-group-two-squares.obj", (6, 3)),
        ("stl_color.stl", cube),
        ("stl_comment.stl", cube),
        ("stl_count_ff.stl", cube),
        ("stl_count_zero.stl", cube),
        ("stl_noend.stl", cube),
        ("stl_solid_trailing.stl", cube),
        ("stl_trailing1.stl", cube),
        ("stl_upper.stl", cube),
        ("stl_utf8bom.stl", cube),
        ("whitespace.off", cube),
    ] {
        let Some(path) = data(&format!("inputs/meshes/{name}")) else { continue };
        let mesh = read(&path).unwrap_or_else(|e| panic!("{e}")).mesh;
        assert_eq!((mesh.vertices().len(), mesh.faces().len()), size, "{name}");
        if size == cube && name.starts_with(|c: char| "ops".contains(c)) {
            let (area, volume) = (mesh.area(), mesh.volume().unwrap());
            assert!((area - 6.0).abs() + (volume - 1.0).abs() < 1e-12, "{name}: {area}, {volume}");
        }
    }
}
