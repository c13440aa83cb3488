//! `catamaran mesh`, from outside.

use catamaran::io::{Output, Overwrite};
use catamaran_geometry::mesh::io::{Attribute, MeshFile};
use catamaran_geometry::mesh::{TriMesh, families, io};

use crate::common::{Folder, calls};

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
fn a_mesh_without_faces_is_a_problem() {
    let folder = Folder::new();
    for (name, text, vertices, problems) in [
        ("empty.obj", "# nothing\n", 0, 1),
        ("empty.off", "OFF\n0 0 0\n", 0, 1),
        ("points.obj", "v 0 0 0\nv 1 0 0\n", 2, 3),
    ] {
        folder.write(name, text);
        let report = folder.succeed(&format!("mesh {name}"));
        let problem = format!("problem     no faces: 1 (a mesh of {vertices} vertices)\n");
        assert!(report.contains(&problem) && report.contains("\narea        0\n"), "{report}");
        let refused = folder.fail(&format!("mesh {name} --check"));
        assert_eq!(refused, format!("catamaran: {name}: problems found: {problems}\n"));
        if vertices == 0 {
            let refused = folder.fail(&format!("mesh {name} -o out.ply"));
            assert!(
                refused.contains("out.ply: not written: the mesh has no vertices"),
                "{refused}"
            );
        }
    }
}

#[test]
fn what_a_reader_skips_and_what_a_file_is_reach_the_user() {
    let folder = Folder::new();
    folder.write("a.off", "OFF4 1 0\n0 0 0 7\n2 0 0 7\n2 2 0 7\n0 2 0 7\n4 0 1 2 3\n");
    let said = notes(&folder, "mesh a.off");
    let note =
        "note: a.off: left out numbers after the others, of vertices: 4, the first at line 2";
    assert!(said.contains(note), "{said}");
    folder.write("b.stl", "<!DOCTYPE html>\n<html></html>\n");
    folder.write("c.ply", "");
    for (name, what) in [
        ("b.stl", "is no mesh of a known format: it seems to be a web page: download the file"),
        ("c.ply", "is empty: it has 0 bytes"),
    ] {
        let refused = folder.fail(&format!("mesh {name}"));
        assert!(refused.contains(&format!("{name}: {what}")), "{refused}");
    }
    // Help has the formats that are in the library's table.
    let help = folder.succeed("mesh --help");
    let help: Vec<&str> = help.split_whitespace().collect();
    assert!(help.join(" ").contains(&io::MeshFormat::readable()), "{help:?}");
}

