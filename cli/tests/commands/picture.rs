//! Options of pictures, whatever the command.

use catamaran::io::{Output, Overwrite};
use catamaran::mesh::io::write;
use catamaran::mesh::{TriMesh, families};

use crate::common::Folder;

fn drawn(folder: &Folder, arguments: &str) -> Vec<u8> {
    folder.succeed(&format!("mesh {arguments} --picture p.png --force"));
    std::fs::read(folder.path("p.png")).unwrap()
}

#[test]
fn the_upward_axis_is_that_of_the_file_or_of_a_terrain_unless_it_is_given() {
    let folder = Folder::new();
    let write = |name: &str, mesh: TriMesh| {
        let output = Output::create(&folder.path(name), Overwrite::Never).unwrap();
        write(output, &mesh.into()).unwrap();
    };
    let knot = families::knot(2, 3, 60, 8, 0.4).unwrap();
    write("knot.stl", knot.clone());
    write("knot.obj", knot);
    write("terrain.obj", families::terrain(20, 20, 3).unwrap());
    for (name, up) in [("knot.stl", "z"), ("knot.obj", "y"), ("terrain.obj", "z")] {
        let guessed = drawn(&folder, name);
        for axis in ["x", "y", "z"] {
            let given = drawn(&folder, &format!("{name} --up {axis}"));
            assert_eq!(given == guessed, axis == up, "{name} --up {axis}");
        }
    }
    // The view is one thing, the axis another.
    let flat = drawn(&folder, "terrain.obj --view 0,90,flat");
    assert_eq!(flat, drawn(&folder, "terrain.obj --view 0,90,flat --up z"));
    for wrong in ["--up w", "--view 0,90,z"] {
        assert_eq!(folder.run(&format!("mesh knot.obj --picture q.png {wrong}")).code, Some(2));
    }
}
