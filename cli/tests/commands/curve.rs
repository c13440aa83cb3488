//! `catamaran curve`, from outside.

use catamaran_geometry::mesh::io::{read, write};
use catamaran_geometry::mesh::{SurfacePoint, TriMesh, families};
use serde_json::json;

use crate::common::{Folder, calls};

/// A folder with a mesh and samples.
fn folder(mesh: &TriMesh, samples: &str) -> Folder {
    let folder = Folder::new();
    let output =
        catamaran::io::Output::create(&folder.path("mesh.obj"), catamaran::io::Overwrite::Never)
            .unwrap();
    write(output, &mesh.clone().into()).unwrap();
    folder.write("samples.txt", samples);
    folder
}

const RING: &str = "0\n400 # half around\n200\n600\n\n100\n700\n";

#[test]
fn a_ring_is_closed_and_written_as_json_lines_and_picture() {
    let folder = folder(&families::torus(40, 20, 2.0, 0.8).unwrap(), RING);
    let said = folder.succeed("curve mesh.obj --samples samples.txt -o curve.json --picture p.png");
    assert!(said.contains("outcome     closed"), "{said}");
    let json = std::fs::read_to_string(folder.path("curve.json")).unwrap();
    assert!(json.contains("\"outcome\": \"closed\""), "{json}");
    assert!(json.contains("\"order\": [0, 4, 2, 1, 3, 5]"), "{json}");
    assert_eq!(&std::fs::read(folder.path("p.png")).unwrap()[1..4], b"PNG");
    folder.succeed("curve mesh.obj --samples samples.txt --mode faithful -l 3 -o curve.obj");
    let obj = std::fs::read_to_string(folder.path("curve.obj")).unwrap();
    assert_eq!(obj.lines().filter(|line| line.starts_with("v ")).count(), 40);
    assert!(obj.lines().any(|line| line.starts_with("l 1 2 ") && line.ends_with(" 40 1")), "{obj}");
    let smooth = folder.succeed("curve mesh.obj --samples samples.txt --smooth -o s.json");
    assert!(smooth.contains("outcome     closed"), "{smooth}");
    // Farthest points are samples too.
    folder.succeed("farthest mesh.obj -n 12 -o points.csv");
    folder.succeed("curve mesh.obj --samples points.csv -o through.json");
    // Nothing is replaced unasked.
    folder.fail("curve mesh.obj --samples samples.txt -o curve.obj");
    folder.succeed("curve mesh.obj --samples samples.txt -o curve.obj --force");
}

#[test]
fn points_in_space_and_on_faces_are_samples() {
    let samples = "2.8 0 0\n-2.8 0.1 0\n0 2.8 0\n0 0.2 0.8 0\n";
    let folder = folder(&families::torus(40, 20, 2.0, 0.8).unwrap(), samples);
    // The first point is a vertex of face 0, and so is the last sample without --insert.
    folder.succeed("curve mesh.obj --samples samples.txt --insert -o curve.json");
    let json = std::fs::read_to_string(folder.path("curve.json")).unwrap();
    assert!(json.contains("800"), "the inserted vertex: {json}");
}

#[test]
fn points_in_other_units_than_the_mesh_are_noted() {
    let folder = folder(&families::torus(40, 20, 2.0, 0.8).unwrap(), "");
    let notes = |samples: &str| {
        folder.write("samples.txt", samples);
        let run = folder.run("curve mesh.obj --samples samples.txt --force -o curve.json");
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        run.stderr
    };
    assert_eq!(notes("2.8 0 0\n-2.9 0.1 0\n0 2.7 0\n0 -2.8 0\n"), "");
    let said = notes("# mm\n2800 0 0\n-2800 100 0\n0 2800 0\n0 -2800 0\n300\n");
    assert!(said.starts_with("note: samples.txt:2: the point is 2.797e3 from the mesh"), "{said}");
    assert!(said.contains("units of the mesh? 4 of 5 samples are as far"), "{said}");
}