#[test]
fn a_surface_that_is_not_orientable_is_not_told_to_be_oriented() {
    let mut sphere = families::icosphere(1).unwrap().into_parts();
    sphere.1[3].swap(0, 1);
    let folder = with("sphere.ply", &TriMesh::new(sphere.0, sphere.1).unwrap().into());
    assert!(folder.succeed("mesh sphere.ply").contains("\noption      --orient flips"));
    folder.succeed("mesh sphere.ply --orient --check");
    let folder = with("strip.ply", &families::moebius(9, 2).unwrap().into());
    let report = folder.succeed("mesh strip.ply");
    assert!(report.contains("not orientable") && !report.contains("--orient"), "{report}");
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
fn one_component_is_checked_and_compared_without_the_others() {
    let folder = Folder::new();
    // Two squares; the faces of the second one disagree.
    folder.write(
        "two.off",
        "OFF\n8 4 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n5 0 0\n6 0 0\n6 1 0\n5 1 0\n\
         3 0 1 2\n3 0 2 3\n3 4 5 6\n3 4 7 6\n",
    );
    let refused = folder.fail("mesh two.off --check -o no.off --component 1");
    assert!(refused.contains("two.off: problems found: 1"), "{refused}");
    folder.succeed("mesh two.off --check -o one.off --component 0");
    let said = folder.succeed("mesh two.off --compare one.off -o again.off --component 0");
    for (label, both) in [
        ("vertices", "4                       4"),
        ("components", "1                       1"),
        ("loops", "1                       1"),
        ("problems", "0                       0"),
    ] {
        assert!(said.contains(&format!("\n{label:<12}{both}\n")), "{label}: {said}");
    }
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
    // Two triangles apart, a vertex alone between them, the second one with the texture of a corner
    // of its own.
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
    let [written, square] = ["other.off", "square.obj"].map(|name| io::read(&folder.path(name)));
    assert_eq!(written.unwrap().mesh, square.unwrap().mesh);
}

#[test]
fn what_can_not_be_done_is_said_in_a_line() {
    let folder = Folder::new();
    folder.write("square.obj", SQUARE);
    folder.write("broken.obj", "v 0\n");
    let strip = families::moebius(9, 1).unwrap();
    let output = Output::create(&folder.path("strip.ply"), Overwrite::Never);
    io::write(output.unwrap(), &strip.into()).unwrap();
    for (arguments, what) in [
        ("mesh none.obj", "none.obj: no such file"),
        ("mesh broken.obj", "broken.obj:1: 1 numbers where 2 are needed"),
        ("mesh broken.obj -o new.obj", "broken.obj:1: "),
        ("mesh square.obj -o new.doc", "new.doc: unknown kind of mesh"),
        ("mesh square.obj -o new.vtp", "VTK XML files can only be read"),
        ("mesh square.obj -o new.ply.xz", "can only be read"),
        ("mesh square.obj -o new.ply --component 1", "1 is not one of the 1 components"),
        ("mesh strip.ply -o new.ply --orient", "not orientable"),
    ] {
        let refused = folder.fail(arguments);
        assert!(refused.contains(what), "{arguments}: {refused}");
    }
}

/// A sphere split along seams, with texture coordinates.
fn split_sphere() -> MeshFile {
    let mesh = families::split_sphere(16, 8).unwrap();
    let values = (0..mesh.vertices().len()).map(|v| [v as f64 / 256.0, 0.25]).collect();
    let mut file = MeshFile::from(mesh);
    file.uv = Some(Attribute { values, corners: None });
    file
}

/// A folder with this mesh in it.
fn with(name: &str, file: &MeshFile) -> Folder {
    let folder = Folder::new();
    let output = Output::create(&folder.path(name), Overwrite::Never).unwrap();
    io::write(output, file).unwrap();
    folder
}

#[test]
fn a_repair_reports_each_step_and_the_result() {
    let folder = with("split.ply", &split_sphere());
    let said = folder.succeed("mesh split.ply --repair --check -o whole.obj");
    let lines = [
        "vertices    151",
        "weld        37 vertices joined along seams",
        "duplicates  0 repeated faces dropped",
        "degenerate  faces without area: 0 vertices joined with one in the same place, 0 edges \
         flipped, 0 faces dropped",
        "compact     0 vertices without a face dropped",
        "cut         0 edges of more than two faces, 0 vertices split",
        "orient      0 faces flipped",
        "repaired    split.ply",
        "vertices    114",
        "genus       0",
        "written     whole.obj: 114 vertices, 224 faces",
    ];
    let mut rest = said.lines();
    for line in lines {
        assert!(rest.any(|said| said == line), "{line:?} in {said}");
    }
    // The texture is that of the corners now.
    let [before, after] = ["split.ply", "whole.obj"].map(|n| io::read(&folder.path(n)).unwrap());
    for f in 0..224 {
        let of_face = |file: &MeshFile| file.uv.as_ref().unwrap().of_face(&file.mesh, f);
        assert_eq!(of_face(&before), of_face(&after), "{f}");
    }
    // A mesh that is whole is not reported twice.
    let said = folder.succeed("mesh whole.obj --repair");
    assert!(!said.contains("repaired"), "{said}");
}

#[test]
fn repairs_are_done_one_by_one_and_in_one_order() {
    let folder = Folder::new();
    // Two tetrahedra, the second without a face and with one twice; a face without area.
    folder.write(
        "broken.off",
        "OFF\n11 11 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n9 9 9\n5 0 0\n6 0 0\n5 1 0\n5 0 1\n0 0 0\n\
         .5 0 0\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n3 5 7 6\n3 5 6 8\n3 5 8 7\n3 7 5 8\n\
         3 0 1 10\n3 9 1 2\n3 9 2 1\n",
    );
    for (flags, line) in [
        ("--weld", "weld        1 vertices joined (equal positions)"),
        ("--weld 0.6", "weld        2 vertices joined (at most 0.6 apart), 1 faces collapsed"),
        ("--drop-duplicates", "duplicates  2 repeated faces dropped"),
        ("--weld --drop-duplicates", "duplicates  3 repeated faces dropped"),
        (
            "--drop-degenerate",
            "degenerate  faces without area: 0 vertices joined with one in the same place, 0 edges \
             flipped, 1 faces dropped",
        ),
        ("--compact", "compact     1 vertices without a face dropped"),
        ("--keep-largest 1", "largest     1 components of 4 faces dropped"),
        (
            "--drop-specks 0",
            "specks      0 components of 0 faces dropped, each below 0 of the area",
        ),
        (
            "--fill-holes 3 --weld --drop-duplicates --drop-degenerate",
            "holes       1 filled by 1 faces, 0 loops left",
        ),
    ] {
        let said = folder.succeed(&format!("mesh broken.off {flags}"));
        assert!(said.lines().any(|said| said == line), "{flags}: {line:?} in {said}");
    }
    let refused = folder.run("mesh broken.off --weld=-1");
    assert_eq!(refused.code, Some(2));
    let why = "expected a length of at least 0, or `seams`";
    assert!(refused.stderr.contains(why), "{}", refused.stderr);
}

#[test]
fn two_meshes_are_compared() {
    let folder = with("a.ply", &families::icosphere(3).unwrap().into());
    let (points, faces) = families::icosphere(3).unwrap().into_parts();
    let raised = points.iter().map(|p| p.map(|x| 1.25 * x)).collect();
    let output = Output::create(&folder.path("b.ply"), Overwrite::Never).unwrap();
    io::write(output, &TriMesh::new(raised, faces).unwrap().into()).unwrap();
    let said = folder.succeed("mesh a.ply --compare b.ply");
    let found = |label: &str| {
        said.lines().rfind(|line| line.starts_with(label)).expect("a line").to_owned()
    };
    let number = |line: &str, after: &str| -> f64 {
        let rest = line.split_once(after).unwrap().1.trim_start();
        rest.split([' ', ',']).next().unwrap().parse().unwrap()
    };
    for label in ["to other", "from other"] {
        let line = found(label);
        let far = number(&line, "largest distance");
        assert!((0.24..=0.25).contains(&far), "{line}");
        assert!((0.23..=0.25).contains(&number(&line, "mean")), "{line}");
        assert!(number(&line, "normals") < 5.0, "{line}");
    }
    assert!(found("Hausdorff").contains("of the longest side"), "{said}");
    assert!(found("faces").split_whitespace().eq(["faces", "1280", "1280"]), "{said}");
    assert!(found("genus").split_whitespace().eq(["genus", "0", "0"]), "{said}");
    let same = folder.succeed("mesh a.ply --compare a.ply");
    let line = same.lines().find(|line| line.starts_with("Hausdorff")).unwrap();
    assert!(number(line, "Hausdorff") < 1e-14, "{line}");
}

/// What a command says on stderr.
fn notes(folder: &Folder, arguments: &str) -> String {
    let output = folder.program().args(arguments.split_whitespace()).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{arguments}: {said}");
    said
}

#[test]
fn every_command_joins_a_split_surface_and_says_so() {
    let folder = with("split.ply", &split_sphere());
    for arguments in [
        "spectrum split.ply -k 4",
        "decimate split.ply -n 60 -o d.ply --force",
        "farthest split.ply -n 5 -o f.csv --force",
        "filter split.ply --low-pass 9 -k 12 -o s.ply --force",
        "basis split.ply -k 4 -o b.npz --force",
        "shapedna split.ply split.ply -k 4",
    ] {
        let said = notes(&folder, arguments);
        for note in [
            "note: split.ply: 37 vertices joined along seams\n",
            "note: split.ply: vertex numbers refer to the repaired mesh, which has 114 vertices; \
             `catamaran mesh split.ply --weld seams -o FILE` writes it\n",
        ] {
            assert!(said.contains(note), "{arguments}: {note:?} in {said}");
        }
        let strict = folder.fail(&format!("{arguments} --strict"));
        let refused = "split.ply: 37 vertices coincide with others along seams: vertex 16 \
                       with vertex 0 (--strict)";
        assert!(strict.contains(refused), "{arguments}: {strict}");
    }
    // The mesh that the note names is the one that commands work on, and needs no repair.
    folder.succeed("mesh split.ply --weld seams -o joined.ply");
    let smooth = |name: &str, out: &str| {
        let arguments = format!("filter {name} --low-pass 9 -k 12 --threads 1 -o {out} --force");
        let said = notes(&folder, &arguments);
        (io::read(&folder.path(out)).unwrap().mesh, said)
    };
    let (split, _) = smooth("split.ply", "s.ply");
    let (joined, said) = smooth("joined.ply", "j.ply");
    assert_eq!(split, joined);
    assert!(!said.contains("note:"), "{said}");
    folder.succeed("farthest joined.ply -n 5 -o f.csv --force --strict");
    let chosen = notes(&folder, "farthest split.ply -n 5 -o f.csv --force --weld 1e-9");
    assert!(chosen.contains("37 vertices joined (at most 0.000000001 apart)"), "{chosen}");
}

#[test]
fn sizes_at_which_areas_overflow_or_vanish_are_refused_by_every_command() {
    let folder = Folder::new();
    let (points, faces) = families::icosphere(2).unwrap().into_parts();
    let write = |name: &str, points: Vec<[f64; 3]>| {
        let output = Output::create(&folder.path(name), Overwrite::Never).unwrap();
        io::write(output, &TriMesh::new(points, faces.clone()).unwrap().into()).unwrap();
    };
    let scaled = |by: f64| points.iter().map(|p| p.map(|x| x * by)).collect::<Vec<_>>();
    let mut one = points.clone();
    one[5][0] = 1e308;
    write("one.ply", one);
    write("huge.ply", scaled(1e160));
    write("tiny.ply", scaled(1e-160));
    for (name, why) in [
        ("one", "one.ply: vertex 5: position [1e308, "),
        ("huge", "huge.ply: vertex 0: position ["),
        ("tiny", "tiny.ply: mesh: the longest side of its bounding box, "),
    ] {
        for arguments in [
            "mesh NAME.ply --check",
            "mesh NAME.ply --repair -o x.ply",
            "spectrum NAME.ply -k 4",
            "farthest NAME.ply -n 5 -o x.csv",
            "decimate NAME.ply -n 60 -o x.ply --strict",
            "shapedna NAME.ply NAME.ply -k 4",
        ] {
            let refused = folder.fail(&arguments.replace("NAME", name));
            assert!(refused.contains(why) && refused.contains("out of range"), "{refused}");
        }
    }
    // Coordinates that are nearly zero are no size.
    let mut near = points.clone();
    near.iter_mut().find(|p| p[0].abs() < 1e-9).unwrap()[0] = 1e-160;
    write("near.ply", near);
    folder.succeed("mesh near.ply --check");
}

#[test]
fn a_mesh_of_any_size_is_normalized_as_its_error_hints() {
    let folder = Folder::new();
    let (points, faces) = families::icosphere(2).unwrap().into_parts();
    for by in [1e-160, 1e160] {
        let scaled = points.iter().map(|p| p.map(|x| x * by)).collect();
        let output = Output::create(&folder.path("far.ply"), Overwrite::Replace).unwrap();
        io::write(output, &TriMesh::new(scaled, faces.clone()).unwrap().into()).unwrap();
        let refused = folder.fail("mesh far.ply --repair");
        let hint = "; `catamaran mesh far.ply --normalize box -o FILE` scales it\n";
        assert!(refused.ends_with(hint), "{refused}");
        for size in ["box", "area"] {
            let line = format!("mesh far.ply --normalize {size} --repair -o near.ply --force");
            let run = folder.run(&line);
            assert_eq!(run.code, Some(0), "{}", run.stderr);
            assert!(
                run.stderr.contains("note: far.ply: ") && run.stderr.contains("scaled to a box")
            );
            let report = folder.succeed("mesh near.ply --check");
            let area = report.lines().find_map(|line| line.strip_prefix("area")).unwrap();
            let error = (area.trim().parse::<f64>().unwrap() - 1.0).abs();
            assert!(size == "box" || error < 1e-13, "{report}");
        }
    }
}

#[test]
fn a_tolerance_has_the_unit_of_the_file_whatever_its_size() {
    let folder = Folder::new();
    let soup = families::soup(&families::icosphere(1).unwrap()).unwrap();
    for by in [1e-160, 1e-3, 1.0, 1e160] {
        let points = soup.vertices().iter().map(|p| p.map(|x| x * by)).collect();
        let output = Output::create(&folder.path("far.ply"), Overwrite::Replace).unwrap();
        io::write(output, &TriMesh::new(points, soup.faces().to_vec()).unwrap().into()).unwrap();
        for size in ["box", "area"] {
            // Edges are half as long as the radius, and longer.
            let weld = format!("--weld {:e}", 0.4 * by);
            let line = format!("mesh far.ply {weld} --normalize {size} -o near.ply --force");
            let report = folder.succeed(&line);
            assert!(report.ends_with("near.ply: 42 vertices, 80 faces\n"), "{line}: {report}");
        }
    }
}

#[test]
fn options_that_leave_nothing_are_named_and_nothing_is_written() {
    let folder = Folder::new();
    folder.write("two.off", TWO);
    folder.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    folder.write("cloud.obj", "v 0 0 0\nv 1 0 0\nv 2 1 0\n");
    folder.write("a.csv", "1,2\n3,4\n");
    let none = "leaves none of the";
    for (arguments, why) in [
        ("mesh two.off --weld 1e300 -o x", format!("two.off: --weld: {none} 8 faces")),
        ("mesh two.off --drop-specks .6 -o x", format!("two.off: --drop-specks: {none} 8 faces")),
        ("mesh flat.obj --drop-degenerate -o x", format!("flat.obj: --drop-degenerate: {none} 1")),
        (
            "mesh flat.obj --repair -o x",
            format!("flat.obj: --repair, which implies --drop-degenerate: {none} 1 faces"),
        ),
        ("mesh cloud.obj --compact -o x", format!("cloud.obj: --compact: {none} 3 vertices")),
        ("spectrum two.off --weld 1e300", format!("two.off: --weld: {none} 8 faces")),
        (
            "farthest two.off -n 1 --drop-specks 0.6 -o x",
            format!("two.off: --drop-specks: {none} 8 faces"),
        ),
        (
            "distance flat.obj --from 0 -o x",
            format!("flat.obj: the removal of faces without area {none} 1 faces"),
        ),
        (
            "shapedna two.off -k 4 --nearest 0",
            "--nearest 0: lists nothing, which is for --signatures, --distances and --fit-m".into(),
        ),
    ] {
        let end = if arguments.starts_with("mesh") { ".ply" } else { ".csv" };
        let refused = folder.fail(&arguments.replace("-o x", &format!("-o x{end}")));
        assert!(refused.contains(&why), "{arguments}: {refused}");
        assert!(!folder.path(&format!("x{end}")).exists(), "{arguments}");
    }
    for arguments in [
        "mesh two.off --keep-largest 0 -o x.ply",
        "mesh two.off --drop-specks 1.5 -o x.ply",
        "spectrum two.off -k 0",
        "filter two.off --low-pass 0 -o x.ply",
        "filter two.off --band 3..3 -o x.ply",
        "ata a.csv --columns 1..1 -o x.csv",
    ] {
        let run = folder.run(arguments);
        assert_eq!(run.code, Some(2), "{arguments}: {}", run.stderr);
        assert!(run.stderr.contains("expected "), "{arguments}: {}", run.stderr);
    }
}

#[test]
fn a_soup_is_resampled_after_it_is_repaired() {
    let soup = families::soup(&families::torus(24, 12, 2.0, 0.7).unwrap()).unwrap();
    let folder = with("soup.ply", &soup.into());
    let said = folder.succeed("decimate soup.ply -n 400 -o d.ply");
    assert!(said.contains("topology    components 1, boundary loops 0, genus 1\n"), "{said}");
}

#[test]
fn faces_that_have_a_vertex_twice_are_a_problem_of_the_report() {
    let folder = Folder::new();
    folder.write("twice.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 2 2 3\nf 1 1 1\n");
    let said = folder.succeed("mesh twice.obj");
    let line = "problem     faces that have a vertex twice: 2 (left out, the first at line 5)\n";
    assert!(said.contains(line), "{said}");
    let records = folder.succeed("mesh twice.obj --json");
    let problem = "{\"faces\":2,\"first\":\"line 5\",\"kind\":\"collapsed_faces\"}";
    assert!(records.contains(problem), "{records}");
    assert!(folder.fail("mesh twice.obj --check").contains("problems found: 1"));
    // What is written has none.
    folder.succeed("mesh twice.obj --repair --check -o once.obj");
    assert!(folder.succeed("mesh once.obj --check").contains("problems    none"));
}

#[test]
fn repeated_faces_and_faces_without_area_are_dropped_with_a_note() {
    let (mut points, mut faces) = families::icosphere(2).unwrap().into_parts();
    faces.push(faces[5]);
    let [a, b, c] = faces[0];
    let [p, q] = [a, b].map(|v| points[v as usize]);
    let m = points.len() as u32;
    points.push([0, 1, 2].map(|k| 0.5 * p[k] + 0.5 * q[k]));
    faces[0] = [a, m, c];
    faces.extend([[m, b, c], [a, b, m]]);
    let folder = with("broken.ply", &TriMesh::new(points, faces).unwrap().into());
    let said = notes(&folder, "spectrum broken.ply -k 4");
    assert!(said.contains("note: broken.ply: 1 repeated faces dropped\n"), "{said}");
    assert!(
        said.contains("0 vertices joined with one in the same place, 1 edges flipped"),
        "{said}"
    );
    assert!(!said.contains("vertex numbers"), "{said}");
    let refused = folder.fail("spectrum broken.ply -k 4 --strict");
    assert!(refused.contains("1 repeated faces: face 320 has the vertices of face 5"), "{refused}");
}

#[test]
fn surfaces_from_other_programs_are_repaired() {
    let Some(suzanne) = crate::inputs::data("meshes/suzanne_499components.ply.gz") else { return };
    let folder = Folder::new();
    let said = folder.succeed(&format!("decimate {} -n 300 -o d.ply", suzanne.display()));
    assert!(said.contains("topology    components 3, boundary loops 4"), "{said}");
}

/// A sphere of this radius around a place in UTM coordinates.
fn far_sphere(radius: f64) -> MeshFile {
    let (points, faces) = families::icosphere(3).unwrap().into_parts();
    let center = [691_608.37, 5_334_764.91, 519.25];
    let place = |p: [f64; 3]| [0, 1, 2].map(|k| radius * p[k] + center[k]);
    TriMesh::new(points.into_iter().map(place).collect(), faces).unwrap().into()
}

#[test]
fn every_command_that_writes_single_precision_says_how_far_vertices_move() {
    let file = far_sphere(50.0);
    let volume = file.mesh.volume().unwrap();
    let folder = with("far.ply", &file);
    for arguments in [
        "mesh far.ply -o a.stl",
        "decimate far.ply -n 100 -o b.stl",
        "filter far.ply --low-pass 9 -k 12 -o c.stl",
    ] {
        let said = notes(&folder, arguments);
        let note = ".stl: rounded coordinates to single precision: vertices move by up to ";
        assert!(said.contains(note), "{arguments}: {said}");
    }
    let said = notes(&folder, "mesh far.ply -o text.stl --text");
    assert_eq!(said, "");
    let text = io::read(&folder.path("text.stl")).unwrap().mesh.volume().unwrap();
    assert!((text / volume - 1.0).abs() < 1e-12, "{text}");
    let glb = folder.succeed("mesh far.ply -o far.glb");
    assert!(glb.contains("written     far.glb"), "{glb}");
    let glb = io::read(&folder.path("far.glb")).unwrap().mesh.volume().unwrap();
    assert!((glb / volume - 1.0).abs() < 1e-6, "{glb}");
    let refused = folder.fail("mesh far.ply -o no.glb --text");
    assert!(refused.contains("no.glb: --text: this format has no text"), "{refused}");
}

#[test]
fn faces_that_would_vanish_are_not_written() {
    let folder = with("tiny.ply", &far_sphere(1e-3));
    let refused = folder.fail("mesh tiny.ply -o tiny.stl");
    assert!(refused.contains("tiny.stl: 1280 of 1280 faces vanish"), "{refused}");
    assert!(refused.contains("`catamaran mesh --text`"), "{refused}");
    assert!(!folder.path("tiny.stl").exists());
    folder.succeed("mesh tiny.ply -o tiny.stl --text");
}

#[test]
fn what_a_reader_leaves_out_of_gltf_is_a_note() {
    let folder = Folder::new();
    let gltf = r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "skin": 0, "scale": [9, 9, 9]}], "skins": [{"joints": [0]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 1,
        "extensions": {"FOO_bar": {}}}]}]}"#;
    folder.write("a.gltf", gltf);
    let said = notes(&folder, "mesh a.gltf");
    for note in [
        "note: a.gltf: left out the extension FOO_bar, which is not supported: 1, the first at \
         mesh 0, primitive 0\n",
        "note: a.gltf: read skinned meshes as they are modelled, without the pose of their joints",
        "note: a.gltf: left out primitives of lines: 1, the first at mesh 0, primitive 0\n",
    ] {
        assert!(said.contains(note), "{said}");
    }
    folder.write(
        "b.gltf",
        gltf.replace("\"scenes\"", "\"extensionsRequired\": [\"FOO_bar\"], \"scenes\""),
    );
    let refused = folder.fail("mesh b.gltf");
    assert!(refused.contains("b.gltf: requires the extension FOO_bar"), "{refused}");
}

