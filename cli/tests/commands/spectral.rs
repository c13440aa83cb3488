//! `catamaran basis`, `catamaran transfer` and `catamaran filter`.

use catamaran::io::{Output, Overwrite};
use catamaran_geometry::mesh::io::{MeshFile, Scalars, read, write};
use catamaran_geometry::mesh::{TriMesh, families};

use crate::common::{Folder, calls};

/// A closed surface without any symmetry, and the same with its vertices in another order.
fn meshes(folder: &Folder) -> (TriMesh, Vec<u32>) {
    let (mut vertices, faces) = families::icosphere(2).unwrap().into_parts();
    for p in &mut vertices {
        let [x, y, z] = *p;
        let r = 1.2
            + 0.25 * (3.0 * x + 1.0).sin()
            + 0.2 * (2.0 * y - x).cos()
            + 0.15 * (2.5 * z + y).sin();
        *p = [1.6 * r * x, 1.2 * r * y, r * z];
    }
    let n = vertices.len();
    // New vertex i is old vertex 5 i (mod n); 162 and 5 have no common divisor.
    let old: Vec<u32> = (0..n).map(|i| (5 * i % n) as u32).collect();
    let mut new = vec![0; n];
    for (i, &x) in old.iter().enumerate() {
        new[x as usize] = i as u32;
    }
    let shuffled = old.iter().map(|&x| vertices[x as usize].map(|c| 3.0 * c)).collect();
    let moved = faces.iter().map(|face| face.map(|x| new[x as usize])).collect();
    let target = TriMesh::new(shuffled, moved).unwrap();
    let source = TriMesh::new(vertices, faces).unwrap();
    for (name, mesh) in [("source.ply", &source), ("target.off", &target)] {
        let output = Output::create(&folder.path(name), Overwrite::Never).unwrap();
        write(output, &mesh.clone().into()).unwrap();
    }
    (source, old)
}

fn write_coordinates(folder: &Folder, mesh: &TriMesh) {
    folder.write_npy("xyz.npy", &[mesh.vertices().len() as u64, 3], &mesh.vertices().concat());
}

#[test]
fn the_basis_is_orthonormal_and_holds_the_products() {
    let folder = Folder::new();
    meshes(&folder);
    let said = folder.succeed("basis source.ply -k 4 --order 2 --mode ours* -o basis.npz");
    assert!(said.contains("15 functions of 15 products"), "{said}");
    let array = |name: &str| folder.read_npz("basis.npz", name).1;
    let (q, r, mass) = (array("functions"), array("r"), array("mass"));
    assert_eq!((q.len(), r.len(), mass.len()), (162 * 15, 15 * 15, 162));
    for a in 0..15 {
        for b in 0..15 {
            let product: f64 = (0..162).map(|i| mass[i] * q[15 * i + a] * q[15 * i + b]).sum();
            assert!((product - f64::from(u8::from(a == b))).abs() < 1e-11);
        }
    }
    assert_eq!(array("factors")[2 * 5..2 * 8], [1.0, 1.0, 1.0, 2.0, 1.0, 3.0]);
    assert_eq!(array("eigenvalues").len(), 5);

    let refusal = folder.fail("basis source.ply -k 4 -o basis.npz");
    assert!(refusal.contains("exists already"), "{refusal}");
    folder.succeed("basis source.ply -k 4 -o basis.npz --force");
    let refusal = folder.fail("basis source.ply -k 162 -o b.npz");
    assert!(refusal.contains("162 vertices"), "{refusal}");
    let refusal = folder.fail("basis none.ply -o b.npz");
    assert!(refusal.contains("none.ply"), "{refusal}");
}

#[test]
fn products_that_depend_on_each_other_name_the_mesh_and_the_mode_that_helps() {
    let folder = Folder::new();
    let output = Output::create(&folder.path("grid.ply"), Overwrite::Never).unwrap();
    write(output, &families::grid(16, 16).unwrap().into()).unwrap();
    let said = folder.fail("basis grid.ply -k 40 --order 3 -o b.npz");
    assert!(said.contains("grid.ply: --mode: a single pass over 12341 products"), "{said}");
    assert!(said.ends_with("; --mode rank-revealing leaves none\n"), "{said}");
    let line =
        "transfer grid.ply grid.ply --identity --details coordinates -k 40 --order 3 -o t.ply";
    let said = folder.fail(line);
    assert!(said.contains("grid.ply: --mode: a single pass over 12341 products"), "{said}");
    folder.succeed("basis grid.ply -k 40 --order 3 --mode rank-revealing -o b.npz");
}

#[test]
fn coordinates_are_transferred_along_points_and_landmarks() {
    let folder = Folder::new();
    let (source, points) = meshes(&folder);
    write_coordinates(&folder, &source);
    let target = |x: u32| points.iter().position(|&p| p == x).unwrap();
    let pairs: String = [0, 17, 60, 121].map(|x| format!("{x} {}\n", target(x))).concat();
    folder.write("pairs.txt", pairs);
    folder.write("points.txt", points.iter().map(|x| format!("{x}\n")).collect::<String>());
    let common = "transfer source.ply target.off --functions xyz.npy -k 10 --order 2";
    folder.succeed(&format!("{common} --points points.txt -o by_points.npy"));
    let found =
        format!("{common} --landmarks pairs.txt --zoom 40 -o found.npy --points-output found.txt");
    let said = folder.succeed(&found);
    assert!(said.contains("transfer    3 functions"), "{said}");
    let read_points = std::fs::read_to_string(folder.path("found.txt")).unwrap();
    let read_points: Vec<u32> = read_points.lines().map(|line| line.parse().unwrap()).collect();
    assert_eq!(read_points, points);
    let (a, b): (Vec<f64>, Vec<f64>) = (
        folder.read_npy("by_points.npy", &[points.len(), 3]),
        folder.read_npy("found.npy", &[points.len(), 3]),
    );
    // Other eigenfunctions were computed along, and so with other roundings.
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-8));
    // What comes out is near the coordinates of the corresponding vertices.
    let distance = |x: &[f64; 3], y: &[f64]| (0..3).map(|c| (x[c] - y[c]).powi(2)).sum::<f64>();
    let truth: Vec<[f64; 3]> = points.iter().map(|&x| source.vertices()[x as usize]).collect();
    let error: f64 = truth.iter().zip(a.chunks(3)).map(|(x, y)| distance(x, y)).sum();
    let norm: f64 = truth.iter().map(|x| distance(x, &[0.0; 3])).sum();
    assert!((error / norm).sqrt() < 0.05, "{}", (error / norm).sqrt());
    for how in ["none", "icp"] {
        folder.succeed(&format!("{common} --landmarks pairs.txt --refine {how} -o {how}.csv"));
    }
    // Too few to tell the sphere from its turned and mirrored images.
    folder.write("few.txt", format!("0 {}\n17 {}\n", target(0), target(17)));
    let run = folder.run(&format!("{common} --landmarks few.txt -o few.csv"));
    assert!(run.stderr.contains("note: 2 landmarks, where 3 are needed"), "{}", run.stderr);
    // Without a correspondence, a search finds the same points.
    let searched = format!("{common} --zoom 40 -o searched.npy --points-output searched.txt");
    let said = folder.succeed(&searched);
    assert!(said.contains("map         found by a search"), "{said}");
    let searched = std::fs::read_to_string(folder.path("searched.txt")).unwrap();
    assert!(searched.lines().map(|line| line.parse::<u32>().unwrap()).eq(points.iter().copied()));
    for how in ["none", "icp", "products"] {
        folder.succeed(&format!("{common} --refine {how} -o searched_{how}.csv"));
    }
    // By way of decimations, landmarks and points are those of the meshes.
    for known in ["", "--landmarks pairs.txt"] {
        let said = folder.succeed(&format!(
            "{common} {known} --zoom 30 --via-decimation 120 -o via.npy --points-output via.txt \
             --force"
        ));
        assert!(said.contains("source.ply: 162 vertices, represented by 120"), "{said}");
        let via: Vec<f64> = folder.read_npy("via.npy", &[points.len(), 3]);
        let found = std::fs::read_to_string(folder.path("via.txt")).unwrap();
        assert!(found.lines().all(|line| line.parse::<usize>().unwrap() < points.len()));
        let off: f64 = points
            .iter()
            .zip(via.chunks(3))
            .map(|(&x, y)| distance(&source.vertices()[x as usize], y))
            .sum();
        let norm: f64 =
            points.iter().map(|&x| distance(&source.vertices()[x as usize], &[0.0; 3])).sum();
        assert!((off / norm).sqrt() < 0.2, "{}", (off / norm).sqrt());
    }
    let refusal = folder.run(&format!("{common} --via-decimation 9 --identity -o never.csv"));
    assert_eq!(refusal.code, Some(2), "{}", refusal.stderr);
    assert!(refusal.stderr.contains("cannot be used with"), "{}", refusal.stderr);
    let refusal = folder.fail(&format!("{common} --operators -o never.csv"));
    assert!(refusal.contains("--operators is for --landmarks and --segments only"), "{refusal}");
    folder.succeed(
        "transfer source.ply source.ply --functions xyz.npy --identity -k 5 --order 1 -o same.npy",
    );
}

