//! Files of simulation, imaging and printing: each encoding of VTK, GIFTI, FreeSurfer, Gmsh and 3MF
//! is read, broken files are refused, and what is written is read back.

use std::fs;
use std::io::Write;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use catamaran::Result;
use catamaran::io::SourceOptions;
use catamaran_geometry::decimate::{DecimateOptions, decimate};
use catamaran_geometry::mesh::io::{
    Attribute, MeshFile, MeshFormat, Scalars, VtkEncoding, read, read_bytes, write, write_bytes,
};
use catamaran_geometry::mesh::{Refined, TriMesh, families, io};
use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::mesh_files::{Folder, create};

const VTK: MeshFormat = MeshFormat::Vtk(VtkEncoding::Ascii);

const FACES: [[u32; 3]; 12] = [
    [0, 2, 1],
    [1, 2, 3],
    [4, 5, 6],
    [5, 7, 6],
    [0, 1, 4],
    [1, 5, 4],
    [2, 6, 3],
    [3, 6, 7],
    [0, 4, 2],
    [2, 4, 6],
    [1, 3, 5],
    [3, 7, 5],
];

/// The sides of the unit cube, outwards.
const SIDES: [[u32; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

fn corners() -> Vec<[f64; 3]> {
    (0..8u32).map(|v| [v & 1, (v >> 1) & 1, v >> 2].map(f64::from)).collect()
}

/// Returns numbers in words.
fn text<T: ToString>(numbers: impl IntoIterator<Item = T>) -> String {
    numbers.into_iter().map(|x| x.to_string()).collect::<Vec<_>>().join(" ")
}

fn positions() -> String {
    text(corners().into_flattened())
}

fn is_cube(bytes: &[u8], format: MeshFormat, what: &str) -> MeshFile {
    let file = read_bytes(bytes, format).unwrap_or_else(|e| panic!("{what}: {e}"));
    assert_eq!(file.mesh.faces().len(), 12, "{what}");
    let (area, volume) = (file.mesh.area(), file.mesh.volume().unwrap());
    assert!((area - 6.0).abs() < 1e-12 && (volume - 1.0).abs() < 1e-12, "{what}: {area}, {volume}");
    file
}

fn read_scalars(path: &Path) -> Result<Vec<Scalars>> {
    io::read_scalars(path, &SourceOptions::new())
}

fn refused(bytes: &[u8], format: MeshFormat) -> String {
    read_bytes(bytes, format).expect_err("refused").to_string()
}

/// Refuses every beginning of a file.
fn beginnings_are_refused(bytes: &[u8], end: usize, format: MeshFormat, what: &str) {
    for length in 1..end {
        assert!(read_bytes(&bytes[..length], format).is_err(), "{what}: {length} bytes");
    }
}

fn big<const N: usize, T>(numbers: impl IntoIterator<Item = T>, to: fn(T) -> [u8; N]) -> Vec<u8> {
    numbers.into_iter().flat_map(to).collect()
}

#[test]
fn legacy_vtk_is_read_in_each_form() {
    let head = |encoding: &str| format!("# vtk DataFile Version 3.0\na cube\n{encoding}\n");
    let points = format!("POINTS 8 double\n{}\n", positions());
    let sides: String = SIDES.iter().map(|side| format!("4 {}\n", text(side))).collect();
    let polygons = format!("DATASET POLYDATA\n{points}POLYGONS 6 30\n{sides}");
    let values = "POINT_DATA 8\nSCALARS heat float\nLOOKUP_TABLE default\n0 1 2 3 4 5 6 7\n\
                  COLOR_SCALARS rgb 3\n1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 0 .5 1\n\
                  FIELD FieldData 2\nwind%20speed 2 8 double\n0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 .5\n\
                  Normals 3 8 float\n0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1\n";
    let file = is_cube((head("ASCII") + &polygons + values).as_bytes(), VTK, "polygons");
    assert_eq!(file.colors.unwrap()[7], [0.0, 0.5, 1.0, 1.0]);
    assert_eq!(file.normals.unwrap().values[3], [0.0, 0.0, 1.0]);
    let names: Vec<&str> = file.scalars.iter().map(|scalars| &scalars.name[..]).collect();
    assert_eq!(names, ["heat", "wind speed.0", "wind speed.1"]);
    assert_eq!((file.scalars[0].values[6], file.scalars[2].values[7]), (6.0, 0.5));
    assert!(file.notes.is_empty(), "{:?}", file.notes);

    // A pixel, quadrilaterals, a quadratic triangle, and cells that are not faces; in offsets, too.
    let cells = "CELLS 9 41\n4 0 2 1 3\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n\
                 6 1 3 7 0 0 0\n3 1 7 5\n1 0\n2 0 1\n";
    let kinds = "CELL_TYPES 9\n8 9 9 9 9 22 5 1 3\n";
    let grid = format!("{}DATASET UNSTRUCTURED_GRID\n{points}{cells}{kinds}", head("ASCII"));
    let file = is_cube(grid.as_bytes(), VTK, "grid");
    assert!(file.notes[0].starts_with("took faces with vertices"), "{:?}", file.notes);
    assert!(file.notes[1].contains("not faces: 2, the first at cell 7"), "{:?}", file.notes);
    let offsets = format!(
        "{}DATASET POLYDATA\n{points}POLYGONS 7 24\nOFFSETS vtktypeint64\n0 4 8 12 16 20 24\n\
         CONNECTIVITY vtktypeint64\n{}\nMETADATA\nINFORMATION 0\n\n",
        head("ASCII"),
        text(SIDES.as_flattened())
    );
    is_cube(offsets.as_bytes(), VTK, "offsets");
    is_cube(format!("\u{feff}{offsets}").as_bytes(), VTK, "a byte order mark");

    let mut binary = (head("BINARY") + "DATASET POLYDATA\nPOINTS 8 double\n").into_bytes();
    binary.extend(big(corners().into_flattened(), f64::to_be_bytes));
    binary.extend(b"\nPOLYGONS 7 24\nOFFSETS vtktypeint64\n");
    binary.extend(big((0..7i64).map(|i| 4 * i), i64::to_be_bytes));
    binary.extend(b"\nCONNECTIVITY vtktypeint64\n");
    binary.extend(big(SIDES.into_iter().flatten().map(i64::from), i64::to_be_bytes));
    is_cube(&binary, VTK, "binary offsets");

    // Texts before the points.
    let texts = "DATASET POLYDATA\nFIELD FieldData 1\nnames 1 2 string\n";
    let named = format!("{}{texts}a b\n\n{points}POLYGONS 6 30\n{sides}", head("ASCII"));
    is_cube(named.as_bytes(), VTK, "texts");
    let mut named = (head("BINARY") + texts).into_bytes();
    named.extend([0xc1, b'a', 0x80, 0x02, b'b', b'c']);
    named.extend(b"\nPOINTS 0 float\n\n");
    assert!(read_bytes(&named, VTK).unwrap().notes.is_empty());

    let mut binary = (head("BINARY") + "DATASET POLYDATA\nPOINTS 8 float\n").into_bytes();
    binary.extend(big(corners().into_flattened(), |x| (x as f32).to_be_bytes()));
    binary.extend(b"\nPOLYGONS 6 30\n");
    binary.extend(big(SIDES.iter().flat_map(|&[a, b, c, d]| [4, a, b, c, d]), u32::to_be_bytes));
    let end = binary.len();
    binary.extend(b"\nPOINT_DATA 8\nCOLOR_SCALARS rgb 3\n");
    binary.extend([51; 24]);
    binary.extend(b"\nSCALARS n short 1\nLOOKUP_TABLE default\n");
    binary.extend(big(0..8i16, i16::to_be_bytes));
    let file = is_cube(&binary, VTK, "binary");
    assert_eq!(file.colors.unwrap()[5], [0.2, 0.2, 0.2, 1.0]);
    assert_eq!(file.scalars[0].values[5], 5.0);
    // Before the points there is a mesh without any.
    let points = head("BINARY").len() + "DATASET POLYDATA\n".len();
    assert!(read_bytes(&binary[..points], VTK).is_ok());
    for length in points + 1..end {
        if let Ok(cut) = read_bytes(&binary[..length], VTK) {
            assert!(cut.mesh.faces().is_empty(), "{length}");
        }
    }
}

#[test]
fn triangle_strips_of_vtk_alternate() {
    let text = "# vtk DataFile Version 2.0\n\nascii\nDATASET POLYDATA\nPOINTS 4 float\n\
                0 0 0 1 0 0 0 1 0 1 1 0\nTRIANGLE_STRIPS 1 5\n4 0 1 2 3\nLINES 1 3\n2 0 1\n";
    let file = read_bytes(text.as_bytes(), VTK).unwrap();
    assert_eq!(file.mesh.faces(), [[0, 1, 2], [2, 1, 3]]);
}

#[test]
fn grids_of_vtk_with_one_side_of_one_point_are_surfaces() {
    let grid = |sides: &str, points: &str| {
        let head = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_GRID\nDIMENSIONS";
        format!("{head} {sides}\nPOINTS 6 float\n{points}\n").into_bytes()
    };
    let points = "0 0 0 1 0 0 2 0 1 0 1 0 1 1 0 2 1 1";
    let values = format!(
        "{points}\nPOINT_DATA 6\nSCALARS h float\nLOOKUP_TABLE default\n{}",
        "1 2 ".repeat(3)
    );
    for sides in ["3 2 1", "3 1 2", "1 3 2"] {
        let file = read_bytes(&grid(sides, &values), VTK).unwrap();
        let faces = [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]];
        assert_eq!((file.mesh.vertices().len(), file.mesh.faces()), (6, &faces[..]), "{sides}");
        assert_eq!(file.scalars[0].values, [1.0, 2.0, 1.0, 2.0, 1.0, 2.0]);
    }
    for (sides, what) in [
        ("6 1 1", "a structured grid of volumes or lines is not a surface"),
        ("3 3 1", "6 points of a grid of 3 x 3 x 1"),
        ("3 9999999999 9999999999", "6 points of a grid of 3 x 9999999999"),
    ] {
        let said = refused(&grid(sides, points), VTK);
        assert!(said.contains(what), "{said}");
    }
    let lacks = String::from_utf8(grid("", points)).unwrap().replace("DIMENSIONS \n", "");
    assert!(refused(lacks.as_bytes(), VTK).contains("lacks its DIMENSIONS"));
}

#[test]
fn errors_in_vtk_name_the_line_and_the_culprit() {
    let head = "# vtk DataFile Version 3.0\n\nASCII\n";
    let points = "DATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n";
    let wide = format!("{points}POINT_DATA 3\nSCALARS s float 5000\n{}", "0 ".repeat(15_000));
    let twice = format!("{points}POINTS 1 float\n9 9 9\n");
    let lists = |text: &str| format!("{points}POLYGONS {text}\n");
    let offsets = |text: &str| {
        let vertices = "CONNECTIVITY vtktypeint64\n0 1 2 0 1 2";
        format!("{points}POLYGONS 2 6\nOFFSETS vtktypeint64\n{text}\n{vertices}\n")
    };
    for (rest, what) in [
        (&wide[..], "array \"s\" has 5000 values for each vertex"),
        (&lists("1 8\n3 0 1 2 3 0 1 2")[..], "4 numbers come after those of the 1 cells"),
        (&offsets("0 3")[..], "3 vertices come after those of the last cell"),
        (&offsets("3 6")[..], "the first of the offsets of cells is not 0"),
        ("DATASET STRUCTURED_POINTS\n", "mesh.vtk:4: a dataset \"STRUCTURED_POINTS\" is not a"),
        ("DATASET POLYDATA\nPOINTS 2 float\n0 0 0\n1 x 0\n", "mesh.vtk:7: \"x\" is not a number"),
        ("DATASET POLYDATA\nPOINTS 9999999999 float\n0 0 0\n", "truncated: the file ends before"),
        ("DATASET POLYDATA\nPOINTS 1 thing\n", "unknown type \"thing\""),
        ("DATASET POLYDATA\nPOINTS 1 float\n0 0 0\nPOLYGONS 1 4\n3 0 1 2\n", "vertex 1 is out"),
        ("DATASET POLYDATA\nPOINTS 1 float\n0 0 0\nPOLYGONS 1 4\n5 0 0 0\n", "cell 0 of 1"),
        ("DATASET UNSTRUCTURED_GRID\nCELLS 1 2\n1 0\n", "CELLS without CELL_TYPES"),
        // Vertices and cells of a second dataset.
        (&twice[..], "\"POINTS 1 float\" is out of place"),
        ("DATASET UNSTRUCTURED_GRID\nCELLS 1 2\n1 0\nCELLS 1 2\n1 0\n", "\"CELLS 1 2\" is out"),
        ("POINTS\n", "mesh.vtk:4: \"POINTS\" lacks a word"),
        ("NONSENSE 1\n", "\"NONSENSE 1\" is out of place"),
    ] {
        let found = refused((head.to_owned() + rest).as_bytes(), VTK);
        assert!(found.contains(what), "{rest}: {found}");
    }
}

/// Returns the parts of a VTK file in XML: its header's attributes, arrays, and appended data.
fn vtp(encoding: &str, packed: bool, wide: bool) -> Vec<u8> {
    let points = big(corners().into_flattened(), f64::to_le_bytes);
    let connectivity = big(SIDES.into_iter().flatten(), |v| i64::from(v).to_le_bytes());
    let offsets = big((1..7).map(|i| 4 * i), i32::to_le_bytes);
    let heat = big((0..8u8).map(|v| 2 * v), |x| [x]);
    let word = |n: usize| match wide {
        true => (n as u64).to_le_bytes().to_vec(),
        false => (n as u32).to_le_bytes().to_vec(),
    };
    // Blocks of 50 bytes.
    let block = |bytes: &[u8]| {
        let mut packer = ZlibEncoder::new(Vec::new(), Compression::default());
        packer.write_all(bytes).unwrap();
        packer.finish().unwrap()
    };
    let stored = |bytes: &[u8]| -> [Vec<u8>; 2] {
        if !packed {
            return [[word(bytes.len()), bytes.to_vec()].concat(), vec![]];
        }
        let blocks: Vec<Vec<u8>> = bytes.chunks(50).map(block).collect();
        let sizes: Vec<u8> = blocks.iter().flat_map(|block| word(block.len())).collect();
        let head = [word(blocks.len()), word(50), word(bytes.len() % 50), sizes].concat();
        [head, blocks.concat()]
    };
    let mut appended: Vec<u8> = Vec::new();
    let mut array = |name: &str, kind: &str, width: usize, bytes: &[u8], numbers: String| {
        let start = format!(
            "<DataArray Name=\"{name}\" type=\"{kind}\" NumberOfComponents=\"{width}\" format="
        );
        let own = stored(bytes);
        let base64 = own.clone().map(|part| STANDARD.encode(part)).concat();
        match encoding {
            "ascii" => format!("{start}\"ascii\">{numbers}<X/></DataArray>"),
            "binary" => format!("{start}\"binary\">\n  {base64}\n</DataArray>"),
            _ => {
                let offset = appended.len();
                appended.extend(if encoding == "raw" { own.concat() } else { base64.into_bytes() });
                format!("{start}\"appended\" offset=\"{offset}\"/>")
            }
        }
    };
    let points = array("Points", "Float64", 3, &points, positions());
    let connectivity = array("connectivity", "Int64", 1, &connectivity, text(SIDES.as_flattened()));
    let offsets = array("offsets", "Int32", 1, &offsets, "4 8 12 16 20 24".into());
    let heat = array("heat", "UInt8", 1, &heat, "0 2 4 6 8 10 12 14".into());
    let compressor = if packed { " compressor=\"vtkZLibDataCompressor\"" } else { "" };
    let header = if wide { " header_type=\"UInt64\"" } else { "" };
    let body = format!(
        "<?xml version=\"1.0\"?>\n<!-- a cube -->\n<VTKFile type=\"PolyData\" version=\"1.0\" \
         byte_order=\"LittleEndian\"{header}{compressor}>\n<PolyData>\n\
         <FieldData><DataArray Name=\"t\" type=\"Int8\">1</DataArray></FieldData>\n\
         <Piece NumberOfPoints=\"8\" NumberOfPolys=\"6\">\n<PointData Scalars=\"heat\">{heat}\
         </PointData>\n<Points>{points}</Points>\n<Polys>{connectivity}{offsets}</Polys>\n\
         </Piece>\n</PolyData>\n"
    );
    let mut bytes = body.into_bytes();
    if matches!(encoding, "raw" | "base64") {
        bytes.extend(format!("<AppendedData encoding=\"{encoding}\">\n  _").into_bytes());
        bytes.extend(appended);
        bytes.extend(b"\n</AppendedData>\n");
    }
    bytes.extend(b"</VTKFile>\n");
    bytes
}

#[test]
fn vtk_in_xml_is_read_in_each_encoding() {
    for encoding in ["ascii", "binary", "raw", "base64"] {
        for (packed, wide) in [(false, false), (false, true), (true, false), (true, true)] {
            let what = format!("{encoding}, {packed}, {wide}");
            let bytes = vtp(encoding, packed, wide);
            let file = is_cube(&bytes, MeshFormat::VtkXml, &what);
            let heat: Vec<f64> = (0..8).map(|v| f64::from(2 * v)).collect();
            assert_eq!(file.scalars, [Scalars { name: "heat".into(), values: heat }], "{what}");
            let end = bytes.len() - 40;
            beginnings_are_refused(&bytes, end.min(700), MeshFormat::VtkXml, &what);
        }
    }
    let grid = String::from_utf8(vtp("ascii", false, false)).unwrap();
    let grid = grid.replace("PolyData", "UnstructuredGrid").replace("Polys>", "Cells>");
    let kinds = "<DataArray Name=\"types\" type=\"UInt8\">9 9 9 9 9 9</DataArray></Cells>";
    let grid = grid.replace("</Cells>", kinds);
    is_cube(grid.as_bytes(), MeshFormat::VtkXml, "grid");
    // The vertices of the second piece count from its own first one.
    let text = String::from_utf8(vtp("ascii", false, false)).unwrap();
    let (start, end) = (text.find("<Piece").unwrap(), text.find("</PolyData>").unwrap());
    let twice = [&text[..end], &text[start..end], &text[end..]].concat();
    let file = read_bytes(twice.as_bytes(), MeshFormat::VtkXml).unwrap();
    assert!((file.mesh.volume().unwrap() - 2.0).abs() < 1e-12);
    assert_eq!(file.scalars[0].values[15], 14.0);
    // An array of one of the pieces lacks values of vertices.
    let other = text[start..end].replace("heat", "cold");
    let twice = [&text[..end], &other, &text[end..]].concat();
    let file = read_bytes(twice.as_bytes(), MeshFormat::VtkXml).unwrap();
    assert!(file.scalars.is_empty());
    assert!(file.notes[0].contains("without a value for each vertex: 2"), "{:?}", file.notes);
    // A first piece without vertices, and so without values.
    let empty = "<Piece><Points><DataArray type=\"Int8\"></DataArray></Points></Piece>";
    let after = [&text[..start], empty, &text[start..]].concat();
    let file = is_cube(after.as_bytes(), MeshFormat::VtkXml, "after an empty piece");
    assert_eq!(file.scalars[0].values[7], 14.0);
    for (from, to, what) in [
        ("\"PolyData\"", "\"ImageData\"", "VTKFile of type \"ImageData\" is not a surface"),
        ("</Points>", "</Point>", "mesh.vtp:8: </Point> where <Points> is open"),
        ("4 8 12", "4 8 99", "cell 2 has vertices 8 to 99 of 24"),
        ("20 24<X/>", "20<X/>", "4 vertices come after those of the last cell"),
        ("\"offsets\"", "\"ends\"", "<Polys> lacks connectivity or offsets"),
        ("1 1 1<X/>", "1 1<X/>", "23 coordinates of points, not three for each"),
        ("0 2 4 6", "0 2 <!-- --> 4 6", "array \"heat\" is in several pieces"),
        ("Components=\"3\"", "Components=\"2\"", "points of 2 coordinates"),
    ] {
        let found = refused(text.replace(from, to).as_bytes(), MeshFormat::VtkXml);
        assert!(found.contains(what), "{to}: {found}");
    }
}

#[test]
fn vtk_in_xml_has_its_byte_order_and_may_have_headers_with_a_padding() {
    let array = |name: &str, kind: &str, bytes: Vec<u8>| {
        let head = STANDARD.encode((bytes.len() as u32).to_be_bytes());
        let start = format!("<DataArray Name=\"{name}\" type=\"{kind}\" format=\"binary\">");
        format!("{start}{head}{}</DataArray>", STANDARD.encode(bytes))
    };
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0f64]];
    let points = array("P", "Float64", big(positions.into_iter().flatten(), f64::to_be_bytes));
    let corners = array("connectivity", "Int32", big([2, 0, 1], i32::to_be_bytes));
    let ends = array("offsets", "Int16", big([3], i16::to_be_bytes));
    let text = format!(
        "<VTKFile type=\"PolyData\" byte_order=\"BigEndian\"><Piece><Points>{points}</Points>\
         <Polys>{corners}{ends}</Polys></Piece></VTKFile>"
    );
    let file = read_bytes(text.as_bytes(), MeshFormat::VtkXml).unwrap();
    assert_eq!((file.mesh.vertices(), file.mesh.faces()), (&positions[..], &[[2, 0, 1]][..]));
}