#[test]
fn the_commands_of_the_guide_run() {
    let guide = include_str!("../../../docs/guide/broken-mesh.md");
    let folder = with("broken.ply", &split_sphere());
    let output = Output::create(&folder.path("original.ply"), Overwrite::Never).unwrap();
    io::write(output, &families::icosphere(3).unwrap().into()).unwrap();
    for line in calls(guide) {
        folder.succeed(&format!("{line}{}", if line.contains(" -o ") { " --force" } else { "" }));
    }
}

/// A soup of triangles: each face of a sphere of 1,280 with vertices of its own, `apart` from where
/// they belong in units of the sphere's radius.
fn soup(apart: f64) -> TriMesh {
    let sphere = families::icosphere(3).unwrap();
    let mut number = 0_u32;
    let corner = |v: &u32| {
        // A golden ratio of the way around, so that no two are alike.
        number += 1;
        let shift = apart * (f64::from(number) * 0.618_034).fract();
        sphere.vertices()[*v as usize].map(|x| x * (1.0 + shift))
    };
    let points: Vec<_> = sphere.faces().as_flattened().iter().map(corner).collect();
    let faces = (0..sphere.faces().len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]);
    TriMesh::new(points, faces.collect()).unwrap()
}

#[test]
fn loose_triangles_are_a_problem_and_the_option_that_helps_is_named() {
    let folder = Folder::new();
    let whole =
        |report: &str| report.contains("components  1\n") && report.contains("problems    none");
    for (name, apart) in [("exact", 0.0), ("rounded", 1e-7), ("torn", 1e-2)] {
        let output = Output::create(&folder.path(&format!("{name}.ply")), Overwrite::Never);
        io::write(output.unwrap(), &soup(apart).into()).unwrap();
        let report = folder.succeed(&format!("mesh {name}.ply"));
        assert!(!report.contains("problems    none"), "{name}: {report}");
        assert!(folder.fail(&format!("mesh {name}.ply --check")).contains("problems found"));
        // An option that is named in full helps.
        let option = report.split_whitespace().find(|word| word.starts_with("--weld")).unwrap();
        // How far the corners of a torn mesh are apart is not in the file.
        let option = if name == "torn" { "--weld=0.03" } else { option };
        let welded = folder.succeed(&format!("mesh {name}.ply {option}"));
        let after = welded.rsplit("repaired").next().unwrap();
        assert!(whole(after), "{name} {option}: {welded}");
        // Whether --repair joined them or not, the report says what they are then.
        let repaired = folder.succeed(&format!("mesh {name}.ply --repair"));
        let after = repaired.rsplit("repaired").next().unwrap();
        assert_eq!(after.contains("problems    none"), apart == 0.0, "{name}: {repaired}");
    }
}

