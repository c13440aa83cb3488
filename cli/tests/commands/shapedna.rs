//! `catamaran shapedna` and `catamaran unions dataset`, from outside.

use std::collections::HashMap;

use catamaran::io::{Output, Overwrite};
use catamaran_geometry::mesh::{TriMesh, families, io};

use crate::common::Folder;

fn write(folder: &Folder, name: &str, mesh: TriMesh) {
    let output = Output::create(&folder.path(name), Overwrite::Never).unwrap();
    io::write(output, &mesh.into()).unwrap();
}

#[test]
fn a_pose_is_nearest_to_its_figure_and_tables_are_written() {
    let folder = Folder::new();
    write(&folder, "rest.ply", families::figure(2, 0.0).unwrap());
    write(&folder, "posed.ply", families::figure(2, 0.7).unwrap());
    write(&folder, "sphere.ply", families::icosphere(3).unwrap());
    write(&folder, "torus.ply", families::torus(40, 20, 2.0, 0.7).unwrap());
    let said = folder.succeed(
        "shapedna sphere.ply torus.ply rest.ply --query posed.ply --signatures s.csv --distances d.csv",
    );
    let nearest = said.lines().nth(1).unwrap();
    assert!(said.starts_with("posed.ply") && nearest.ends_with("rest.ply"), "{said}");
    let read = |name| std::fs::read_to_string(folder.path(name)).unwrap();
    let rows = |text: String| text.lines().map(|line| line.split(',').count()).collect::<Vec<_>>();
    assert_eq!(rows(read("s.csv")), [20; 4]);
    assert_eq!(rows(read("d.csv")), [4; 4]);
    let each = folder.succeed("shapedna sphere.ply torus.ply rest.ply posed.ply --nearest 1 -k 8");
    assert_eq!(each.lines().count(), 8);
    let refused = folder.fail("shapedna sphere.ply --signatures s.csv");
    assert!(refused.contains("exists already"), "{refused}");
}

/// The cube of LaPy's tests (data/cubeTria.vtk): 20 x 20 squares a side, cut along one diagonal.
fn cube_of_lapy() -> TriMesh {
    const SIDE: u32 = 20;
    let mut numbers: HashMap<Vec<u32>, u32> = HashMap::new();
    let (mut points, mut faces) = (Vec::new(), Vec::new());
    for (axis, side) in [0, 1, 2].into_iter().flat_map(|axis| [(axis, 0), (axis, SIDE)]) {
        for (i, j) in (0..SIDE).flat_map(|i| (0..SIDE).map(move |j| (i, j))) {
            let corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
            let [a, b, c, d] = corners.map(|place| {
                let mut place = place.to_vec();
                place.insert(axis, side);
                let next = points.len() as u32;
                let number = *numbers.entry(place.clone()).or_insert(next);
                if number == next {
                    points.push([0, 1, 2].map(|k| f64::from(place[k]) / f64::from(SIDE)));
                }
                number
            });
            let cut = if axis == 0 { [[a, b, d], [b, c, d]] } else { [[a, b, c], [a, c, d]] };
            let inwards = (side == 0) != (axis == 1);
            faces.extend(cut.map(|[a, b, c]| if inwards { [a, c, b] } else { [a, b, c] }));
        }
    }
    TriMesh::new(points, faces).unwrap()
}

#[test]
fn surfaces_of_freesurfer_and_gifti_have_the_eigenvalues_that_lapy_stores() {
    let folder = Folder::new();
    let cube = cube_of_lapy();
    let mut surface = b"\xff\xff\xfecreated by a test\n\n".to_vec();
    for count in [cube.vertices().len(), cube.faces().len()] {
        surface.extend((count as u32).to_be_bytes());
    }
    let positions = cube.vertices().as_flattened().iter();
    surface.extend(positions.flat_map(|&x| (x as f32).to_be_bytes()));
    surface.extend(cube.faces().as_flattened().iter().flat_map(|v| v.to_be_bytes()));
    folder.write("lh.white", surface);
    write(&folder, "cube.gii", cube);
    // LaPy, lapy/utils/tests/expected_outcomes.json: test_compute_shapedna, and by the area. They
    // are of single precision: the first, which is zero, tells how far they are all moved.
    let stored = [-4.0165149e-5, 4.169641, 4.1704664];
    let by_area = [-0.00024099089, 25.017845, 25.022799];
    let same = |found: &[f64], stored: [f64; 3], what: &str| {
        assert!(found[0].abs() < 1e-9, "{what}: {found:?}");
        for (found, stored) in found.iter().zip(stored.map(|x| x - stored[0])).skip(1) {
            assert!((found / stored - 1.0).abs() < 1e-5, "{what}: {found}, {stored}");
        }
    };
    for name in ["lh.white", "cube.gii"] {
        folder.succeed(&format!("spectrum {name} -k 3 --mass full -o s.npz --force"));
        same(&folder.read_npz("s.npz", "eigenvalues").1, stored, name);
    }
    let table = "--signatures s.csv --nearest 0 --force";
    for (option, stored) in [("", by_area), (" --sized", stored)] {
        folder.succeed(&format!("shapedna lh.white cube.gii -k 3 --mass full{option} {table}"));
        for row in std::fs::read_to_string(folder.path("s.csv")).unwrap().lines() {
            let found: Vec<f64> = row.split(',').map(|word| word.parse().unwrap()).collect();
            same(&found, stored, option);
        }
    }
}

