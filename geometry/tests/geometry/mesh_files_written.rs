//! What written mesh files hold, that every loss has a note, and that other programs can read them.

use std::fs;

use catamaran_geometry::mesh::io::{
    Attribute, GltfEncoding, Material, MeshFile, MeshFormat, PlyEncoding, StlEncoding, read,
    read_bytes, write, write_as, write_bytes, write_with_material,
};
use catamaran_geometry::mesh::{TriMesh, families};

use crate::common::data;
use crate::mesh_files::{Folder, create, note};

/// A sphere of this radius around a point.
fn sphere(radius: f64, center: [f64; 3]) -> TriMesh {
    let (points, faces) = families::icosphere(3).unwrap().into_parts();
    let place = |p: [f64; 3]| [0, 1, 2].map(|k| radius * p[k] + center[k]);
    TriMesh::new(points.into_iter().map(place).collect(), faces).unwrap()
}

/// A place in UTM coordinates, in metres.
const UTM: [f64; 3] = [691_608.37, 5_334_764.91, 519.25];

/// The largest distance between vertices of two meshes, face by face.
fn apart(a: &TriMesh, b: &TriMesh) -> f64 {
    assert_eq!(a.faces().len(), b.faces().len());
    let corners = |mesh: &TriMesh| -> Vec<[f64; 3]> {
        mesh.faces().as_flattened().iter().map(|&v| mesh.vertices()[v as usize]).collect()
    };
    let distance =
        |(p, q): ([f64; 3], [f64; 3])| (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt();
    corners(a).into_iter().zip(corners(b)).map(distance).fold(0.0, f64::max)
}

/// The displacement that a note names.
fn noted(notes: &[String]) -> f64 {
    let start = "rounded coordinates to single precision: vertices move by up to ";
    let said = notes.iter().find_map(|line| line.strip_prefix(start)).expect("a note");
    said.split(' ').next().unwrap().parse().unwrap()
}

#[test]
fn single_precision_notes_the_largest_displacement() {
    let folder = Folder::new();
    for (radius, center) in [(100.0, UTM), (1.0, [0.0; 3]), (3.0, [1e4, 0.0, -1e5])] {
        let mesh = sphere(radius, center);
        for name in ["a.stl", "a.glb", "a.gltf", "a.stl.gz"] {
            let path = folder.path(name);
            let notes = write(create(&path), &mesh.clone().into()).unwrap();
            let moved = apart(&mesh, &read(&path).unwrap().mesh);
            let said = noted(&notes);
            assert!((said / moved - 1.0).abs() < 0.051, "{name}: {said}, {moved}");
            // In glTF, coordinates count from the middle.
            let is_stl = name.starts_with("a.stl");
            assert_eq!(moved > 1e-6 * radius, is_stl && center != [0.0; 3], "{name}: {moved}");
        }
        for name in ["a.obj", "a.ply", "a.off"] {
            let path = folder.path(name);
            assert!(write(create(&path), &mesh.clone().into()).unwrap().is_empty(), "{name}");
            assert_eq!(read(&path).unwrap().mesh, mesh);
        }
        let format = MeshFormat::of("a.stl".as_ref()).unwrap().as_text().unwrap();
        let path = folder.path("text.stl");
        assert!(write_as(create(&path), &mesh.clone().into(), format).unwrap().is_empty());
        assert_eq!(apart(&read(&path).unwrap().mesh, &mesh), 0.0);
    }
    // Nothing is noted where nothing is rounded.
    for name in ["b.stl", "b.glb"] {
        let grid = families::grid(4, 2).unwrap();
        assert!(write(create(&folder.path(name)), &grid.into()).unwrap().is_empty());
    }
}

#[test]
fn faces_that_would_vanish_are_an_error_and_glb_keeps_them() {
    let folder = Folder::new();
    // A millimetre, a thousand kilometres away.
    let mesh = sphere(5e-4, [1e6, 1e6, 1e6]);
    let path = folder.path("a.stl");
    let refused = write(create(&path), &mesh.clone().into()).unwrap_err().to_string();
    let said = "a.stl: 1280 of 1280 faces vanish in the single precision of this format, the first \
                is face 0; .ply, .obj, .off and STL as text";
    assert!(refused.contains(said) && !path.exists(), "{refused}");
    let path = folder.path("a.glb");
    write(create(&path), &mesh.clone().into()).unwrap();
    let back = read(&path).unwrap().mesh;
    // As far as double precision has digits at this place.
    let [found, volume] = [&back, &mesh].map(|m| m.volume().unwrap());
    assert!((found / volume - 1.0).abs() < 1e-5, "{found}");
    // Two bodies of a millimetre far apart: glTF has no middle for both.
    let (mut points, mut faces) = mesh.into_parts();
    let (more, other) = sphere(5e-4, [-1e6; 3]).into_parts();
    faces.extend(other.iter().map(|face| face.map(|v| v + points.len() as u32)));
    points.extend(more);
    let both = TriMesh::new(points, faces).unwrap().into();
    let path = folder.path("both.glb");
    let refused = write(create(&path), &both).unwrap_err().to_string();
    assert!(refused.contains("of 2560 faces vanish") && !path.exists(), "{refused}");
    let material = write_with_material(create(&path), &both, &Material::new()).unwrap_err();
    assert!(material.to_string().contains("faces vanish") && !path.exists());
}

#[test]
fn colors_come_back_and_what_is_rounded_is_noted() {
    let folder = Folder::new();
    let mut file = MeshFile::from(families::grid(1, 1).unwrap());
    let colors = |largest: f64| Some(vec![[0.8, 0.8, largest, 1.0], [0.8; 4], [0.2; 4], [1.0; 4]]);
    for largest in [1.2, 3.0, 15.5] {
        file.colors = colors(largest);
        for name in ["a.obj", "a.off", "a.glb", "a.ply"] {
            let path = folder.path(name);
            let notes = write(create(&path), &file).unwrap();
            let back = read(&path).unwrap();
            let exact = !name.ends_with("glb");
            for (found, given) in back.colors.iter().zip(&file.colors) {
                let (found, given) = (found.as_flattened(), given.as_flattened());
                let near = |(a, b): (&f64, &f64)| (a - b).abs() <= if exact { 0.0 } else { 1e-6 };
                assert!(found.iter().zip(given).all(near), "{name}: {found:?}");
            }
            let doubles = notes.iter().any(|line| line.contains("as double numbers"));
            assert_eq!(doubles, name == "a.ply", "{notes:?}");
            if name == "a.obj" || name == "a.off" {
                let said =
                    "took colours to be from 0 to 1, although numbers of them are above 1: 1";
                note(&back, said);
            }
        }
    }
    // Bytes are what other programs read.
    file.colors = colors(0.123);
    let path = folder.path("b.ply");
    assert_eq!(write(create(&path), &file).unwrap(), ["rounded colours to 256 levels"]);
    let text = fs::read(&path).unwrap();
    assert!(String::from_utf8_lossy(&text).contains("property uchar red"));
    assert_eq!(read(&path).unwrap().colors.unwrap()[0][2], 31.0 / 255.0);
}

#[test]
fn colors_of_text_count_from_0_to_1_or_to_255() {
    let read = |colors: [&str; 3]| {
        let v = |i: usize| format!("v {i} 0 {} {}\n", i * i, colors[i]);
        let text = format!("{}{}{}f 1 2 3\n", v(0), v(1), v(2));
        let file = read_bytes(text.as_bytes(), MeshFormat::Obj).unwrap();
        (file.colors.unwrap().into_iter().map(|c| c[0]).collect::<Vec<_>>(), file.notes)
    };
    let (found, notes) = read(["255 0 0", "51 0 0", "0 0 0"]);
    assert_eq!((found, notes.len()), (vec![1.0, 0.2, 0.0], 0));
    let (found, notes) = read(["1 0 0", "0 1 1", "1 1 1"]);
    assert_eq!((found, notes.len()), (vec![1.0, 0.0, 1.0], 0));
    let (found, notes) = read(["1.5 0 0", "1 1 1", ".25 0 0"]);
    assert_eq!(found, [1.5, 1.0, 0.25]);
    assert!(notes[0].ends_with("above 1: 1, the largest is 1.5"), "{notes:?}");
    let (found, notes) = read(["255.0 0 0", "127.5 1 1", "0 0 0"]);
    assert_eq!(found, [1.0, 0.5, 0.0]);
    assert!(notes[0].starts_with("took colours to be from 0 to 255"), "{notes:?}");
    let (found, notes) = read(["510 0 0", "255 1 1", "0 0 0"]);
    assert_eq!(found, [2.0, 1.0, 0.0]);
    assert!(notes[0].ends_with("is 510, and 1 are above 255"), "{notes:?}");
}

#[test]
fn lists_of_ply_have_one_length() {
    let folder = Folder::new();
    let mut file = MeshFile::from(families::grid(2, 1).unwrap());
    let absent = [Attribute::<2>::ABSENT; 3];
    let values = vec![[0.25, 0.5], [0.75, 1.0], [40.1, 0.0]];
    let corners = vec![[0, 1, 2], absent, [2, 1, 0], absent];
    file.uv = Some(Attribute { values, corners: Some(corners) });
    for encoding in [PlyEncoding::Ascii, PlyEncoding::LittleEndian] {
        let path = folder.path("a.ply");
        let notes = write_as(create(&path), &file, MeshFormat::Ply(encoding)).unwrap();
        assert_eq!(notes[0], "wrote texture coordinates 0 for 2 faces without any");
        assert_eq!(notes.len(), if encoding == PlyEncoding::Ascii { 1 } else { 2 }, "{notes:?}");
        let back = read(&path).unwrap();
        assert_eq!(back.uv.unwrap().of_face(&back.mesh, 1), Some([[0.0; 2]; 3]));
    }
}

#[test]
fn attributes_that_are_not_finite_are_not_written() {
    let folder = Folder::new();
    let path = folder.path("a.obj");
    for wrong in [f64::NAN, f64::INFINITY] {
        let mut file = MeshFile::from(families::grid(1, 1).unwrap());
        file.colors = Some(vec![[0.0, 0.0, wrong, 1.0]; 4]);
        let refused = write(create(&path), &file).unwrap_err().to_string();
        assert!(refused == "colors: not finite at row 0, column 2" && !path.exists(), "{refused}");
        file.colors = None;
        file.normals = Some(Attribute { values: vec![[0.0, wrong, 1.0]; 4], corners: None });
        assert!(write(create(&path), &file).is_err() && !path.exists());
    }
}

#[test]
fn attributes_of_corners_come_back_or_are_named() {
    // The corners of two faces differ at their common edge.
    let mut file = MeshFile::from(families::grid(1, 1).unwrap());
    let corners = Some(vec![[0, 1, 2], [3, 4, 5]]);
    let uv = (0..6).map(|i| [f64::from(i) / 8.0, 0.5]).collect();
    let normal = |i: usize| if i < 3 { [0.0, 0.6, 0.8] } else { [0.8, 0.0, 0.6] };
    file.uv = Some(Attribute { values: uv, corners: corners.clone() });
    file.normals = Some(Attribute { values: (0..6).map(normal).collect(), corners });
    for ending in ["obj", "ply", "off", "stl", "glb", "vtk", "gii", "3mf"] {
        let format = MeshFormat::of(format!("a.{ending}").as_ref()).unwrap();
        let (bytes, notes) = write_bytes(&file, format).unwrap();
        let back = read_bytes(&bytes, format).unwrap();
        let said = notes.join(" ");
        let is_kept = same_corners(&file.uv, &file.mesh, &back.uv, &back.mesh);
        assert!(is_kept || said.contains("texture coordinates"), "{ending}: {notes:?}");
        let is_kept = same_corners(&file.normals, &file.mesh, &back.normals, &back.mesh);
        assert!(is_kept || said.contains("normals"), "{ending}: {notes:?}");
    }
}

/// Returns whether two meshes have the same values at the corners of each face.
fn same_corners<const N: usize>(
    a: &Option<Attribute<N>>,
    a_mesh: &TriMesh,
    b: &Option<Attribute<N>>,
    b_mesh: &TriMesh,
) -> bool {
    let (Some(a), Some(b)) = (a, b) else { return false };
    let near = |(x, y): (&f64, &f64)| (x - y).abs() < 1e-6;
    (0..a_mesh.faces().len()).all(|f| match (a.of_face(a_mesh, f), b.of_face(b_mesh, f)) {
        (Some(a), Some(b)) => a.as_flattened().iter().zip(b.as_flattened()).all(near),
        _ => false,
    })
}

#[test]
fn off_has_one_attribute_beside_positions() {
    let folder = Folder::new();
    let mut file = MeshFile::from(families::grid(1, 1).unwrap());
    file.normals = Some(Attribute { values: vec![[0.0, 0.0, 1.0]; 4], corners: None });
    let path = folder.path("a.off");
    let head = |file: &MeshFile| {
        let notes = write(create(&path), file).unwrap();
        (fs::read_to_string(&path).unwrap().lines().next().unwrap().to_owned(), notes)
    };
    assert_eq!(head(&file), ("NOFF".into(), vec![]));
    file.colors = Some(vec![[0.5, 0.0, 1.0, 1.0]; 4]);
    let said = "this format can't store normals beside colours";
    assert_eq!(head(&file), ("COFF".into(), vec![said.into()]));
}

#[test]
fn a_sphere_in_utm_coordinates_keeps_its_volume() {
    let Some(path) = data("inputs/meshes/sphere_s_utm.obj") else { return };
    let file = read(&path).unwrap();
    let folder = Folder::new();
    for (format, tolerance) in [
        (MeshFormat::Gltf(GltfEncoding::Binary), 1e-7),
        (MeshFormat::Stl(StlEncoding::Ascii), 1e-12),
    ] {
        let path = folder.path("sphere");
        write_as(create(&path), &file, format).unwrap();
        let found = read(&path).unwrap().mesh;
        let [found, volume] = [&found, &file.mesh].map(|m| m.volume().unwrap());
        assert!((found / volume - 1.0).abs() < tolerance, "{found}");
    }
    assert!(noted(&write(create(&folder.path("a.stl")), &file).unwrap()) > 0.1);
    let Some(path) = data("inputs/meshes/obj_rgb_hdr2.obj") else { return };
    assert_eq!(read(&path).unwrap().colors.unwrap()[0], [0.8, 0.8, 1.2, 1.0]);
}
