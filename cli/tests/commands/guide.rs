//! The commands of README.md and of the pages of docs/guide that have no chapter of their own.

use catamaran::io::{Output, Overwrite};
use catamaran_geometry::mesh::{TriMesh, families, io};

use crate::common::{Folder, calls, table};

/// A folder with everything that the pages read.
fn folder() -> Folder {
    let folder = Folder::new();
    for (name, m) in [("A.npy", 300), ("B.npy", 200)] {
        folder.write_npy(name, &[m as u64, 7], &table(m, 7));
    }
    let rows = table(40, 3);
    let lines: Vec<String> =
        rows.chunks(3).map(|row| format!("{},{},{}\n", row[0], row[1], row[2])).collect();
    folder.write("A.csv", lines.concat());
    folder.write("table.csv", format!("x,z,y\n{}", lines.concat()));
    let put = |name: &str, mesh: TriMesh| {
        let output = Output::create(&folder.path(name), Overwrite::Never).unwrap();
        io::write(output, &mesh.into()).unwrap();
    };
    put("scan.ply", families::torus(80, 40, 1.0, 0.4).unwrap());
    for (name, level) in [("a.ply", 2), ("b.ply", 3)] {
        put(name, families::icosphere(level).unwrap());
    }
    put("c.ply", families::torus(20, 12, 1.0, 0.5).unwrap());
    for (name, radius, factor) in
        [("ann1", 0.5, 0.8), ("ann2", 0.5, 1.2), ("bob1", 0.6, 0.8), ("bob2", 0.6, 1.2)]
    {
        let mesh = families::torus(20, 12, 2.0, radius).unwrap();
        let vertices = mesh.vertices().iter().map(|&[x, y, z]| [x, y, factor * z]).collect();
        put(&format!("{name}.ply"), TriMesh::new(vertices, mesh.faces().to_vec()).unwrap());
    }
    folder.write("labels.txt", "ann\nann\nbob\nbob\n");
    put("top.ply", families::grid(16, 10).unwrap());
    put("bottom.ply", families::grid(10, 14).unwrap());
    folder
}

/// Runs the commands of a document, but those that need a device or take minutes.
fn run(document: &str) {
    let folder = folder();
    let is_left_out = |call: &str| {
        let first = ["unions dataset", "unions train", "unions tune"];
        call.contains("--device") || first.iter().any(|words| call.starts_with(words))
    };
    for call in calls(document).into_iter().filter(|call| !is_left_out(call)) {
        folder.succeed(call);
    }
}

#[test]
fn the_commands_of_the_readme_run() {
    run(include_str!("../../../README.md"));
}

#[test]
fn the_commands_of_the_pages_on_matrices_run() {
    run(include_str!("../../../docs/guide/ata.md"));
    run(include_str!("../../../docs/guide/tables.md"));
    run(include_str!("../../../docs/guide/larger-than-memory.md"));
    run(include_str!("../../../docs/guide/reproducibility.md"));
    run(include_str!("../../../docs/guide/performance.md"));
}

#[test]
fn the_commands_of_the_page_on_the_command_line_run() {
    run(include_str!("../../../docs/guide/command-line.md"));
}

#[test]
fn the_commands_of_the_page_on_decimation_run() {
    run(include_str!("../../../docs/guide/decimation.md"));
}

#[test]
fn the_commands_of_the_page_on_unions_run() {
    run(include_str!("../../../docs/guide/unions.md"));
}