#[test]
fn commands_of_a_page_of_the_guide_write_different_files() {
    for page in [
        include_str!("../../../docs/guide/curves.md"),
        include_str!("../../../docs/guide/newton.md"),
        include_str!("../../../docs/guide/plants.md"),
        include_str!("../../../docs/guide/slime.md"),
    ] {
        let is_command = |line: &&str| line.trim_start_matches("$ ").starts_with("catamaran ");
        let output = |line: &'static str| line.split(" -o ").nth(1)?.split_whitespace().next();
        let all: Vec<&str> = page.lines().filter(is_command).filter_map(output).collect();
        let mut names = all.clone();
        names.sort_unstable();
        names.dedup();
        assert!(names.len() == all.len() && all.len() > 3, "{all:?}");
    }
}

#[test]
fn points_of_smooth_curves_are_points_of_faces_of_the_mesh() {
    let mesh = families::torus(40, 20, 2.0, 0.8).unwrap();
    let folder = folder(&mesh, "2.8 0 0\n-2.8 0.1 0\n0 2.8 0\n0 0.2 0.7 0.1\n");
    folder.succeed("curve mesh.obj --samples samples.txt --insert --smooth -o curve.json");
    let json = std::fs::read_to_string(folder.path("curve.json")).unwrap();
    let found: serde_json::Value = serde_json::from_str(&json).unwrap();
    let curve = &found["curves"][0];
    let rows =
        |name: &str| -> Vec<[f64; 3]> { serde_json::from_value(curve[name].clone()).unwrap() };
    let faces: Vec<u32> = serde_json::from_value(curve["faces"].clone()).unwrap();
    let (points, weights) = (rows("points"), rows("weights"));
    assert!(points.len() > 4 && points.len() == weights.len() && points.len() == faces.len());
    for ((face, weights), point) in faces.into_iter().zip(weights).zip(points) {
        let position = SurfacePoint { face, weights }.position(&mesh);
        let apart = (0..3).map(|k| (position[k] - point[k]).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-9, "face {face}, {weights:?}: {position:?} and {point:?}");
    }
}

#[test]
fn samples_too_few_for_a_curve_are_left_out_with_a_note_and_others_get_theirs() {
    let folder = folder(&families::spheres(3, 1).unwrap(), "42\n0\n1\n5\n84\n85\n");
    let run = folder.run("curve mesh.obj --samples samples.txt -o curve.json");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stdout.contains("outcome     closed"), "{}", run.stdout);
    assert!(run.stdout.contains("curve       3 samples"), "{}", run.stdout);
    assert!(run.stderr.contains("note: 3 of 6 samples left out"), "{}", run.stderr);
    let json = std::fs::read_to_string(folder.path("curve.json")).unwrap();
    assert!(json.contains("\"left_out\": [0, 4, 5]"), "{json}");
}

