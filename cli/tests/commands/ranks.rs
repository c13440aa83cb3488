//! `mpirun catamaran`: each process has its part of the rows.
#![cfg(feature = "mpi")]

use std::process::Command;

use catamaran::io::{Output, Overwrite};
use catamaran_geometry::mesh::{families, io};

use crate::common::{Folder, Run};

/// `catamaran` in this folder, `ranks` times.
fn mpirun(folder: &Folder, ranks: usize, arguments: &str) -> Run {
    let program = folder.program();
    let mut command = Command::new(std::env::var("MPIRUN").unwrap_or_else(|_| "mpirun".into()));
    command.args(["-n", &ranks.to_string()]).arg(program.get_program());
    command.args(arguments.split_whitespace()).current_dir(folder.path("."));
    // Open MPI: in a container one is root, and has fewer cores than ranks.
    for name in ["ALLOW_RUN_AS_ROOT", "ALLOW_RUN_AS_ROOT_CONFIRM", "MCA_rmaps_base_oversubscribe"] {
        command.env(format!("OMPI_{name}"), "1");
    }
    Run::new(command.output().expect("mpirun starts"))
}

/// A table of small integers, whose sums are exact in any order.
fn table(rows: usize) -> String {
    let row = |i: usize| {
        let entries: Vec<String> =
            (0..9).map(|j| ((i * 31 + j * 17 + i * j) % 7).to_string()).collect();
        entries.join(",") + "\n"
    };
    (0..rows).map(row).collect()
}

#[test]
fn ranks_share_the_rows_and_give_the_same_product() {
    let folder = Folder::new();
    folder.write("a.csv", table(1001));
    assert_eq!(folder.run("ata a.csv -o one.csv").code, Some(0));
    for ranks in [2, 3] {
        let run = mpirun(&folder, ranks, &format!("ata a.csv -o {ranks}.csv --verify --threads 1"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        // One of them speaks.
        assert_eq!(run.stdout.matches("written").count(), 1, "{}", run.stdout);
        let read = |name: &str| std::fs::read(folder.path(name)).unwrap();
        assert!(read("one.csv") == read(&format!("{ranks}.csv")));
    }
}

#[test]
fn ranks_share_the_rows_and_solve_to_the_same_bytes() {
    let folder = Folder::new();
    folder.write("a.csv", table(1001));
    for command in [
        "lstsq a.csv --by-column 3,0 --intercept",
        "pca a.csv -k 3 --standardize --scores",
        "svd a.csv --left",
    ] {
        folder.succeed(&format!("{command} -o one.npz --force"));
        for ranks in [2, 3] {
            let arguments = format!("{command} -o {ranks}.npz --threads 1 --force");
            let run = mpirun(&folder, ranks, &arguments);
            assert_eq!(run.code, Some(0), "{}", run.stderr);
            assert_eq!(run.stdout.matches("written").count(), 1, "{}", run.stdout);
            let read = |name: &str| std::fs::read(folder.path(name)).unwrap();
            assert!(read("one.npz") == read(&format!("{ranks}.npz")), "{command}");
        }
    }
    let refused = mpirun(&folder, 2, "lstsq a.csv --by-column 99 -o no.npz");
    assert_ne!(refused.code, Some(0));
    assert!(refused.stderr.contains("a.csv: no column 99"), "{}", refused.stderr);
    assert!(!folder.path("no.npz").exists());
}

#[test]
fn ranks_share_the_eigenvectors_and_find_the_same_eigenvalues() {
    let folder = Folder::new();
    let output = Output::create(&folder.path("sphere.ply"), Overwrite::Never).unwrap();
    io::write(output, &families::icosphere(3).unwrap().into()).unwrap();
    folder.succeed("spectrum sphere.ply -k 12 -o 1.npz");
    let expected = folder.read_npz("1.npz", "eigenvalues").1;
    for (ranks, mass) in [(2, "lumped"), (3, "lumped"), (2, "full")] {
        let file = format!("{ranks}-{mass}.npz");
        let arguments = format!("spectrum sphere.ply -k 12 -o {file} --mass {mass} --threads 1");
        let run = mpirun(&folder, ranks, &arguments);
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        assert_eq!(run.stdout.matches("written").count(), 1, "{}", run.stdout);
        assert_eq!(folder.read_npz(&file, "eigenvectors").0, [642, 12]);
        let values = folder.read_npz(&file, "eigenvalues").1;
        // The masses change the values a little.
        let allowed = if mass == "lumped" { 1e-10 } else { 0.05 };
        let close = |(x, y): (&f64, &f64)| (x - y).abs() <= allowed * y.max(1e-2);
        assert!(values.iter().zip(&expected).all(close), "{values:?} {expected:?}");
    }
    let run = mpirun(&folder, 2, "spectrum sphere.ply -k 12 --memory 1 -o c.npz");
    assert_ne!(run.code, Some(0));
    let why = "--memory limits one process: it can't be combined with mpirun";
    assert!(run.stderr.contains(why), "{}", run.stderr);
    let run = mpirun(&folder, 2, "spectrum sphere.ply -k 643 -o c.npz");
    assert_ne!(run.code, Some(0));
    assert!(run.stderr.contains("k: 643 eigenpairs of a matrix of 642 rows"), "{}", run.stderr);
    assert!(!folder.path("c.npz").exists());
}

#[test]
fn more_ranks_than_rows_leave_some_idle() {
    let folder = Folder::new();
    folder.write("a.csv", "1,2\n");
    let run = mpirun(&folder, 3, "ata a.csv -o c.csv --center");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_eq!(std::fs::read_to_string(folder.path("c.csv")).unwrap(), "0.0,0.0\n0.0,0.0\n");
}

#[test]
fn an_error_on_any_rank_ends_all() {
    let folder = Folder::new();
    folder.write("a.csv", "1,2\n3,x\n");
    let run = mpirun(&folder, 2, "ata a.csv -o c.csv");
    assert_ne!(run.code, Some(0));
    // Whole, though every rank complains.
    let told =
        |line: &str| line.starts_with("catamaran: rank ") && line.contains("a.csv:2: column 2");
    assert!(run.stderr.lines().any(told), "{}", run.stderr);
    assert!(!folder.path("c.csv").exists());
}