#[test]
fn vtk_in_xml_may_be_packed_by_lz4_and_lzma_and_text_by_anything() {
    /// The positions in single precision, as LZ4 packs them.
    const BLOCK: [u8; 17] = [25, 0, 1, 0, 41, 128, 63, 15, 0, 112, 0, 0, 64, 0, 0, 0, 0];
    /// The same by Python's lzma, with the check that VTK writes.
    const XZ: [u8; 72] = [
        0xfd, 0x37, 0x7a, 0x58, 0x5a, 0x00, 0x00, 0x01, 0x69, 0x22, 0xde, 0x36, 0x02, 0x00, 0x21,
        0x01, 0x16, 0x00, 0x00, 0x00, 0x74, 0x2f, 0xe5, 0xa3, 0xe0, 0x00, 0x23, 0x00, 0x0d, 0x5d,
        0x00, 0x00, 0x6c, 0xce, 0x50, 0xaf, 0xf7, 0x01, 0xe7, 0x91, 0xb7, 0xfc, 0x00, 0x00, 0x00,
        0x00, 0x00, 0x00, 0x49, 0x13, 0x91, 0xed, 0x00, 0x01, 0x25, 0x24, 0x1d, 0x81, 0x76, 0xf4,
        0x90, 0x42, 0x99, 0x0d, 0x01, 0x00, 0x00, 0x00, 0x00, 0x01, 0x59, 0x5a,
    ];
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
    let points = |encoding: &str, numbers: &str| {
        format!(
            "<DataArray Name=\"P\" type=\"Float32\" NumberOfComponents=\"3\" \
             format=\"{encoding}\">{numbers}</DataArray>"
        )
    };
    let by = |block: &[u8], size: u32| {
        // One block, of this size, which is whole.
        let head = [1, size, 0, block.len() as u32].map(u32::to_le_bytes).concat();
        points("binary", &[STANDARD.encode(head), STANDARD.encode(block)].concat())
    };
    let packed = |size: u32| by(&BLOCK, size);
    let file = |compressor: &str, points: String| {
        format!(
            "<VTKFile type=\"PolyData\" compressor=\"vtk{compressor}DataCompressor\"><Piece>\
             <Points>{points}</Points><Polys>\
             <DataArray Name=\"connectivity\" type=\"Int8\">0 1 2</DataArray>\
             <DataArray Name=\"offsets\" type=\"Int8\">3</DataArray></Polys></Piece></VTKFile>"
        )
    };
    let text = || points("ascii", "0 0 0 1 0 0 0 2 0");
    // Text is not packed, whatever the header names.
    for text in [
        file("LZ4", packed(36)),
        file("LZ4", text()),
        file("LZMA", by(&XZ, 36)),
        file("LZMA", text()),
    ] {
        let mesh = read_bytes(text.as_bytes(), MeshFormat::VtkXml).unwrap().mesh;
        assert_eq!((mesh.vertices(), mesh.faces()), (&positions[..], &[[0, 1, 2]][..]));
    }
    for (text, what) in [
        (file("LZMA", packed(36)), "can't be unpacked"),
        (
            file("Brotli", packed(36)),
            "packed by vtkBrotliDataCompressor, where zlib, LZ4 and LZMA are read",
        ),
        (file("LZMA", by(&XZ, 35)), "unpacks to more than 35 bytes"),
        (file("LZMA", by(&XZ, 40)), "unpacks to 36 of 40 bytes"),
        (file("LZMA", by(&XZ[..60], 36)), "can't be unpacked"),
        (file("LZ4", packed(35)), "can't be unpacked"),
        (file("LZ4", packed(40)), "unpacks to 36 of 40 bytes"),
        (file("LZ4", packed(1 << 20)), "do not unpack to 1048576"),
    ] {
        let said = refused(text.as_bytes(), MeshFormat::VtkXml);
        assert!(said.contains(what), "{said}");
    }
}