#[test]
fn operators_segments_and_products_find_the_points_too() {
    let folder = Folder::new();
    let (source, points) = meshes(&folder);
    write_coordinates(&folder, &source);
    let target = |x: u32| points.iter().position(|&p| p == x).unwrap();
    let pairs: String = [0, 17, 60].map(|x| format!("{x} {}\n", target(x))).concat();
    folder.write("pairs.txt", pairs);
    // Segments: the nearest of some vertices, in space.
    let nearest = |p: &[f64; 3]| {
        let square = |q: u32| -> f64 {
            let q = source.vertices()[q as usize];
            (0..3).map(|c| (p[c] - q[c]).powi(2)).sum()
        };
        [3_u32, 40, 77, 90, 141]
            .into_iter()
            .min_by(|&a, &b| square(a).total_cmp(&square(b)))
            .unwrap()
    };
    let labels: Vec<u32> = source.vertices().iter().map(nearest).collect();
    let lines = |labels: Vec<u32>| labels.iter().map(|l| format!("{l}\n")).collect::<String>();
    folder.write("a.txt", lines(labels.clone()));
    folder.write("b.txt", lines(points.iter().map(|&x| labels[x as usize]).collect()));
    let common = "transfer source.ply target.off --functions xyz.npy -k 10 --order 2 --force";
    for how in [
        "--landmarks pairs.txt --operators --refine products",
        "--landmarks pairs.txt --refine products --mode ours*",
        "--segments a.txt b.txt --refine products",
        "--segments a.txt b.txt --operators --zoom 40",
        "--segments a.txt b.txt --landmarks pairs.txt --operators --refine icp",
    ] {
        folder.succeed(&format!("{common} {how} -o out.npy --points-output found.txt"));
        let found = std::fs::read_to_string(folder.path("found.txt")).unwrap();
        let found: Vec<u32> = found.lines().map(|line| line.parse().unwrap()).collect();
        let right = found.iter().zip(&points).filter(|(a, b)| a == b).count();
        assert!(right >= 160, "{how}: {right} of 162");
    }
    folder.write("c.txt", lines(vec![5; 162]));
    folder.write("half.txt", "0.5\n".repeat(162));
    for (arguments, says) in [
        ("--segments a.txt c.txt", "a.txt, c.txt: labels: label 3 is on one of the meshes only"),
        ("--segments a.txt half.txt", "half.txt: row 0: 0.5 is not the number of a segment"),
        ("--segments a.txt pairs.txt", "pairs.txt: 3 rows for 162 vertices"),
        ("--identity --smooth-functions 3", "--smooth-functions is for --details heights only"),
    ] {
        let said = folder.fail(&format!("{common} {arguments} -o out.npy"));
        assert!(said.contains(says), "{said}");
    }
    for arguments in [
        "--identity --operators",
        "--points a.txt --landmarks pairs.txt",
        "--segments a.txt",
        "--identity --details heights",
    ] {
        let run = folder.run(&format!("{common} {arguments} -o out.npy"));
        assert_eq!(run.code, Some(2), "{arguments}: {}", run.stderr);
    }
}

#[test]
fn details_are_coordinates_or_heights() {
    let folder = Folder::new();
    let (source, points) = meshes(&folder);
    folder.write("points.txt", points.iter().map(|x| format!("{x}\n")).collect::<String>());
    let vertices = |name: &str| read(&folder.path(name)).unwrap().mesh;
    let before = vertices("target.off");
    let error = |found: &TriMesh, truth: &dyn Fn(usize) -> [f64; 3]| -> f64 {
        let square = |p: [f64; 3], q: [f64; 3]| (0..3).map(|c| (p[c] - q[c]).powi(2)).sum::<f64>();
        let errors = found.vertices().iter().enumerate().map(|(i, &p)| square(p, truth(i)));
        let sizes = (0..162).map(|i| square(truth(i), [0.0; 3]));
        (errors.sum::<f64>() / sizes.sum::<f64>()).sqrt()
    };
    let common = "transfer source.ply target.off --points points.txt -k 10 --order 2 --mode ours*";
    // The target is three times as large as the source, and the same otherwise.
    let said = folder.succeed(&format!("{common} --details coordinates -o c.ply --picture c.png"));
    assert!(said.contains("transfer    3 functions"), "{said}");
    let found = vertices("c.ply");
    assert_eq!(found.faces(), before.faces());
    let truth = |i: usize| source.vertices()[points[i] as usize];
    assert!(error(&found, &truth) < 0.02, "{}", error(&found, &truth));
    folder.succeed(&format!(
        "{common} --details heights --smooth-functions 5 -o h.obj --picture h.png"
    ));
    let found = vertices("h.obj");
    assert_eq!(found.faces(), before.faces());
    let truth = |i: usize| before.vertices()[i];
    assert!(error(&found, &truth) < 0.05, "{}", error(&found, &truth));
    // A smooth surface of as many functions as the transfer has is closer than one of the first
    // ones.
    folder.succeed(&format!("{common} --details heights --smooth-functions 1 -o flat.obj"));
    assert!(error(&vertices("flat.obj"), &truth) > error(&found, &truth));
    for picture in ["c.png", "h.png"] {
        assert_eq!(&std::fs::read(folder.path(picture)).unwrap()[1..4], b"PNG");
    }
    for (arguments, says) in [
        ("--details heights -o x.npy", "x.npy"),
        ("--details coordinates -o c.ply", "exists already"),
        ("--details heights --smooth-functions 162 -o x.ply", "162 vertices"),
    ] {
        let said = folder.fail(&format!("{common} {arguments}"));
        assert!(said.contains(says), "{said}");
    }
}