#[test]
fn outliers_are_dropped_on_request_and_named() {
    // Around the outer equator, and a vertex of the inner one.
    let ring: Vec<String> = (0..20).map(|i| format!("{}\n", 40 * ((7 * i) % 20))).collect();
    let (first, rest) = ring.split_at(9);
    let with_stray = [first, &["210\n".to_owned()], rest].concat().concat();
    let folder = folder(&families::torus(40, 20, 2.0, 0.8).unwrap(), &ring.concat());
    folder.write("strayed.txt", format!("curve a\n{}curve b\n{with_stray}", ring.concat()));
    folder.succeed("curve mesh.obj --samples samples.txt -o alone.json");
    let said = folder.succeed("curve mesh.obj --samples strayed.txt --drop-outliers -o both.json");
    assert!(said.contains("outliers    b: 1 of 21 samples dropped: 29 (from 0)"), "{said}");
    let read = |name: &str| -> serde_json::Value {
        serde_json::from_slice(&std::fs::read(folder.path(name)).unwrap()).unwrap()
    };
    let (alone, both) = (read("alone.json"), read("both.json"));
    assert_eq!((&alone["outliers"], &both["outliers"]), (&json!([]), &json!([29])));
    for curve in [0, 1] {
        assert_eq!(both["curves"][curve]["path"], alone["curves"][0]["path"]);
    }
    let run = "curve mesh.obj --samples strayed.txt --drop-outliers --mode faithful -o c.json";
    assert!(folder.fail(run).contains("--drop-outliers: --mode faithful takes every sample"));
    assert!(!folder.path("c.json").exists());
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let mesh = families::spheres(2, 1).unwrap();
    let folder = folder(&mesh, "0\n1\nx\n");
    let run = "curve mesh.obj --samples samples.txt -o curve.json";
    let told = |samples: &str| {
        folder.write("samples.txt", samples);
        folder.fail(run)
    };
    assert!(told("0\n1\nx\n").contains("samples.txt:3: neither"));
    // Three numbers after that of the face, and another word.
    for face in ["7 0.2 0.3 0.5 x", "7 x 0.2 0.3 0.5", "7 0.2 0.3 0.5 0"] {
        let said = told(&format!("0\n1\n{face}\n"));
        assert!(said.contains("samples.txt:3: neither"), "{face}: {said}");
    }
    assert!(told("0\n1\n").contains("samples: must be at least 3, are 2"));
    assert!(told("0\n1\n1\n").contains("sample 2 is vertex 1, as sample 1"));
    // By its line, whatever lines are before it.
    let far = told("# clicks\n0\n1\n\n99\n");
    assert!(far.contains("catamaran: samples.txt:5: vertex 99 is out of range: 84"), "{far}");
    assert!(!folder.path("curve.json").exists());
    // An outcome, not an error: there is a file.
    folder.write("samples.txt", "0\n1\n42\n");
    let outcome = folder.run(run);
    assert_eq!(outcome.code, Some(1));
    assert!(outcome.stderr.contains("samples on 2 components of the mesh"), "{}", outcome.stderr);
    let json = std::fs::read_to_string(folder.path("curve.json")).unwrap();
    assert!(json.contains("\"outcome\": \"disconnected\""), "{json}");
    assert!(json.contains("\"length\": 0,") && json.contains("\"left_out\": [0, 1, 2]"), "{json}");
    assert!(folder.fail("curve mesh.obj --samples samples.txt -o c.txt").contains(".obj or .json"));
}

#[test]
fn a_curve_that_is_not_complete_is_named_with_the_number_of_its_sample_in_the_file() {
    // The first path of the second curve divides the mesh between the other two samples.
    let samples = "curve a\n20\n24\n60\n56\ncurve b open\n36\n44\n4\n76\n";
    let folder = folder(&families::grid(8, 8).unwrap(), samples);
    let run = "curve mesh.obj --samples samples.txt --mode ordered --force -o curve.json";
    let found = folder.run(run);
    assert_eq!(found.code, Some(1), "{}", found.stderr);
    let outcome = "blocked at sample 4, 3 samples not reached";
    assert!(found.stdout.contains("outcome     a: closed"), "{}", found.stdout);
    assert!(found.stdout.contains(&format!("outcome     b: {outcome}")), "{}", found.stdout);
    let says = format!("catamaran: samples.txt: curve b: not complete: {outcome}\n");
    assert_eq!(found.stderr, says);
    let found = folder.run(&format!("{run} --json"));
    assert!(found.stdout.contains("\"blocked_at\":4"), "{}", found.stdout);
    // A file without names.
    folder.write("samples.txt", "36\n44\n4\n76\n");
    let found = folder.run(&format!("{run} --open"));
    let says = "catamaran: samples.txt: a curve is not complete: blocked at sample 0, 3 samples";
    assert!(found.stderr.starts_with(says), "{}", found.stderr);
}

/// Numbers of vertices of a grid of n x n squares.
fn square(n: u32, low: u32, high: u32) -> String {
    let at = |x: u32, y: u32| y * (n + 1) + x;
    let corners = [at(low, low), at(high, high), at(high, low), at(low, high)];
    corners.map(|v| format!("{v}\n")).concat()
}

fn area(folder: &Folder, name: &str) -> f64 {
    read(&folder.path(name)).unwrap().mesh.area()
}