#[test]
fn what_headers_of_xml_announce_takes_no_memory() {
    let text = "<VTKFile type=\"PolyData\" header_type=\"UInt64\" \
                compressor=\"vtkZLibDataCompressor\"><Piece><Points><DataArray Name=\"P\" \
                type=\"Float32\" format=\"binary\">DATA</DataArray></Points></Piece></VTKFile>";
    for words in [[1 << 50, 1, 1, 1], [1, 1 << 50, 1 << 50, 1], [1, 8, 8, 1 << 40]] {
        let mut bytes = words.map(|word: u64| word.to_le_bytes()).concat();
        bytes.push(0);
        let file = text.replace("DATA", &STANDARD.encode(bytes));
        let found = refused(file.as_bytes(), MeshFormat::VtkXml);
        assert!(found.contains("truncated") || found.contains("memory"), "{found}");
    }
}

#[test]
fn gifti_is_read_in_each_encoding() {
    let points: Vec<f32> = corners().into_flattened().into_iter().map(|x| x as f32).collect();
    let by_columns = |i: usize| points[3 * (i % 8) + i / 8];
    for encoding in ["ASCII", "Base64Binary", "GZipBase64Binary"] {
        for (endian, order) in
            [("Little", "RowMajor"), ("Big", "RowMajor"), ("Little", "ColumnMajor")]
        {
            let is_big = endian == "Big";
            let ordered: Vec<f32> = match order {
                "RowMajor" => points.clone(),
                _ => (0..24).map(by_columns).collect(),
            };
            let data = |bytes: Vec<u8>, numbers: String| match encoding {
                "ASCII" => numbers,
                "Base64Binary" => STANDARD.encode(bytes),
                _ => {
                    let mut packer = ZlibEncoder::new(Vec::new(), Compression::default());
                    packer.write_all(&bytes).unwrap();
                    STANDARD.encode(packer.finish().unwrap())
                }
            };
            let array = |intent: &str, kind: &str, shape: &str, order: &str, data: String| {
                format!(
                    "<DataArray Intent=\"NIFTI_INTENT_{intent}\" DataType=\"NIFTI_TYPE_{kind}\" \
                     {shape} Encoding=\"{encoding}\" Endian=\"{endian}Endian\" \
                     ArrayIndexingOrder=\"{order}Order\"><MetaData><MD><Name>Name</Name>\
                     <Value><![CDATA[of & {intent}]]></Value></MD></MetaData>\
                     <Data>{data}</Data></DataArray>\n"
                )
            };
            let float = if is_big { f32::to_be_bytes } else { f32::to_le_bytes };
            let int = if is_big { u32::to_be_bytes } else { u32::to_le_bytes };
            let table = |rows: usize| format!("Dimensionality=\"2\" Dim0=\"{rows}\" Dim1=\"3\"");
            let faces = || FACES.into_iter().flatten();
            let thickness = [0.5f32, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0];
            let body = [
                array(
                    "POINTSET",
                    "FLOAT32",
                    &table(8),
                    order,
                    data(big(ordered.clone(), float), text(ordered)),
                ),
                array(
                    "TRIANGLE",
                    "INT32",
                    &table(12),
                    "RowMajor",
                    data(big(faces(), int), text(faces())),
                ),
                array(
                    "SHAPE",
                    "FLOAT32",
                    "Dimensionality=\"1\" Dim0=\"8\"",
                    "RowMajor",
                    data(big(thickness, float), text(thickness)),
                ),
            ];
            let gifti = |body: String| format!("<?xml version=\"1.0\"?><GIFTI>\n{body}</GIFTI>");
            let what = format!("{encoding}, {endian}, {order}");
            let bytes = gifti(body.concat()).into_bytes();
            let file = is_cube(&bytes, MeshFormat::Gifti, &what);
            assert_eq!(file.scalars[0].name, "of & SHAPE");
            assert_eq!(file.scalars[0].values, thickness.map(f64::from), "{what}");
            beginnings_are_refused(&bytes, bytes.len(), MeshFormat::Gifti, &what);
            let own = String::from_utf8(bytes).unwrap();
            let names = [
                ("\"ASCII\"", "\"GIFTI_ENCODING_ASCII\""),
                ("\"Base64Binary\"", "\"GIFTI_ENCODING_B64BIN\""),
                ("\"GZipBase64Binary\"", "\"GIFTI_ENCODING_B64GZ\""),
                ("BigEndian", "GIFTI_ENDIAN_BIG"),
                ("ColumnMajorOrder", "GIFTI_IND_ORD_COL_MAJOR"),
            ];
            let of_c = names.iter().fold(own, |text, (ours, of_c)| text.replace(ours, of_c));
            is_cube(of_c.as_bytes(), MeshFormat::Gifti, &what);
            // Values without a surface.
            let values = gifti(body[2].clone());
            let found = refused(values.as_bytes(), MeshFormat::Gifti);
            assert!(found.contains("no surface"), "{found}");
            let folder = Folder::new();
            let path = folder.path("a.shape.gii");
            fs::write(&path, values).unwrap();
            assert_eq!(read_scalars(&path).unwrap(), file.scalars);
        }
    }
}