#[test]
fn what_has_too_few_vertices_is_named() {
    let folder = Folder::new();
    write(&folder, "small.ply", families::icosphere(0).unwrap());
    let refused = folder.fail("shapedna small.ply small.ply -k 100");
    assert!(refused.contains("small.ply") && refused.contains("100 eigenpairs"), "{refused}");
}

#[test]
fn one_mesh_has_a_signature_but_no_neighbors() {
    let folder = Folder::new();
    write(&folder, "one.ply", families::icosphere(2).unwrap());
    let refused = folder.fail("shapedna one.ply -k 4");
    assert!(refused.contains("one.ply: one mesh has no neighbors"), "{refused}");
    folder.succeed("shapedna one.ply -k 4 --signatures s.csv");
}

#[test]
fn point_clouds_are_refused_by_name() {
    let folder = Folder::new();
    folder.write("cloud.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    for command in
        ["shapedna cloud.obj cloud.obj -k 1", "descriptors cloud.obj --kind hks -o d.npy"]
    {
        let said = folder.fail(command);
        assert!(said.contains("cloud.obj: has no faces; `catamaran spectrum`"), "{said}");
    }
}

#[test]
fn what_a_reader_leaves_out_is_noted() {
    let folder = Folder::new();
    write(&folder, "whole.obj", families::icosphere(1).unwrap());
    let text = std::fs::read_to_string(folder.path("whole.obj")).unwrap();
    folder.write("twice.obj", text + "f 1 1 2\n");
    let run = folder.run("shapedna whole.obj twice.obj -k 5");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let note = "note: twice.obj: left out triangles that have a vertex twice: 1";
    assert!(run.stderr.contains(note), "{}", run.stderr);
    let refused = folder.run("shapedna whole.obj twice.obj -k 5 --strict").stderr;
    assert!(refused.contains("facets with two equal corners: 1 (--strict)"), "{refused}");
}

/// A torus with a tube of this radius, stretched along its axis.
fn stretched(radius: f64, factor: f64) -> TriMesh {
    let mesh = families::torus(24, 12, 2.0, radius).unwrap();
    let vertices = mesh.vertices().iter().map(|&[x, y, z]| [x, y, factor * z]).collect();
    TriMesh::new(vertices, mesh.faces().to_vec()).unwrap()
}

/// Two shapes, each stretched four times, their labels, and another one of each.
fn shapes() -> Folder {
    let folder = Folder::new();
    let mut labels = String::new();
    for (shape, radius, query) in [("thin", 0.6, 1.18), ("thick", 0.68, 0.9)] {
        for (i, factor) in [0.8, 0.95, 1.1, 1.25].into_iter().enumerate() {
            write(&folder, &format!("{shape}{i}.off"), stretched(radius, factor));
            labels += &format!("{shape}\n");
        }
        write(&folder, &format!("{shape}.off"), stretched(radius, query));
    }
    folder.write("labels.txt", labels);
    folder
}

/// The meshes of [`shapes`] in the order of their labels.
const ALL: &str = "thin0.off thin1.off thin2.off thin3.off thick0.off thick1.off thick2.off \
                   thick3.off";

#[test]
fn a_fitted_metric_finds_the_shape_that_deformations_hide() {
    let folder = shapes();
    let fit = format!("shapedna {ALL} -k 6 --labels labels.txt --fit-metric");
    let said = folder.succeed(&format!("{fit} m.json --poses-only"));
    assert!(said.contains("m.json: fitted to 8 meshes, 6 eigenvalues"), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    for shape in ["thin", "thick"] {
        let search = format!("shapedna {ALL} --query {shape}.off -k 6");
        let nearest = |said: &str| {
            let lines = said.lines().skip(1).map(|line| line.split(' ').next_back().unwrap());
            lines.map(str::to_owned).collect::<Vec<_>>()
        };
        let found = nearest(&folder.succeed(&format!("{search} --metric m.json --nearest 4")));
        assert_eq!(found.len(), 4);
        assert!(found.iter().all(|name| name.starts_with(shape)), "{shape}: {found:?}");
        // Without the metric, the nearest mesh may be the other shape.
        let euclidean = nearest(&folder.succeed(&format!("{search} --nearest 4")));
        assert!(!euclidean.iter().all(|name| name.starts_with(shape)), "{shape}: {euclidean:?}");
    }
    let table = format!("shapedna {ALL} -k 6 --metric m.json --distances d.csv --nearest 0");
    folder.succeed(&table);
    let rows = std::fs::read_to_string(folder.path("d.csv")).unwrap();
    assert_eq!(rows.lines().count(), 8);
}

#[test]
fn a_metric_is_for_signatures_of_its_kind() {
    let folder = shapes();
    let fit = format!("shapedna {ALL} -k 6 --labels labels.txt --fit-metric m.json --poses-only");
    folder.succeed(&fit);
    let search = "shapedna thin.off thick.off --metric m.json";
    let refused = folder.fail(search);
    assert!(refused.contains("m.json: compares 6 eigenvalues, not 20: give -k 6"), "{refused}");
    for option in ["--sized", "--dirichlet"] {
        let refused = folder.fail(&format!("{search} -k 6 {option}"));
        assert!(refused.contains("m.json: was fitted to \"Neumann eigenvalues"), "{refused}");
    }
    write(&folder, "two.off", families::spheres(2, 1).unwrap());
    let refused = folder.fail("shapedna thin.off two.off --metric m.json -k 6");
    let says = "two.off: 2 eigenvalues are zero, the metric has 1";
    assert!(refused.contains(says), "{refused}");
    let text = std::fs::read_to_string(folder.path("m.json")).unwrap();
    folder.write("newer.json", text.replace("\"version\": 1", "\"version\": 2"));
    folder.write("half.json", &text[..text.len() / 2]);
    for (name, says) in [("newer.json", "has version 2"), ("half.json", "not a metric")] {
        let refused = folder.fail(&format!("shapedna thin.off thick.off -k 6 --metric {name}"));
        assert!(refused.contains(name) && refused.contains(says), "{refused}");
    }
}

#[test]
fn metrics_of_few_shapes_and_wrong_labels_are_refused() {
    let folder = shapes();
    let fit = format!("shapedna {ALL} --fit-metric m.json --labels labels.txt");
    let refused = folder.fail(&format!("{fit} -k 6"));
    assert!(refused.contains("--labels: ") && refused.contains("--poses-only"), "{refused}");
    assert!(refused.contains("at least 13 identities, are of 2"), "{refused}");
    let refused = folder.fail(&format!("{fit} -k 8 --poses-only"));
    assert!(refused.contains("at least 7 poses beside their first ones, have 6"), "{refused}");
    folder.write("few.txt", "a\nb\n");
    folder.write("blank.txt", "a\n\nb\n");
    for (labels, says) in [
        ("few.txt", "few.txt: must have a line for each of the 8 meshes, has 2"),
        ("blank.txt", "blank.txt:2: names no shape"),
    ] {
        let refused = folder.fail(&format!("shapedna {ALL} --fit-metric m.json --labels {labels}"));
        assert!(refused.contains(says), "{refused}");
    }
    let refused = folder.fail(&format!("shapedna {ALL} --fit-metric m.csv --labels labels.txt"));
    assert!(refused.contains("m.csv: the name must end in .json"), "{refused}");
}

#[test]
fn a_data_set_is_the_same_bytes_for_any_number_of_threads() {
    let folder = Folder::new();
    let sizes = "--size small --vertices 800 --known 1 --unknown 0 --others 0 --poses 1 --pairs 6";
    let said = folder.succeed(&format!("unions dataset -o one.npz {sizes} --threads 1"));
    assert!(said.contains("samples ") && said.contains("written "), "{said}");
    folder.succeed(&format!("unions dataset -o two.npz {sizes} --threads 2"));
    let read = |name| std::fs::read(folder.path(name)).unwrap();
    assert!(read("one.npz") == read("two.npz"));
    assert!(!folder.path("one.npz.parts").exists());
    let refused = folder.fail("unions dataset -o one.npz");
    assert!(refused.contains("exists already"), "{refused}");
    let refused = folder.fail("unions dataset -o set.csv");
    assert!(refused.contains(".npz"), "{refused}");
}

#[test]
fn a_data_set_leaves_the_files_of_others() {
    let folder = Folder::new();
    let sizes = "--size small --vertices 800 --known 1 --unknown 0 --others 0 --poses 1 --pairs 6 \
                 --varied 0 --creatures 0";
    // A refused option is named, and does not stand in the way of the next run.
    for (option, says) in [
        ("--vertices 3", "--vertices: must be from 500 to 1000000, is 3"),
        ("--poses 0", "--poses: must be from 1 to 10000, is 0"),
    ] {
        let refused = folder.fail(&format!("unions dataset -o set.npz --size small {option}"));
        assert!(refused.contains(says), "{refused}");
    }
    std::fs::create_dir(folder.path("set.npz.parts")).unwrap();
    folder.write("set.npz.parts/mine.txt", "mine");
    let refused = folder.fail(&format!("unions dataset -o set.npz {sizes}"));
    let says = "set.npz.parts: has mine.txt, but no options.txt";
    assert!(refused.contains(says), "{refused}");
    std::fs::remove_file(folder.path("set.npz.parts/mine.txt")).unwrap();
    folder.succeed(&format!("unions dataset -o set.npz {sizes}"));
    assert!(folder.path("set.npz").exists() && !folder.path("set.npz.parts").exists());
}