#[test]
fn one_coefficient_changes_by_a_share_of_the_size() {
    let folder = Folder::new();
    let (source, _) = meshes(&folder);
    write_coordinates(&folder, &source);
    let before = source.vertices().concat();
    let change = |arguments: &str| -> Vec<f64> {
        folder.succeed(&format!(
            "filter source.ply -k 10 --functions xyz.npy {arguments} -o out.npy --force"
        ));
        let after: Vec<f64> = folder.read_npy("out.npy", &[source.vertices().len(), 3]);
        after.iter().zip(&before).map(|(a, b)| a - b).collect()
    };
    for order in [1, 2] {
        let once = change(&format!("--coefficient 4 --share 0.2 --order {order}"));
        let back = change(&format!("--coefficient 4 --share -0.2 --order {order}"));
        let other = change(&format!("--coefficient 5 --share 0.2 --order {order}"));
        // Each column changes by the same function, which the other one is orthogonal to.
        for (row, back) in once.chunks(3).zip(back.chunks(3)) {
            assert!((row[0] - row[1]).abs() < 1e-12 && (row[0] - row[2]).abs() < 1e-12);
            assert!((row[0] + back[0]).abs() < 1e-12);
        }
        let areas = catamaran_geometry::mesh::vertex_areas(&source);
        let total: f64 = areas.iter().sum();
        let inner = |a: &[f64], b: &[f64]| -> f64 {
            (0..162).map(|i| areas[i] * a[3 * i] * b[3 * i]).sum()
        };
        let mean = |c: usize| (0..162).map(|i| areas[i] * before[3 * i + c]).sum::<f64>() / total;
        let square = |c: usize| -> f64 {
            (0..162).map(|i| areas[i] * (before[3 * i + c] - mean(c)).powi(2)).sum()
        };
        let size = ((square(0) + square(1) + square(2)) / 3.0).sqrt();
        assert!((inner(&once, &once).sqrt() / size - 0.2).abs() < 1e-9, "order {order}");
        assert!(inner(&once, &other).abs() < 1e-9 * size * size);
    }
    folder.succeed("filter source.ply -k 10 --coefficient 3 -o moved.ply --picture m.png");
    assert_eq!(read(&folder.path("moved.ply")).unwrap().mesh.faces(), source.faces());
    folder.write("short.csv", "1\n2\n");
    for (arguments, says) in [
        ("--coefficient 11", "the last frequency is number 10"),
        ("--low-pass 12", "--low-pass: 11 frequencies are computed; -k 11 or more is needed"),
        ("--high-pass 99", "--high-pass: 11 frequencies"),
        ("--band 9..12", "--band: 11 frequencies"),
        ("--low-pass 3 --share 0.1", "--share is for --coefficient only"),
        ("--heat 0.1 --amount 2", "--amount is for --sharpen only"),
        ("--order 2 --low-pass 99", "--low-pass: at most 66 frequencies are computed; a larger"),
        ("--order 2 --coefficient 66", "--coefficient 66: the last frequency is at most number 65"),
        ("--order 300 --heat 0.1", "--order: must be at most 255, is 300"),
        ("--heat 0.1 --functions short.csv -o x.csv --force", "short.csv: 2 rows for 162 vertices"),
    ] {
        let output = if arguments.contains(" -o ") { "" } else { "-o x.ply" };
        refused_before_eigenpairs(
            &folder,
            &format!("filter source.ply -k 10 {arguments} {output}"),
            says,
        );
    }
    for arguments in [
        "--coefficient 2 --low-pass 3",
        "--coefficient 0",
        "--coefficient 1 --share inf",
        "--heat -1",
        "--sharpen nan",
        "--sharpen 1 --amount inf",
    ] {
        let run = folder.run(&format!("filter source.ply -k 10 {arguments} -o x.ply"));
        assert_eq!(run.code, Some(2), "{}", run.stderr);
    }
    for (arguments, says) in [
        ("-o b.txt", "b.txt: "),
        ("-k 100 --order 12 -o b.npz", "--order: 100 functions have more than 2^32 - 1 products"),
    ] {
        refused_before_eigenpairs(&folder, &format!("basis source.ply {arguments}"), says);
    }
}

/// Runs a command that fails because of its options, before it has computed eigenpairs.
fn refused_before_eigenpairs(folder: &Folder, arguments: &str, says: &str) {
    let run = folder.run(arguments);
    assert_eq!(run.code, Some(1), "{arguments}: {}", run.stderr);
    assert!(run.stderr.contains(says), "{arguments}: {}", run.stderr);
    assert!(!run.stdout.contains("eigenpairs"), "{arguments}: {}", run.stdout);
}

#[test]
fn transfer_refuses_what_does_not_fit() {
    let folder = Folder::new();
    let (source, _) = meshes(&folder);
    write_coordinates(&folder, &source);
    folder.write("short.txt", "1\n2\n");
    folder.write("outside.txt", "0 0\n1 162\n");
    folder.write("fork.txt", "0 5\n3 3\n0 5\n0 6\n");
    folder.write("join.txt", "1 5\n0 5\n");
    folder.write("one.csv", "1,2\n3,4\n");
    folder.write("s.csv", "0\n".repeat(161) + "1\n");
    folder.write("t.csv", "0\n".repeat(162));
    folder.write("nan.csv", &("1,2\n".repeat(160) + "3,nan\n5,6\n"));
    folder.write("s.mtx", "%%MatrixMarket matrix coordinate real general\n162 1 1\n1 1 2.5\n");
    let common = "transfer source.ply target.off -k 5 -o out.npy";
    for (arguments, says) in [
        ("--functions xyz.npy --points short.txt", "short.txt: 2 rows"),
        ("--functions xyz.npy --landmarks outside.txt", "outside.txt: row 1: 162"),
        ("--functions xyz.npy --landmarks short.txt", "short.txt: 1 columns"),
        (
            "--functions xyz.npy --landmarks fork.txt",
            "fork.txt: rows 0 and 3 (from 0): vertex 0 of the source has the partners 5 and 6",
        ),
        (
            "--functions xyz.npy --landmarks join.txt",
            "join.txt: rows 0 and 1 (from 0): vertex 5 of the target has the partners 1 and 0",
        ),
        ("--functions one.csv --identity", "one.csv: 2 rows"),
        ("--functions s.mtx --identity", "s.mtx: the matrix must be dense, but is sparse"),
        ("--functions nan.csv --identity", "nan.csv:161: column 2: \"nan\" where a number"),
        ("--functions xyz.npy --identity --order 300", "--order: must be at most 255, is 300"),
        ("--functions xyz.npy --segments s.csv t.csv", "s.csv, t.csv: labels: label 1 is on one"),
    ] {
        refused_before_eigenpairs(&folder, &format!("{common} {arguments}"), says);
    }
    // Without a correspondence one is searched for.
    let run = folder.run(&format!("{common} --functions xyz.npy"));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stdout.contains("found by a search"), "{} {}", run.stdout, run.stderr);
}

