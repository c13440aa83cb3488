//! Mesh files: what is written is read back the same, and what is broken is an error that names its
//! place.

use std::fs;
use std::io::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use catamaran::base::Rng;
use catamaran::io::{Output, Overwrite, SourceOptions};
use catamaran::{Error, Result};
use catamaran_geometry::mesh::io::{
    Attribute, GltfEncoding, Labels, MeshFile, MeshFormat, PlyEncoding, StlEncoding, read,
    read_bytes, read_with, write, write_as,
};
use catamaran_geometry::mesh::{Problem, RepairOptions, TriMesh, families, repair};
use tempfile::TempDir;

const PLY: [MeshFormat; 3] = [
    MeshFormat::Ply(PlyEncoding::Ascii),
    MeshFormat::Ply(PlyEncoding::LittleEndian),
    MeshFormat::Ply(PlyEncoding::BigEndian),
];
const OBJ: MeshFormat = MeshFormat::Obj;
const OFF: MeshFormat = MeshFormat::Off;
const STL_TEXT: MeshFormat = MeshFormat::Stl(StlEncoding::Ascii);
const STL: MeshFormat = MeshFormat::Stl(StlEncoding::Binary);
const GLTF: MeshFormat = MeshFormat::Gltf(GltfEncoding::Text);
const GLB: MeshFormat = MeshFormat::Gltf(GltfEncoding::Binary);

fn extension(format: MeshFormat) -> &'static str {
    match format {
        MeshFormat::Obj => "obj",
        MeshFormat::Ply(_) => "ply",
        MeshFormat::Off => "off",
        MeshFormat::Stl(_) => "stl",
        MeshFormat::Gltf(_) => "gltf",
        other => panic!("{other:?} is for mesh_formats.rs"),
    }
}

pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The bytes of a file in a format.
    fn bytes(&self, file: &MeshFile, format: MeshFormat) -> Vec<u8> {
        let path = self.path(&format!("mesh.{}", extension(format)));
        write_as(create(&path), file, format).expect("written");
        fs::read(&path).expect("a file")
    }
}

pub fn create(path: &Path) -> Output {
    Output::create(path, Overwrite::Replace).expect("an output")
}

fn meshes() -> Vec<(&'static str, TriMesh)> {
    let made = [
        ("sphere", families::icosphere(2)),
        ("spheres", families::spheres(2, 0)),
        ("grid", families::grid(3, 2)),
        ("disk", families::disk(3, 7)),
        ("cylinder", families::cylinder(5, 2, 0.3, 1.0)),
        ("torus", families::torus(7, 5, 1.0, 0.3)),
        ("knot", families::knot(2, 3, 40, 4, 0.2)),
        ("genus", families::genus(2, 1)),
        ("terrain", families::terrain(6, 5, 3)),
        ("figure", families::figure(1, 0.5)),
        ("moebius", families::moebius(9, 2)),
        ("slivers", families::slivers(4, 4, 1e-9)),
        ("pages", families::pages(5)),
        ("bow tie", families::bow_tie()),
        ("nothing", TriMesh::new(vec![], vec![])),
        (
            "extremes",
            TriMesh::new(
                vec![
                    [f64::MIN_POSITIVE, 5e-324, -0.0],
                    [1.7e308, 0.1, 1e-7],
                    [-1.0 / 3.0, 1e16, 1e22],
                ],
                vec![[2, 0, 1]],
            ),
        ),
    ];
    made.into_iter().map(|(name, mesh)| (name, mesh.expect(name))).collect()
}

#[test]
fn every_family_comes_back_bit_for_bit() {
    let folder = Folder::new();
    for (name, mesh) in meshes() {
        let file = MeshFile::from(mesh);
        for format in [[OBJ, OFF].as_slice(), &PLY].concat() {
            let back = read_bytes(&folder.bytes(&file, format), format).expect(name);
            assert_eq!(back, file, "{name}, {format:?}");
            let bits = |m: &TriMesh| {
                m.vertices().as_flattened().iter().map(|x| x.to_bits()).collect::<Vec<_>>()
            };
            assert_eq!(bits(&back.mesh), bits(&file.mesh), "{name}, {format:?}");
        }
    }
}

#[test]
fn stl_keeps_triangles_and_merges_their_corners() {
    let folder = Folder::new();
    for (name, mesh) in meshes() {
        let corners = |mesh: &TriMesh| -> Vec<[f64; 3]> {
            mesh.faces().as_flattened().iter().map(|&v| mesh.vertices()[v as usize]).collect()
        };
        let file = MeshFile::from(mesh);
        let back = read_bytes(&folder.bytes(&file, STL_TEXT), STL_TEXT).expect(name);
        assert_eq!(corners(&back.mesh), corners(&file.mesh), "{name}");
        assert_eq!(back.mesh.vertices().len(), file.mesh.vertices().len(), "{name}");
        if name == "extremes" || name == "slivers" {
            continue;
        }
        let back = read_bytes(&folder.bytes(&file, STL), STL).expect(name);
        let rounded: Vec<_> =
            corners(&file.mesh).iter().map(|p| p.map(|x| f64::from(x as f32))).collect();
        assert_eq!(corners(&back.mesh), rounded, "{name}");
        assert_eq!(back.mesh.vertices().len(), file.mesh.vertices().len(), "{name}");
    }
    // Beyond single precision: refused, and nothing appears.
    let path = folder.path("extremes.stl");
    let extremes = meshes().pop().expect("the last one").1.into();
    let refused = write(create(&path), &extremes).unwrap_err();
    assert!(refused.to_string().contains("beyond single precision") && !path.exists(), "{refused}");
}

#[test]
fn facets_that_collapse_are_counted() {
    let text = b"solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex -0 0 0\nvertex 1 0 0\n\
                 endloop\nendfacet\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n\
                 endsolid s\n";
    let file = read_bytes(text, STL_TEXT).unwrap();
    assert_eq!((file.collapsed_faces, file.mesh.faces()), (1, &[[0, 1, 2]][..]));
    assert_eq!(file.mesh.vertices().len(), 3);
    let collapsed = Problem::CollapsedFaces { count: 1, first: "line 8".into() };
    let problems = file.validate().problems;
    assert_eq!(problems, [collapsed], "{problems:?}");
    assert!(file.mesh.validate().problems.is_empty());
    // Counted without a list of all.
    let vertices = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let faces = vec![[0, 1, 2], [2, 1, 1], [0, 0, 0]];
    let report = MeshFile::from_arrays(vertices, faces).unwrap().validate().to_string();
    let line = "faces that have a vertex twice: 2 (left out, the first at face 1)";
    assert!(report.ends_with(line), "{report}");
}

/// A square with everything a file can hold, by vertex.
fn painted() -> MeshFile {
    let mut file = MeshFile::from(families::grid(1, 1).unwrap());
    let uv = vec![[0.0, 0.1], [1.0, 0.2], [0.3, 1.0], [0.5, 0.7]];
    file.uv = Some(Attribute { values: uv, corners: None });
    file.normals = Some(Attribute { values: vec![[0.0, 0.1, 1.0]; 4], corners: None });
    let colors =
        [[0.0, 1.0, 0.2, 1.0], [1.0 / 255.0, 0.4, 0.6, 1.0], [0.8, 1.0, 1.0, 0.2], [1.0; 4]];
    file.colors = Some(colors.to_vec());
    file
}

#[test]
fn attributes_of_vertices_come_back() {
    let folder = Folder::new();
    let mut other = painted();
    // Not bytes, and opaque.
    other.colors = Some(vec![[0.123456789, 0.5, 1.0, 1.0]; 4]);
    for file in [painted(), other] {
        for format in [[OBJ, OFF].as_slice(), &PLY].concat() {
            let back = read_bytes(&folder.bytes(&file, format), format).unwrap();
            let mut expected = file.clone();
            if format == PLY[1] || format == PLY[2] {
                rounded(&mut expected.uv.as_mut().unwrap().values);
            }
            if PLY.contains(&format) {
                let byte = |x: f64| (255.0 * x).round() / 255.0;
                expected.colors =
                    file.colors.as_ref().map(|all| all.iter().map(|c| c.map(byte)).collect());
            }
            if format == OFF {
                (expected.uv, expected.normals) = (None, None);
            }
            assert_eq!(back, expected, "{format:?}");
        }
    }
    let header = String::from_utf8_lossy(&folder.bytes(&painted(), PLY[1])).into_owned();
    assert!(
        header.contains("property uchar alpha")
            && header.contains("property float x")
            && header.contains("property float s\nproperty float t"),
        "{header}"
    );
}