#[test]
fn names_and_matrices_of_gifti_are_noticed() {
    let array = |intent: &str, shape: &str, inside: &str, data: &str| {
        format!(
            "<DataArray Intent=\"NIFTI_INTENT_{intent}\" DataType=\"NIFTI_TYPE_FLOAT32\" {shape} \
             ArrayIndexingOrder=\"ColumnMajorOrder\" Encoding=\"ASCII\">{inside}\
             <Data>{data}</Data></DataArray>"
        )
    };
    let name = "<MetaData><MD><Name>\nName\n</Name><Value>\n<![CDATA[depth]]>\n</Value></MD>\
                </MetaData>";
    let values = array("SHAPE", "Dimensionality=\"1\" Dim0=\"3\"", name, "4 5 6");
    let whole = |x: u32, more: &str| {
        let matrix = format!("<MatrixData>1 0 0 {x} 0 1 0 0 0 0 1 0 0 0 0 1</MatrixData>");
        let shape = "Dimensionality=\"2\" Dim0=\"3\" Dim1=\"3\"";
        let points = array("POINTSET", shape, &matrix, "0 1 0 0 0 1 0 0 0");
        format!("<GIFTI>{points}{values}{more}</GIFTI>")
    };
    for (x, notes) in [(0, 0), (2, 1)] {
        let file = read_bytes(whole(x, "").as_bytes(), MeshFormat::Gifti).unwrap();
        assert_eq!((&file.scalars[0].name[..], file.notes.len()), ("depth", notes));
        assert_eq!(file.mesh.vertices()[1], [1.0, 0.0, 0.0]);
    }
    // Triangles of a second surface would connect the points of the first.
    let table = |rows: usize| format!("Dimensionality=\"2\" Dim0=\"{rows}\" Dim1=\"3\"");
    let surface = [
        array("TRIANGLE", &table(1), "", "0 1 2"),
        array("POINTSET", &table(3), "", "0 0 0 0 0 9 0 9 0"),
        array("TRIANGLE", &table(1), "", "0 2 1"),
    ];
    let file = read_bytes(whole(0, &surface.concat()).as_bytes(), MeshFormat::Gifti).unwrap();
    assert_eq!((file.mesh.vertices().len(), file.mesh.faces()), (3, &[[0, 1, 2]][..]));
    assert!(file.notes[0].contains("of further surfaces, or not of three numbers each: 2"));
    // nibabel writes text row by row, whatever the order that it states; lines tell that.
    let read = |points: &str, triangles: &str| {
        let points = array("POINTSET", &table(4), "", points);
        let triangles = array("TRIANGLE", &table(2), "", triangles);
        let text = format!("<GIFTI>{points}{triangles}</GIFTI>");
        read_bytes(text.as_bytes(), MeshFormat::Gifti).unwrap()
    };
    let by_rows = read("0 0 0\n1 0 0\n0 2 0\n0 0 3\n", "\n0 1 2\n0 2 3\n");
    let said = "took numbers of text row by row, as its lines have them, although the file says \
                ColumnMajorOrder: 2, the first at NIFTI_INTENT_POINTSET";
    assert_eq!(by_rows.notes, [said]);
    let by_columns = read("0 1 0 0\n0 0 2 0\n0 0 0 3", "0 0 1 2 2 3");
    assert!(by_columns.notes.is_empty());
    assert_eq!(by_rows.mesh, by_columns.mesh);
    let corners = (by_rows.mesh.vertices()[3], by_rows.mesh.faces());
    assert_eq!(corners, ([0.0, 0.0, 3.0], &[[0, 1, 2], [0, 2, 3]][..]));
    let deep = "Dimensionality=\"3\" Dim0=\"3\" Dim1=\"1\" Dim2=\"1\"";
    let wide = "Dimensionality=\"2\" Dim0=\"1\" Dim1=\"5000\"";
    for (shape, count, what) in [(deep, 3, "more than two dimensions"), (wide, 5000, "5000 values")]
    {
        let more = array("SHAPE", shape, "", &"0 ".repeat(count));
        let found = refused(whole(0, &more).as_bytes(), MeshFormat::Gifti);
        assert!(found.contains(what), "{found}");
    }
}

#[test]
fn surfaces_of_freesurfer_are_read_and_old_ones_of_quadrilaterals() {
    let mut bytes = b"\xff\xff\xfecreated by a test\n\n\0\0\0\x08\0\0\0\x0c".to_vec();
    bytes.extend(big(corners().into_flattened(), |x| (x as f32).to_be_bytes()));
    bytes.extend(big(FACES.into_iter().flatten(), u32::to_be_bytes));
    let end = bytes.len();
    bytes.extend(b"\0\0\0\x02valid");
    let file = is_cube(&bytes, MeshFormat::FreeSurfer, "triangles");
    assert_eq!(file.mesh.faces(), FACES);
    beginnings_are_refused(&bytes, end, MeshFormat::FreeSurfer, "triangles");

    let quads: Vec<u8> = SIDES.iter().flatten().flat_map(|&v| [0, 0, v as u8]).collect();
    let head = |magic: u8| vec![0xff, 0xff, magic, 0, 0, 8, 0, 0, 6];
    let floats = big(corners().into_flattened(), |x| (x as f32).to_be_bytes());
    let hundredths = big(corners().into_flattened(), |x| ((100.0 * x) as i16).to_be_bytes());
    // The number that decides is near 2.6 for vertices 0 and 2, and near 1.9 for 0 and 1.
    let (odd, even) = ([[0, 2, 3], [0, 3, 1]], [[0, 1, 4], [5, 4, 1]]);
    for (magic, points) in [(0xfd, floats), (0xff, hundredths)] {
        let bytes = [head(magic), points, quads.clone()].concat();
        let file = is_cube(&bytes, MeshFormat::FreeSurfer, "quadrilaterals");
        let faces = file.mesh.faces();
        assert_eq!((&faces[..2], &faces[4..6]), (&odd[..], &even[..]));
        beginnings_are_refused(&bytes, bytes.len(), MeshFormat::FreeSurfer, "quadrilaterals");
    }
    // Content decides: the name says nothing.
    let folder = Folder::new();
    let path = folder.path("lh.smoothwm");
    fs::write(&path, &bytes).unwrap();
    assert_eq!(read(&path).unwrap().mesh, file.mesh);
}

#[test]
fn surfaces_of_freesurfer_are_read_as_text() {
    let rows = |rows: Vec<String>| rows.into_iter().map(|row| row + "  0\n").collect::<String>();
    let points = rows(corners().into_iter().map(text).collect());
    let whole =
        format!("#!ascii version of lh.white\n8 12\n{points}{}", rows(FACES.map(text).into()));
    let file = is_cube(whole.as_bytes(), MeshFormat::FreeSurfer, "text");
    assert_eq!((file.mesh.faces(), file.notes.len()), (&FACES[..], 0));
    beginnings_are_refused(whole.as_bytes(), whole.len() - 2, MeshFormat::FreeSurfer, "text");
    // Content decides, and the surface has no values.
    let folder = Folder::new();
    let path = folder.path("lh.white.asc");
    fs::write(&path, &whole).unwrap();
    assert_eq!(read(&path).unwrap().mesh, file.mesh);
    assert!(read_scalars(&path).unwrap_err().to_string().contains("is a surface, without values"));
    let marked = whole.replacen("1  0\n", "1  1\n", 1);
    let notes = is_cube(marked.as_bytes(), MeshFormat::FreeSurfer, "marked").notes;
    assert_eq!(notes, ["took vertices and faces that the file marks as cut away: 1"]);
}

