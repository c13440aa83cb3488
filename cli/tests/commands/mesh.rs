//! `catamaran mesh`, from outside.

use catamaran::mesh::{families, io};

use crate::common::Folder;

const SQUARE: &str = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4\n";
/// Two tetrahedra apart, one with a face turned over, and a vertex alone.
const TWO: &str = "OFF\n9 8 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n9 9 9\n5 0 0\n6 0 0\n5 1 0\n5 0 1\n\
                   3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n3 5 7 6\n3 5 6 8\n3 5 8 7\n3 8 7 6\n";

#[test]
fn report_says_what_the_mesh_is() {
    let folder = Folder::new();
    folder.write("square.obj", SQUARE);
    let report = folder.succeed("mesh square.obj --check");
    for line in [
        "vertices    4",
        "edges       5, 4 on the boundary",
        "faces       2",
        "components  1",
        "loops       1",
        "Euler       1",
        "genus       0",
        "problems    none",
        "area        4",
        "box         [0.0, 0.0, 0.0] to [2.0, 2.0, 0.0]",
        "quality     0.717 mean, 0.717 least, 0.00 % below 0.1 (1: equilateral)",
    ] {
        assert!(report.lines().any(|said| said == line), "{line:?} in {report}");
    }
    assert!(!report.contains("volume"), "{report}");
}

#[test]
fn problems_are_named_and_fail_only_on_demand() {
    let folder = Folder::new();
    folder.write("two.off", TWO);
    let report = folder.succeed("mesh two.off");
    assert!(report.contains("problem     vertices without a face: 1 (vertex 4)\n"), "{report}");
    assert!(
        report.contains(
            "problem     edges whose faces run the same way: 3 (edge 6-7 of faces 4 and 7;"
        ),
        "{report}"
    );
    assert!(report.contains("components  2\n"), "{report}");
    let refused = folder.fail("mesh two.off --check -o other.off");
    assert_eq!(refused, "catamaran: two.off: problems found: 4\n");
}

#[test]
fn a_mesh_is_cleaned_and_converted() {
    let folder = Folder::new();
    folder.write("two.off", TWO);
    let report = folder.succeed("mesh two.off -o clean.ply.gz --orient --compact --normalize box");
    assert!(report.ends_with("written     clean.ply.gz: 8 vertices, 8 faces\n"), "{report}");
    let clean = folder.succeed("mesh clean.ply.gz --check");
    assert!(clean.contains("problems    none") && clean.contains("volume"), "{clean}");
    folder.succeed("mesh two.off -o one.stl --component 1 --orient");
    let one = io::read(&folder.path("one.stl")).unwrap().mesh;
    assert_eq!((one.vertices().len(), one.vertices()[0]), (4, [5.0, 0.0, 0.0]));
    folder.succeed("mesh two.off -o largest.obj --component largest --normalize area");
    let largest = io::read(&folder.path("largest.obj")).unwrap().mesh;
    assert!((largest.area() - 1.0).abs() < 1e-12);
}

#[test]
fn a_conversion_keeps_attributes() {
    let folder = Folder::new();
    folder.write("a.obj", format!("{SQUARE}vt 0 0\nvt 1 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/1/1\n"));
    let report = folder.succeed("mesh a.obj -o b.obj");
    assert!(report.contains("attributes  texture coordinates, normals"), "{report}");
    let read = |name: &str| io::read(&folder.path(name)).unwrap();
    assert_eq!(read("a.obj"), read("b.obj"));
}