#[test]
fn no_tolerance_is_advised_that_would_join_the_ends_of_an_edge() {
    let folder = Folder::new();
    // Two squares of this size, each of two triangles, with a gap of a thousandth between them.
    let torn = |size: f64| -> Vec<[f64; 3]> {
        let gap = size * 9e-4;
        [[0.0, 0.0], [size, 0.0], [size, size], [size, gap], [size, size + gap], [0.0, size]]
            .map(|[x, y]| [x, y, size])
            .into()
    };
    let write = |name: &str, sizes: &[f64]| {
        let mut text = String::new();
        for (k, &size) in sizes.iter().enumerate() {
            torn(size).iter().for_each(|[x, y, z]| text += &format!("v {x} {y} {z}\n"));
            let at = 6 * k;
            text += &format!(
                "f {} {} {}\nf {} {} {}\n",
                at + 1,
                at + 2,
                at + 3,
                at + 4,
                at + 5,
                at + 6
            );
        }
        folder.write(name, text);
        folder.succeed(&format!("mesh {name}"))
    };
    assert!(write("torn.obj", &[1.0]).contains("option      --weld=1e-3 "));
    // The gap of the large one is longer than the edges of the small one.
    let report = write("both.obj", &[1000.0, 0.01]);
    assert!(report.contains("option      --weld=TOLERANCE "), "{report}");
}