#[test]
fn numbers_of_gifti_may_be_in_a_file_beside_it() {
    let array = |intent: &str, kind: &str, rows: usize, file: &str, start: &str| {
        format!(
            "<DataArray Intent=\"NIFTI_INTENT_{intent}\" DataType=\"NIFTI_TYPE_{kind}\" \
             Dimensionality=\"2\" Dim0=\"{rows}\" Dim1=\"3\" Encoding=\"ExternalFileBinary\" \
             Endian=\"BigEndian\" ExternalFileName=\"{file}\" ExternalFileOffset=\"{start}\">\
             <Data></Data></DataArray>"
        )
    };
    let folder = Folder::new();
    let points = big(corners().into_flattened(), f64::to_be_bytes);
    let triangles = big(FACES.into_iter().flatten(), u32::to_be_bytes);
    fs::write(folder.path("a b.dat"), [points, triangles].concat()).unwrap();
    let path = folder.path("a.gii");
    let found = |start: &str, file: &str| {
        let points = array("POINTSET", "FLOAT64", 8, "a b.dat", "");
        let triangles = array("TRIANGLE", "INT32", 12, file, start);
        fs::write(&path, format!("<GIFTI>{points}{triangles}</GIFTI>")).unwrap();
        read(&path)
    };
    let mesh = found("192", "a b.dat").unwrap().mesh;
    assert_eq!((mesh.vertices(), mesh.faces()), (&corners()[..], &FACES[..]));
    for (start, file, what) in [
        ("196", "a b.dat", "data array 1: has 35 of 36 numbers"),
        ("192", "../a b.dat", "is not the name of a file beside this one"),
        ("192", "none.dat", "none.dat: "),
        ("192", "", "is not the name of a file beside this one"),
    ] {
        let said = found(start, file).unwrap_err().to_string();
        assert!(said.contains(what), "{said}");
    }
}

#[test]
fn files_of_volumes_alone_are_refused_by_name() {
    let vtk = "# vtk DataFile Version 3.0\na tetrahedron\nASCII\nDATASET UNSTRUCTURED_GRID\n\
               POINTS 4 double\n0 0 0 1 0 0 0 1 0 0 0 1\nCELLS 1 5\n4 0 1 2 3\n\
               CELL_TYPES 1\n10\n";
    let gmsh = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n\
                4 0 0 1\n$EndNodes\n$Elements\n1\n1 4 2 0 1 1 2 3 4\n$EndElements\n";
    for (text, format) in [(vtk, VTK), (gmsh, MeshFormat::Gmsh)] {
        let found = refused(text.as_bytes(), format);
        assert!(found.contains("the cells: no faces: they are volumes"), "{found}");
    }
}

#[test]
fn values_that_are_left_out_are_noticed_in_every_section() {
    let head = "# vtk DataFile Version 3.0\na triangle\nASCII\nDATASET POLYDATA\n\
                POINTS 3 double\n0 0 0 1 0 0 0 1 0\nPOLYGONS 1 4\n3 0 1 2\n";
    let field = "FIELD FieldData 1\npart%20a 1 1 double\n7\n";
    for (section, note) in [
        ("CELL_DATA 1\n", "left out values of cells: 1, the first at part a"),
        (
            "POINT_DATA 3\n",
            "left out arrays without a value for each vertex: 1, the first at part a",
        ),
    ] {
        let file = read_bytes(format!("{head}{section}{field}").as_bytes(), VTK).unwrap();
        assert_eq!(file.notes, [note]);
    }
    let gmsh = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n\
                $EndNodes\n$Elements\n1\n1 2 2 0 1 1 2 3\n$EndElements\n$NodeData\n1\n\"T\"\n1\n\
                0.0\n3\n0\n1\n3\n1 np.float64(0.5)\n$EndNodeData\n";
    let folder = Folder::new();
    let path = folder.path("a.msh");
    fs::write(&path, gmsh).unwrap();
    let found = read_scalars(&path).unwrap_err().to_string();
    assert!(found.contains("no values of vertices: left out values of nodes"), "{found}");
}

#[test]
fn values_and_labels_of_freesurfer_are_read() {
    let folder = Folder::new();
    let mut curv = b"\xff\xff\xff\0\0\0\x03\0\0\0\x01\0\0\0\x01".to_vec();
    curv.extend(big([0.5f32, -1.0, 2.0], f32::to_be_bytes));
    let found = refused(&curv, MeshFormat::FreeSurfer);
    assert!(found.contains("no surface"), "{found}");
    let mut old = b"\0\0\x03\0\0\x01".to_vec();
    old.extend(big([50i16, -100, 200], i16::to_be_bytes));
    for (name, bytes) in [("lh.curv", &curv), ("lh.sulc", &old)] {
        let path = folder.path(name);
        fs::write(&path, bytes).unwrap();
        let scalars = read_scalars(&path).unwrap();
        assert_eq!(
            (&scalars[0].name[..], &scalars[0].values[..]),
            (&name[3..], &[0.5, -1.0, 2.0][..])
        );
        fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
        let found = read_scalars(&path).unwrap_err().to_string();
        assert!(found.contains("truncated"), "{found}");
    }
    // Labels of vertices: colours, of which a table says the numbers; version 2 of it.
    let color = |r: i32, g: i32, b: i32| r + (g << 8) + (b << 16);
    let mut words = vec![3, 0, color(10, 20, 30), 1, color(1, 1, 1), 2, 0];
    words.extend([1, -2, 9, 1]);
    let mut bytes = big(words, i32::to_be_bytes);
    bytes.extend(b"t\0\0\0\x02");
    for (number, [r, g, b]) in [(4, [1, 1, 1]), (7, [10, 20, 30])] {
        bytes.extend(big([number, 2], i32::to_be_bytes));
        bytes.extend(b"n\0");
        bytes.extend(big([r, g, b, 0], i32::to_be_bytes));
    }
    let path = folder.path("lh.annot");
    fs::write(&path, &bytes).unwrap();
    assert_eq!(read_scalars(&path).unwrap()[0].values, [7.0, 4.0, -1.0]);
    let mut packer = GzEncoder::new(Vec::new(), Compression::default());
    packer.write_all(&bytes).unwrap();
    let packed = folder.path("lh.annot.gz");
    fs::write(&packed, packer.finish().unwrap()).unwrap();
    assert_eq!(read_scalars(&packed).unwrap(), read_scalars(&path).unwrap());
    // Nothing marks the old form of values but its size.
    let longer = folder.path("lh.old");
    fs::write(&longer, [&old[..], &[0]].concat()).unwrap();
    let found = read_scalars(&longer).unwrap_err().to_string();
    assert!(found.contains("is no file of values"), "{found}");
    // The first number announces more than there is.
    bytes[0] = 0x7f;
    fs::write(&path, &bytes).unwrap();
    assert!(read_scalars(&path).unwrap_err().to_string().contains("truncated"));
    let within = SourceOptions::new().max_memory(8);
    let found = io::read_scalars(&longer, &within).unwrap_err().to_string();
    assert!(found.contains("a larger max_memory allows it"), "{found}");
}

#[test]
fn frames_of_mgh_are_functions_and_packed_by_gzip_too() {
    let folder = Folder::new();
    let values = [[0.5f64, -1.0, 2.0], [3.0, 0.25, 7.0]];
    // Their numbers, and how a number is stored.
    type To = fn(f64) -> Vec<u8>;
    let kinds: [(u32, To); 5] = [
        (3, |x| (x as f32).to_be_bytes().to_vec()),
        (0, |x| vec![x as u8]),
        (1, |x| (x as i32).to_be_bytes().to_vec()),
        (4, |x| (x as i16).to_be_bytes().to_vec()),
        (10, |x| (x as u16).to_be_bytes().to_vec()),
    ];
    let mgh = |sizes: [u32; 4], kind: u32, to: To| {
        let [x, y, z, frames] = sizes;
        let mut bytes = big([1, x, y, z, frames, kind, 0], u32::to_be_bytes);
        bytes.resize(284, 0);
        bytes.extend(values.as_flattened().iter().flat_map(|&x| to(x)));
        bytes
    };
    let path = folder.path("lh.thickness.mgh");
    for (kind, to) in kinds {
        fs::write(&path, mgh([3, 1, 1, 2], kind, to)).unwrap();
        let found = read_scalars(&path).unwrap();
        let kept = |x: f64| match kind {
            3 => x,
            4 | 1 => x.trunc(),
            _ => x.trunc().max(0.0),
        };
        for (k, own) in values.iter().enumerate() {
            let right = Scalars { name: format!("thickness.{k}"), values: own.map(kept).to_vec() };
            assert_eq!(found[k], right, "type {kind}");
        }
    }
    // The vertices may fill any dimension, and one frame has no number.
    let bytes = mgh([1, 3, 2, 1], 3, kinds[0].1);
    let mut packer = GzEncoder::new(Vec::new(), Compression::default());
    packer.write_all(&bytes).unwrap();
    let packed = folder.path("a.mgz");
    fs::write(&packed, packer.finish().unwrap()).unwrap();
    let right = Scalars { name: "a".into(), values: values.concat() };
    assert_eq!(read_scalars(&packed).unwrap(), [right]);
    let no_surface = read(&packed).unwrap_err().to_string();
    assert!(no_surface.contains("has values of vertices by its name, but no surface"));
    // What follows the values is left out, as in files with a name of the scanner.
    fs::write(&path, [&bytes[..], &[1; 20]].concat()).unwrap();
    assert_eq!(read_scalars(&path).unwrap()[0].values.len(), 6);
    for (bytes, what) in [
        (bytes[..bytes.len() - 1].to_vec(), "truncated: the file ends before the values"),
        (bytes[..200].to_vec(), "truncated: the file ends before the header"),
        (mgh([3, 1, 1, 2], 2, kinds[0].1), "is no file of values (MGH)"),
        (mgh([3, 1, 1, 4097], 3, kinds[0].1), "4097 frames, where 4096 are supported"),
        (mgh([1 << 20, 1 << 20, 1 << 20, 1], 3, kinds[0].1), "memory"),
    ] {
        fs::write(&path, bytes).unwrap();
        let found = read_scalars(&path).unwrap_err().to_string();
        assert!(found.contains(what), "{what}: {found}");
    }
}

