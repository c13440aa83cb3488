//! `catamaran spectrum`, from outside.

use crate::common::Folder;

#[cfg(feature = "hdf5")]
use catamaran::faer::Mat;
#[cfg(feature = "hdf5")]
use catamaran::io::RowFile;
use catamaran::io::{Output, Overwrite};
#[cfg(feature = "hdf5")]
use catamaran::rows::RowBlocks;
use catamaran_geometry::mesh::{TriMesh, families, io};

fn write(folder: &Folder, name: &str, mesh: TriMesh) {
    let output = Output::create(&folder.path(name), Overwrite::Never).unwrap();
    io::write(output, &mesh.into()).unwrap();
}

#[test]
fn a_sphere_has_the_multiplets_of_spherical_harmonics() {
    let folder = Folder::new();
    write(&folder, "sphere.ply", families::icosphere(4).unwrap());
    let said = folder.succeed("spectrum sphere.ply -k 16 -o s.npz --verify --threads 2");
    assert!(said.contains("2562 vertices, 2562 of them free"), "{said}");
    assert!(said.contains("written     ") && said.contains("residual    "), "{said}");
    let (shape, values) = folder.read_npz("s.npz", "eigenvalues");
    assert_eq!(shape, [16]);
    for (i, value) in values.iter().enumerate() {
        let l = f64::from(i.isqrt() as u32);
        assert!((value - l * (l + 1.0)).abs() <= 0.01 * l * (l + 1.0) + 1e-9, "{i}: {value}");
    }
    assert_eq!(folder.read_npz("s.npz", "eigenvectors").0, [2562, 16]);
    assert!(folder.read_npz("s.npz", "residuals").1.iter().all(|r| *r <= 1e-9));
    // The same bytes with another number of threads.
    folder.succeed("spectrum sphere.ply -k 16 -o one.npz --verify --threads 1");
    assert_eq!(
        folder.read_npz("one.npz", "eigenvectors"),
        folder.read_npz("s.npz", "eigenvectors")
    );
}

#[test]
fn a_file_without_faces_is_a_point_cloud() {
    let folder = Folder::new();
    let points = families::icosphere(3).unwrap().into_parts().0;
    let lines: String = points.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    folder.write("cloud.obj", &lines);
    folder.succeed("spectrum cloud.obj -k 4 -o s.npz");
    let values = folder.read_npz("s.npz", "eigenvalues").1;
    assert!(values[0].abs() < 1e-9 && values[1..].iter().all(|x| (x - 2.0).abs() < 0.1));
    for option in ["--mass full", "--via-decimation 99"] {
        let said = folder.fail(&format!("spectrum cloud.obj -k 4 -o t.npz {option}"));
        assert!(said.contains("cloud.obj: has no faces, which --via-decimation"), "{said}");
    }
}

#[test]
fn a_decimation_gives_nearly_the_same_pairs_and_its_errors_are_told() {
    let folder = Folder::new();
    write(&folder, "torus.ply", families::torus(90, 40, 1.0, 0.4).unwrap());
    folder.succeed("spectrum torus.ply -k 12 -o all.npz");
    let said = folder.succeed(
        "spectrum torus.ply -k 12 --via-decimation 600 -o few.npz --picture few.png --threads 2",
    );
    assert!(said.contains("decimation  to 600 vertices: the pairs are approximate"), "{said}");
    let [all, few] = ["all.npz", "few.npz"].map(|file| folder.read_npz(file, "eigenvalues").1);
    for (i, (exact, found)) in all.iter().zip(&few).enumerate().skip(1) {
        let error = found / exact - 1.0;
        assert!((-1e-9..2e-3).contains(&error), "{i}: {error:e}");
    }
    assert_eq!(folder.read_npz("few.npz", "eigenvectors").0, [3600, 12]);
    for (arguments, named) in [
        ("--via-decimation 9", "--via-decimation 9: too few vertices for the 12 eigenpairs of -k"),
        ("--via-decimation 600 --boundary dirichlet", "--via-decimation needs --boundary neumann"),
        ("--via-decimation 600 --shift 1", "cannot be used with '--shift"),
        ("--via-decimation 2", "--via-decimation 2: too few vertices for the 12 eigenpairs of -k"),
    ] {
        let refused = folder.run(&format!("spectrum torus.ply -k 12 -o no.npz {arguments}"));
        assert_ne!(refused.code, Some(0));
        assert!(refused.stderr.contains(named), "{arguments}: {}", refused.stderr);
        assert!(!folder.path("no.npz").exists());
    }
}