#[test]
fn parts_keep_the_attributes_of_their_vertices_and_corners() {
    let folder = Folder::new();
    // Two triangles apart, a vertex alone between them, the second one with the texture of a corner of its own.
    let colors = ["1 0 0", "0 1 0", "0 0 1", "0 0 0", "1 1 0", "1 0 1", "0 1 1"];
    let points = ["0 0 0", "1 0 0", "0 1 0", "9 9 9", "5 0 0", "6 0 0", "5 1 0"];
    let vertices: String = points.iter().zip(colors).map(|(p, c)| format!("v {p} {c}\n")).collect();
    let texture = "vt 0 0\nvt .5 0\nvt 0 .5\nvt 1 1\nvn 0 0 1\nvn 0 1 0\n";
    folder.write("a.obj", format!("{vertices}{texture}f 1/1/1 2/2/1 3/3/1\nf 5/1/2 6/4/2 7/3/2\n"));
    folder.succeed("mesh a.obj -o second.obj --component 1");
    let read = |name: &str| io::read(&folder.path(name)).unwrap();
    let second = read("second.obj");
    assert_eq!(
        second.colors.unwrap(),
        [[1.0, 1.0, 0.0, 1.0], [1.0, 0.0, 1.0, 1.0], [0.0, 1.0, 1.0, 1.0]]
    );
    let of_face = second.uv.unwrap().of_face(&second.mesh, 0);
    assert_eq!(of_face, Some([[0.0, 0.0], [1.0, 1.0], [0.0, 0.5]]));
    assert_eq!(second.normals.unwrap().of_face(&second.mesh, 0), Some([[0.0, 1.0, 0.0]; 3]));
    folder.succeed("mesh a.obj -o compact.obj --compact");
    let compact = read("compact.obj");
    assert_eq!(
        (compact.mesh.vertices().len(), compact.colors.as_ref().unwrap()[3]),
        (6, [1.0, 1.0, 0.0, 1.0])
    );
    let of_face = compact.uv.as_ref().unwrap().of_face(&compact.mesh, 1);
    assert_eq!(of_face, Some([[0.0, 0.0], [1.0, 1.0], [0.0, 0.5]]));
    // The second face of a square that runs the other way: its corners turn with it.
    folder.write(
        "square.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 4/4 3/3\n",
    );
    folder.succeed("mesh square.obj -o turned.obj --orient");
    let turned = read("turned.obj");
    assert_eq!(turned.mesh.faces()[1], [0, 2, 3]);
    let uv = turned.uv.unwrap();
    assert_eq!(uv.of_face(&turned.mesh, 1), Some([[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]));
}

#[test]
fn nothing_is_overwritten_without_force() {
    let folder = Folder::new();
    folder.write("square.obj", SQUARE);
    folder.write("other.off", "precious");
    let refused = folder.fail("mesh square.obj -o other.off");
    assert!(refused.contains("other.off: exists already (--force replaces it)"), "{refused}");
    assert_eq!(std::fs::read(folder.path("other.off")).unwrap(), b"precious");
    folder.succeed("mesh square.obj -o other.off --force");
    assert!(io::read(&folder.path("other.off")).is_ok());
}

#[test]
fn what_can_not_be_done_is_said_in_a_line() {
    let folder = Folder::new();
    folder.write("square.obj", SQUARE);
    folder.write("broken.obj", "v 0 0\n");
    let strip = families::moebius(9, 1).unwrap();
    let output =
        catamaran::io::Output::create(&folder.path("strip.ply"), catamaran::io::Overwrite::Never);
    io::write(output.unwrap(), &strip.into()).unwrap();
    for (arguments, what) in [
        ("mesh none.obj", "none.obj: no such file"),
        ("mesh broken.obj", "broken.obj:1: 2 numbers where 3 are needed"),
        ("mesh broken.obj -o new.obj", "broken.obj:1: "),
        ("mesh square.obj -o new.vtk", "new.vtk: unknown kind of mesh"),
        ("mesh square.obj -o new.ply.xz", "can only be read"),
        ("mesh square.obj -o new.ply --component 1", "1 of 1 (numbered from 0)"),
        ("mesh strip.ply -o new.ply --orient", "not orientable"),
    ] {
        let refused = folder.fail(arguments);
        assert!(refused.contains(what), "{arguments}: {refused}");
    }
}