#[test]
fn components_that_are_inside_out_are_a_problem_until_they_are_oriented() {
    let sphere = families::icosphere(1).unwrap();
    // A small sphere within, and one beside, which faces the wrong side.
    let (mut points, mut faces) = sphere.clone().into_parts();
    for (scale, shift, is_turned) in [(0.5, 0.0, false), (1.0, 5.0, true)] {
        let first = points.len() as u32;
        points.extend(
            sphere.vertices().iter().map(|&[x, y, z]| [scale * x + shift, scale * y, scale * z]),
        );
        faces.extend(sphere.faces().iter().map(|face| {
            let [a, b, c] = face.map(|v| first + v);
            if is_turned { [a, c, b] } else { [a, b, c] }
        }));
    }
    let folder = with("three.ply", &TriMesh::new(points, faces).unwrap().into());
    let report = folder.succeed("mesh three.ply");
    for line in [
        "problem     closed components that are inside out: 2 (that of face 80; that of face 160)",
        "option      --orient flips the faces of components that are inside out",
    ] {
        assert!(report.lines().any(|said| said == line), "{report}");
    }
    let records = folder.succeed("mesh three.ply --json");
    assert!(records.contains("{\"face\":80,\"kind\":\"inside_out\"}"), "{records}");
    assert!(folder.fail("mesh three.ply --check").contains("problems found: 2"));
    let report = folder.succeed("mesh three.ply --orient --check");
    assert!(report.contains("\norient      160 faces flipped\n"), "{report}");
    assert!(report.contains("\nproblems    none\n"), "{report}");
}