#[test]
fn a_tolerance_that_is_not_reached_is_an_error_that_names_the_pair_and_its_residual() {
    let folder = Folder::new();
    // Every second column of a grid is 1e-7 from the one before it: weights of 1e6.
    let (mut vertices, faces) = families::grid(5, 5).unwrap().into_parts();
    for p in &mut vertices {
        let column = (5.0 * p[0]).round();
        p[0] = (column / 2.0).floor() + 1e-7 * (column % 2.0);
    }
    write(&folder, "thin.ply", TriMesh::new(vertices, faces).unwrap());
    let run = folder.run("spectrum thin.ply -k 8 --tolerance 1e-12 --verify -o s.npz");
    assert_eq!(run.code, Some(1), "{}", run.stdout);
    let residuals = folder.read_npz("s.npz", "residuals").1;
    let worst = (0..8).max_by(|&i, &j| residuals[i].total_cmp(&residuals[j])).unwrap();
    let residual = residuals[worst];
    assert!(residual > 1e-9, "{residuals:?}");
    let said = format!("eigenpair {worst} (from 0) has a residual of {residual:.1e}, above the");
    assert!(run.stderr.contains(&said) && run.stderr.contains("1e-12"), "{}", run.stderr);
    // Where none is asked for there is a note.
    let run = folder.run("spectrum thin.ply -k 8 -o default.npz");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stderr.contains("note: thin.ply") && run.stderr.contains("1e-9"), "{}", run.stderr);
    // One that can be reached is.
    let said = folder.succeed("spectrum thin.ply -k 8 --tolerance 1e-5");
    assert!(said.contains("residual    "), "{said}");
}

#[test]
fn options_change_the_problem() {
    let folder = Folder::new();
    folder.write(
        "square.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv .5 .5 0\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n",
    );
    // One vertex inside: its weights sum to 4, a third of the area is its mass.
    let said = folder.succeed("spectrum square.obj -k 1 --boundary dirichlet -o d.npz");
    assert!(said.contains("5 vertices, 1 of them free"), "{said}");
    assert!((folder.read_npz("d.npz", "eigenvalues").1[0] - 12.0).abs() < 1e-12);
    let (shape, vectors) = folder.read_npz("d.npz", "eigenvectors");
    assert_eq!((shape, &vectors[..4]), (vec![5, 1], &[0.0; 4][..]));
    let kinds = ["--laplacian intrinsic", "--laplacian tufted", "--laplacian cotangent"];
    for option in kinds.into_iter().chain(["--mass full", "--shift 7"]) {
        let said = folder.succeed(&format!("spectrum square.obj -k 2 {option}"));
        assert!(said.contains("eigenpairs  2 in "), "{said}");
    }
}

/// Returns a sheet of 24 x 24 vertices, each column twice at a distance of 1e-9. Cotangents of 1e9
/// hide the others: residuals of 40 eigenpairs stay above 1e-2 with AVX2 and with plain Rust.
fn sheet_with_slivers() -> TriMesh {
    const SIDE: usize = 24;
    let columns = (0..2 * SIDE).map(|i| (i / 2, (i / 2) as f64 + [0.0, 1e-9][i % 2]));
    let vertices = columns.flat_map(|(i, x)| {
        (0..SIDE).map(move |j| {
            let shift = 0.074 * ((7 * j + 3 * i) % 5) as f64;
            [x, j as f64 + shift, 0.3 * (i * j % 3) as f64]
        })
    });
    let faces = (0..2 * SIDE - 1).flat_map(|i| {
        (0..SIDE - 1).flat_map(move |j| {
            let p = (i * SIDE + j) as u32;
            let right = p + SIDE as u32;
            [[p, right, right + 1], [p, right + 1, p + 1]]
        })
    });
    TriMesh::new(vertices.collect(), faces.collect()).unwrap()
}

#[test]
fn slivers_whose_eigenpairs_are_inexact_need_the_intrinsic_laplacian() {
    let folder = Folder::new();
    write(&folder, "sheet.ply", sheet_with_slivers());
    for command in [
        "spectrum sheet.ply -k 40 -o s.npz",
        "transfer sheet.ply sheet.ply --identity --details coordinates -k 39 -o t.ply",
    ] {
        let said = folder.fail(command);
        assert!(said.contains("residuals of 1e-9 were not reached (long thin tri"), "{said}");
        folder.succeed(&format!("{command} --laplacian intrinsic"));
    }
}

#[test]
fn a_shift_may_be_an_eigenvalue() {
    let folder = Folder::new();
    write(&folder, "torus.ply", families::torus(40, 20, 2.0, 0.7).unwrap());
    folder.succeed("spectrum torus.ply -k 9 -o plain.npz");
    let plain = folder.read_npz("plain.npz", "eigenvalues").1;
    for shift in ["0", "1e-8", "-1e-12"] {
        folder.succeed(&format!("spectrum torus.ply -k 9 --shift={shift} -o near.npz --force"));
        let near = folder.read_npz("near.npz", "eigenvalues").1;
        assert_eq!(near.len(), 9);
        assert!(near.iter().zip(&plain).all(|(a, b)| (a - b).abs() < 1e-9), "{shift}: {near:?}");
    }
    let shift = plain[8];
    folder.succeed(&format!("spectrum torus.ply -k 1 --shift={shift:.15e} -o near.npz --force"));
    assert!((folder.read_npz("near.npz", "eigenvalues").1[0] - shift).abs() < 1e-9);
    let said = folder.fail("spectrum torus.ply -k 1 --shift 1e300 -o far.npz");
    assert!(
        said.contains("torus.ply: residuals of 1e-9 were not reached near --shift 1e300"),
        "{said}"
    );
}