/// Single precision, which other programs read texture coordinates of PLY in.
fn rounded(values: &mut [[f64; 2]]) {
    values.as_flattened_mut().iter_mut().for_each(|x| *x = f64::from(*x as f32));
}

#[test]
fn attributes_of_corners_come_back() {
    let folder = Folder::new();
    let mut file = MeshFile::from(families::grid(2, 1).unwrap());
    let absent = [Attribute::<2>::ABSENT; 3];
    let values: Vec<_> = (0..5).map(|i| [f64::from(i) / 7.0, 0.25]).collect();
    let corners = vec![[0, 1, 2], absent, [2, 3, 4], [4, 0, 1]];
    file.uv = Some(Attribute { values, corners: Some(corners.clone()) });
    let normals = vec![[0.0, 0.0, 1.0], [0.0, 0.6, 0.8]];
    file.normals =
        Some(Attribute { values: normals, corners: Some(vec![[0; 3], [1; 3], [0; 3], [1; 3]]) });
    let back = read_bytes(&folder.bytes(&file, OBJ), OBJ).unwrap();
    assert_eq!(back, file);
    // In PLY each corner has a value of its own, 0 where there is none, and normals of corners have
    // no place.
    for format in PLY {
        let back = read_bytes(&folder.bytes(&file, format), format).unwrap();
        assert_eq!((&back.mesh, &back.normals), (&file.mesh, &None));
        let (uv, mut expected) = (back.uv.unwrap(), file.uv.clone().unwrap());
        if format != PLY[0] {
            rounded(&mut expected.values);
        }
        for f in 0..4 {
            let expected = expected.of_face(&file.mesh, f).unwrap_or_default();
            assert_eq!(uv.of_face(&back.mesh, f), Some(expected), "{format:?}, {f}");
        }
    }
    // What does not fit is not written.
    let path = folder.path("wrong.obj");
    for wrong in [vec![[0, 1, 9]; 4], vec![[0; 3]; 3]] {
        file.uv.as_mut().unwrap().corners = Some(wrong);
        assert!(write(create(&path), &file).is_err() && !path.exists());
    }
}

#[test]
fn packed_files_are_read_and_gzipped_ones_written() {
    let folder = Folder::new();
    let file = MeshFile::from(families::icosphere(1).unwrap());
    for name in ["a.obj.gz", "a.ply.gz", "a.OFF.GZ", "a.off"] {
        let path = folder.path(name);
        write(create(&path), &file).unwrap();
        assert_eq!(read(&path).unwrap(), file, "{name}");
        let magic = fs::read(&path).unwrap()[..2] == [0x1f, 0x8b];
        assert_eq!(magic, name != "a.off", "{name}");
    }
    let refused = write(create(&folder.path("a.ply.xz")), &file).unwrap_err();
    assert!(refused.to_string().contains("only be read"), "{refused}");
    let unknown = write(create(&folder.path("a.doc")), &file).unwrap_err();
    assert!(unknown.to_string().contains("unknown kind of mesh"), "{unknown}");

    // `v 0 0 0, v 1 0 0, v 0 1 0, f 1 2 3` by xz 5.4.
    let path = folder.path("triangle.obj.xz");
    fs::write(&path, XZ).unwrap();
    assert_eq!(read(&path).unwrap().mesh.faces(), [[0, 1, 2]]);
    for cut in 0..XZ.len() {
        fs::write(&path, &XZ[..cut]).unwrap();
        assert!(read(&path).is_err(), "{cut}");
    }
    let path = folder.path("triangle.obj.bz2");
    fs::write(&path, BZ2).unwrap();
    assert_eq!(read(&path).unwrap().mesh.faces(), [[0, 1, 2]]);
    fs::write(&path, &BZ2[..BZ2.len() - 1]).unwrap();
    assert!(read(&path).is_err());
    let path = folder.path("triangle.obj.xz");
    let mut rng = Rng::new(1);
    for _ in 0..500 {
        let mut bytes = XZ.to_vec();
        let at = rng.bits() as usize % bytes.len();
        bytes[at] ^= 1 << (rng.bits() % 8);
        fs::write(&path, &bytes).unwrap();
        drop(read(&path));
    }
    fs::write(&path, XZ_GREEDY).unwrap();
    let refused = read(&path).unwrap_err();
    assert!(refused.to_string().contains("dictionary"), "{refused}");
}

/// The same by Python's bz2.
#[rustfmt::skip]
const BZ2: [u8; 59] = [
    0x42, 0x5a, 0x68, 0x39, 0x31, 0x41, 0x59, 0x26, 0x53, 0x59, 0x14, 0x8b, 0xc2, 0x85, 0x00, 0x00,
    0x0e, 0xd9, 0x80, 0x00, 0x10, 0x40, 0x00, 0x78, 0x00, 0x01, 0x00, 0x01, 0x00, 0x20, 0x00, 0x31,
    0x0c, 0x08, 0x12, 0xa7, 0xea, 0x86, 0x9f, 0xaa, 0x6f, 0x13, 0xa8, 0xb0, 0xb7, 0x28, 0x35, 0x07,
    0xc5, 0xdc, 0x91, 0x4e, 0x14, 0x24, 0x05, 0x22, 0xf0, 0xa1, 0x40,
];

#[rustfmt::skip]
const XZ: [u8; 80] = [
    0xfd, 0x37, 0x7a, 0x58, 0x5a, 0x00, 0x00, 0x01, 0x69, 0x22, 0xde, 0x36, 0x02, 0x00, 0x21, 0x01,
    0x00, 0x00, 0x00, 0x00, 0x37, 0x27, 0x97, 0xd6, 0xe0, 0x00, 0x1f, 0x00, 0x18, 0x5d, 0x00, 0x3b,
    0x08, 0x02, 0x11, 0x02, 0x0a, 0x80, 0x5b, 0x9c, 0x91, 0xd6, 0x00, 0x57, 0xaf, 0xbe, 0x9d, 0x6f,
    0x8d, 0xd0, 0xae, 0x4d, 0x9e, 0xbd, 0x00, 0x00, 0x43, 0xf9, 0x6e, 0x2a, 0x00, 0x01, 0x30, 0x20,
    0x10, 0xa3, 0xae, 0xc4, 0x90, 0x42, 0x99, 0x0d, 0x01, 0x00, 0x00, 0x00, 0x00, 0x01, 0x59, 0x5a,
];

/// The same, asking for a dictionary of 1 GiB.
#[rustfmt::skip]
const XZ_GREEDY: [u8; 84] = [
    0xfd, 0x37, 0x7a, 0x58, 0x5a, 0x00, 0x00, 0x04, 0xe6, 0xd6, 0xb4, 0x46, 0x02, 0x00, 0x21, 0x01,
    0x24, 0x00, 0x00, 0x00, 0x5e, 0x1f, 0xc7, 0xf9, 0xe0, 0x00, 0x1f, 0x00, 0x18, 0x5d, 0x00, 0x3b,
    0x08, 0x02, 0x11, 0x02, 0x0a, 0x80, 0x5b, 0x9c, 0x91, 0xd6, 0x00, 0x57, 0xaf, 0xbe, 0x9d, 0x6f,
    0x8d, 0xd0, 0xae, 0x4d, 0x9e, 0xbd, 0x00, 0x00, 0xd2, 0x82, 0x02, 0x14, 0x72, 0x61, 0x16, 0x71,
    0x00, 0x01, 0x34, 0x20, 0x14, 0x66, 0xc2, 0xa0, 0x1f, 0xb6, 0xf3, 0x7d, 0x01, 0x00, 0x00, 0x00,
    0x00, 0x04, 0x59, 0x5a,
];

#[test]
fn bombs_are_refused() {
    let folder = Folder::new();
    let path = folder.path("bomb.obj.gz");
    let file = fs::File::create(&path).unwrap();
    let mut gz = flate2::write::GzEncoder::new(file, flate2::Compression::fast());
    let comments = [b"#\n".as_slice(); 1 << 16].concat();
    for _ in 0..(1 << 26) / comments.len() + 1 {
        gz.write_all(&comments).unwrap();
    }
    gz.finish().unwrap();
    let within = SourceOptions::new().max_memory(1 << 26);
    let refused = read_with(&path, &within).unwrap_err();
    assert!(refused.to_string().contains("unpacks to more than"), "{refused}");
    // One long line.
    let long = vec![b' '; (1 << 20) + 1];
    for ending in ["obj", "off", "stl", "ply"] {
        let start = if ending == "stl" { b"solid\n".as_slice() } else { b"" };
        let path = folder.path(&format!("long.{ending}"));
        fs::write(&path, [start, &long].concat()).unwrap();
        let refused = read_with(&path, &within).unwrap_err();
        assert!(refused.to_string().contains("a line of 1048576 bytes or more"), "{refused}");
    }
}

