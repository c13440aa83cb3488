//! `catamaran curve`, from outside.

use catamaran::mesh::io::write;
use catamaran::mesh::{TriMesh, families};

use crate::common::Folder;

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
    assert!(said.contains("outcome   closed"), "{said}");
    let json = std::fs::read_to_string(folder.path("curve.json")).unwrap();
    assert!(json.contains("\"outcome\": \"closed\""), "{json}");
    assert!(json.contains("\"order\": [0, 4, 2, 1, 3, 5]"), "{json}");
    assert_eq!(&std::fs::read(folder.path("p.png")).unwrap()[1..4], b"PNG");
    folder.succeed("curve mesh.obj --samples samples.txt --mode faithful -l 3 -o curve.obj");
    let obj = std::fs::read_to_string(folder.path("curve.obj")).unwrap();
    assert_eq!(obj.lines().filter(|line| line.starts_with("v ")).count(), 40);
    assert!(obj.lines().any(|line| line.starts_with("l 1 2 ") && line.ends_with(" 40 1")), "{obj}");
    let smooth = folder.succeed("curve mesh.obj --samples samples.txt --smooth -o s.json");
    assert!(smooth.contains("outcome   closed"), "{smooth}");
    // Farthest points are samples too.
    folder.succeed("fps mesh.obj -n 12 -o points.csv");
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
fn samples_too_few_for_a_curve_are_left_out_with_a_note_and_others_get_theirs() {
    let folder = folder(&families::spheres(3, 1).unwrap(), "42\n0\n1\n5\n84\n85\n");
    let run = folder.run("curve mesh.obj --samples samples.txt -o curve.json");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stdout.contains("outcome   closed"), "{}", run.stdout);
    assert!(run.stdout.contains("curve     3 samples"), "{}", run.stdout);
    assert!(run.stderr.contains("note: 3 of 6 samples left out"), "{}", run.stderr);
    let json = std::fs::read_to_string(folder.path("curve.json")).unwrap();
    assert!(json.contains("\"left_out\": [0, 4, 5]"), "{json}");
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
    assert!(told("0\n1\n").contains("samples: 2, where 3 are needed"));
    assert!(told("0\n1\n1\n").contains("sample 2 is vertex 1, as sample 1"));
    assert!(told("0\n1\n99\n").contains("vertex 99 of 84"));
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