#[test]
fn a_region_and_the_rest_are_written_as_meshes_and_tables() {
    let folder = folder(&families::grid(8, 8).unwrap(), &square(8, 2, 6));
    let said = folder.succeed(
        "curve mesh.obj --samples samples.txt --region in.ply --region in.npy --rest out.obj \
         --rest out.csv --paint all.ply --picture p.png",
    );
    assert!(said.contains("region      32 faces, area 0.25, 25.00 % of the surface"), "{said}");
    assert_eq!((area(&folder, "in.ply"), area(&folder, "out.obj")), (0.25, 0.75));
    let inside: Vec<f64> = folder.read_npy("in.npy", &[128, 1]);
    assert_eq!((inside.len(), inside.iter().sum::<f64>()), (128, 32.0));
    let outside = std::fs::read_to_string(folder.path("out.csv")).unwrap();
    let outside: Vec<f64> = outside.lines().map(|line| line.parse().unwrap()).collect();
    assert!(inside.iter().zip(&outside).all(|(a, b)| a + b == 1.0));
    // Colours end at the curve, whose 16 vertices are there twice.
    let painted = read(&folder.path("all.ply")).unwrap();
    assert_eq!(painted.mesh.vertices().len(), 81 + 16);
    let mut colors = painted.colors.unwrap();
    colors.sort_by(|a, b| a[0].total_cmp(&b[0]));
    colors.dedup();
    assert_eq!(colors.len(), 2);
    // The other side, by size and by a seed.
    for side in ["large", "seed:0", "seed:0,80"] {
        let run = "curve mesh.obj --samples samples.txt --force --region in.ply --side";
        folder.succeed(&format!("{run} {side}"));
        assert_eq!(area(&folder, "in.ply"), 0.75, "{side}");
    }
    let run = "curve mesh.obj --samples samples.txt --region x.ply --side seed:20";
    assert!(folder.fail(run).contains("vertex 20 is on the curve"));
    assert!(!folder.path("x.ply").exists());
}

#[test]
fn smooth_curves_cut_faces_and_shares_say_how_much_of_them() {
    let folder = folder(&families::icosphere(3).unwrap(), "3\n200\n400\n500\n");
    folder.succeed(
        "curve mesh.obj --samples samples.txt --smooth --region in.obj --region in.npy --rest \
         out.obj",
    );
    let shares: Vec<f64> = folder.read_npy("in.npy", &[1280, 1]);
    assert!(shares.iter().any(|&s| s > 0.0 && s < 1.0));
    let mesh = families::icosphere(3).unwrap();
    let sum: f64 = shares.iter().zip(mesh.face_areas()).map(|(s, a)| s * a).sum();
    let [inside, outside] = ["in.obj", "out.obj"].map(|name| area(&folder, name));
    assert!((sum - inside).abs() < 1e-12 && (inside + outside - mesh.area()).abs() < 1e-12);
}

#[test]
fn several_curves_in_a_file_are_combined() {
    let [a, b] = [square(8, 1, 5), square(8, 3, 7)];
    let folder = folder(&families::grid(8, 8).unwrap(), &format!("curve a\n{a}curve b\n{b}"));
    let run = "curve mesh.obj --samples samples.txt --force --region in.ply";
    for (how, squares) in [("union", 28), ("intersection", 4), ("difference", 12), ("xor", 24)] {
        folder.succeed(&format!("{run} --combine {how}"));
        assert_eq!(area(&folder, "in.ply"), f64::from(squares) / 64.0, "{how}");
    }
    // A side for one of them, and a hole.
    let hole = square(8, 2, 4);
    folder.write("samples.txt", format!("curve a side=large\n{a}curve hole\n{hole}"));
    folder.succeed(&format!("{run} -o both.json"));
    assert_eq!(area(&folder, "in.ply"), 52.0 / 64.0);
    let json = std::fs::read_to_string(folder.path("both.json")).unwrap();
    assert!(json.contains("\"name\": \"hole\"") && json.contains("4, 6, 5, 7"), "{json}");
    // In a file with lines, objects.
    folder.succeed("curve mesh.obj --samples samples.txt -o both.obj");
    let obj = std::fs::read_to_string(folder.path("both.obj")).unwrap();
    assert!(obj.contains("o a\n") && obj.contains("o hole\n"), "{obj}");
    let told = |samples: &str| {
        folder.write("samples.txt", samples);
        folder.fail(run)
    };
    assert!(told("1\ncurve a\n2\n3\n4\n").contains("samples.txt:2: samples before the first"));
    assert!(told("curve a\n2\ncurve a\n3\n").contains("samples.txt:3: a second curve a"));
    assert!(told("curve a wide\n2\n").contains("wide: expected open, single or side=SIDE"));
    assert!(told("curve a side=in\n2\n").contains("expected small, large or seed:V"));
    assert!(
        told("curve a\n10\n12\n28\ncurve b\n")
            .contains("curve b: samples: must be at least 3, are 0")
    );
    assert!(
        folder
            .fail("curve mesh.obj --samples samples.txt --side large -o c.obj")
            .contains("--side")
    );
    let run = folder.run("curve mesh.obj --samples samples.txt");
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("--output"), "{}", run.stderr);
}