#[test]
fn the_limit_of_memory_holds_for_text_in_utf16_and_with_carriage_returns() {
    let folder = Folder::new();
    let long = " ".repeat((1 << 20) + 1);
    let within = SourceOptions::new().max_memory(1 << 26);
    for (ending, start) in [("obj", "#\r#\r#\r"), ("off", "OFF\r#\r#\r")] {
        let text = format!("{start}{long}");
        let wide = format!("\u{feff}{text}").encode_utf16().flat_map(u16::to_le_bytes).collect();
        for bytes in [text.into_bytes(), wide] {
            let path = folder.path(&format!("long.{ending}"));
            fs::write(&path, &bytes).unwrap();
            let refused = read_with(&path, &within).unwrap_err();
            assert!(refused.to_string().contains("a line of 1048576 bytes or more"), "{refused}");
        }
    }
}

#[test]
fn reading_reports_progress_and_can_be_cancelled() {
    let folder = Folder::new();
    let path = folder.path("mesh.ply");
    let mesh = families::icosphere(3).unwrap();
    write(create(&path), &mesh.clone().into()).unwrap();
    let last = std::sync::Mutex::new(0.0);
    let remember = |fraction| {
        *last.lock().unwrap() = fraction;
        ControlFlow::Continue(())
    };
    let file = read_with(&path, &SourceOptions::new().progress(&remember));
    assert_eq!((file.unwrap().mesh, *last.lock().unwrap()), (mesh, 1.0));
    let cancel = |_| ControlFlow::Break(());
    let cancelled = read_with(&path, &SourceOptions::new().progress(&cancel));
    assert_eq!(cancelled.unwrap_err(), Error::Cancelled);
}

#[test]
fn missing_and_nameless_files_are_named() {
    let folder = Folder::new();
    fs::write(folder.path("text.txt"), "some text\n").unwrap();
    for (name, what) in [
        ("none.obj", "no such file"),
        ("none.txt", "no such file"),
        ("text.txt", "unknown kind of mesh"),
    ] {
        let path = folder.path(name);
        match read(&path) {
            Err(Error::Io { path: named, line: None, what: said, .. }) => {
                assert!(named == path && said.contains(what), "{said}");
            }
            other => panic!("{other:?}"),
        }
    }
}

fn mesh_of(text: &str, format: MeshFormat) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let file = read_bytes(text.as_bytes(), format).unwrap_or_else(|e| panic!("{e}: {text}"));
    file.mesh.into_parts()
}

#[test]
fn obj_is_read_in_its_many_dialects() {
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    let two = vec![[0, 1, 2], [0, 2, 3]];
    for face in [
        "f 1 2 3 4",
        "f -4 -3 -2 -1",
        "  f\t1 2 \\\n 3 \\\n4  ",
        "f 1 2 3 4 # a comment",
        "fo 1 2 3 4\r",
        "vn 0 0 1\nf 1//1 2//1 3//-1 4//1",
        "vt 0.5\nvt 1 1 0\nf 1/1 2/2 3/1 4/-1",
        "o name with \u{e9}\ng a\ns off\nusemtl m\nmtllib f\nl 1 2\np 3\nf 1 2 3 4",
    ] {
        assert_eq!(
            mesh_of(&format!("\u{feff}# a comment\n{square}{face}\n"), OBJ).1,
            two,
            "{face}"
        );
    }
    // Latin-1, faces first, weights.
    let odd = b"g caf\xe9\nf 1 2 3\nv 0 0 0 1\nv 1 0 0 1\nv 0 1 0 1";
    assert_eq!(read_bytes(odd, OBJ).unwrap().mesh.faces(), [[0, 1, 2]]);
    let bytes = "v 0 0 0 255 0 0\nv 1 0 0 0 128 0\n";
    let colors = read_bytes(bytes.as_bytes(), OBJ).unwrap().colors.unwrap();
    assert_eq!(colors, [[1.0, 0.0, 0.0, 1.0], [0.0, 128.0 / 255.0, 0.0, 1.0]]);
    // Colours of some vertices only are none.
    assert_eq!(read_bytes(b"v 0 0 0 1 0 0\nv 1 0 0\n", OBJ).unwrap().colors, None);
}

#[test]
fn off_is_read_in_its_many_dialects() {
    let rest =
        "# a comment\n\n 0 0 0 # here too\n1 0 0\n1 1 0\n\n0 1 0\n4 0 1 2 3 255 0 0\n\n#end\n";
    for head in ["OFF\n4 1 0\n", "OFF 4 1 4\n", "# first\nOFF # then\n4 1\n"] {
        assert_eq!(mesh_of(&format!("{head}{rest}"), OFF).1, [[0, 1, 2], [0, 2, 3]], "{head}");
    }
    let file = read_bytes(b"STCNOFF\n1 0 0\n1 2 3 0 0 1 255 0 0 51 0.5 0.25", OFF).unwrap();
    assert_eq!(file.normals.unwrap().values, [[0.0, 0.0, 1.0]]);
    assert_eq!(file.colors.unwrap(), [[1.0, 0.0, 0.0, 0.2]]);
    assert_eq!(file.uv.unwrap().values, [[0.5, 0.25]]);
}

#[test]
fn ply_is_read_with_any_properties_in_any_order() {
    let text = "ply\r\nformat ascii 1.0\r\ncomment c\nobj_info o\nelement camera 1\nproperty list uchar int ids\n\
                property double f\nelement nothing 99999999999\nelement face 1\nproperty uchar flags\n\
                property list uint8 uint32 vertex_index\nelement vertex 4\nproperty uchar red\nproperty int8 z\n\
                property uchar green\nproperty float64 y\nproperty short x\nproperty uchar blue\n\
                element edge 1\nproperty int a\nend_header\n2 7 8 0.5\n1 4 3 2 1 0\n255 0 51 0.5 0 0\n\n0 0 0 0 1 0\n\
                0 0 0 1 1 0\n0 0 0 1 0 0\n5\n\n";
    let file = read_bytes(text.as_bytes(), PLY[0]).unwrap();
    assert_eq!(file.mesh.faces(), [[3, 2, 1], [3, 1, 0]]);
    assert_eq!(file.mesh.vertices()[0], [0.0, 0.5, 0.0]);
    assert_eq!(file.colors.unwrap()[0], [1.0, 0.2, 0.0, 1.0]);
    // The same numbers in binary, in both orders.
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty short z\nproperty list char float l\n\
                  property uint x\nproperty double y\nelement face 1\nproperty list int ushort vertex_indices\n\
                  end_header\n";
    for (little, order) in [(true, "binary_little_endian"), (false, "binary_big_endian")] {
        let mut bytes = header.replace("binary_little_endian", order).into_bytes();
        let mut put = |mut number: Vec<u8>| {
            if !little {
                number.reverse();
            }
            bytes.extend(number);
        };
        for (x, y, z) in [(0u32, 0.0f64, -5i16), (4_000_000_000, 0.25, 300), (1, 1.0, 0)] {
            put(z.to_le_bytes().to_vec());
            put(vec![2]);
            put(1.5f32.to_le_bytes().to_vec());
            put(2.5f32.to_le_bytes().to_vec());
            put(x.to_le_bytes().to_vec());
            put(y.to_le_bytes().to_vec());
        }
        put(3i32.to_le_bytes().to_vec());
        [2u16, 0, 1].into_iter().for_each(|v| put(v.to_le_bytes().to_vec()));
        let mesh = read_bytes(&bytes, PLY[1]).unwrap().mesh;
        assert_eq!(mesh.vertices()[..2], [[0.0, 0.0, -5.0], [4e9, 0.25, 300.0]], "{order}");
        assert_eq!(mesh.faces(), [[2, 0, 1]], "{order}");
    }
}

/// The line and the message of what reading says, or the element of what is no mesh.
pub fn refusal(bytes: &[u8], format: MeshFormat) -> (Option<usize>, String) {
    match read_bytes(bytes, format) {
        Err(Error::Io { line, what, .. }) => (line, what),
        Err(Error::Mesh { what, element }) => (None, format!("{element}: {what}")),
        other => panic!("{other:?} of {:?}", String::from_utf8_lossy(bytes)),
    }
}