/// Numbers as Gmsh writes them, as text or binary.
struct Numbers {
    bytes: Vec<u8>,
    binary: bool,
}

impl Numbers {
    fn text(&mut self, text: &str) {
        self.bytes.extend(text.as_bytes());
    }

    fn ints<const N: usize>(&mut self, numbers: [i32; N]) {
        self.add(numbers, i32::to_le_bytes);
    }

    fn longs<const N: usize>(&mut self, numbers: [u64; N]) {
        self.add(numbers, u64::to_le_bytes);
    }

    fn reals<const N: usize>(&mut self, numbers: [f64; N]) {
        self.add(numbers, f64::to_le_bytes);
    }

    fn add<T: ToString, const N: usize, const SIZE: usize>(
        &mut self,
        numbers: [T; N],
        to: fn(T) -> [u8; SIZE],
    ) {
        for number in numbers {
            match self.binary {
                true => self.bytes.extend(to(number)),
                false => self.text(&(number.to_string() + " ")),
            }
        }
    }
}

/// Returns a cube in Gmsh's format, and a node in no face; node numbers are 10 more than vertex
/// numbers.
fn msh(version: u32, binary: bool) -> Vec<u8> {
    let mut file = Numbers { bytes: Vec::new(), binary };
    let number = if version == 2 { "2.2" } else { "4.1" };
    file.text(&format!("$MeshFormat\n{number} {} 8\n", u8::from(binary)));
    if binary {
        file.ints([1]);
    }
    file.text("\n$EndMeshFormat\n$Comments\n$ of any kind\n$EndComments\n$Nodes\n");
    let position = |v: i32| corners()[v as usize % 8];
    if version == 2 {
        file.text("9\n");
        for v in 0..9 {
            file.ints([v + 10]);
            file.reals(position(v));
        }
    } else {
        // Blocks, nodes, the least and the largest number; the block of a surface.
        file.longs([1, 9, 10, 18]);
        file.ints([2, 1, 0]);
        file.longs([9]);
        (10..19).for_each(|number| file.longs([number]));
        (0..9).for_each(|v| file.reals(position(v)));
    }
    file.text("\n$EndNodes\n$Elements\n");
    if version == 2 {
        file.text("7\n");
        // A point, and quadrilaterals, with two tags each.
        let head = |i: i32, kind: i32| match binary {
            true => [kind, 1, 2, i, 5, 5],
            false => [i, kind, 2, 5, 5, 0],
        };
        let given = if binary { 6 } else { 5 };
        let add = |file: &mut Numbers, head: [i32; 6]| {
            head[..given].iter().for_each(|&number| file.ints([number]));
        };
        add(&mut file, head(0, 15));
        file.ints([18]);
        for (i, side) in (1..).zip(SIDES) {
            add(&mut file, head(i, 3));
            file.ints(side.map(|v| v as i32 + 10));
        }
    } else {
        file.longs([2, 7, 1, 7]);
        file.ints([0, 1, 15]);
        file.longs([1, 1, 18]);
        file.ints([2, 1, 3]);
        file.longs([6]);
        for (i, side) in (2..).zip(SIDES) {
            file.longs([i]);
            file.longs(side.map(|v| u64::from(v) + 10));
        }
    }
    file.text("\n$EndElements\n$NodeData\n1\n\"heat\"\n1\n0.0\n3\n0\n1\n2\n");
    for (number, value) in [(11, 0.25), (17, 0.5)] {
        file.ints([number]);
        file.reals([value]);
    }
    file.text("\n$EndNodeData\n");
    file.bytes
}

#[test]
fn faces_of_gmsh_are_read_in_each_version() {
    for (version, binary) in [(2, false), (2, true), (4, false), (4, true)] {
        let what = format!("{version}, {binary}");
        let bytes = msh(version, binary);
        let file = is_cube(&bytes, MeshFormat::Gmsh, &what);
        // The node of no face is gone.
        assert_eq!(file.mesh.vertices(), corners(), "{what}");
        let Scalars { name, values } = &file.scalars[0];
        assert_eq!((&name[..], values[1], values[7]), ("heat", 0.25, 0.5), "{what}");
        assert!(values[0].is_nan(), "{what}");
        let end = bytes.windows(12).position(|bytes| bytes == b"$EndElements").unwrap();
        for length in 1..end {
            if let Ok(cut) = read_bytes(&bytes[..length], MeshFormat::Gmsh) {
                assert!(cut.mesh.faces().is_empty(), "{what}: {length}");
            }
        }
    }
    let text = String::from_utf8(msh(2, false)).unwrap();
    for (from, to, what) in [
        ("2.2 0 8", "3.0 0 8", "mesh.msh:2: version \"3.0\", where 2 and 4.1, and 1 and 4.0 in"),
        ("2.2 0 8", "4.0 1 8", "mesh.msh:2: version 4.0 in binary, where"),
        ("$MeshFormat", "$Format", "has no $MeshFormat before other sections"),
        ("1 3 2 5 5 10", "1 3 2 5 5 99", "element 1: node 99 does not exist"),
        ("1 3 2 5 5 10", "1 999 2 5 5 10", "unknown type 999 of elements"),
    ] {
        let found = refused(text.replacen(from, to, 1).as_bytes(), MeshFormat::Gmsh);
        assert!(found.contains(what), "{to}: {found}");
    }
    // What is left out is noted, and a byte order mark is skipped.
    let wide = text.replace("$NodeData\n1\n\"heat\"\n1\n0.0\n3\n0\n1", "$NodeData\n0\n0\n2\n0\n10");
    let cells = format!("\u{feff}{wide}$ElementData\n0\n0\n0\n$EndElementData\n");
    let file = is_cube(cells.as_bytes(), MeshFormat::Gmsh, "values of elements");
    assert!(
        file.notes.iter().any(|note| note.contains("(10 values of a node)")),
        "{:?}",
        file.notes
    );
    assert!(file.notes.contains(&"left out values of elements: 1".into()), "{:?}", file.notes);
    let parametric = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 1 1 1\n9 1 1 1\n1\n0 0 0\n";
    let found = refused(parametric.as_bytes(), MeshFormat::Gmsh);
    assert!(found.contains("nodes with 9 parameters"), "{found}");
    let mut bytes = msh(2, true);
    bytes["$MeshFormat\n2.2 1 8\n".len()] = 7;
    let found = refused(&bytes, MeshFormat::Gmsh);
    assert!(found.contains("not 1 in any byte order"), "{found}");
}

#[test]
fn counts_of_gmsh_may_have_4_bytes_and_comments_may_come_first() {
    let begin = b"$Comments\nby a test\n$EndComments\n$MeshFormat\n4.1 1 4\n";
    let mut file = Numbers { bytes: begin.to_vec(), binary: true };
    file.ints([1]);
    file.text("\n$EndMeshFormat\n$Nodes\n");
    file.ints([1, 3, 1, 3, 2, 1, 0, 3, 1, 2, 3]);
    file.reals([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0]);
    file.text("\n$EndNodes\n$Elements\n");
    file.ints([1, 1, 1, 1, 2, 1, 2, 1, 1, 1, 2, 3]);
    file.text("\n$EndElements\n");
    let folder = Folder::new();
    let path = folder.path("a.dat");
    fs::write(&path, &file.bytes).unwrap();
    let found = read(&path).unwrap();
    assert_eq!((found.mesh.vertices()[2], found.mesh.faces()), ([0.0, 2.0, 0.0], &[[0, 1, 2]][..]));
    let text = String::from_utf8(msh(4, false)).unwrap().replace("4.1 0 8", "4.1 0 2");
    let said = refused(text.as_bytes(), MeshFormat::Gmsh);
    assert!(said.contains("numbers of 2 bytes are not supported"), "{said}");
}