#[test]
fn refinements_without_effect_are_refused() {
    let folder = Folder::new();
    let transfer = "transfer none.obj none.obj --details heights -o o.obj";
    for options in [
        "--identity --refine icp",
        "--points p.txt --refine icp",
        "--identity --zoom 40",
        "--landmarks p.txt --refine icp --zoom 40",
    ] {
        let run = folder.run(&format!("{transfer} {options}"));
        assert_eq!(run.code, Some(2), "{options}: {}", run.stderr);
        assert!(run.stderr.contains("--refine") || run.stderr.contains("--zoom"), "{options}");
    }
    let refused = folder.fail(&format!("{transfer} --landmarks p.txt -k 30 --zoom 10"));
    assert!(refused.contains("--zoom 10: must be at least the 30 of -k"), "{refused}");
}

#[test]
fn bases_of_nothing_are_refused() {
    let folder = Folder::new();
    for arguments in [
        "basis none.obj -k 0 -o b.npz",
        "basis none.obj --order 0 -o b.npz",
        "filter none.obj --low-pass 1 -k 0 -o b.obj",
        "filter none.obj --low-pass 1 --order 0 -o b.obj",
        "transfer none.obj none.obj --identity --details heights -k 0 -o b.obj",
        "transfer none.obj none.obj --identity --details heights --order 0 -o b.obj",
        "transfer none.obj none.obj --identity --details heights --target-k 0 -o b.obj",
    ] {
        let run = folder.run(arguments);
        assert_eq!(run.code, Some(2), "{arguments}: {}", run.stderr);
        assert!(run.stderr.contains("expected a whole number of at least 1"), "{}", run.stderr);
    }
}

#[test]
fn filters_smooth_sharpen_and_split() {
    let folder = Folder::new();
    let (source, _) = meshes(&folder);
    write_coordinates(&folder, &source);
    let energy = |mesh: &TriMesh| -> f64 {
        let edge = |a: u32, b: u32| -> f64 {
            let (p, q) = (mesh.vertices()[a as usize], mesh.vertices()[b as usize]);
            (0..3).map(|c| (p[c] - q[c]).powi(2)).sum()
        };
        mesh.faces().iter().map(|&[a, b, c]| edge(a, b) + edge(b, c) + edge(c, a)).sum()
    };
    let filtered = |arguments: &str, name: &str| {
        folder.succeed(&format!("filter source.ply {arguments} -o {name}"));
        read(&folder.path(name)).unwrap().mesh
    };
    let before = energy(&source);
    let low = filtered("--low-pass 5 -k 20", "low.obj");
    let heat = filtered("--heat 1e-2 -k 20 --order 1", "heat.ply");
    let sharp = filtered("--sharpen 1e-2 --amount 2 -k 20", "sharp.ply");
    let products = filtered("--heat 1e-2 -k 5 --order 2", "products.ply");
    assert!(energy(&low) < before && energy(&heat) < before && energy(&sharp) > before);
    assert!(energy(&products) < before);
    assert_eq!(low.faces(), source.faces());
    // What passes below and what passes above add up.
    for (arguments, name) in
        [("--low-pass 6", "a.npy"), ("--high-pass 6", "b.npy"), ("--band 0..6", "c.npy")]
    {
        folder
            .succeed(&format!("filter source.ply {arguments} -k 20 --functions xyz.npy -o {name}"));
    }
    let [a, b, c]: [Vec<f64>; 3] = ["a.npy", "b.npy", "c.npy"]
        .map(|name| folder.read_npy(name, &[source.vertices().len(), 3]));
    for (i, x) in source.vertices().concat().into_iter().enumerate() {
        assert!((a[i] + b[i] - x).abs() < 1e-12);
    }
    assert_eq!(a, c);
    assert_eq!(folder.run("filter source.ply --heat nan -o x.ply").code, Some(2));
}

#[test]
fn the_name_of_the_output_is_checked_before_any_input_is_read() {
    let folder = Folder::new();
    for (command, why) in [
        ("filter none.ply --low-pass 3 -o x.xyz", "x.xyz: unknown kind of mesh"),
        ("filter none.ply --low-pass 3 -o x.ply.xz", "x.ply.xz: .xz files can only be read"),
        ("filter none.ply --low-pass 3 --functions f.csv -o x.ply", "x.ply: unknown kind of file"),
        (
            "transfer none.ply target.ply --identity --details coordinates -o x.ply.xz",
            "x.ply.xz: .xz files can only be read",
        ),
    ] {
        let said = folder.fail(command);
        assert!(said.contains(why), "{command}: {said}");
    }
}

/// The mean of the vertices of each of so many components of the same size.
fn middles(mesh: &TriMesh, components: usize) -> Vec<[f64; 3]> {
    let n = mesh.vertices().len() / components;
    let mean = |points: &[[f64; 3]]| {
        [0, 1, 2].map(|k| points.iter().map(|p| p[k]).sum::<f64>() / points.len() as f64)
    };
    mesh.vertices().chunks(n).map(mean).collect()
}

#[test]
fn a_filter_moves_no_component_to_the_origin() {
    let folder = Folder::new();
    let spheres = families::spheres(4, 2).unwrap();
    let output = Output::create(&folder.path("spheres.ply"), Overwrite::Never).unwrap();
    write(output, &spheres.clone().into()).unwrap();
    let filters = ["--low-pass 2", "--band 0..2", "--low-pass 18", "--heat 1e-3"];
    let products = ["--low-pass 2 --order 2", "--heat 1e-3 --order 2"];
    for filter in filters.iter().chain(&products) {
        folder.succeed(&format!("filter spheres.ply {filter} -k 20 -o out.ply --force"));
        let found = middles(&read(&folder.path("out.ply")).unwrap().mesh, 4);
        for (i, middle) in found.iter().enumerate() {
            let off = (middle[0] - 3.0 * i as f64).abs().max(middle[1].abs()).max(middle[2].abs());
            assert!(off < 1e-3, "{filter}: component {i} at {middle:?}");
        }
    }
    // Pieces that shrink to points are said to.
    let run = folder.run("filter spheres.ply --low-pass 1 -k 20 -o points.ply");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stderr.contains("note: 4 of 4 components are points now"), "{}", run.stderr);
    // The other note is that of the number of components.
    assert_eq!(run.stderr.lines().count(), 2, "{}", run.stderr);
    let run = folder.run("filter spheres.ply --low-pass 17 -k 20 -o round.ply");
    assert!(!run.stderr.contains("are points now"), "{}", run.stderr);
    assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
}