#[test]
#[cfg(feature = "hdf5")]
fn hdf5_holds_the_same_arrays() {
    let folder = Folder::new();
    write(&folder, "sphere.ply", families::icosphere(3).unwrap());
    folder.succeed("spectrum sphere.ply -k 9 -o s.npz");
    folder.succeed("spectrum sphere.ply -k 9 -o s.h5");
    for name in ["eigenvalues", "eigenvectors", "residuals"] {
        let mut rows = RowFile::open(folder.path(&format!("s.h5:{name}"))).unwrap();
        let (m, n) = (rows.nrows(), rows.ncols());
        let mut found = Mat::<f64>::zeros(m, n);
        rows.read(0, found.as_mut()).unwrap();
        let (shape, expected) = folder.read_npz("s.npz", name);
        assert_eq!(shape.iter().product::<usize>(), m * n);
        assert!((0..m * n).all(|i| found[(i / n, i % n)] == expected[i]), "{name}");
    }
    assert!(folder.fail("spectrum sphere.ply -k 9 -o s.h5").contains("exists already"));
    folder.succeed("spectrum sphere.ply -k 2 -o s.h5 --force");
}

#[test]
#[cfg(not(feature = "hdf5"))]
fn hdf5_that_is_not_built_in_is_refused_before_any_work() {
    let folder = Folder::new();
    let refused = folder.fail("spectrum none.ply -k 9 -o s.h5");
    assert!(refused.contains("s.h5: HDF5 is not part of this program"), "{refused}");
}

#[test]
fn numbers_that_are_none_are_refused_with_what_is_expected() {
    let folder = Folder::new();
    for value in ["-1", "1.5", "many"] {
        let run = folder.run(&format!("spectrum a.obj -k {value}"));
        assert_eq!(run.code, Some(2));
        let why =
            format!("error: invalid value '{value}' for '-k <NUMBER>': expected a whole number");
        assert!(run.stderr.starts_with(&why), "{}", run.stderr);
        assert!(run.stderr.ends_with("try '--help'.\n"), "{}", run.stderr);
    }
    let run = folder.run("spectrum a.obj --threads 0");
    assert!(run.stderr.contains("'--threads <N>': expected at least 1"), "{}", run.stderr);
    let run = folder.run("spectrum a.obj --memory -1");
    assert!(run.stderr.contains("expected a number of GiB above 0"), "{}", run.stderr);
}

#[test]
fn too_little_memory_is_said_in_the_unit_of_the_option() {
    let folder = Folder::new();
    folder.succeed("generate torus 40 20 2 0.8 -o t.ply");
    let message = folder.fail("spectrum t.ply -k 20 --memory 0.00001");
    let why = message.strip_prefix("catamaran: t.ply: --memory: must be at least ").unwrap();
    let least = why.strip_suffix(" GiB\n").unwrap();
    assert!((0.0001..0.1).contains(&least.parse::<f64>().unwrap()), "{message}");
    folder.succeed(&format!("spectrum t.ply -k 20 --memory {least}"));
    let message = folder.fail("spectrum t.ply -k 20 --shift 1 --memory 0.00001");
    assert!(message.contains("--memory: 10737 bytes are too little for 20 pairs"), "{message}");
    assert!(message.ends_with("(the unit of the option is GiB, 1073741824 bytes)\n"), "{message}");
}

#[test]
fn refusals_say_what_is_wrong_and_write_nothing() {
    let folder = Folder::new();
    folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let message = folder.fail("spectrum a.obj -k 4 -o s.npz");
    assert!(message.contains("a.obj: -k 4, where 3 vertices are free"), "{message}");
    let message = folder.fail("spectrum a.obj -o s.npz");
    assert!(message.contains("a.obj: -k 100 (the default), where 3 vertices are"), "{message}");
    assert!(folder.fail("spectrum a.obj -k 1 -o s.txt").contains("must end in .npz, .h5"));
    assert!(folder.fail("spectrum none.obj -k 1 -o s.npz").contains("none.obj"));
    folder.succeed("spectrum a.obj -k 1 -o s.npz");
    assert!(folder.fail("spectrum a.obj -k 1 -o s.npz").contains("exists already"));
    folder.succeed("spectrum a.obj -k 2 -o s.npz --force");
    assert_eq!(folder.read_npz("s.npz", "eigenvalues").0, [2]);
}