#[test]
fn every_problem_names_an_option_that_removes_it() {
    let folder = Folder::new();
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    for (name, text, option) in [
        ("alone", format!("{square}f 1 2 3\n"), "--compact"),
        ("twice", format!("{square}f 1 2 3 4\nf 2 3 1\n"), "--drop-duplicates"),
        ("turned", format!("{square}f 1 2 3\nf 1 4 3\n"), "--orient"),
        ("split", format!("{square}v 0 0 0\nv 1 1 0\nf 1 2 3\nf 5 6 4\n"), "--weld"),
        ("flat", format!("{square}v 0.5 0 0\nf 1 5 2\nf 1 2 3 4\n"), "--drop-degenerate"),
        ("pages", format!("{square}v 0 0 1\nf 1 2 3\nf 2 1 4\nf 1 2 5\n"), "--repair"),
        (
            "inward",
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n".into(),
            "--orient",
        ),
    ] {
        folder.write(&format!("{name}.obj"), text);
        let report = folder.succeed(&format!("mesh {name}.obj"));
        assert!(report.contains(&format!("option      {option} ")), "{name}: {report}");
        folder.succeed(&format!("mesh {name}.obj {option} -o {name}-mended.obj --check"));
    }
    // What has no problem needs no option.
    folder.write("square.obj", SQUARE);
    assert!(!folder.succeed("mesh square.obj").contains("option "));
}