#[test]
fn broken_text_is_named_by_its_line() {
    let v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let ply = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
    let face = "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n";
    let cases: Vec<(String, MeshFormat, Option<usize>, &str)> = vec![
        ("v 0\n".into(), OBJ, Some(1), "1 numbers where 2 are needed"),
        ("v 0 0 0\nv 0 0\n".into(), OBJ, Some(2), "2 numbers where 3 are needed"),
        ("v 0 0\nv 0 0 0\n".into(), OBJ, Some(2), "3 numbers where the first vertex has 2"),
        ("v 0 0 x\n".into(), OBJ, Some(1), "\"x\" is not a number"),
        (format!("\nv 0 0 nan\n{v}f 1 2 3\n"), OBJ, None, "line 2: the position of a vertex"),
        (format!("v 0 0 1e999\n{v}f 2 1 3\n"), OBJ, None, "line 1: the position of a vertex"),
        (format!("{v}f 1 2 4\n\n"), OBJ, Some(4), "vertex 4 is out of range: the file has 3"),
        (format!("{v}f 1 2 0\n"), OBJ, Some(4), "vertex 0 is out of range: 3"),
        (format!("{v}f 1 2 -4\n"), OBJ, Some(4), "vertex -4 is out of range: 3 so far"),
        (format!("{v}f 1 2 99999999999999999999\n"), OBJ, Some(4), "not a whole number"),
        (
            format!("{v}f 1 2 4294967296\n"),
            OBJ,
            Some(4),
            "vertex 4294967296 is out of range: 3 so far",
        ),
        (format!("{v}f 1/1/1/1 2 3\n"), OBJ, Some(4), "is not a corner"),
        ("\nhello\nworld\n".into(), OBJ, Some(2), "\"hello\" is not a statement"),
        ("COFFEE\n".into(), OFF, Some(1), "is not OFF"),
        ("OFFICE\n".into(), OFF, Some(1), "is not OFF"),
        ("OFF BINARY\n".into(), OFF, Some(1), "binary OFF"),
        ("OFF\n1\n".into(), OFF, Some(3), "truncated: the file ends before counts"),
        ("OFF\n-1 0 0\n".into(), OFF, Some(2), "-1 is not a count"),
        (
            "OFF\n2 0 0\n0 0 0\n".into(),
            OFF,
            Some(4),
            "truncated: the file ends before vertex 1 of 2",
        ),
        (
            "OFF\n3 1 0\n0 0 0\n0 0 1\n0 1 0\n3 0 1 3\n".into(),
            OFF,
            Some(6),
            "vertex 3 is out of range: 3",
        ),
        ("OFF\n3 1 0\n0 0 0\n0 0 1\n0 1 0\n3 0 1\n".into(), OFF, Some(7), "2 of 3 corners"),
        ("OFF\n9999999999999 9999999999 0\n".into(), OFF, Some(3), "truncated"),
        ("solid\nfacet\nvertex 0 0\n".into(), STL_TEXT, Some(3), "2 numbers where 3"),
        ("solid\nfacet\nendfacet\n".into(), STL_TEXT, Some(3), "a facet has 0 vertices"),
        ("solid\nendsolid\nvertex 0 0 0\n".into(), STL_TEXT, Some(3), "out of place"),
        ("solid\nfacet\nouter loop\n".into(), STL_TEXT, Some(4), "truncated: the last facet"),
        ("plyy\n".into(), PLY[0], Some(1), "must be 'ply'"),
        ("ply\nformat ascii 1.0\n".into(), PLY[0], Some(3), "no end_header"),
        ("ply\nformat ascii 2.0\n".into(), PLY[0], Some(2), "version"),
        ("ply\nend_header\n".into(), PLY[0], Some(2), "the header has no format"),
        ("ply\nproperty int x\n".into(), PLY[0], Some(2), "a property without an element"),
        ("ply\nelement vertex many\n".into(), PLY[0], Some(2), "not a whole number"),
        ("ply\nelement a 1\nproperty quad x\n".into(), PLY[0], Some(3), "\"quad\""),
        (format!("{ply}end_header\n0 0\n"), PLY[0], Some(8), "too few numbers"),
        (
            format!("{ply}end_header\n\n"),
            PLY[0],
            Some(9),
            "truncated: 0 of 1 rows of element vertex",
        ),
        (
            format!("{ply}{face}3 0 -1 0\n"),
            PLY[0],
            Some(11),
            "face 0: -1 is not the number of a vertex",
        ),
        (
            format!("{ply}{face}3 0 1 2\n"),
            PLY[0],
            None,
            "mesh.ply: face 0: vertex 1 is out of range: 1",
        ),
        (
            format!("{ply}{face}999999999999 0 1 2\n"),
            PLY[0],
            Some(11),
            "999999999999 is not the length",
        ),
        (
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n".into(),
            PLY[0],
            Some(5),
            "vertices have no x, y and z",
        ),
    ];
    for (text, format, line, what) in cases {
        let (found, said) = refusal(text.as_bytes(), format);
        assert!(found == line && said.contains(what), "{text:?}: line {found:?}: {said}");
        assert!(!said.contains('\n'), "{said}");
    }
}

#[test]
fn broken_binary_files_name_their_element() {
    let folder = Folder::new();
    let file = MeshFile::from(families::icosphere(0).unwrap());
    let ply = folder.bytes(&file, PLY[1]);
    assert_eq!(
        refusal(&ply[..ply.len() - 1], PLY[1]).1,
        "face 19: truncated: the file ends too early"
    );
    let mut wrong = ply.clone();
    let last = wrong.len() - 2;
    wrong[last] = 1;
    assert!(refusal(&wrong, PLY[1]).1.starts_with("mesh.ply: face 19: vertex "));
    let stl = folder.bytes(&file, STL);
    assert_eq!(refusal(&stl[..stl.len() - 1], STL).1, "truncated: facet 19 of 20 is incomplete");
    assert_eq!(refusal(&stl[..83], STL).1, "truncated: the header is incomplete");
    let mut wrong = stl.clone();
    wrong[84 + 50 * 3 + 12..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(refusal(&wrong, STL).1.starts_with("facet 3 of 20: position [NaN"));
    // A count that lies takes no memory.
    let mut wrong = stl;
    wrong[80..84].copy_from_slice(&(u32::MAX - 1).to_le_bytes());
    assert_eq!(
        refusal(&wrong, STL).1,
        format!("truncated: facet 20 of {} is incomplete", u32::MAX - 1)
    );
    let huge =
        b"ply\nformat binary_little_endian 1.0\nelement vertex 18446744073709551615\nend_header\n";
    assert!(refusal(huge, PLY[1]).1.contains("not a whole number"));
    let lists = b"ply\nformat binary_little_endian 1.0\nelement a 1\nproperty list uint double l\nend_header\n\xff\xff\xff\xffabc";
    assert_eq!(refusal(lists, PLY[1]).1, "a 0: truncated: the file ends too early");
}

#[test]
fn binary_files_longer_than_a_block_are_read_whole() {
    let folder = Folder::new();
    let sphere = MeshFile::from(families::icosphere(5).unwrap());
    let faces = sphere.mesh.faces().len();
    for (format, last) in [
        (STL, format!("truncated: facet {} of {faces} is incomplete", faces - 1)),
        (PLY[1], format!("face {}: truncated: the file ends too early", faces - 1)),
        (PLY[2], format!("face {}: truncated: the file ends too early", faces - 1)),
    ] {
        let mut bytes = folder.bytes(&sphere, format);
        let found = read_bytes(&bytes, format).unwrap();
        assert!(found.notes.is_empty(), "{:?}", found.notes);
        let corners = |mesh: &TriMesh| -> Vec<[[f32; 3]; 3]> {
            let place = |v: u32| mesh.vertices()[v as usize].map(|x| x as f32);
            mesh.faces().iter().map(|face| face.map(place)).collect()
        };
        assert!(corners(&found.mesh) == corners(&sphere.mesh));
        assert_eq!(found.mesh.vertices().len(), sphere.mesh.vertices().len());
        assert_eq!(refusal(&bytes[..bytes.len() - 1], format).1, last);
        bytes.extend([0, 0, 0]);
        let said = read_bytes(&bytes, format).unwrap().notes;
        let [said] = &said[..] else { panic!("{said:?}") };
        assert!(
            said.starts_with("left out bytes after the last ") && said.ends_with(": 3"),
            "{said}"
        );
    }
}

/// The note that begins so.
pub fn note<'a>(file: &'a MeshFile, start: &str) -> &'a str {
    let found = file.notes.iter().find(|note| note.starts_with(start));
    found.unwrap_or_else(|| panic!("no note {start:?}: {:?}", file.notes))
}

