//! Options of pictures, whatever the command.

use catamaran::io::{Output, Overwrite};
use catamaran_geometry::mesh::io::write;
use catamaran_geometry::mesh::{TriMesh, families};

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

/// Commands that draw a picture as FILE, with the inputs of [`drawings`].
const DRAWINGS: [&str; 8] = [
    "ata a.csv --picture FILE",
    "pca a.csv --picture FILE",
    "mesh knot.obj --picture FILE",
    "decimate knot.obj -n 100 -o out --picture FILE",
    "farthest knot.obj -n 9 -o out --picture FILE",
    "distance knot.obj --from 0 -o out --picture FILE",
    "newton knot.obj --picture FILE",
    "newton --volume --size 8 --picture FILE",
];

#[test]
fn the_ending_decides_the_format_of_every_picture() {
    let folder = Folder::new();
    let knot = families::knot(2, 3, 60, 8, 0.4).unwrap();
    let output = Output::create(&folder.path("knot.obj"), Overwrite::Never).unwrap();
    write(output, &knot.into()).unwrap();
    folder.write("a.csv", "1,2,4\n3,4,-1\n0.5,-1,2\n1,1,0\n");
    for (i, line) in DRAWINGS.iter().enumerate() {
        // Names of meshes and of tables, in one place of the command.
        let out =
            if line.starts_with("decimate") { format!("{i}.obj") } else { format!("{i}.csv") };
        let line = line.replace("-o out", &format!("-o {out} --force"));
        let draw = |name: &str| folder.succeed(&line.replace("FILE", name));
        let named = |end: &str| format!("{i}.{end}");
        draw(&named("png"));
        draw(&named("SVG"));
        let pixels = std::fs::read(folder.path(&named("png"))).unwrap();
        assert_eq!(pixels[..8], *b"\x89PNG\r\n\x1a\n", "{line}");
        let text = std::fs::read_to_string(folder.path(&named("SVG"))).unwrap();
        assert!(text.starts_with("<svg ") && text.trim_end().ends_with("</svg>"), "{line}");
        assert!(text.contains("http://www.w3.org/2000/svg"), "{line}");
    }
    // Before any input is read.
    for line in DRAWINGS {
        for name in ["x.jpg", "x", "x.svgz", "png"] {
            let line = line.replace("a.csv", "none.csv").replace("knot.obj", "none.obj");
            let line = line.replace("-o out", "-o out.obj").replace("FILE", name);
            let line = line.replace(
                "-o out.obj",
                if line.contains("decimate") { "-o y.obj" } else { "-o y.csv" },
            );
            let refused = folder.fail(&line);
            assert!(refused.contains(&format!("{name}: the name of a picture must end in .png")));
        }
    }
}