#[test]
fn fewer_eigenfunctions_than_components_are_refused_with_the_reason() {
    let folder = Folder::new();
    let output = Output::create(&folder.path("spheres.ply"), Overwrite::Never).unwrap();
    write(output, &families::spheres(6, 1).unwrap().into()).unwrap();
    for command in [
        "filter spheres.ply --low-pass 3 -k 4 -o out.ply",
        "filter spheres.ply --heat 1e-3 -k 4 --order 2 -o out.ply",
        "basis spheres.ply -k 4 -o out.npz",
    ] {
        let said = folder.fail(command);
        for part in ["6 components", "-k 4 is too few", "5 or more is enough"] {
            assert!(said.contains(part), "{said}");
        }
    }
    folder.succeed("basis spheres.ply -k 5 -o out.npz");
}

#[test]
fn the_shortest_path_to_a_vertex_is_reported_and_written() {
    let folder = Folder::new();
    folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 3 0\nv 2 0.5 0\nv 9 9 9\nf 1 2 3\nf 2 4 3\n");
    let said = folder.succeed("distance a.obj --from 2,0 --to 3 -o d.npy --path-output path.obj");
    assert!(said.contains("path        2.118034e0 over 2 edges\n"), "{said}");
    let path = std::fs::read_to_string(folder.path("path.obj")).unwrap();
    assert_eq!(path, "v 0 0 0\nv 1 0 0\nv 2 0.5 0\nl 1 2 3\n");
    for (to, why) in [
        ("4 -o e.npy", "a.obj: --to: no edges lead to vertex 4"),
        ("5 -o e.npy", "a.obj: --to: vertex 5 is out of range: 5 vertices"),
        ("3 -o e.npy --path-output path.ply", "path.ply: the name must end in .obj"),
    ] {
        let said = folder.fail(&format!("distance a.obj --from 0 --to {to}"));
        assert!(said.contains(why), "{said}");
    }
    let said = folder.fail("distance a.obj --from 0,0,1 -o e.npy");
    assert!(said.contains("--from: vertex 0 twice"), "{said}");
}

#[test]
fn exact_distances_and_paths_are_those_of_the_unfolded_faces() {
    let folder = Folder::new();
    folder.write("rhombus.obj", "v 0 0 0\nv 1 -3 0\nv 2 0 0\nv 1 3 0\nf 1 2 3\nf 1 3 4\n");
    let said = folder.succeed(
        "distance rhombus.obj --from 1 --method exact --to 3,0 -o d.npy --path-output path.csv",
    );
    assert!(said.contains(&format!("{:.6e} in 3 straight parts", 6.0 + 10f64.sqrt())), "{said}");
    let exact = [10f64.sqrt(), 0.0, 10f64.sqrt(), 6.0];
    for (found, exact) in folder.read_npy::<f64>("d.npy", &[4, 1]).iter().zip(exact) {
        assert!((found - exact).abs() < 1e-12, "{found} and not {exact}");
    }
    let path = std::fs::read_to_string(folder.path("path.csv")).unwrap();
    let rows: Vec<Vec<f64>> = path
        .lines()
        .skip(1)
        .map(|row| row.split(',').map(|x| x.parse().unwrap()).collect())
        .collect();
    // From a tip of the rhombus over the middle of its diagonal to the other, and along a side.
    let expected = [[1.0, -3.0], [1.0, 0.0], [1.0, 3.0], [0.0, 0.0]];
    assert!(path.starts_with("x,y,z,face,a,b,c\n") && rows.len() == 4, "{path}");
    for (row, expected) in rows.iter().zip(expected) {
        assert!((row[0] - expected[0]).abs() < 1e-12 && (row[1] - expected[1]).abs() < 1e-12);
        assert!((row[4] + row[5] + row[6] - 1.0).abs() < 1e-12);
    }
    folder.succeed(
        "distance rhombus.obj --from 1 --method exact --to 3 -o e.npy --path-output path.obj",
    );
    let line = std::fs::read_to_string(folder.path("path.obj")).unwrap();
    assert!(line.starts_with("v 1 -3 0\n") && line.ends_with("l 1 2 3\n"), "{line}");
    folder.write(
        "two.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf 1 2 3\nf 4 5 6\n",
    );
    for (line, why) in [
        ("rhombus.obj --from 1 --to 3 -o f.npy --path-output path.csv", "for --method exact only"),
        ("rhombus.obj --from 1 --to 4 --method exact -o f.npy", "--to: vertex 4 is out of range"),
        ("two.obj --from 0 --to 1,4 --method exact -o f.npy", "no path over faces leads through"),
    ] {
        let said = folder.fail(&format!("distance {line}"));
        assert!(said.contains(why), "{said}");
    }
    // Along edges through several vertices.
    let said = folder.succeed("distance rhombus.obj --from 1 --method edges --to 3,0 -o g.npy");
    assert!(said.contains("over 3 edges"), "{said}");
}

#[test]
fn exact_distances_and_paths_start_and_end_inside_faces() {
    let folder = Folder::new();
    folder.write("rhombus.obj", "v 0 0 0\nv 1 -3 0\nv 2 0 0\nv 1 3 0\nf 1 2 3\nf 1 3 4\n");
    let run = |words: &[&str]| {
        let output =
            folder.program().args(["distance", "rhombus.obj"]).args(words).output().unwrap();
        let said = [output.stdout, output.stderr].concat();
        (output.status.success(), String::from_utf8(said).unwrap())
    };
    // The middle of the diagonal, in the second face, and the vertex 1 by its position.
    let from = "1 0.5 0.5 0";
    let (done, said) = run(&["--from", from, "--method", "exact", "-o", "d.npy"]);
    assert!(done, "{said}");
    for (found, exact) in folder.read_npy::<f64>("d.npy", &[4, 1]).iter().zip([1.0, 3.0, 1.0, 3.0])
    {
        assert!((found - exact).abs() < 1e-14, "{found} and not {exact}");
    }
    let exact = ["--method", "exact", "-o", "e.npy", "--force"];
    let to = "1 -2.9 0.3,0 0.25 0.25 0.5,3";
    let (done, said) = run(&[&["--from", from, "--to", to][..], &exact].concat());
    // To (1, -3), back to (1.25, -0.75), and to (1, 3).
    let length = 3.0 + f64::hypot(0.25, 2.25) + f64::hypot(0.25, 3.75);
    assert!(done && said.contains(&format!("path        {length:.6e} in")), "{said}");
    for (words, why) in [
        (&["--from", from, "-o", "f.npy"][..], "--from: points of faces are for --method exact"),
        (&["--from", "0", "--to", from, "-o", "f.npy"], "--to: points of faces are for"),
        (&["--from", "2 1 0 0", "--method", "exact", "-o", "f.npy"], "--from: face 2 is out of"),
        (&["--from", "1 1 1 0", "--method", "exact", "-o", "f.npy"], "wrong barycentric"),
        (&["--from", "1 1", "-o", "f.npy"], "expected a vertex, a face and three barycentric"),
        (
            &["--from", "0", "-o", "f.npy", "--path-output", "p.obj"],
            "needs a path: --to or --trace",
        ),
    ] {
        let (done, said) = run(words);
        assert!(!done && said.contains(why), "{said}");
    }
}

