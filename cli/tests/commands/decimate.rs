//! `catamaran decimate` and `catamaran farthest`, from outside.

use std::fs;

use catamaran::io::{Output, Overwrite};
use catamaran_geometry::decimate::{DecimateOptions, decimate};
use catamaran_geometry::mesh::io::{Attribute, MeshFile, Scalars, read, write};
use catamaran_geometry::mesh::{TriMesh, families};

use crate::common::Folder;

fn folder(name: &str, file: &MeshFile) -> Folder {
    let folder = Folder::new();
    let output = Output::create(&folder.path(name), Overwrite::Never).unwrap();
    write(output, file).unwrap();
    folder
}

fn sphere() -> TriMesh {
    families::icosphere(4).unwrap()
}

/// Numbers of the lines of a file that begin with one.
fn numbers(folder: &Folder, name: &str) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(folder.path(name)).unwrap();
    let rows = text.lines().map(|line| {
        line.split([' ', ','])
            .filter(|word| !word.is_empty())
            .map(|word| word.parse().ok())
            .collect::<Option<Vec<f64>>>()
    });
    rows.flatten().filter(|row| !row.is_empty()).collect()
}

#[test]
fn specks_are_told_apart_from_the_rest_or_dropped() {
    let (mut points, mut faces) = sphere().into_parts();
    let first = points.len() as u32;
    points.extend([[5.0, 0.0, 0.0], [5.1, 0.0, 0.0], [5.0, 0.1, 0.0], [5.0, 0.0, 0.1]]);
    let speck = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    faces.extend(speck.map(|face| face.map(|v| first + v)));
    let folder = folder("in.ply", &TriMesh::new(points, faces).unwrap().into());
    let said = folder.succeed("decimate in.ply -n 101 -o all.ply --report");
    assert!(
        said.contains("components 2,") && said.contains("largest     component alone"),
        "{said}"
    );
    let said = folder.succeed("decimate in.ply -n 101 -o one.ply --report --drop-specks 0.01");
    assert!(said.contains("components 1,") && !said.contains("component alone"), "{said}");
    assert_eq!(read(&folder.path("one.ply")).unwrap().mesh.vertices().len(), 101);
}

#[test]
fn a_mesh_has_as_many_vertices_as_are_asked_for_and_a_report() {
    let folder = folder("in.ply", &sphere().into());
    let said = folder.succeed("decimate in.ply -n 101 -o out.obj --report --picture p.png");
    for part in [
        "mesh        in.ply: 2562 vertices, 5120 faces, read in ",
        "decimated   101 vertices, 198 faces, in ",
        "repairs     none\n",
        "topology    components 1, boundary loops 0, genus 0\n",
        "edges with more than two faces: 0\n",
        "Hausdorff   ",
        "written     out.obj\n",
    ] {
        assert!(said.contains(part), "{part:?} in {said}");
    }
    assert!(!said.contains("changed to"), "{said}");
    let made = read(&folder.path("out.obj")).unwrap().mesh;
    assert_eq!((made.vertices().len(), made.faces().len()), (101, 198));
    made.require_manifold().unwrap();
    assert_eq!(&fs::read(folder.path("p.png")).unwrap()[1..4], b"PNG");
    // A part of them, by another number of threads, and literally as the thesis has it.
    for (arguments, vertices) in [
        ("--ratio 0.1 --relax 3 --lloyd 1", 256),
        ("-n 101 --threads 1 --first 7", 101),
        ("-n 40 --method thesis", 40),
        ("-n 4000", 4000),
        // The sphere is closed: 2 n - 4 faces.
        ("--faces 300", 152),
        ("--edge-length 0.35", 118),
    ] {
        folder.succeed(&format!("decimate in.ply {arguments} -o out.stl --force"));
        folder.succeed(&format!("decimate in.ply {arguments} -o out.ply --force"));
        assert_eq!(read(&folder.path("out.ply")).unwrap().mesh.vertices().len(), vertices);
    }
}

