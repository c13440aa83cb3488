//! Meshes of several components in every command that takes a spectrum: each component has an
//! eigenvalue zero of its own.

use catamaran::io::{Output, Overwrite};
use catamaran_geometry::mesh::{TriMesh, families, io};

use crate::common::{Folder, Run};

fn write(folder: &Folder, name: &str, mesh: TriMesh) {
    let output = Output::create(&folder.path(name), Overwrite::Never).unwrap();
    io::write(output, &mesh.into()).unwrap();
}

/// The meshes as one, beside each other.
fn beside(meshes: &[TriMesh]) -> TriMesh {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for (i, mesh) in meshes.iter().enumerate() {
        let first = vertices.len() as u32;
        vertices.extend(mesh.vertices().iter().map(|p| [p[0] + 10.0 * i as f64, p[1], p[2]]));
        faces.extend(mesh.faces().iter().map(|face| face.map(|v| first + v)));
    }
    TriMesh::new(vertices, faces).unwrap()
}

/// Three squares with one edge in common, each with vertices of its own.
fn pages() -> TriMesh {
    let grid = families::grid(6, 6).unwrap();
    let page = |angle: f64| {
        let turned = |p: &[f64; 3]| [p[0] * angle.cos(), p[1], p[0] * angle.sin()];
        grid.vertices().iter().map(turned).collect::<Vec<_>>()
    };
    let n = grid.vertices().len() as u32;
    let vertices = [0.0, 2.0, 4.0].map(page).concat();
    let faces = (0..3).flat_map(|i| grid.faces().iter().map(move |face| face.map(|v| v + i * n)));
    TriMesh::new(vertices, faces.collect()).unwrap()
}

fn succeed(folder: &Folder, command: &str) -> Run {
    let run = folder.run(command);
    assert_eq!(run.code, Some(0), "{command}: {}", run.stderr);
    run
}

/// Every command that takes a spectrum of the mesh MESH, with -k of at most K.
const COMMANDS: [&str; 11] = [
    "spectrum MESH -k K -o s.npz --force",
    "spectrum MESH -k K --mass full --laplacian intrinsic -o s.npz --force",
    "shapedna MESH other.ply -k K",
    "descriptors MESH --kind hks -k K -o d.npy --force",
    "descriptors MESH --kind wks -k K -o d.npy --force",
    "descriptors MESH --kind gps -k K -o d.npy --force",
    "basis MESH -k K -o b.npz --force",
    "filter MESH --heat 0.01 -k K -o f.ply --force",
    "transfer MESH MESH --identity --details coordinates -k K -o t.ply --force",
    "transfer MESH MESH --landmarks pairs.txt --details coordinates -k K -o t.ply --force",
    "transfer MESH MESH --identity --details heights -k 30 --smooth-functions K -o t.ply --force",
];

fn folder() -> Folder {
    let folder = Folder::new();
    write(&folder, "spheres.ply", families::spheres(6, 1).unwrap());
    let scaled = |i: usize| {
        let (mut vertices, faces) = families::icosphere(1).unwrap().into_parts();
        let axes = [1.0 + 0.1 * i as f64, 1.3, 0.7];
        vertices.iter_mut().for_each(|p| (0..3).for_each(|c| p[c] *= axes[c]));
        TriMesh::new(vertices, faces).unwrap()
    };
    write(&folder, "ellipsoids.ply", beside(&[0, 1, 2, 3, 4, 5].map(scaled)));
    write(&folder, "other.ply", families::torus(24, 12, 1.0, 0.4).unwrap());
    write(&folder, "pages.ply", pages());
    folder.write("pairs.txt", "0 0\n50 50\n90 90\n130 130\n180 180\n230 230\n");
    folder
}

#[test]
fn every_command_that_takes_a_spectrum_notes_the_number_of_components() {
    let folder = folder();
    for command in COMMANDS {
        let run = succeed(&folder, &command.replace("MESH", "ellipsoids.ply").replace('K', "20"));
        let note = "note: ellipsoids.ply: 6 components: 6 eigenvalues are zero, one for each (`";
        assert!(run.stderr.contains(note), "{command}: {}", run.stderr);
        // No vertices coincide.
        assert!(!run.stderr.contains("--weld joins"), "{command}: {}", run.stderr);
        let run = succeed(&folder, &command.replace("MESH", "other.ply").replace('K', "8"));
        assert!(!run.stderr.contains("components"), "{command}: {}", run.stderr);
    }
}

#[test]
fn eigenvalues_that_are_all_zero_are_noted_or_refused_and_the_number_named_is_enough() {
    let folder = folder();
    for command in COMMANDS {
        let command = command.replace("MESH", "ellipsoids.ply");
        let run = folder.run(&command.replace('K', "4"));
        if command.starts_with("spectrum") {
            assert!(run.stderr.contains("6 eigenvalues are zero"), "{}", run.stderr);
            continue;
        }
        assert_eq!(run.code, Some(1), "{command}: {}", run.stdout);
        assert!(run.stderr.contains("6 "), "{command}: {}", run.stderr);
        let words: Vec<&str> = run.stderr.split([' ', ',']).collect();
        let place = words.windows(2).position(|pair| ["or", "at"].contains(&pair[1])).unwrap();
        let least: usize = words[place].parse().unwrap();
        assert!((5..=7).contains(&least), "{command}: {}", run.stderr);
        succeed(&folder, &command.replace('K', &least.to_string()));
        let refused = folder.fail(&command.replace('K', &(least - 1).to_string()));
        assert!(refused.contains(&format!("{least} ")), "{command}: {refused}");
    }
}