#[test]
fn a_mesh_is_cut_into_pieces_or_slit() {
    let folder = folder(&families::grid(8, 8).unwrap(), &square(8, 2, 6));
    let said = folder.succeed("curve mesh.obj --samples samples.txt --cut parts/");
    assert!(said.contains("cut         16 edges, 2 components, 128 faces"), "{said}");
    let areas = ["parts/piece-1.ply", "parts/piece-2.ply"].map(|name| area(&folder, name));
    assert_eq!(areas, [0.75, 0.25]);
    // What is there stays.
    assert!(folder.fail("curve mesh.obj --samples none.txt --cut parts").contains("exists"));
    let said = folder.fail("curve mesh.obj --samples none.txt -o none.json");
    assert!(said.contains("none.txt: no such file"), "{said}");
    folder.succeed("curve mesh.obj --samples samples.txt --cut parts --force");
    folder.write("parts/piece-3.obj", "");
    let run = folder.run("curve mesh.obj --samples samples.txt --cut parts --force");
    let note = "note: parts: pieces that this run does not write stay: 1, piece-3.obj\n";
    assert!(run.code == Some(0) && run.stderr.contains(note), "{}", run.stderr);
    // An open curve leaves a slit, of four edges here.
    folder.write("samples.txt", "curve slit open\n38\n42\n40\n");
    folder.succeed("curve mesh.obj --samples samples.txt --cut slit.ply");
    assert_eq!(read(&folder.path("slit.ply")).unwrap().mesh.vertices().len(), 81 + 3);
    let told = folder.fail("curve mesh.obj --samples samples.txt --region in.ply");
    assert!(told.contains("curve slit") && told.contains("that are open"), "{told}");
    // Samples that are in order are joined in it.
    folder.write("samples.txt", "10\n16\n70\n64\n");
    let said = folder.succeed("curve mesh.obj --samples samples.txt --mode ordered -o c.json");
    let json = std::fs::read_to_string(folder.path("c.json")).unwrap();
    assert!(json.contains("\"order\": [0, 1, 2, 3]"), "{json} {said}");
}

#[test]
fn loops_around_handles_are_cut_and_enclose_nothing() {
    let folder = folder(&families::torus(40, 20, 2.0, 0.8).unwrap(), "60\n65\n70\n75\n");
    let said = folder.succeed("curve mesh.obj --samples samples.txt --cut cut.ply");
    assert!(said.contains("cut         20 edges, 1 components"), "{said}");
    assert_eq!(read(&folder.path("cut.ply")).unwrap().mesh.vertices().len(), 820);
    let told = folder.fail("curve mesh.obj --samples samples.txt --region in.ply");
    assert!(told.contains("go around a handle"), "{told}");
    assert!(!folder.path("in.ply").exists());
}