#[test]
fn geodesics_are_traced_from_a_point_in_a_direction() {
    let folder = Folder::new();
    folder.write("rhombus.obj", "v 0 0 0\nv 1 -3 0\nv 2 0 0\nv 1 3 0\nf 1 2 3\nf 1 3 4\n");
    let said = folder
        .succeed("distance rhombus.obj --from 1 --trace 0,2,0 --length 4.5 --path-output path.csv");
    let is_said = said.contains("trace       4.500000e0 to ") && said.contains(", on face 1\n");
    assert!(is_said, "{said}");
    let path = std::fs::read_to_string(folder.path("path.csv")).unwrap();
    let rows: Vec<Vec<f64>> = path
        .lines()
        .skip(1)
        .map(|row| row.split(',').map(|x| x.parse().unwrap()).collect())
        .collect();
    for (row, exact) in rows.iter().zip([-3.0, 0.0, 1.5]) {
        assert!((row[0] - 1.0).abs() < 1e-14 && (row[1] - exact).abs() < 1e-14, "{path}");
    }
    assert!(path.starts_with("x,y,z,face,a,b,c\n") && rows.len() == 3, "{path}");
    let said = folder.succeed("--json distance rhombus.obj --from 1 --trace 0,1,0 --length 7");
    for part in [r#""record":"trace""#, r#""end":"boundary""#, r#""direction":["#] {
        assert!(said.contains(part), "{said}");
    }
    let said = folder.succeed("distance rhombus.obj --from 1 --trace 0,1,0 --length 7");
    assert!(said.contains("6.000000e0 to ") && said.contains(", stopped at the boundary"));
    // With distances.
    let both = "distance rhombus.obj --from 1 --trace 0,1,0 --length 2 --method exact -o d.npy";
    folder.succeed(both);
    assert!((folder.read_npy::<f64>("d.npy", &[4, 1])[3] - 6.0).abs() < 1e-12);
    for (line, why) in [
        ("--from 1 --trace 0,1 --length 7", "expected 3 numbers separated by commas"),
        ("--from 1 --trace 0,0,1 --length 7", "--trace: points away from the surface at vertex 1"),
        ("--from 1 --trace 0,0,0 --length 7", "--trace: must be finite and not 0"),
        ("--from 1,2 --trace 0,1,0 --length 7", "--trace starts from one point: --from has 2"),
        ("--from 4 --trace 0,1,0 --length 7", "--from: vertex 4 is out of range"),
        ("--from 1 --trace 0,1,0", "--length"),
        ("--from 1 --length 7 -o e.npy", "--trace"),
        ("--from 1 --trace 0,1,0 --length 7 --to 3", "--to"),
        (
            "--from 1 --trace 0,1,0 --length 7 --method edges",
            "--method edges has no effect on --trace, which goes over faces: it is for -o",
        ),
        ("--from 1", "--output"),
    ] {
        let run = folder.run(&format!("distance rhombus.obj {line}"));
        assert!(run.code != Some(0) && run.stderr.contains(why), "{line}: {}", run.stderr);
    }
}

#[test]
fn distances_are_over_faces_or_along_edges() {
    let folder = Folder::new();
    let mesh = families::spheres(2, 3).unwrap();
    let output = Output::create(&folder.path("spheres.ply"), Overwrite::Never).unwrap();
    write(output, &mesh.clone().into()).unwrap();
    let n = mesh.vertices().len() / 2;
    let said = folder.succeed("distance spheres.ply --from 5 -o heat.npy --picture p.png");
    assert!(said.contains(&format!("{n} of {} vertices reached", 2 * n)), "{said}");
    assert_eq!(&std::fs::read(folder.path("p.png")).unwrap()[1..4], b"PNG");
    folder.succeed("distance spheres.ply --from 5 --method edges -o edges.npy");
    let (heat, edges): (Vec<f64>, Vec<f64>) =
        (folder.read_npy("heat.npy", &[2 * n, 1]), folder.read_npy("edges.npy", &[2 * n, 1]));
    assert_eq!((heat.len(), edges.len(), heat[5], edges[5]), (2 * n, 2 * n, 0.0, 0.0));
    for (v, p) in mesh.vertices().iter().enumerate().take(n) {
        let q = mesh.vertices()[5];
        let angle = (0..3).map(|k| p[k] * q[k]).sum::<f64>().clamp(-1.0, 1.0).acos();
        assert!((heat[v] - angle).abs() < 0.1, "{v}: {} and not {angle}", heat[v]);
        assert!(edges[v] >= 0.99 * angle && edges[v] <= 1.3 * angle, "{v}: {}", edges[v]);
    }
    assert!(heat[n..].iter().chain(&edges[n..]).all(|distance| *distance == f64::INFINITY));
    // From the nearest of several.
    folder.succeed(&format!("distance spheres.ply --from 5,{n} --method edges -o both.npy"));
    let both: Vec<f64> = folder.read_npy("both.npy", &[2 * n, 1]);
    assert!(both[..n] == edges[..n] && both[n] == 0.0 && both.iter().all(|x| x.is_finite()));
    for threads in [1, 2] {
        folder.succeed(&format!(
            "distance spheres.ply --from 5 --threads {threads} -o same.npy --force"
        ));
        assert_eq!(folder.read_npy::<f64>("same.npy", &[2 * n, 1]), heat);
    }
    for method in ["heat", "exact", "edges"] {
        let refused = folder
            .fail(&format!("distance spheres.ply --from {} --method {method} -o x.npy", 2 * n));
        assert!(
            refused.contains(&format!(
                "--from: vertex {} is out of range: {} vertices",
                2 * n,
                2 * n
            )),
            "{refused}"
        );
    }
    // Two faces in a plane, on which the distances are straight.
    folder.write("rhombus.obj", "v 0 0 0\nv 1 -3 0\nv 2 0 0\nv 1 3 0\nf 1 2 3\nf 1 3 4\n");
    folder.succeed("distance rhombus.obj --from 2 -o rhombus.npy");
    let exact = [2.0, 10f64.sqrt(), 0.0, 10f64.sqrt()];
    for (found, exact) in folder.read_npy::<f64>("rhombus.npy", &[4, 1]).iter().zip(exact) {
        assert!((found - exact).abs() < 1e-12, "{found} and not {exact}");
    }
    // Three pages on one edge, of which `intrinsic` makes nothing.
    let book = "v 0 0 0\nv 0 0 1\nv 1 0 0.5\nv 0 1 0.5\nv -1 0 0.5\nf 1 2 3\nf 1 2 4\nf 1 2 5\n";
    folder.write("book.obj", book);
    folder.succeed("distance book.obj --from 2 -o book.npy");
    let refused = folder.fail("distance book.obj --from 2 --laplacian intrinsic -o x.npy");
    assert!(refused.contains("the tufted Laplacian allows this"), "{refused}");
    folder.write("alone.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\n");
    let refused = folder.fail("distance alone.obj --from 0,3 -o x.npy");
    assert!(refused.contains("alone.obj: vertex 3 is in no face"), "{refused}");
    assert!(folder.fail("distance spheres.ply --from 5 -o heat.npy").contains("exists already"));
    assert!(folder.fail("distance spheres.ply --from 5 -o a.ply").contains("a.ply"));
    assert!(folder.fail("distance spheres.ply --from 5 --time 0 -o a.npy").contains("time"));
}