#[test]
fn the_report_says_that_the_hausdorff_distance_is_that_of_the_vertices() {
    let folder = folder("in.ply", &sphere().into());
    let said = folder.succeed("decimate in.ply -n 60 -o out.ply --report");
    let line = said.lines().find(|line| line.starts_with("Hausdorff   ")).unwrap();
    assert!(line.contains(" of the vertices, eq. 5.8 as printed "), "{line}");
    let said = folder.succeed("decimate in.ply -n 60 -o out.ply --report --json --force");
    let record = said.lines().find(|line| line.contains("\"record\":\"hausdorff\"")).unwrap();
    assert!(record.contains("\"of_vertices\":") && !record.contains("\"distance\":"), "{record}");
}

#[test]
fn faces_without_area_in_the_result_are_noted() {
    let (points, faces) = families::torus(40, 20, 2.0, 0.8).unwrap().into_parts();
    let flat = points.into_iter().map(|[x, y, _]| [x, y, 0.0]).collect();
    let folder = folder("in.ply", &TriMesh::new(flat, faces).unwrap().into());
    for n in [20, 100, 300] {
        let run = folder.run(&format!("decimate in.ply -n {n} -o out.ply --force"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        let found = read(&folder.path("out.ply")).unwrap().mesh.faces_without_area().len();
        let note =
            format!("note: {found} faces of the result have no area: try another value of -n");
        assert_eq!(run.stderr.contains(&note), found > 0, "{n}: {}", run.stderr);
    }
}

#[test]
fn an_error_sets_the_number_of_vertices_and_the_report_has_the_distance_that_it_bounds() {
    let folder = folder("in.ply", &sphere().into());
    let bound = |said: &str| {
        let line = said.lines().find(|line| line.starts_with("distance ")).unwrap();
        line.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap()
    };
    let said = folder.succeed("decimate in.ply --error 0.03 -o length.ply");
    assert!(bound(&said) <= 0.03 && !said.contains("Hausdorff"), "{said}");
    let few = read(&folder.path("length.ply")).unwrap().mesh;
    assert!(few.vertices().len() < 400, "{said}");
    // The diagonal of the ball's box is 2 sqrt(3).
    let said = folder.succeed("decimate in.ply --error 0.2% -o share.ply --report");
    assert!(bound(&said) <= 0.002 * 12f64.sqrt() && said.contains("Hausdorff"), "{said}");
    assert!(read(&folder.path("share.ply")).unwrap().mesh.vertices().len() > few.vertices().len());
    // A vertex without a face, however far away, makes no percentage larger.
    let (mut vertices, faces) = sphere().into_parts();
    vertices.push([500.0; 3]);
    let stray = MeshFile::from(TriMesh::new(vertices, faces).unwrap());
    let output = Output::create(&folder.path("stray.ply"), Overwrite::Never).unwrap();
    write(output, &stray).unwrap();
    folder.succeed("decimate stray.ply --error 0.2% -o same.ply");
    let [same, share] = ["same.ply", "share.ply"].map(|name| read(&folder.path(name)).unwrap());
    assert_eq!(same.mesh, share.mesh);
    for (arguments, why) in [
        ("--error 0", "expected a positive length"),
        ("--error=-1%", "expected a positive length"),
        ("--error 0.1 -n 100", "cannot be used with"),
        ("--error 0.1 --levels 100,50", "cannot be used with"),
        ("-n 100 --uniform --relax 0", "--uniform: needs relaxation passes"),
        ("-n 100 --uniform --method thesis", "--uniform: needs relaxation passes"),
    ] {
        let run = folder.run(&format!("decimate in.ply {arguments} -o no.ply"));
        assert!(run.code != Some(0) && run.stderr.contains(why), "{}", run.stderr);
    }
}

#[test]
fn locked_vertices_come_first_and_stay_where_they_are() {
    let mesh = sphere();
    let mut file = MeshFile::from(mesh.clone());
    let values = (0..mesh.vertices().len()).map(|v| f64::from(u8::from(v == 9 || v == 300)));
    file.scalars.push(Scalars { name: "fixed".into(), values: values.collect() });
    let folder = folder("in.vtk", &file);
    folder.write("fixed.txt", "# three\n\n300\n7\n2000\n");
    for (option, vertices) in
        [("--lock fixed.txt", vec![300, 7, 2000]), ("--lock-by fixed", vec![9, 300])]
    {
        let said = folder.succeed(&format!("decimate in.vtk -n 100 {option} -o out.ply --force"));
        assert!(said.contains(&format!("locked      {} vertices", vertices.len())), "{said}");
        let made = read(&folder.path("out.ply")).unwrap().mesh;
        assert_eq!(made.vertices().len(), 100);
        for (at, v) in vertices.into_iter().enumerate() {
            assert_eq!(made.vertices()[at], mesh.vertices()[v]);
        }
    }
    for (text, why) in [
        ("5\nx\n", "wrong.txt: line 2: 'x' is not a vertex from 0 to 2561"),
        ("2562\n", "wrong.txt: line 1: '2562' is not a vertex from 0 to 2561"),
        ("5\n6\n5\n", "wrong.txt: line 3: vertex 5 is also in line 1"),
        ("# nothing\n", "wrong.txt: names no vertex"),
    ] {
        folder.write("wrong.txt", text);
        let said = folder.fail("decimate in.vtk -n 100 --lock wrong.txt -o no.ply");
        assert!(said.contains(why), "{said}");
    }
    let said = folder.fail("decimate in.vtk -n 100 --lock-by loose -o no.ply");
    assert!(said.contains("--lock-by loose: in.vtk has no such scalar: fixed"), "{said}");
    let said = folder.fail("decimate in.vtk -n 5 --lock fixed.txt --method thesis -o no.ply");
    assert!(said.contains("--lock: the method of the thesis locks no vertices"), "{said}");
    let said = folder.fail("decimate in.vtk -n 100 --lock none.txt -o no.ply");
    assert!(said.contains("none.txt"), "{said}");
}

#[test]
fn edges_between_locked_vertices_that_the_result_lacks_are_noted() {
    let torus = families::torus(40, 20, 2.0, 0.8).unwrap();
    let folder = folder("in.ply", &torus.into());
    folder.write("all.txt", (0..800).map(|v| format!("{v}\n")).collect::<String>());
    let run = folder.run("decimate in.ply -n 800 --lock all.txt -o out.ply");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    // No vertex is new: the edges are not split, but others are in their place.
    let note = " of 2400 edges between locked vertices are longer than those of the result, and \
                not in it\n";
    assert!(run.stderr.contains(note), "{}", run.stderr);
}

#[test]
fn densities_come_from_a_file_or_a_scalar_and_are_carried_through_levels() {
    let mesh = sphere();
    let density: Vec<f64> =
        mesh.vertices().iter().map(|p| if p[0] > 0.0 { 9.0 } else { 1.0 }).collect();
    let mut file = MeshFile::from(mesh.clone());
    file.scalars.push(Scalars { name: "detail".into(), values: density.clone() });
    let folder = folder("in.vtk", &file);
    let lines: Vec<String> = density.iter().map(f64::to_string).collect();
    folder.write("density.txt", format!("# vertices per area\n\n{}\n", lines.join("\n")));
    for (option, of, name) in [
        ("--density density.txt", DecimateOptions::new().density(&density), "file.ply"),
        ("--density-by detail", DecimateOptions::new().density(&density), "scalar.ply"),
        ("--curvature 16", DecimateOptions::new().curvature(16.0), "curvature.ply"),
        ("--curvature 1", DecimateOptions::new(), "even.ply"),
    ] {
        folder.succeed(&format!("decimate in.vtk -n 300 {option} -o {name}"));
        let made = read(&folder.path(name)).unwrap().mesh;
        assert_eq!(made, decimate(&mesh, 300, &of).unwrap().mesh, "{option}");
    }
    folder.succeed("decimate in.vtk --levels 600,150 --density density.txt -o level-{}.ply");
    let few = read(&folder.path("level-150.ply")).unwrap().mesh;
    let dense = few.vertices().iter().filter(|p| p[0] > 0.0).count();
    assert!((115..145).contains(&dense), "{dense} of 150");
    for (text, why) in [
        ("5\n0\n", "wrong.txt: line 2: '0' is not a positive number"),
        ("x\n", "wrong.txt: line 1: 'x' is not a positive number"),
        ("5\n6\n", "wrong.txt: expected a number for each of 2562 vertices, got 2"),
    ] {
        folder.write("wrong.txt", text);
        let said = folder.fail("decimate in.vtk -n 100 --density wrong.txt -o no.ply");
        assert!(said.contains(why), "{said}");
    }
    for (option, why) in [
        ("--density-by loose", "--density-by loose: in.vtk has no such scalar: detail"),
        ("--curvature 0.5", "--curvature: must be from 1 to 1000000, is 0.5"),
        ("--density density.txt --method thesis", "--density: the method of the thesis has"),
        ("--curvature 9 --method thesis", "--curvature: the method of the thesis has"),
    ] {
        let said = folder.fail(&format!("decimate in.vtk -n 100 {option} -o no.ply"));
        assert!(said.contains(why), "{said}");
    }
}

#[test]
fn levels_are_decimated_from_each_other_and_named_by_their_numbers() {
    let mesh = sphere();
    let mut file = MeshFile::from(mesh.clone());
    file.colors = Some(vec![[1.0, 0.5, 0.0, 1.0]; mesh.vertices().len()]);
    let folder = folder("in.ply", &file);
    folder.write("fixed.txt", "300\n7\n");
    let said = folder
        .succeed("decimate in.ply --levels 400,120,30 --lock fixed.txt -o lod-{}.ply --report");
    assert_eq!(said.matches("Hausdorff").count(), 3, "{said}");
    let level = |n: usize| read(&folder.path(&format!("lod-{n}.ply"))).unwrap();
    for n in [400, 120, 30] {
        let made = level(n);
        assert_eq!(made.mesh.vertices().len(), n);
        assert_eq!(made.mesh.vertices()[..2], [mesh.vertices()[300], mesh.vertices()[7]]);
        assert!(made.colors.is_some());
    }
    folder.write("first.txt", "0\n1\n");
    folder.succeed("decimate lod-400.ply -n 120 --lock first.txt -o alone.ply");
    let alone = read(&folder.path("alone.ply")).unwrap().mesh;
    assert_eq!(alone, level(120).mesh);
    for (arguments, why) in [
        ("--levels 100,50 -o no.ply", "{} must stand for the number of vertices"),
        ("--levels 50,100 -o no-{}.ply", "--levels: each must have fewer vertices"),
        ("--levels 50,2 -o no-{}.ply", "--levels: 2, but 1 components need 4 vertices"),
    ] {
        let said = folder.fail(&format!("decimate in.ply {arguments}"));
        assert!(said.contains(why), "{said}");
    }
}

#[test]
fn requests_that_need_more_memory_than_allowed_say_how_much_before_they_start() {
    let folder = folder("in.ply", &sphere().into());
    let file = fs::metadata(folder.path("in.ply")).unwrap().len();
    assert!(file < 1 << 20, "{file} bytes");
    for (command, what) in [
        ("decimate in.ply -n 1000000 -o out.ply", "1000000 vertices"),
        ("decimate in.ply --edge-length 0.0001 -o out.ply", "vertices"),
        ("spectrum in.ply -k 2000 -o out.npz", "2000 of 2562 eigenpairs"),
        ("basis in.ply -k 600 -o out.npz", "-k: 601 functions of 2562 vertices"),
        ("basis in.ply -k 50 -o out.npz", "order: 1326 functions of 2562 vertices"),
        (
            "transfer in.ply in.ply --identity --details coordinates -k 50 -o out.ply",
            "order: 1326 functions of 2562 vertices",
        ),
        (
            "transfer in.ply in.ply --identity --details heights --smooth-functions 600 -o out.ply",
            "--smooth-functions: 601 functions of 2562 vertices",
        ),
        ("newton --size 4096 -o out.png", "16777216 points"),
        ("slime --tile --size 4096 -o out", "4096 x 4096"),
    ] {
        let message = folder.fail(&format!("{command} --input-limit 0.01"));
        assert!(message.contains(what), "{command}: {message}");
        assert!(message.contains("would take at least"), "{command}: {message}");
        assert!(message.contains("10.24 MiB are allowed (--input-limit)"), "{command}: {message}");
    }
    // Without a limit the memory of the machine counts.
    let message = folder.fail("decimate in.ply -n 999999999999 -o out.ply");
    assert!(message.contains("GiB are available"), "{message}");
    assert!(!folder.path("out.ply").exists());
}

#[test]
fn a_mesh_is_the_same_for_any_number_of_threads() {
    let folder = folder("in.ply", &families::figure(5, 0.5).unwrap().into());
    for threads in [1, 2, 3] {
        folder.succeed(&format!("decimate in.ply -n 150 --threads {threads} -o {threads}.ply"));
    }
    let [one, two, three] = ["1.ply", "2.ply", "3.ply"].map(|name| fs::read(folder.path(name)));
    let one = one.unwrap();
    assert!(one == two.unwrap() && one == three.unwrap());
}

#[test]
fn the_prolongation_has_a_row_of_sum_one_for_each_vertex_of_the_input() {
    let folder = folder("in.ply", &sphere().into());
    let said = folder.succeed("decimate in.ply -n 60 -o out.ply --prolongation p.mtx");
    assert!(said.contains("matrix      p.mtx: 2562 x 60, "), "{said}");
    let rows = numbers(&folder, "p.mtx");
    assert_eq!(rows[0][..2], [2562.0, 60.0]);
    assert_eq!(rows[0][2] as usize, rows.len() - 1);
    let mut sums = vec![0.0; 2562];
    for row in &rows[1..] {
        let [i, j, weight] = row[..] else { panic!("{row:?}") };
        assert!((1.0..=60.0).contains(&j) && weight > 0.0, "{row:?}");
        sums[i as usize - 1] += weight;
    }
    assert!(sums.iter().all(|sum| (sum - 1.0).abs() < 1e-9));
}

#[test]
fn colours_and_texture_coordinates_are_carried() {
    let mesh = families::terrain(30, 30, 1).unwrap();
    let mut file = MeshFile::from(mesh.clone());
    let plane = |p: &[f64; 3]| [p[0], 0.5 * p[1]];
    file.uv =
        Some(Attribute { values: mesh.vertices().iter().map(plane).collect(), corners: None });
    file.colors = Some(mesh.vertices().iter().map(|p| [p[0], p[1], 0.0, 1.0]).collect());
    let folder = folder("in.obj", &file);
    folder.succeed("decimate in.obj -n 90 -o out.obj");
    let made = read(&folder.path("out.obj")).unwrap();
    let colors = made.colors.as_ref().expect("colours");
    let uv = made.uv.as_ref().expect("texture coordinates");
    for (f, face) in made.mesh.faces().iter().enumerate() {
        for (v, [x, y]) in face.iter().zip(uv.of_face(&made.mesh, f).unwrap()) {
            let p = made.mesh.vertices()[*v as usize];
            // Vertices are beside the terrain by less than its roughness.
            assert!((x - p[0]).abs() < 0.05 && (2.0 * y - p[1]).abs() < 0.05, "{p:?} {x} {y}");
            let [red, green, ..] = colors[*v as usize];
            assert!((x - red).abs() < 0.01 && (2.0 * y - green).abs() < 0.01, "{red} {green}");
        }
    }
}

#[test]
fn materials_are_carried_and_normals_are_said_not_to_be() {
    let folder = Folder::new();
    let mesh = families::grid(12, 12).unwrap();
    let mut text = String::from("mtllib grid.mtl\nvn 0 0 1\n");
    for [x, y, z] in mesh.vertices() {
        text += &format!("v {x} {y} {z}\n");
    }
    for material in ["red", "blue"] {
        text += &format!("usemtl {material}\n");
        for face in mesh.faces() {
            let [a, b, c] = face.map(|v| v + 1);
            let x: f64 = face.iter().map(|&v| mesh.vertices()[v as usize][0]).sum();
            if (x < 1.5) == (material == "red") {
                text += &format!("f {a}//1 {b}//1 {c}//1\n");
            }
        }
    }
    folder.write("in.obj", text);
    let made = folder.run("decimate in.obj -n 40 -o out.obj");
    assert_eq!(made.code, Some(0), "{}", made.stderr);
    let note = "note: out.obj: normals of the input are not carried over\n";
    assert!(made.stderr.contains(note), "{}", made.stderr);
    let made = read(&folder.path("out.obj")).unwrap();
    let materials = made.materials.expect("materials");
    for (f, face) in made.mesh.faces().iter().enumerate() {
        let x: f64 = face.iter().map(|&v| made.mesh.vertices()[v as usize][0]).sum();
        let material = if x < 1.5 { "red" } else { "blue" };
        assert!((x - 1.5).abs() < 0.1 || materials.of_face(f) == Some(material), "{x}");
    }
    assert_eq!(made.material_files, ["grid.mtl"]);
}

#[test]
fn refusals_say_why_and_leave_nothing() {
    let folder = folder("in.ply", &families::spheres(3, 2).unwrap().into());
    let refused = |arguments: &str| folder.fail(&format!("decimate in.ply {arguments}"));
    let few = refused("-n 11 -o out.ply --prolongation p.mtx");
    assert!(few.contains("in.ply: can't be decimated to 11"), "{few}");
    assert!(few.contains("3 components need 12 vertices: 4 each, 3 with boundary"), "{few}");
    assert!(refused("-n 20 --first 486 -o out.ply").contains("first"));
    assert!(
        refused("--ratio 0 -o out.ply").contains("--ratio 0: a finite number above 0 is needed")
    );
    assert!(refused("--faces 0 -o out.ply").contains("catamaran: --faces: must be at least 1"));
    assert!(refused("--edge-length 0 -o out.ply").contains("catamaran: --edge-length: must be"));
    // The message names the option that was given, not `-n`, which has the number of vertices.
    assert!(refused("--edge-length 1e9 -o out.ply").contains("vertices: --edge-length 1e9: "));
    assert!(refused("--ratio 1e-9 -o out.ply").contains("vertices: --ratio 0.000000001: "));
    for command in ["decimate in.ply -n 20", "mesh in.ply"] {
        let run = folder.run(&format!("{command} --drop-specks 2 -o out.ply"));
        assert_eq!(run.code, Some(2), "{}", run.stderr);
        assert!(run.stderr.contains("'--drop-specks <SHARE>': expected a number from 0 to 1"));
    }
    for (arguments, why) in
        [("--edge-length 1 --faces 9", "cannot be used with"), ("", "<-n <N>|--ratio")]
    {
        let run = folder.run(&format!("decimate in.ply {arguments} -o out.ply"));
        assert!(run.code == Some(2) && run.stderr.contains(why), "{}", run.stderr);
    }
    let table = refused("-n 20 -o out.ply --prolongation p.npy");
    assert!(table.contains("p.npy: the name of --prolongation must end in .mtx"), "{table}");
    assert!(refused("-n 20 -o out.txt").contains("out.txt"));
    let numbers = refused("-n 999999999999 -o out.ply");
    assert!(numbers.contains("999999999999 vertices would take at least"), "{numbers}");
}

#[test]
fn nothing_is_replaced_unasked() {
    let folder = folder("in.ply", &sphere().into());
    for name in ["out.ply", "p.mtx", "p.png"] {
        folder.write(name, "mine");
        let arguments = match name {
            "out.ply" => "-o out.ply".to_owned(),
            "p.mtx" => "-o new.ply --prolongation p.mtx".to_owned(),
            _ => format!("-o new.ply --picture {name}"),
        };
        let refused = folder.fail(&format!("decimate in.ply -n 20 {arguments}"));
        assert!(refused.contains(name), "{refused}");
        assert_eq!(fs::read(folder.path(name)).unwrap(), b"mine");
    }
    folder.succeed("decimate in.ply -n 20 -o out.ply --prolongation p.mtx --force");
    assert_eq!(read(&folder.path("out.ply")).unwrap().mesh.vertices().len(), 20);
    folder.write("samples.csv", "mine");
    assert!(folder.fail("farthest in.ply -n 5 -o samples.csv").contains("samples.csv"));
    assert_eq!(fs::read(folder.path("samples.csv")).unwrap(), b"mine");
    folder.succeed("farthest in.ply -n 5 -o samples.csv --force");
}

#[test]
fn farthest_points_are_nested_and_start_their_cells() {
    let folder = folder("in.ply", &sphere().into());
    let said = folder.succeed(
        "farthest in.ply -n 30 --first 17 -o few.csv --cells cells.csv --distances distances.csv",
    );
    assert!(said.contains("samples     30, cells of radius "), "{said}");
    // By its former name.
    folder.succeed("fps in.ply -n 50 --first 17 -o many.csv --picture p.png");
    let (few, many) = (numbers(&folder, "few.csv"), numbers(&folder, "many.csv"));
    assert_eq!((few.len(), many.len()), (30, 50));
    assert_eq!(few, many[..30]);
    assert_eq!(few[0], [17.0]);
    let cells = numbers(&folder, "cells.csv");
    assert_eq!(cells.len(), 2562);
    let distances = numbers(&folder, "distances.csv");
    assert_eq!(distances.len(), 2562);
    for (k, sample) in few.iter().enumerate() {
        assert_eq!(cells[sample[0] as usize], [k as f64]);
        assert_eq!(distances[sample[0] as usize], [0.0]);
    }
    assert!(cells.iter().all(|cell| (0.0..30.0).contains(&cell[0])));
    assert!(distances.iter().all(|distance| distance[0] >= 0.0));
    // Edges have a length: only the samples are at no distance.
    assert_eq!(distances.iter().filter(|distance| distance[0] == 0.0).count(), 30);
    let refused = folder.fail("farthest in.ply -n 2563 -o more.csv");
    assert!(refused.contains("in.ply: -n: 2563, but only 2562 vertices"), "{refused}");
    let refused = folder.fail("farthest in.ply -n 5 --first 2562 -o more.csv");
    assert!(refused.contains("in.ply: --first: must be a vertex with a face"), "{refused}");
}

#[test]
fn distances_from_farthest_points_are_those_of_a_mesh_of_any_size() {
    let torus = families::torus(40, 20, 2.0, 0.8).unwrap();
    let run = |exponent: i32| {
        let vertices = torus.vertices().iter().map(|p| p.map(|x| x * 2f64.powi(exponent)));
        let scaled = TriMesh::new(vertices.collect(), torus.faces().to_vec()).unwrap();
        let folder = folder("in.ply", &scaled.into());
        folder.succeed("farthest in.ply -n 10 -o few.csv --distances distances.npy");
        let all: Vec<f64> = folder.read_npy("distances.npy", &[800, 1]);
        all.into_iter().map(|x| x * 2f64.powi(-exponent)).collect::<Vec<f64>>()
    };
    let expected = run(0);
    for exponent in [-166, -146, 200] {
        assert_eq!(run(exponent), expected, "{exponent}");
    }
}

#[test]
fn fewer_farthest_points_than_components_leave_an_infinite_radius() {
    let folder = folder("in.ply", &families::spheres(2, 1).unwrap().into());
    let run = folder.run("farthest in.ply -n 1 -o few.csv --cells cells.csv --distances d.csv");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stdout.contains("samples     1, cells of radius inf, in "), "{}", run.stdout);
    let note = "note: 1 of 2 components have no sample: 42 vertices are in no cell, and infinitely \
                far from all samples; -n 2 is enough for one in each";
    assert!(run.stderr.contains(note), "{}", run.stderr);
    let count = |name: &str, wanted: f64| {
        numbers(&folder, name).iter().filter(|row| row[0] == wanted).count()
    };
    assert_eq!((count("cells.csv", -1.0), count("d.csv", f64::INFINITY)), (42, 42));
    let run = folder.run("farthest in.ply -n 2 -o few.csv --force");
    assert!(!run.stderr.contains("sample"), "{}", run.stderr);
    assert!(!run.stdout.contains("inf,"), "{}", run.stdout);
}

#[test]
fn numbers_of_vertices_and_cells_are_integers() {
    let folder = folder("in.ply", &sphere().into());
    folder.succeed("farthest in.ply -n 7 --first 2000 -o few.npy --cells cells.npy");
    folder.succeed("farthest in.ply -n 7 --first 2000 -o few.csv");
    // Entries of another type would not be read as these.
    let samples: Vec<i64> = folder.read_npy("few.npy", &[7, 1]);
    assert_eq!((samples.len(), samples[0]), (7, 2000));
    let cells: Vec<i64> = folder.read_npy("cells.npy", &[2562, 1]);
    assert!(cells.iter().all(|cell| (0..7).contains(cell)));
    let lines: String = samples.iter().map(|sample| format!("{sample}\n")).collect();
    assert_eq!(fs::read_to_string(folder.path("few.csv")).unwrap(), lines);
}

#[test]
fn no_samples_are_refused() {
    let folder = folder("in.ply", &sphere().into());
    for count in ["0", "-1", "x"] {
        let run = folder.run(&format!("farthest in.ply -n={count} -o few.npy"));
        assert_eq!(run.code, Some(2), "{}", run.stderr);
        assert!(run.stderr.contains("at least 1"), "{}", run.stderr);
    }
    assert!(!folder.path("few.npy").exists());
}