#[test]
fn a_signature_of_zeros_is_refused_for_every_boundary() {
    let folder = folder();
    let refused = folder.fail("shapedna spheres.ply ellipsoids.ply -k 6");
    let says = "spheres.ply: 6 eigenvalues are zero, one for each component: -k 6 compares zeros \
                only, 7 or more is enough";
    assert!(refused.contains(says), "{refused}");
    folder.succeed("shapedna spheres.ply ellipsoids.ply -k 7");
    // Closed components have no boundary where functions could be zero.
    let refused = folder.fail("shapedna spheres.ply ellipsoids.ply -k 6 --dirichlet");
    assert!(refused.contains("7 or more is enough"), "{refused}");
    let refused = folder.fail("shapedna other.ply other.ply -k 1");
    assert!(refused.contains("1 eigenvalue is zero"), "{refused}");
}

#[test]
fn the_hints_of_the_note_lead_to_one_component() {
    let folder = folder();
    let run = succeed(&folder, "spectrum pages.ply -k 5");
    let hint = "note: pages.ply: 3 components: 3 eigenvalues are zero, one for each (--weld joins \
                them into 1; `";
    assert!(run.stderr.contains(hint), "{}", run.stderr);
    // --weld and --strict exclude each other.
    let run = succeed(&folder, "spectrum pages.ply --strict -k 5");
    let hint = "(--weld instead of --strict joins them into 1; `";
    assert!(run.stderr.contains(hint), "{}", run.stderr);
    let run = succeed(&folder, "spectrum pages.ply --weld -k 5");
    assert!(!run.stderr.contains("eigenvalues are zero"), "{}", run.stderr);

    for mesh in ["pages.ply", "spheres.ply"] {
        let run = succeed(&folder, &format!("spectrum {mesh} -k 5"));
        let note = run.stderr.lines().find(|line| line.contains("components:")).unwrap();
        let extract = note.split('`').nth(1).unwrap();
        let extract = extract.strip_prefix("catamaran ").unwrap().replace("FILE", "one.ply");
        folder.succeed(&format!("{extract} --force"));
        assert_eq!(succeed(&folder, "spectrum one.ply -k 5").stderr, "");
    }
}

#[test]
fn boundary_conditions_count() {
    let folder = folder();
    let [grid, sphere] = [families::grid(8, 8).unwrap(), families::icosphere(2).unwrap()];
    write(&folder, "both.ply", beside(&[grid.clone(), sphere.clone()]));
    write(&folder, "grids.ply", beside(&[grid.clone(), grid]));
    write(&folder, "sphere.ply", sphere);
    for (mesh, says) in [
        ("both.ply", "2 components: 1 eigenvalue is zero, one for each without boundary"),
        ("grids.ply", "2 components, whose eigenvalues are in one list"),
        ("sphere.ply", "the mesh has no boundary"),
    ] {
        let run = succeed(&folder, &format!("spectrum {mesh} -k 5 --boundary dirichlet"));
        assert!(run.stderr.contains(&format!("note: {mesh}: {says}")), "{}", run.stderr);
    }
    let refused = folder.fail("shapedna both.ply both.ply -k 1 --dirichlet");
    let says = "1 eigenvalue is zero, one for each component without boundary: -k 1";
    assert!(refused.contains(says), "{refused}");
    let run = folder.run("unions predict grids.ply both.ply");
    assert_eq!(run.code, Some(1), "{}", run.stdout);
    assert!(run.stderr.contains("both.ply: a component is closed (1 of 2)"), "{}", run.stderr);
    folder.write("wanted.csv", "2\n2.1\n2.2\n");
    let run = succeed(&folder, "unions shape spheres.ply --spectrum wanted.csv --steps 1 -o x.ply");
    assert!(run.stderr.contains("6 components: 6 eigenvalues are zero"), "{}", run.stderr);
}

#[test]
fn vertices_in_no_face_are_noted_or_named_with_the_command_that_drops_them() {
    let alone = "v 0 0 0\nv 9 9 9\nv 1 0 0\nv 0 1 0\nf 1 3 4\n";
    // The repair drops the face without area, and leaves its vertices.
    let flat = format!("{alone}v 9 9 10\nv 9 9 12\nf 2 5 6\n");
    for (text, count) in [(alone, 1), (flat.as_str(), 3)] {
        let folder = Folder::new();
        folder.write("a.obj", text);
        let noted = succeed(&folder, "spectrum a.obj -k 3").stderr;
        assert!(noted.contains(&format!("note: a.obj: vertices in no face: {count}")), "{noted}");
        let refused = folder.run("basis a.obj -k 1 --order 1 -o b.npz");
        assert_eq!(refused.code, Some(1));
        assert!(refused.stderr.contains("a.obj: vertex 1 is in no face"), "{}", refused.stderr);
        for said in [noted, refused.stderr] {
            let compact = said.split('`').nth(1).unwrap().strip_prefix("catamaran ").unwrap();
            folder.succeed(&format!("{} --force", compact.replace("FILE", "b.obj")));
            assert_eq!(succeed(&folder, "spectrum b.obj -k 3").stderr, "");
            folder.succeed("basis b.obj -k 1 --order 1 -o b.npz --force");
        }
    }
}