#[test]
fn descriptors_are_tables_with_a_row_for_each_vertex_that_poses_do_not_change() {
    let folder = Folder::new();
    let (source, _) = meshes(&folder);
    let n = source.vertices().len();
    write_coordinates(&folder, &source);
    // The same surface elsewhere, turned by a quarter.
    let moved = source.vertices().iter().map(|&[x, y, z]| [5.0 - y, x, z + 1.0]).collect();
    let output = Output::create(&folder.path("moved.ply"), Overwrite::Never).unwrap();
    write(output, &TriMesh::new(moved, source.faces().to_vec()).unwrap().into()).unwrap();
    for (kind, columns) in [
        ("hks -k 20 --scales 7", 7),
        ("wks -k 20 --scales 5", 5),
        ("gps -k 6", 6),
        ("shot --radius 0.9", 352),
        ("rings --radius 0.9 --rings 3 --functions xyz.npy", 12),
        ("hks", 100),
    ] {
        let tables = ["source", "moved"].map(|name| {
            let said = folder.succeed(&format!(
                "descriptors {name}.ply --kind {kind} -o table.npy --force --threads 2"
            ));
            assert!(said.contains(&format!("{n} vertices, {columns} columns")), "{said}");
            folder.read_npy::<f64>("table.npy", &[n, columns])
        });
        assert_eq!(tables[0].len(), n * columns, "{kind}");
        let size = tables[0].iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        // Eigenfunctions have their signs by chance.
        let (a, b) = (&tables[0], &tables[1]);
        let close = |(a, b): (&f64, &f64)| (a.abs() - b.abs()).abs() < 1e-6 * size;
        assert!(size > 0.0 && a.iter().zip(b).all(close), "{kind}");
    }
    let run = folder.run("descriptors source.ply --kind shot --radius 1e-9 -o zeros.npy");
    assert!(run.stderr.contains(&format!("{n} of {n} rows are 0")), "{}", run.stderr);
    let rings = "--kind rings --rings 3 --functions xyz.npy -o rings.npy --force";
    let run = folder.run(&format!("descriptors source.ply {rings} --radius 1e-9"));
    let note = format!("note: --radius 0.000000001: {n} of {n} rows have rings without vertices");
    assert!(run.stderr.contains(&note), "{}", run.stderr);
    let run = folder.run(&format!("descriptors source.ply {rings} --radius 0.9"));
    assert!(!run.stderr.contains("note: --radius"), "{}", run.stderr);
    folder.succeed("descriptors source.ply --kind wks -k 20 -o w.csv --picture p.png");
    assert_eq!(&std::fs::read(folder.path("p.png")).unwrap()[1..4], b"PNG");
    for (arguments, says) in [
        ("--kind shot -o x.npy", "--radius"),
        ("--kind hks --radius 1 -o x.npy", "--radius"),
        ("--kind shot --radius 1 -k 3 -o x.npy", "-k"),
        ("--kind rings --radius 1 --rings 3 -o x.npy", "--functions"),
        ("--kind rings --radius 1 --functions xyz.npy -o x.npy", "--rings"),
        ("--kind rings --rings 3 --functions xyz.npy -o x.npy", "--radius"),
        ("--kind hks --functions xyz.npy -o x.npy", "--functions"),
        ("--kind rings --radius 1 --rings 99999999999999 --functions xyz.npy -o x.npy", "--rings"),
        ("--kind gps --scales 3 -o x.npy", "--scales"),
        ("--kind shot --radius=-1 -o x.npy", "radius"),
        ("--kind hks -k 162 -o x.npy", "162 vertices"),
        ("--kind hks -o x.doc", "x.doc"),
        ("--kind hks -o w.csv", "exists already"),
    ] {
        let said = folder.fail(&format!("descriptors source.ply {arguments}"));
        assert!(said.contains(says), "{arguments}: {said}");
    }
}

#[test]
fn rings_have_shares_of_the_area_and_means_of_functions() {
    let folder = Folder::new();
    let n = meshes(&folder).0.vertices().len();
    folder.write_npy("ones.npy", &[n as u64, 1], &vec![1.0_f64; n]);
    let rings = "--kind rings --radius 2 --rings 2 --functions ones.npy";
    folder.succeed(&format!("descriptors source.ply {rings} -o rings.npy"));
    let found = folder.read_npy::<f64>("rings.npy", &[n, 4]);
    for row in found.as_chunks::<4>().0 {
        assert!((row[0] + row[2] - 1.0).abs() < 1e-12 && row[2] > 0.0, "{row:?}");
        assert!((row[1] - 1.0).abs() < 1e-12 && (row[3] - 1.0).abs() < 1e-12, "{row:?}");
    }
}

/// A surface without symmetry as modelling programs write it: quads with a fan of polygons at the
/// ends, colours, and two copies as objects.
fn write_foreign_files(folder: &Folder) {
    const AROUND: usize = 12;
    const RINGS: usize = 6;
    let point = |k: usize, i: usize| {
        let angle = std::f64::consts::TAU * i as f64 / AROUND as f64;
        let wide = 1.0 + 0.2 * k as f64;
        [wide * angle.cos() + 0.1 * (k * k) as f64, 1.3 * angle.sin(), 0.6 * k as f64]
    };
    let points: Vec<[f64; 3]> =
        (0..RINGS).flat_map(|k| (0..AROUND).map(move |i| point(k, i))).collect();
    let quad = |k: usize, i: usize| {
        let (next, up) = ((i + 1) % AROUND, AROUND * (k + 1));
        vec![k * AROUND + i, k * AROUND + next, up + next, up + i]
    };
    let mut faces: Vec<Vec<usize>> =
        (0..RINGS - 1).flat_map(|k| (0..AROUND).map(move |i| quad(k, i))).collect();
    faces.push((0..AROUND).rev().collect());
    faces.push((0..AROUND).map(|i| (RINGS - 1) * AROUND + i).collect());

    let numbers = |face: &[usize], first: usize| -> String {
        face.iter().map(|v| format!(" {}", v + first)).collect()
    };
    let mut ply = format!(
        "ply\nformat ascii 1.0\ncomment VCGLIB generated\nelement vertex {}\nproperty float x\n\
         property float y\nproperty float z\nproperty uchar red\nproperty uchar green\n\
         property uchar blue\nproperty uchar alpha\nproperty float quality\nelement face {}\n\
         property list uchar int vertex_indices\nproperty int flags\nend_header\n",
        points.len(),
        faces.len()
    );
    let mut off = format!("COFF\n# libigl\n{} {} 0\n", points.len(), faces.len());
    for [x, y, z] in &points {
        ply += &format!("{x} {y} {z} 255 102 51 255 0.5\n");
        off += &format!("{x} {y} {z} 255 102 51 255\n");
    }
    for face in &faces {
        ply += &format!("{}{} 0\n", face.len(), numbers(face, 0));
        off += &format!("{}{}\n", face.len(), numbers(face, 0));
    }
    let mut obj = String::from("# OBJ File Generated by Meshlab\nmtllib ./part.mtl\n");
    for (object, name) in ["Left", "Right"].into_iter().enumerate() {
        obj += &format!("o {name}\n");
        for [x, y, z] in &points {
            obj += &format!("v {} {y} {z} 1.0 0.4 0.2\n", x + 9.0 * object as f64);
        }
        obj += "usemtl red\n";
        for face in &faces {
            obj += &format!("f{}\n", numbers(face, 1 + object * points.len()));
        }
    }
    for (name, content) in [("foreign.ply", ply), ("foreign.off", off), ("foreign.obj", obj)] {
        folder.write(name, content);
    }
}