#[test]
fn files_of_other_programs_go_through_with_what_they_have() {
    // Quads in two objects, with colours and texture coordinates: 6 x 6 squares.
    let at = |x: u32, y: u32| 7 * y + x + 1;
    let mut obj = String::from("# MeshLab\nmtllib scan.mtl\n");
    for (x, y) in (0..7).flat_map(|y| (0..7).map(move |x| (x, y))) {
        obj += &format!(
            "v {x} {y} 0 {} 0.5 0.25\nvt {} {}\n",
            f64::from(x) / 6.0,
            f64::from(x) / 6.0,
            y
        );
    }
    for x in 0..6 {
        obj += if x < 3 { "o left\n" } else { "o right\n" };
        for y in 0..6 {
            let corners = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
            obj += &format!("f {}\n", corners.map(|v| format!("{v}/{v}")).join(" "));
        }
    }
    let folder = Folder::new();
    folder.write("scan.obj", &obj);
    folder.write("samples.txt", "8\n40\n12\n31\n");
    folder.succeed(
        "curve scan.obj --samples samples.txt --smooth --region in.obj --rest out.obj --cut parts/",
    );
    let [inside, outside] = ["in.obj", "out.obj"].map(|name| read(&folder.path(name)).unwrap());
    assert!((inside.mesh.area() + outside.mesh.area() - 36.0).abs() < 1e-12);
    for file in [&inside, &outside] {
        let objects = file.objects.as_ref().unwrap();
        let colors = file.colors.as_ref().unwrap();
        for (f, face) in file.mesh.faces().iter().enumerate() {
            let [a, b, c] = face.map(|v| file.mesh.vertices()[v as usize][0]);
            let side = if a + b + c < 9.0 { "left" } else { "right" };
            assert_eq!(objects.of_face(f), Some(side));
            let uv = file.uv.as_ref().unwrap().of_face(&file.mesh, f).unwrap();
            for (v, uv) in face.iter().zip(uv) {
                let [x, y, _] = file.mesh.vertices()[*v as usize];
                assert!((colors[*v as usize][0] - x / 6.0).abs() < 1e-9);
                assert!((uv[0] - x / 6.0).abs() < 1e-9 && (uv[1] - y).abs() < 1e-9);
            }
        }
    }
    assert!(folder.path("parts/piece-2.obj").exists());
    // A polygon, and colours of faces, as libigl writes them.
    folder.write(
        "fan.off",
        "OFF\n7 4 0\n0 0 0\n2 0 0\n3 2 0\n2 4 0\n0 4 0\n-1 2 0\n1 2 0\n4 0 1 6 5 255 0 0\n\
         4 1 2 3 6 0 255 0\n3 3 4 6\n3 4 5 6\n",
    );
    folder.write("open.txt", "1\n6\n4\n");
    let said = folder.succeed("curve fan.off --samples open.txt --open --cut cut.off");
    assert!(said.contains("2 components"), "{said}");
    // Points alone, and what is no mesh.
    let axes = ["x", "y", "z"].map(|axis| format!("property float {axis}\n")).concat();
    let points = "end_header\n0 0 0\n1 0 0\n0 1 0\n";
    let head = "ply\nformat ascii 1.0\nelement vertex 3\n";
    folder.write("points.ply", format!("{head}{axes}{points}"));
    folder.write("few.txt", "0\n1\n2\n");
    let run = folder.run("curve points.ply --samples few.txt --cut c.ply");
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    assert!(run.stderr.contains("is in no face"), "{}", run.stderr);
    folder.write("scan.las", "LASF");
    assert!(folder.fail("curve scan.las --samples few.txt --cut c.ply").contains("scan.las"));
}

#[test]
fn the_commands_of_the_guide_run() {
    let guide = include_str!("../../../docs/guide/curves.md");
    let folder = folder(&families::grid(20, 20).unwrap(), "");
    std::fs::rename(folder.path("mesh.obj"), folder.path("scan.obj")).unwrap();
    folder.write("clicks.txt", square(20, 4, 14));
    folder.write("line.txt", "231\n240\n236\n");
    folder.write(
        "two.txt",
        format!("curve face\n{}curve eye\n{}", square(20, 4, 14), square(20, 8, 11)),
    );
    for line in calls(guide) {
        folder.succeed(&format!("{line} --force"));
    }
    assert!(folder.path("pieces/piece-2.ply").exists());
}