#[test]
fn faces_with_a_vertex_twice_are_left_out_and_counted() {
    let v = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
    let text = format!("{v}f 1/1 2/2 2/3\nusemtl m\nf 1/1 2/2 3/3 3/3 4/4\nf 4/4 1/4 2/2\n");
    let file = read_bytes(text.as_bytes(), OBJ).unwrap();
    assert_eq!(file.mesh.faces(), [[0, 1, 2], [0, 2, 3], [3, 0, 1]]);
    let uv = file.uv.as_ref().unwrap();
    assert_eq!(uv.of_face(&file.mesh, 2), Some([[0.0, 1.0], [0.0, 1.0], [1.0, 0.0]]));
    assert_eq!(file.materials.as_ref().unwrap().of_faces, [0, 0, 0]);
    assert_eq!(file.collapsed_faces, 2);
    let said = note(&file, "left out triangles that have a vertex twice");
    assert!(said.ends_with(": 2, the first at line 9"), "{said}");

    let square = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    let off = format!("OFF\n4 2 0\n{square}3 0 0 1\n4 0 1 2 3\n");
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
         property float z\nelement face 2\nproperty list uchar int vertex_indices\n\
         property list uchar float texcoord\nend_header\n{square}\
         3 0 0 1 6 9 9 9 9 9 9\n4 0 1 2 3 8 0 0 1 0 1 1 0 1\n"
    );
    for (text, format, place) in [(off, OFF, "line 7"), (ply, PLY[0], "face 0")] {
        let file = read_bytes(text.as_bytes(), format).unwrap();
        assert_eq!(file.mesh.faces(), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(file.collapsed_faces, 1);
        assert!(file.notes.iter().any(|n| n.ends_with(place)), "{:?}", file.notes);
        if let Some(uv) = &file.uv {
            let square = [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            assert_eq!(uv.of_face(&file.mesh, 1), Some(square));
        }
    }
}

#[test]
fn faces_that_are_points_or_edges_are_left_out_and_counted() {
    let v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let file = read_bytes(format!("{v}f\nf 1\nf 1 2\nf 1 2 3\n").as_bytes(), OBJ).unwrap();
    assert_eq!(file.mesh.faces(), [[0, 1, 2]]);
    let said = note(&file, "left out faces of fewer than three corners");
    assert!(said.ends_with(": 3, the first at line 4"), "{said}");
    let off = b"OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n3 0 1 2\n";
    let file = read_bytes(off, OFF).unwrap();
    assert_eq!((file.mesh.faces(), file.notes.len()), (&[[0, 1, 2]][..], 1));
}

#[test]
fn statements_that_are_not_of_obj_are_skipped_and_counted() {
    let text = b"v 0 0 0\nv 1 0 0\n$ 1 2\nv 0 1 0\nhello world\nl 1 2\nf 1 2 3\n";
    let file = read_bytes(text, OBJ).unwrap();
    assert_eq!(file.mesh.faces(), [[0, 1, 2]]);
    let said = note(&file, "skipped statements that are not of OBJ");
    assert!(said.ends_with(": 2, the first at line 3 (\"$\")"), "{said}");
    note(&file, "left out lines, points");
    // Corners of different kinds.
    let mixed = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2 3\nf 1/1 2/1 3/1\n";
    let file = read_bytes(mixed, OBJ).unwrap();
    assert_eq!(file.uv.as_ref().unwrap().of_face(&file.mesh, 0), None);
    assert!(file.uv.as_ref().unwrap().of_face(&file.mesh, 1).is_some());
    note(&file, "left out texture coordinates or normals that some corners");
}

#[test]
fn numbers_that_are_not_finite_stop_no_reader_but_in_positions() {
    let obj = "v 0 0 0 nan 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 -nan(ind)\nvt nan -nan\nvn inf 0 1\n\
               f 1/1/1 2/1/1 3/1/1\n";
    let off = "STCNOFF\n3 1 0\n0 0 0 nan 0 1 0 nan 0 0 nan\n1 0 0 0 0 1 0 1 0 0 0\n\
               0 1 0 0 0 inf 0 0 nan 0 0\n3 0 1 2\n";
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
               property float z\nproperty float nx\nproperty float ny\nproperty float nz\n\
               property float s\nproperty float t\nproperty float red\nproperty float green\n\
               property float blue\nelement face 1\nproperty list uchar int vertex_indices\n\
               end_header\n0 0 0 nan 0 1 nan 0 0 nan 0\n1 0 0 0 0 1 0 0 0 0 0\n\
               0 1 0 0 0 1 0 inf 0 0 nan\n3 0 1 2\n";
    for (text, format) in [(obj, OBJ), (off, OFF), (ply, PLY[0])] {
        let file = read_bytes(text.as_bytes(), format).unwrap();
        assert_eq!(file.mesh.faces(), [[0, 1, 2]], "{format:?}");
        let said = note(&file, "took 0 for numbers of colours, normals and texture coordinates");
        assert!(said.contains(": 5, the first"), "{said}");
        let values = [
            file.uv.unwrap().values.as_flattened(),
            file.normals.unwrap().values.as_flattened(),
            file.colors.unwrap().as_flattened(),
        ]
        .concat();
        assert!(values.iter().all(|x| x.is_finite()), "{format:?}");
    }
}

#[test]
fn off_is_read_wherever_its_lines_end() {
    let two = [[0, 1, 2], [0, 2, 3]];
    for text in [
        "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0\n1\n\n2 # here\n3\n",
        "OFF\n4\n1\n0\n0 0\n0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n",
        "OFF 4 1 0 0 0 0 1 0 0 1 1 0 0 1 0 4 0 1 2 3",
        "OFF\n4 2 0\n0 0 0 1 0 0 1 1 0 0 1 0\n3 0 1 2\n3 0 2 3 0.1 0.2 0.3\n",
        "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1\n2 255 0 0\n3 0 2 3 1 0 0 1\n",
    ] {
        let (vertices, faces) = mesh_of(text, OFF);
        assert_eq!(faces, two, "{text:?}");
        assert_eq!(vertices[2..], [[1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], "{text:?}");
    }
    let colors = "COFF\n3 1 0\n0 0 0\n255 0\n0\n1 0 0 0 255 0\n0 1 0 0 0 255\n3 0 1 2 9\n";
    let file = read_bytes(colors.as_bytes(), OFF).unwrap();
    assert_eq!(file.colors.as_ref().unwrap()[0], [1.0, 0.0, 0.0, 1.0]);
    assert!(note(&file, "left out colours of faces").ends_with(": 1, the first at line 8"));
}

#[test]
fn elements_of_off_that_were_taken_for_a_colour_are_quoted_where_some_are_missing() {
    let square = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    let cases = [
        (
            format!("OFF\n4 2 0\n{square}3 0 1 2  3 0 2 3 # two\n"),
            (8, "face 1 of 2; in line 7, \"3 0 2 3\" was taken for the colour of a face"),
        ),
        (
            "OFF\n2 0 0\n0 0 0 1 0 0\n".into(),
            (
                4,
                "vertex 1 of 2 (0 of 3 numbers); in line 3, \"1 0 0\" was taken for the colour of a \
                 vertex",
            ),
        ),
        // The first line that has a face and more.
        (
            format!(
                "COFF\n4 5 0\n{}3 0 1 2\n3 0 2 3 1\n3 0 1 3 2\n",
                square.replace('\n', " 1 1 1\n")
            ),
            (10, "face 3 of 5; in line 8, \"1\" was taken for the colour of a face"),
        ),
    ];
    for (text, (line, what)) in cases {
        let said = format!("truncated: the file ends before {what}");
        assert_eq!(refusal(text.as_bytes(), OFF), (Some(line), said));
    }
}

#[test]
fn triangle_strips_of_ply_are_read() {
    let text = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\n\
                property float z\nelement tristrips 2\nproperty list int int vertex_indices\n\
                end_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n1 2 0\n\
                11 0 1 2 3 -1 2 3 4 5 -1 4\n5 0 1 1 2 3\n";
    let file = read_bytes(text.as_bytes(), PLY[0]).unwrap();
    let strips = [[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5], [1, 2, 3]];
    assert_eq!(file.mesh.faces(), strips);
    // Triangles without area only turn a strip.
    assert_eq!((file.collapsed_faces, file.notes), (0, vec![]));
    let wrong = text.replace("5 0 1 1 2 3", "3 0 1 7");
    assert!(refusal(wrong.as_bytes(), PLY[0]).1.contains("vertex 7 is out of range: 6"));
    let wrong = text.replace("5 0 1 1 2 3", "3 0 1 -2");
    assert_eq!(
        refusal(wrong.as_bytes(), PLY[0]).1,
        "tristrips 1: -2 is not the number of a vertex"
    );
}

#[test]
fn lists_of_ply_may_be_of_any_type() {
    for (count, item) in [("float", "double"), ("int", "float"), ("ushort", "char")] {
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
             property float z\nelement face 1\nproperty list {count} {item} vertex_indices\n\
             end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
        );
        assert_eq!(mesh_of(&text, PLY[0]).1, [[0, 1, 2]]);
        for wrong in ["-1", "1.5", "nan"] {
            let wrong = text.replace("3 0 1 2", &format!("{wrong} 0 1 2"));
            assert!(read_bytes(wrong.as_bytes(), PLY[0]).is_err(), "{count}, {wrong}");
        }
    }
}

#[test]
fn concave_polygons_are_cut_along_their_inside() {
    let area = |mesh: &TriMesh| mesh.area();
    // An arrow whose first corner sees only two edges, in a plane that is askew.
    let corners = [[0.0, 2.0], [-2.0, -1.0], [0.0, 0.0], [2.0, -1.0]];
    for start in 0..4 {
        let mut text = String::new();
        for i in 0..4 {
            let [x, y] = corners[(i + start) % 4];
            text += &format!("v {x} {y} {}\nvt {x} {y}\n", x + y);
        }
        text += "f 1/1 2/2 3/3 4/4\n";
        let file = read_bytes(text.as_bytes(), OBJ).unwrap();
        assert!((area(&file.mesh) - 4.0 * 3f64.sqrt()).abs() < 1e-12, "{start}");
        assert_eq!(file.mesh.faces().len(), 2);
        // Corners have kept the values of their vertices.
        let uv = file.uv.unwrap();
        for (f, face) in file.mesh.faces().iter().enumerate() {
            let own = face.map(|v| file.mesh.vertices()[v as usize]).map(|[x, y, _]| [x, y]);
            assert_eq!(uv.of_face(&file.mesh, f), Some(own), "{start}");
        }
    }
    // A face before its vertices, in two formats.
    let obj = "f 1 2 3 4\nv -2 -1 0\nv 0 0 0\nv 2 -1 0\nv 0 2 0\n";
    let off = "OFF\n4 1 0\n-2 -1 0\n0 0 0\n2 -1 0\n0 2 0\n4 0 1 2 3\n";
    for (text, format) in [(obj, OBJ), (off, OFF)] {
        assert_eq!(area(&read_bytes(text.as_bytes(), format).unwrap().mesh), 4.0, "{format:?}");
    }
}

#[test]
fn random_polygons_keep_their_number_of_triangles() {
    let mut rng = Rng::new(23);
    for i in 0..3000 {
        let corners = 4 + (rng.bits() % 60) as usize;
        // Few places, so that corners meet and lie on lines; some polygons are large, some flat.
        let scale = [1.0, 1e-300, 1e300, 0.1][i % 4];
        let places = 1 + rng.bits() % 9;
        let mut text = String::new();
        for _ in 0..corners {
            let [x, y, z] = [0, 1, 2].map(|_| (rng.bits() % places) as f64 * scale);
            text += &format!("v {x:e} {y:e} {}\n", if i % 3 == 0 { 0.0 } else { z });
        }
        text += "f";
        (1..=corners).for_each(|v| text += &format!(" {v}"));
        let file = read_bytes(text.as_bytes(), OBJ).expect("a polygon");
        assert_eq!(file.mesh.faces().len() + file.collapsed_faces, corners - 2, "{text}");
    }
}

#[test]
fn content_decides_where_the_name_lies() {
    let folder = Folder::new();
    let file = MeshFile::from(families::icosphere(1).unwrap());
    for format in [[OBJ, OFF, STL_TEXT, STL, GLTF, GLB].as_slice(), &PLY].concat() {
        let bytes = folder.bytes(&file, format);
        for name in ["mesh.bin", "mesh", "mesh.obj", "mesh.ply", "mesh.off", "mesh.stl", "mesh.glb"]
        {
            let path = folder.path(name);
            fs::write(&path, &bytes).unwrap();
            let back = read(&path).unwrap_or_else(|e| panic!("{format:?}: {e}"));
            assert_eq!(back.mesh.faces().len(), 80, "{format:?} in {name}");
            let own = match extension(format) {
                "gltf" => name == "mesh.glb",
                other => name.ends_with(other),
            };
            assert_eq!(back.notes.is_empty(), own, "{format:?} in {name}: {:?}", back.notes);
        }
    }
    // Packed or not, whatever the name says.
    let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    gz.write_all(&folder.bytes(&file, OBJ)).unwrap();
    let packed = gz.finish().unwrap();
    let plain = folder.bytes(&file, OBJ);
    for (name, bytes, said) in [
        ("a.obj", &packed, "packed by gzip"),
        ("b", &packed, "packed by gzip"),
        ("c.obj.gz", &plain, "not packed"),
        ("d.obj.xz", &packed, "packed by gzip"),
    ] {
        let path = folder.path(name);
        fs::write(&path, bytes).unwrap();
        let back = read(&path).unwrap();
        assert_eq!(back.mesh, file.mesh, "{name}");
        note(&back, said);
    }
    // A binary STL file may begin as any text.
    let mut stl = folder.bytes(&file, STL);
    stl[..80].fill(b' ');
    stl[..6].copy_from_slice(b"solid\n");
    fs::write(folder.path("solid.stl"), &stl).unwrap();
    assert_eq!(read(&folder.path("solid.stl")).unwrap().mesh.faces().len(), 80);
}

#[test]
fn materials_groups_and_objects_of_obj_come_back() {
    let folder = Folder::new();
    let text = "mtllib two.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\n\
                f 1 2 3\no board\ng left a\nusemtl red # one\nf 1 3 4 4\n\
                g right\nusemtl blue\nf 2 5 6 3\ng left a\nf 1 2 4\n";
    let file = read_bytes(text.as_bytes(), OBJ).unwrap();
    let absent = Labels::ABSENT;
    let materials = file.materials.as_ref().unwrap();
    assert_eq!(materials.names, ["red # one", "blue"]);
    assert_eq!(materials.of_faces, [absent, 0, 1, 1, 1]);
    assert_eq!(file.groups.as_ref().unwrap().of_faces, [absent, 0, 1, 1, 0]);
    assert_eq!(file.groups.as_ref().unwrap().of_face(2), Some("right"));
    assert_eq!(file.objects.as_ref().unwrap().of_faces, [absent, 0, 0, 0, 0]);
    let back = read_bytes(&folder.bytes(&file, OBJ), OBJ).unwrap();
    let labels = |file: &MeshFile| {
        (
            file.materials.clone(),
            file.groups.clone(),
            file.objects.clone(),
            file.material_files.clone(),
        )
    };
    assert_eq!(labels(&back), labels(&file));
    // They go with faces that are kept or flipped.
    let part = file.mesh.submesh(&[4, 1]).unwrap();
    let faces = file.part(part).unwrap();
    assert_eq!(faces.materials.as_ref().unwrap().of_face(0), Some("red # one"));
    assert_eq!(faces.materials.as_ref().unwrap().of_face(1), Some("blue"));
    let bytes = folder.bytes(&faces, OBJ);
    assert_eq!(labels(&read_bytes(&bytes, OBJ).unwrap()).3, ["two.mtl"]);
    // And through repairs: the first face is left out, the last one flipped.
    let file = read_bytes(
        b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nusemtl a\nf 1 2 5\nf 1 2 3\nusemtl b\nf 1 4 3\n",
        OBJ,
    );
    let repaired = repair(file.unwrap(), &RepairOptions::everything()).unwrap().file;
    assert_eq!(repaired.mesh.faces().len(), 2);
    assert_eq!(repaired.materials.unwrap().of_faces, [0, 1]);
}

#[test]
fn names_that_would_break_a_file_are_refused() {
    let folder = Folder::new();
    let path = folder.path("a.obj");
    for name in ["", " a", "a\nv 0 0 0", "a\\"] {
        let mut file = MeshFile::from(families::grid(1, 1).unwrap());
        file.groups = Some(Labels { names: vec![name.into()], of_faces: vec![0; 2] });
        let refused = write(create(&path), &file).unwrap_err();
        assert!(refused.to_string().contains("the name"), "{refused}");
        file.groups = Some(Labels { names: vec!["a".into()], of_faces: vec![0, 1] });
        assert!(write(create(&path), &file).is_err() && !path.exists());
    }
    // What is read can be written.
    let odd = b"v 0 0 0\nv 1 0 0\nv 0 1 0\ng a\rb\\ \ng \x01\xff\nusemtl \nf 1 2 3\n";
    folder.bytes(&read_bytes(odd, OBJ).unwrap(), OBJ);
}

#[test]
fn what_a_format_has_no_place_for_is_named() {
    let mut file = painted();
    let corners = || Some(vec![[0, 1, 2], [3, 1, 2]]);
    file.uv.as_mut().unwrap().corners = corners();
    file.normals.as_mut().unwrap().corners = corners();
    file.materials = Some(Labels { names: vec!["a".into()], of_faces: vec![0; 2] });
    file.groups = file.materials.clone();
    assert_eq!(OBJ.left_out(&file), [""; 0]);
    assert_eq!(GLB.left_out(&file), ["groups"]);
    assert_eq!(PLY[0].left_out(&file), ["normals of corners", "materials", "groups"]);
    let off = ["texture coordinates", "normals beside colours", "materials", "groups"];
    assert_eq!(OFF.left_out(&file), off);
    let stl = ["texture coordinates", "normals", "colours", "materials", "groups"];
    assert_eq!(STL.left_out(&file), stl);
    for format in [[OBJ, GLB].as_slice(), &PLY].concat() {
        assert_eq!(format.left_out(&painted()), [""; 0], "{format:?}");
    }
    file.colors = None;
    assert_eq!(OFF.left_out(&file)[1], "normals of corners");
    let points = TriMesh::new(vec![[0.0; 3]], vec![]).unwrap().into();
    assert_eq!(STL.left_out(&points), ["vertices without a face"]);
}

/// A mesh whose numbers are whole in single precision.
fn rounded_mesh(mesh: &TriMesh) -> TriMesh {
    let (vertices, faces) = mesh.clone().into_parts();
    let single = vertices.into_iter().map(|p| p.map(|x| f64::from(x as f32))).collect();
    TriMesh::new(single, faces).unwrap()
}

#[test]
fn every_family_comes_back_from_gltf() {
    let folder = Folder::new();
    for (name, mesh) in meshes() {
        if name == "extremes" || name == "slivers" {
            continue;
        }
        let file = MeshFile::from(rounded_mesh(&mesh));
        for format in [GLTF, GLB] {
            let back = read_bytes(&folder.bytes(&file, format), format).expect(name);
            assert_eq!(back, file, "{name}, {format:?}");
        }
    }
    let path = folder.path("extremes.glb");
    let extremes = meshes().pop().expect("the last one").1.into();
    let refused = write(create(&path), &extremes).unwrap_err();
    assert!(refused.to_string().contains("beyond single precision") && !path.exists(), "{refused}");
}

#[test]
fn attributes_come_back_from_gltf() {
    let folder = Folder::new();
    for format in [GLTF, GLB] {
        let mut file = painted();
        file.uv.as_mut().unwrap().values = vec![[0.0, 0.25], [1.0, 0.5], [0.25, 1.0], [0.5, 0.75]];
        file.normals.as_mut().unwrap().values = vec![[0.0, 1.0, 0.0]; 4];
        assert_eq!(read_bytes(&folder.bytes(&file, format), format).unwrap(), file);
        // Not bytes.
        file.colors = Some(vec![[0.125, 0.5, 2.0, 1.0]; 4]);
        assert_eq!(read_bytes(&folder.bytes(&file, format), format).unwrap(), file);

        // Seams: copies are written, and joined again.
        let mut file = MeshFile::from(families::grid(2, 1).unwrap());
        let values = (0..7).map(|i| [f64::from(i) / 8.0, 0.25]).collect();
        let corners = vec![[0, 1, 2], [Attribute::<2>::ABSENT; 3], [2, 3, 4], [4, 5, 6]];
        file.uv = Some(Attribute { values, corners: Some(corners) });
        let normals = vec![[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]];
        let corners = Some(vec![[0; 3], [1; 3], [0; 3], [1; 3]]);
        file.normals = Some(Attribute { values: normals, corners });
        file.materials =
            Some(Labels { names: vec!["a".into(), "b".into()], of_faces: vec![1, 1, 0, 0] });
        let back = read_bytes(&folder.bytes(&file, format), format).unwrap();
        // Faces are by material and by what they have.
        let order = |mesh: &TriMesh, f: usize| {
            mesh.faces().iter().position(|face| *face == file.mesh.faces()[f]).unwrap()
        };
        assert_eq!(back.mesh.vertices(), file.mesh.vertices());
        for f in 0..4 {
            let at = order(&back.mesh, f);
            let both = [(&back, at), (&file, f)];
            let uv = both.map(|(file, f)| file.uv.as_ref().unwrap().of_face(&file.mesh, f));
            assert_eq!(uv[0], uv[1], "{f}");
            let normals =
                both.map(|(file, f)| file.normals.as_ref().unwrap().of_face(&file.mesh, f));
            assert_eq!(normals[0], normals[1], "{f}");
            let materials = both.map(|(file, f)| file.materials.as_ref().unwrap().of_face(f));
            assert_eq!(materials[0], materials[1], "{f}");
        }
        note(&back, "joined vertices");
    }
}

/// A glTF file of these numbers as its only buffer, in the JSON of a document that lacks it.
pub fn gltf(document: &str, bytes: &[u8]) -> Vec<u8> {
    let json = format!(
        "{{\"asset\": {{\"version\": \"2.0\"}}, \"buffers\": [{{\"byteLength\": {}}}], {document}}}",
        bytes.len()
    );
    let padded = |bytes: &[u8], with: u8| {
        let mut bytes = bytes.to_vec();
        bytes.resize(bytes.len().next_multiple_of(4), with);
        bytes
    };
    let (json, bytes) = (padded(json.as_bytes(), b' '), padded(bytes, 0));
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend((28 + json.len() as u32 + bytes.len() as u32).to_le_bytes());
    for (kind, content) in [(b"JSON", &json), (b"BIN\0", &bytes)] {
        file.extend((content.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(content);
    }
    file
}

/// The corners of a square as floats, then 0 1 2 2 1 3 as bytes.
pub fn square_bytes() -> Vec<u8> {
    let corners = [[0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let mut bytes: Vec<u8> = corners.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0, 1, 2, 2, 1, 3]);
    bytes
}

pub const SQUARE: &str = r#""bufferViews": [{"buffer": 0, "byteLength": 48},
    {"buffer": 0, "byteOffset": 48, "byteLength": 6}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 4},
    {"bufferView": 1, "componentType": 5121, "type": "SCALAR", "count": 6}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]"#;

#[test]
fn nodes_of_gltf_place_their_meshes() {
    let scene = r#", "scene": 0, "scenes": [{"nodes": [0, 3]}], "nodes": [
        {"children": [1, 2], "translation": [10, 0, 0]},
        {"mesh": 0, "scale": [2, 1, 1], "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476]},
        {"mesh": 0, "matrix": [-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,5,1]},
        {"translation": [0, 0, 0]}, {"mesh": 0}]"#;
    let bytes = gltf(&format!("{SQUARE}{scene}"), &square_bytes());
    let mesh = read_bytes(&bytes, GLB).unwrap().mesh;
    assert_eq!((mesh.vertices().len(), mesh.faces().len()), (8, 4));
    let near = |v: usize, expected: [f64; 3]| {
        let found = mesh.vertices()[v];
        (0..3).all(|k| (found[k] - expected[k]).abs() < 1e-12)
    };
    // Turned by a right angle after it is stretched.
    assert!(near(1, [10.0, 2.0, 0.0]) && near(2, [9.0, 0.0, 0.0]), "{:?}", mesh.vertices());
    assert!(near(5, [9.0, 0.0, 5.0]), "{:?}", mesh.vertices());
    // A mirror turns faces over, so both squares are still seen from above.
    assert!(mesh.face_normals().iter().all(|n| n[2] > 0.99));
    // Without a scene all meshes are there.
    assert_eq!(read_bytes(&gltf(SQUARE, &square_bytes()), GLB).unwrap().mesh.faces().len(), 2);
}

#[test]
fn gltf_is_read_in_its_many_dialects() {
    let square = [[0, 1, 2], [2, 1, 3]];
    // No numbers of vertices: the square as a strip, or half of it.
    let strip = SQUARE.replace("\"indices\": 1", "\"mode\": 5");
    assert_eq!(read_bytes(&gltf(&strip, &square_bytes()), GLB).unwrap().mesh.faces(), square);
    let five = SQUARE.replace("\"count\": 6", "\"count\": 5");
    let file = read_bytes(&gltf(&five, &square_bytes()), GLB).unwrap();
    assert_eq!(file.mesh.faces(), &square[..1]);
    note(&file, "left out corners behind the last triangle of a primitive: 2");
    let fan = SQUARE.replace("\"indices\": 1", "\"mode\": 6");
    let faces = read_bytes(&gltf(&fan, &square_bytes()), GLB).unwrap().mesh;
    assert_eq!(faces.faces(), [[0, 1, 2], [0, 2, 3]]);
    let lines = SQUARE.replace("\"indices\": 1", "\"mode\": 1");
    note(&read_bytes(&gltf(&lines, &square_bytes()), GLB).unwrap(), "left out primitives of lines");
    // Bytes that stand for fractions, apart by a stride; a sparse element.
    let mut bytes = vec![0u8; 16];
    bytes[4] = 255;
    bytes[9] = 51;
    bytes.extend([2, 0, 0, 0, 0, 0, 0, 0]);
    let document = r#""bufferViews": [{"buffer": 0, "byteLength": 16, "byteStride": 4},
        {"buffer": 0, "byteOffset": 16, "byteLength": 1},
        {"buffer": 0, "byteOffset": 17, "byteLength": 3}],
        "accessors": [{"bufferView": 0, "componentType": 5121, "type": "VEC3", "count": 3,
        "normalized": true, "sparse": {"count": 1, "indices": {"bufferView": 1,
        "componentType": 5121}, "values": {"bufferView": 2}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}]"#;
    let mesh = read_bytes(&gltf(document, &bytes), GLB).unwrap().mesh;
    assert_eq!(mesh.vertices()[..2], [[0.0; 3], [1.0, 0.0, 0.0]]);
    let unsparse = document.replace("\"sparse\"", "\"extras\"");
    let mesh = read_bytes(&gltf(&unsparse, &bytes), GLB).unwrap().mesh;
    assert_eq!(mesh.vertices()[2], [0.0, 0.2, 0.0]);
    // Numbers in a file beside it, and in the JSON.
    let folder = Folder::new();
    fs::write(folder.path("the numbers.bin"), square_bytes()).unwrap();
    let beside = format!(
        "{{\"asset\": {{\"version\": \"2.0\"}}, {SQUARE}, \"buffers\": [{{\"byteLength\": 54, \
         \"uri\": \"the%20numbers.bin\"}}]}}"
    );
    let path = folder.path("mesh.gltf");
    fs::write(&path, &beside).unwrap();
    assert_eq!(read(&path).unwrap().mesh.faces(), square);
    for (uri, said) in [
        ("/etc/passwd", "not the name of a file beside"),
        ("../mesh.gltf", "not the name of a file beside"),
        ("https://a.b/c", "not the name of a file beside"),
        ("none.bin", "none.bin: "),
        ("%2", "broken URI"),
        ("data:,abc", "not in base64"),
        ("data:;base64,ab!d", "broken base64"),
        ("data:;base64,abcd", "buffer 0: has 3 of 54 bytes"),
    ] {
        let text = beside.replace("the%20numbers.bin", uri);
        let refused = refusal(text.as_bytes(), GLTF).1;
        assert!(refused.contains(said), "{uri}: {refused}");
    }
}

#[test]
fn broken_gltf_names_what_is_broken() {
    let nodes = r#", "scenes": [{"nodes": [0]}], "nodes": [{"children": [0]}]"#;
    let huge =
        SQUARE.replace("\"bufferView\": 0, ", "").replace("\"count\": 4", "\"count\": 99999999999");
    let cases = [
        (
            SQUARE.replace("\"indices\": 1", "\"indices\": 2"),
            "mesh 0, primitive 0: accessor 2 is out of range: 2 accessors",
        ),
        (
            SQUARE.replace("\"byteLength\": 48", "\"byteLength\": 480"),
            "view 0 is beyond its buffer",
        ),
        (SQUARE.replace("\"count\": 4", "\"count\": 5"), "element 4 of 5 is beyond view 0"),
        (SQUARE.replace("\"count\": 4", "\"count\": 3"), "vertex 3 is out of range: 3"),
        (SQUARE.replace("VEC3", "MAT3"), "type \"MAT3\""),
        (SQUARE.replace("5126", "5124"), "component type 5124"),
        (SQUARE.replace("\"buffer\": 0", "\"buffer\": 7"), "beyond its buffer"),
        (format!("{SQUARE}{nodes}"), "node 0 has two parents"),
        (format!("{SQUARE}, \"scene\": 3"), "no scene 3"),
        (huge, "of memory"),
        (
            format!("{SQUARE}, \"extensionsRequired\": [\"KHR_meshopt_compression\"]"),
            "compressed by the extension KHR_meshopt",
        ),
    ];
    for (document, what) in cases {
        let (line, said) = refusal(&gltf(&document, &square_bytes()), GLB);
        assert!(line.is_none() && said.contains(what), "{said}: {document}");
    }
    let mut nan = square_bytes();
    nan[12..16].copy_from_slice(&f32::NAN.to_le_bytes());
    let said = refusal(&gltf(SQUARE, &nan), GLB).1;
    assert!(said.contains("primitive 0: vertex 1: position [NaN"), "{said}");
    for (text, line, what) in [
        ("{\n\"asset\": 3}", Some(2), "not the JSON of a glTF file"),
        ("{\"asset\": {\"version\": \"1.0\"}}", None, "version \"1.0\""),
        ("glTF\x01\0\0\0\0\0\0\0", None, "version 1 of binary"),
        ("glTF\x02\0\0\0\x0c\0\0\0", None, "without a chunk of JSON"),
    ] {
        let (found, said) = refusal(text.as_bytes(), GLTF);
        assert!(found == line && said.contains(what), "{text}: line {found:?}: {said}");
    }
}

/// Some files in every format.
fn samples() -> Vec<(&'static str, MeshFormat, Vec<u8>)> {
    let folder = Folder::new();
    let mut found = Vec::new();
    let files =
        [painted(), families::bow_tie().unwrap().into(), families::moebius(3, 1).unwrap().into()];
    for file in files {
        for format in [[OBJ, OFF, STL_TEXT, STL, GLTF, GLB].as_slice(), &PLY].concat() {
            found.push((extension(format), format, folder.bytes(&file, format)));
        }
    }
    found
}

#[test]
fn every_truncation_is_an_error_or_a_mesh() {
    for (name, format, bytes) in samples() {
        for cut in 0..bytes.len() {
            let read = read_bytes(&bytes[..cut], format);
            // Text may lose its last digit, or whole statements, and be a file still.
            let binary = [STL, PLY[1], PLY[2], GLB].contains(&format);
            assert!(!binary || read.is_err(), "{name}, {cut} of {} bytes", bytes.len());
        }
    }
}

#[test]
fn mutations_never_panic() {
    let mut rng = Rng::new(20);
    for (_, format, bytes) in samples() {
        for _ in 0..1500 {
            let mut mutant = bytes.clone();
            for _ in 0..1 + rng.bits() % 4 {
                let at = rng.bits() as usize % mutant.len();
                match rng.bits() % 4 {
                    0 => mutant[at] = rng.bits() as u8,
                    1 => mutant[at] ^= 1 << (rng.bits() % 8),
                    2 => drop(mutant.remove(at)),
                    _ => mutant.insert(at, b" \n0-9e/.\xff"[rng.bits() as usize % 9]),
                }
            }
            if let Ok(file) = read_bytes(&mutant, format) {
                drop(file.mesh.validate().to_string());
            }
        }
    }
}

#[test]
#[ignore = "writes fuzz/seeds, from which scripts/fuzz starts"]
fn seeds_for_fuzzing() -> Result<()> {
    let seeds = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds");
    for (i, (name, _, bytes)) in samples().into_iter().enumerate() {
        fs::create_dir_all(seeds.join(name)).expect("a folder");
        fs::write(seeds.join(name).join(format!("{i}.{name}")), bytes).expect("a seed");
    }
    Ok(())
}