#[test]
fn quads_polygons_colours_and_objects_go_through_every_command() {
    let folder = Folder::new();
    write_foreign_files(&folder);
    for (name, copies) in [("foreign.ply", 1), ("foreign.off", 1), ("foreign.obj", 2)] {
        let before = read(&folder.path(name)).unwrap();
        let vertices = 72 * copies;
        // Two triangles for each of 60 quads, and ten for each of two polygons.
        assert_eq!(before.mesh.vertices().len(), vertices, "{name}");
        assert_eq!(before.mesh.faces().len(), 140 * copies, "{name}");
        folder.succeed(&format!("spectrum {name} -k 8 -o s.npz --force"));
        let said = folder.succeed(&format!("descriptors {name} --kind wks -k 20 -o d.npy --force"));
        assert!(said.contains(&format!("{vertices} vertices, 100 columns")), "{said}");
        folder.succeed(&format!("basis {name} -k 6 -o b.npz --force"));
        let itself = format!("transfer {name} {name} --identity -k 8");
        for command in [
            format!("filter {name} --heat 1e-3 -k 20"),
            format!("filter {name} --coefficient 2 -k 20"),
            format!("{itself} --details coordinates"),
            format!("{itself} --details heights --smooth-functions 6"),
        ] {
            folder.succeed(&format!("{command} -o out.obj --force"));
            let after = read(&folder.path("out.obj")).unwrap();
            assert_eq!(after.mesh.faces(), before.mesh.faces(), "{command}");
            assert_eq!(after.colors, before.colors, "{command}");
            assert_eq!(after.objects, before.objects, "{command}");
            assert_eq!(after.materials, before.materials, "{command}");
            assert_eq!(after.material_files, before.material_files, "{command}");
            assert_eq!(after.objects.is_some(), name == "foreign.obj");
        }
    }
}

#[test]
fn the_commands_of_the_guide_run() {
    let guide = include_str!("../../../docs/guide/spectra.md");
    let folder = Folder::new();
    for (name, pose) in [("man.ply", 0.2), ("woman.ply", 0.7)] {
        let output = Output::create(&folder.path(name), Overwrite::Never).unwrap();
        write(output, &families::figure(1, pose).unwrap().into()).unwrap();
    }
    let figure = families::figure(1, 0.2).unwrap();
    let n = figure.vertices().len();
    let lines = |line: &dyn Fn(usize) -> String| (0..n).map(line).collect::<String>();
    folder.write("f.csv", lines(&|v| format!("{}\n", figure.vertices()[v][2])));
    let part = |v: usize| {
        let [x, _, z] = figure.vertices()[v];
        format!("{}\n", u8::from(x > 0.0) + 2 * u8::from(z > 7.0))
    };
    folder.write("man.txt", lines(&part));
    folder.write("woman.txt", lines(&part));
    folder.write("pairs.txt", "0 0\n40 40\n90 90\n120 120\n");
    for line in calls(guide) {
        folder.succeed(line);
    }
}

#[test]
fn functions_are_those_of_a_mesh_file_or_of_freesurfer() {
    let folder = Folder::new();
    let mut file = MeshFile::from(families::icosphere(2).unwrap());
    let heights: Vec<f64> = file.mesh.vertices().iter().map(|p| p[2]).collect();
    let magic = [&[255u8; 3][..], &162u32.to_be_bytes(), &[0; 4], &1u32.to_be_bytes()].concat();
    let values = heights.iter().flat_map(|&z| (z as f32).to_be_bytes());
    std::fs::write(folder.path("lh.thickness"), [magic, values.collect()].concat()).unwrap();
    file.scalars = vec![Scalars { name: "height".into(), values: heights }];
    write(Output::create(&folder.path("a.gii"), Overwrite::Never).unwrap(), &file).unwrap();
    let report = folder.succeed("mesh a.gii");
    assert!(report.contains("scalars"), "{report}");
    let smooth = |functions: &str, output: &str| -> Vec<f64> {
        folder.succeed(&format!("filter a.gii --low-pass 4 --functions {functions} -o {output}"));
        folder.read_npy(output, &[162, 1])
    };
    let by_mesh = smooth("a.gii", "mesh.npy");
    let by_thickness = smooth("lh.thickness", "thickness.npy");
    // MGH: the version, three sizes, a frame, single precision, and no place in space.
    let mut mgh = [1u32, 162, 1, 1, 1, 3, 0].map(u32::to_be_bytes).concat();
    mgh.resize(284, 0);
    let curv = std::fs::read(folder.path("lh.thickness")).unwrap();
    folder.write("lh.thickness.mgh", [&mgh[..], &curv[15..]].concat());
    assert_eq!(smooth("lh.thickness.mgh", "mgh.npy"), by_thickness);
    // The content decides: these names are those of a surface, of a table and of nothing known.
    for name in ["lh.area.pial", "thickness.csv", "lh.jacobian_white"] {
        std::fs::copy(folder.path("lh.thickness"), folder.path(name)).unwrap();
        assert_eq!(smooth(name, &format!("{name}.npy")), by_thickness, "{name}");
    }
    folder.write("broken.mgz", "any");
    write(Output::create(&folder.path("a.3mf"), Overwrite::Never).unwrap(), &file).unwrap();
    for (name, says) in [
        ("broken.mgz", "broken.mgz: is no file of values (MGH): damaged, or another one"),
        ("a.3mf", "a.3mf: has no values of vertices"),
    ] {
        let said = folder.fail(&format!("filter a.gii --low-pass 4 --functions {name} -o b.npy"));
        assert!(said.contains(says), "{name}: {said}");
    }
    // Heights are a combination of the first three eigenfunctions.
    for (v, (a, b)) in by_mesh.iter().zip(&by_thickness).enumerate() {
        let z = file.scalars[0].values[v];
        assert!((a - z).abs() < 0.05 && (b - z).abs() < 0.05, "{v}: {a}, {b}, {z}");
    }
    let array = |rows: usize| {
        format!(
            "<DataArray Intent=\"NIFTI_INTENT_SHAPE\" DataType=\"NIFTI_TYPE_FLOAT32\" \
             Dimensionality=\"1\" Dim0=\"{rows}\" Encoding=\"ASCII\"><Data>{}</Data></DataArray>",
            "1 ".repeat(rows)
        )
    };
    folder.write("uneven.gii", format!("<GIFTI>{}{}</GIFTI>", array(162), array(163)));
    let refusal = folder.fail("filter a.gii --low-pass 4 --functions uneven.gii -o b.npy");
    assert!(refusal.contains("163 values of \"shape\", and 162"), "{refusal}");
}