#[test]
fn generated_meshes_are_those_of_the_library_by_their_names() {
    let folder = Folder::new();
    for (line, mesh) in [
        ("icosphere 1", families::icosphere(1)),
        ("torus 12 6 2 0.5", families::torus(12, 6, 2.0, 0.5)),
        ("knot 2 3 40 6 0.2", families::knot(2, 3, 40, 6, 0.2)),
        ("genus 2 1", families::genus(2, 1)),
        ("figure 1 0.5", families::figure(1, 0.5)),
        ("grid 3 2", families::grid(3, 2)),
        ("disk 2 5", families::disk(2, 5)),
        ("cylinder 6 2 1 3", families::cylinder(6, 2, 1.0, 3.0)),
        ("terrain 4 3 7", families::terrain(4, 3, 7)),
    ] {
        folder.succeed(&format!("generate {line} -o a.ply --force"));
        assert_eq!(io::read(&folder.path("a.ply")).unwrap().mesh, mesh.unwrap(), "{line}");
    }
    for (line, says) in [
        ("torus 12 6 -o x.ply", "torus: needs AROUND TUBE MAJOR MINOR, and 2 numbers are given"),
        ("icosphere -o x.ply", "icosphere: needs SUBDIVISIONS, and 0 numbers are given"),
        ("grid 1.5 2 -o x.ply", "grid: COLUMNS must be a whole number of at least 0, is 1.5"),
        ("terrain 2 2 -1 -o x.ply", "SEED must be a whole number of at least 0, is -1"),
        ("figure 1 2 -o x.ply", "pose"),
        ("grid 2 2 -o x.doc", "x.doc"),
        ("grid 2 2 -o a.ply", "exists already"),
    ] {
        let said = folder.fail(&format!("generate {line}"));
        assert!(said.contains(says), "{line}: {said}");
    }
    let help = folder.succeed("generate --help");
    assert!(help.contains("AROUND ALONG RADIUS HEIGHT"), "{help}");
    let words: Vec<&str> = help.split_whitespace().collect();
    let help = words.join(" ");
    assert!(help.contains("ALONG of a cylinder is the number of rings of cells"), "{help}");
}

#[test]
fn points_in_other_units_than_the_mesh_are_noted() {
    let folder = Folder::new();
    folder.write("square.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    let note = |point: &str| {
        let mut command = folder.program();
        command.args(["distance", "square.obj", "--from", point, "-o", "d.csv", "--force"]);
        let run = command.output().unwrap();
        assert!(run.status.success(), "{run:?}");
        String::from_utf8(run.stderr).unwrap()
    };
    assert_eq!(note("1.05 1.05 0"), "");
    let said = "note: --from: 300 400 0 is 4.986e2 from the mesh, and stands for vertex 2";
    assert!(note("300 400 0").starts_with(said), "{}", note("300 400 0"));
}
