//! `catamaran shapedna` and `catamaran unions dataset`, from outside.

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

#[test]
fn what_has_too_few_vertices_is_named() {
    let folder = Folder::new();
    write(&folder, "small.ply", families::icosphere(0).unwrap());
    let refused = folder.fail("shapedna small.ply -k 100");
    assert!(refused.contains("small.ply") && refused.contains("100 eigenpairs"), "{refused}");
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