#[test]
fn old_versions_of_gmsh_are_read_as_text() {
    let rows = |row: &dyn Fn(usize, [f64; 3]) -> String| -> String {
        (10..).zip(corners()).map(|(number, [x, y, z])| row(number, [x, y, z]) + "\n").collect()
    };
    let sides = |row: &dyn Fn(usize, String) -> String| -> String {
        let side = |side: [u32; 4]| text(side.map(|v| v + 10));
        (1..).zip(SIDES).map(|(i, own)| row(i, side(own)) + "\n").collect()
    };
    // Version 1: two regions, and the number of nodes.
    let nodes = rows(&|number, [x, y, z]| format!("{number} {x} {y} {z}"));
    let elements = sides(&|i, nodes| format!("{i} 3 7 7 4 {nodes}"));
    let one = format!("$NOD\n8\n{nodes}$ENDNOD\n$ELM\n6\n{elements}$ENDELM\n");
    // Version 4.0: the entity's number comes before its dimension; a node of a surface has two
    // parameters.
    let nodes = rows(&|number, [x, y, z]| format!("{number} {x} {y} {z} 0.5 0.25"));
    let elements = sides(&|i, nodes| format!("{i} {nodes}"));
    let four = format!(
        "$MeshFormat\n4 0 8\n$EndMeshFormat\n$Nodes\n1 8\n1 2 1 8\n{nodes}$EndNodes\n\
         $Elements\n1 6\n1 2 3 6\n{elements}$EndElements\n"
    );
    for text in [&one, &four] {
        let file = is_cube(text.as_bytes(), MeshFormat::Gmsh, text);
        assert_eq!((file.mesh.vertices(), file.notes.len()), (&corners()[..], 0));
        let cut = text.rfind('$').unwrap();
        assert!(refused(&text.as_bytes()[..cut], MeshFormat::Gmsh).contains("truncated"));
    }
    let wrong = one.replacen("1 3 7 7 4", "1 3 7 7 3", 1);
    assert!(refused(wrong.as_bytes(), MeshFormat::Gmsh).contains("element 0: 3 nodes, not 4"));
}

#[test]
fn binary_files_of_gmsh_have_either_byte_order() {
    let mut bytes = b"$MeshFormat\n2.2 1 8\n\0\0\0\x01\n$EndMeshFormat\n$Nodes\n3\n".to_vec();
    for (number, y) in [(1, 0.0), (2, 1.0), (300, 2.0)] {
        bytes.extend(i32::to_be_bytes(number));
        bytes.extend(big([y * y, y, 0.5], f64::to_be_bytes));
    }
    bytes.extend(b"\n$EndNodes\n$Elements\n1\n");
    // A triangle without tags.
    bytes.extend(big([2, 1, 0, 7, 1, 2, 300], i32::to_be_bytes));
    bytes.extend(b"\n$EndElements\n");
    let mesh = read_bytes(&bytes, MeshFormat::Gmsh).unwrap().mesh;
    assert_eq!((mesh.vertices()[2], mesh.faces()), ([4.0, 2.0, 0.5], &[[0, 1, 2]][..]));
}

/// Returns an archive with these parts and one that names the first as the model.
fn threemf(parts: &[(&str, &str)]) -> Vec<u8> {
    let mut archive = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let relations = format!(
        "<Relationships><Relationship Id=\"a\" Target=\"/{}\" \
         Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>",
        parts[0].0
    );
    for &(name, text) in [("_rels/.rels", &relations[..])].iter().chain(parts) {
        archive.start_file(name, SimpleFileOptions::default()).unwrap();
        archive.write_all(text.as_bytes()).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// Returns an object that is the unit cube.
fn cube_object(id: u32) -> String {
    let vertices: String = corners()
        .iter()
        .map(|[x, y, z]| format!("<vertex x=\"{x}\" y=\"{y}\" z=\"{z}\"/>"))
        .collect();
    let triangles: String = FACES
        .iter()
        .map(|[a, b, c]| format!("<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>"))
        .collect();
    format!(
        "<object id=\"{id}\"><mesh><vertices>{vertices}</vertices><triangles>{triangles}\
         </triangles></mesh></object>"
    )
}

#[test]
fn objects_of_3mf_are_in_their_places_in_millimetres() {
    let format = MeshFormat::ThreeMf;
    let model = |unit: &str, resources: &str, build: &str| {
        format!(
            "<?xml version=\"1.0\"?><model unit=\"{unit}\"><resources>{resources}</resources>\
             <build>{build}</build></model>"
        )
    };
    let cube = cube_object(1);
    let text = model("millimeter", &cube, "<item objectid=\"1\"/>");
    is_cube(&threemf(&[("3D/a.model", &text)]), format, "one");
    let centimetres = model("centimeter", &cube, "<item objectid=\"1\"/>");
    let file = read_bytes(&threemf(&[("3D/a.model", &centimetres)]), format).unwrap();
    assert_eq!(file.mesh.volume(), Some(1000.0));
    assert_eq!(file.notes, ["converted to millimetres: 1, the first at the unit centimeter"]);
    // A component that is moved in an item that is mirrored, beside a plain one, from another part.
    let resources = "<object id=\"2\"><components><component objectid=\"1\" p:path=\"/3D/b.model\" \
                     transform=\"2 0 0 0 1 0 0 0 1 5 0 0\"/></components></object>";
    let build = "<item objectid=\"2\" transform=\"-1 0 0 0 1 0 0 0 1 0 0 3\"/>\
                 <item objectid=\"2\"/>";
    let parts = [
        ("3D/a.model", model("millimeter", resources, build)),
        ("3D/b.model", model("inch", &cube, "")),
    ];
    let parts = parts.each_ref().map(|(name, text)| (*name, &text[..]));
    let file = read_bytes(&threemf(&parts), format).unwrap();
    let inch = 25.4f64;
    let volume = file.mesh.volume().unwrap();
    assert!((volume - 4.0 * inch.powi(3)).abs() < 1e-9, "{volume}");
    let [low, high] = file.mesh.bounding_box().unwrap();
    let right = [-5.0 - 2.0 * inch, 0.0, 0.0].into_iter().zip(low);
    assert!(
        right
            .chain([5.0 + 2.0 * inch, inch, inch + 3.0].into_iter().zip(high))
            .all(|(a, b)| { (a - b).abs() < 1e-12 })
    );
    // Names of parts differ in more than their case.
    let outer = resources.replace("/3D/b.model", "/3d/B.MODEL");
    let parts = [("3D/a.model", &model("inch", &outer, build)[..]), parts[1]];
    assert_eq!(read_bytes(&threemf(&parts), format).unwrap().mesh.faces().len(), 24);
    // Supports hold the object while it is printed, as items and as components.
    let support = |id: u32, kind: &str| {
        let named = format!("<object type=\"{kind}\" id");
        cube_object(id).replace("<object id", &named)
    };
    let more = "<object id=\"4\"><components><component objectid=\"1\"/>\
                <component objectid=\"3\"/></components></object>";
    let resources = [&support(2, "support")[..], &support(3, "solidsupport"), &cube, more].concat();
    let build = "<item objectid=\"2\"/><item objectid=\"4\"/>";
    let text = model("millimeter", &resources, build);
    let file = is_cube(&threemf(&[("3D/a.model", &text)]), format, "beside supports");
    let said = "left out supports, which hold objects while they are printed: objects: 2, the \
                first at object 2";
    assert_eq!(file.notes, [said]);
    let text = model("millimeter", &resources, "<item objectid=\"2\"/>");
    let said = refused(&threemf(&[("3D/a.model", &text)]), format);
    assert!(said.contains("has supports only"), "{said}");
    let text = model("millimeter", &support(1, "surface"), "<item objectid=\"1\"/>");
    is_cube(&threemf(&[("3D/a.model", &text)]), format, "a surface");
    // Objects within themselves, and millions of them.
    let own = "<object id=\"1\"><components><component objectid=\"1\"/></components></object>";
    let mut many = String::from("<object id=\"0\"/>");
    for i in 1..40 {
        let inner = format!("<component objectid=\"{}\"/>", i - 1);
        many += &format!("<object id=\"{i}\"><components>{inner}{inner}</components></object>");
    }
    for (resources, build, what) in [
        (own, "<item objectid=\"1\"/>", "components within components"),
        (&many[..], "<item objectid=\"39\"/>", "of memory"),
        (&cube[..], "<item objectid=\"7\"/>", "object 7 does not exist"),
        (&cube[..], "", "no items"),
        ("<object id=\"1\"><mesh><vertex x=\"1\" y=\"2\"/></mesh></object>", "", "attribute z"),
        ("<object id=\"1\"/><object id=\"1\"/>", "", "object 1 exists twice"),
        ("<object id=\"a\"/>", "", "\"a\" is not a whole number"),
    ] {
        let text = model("meter", resources, build);
        let found = refused(&threemf(&[("3D/a.model", &text)]), format);
        assert!(found.contains(what), "{what}: {found}");
    }
    let space = "http://schemas.microsoft.com/3dmanufacturing";
    let names = [("p", "production/2015/06"), ("b", "beamlattice/2017/02"), ("s", "slice/2015/07")];
    let requires_for = |prefixes: &str, resources: &str| {
        let spaces = names.map(|(prefix, name)| format!(" xmlns:{prefix}=\"{space}/{name}\""));
        let unit = format!("millimeter\"{} requiredextensions=\"{prefixes}", spaces.concat());
        threemf(&[("3D/a.model", &model(&unit, resources, "<item objectid=\"1\"/>"))])
    };
    let requires = |prefixes: &str| requires_for(prefixes, &cube);
    is_cube(&requires("p"), format, "production");
    // Beams and slices that no object has, and slices of the triangles.
    is_cube(&requires("p b"), format, "no beams");
    is_cube(&requires("s"), format, "slices");
    let coarse = cube.replacen("<object ", "<object s:meshresolution=\"lowres\" ", 1);
    let file = read_bytes(&requires_for("s", &coarse), format).unwrap();
    let said = "read the coarse meshes of objects, not their slices: 1, the first at object 1";
    assert_eq!((file.mesh.faces().len(), &file.notes[..]), (12, &[said.to_owned()][..]));
    let beams = cube.replacen("<mesh>", "<mesh><b:beamlattice/>", 1);
    let found = refused(&requires_for("b", &beams), format);
    assert!(found.contains("requires the extension http") && found.contains("beam"), "{found}");
    let found = refused(&requires("q"), format);
    assert!(found.contains("requires the extension q, which is not supported"), "{found}");
    let found = refused(&threemf(&[("a", &model("mile", "", ""))]), format);
    assert!(found.contains("unknown unit \"mile\""), "{found}");
    let bytes = threemf(&[("3D/a.model", &text)]);
    beginnings_are_refused(&bytes, bytes.len() - 1, format, "archive");
}

#[test]
fn names_of_files_in_an_archive_tell_3mf_from_packed_meshes() {
    let folder = Folder::new();
    let stored = |parts: &[(&str, &[u8])], name: &str| {
        let mut archive = ZipWriter::new(std::io::Cursor::new(Vec::new()));
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
        for (name, bytes) in parts {
            archive.start_file(*name, options).unwrap();
            archive.write_all(bytes).unwrap();
        }
        let bytes = archive.finish().unwrap().into_inner();
        fs::write(folder.path(name), &bytes).unwrap();
        bytes
    };
    let obj = ["v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n# _rels/.rels\n", &"g a\n".repeat(50)].concat();
    let relations = "<Relationships><Relationship Target=\"3D/a.model\" Type=\"x/3dmodel\"/>\
                     </Relationships>";
    let model = format!(
        "<model><resources>{}</resources><build><item objectid=\"1\"/></build></model>",
        cube_object(1)
    );
    stored(&[("3D/b.obj", obj.as_bytes())], "b.obj.zip");
    // A picture that is larger than what is read to detect the format.
    let picture = vec![0; 1 << 17];
    let parts: [(&str, &[u8]); 3] = [
        ("Metadata/thumbnail.png", &picture[..]),
        ("_rels/.rels", relations.as_bytes()),
        ("3D/a.model", model.as_bytes()),
    ];
    stored(&parts, "picture.3mf");
    let own = stored(&parts[1..], "c.3mf");
    stored(&[("c.3mf", &own[..])], "c.3mf.zip");
    let wide: Vec<u8> =
        format!("\u{feff}{model}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    stored(&[parts[1], ("3D/a.model", &wide[..])], "wide.3mf");
    for (name, faces) in
        [("b.obj.zip", 1), ("picture.3mf", 12), ("c.3mf", 12), ("c.3mf.zip", 12), ("wide.3mf", 12)]
    {
        let file = read(&folder.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!((file.mesh.faces().len(), file.notes), (faces, vec![]), "{name}");
    }
}

/// Returns a mesh with all attributes of vertices.
fn with_attributes() -> MeshFile {
    let mesh = families::icosphere(2).unwrap();
    let of = |f: fn(&[f64; 3]) -> f64| mesh.vertices().iter().map(f).collect::<Vec<f64>>();
    let (height, mut wave) = (of(|p| p[2]), of(|p| (3.0 * p[0]).sin()));
    wave[4] = f64::NAN;
    let uv = mesh.vertices().iter().map(|p| [p[0], 1e-3 * p[1]]).collect();
    let colors = mesh.vertices().iter().map(|p| [p[0].abs(), 0.25, 1.0, 0.5]).collect();
    let normals = mesh.vertices().to_vec();
    let mut file = MeshFile::from(mesh);
    file.uv = Some(Attribute { values: uv, corners: None });
    file.colors = Some(colors);
    file.normals = Some(Attribute { values: normals, corners: None });
    file.scalars = vec![
        Scalars { name: "height".into(), values: height },
        Scalars { name: "a wave, 100 % \"<&>\"".into(), values: wave },
    ];
    file
}

/// Compares the bits of numbers, in which NaN is itself.
fn same(a: &[Scalars], b: &[Scalars]) -> bool {
    let bits = |s: &Scalars| s.values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.name == b.name && bits(a) == bits(b))
}

#[test]
fn what_vtk_gifti_and_3mf_store_comes_back() {
    let file = with_attributes();
    for encoding in [VtkEncoding::Ascii, VtkEncoding::Binary] {
        let (bytes, notes) = write_bytes(&file, MeshFormat::Vtk(encoding)).unwrap();
        let back = read_bytes(&bytes, VTK).unwrap();
        assert!(same(&back.scalars, &file.scalars), "{encoding:?}");
        assert_eq!((&back.mesh, &back.uv), (&file.mesh, &file.uv), "{encoding:?}");
        assert_eq!(back.normals, file.normals, "{encoding:?}");
        if encoding == VtkEncoding::Ascii {
            assert_eq!((&back.colors, notes.len()), (&file.colors, 0));
        } else {
            assert_eq!(notes, ["rounded colours to 256 levels from 0 to 1"]);
            let rounded = |x: f64| (255.0 * x).round() / 255.0;
            let expected = file.colors.as_ref().unwrap().iter().map(|c| c.map(rounded));
            assert_eq!(back.colors.unwrap(), expected.collect::<Vec<_>>());
        }
    }
    let (bytes, notes) = write_bytes(&file, MeshFormat::Gifti).unwrap();
    assert_eq!(notes[0], "this format can't store texture coordinates, colours");
    assert!(notes.iter().any(|note| note == "rounded scalars to single precision"), "{notes:?}");
    let back = read_bytes(&bytes, MeshFormat::Gifti).unwrap();
    assert_eq!(
        (back.mesh.faces(), &back.scalars[1].name),
        (file.mesh.faces(), &file.scalars[1].name)
    );
    for (a, b) in back.scalars.iter().zip(&file.scalars) {
        let close = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-7 || (a.is_nan() && b.is_nan());
        assert!(a.values.iter().zip(&b.values).all(close));
    }
    // Single precision comes back as it is.
    let (again, _) = write_bytes(&back, MeshFormat::Gifti).unwrap();
    assert_eq!(again, bytes);
    let (bytes, notes) = write_bytes(&file, MeshFormat::ThreeMf).unwrap();
    let lost = "this format can't store texture coordinates, normals, colours, scalars";
    assert_eq!(notes, [lost]);
    assert_eq!(read_bytes(&bytes, MeshFormat::ThreeMf).unwrap().mesh, file.mesh);
    // A mesh without vertices.
    let nothing = MeshFile::from(TriMesh::new(vec![], vec![]).unwrap());
    for format in
        [VTK, MeshFormat::Vtk(VtkEncoding::Binary), MeshFormat::Gifti, MeshFormat::ThreeMf]
    {
        let (bytes, _) = write_bytes(&nothing, format).unwrap();
        assert_eq!(read_bytes(&bytes, format).unwrap().mesh, nothing.mesh, "{format:?}");
    }
}

#[test]
fn names_and_content_decide_between_the_formats() {
    let folder = Folder::new();
    let mut file = with_attributes();
    file.scalars.truncate(1);
    for name in ["a.vtk", "b.gii", "c.3mf", "d.vtk.gz", "e.gii.gz"] {
        let path = folder.path(name);
        write(create(&path), &file).unwrap();
        assert_eq!(read(&path).unwrap().mesh.faces(), file.mesh.faces(), "{name}");
        // Under another name, the content decides.
        let other = folder.path(&format!("{}.obj", &name[..1]));
        fs::copy(&path, &other).unwrap();
        let back = read(&other).unwrap();
        assert_eq!(back.mesh.faces(), file.mesh.faces(), "{name}");
        assert!(back.notes.iter().any(|note| note.contains("format of its content")), "{name}");
    }
    for name in ["a.vtp", "a.vtu", "lh.white", "a.msh"] {
        let refused = write(create(&folder.path(name)), &file).unwrap_err().to_string();
        assert!(refused.contains("can only be read"), "{refused}");
    }
}

#[test]
fn scalars_follow_the_vertices() {
    let mut file = with_attributes();
    file.scalars.truncate(1);
    let is_height = |file: &MeshFile, within: f64| {
        let values = file.scalars[0].values.iter();
        assert_eq!(values.len(), file.mesh.vertices().len());
        assert!(values.zip(file.mesh.vertices()).all(|(z, p)| (z - p[2]).abs() <= within));
    };
    let part = file.part(file.mesh.submesh(&[3, 80, 200]).unwrap()).unwrap();
    is_height(&part, 0.0);
    is_height(&file.refined(&Refined::new(file.mesh.clone())).unwrap(), 0.0);
    let fewer = decimate(&file.mesh, 60, &DecimateOptions::new()).unwrap().carry(&file).unwrap();
    is_height(&fewer, 0.2);
    file.scalars[0].values.pop();
    assert!(write_bytes(&file, VTK).unwrap_err().to_string().contains("scalars"));
}

#[test]
fn files_with_any_byte_changed_are_read_or_refused() {
    let mut small = MeshFile::from(families::icosphere(0).unwrap());
    let values = (0..12).map(f64::from).collect();
    small.scalars = vec![Scalars { name: "n".into(), values }];
    let written = |format: MeshFormat| (write_bytes(&small, format).unwrap().0, format);
    let files = [
        (msh(2, true), MeshFormat::Gmsh),
        (msh(4, true), MeshFormat::Gmsh),
        (msh(4, false), MeshFormat::Gmsh),
        (vtp("raw", true, false), MeshFormat::VtkXml),
        (vtp("base64", false, true), MeshFormat::VtkXml),
        written(MeshFormat::Gifti),
        written(MeshFormat::ThreeMf),
        written(VTK),
        written(MeshFormat::Vtk(VtkEncoding::Binary)),
    ];
    for (bytes, format) in files {
        for at in 0..bytes.len() {
            for to in [0, 0xff, b'9'] {
                let mut changed = bytes.clone();
                changed[at] = to;
                if let Ok(file) = read_bytes(&changed, format) {
                    std::hint::black_box(file.mesh.validate());
                }
            }
        }
    }
}
