//! `mpirun catamaran`: each process has its part of the rows.
#![cfg(feature = "mpi")]

use std::process::Command;

use catamaran::io::{Output, Overwrite};
use catamaran_geometry::mesh::{families, io};

use crate::common::{Folder, Run};

/// `catamaran` in this folder, `ranks` times.
fn mpirun(folder: &Folder, ranks: usize, arguments: &str) -> Run {
    Run::new(launcher(folder, ranks, arguments).output().expect("mpirun starts"))
}

/// The launcher of [`mpirun`].
fn launcher(folder: &Folder, ranks: usize, arguments: &str) -> Command {
    let mut command = launcher_of_mpi(folder);
    command.args(["-n", &ranks.to_string()]).arg(folder.program().get_program());
    command.args(arguments.split_whitespace());
    command
}

/// The launcher, without arguments.
fn launcher_of_mpi(folder: &Folder) -> Command {
    let mut command = Command::new(std::env::var("MPIRUN").unwrap_or_else(|_| "mpirun".into()));
    command.current_dir(folder.path("."));
    // Open MPI: in a container one is root, and has fewer cores than ranks.
    for name in ["ALLOW_RUN_AS_ROOT", "ALLOW_RUN_AS_ROOT_CONFIRM", "MCA_rmaps_base_oversubscribe"] {
        command.env(format!("OMPI_{name}"), "1");
    }
    // hwloc's plugin for OpenCL may load LLVM, which takes SIGUSR1 from Open MPI's mpirun.
    command.env("HWLOC_COMPONENTS", "-opencl");
    command
}

/// The lines in which the program complains.
fn complaints(run: &Run) -> Vec<&str> {
    run.stderr.lines().filter(|line| line.starts_with("catamaran: ")).collect()
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
fn ranks_leave_out_the_same_rows_and_have_the_same_columns_of_factors() {
    let folder = Folder::new();
    let row = |i: usize| {
        let word = ["north", "south", "east"][i % 3];
        let cell = if i % 11 == 4 { String::new() } else { (i * 7 % 5).to_string() };
        format!("{},{cell},{},{word}\n", i * 31 % 7, i * i % 13)
    };
    let rows: String = (0..501).map(row).collect();
    folder.write("a.csv", format!("x,y,z,where\n{rows}"));
    let weights: String = (0..501).map(|i| format!("{}\n", i % 4 + 1)).collect();
    folder.write("w.csv", weights);
    for command in [
        "lstsq a.csv --by-column y --factor where --intercept --missing drop --weights w.csv",
        "pca a.csv --columns x,y,z -k 2 --missing drop --scores",
        "svd a.csv --columns x,y,z --missing drop --left",
    ] {
        folder.succeed(&format!("{command} -o one.npz --force"));
        for ranks in [2, 3] {
            let arguments = format!("{command} -o {ranks}.npz --threads 1 --force");
            let run = mpirun(&folder, ranks, &arguments);
            assert_eq!(run.code, Some(0), "{}", run.stderr);
            // One of them speaks.
            assert_eq!(run.stderr.matches("a missing cell left out").count(), 1, "{}", run.stderr);
            let read = |name: &str| std::fs::read(folder.path(name)).unwrap();
            assert!(read("one.npz") == read(&format!("{ranks}.npz")), "{command}");
        }
    }
    let line = "lstsq a.csv --by-column y --factor where=west --missing drop";
    let refused = mpirun(&folder, 2, line);
    assert_ne!(refused.code, Some(0));
    let said = complaints(&refused);
    assert_eq!(said.len(), 1, "{}", refused.stderr);
    assert!(said[0].starts_with("catamaran: rank 0: a.csv: factor: where "), "{said:?}");
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
    assert!(run.stderr.contains("-k 643, where 642 vertices are free"), "{}", run.stderr);
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
    // One of them speaks.
    let said = complaints(&run);
    assert_eq!(said.len(), 1, "{}", run.stderr);
    assert!(said[0].starts_with("catamaran: rank 0: a.csv:2: column 2"), "{said:?}");
    assert!(!folder.path("c.csv").exists());
}

#[test]
fn a_rank_that_fails_alone_speaks_and_the_others_are_silent() {
    let folder = Folder::new();
    // In the rows of the last of three ranks; with 40 rows in a block, the others are at work.
    let (m, n) = (6000, 40);
    let mut a = table_of(m, n);
    a[(m - 100) * n + 7] = f64::NAN;
    folder.write_npy("a.npy", &[m as u64, n as u64], &a);
    let line = "ata a.npy -o c.npy --require-finite --threads 1 --block-rows 40";
    let run = mpirun(&folder, 3, line);
    assert_ne!(run.code, Some(0));
    let said = complaints(&run);
    assert_eq!(said.len(), 1, "{}", run.stderr);
    let expected = format!("catamaran: rank 2: a.npy: NaN at row {}, column 7", m - 100);
    assert!(said[0].starts_with(&expected), "{said:?}");
    assert!(!run.stderr.contains("cancelled"), "{}", run.stderr);
    assert_eq!(folder.names(), ["a.npy"]);
}

/// Small whole numbers.
fn table_of(m: usize, n: usize) -> Vec<f64> {
    (0..m * n).map(|k| ((k * 7919 + 13) % 23) as f64 - 11.0).collect()
}

/// Runs `catamaran` on two ranks that have folders of their own.
fn in_two_folders(folders: &Folder, arguments: &str) -> Run {
    let mut command = launcher_of_mpi(folders);
    let program = folders.program().get_program().to_owned();
    for (i, folder) in ["first", "second"].into_iter().enumerate() {
        if i > 0 {
            command.arg(":");
        }
        command.args(["-n", "1", "-wdir"]).arg(folders.path(folder)).arg(&program);
        command.args(arguments.split_whitespace());
    }
    Run::new(command.output().expect("mpirun starts"))
}

#[test]
fn ranks_that_have_different_files_are_refused_before_the_first_product() {
    let folders = Folder::new();
    for name in ["first", "second"] {
        std::fs::create_dir(folders.path(name)).unwrap();
    }
    let (m, n) = (2000, 4);
    let a = table_of(m, n);
    let mut other = a.clone();
    other[m * n - 1] += 1.0;
    let single: Vec<f32> = a.iter().map(|&x| x as f32).collect();
    let write = |m: usize, a: &[f64]| folders.write_npy("second/a.npy", &[m as u64, 4], a);
    folders.write_npy("first/a.npy", &[m as u64, n as u64], &a);
    for (copy, what) in [
        ("incomplete", "the number of rows is 1500, where rank 0 has 2000"),
        ("other", "the fingerprint of sampled rows is "),
        ("single", "the size of an entry is 4, where rank 0 has 8"),
    ] {
        match copy {
            "incomplete" => write(1500, &a[..1500 * n]),
            "other" => write(m, &other),
            _ => folders.write_npy("second/a.npy", &[m as u64, n as u64], &single),
        }
        for command in ["ata a.npy -o c.npy", "lstsq a.npy --by-column 1", "svd a.npy", "pca a.npy"]
        {
            let run = in_two_folders(&folders, command);
            assert_ne!(run.code, Some(0), "{copy}, {command}: {}", run.stdout);
            let said = complaints(&run);
            assert_eq!(said.len(), 1, "{copy}, {command}: {}", run.stderr);
            let expected = format!("catamaran: a.npy: rank 1: {what}");
            assert!(said[0].starts_with(&expected), "{copy}, {command}: {said:?}");
            assert!(!folders.path("first/c.npy").exists());
        }
    }
    write(m, &a);
    let run = in_two_folders(&folders, "ata a.npy -o c.npy");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(folders.path("first/c.npy").exists() && !folders.path("second/c.npy").exists());
}

#[test]
fn c_larger_than_memory_is_computed_in_strips_by_all_ranks() {
    let folder = Folder::new();
    let (m, n) = (61, 700);
    folder.write_npy("a.npy", &[m as u64, n as u64], &table_of(m, n));
    folder.succeed("ata a.npy -o whole.npy --threads 1");
    for ranks in [2, 3] {
        let options = "--memory 0.006 --block-rows 16 --explain --threads 1";
        let run = mpirun(&folder, ranks, &format!("ata a.npy -o {ranks}.npy {options}"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        assert!(run.stdout.contains("times, for strips"), "{}", run.stdout);
        let read = |name: &str| std::fs::read(folder.path(name)).unwrap();
        assert!(read("whole.npy") == read(&format!("{ranks}.npy")), "{ranks} ranks");
    }
    let run = mpirun(&folder, 2, "ata a.npy -o c.npy --memory 0.006 --block-rows 16 --verify");
    assert_ne!(run.code, Some(0));
    assert_eq!(complaints(&run).len(), 1, "{}", run.stderr);
    assert!(run.stderr.contains("--verify needs all of C in memory"), "{}", run.stderr);
}

#[test]
fn a_shortage_tells_the_least_memory_of_all_ranks() {
    let folder = Folder::new();
    let (m, n) = (2000, 60);
    folder.write_npy("a.npy", &[m as u64, n as u64], &table_of(m, n));
    let program = folder.program().get_program().to_owned();
    let line = ["ata", "a.npy", "-o", "c.npy", "--block-rows", "2000", "--threads", "1"];
    let mut command = launcher_of_mpi(&folder);
    command.args(["-n", "1"]).arg(&program).args(line);
    command.args([":", "-n", "1"]).arg(&program).args(line).args(["--memory", "0.001"]);
    let run = Run::new(command.output().expect("mpirun starts"));
    assert_ne!(run.code, Some(0), "{}", run.stdout);
    let said = complaints(&run);
    assert!(said.len() == 1 && said[0].contains("with 0.001 GiB of memory"), "{}", run.stderr);
}

/// Names of the checkpoints of a folder.
fn checkpoints(folder: &Folder) -> Vec<String> {
    folder.names().into_iter().filter(|name| name.starts_with("sums")).collect()
}

/// Starts a run on `ranks` ranks, and sends it SIGUSR1, which launchers pass on, once it has saved
/// something. Returns `false` if it was faster.
fn is_interrupted(folder: &Folder, ranks: usize, arguments: &str) -> bool {
    let mut command = launcher(folder, ranks, arguments);
    let said = || std::fs::File::create(folder.path("said.txt")).unwrap();
    let mut child = command.stdout(said()).stderr(said()).spawn().expect("mpirun starts");
    while checkpoints(folder).len() < ranks {
        if child.try_wait().unwrap().is_some() {
            return false;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let id = child.id().to_string();
    // If it has ended, there is no process of this number.
    let _ = Command::new("kill").args(["-USR1", &id]).status();
    !child.wait().unwrap().success()
}

#[test]
fn exact_sums_are_continued_by_any_number_of_ranks_and_others_say_that_they_are_not() {
    let (m, n) = (30_000_usize, 20_usize);
    let a: Vec<f64> = (0..m * n).map(|k| ((k * 7919 + 13) % 10007) as f64 * 0.37).collect();
    for (kind, is_exact) in [("--reproducible", true), ("--accuracy classical", false)] {
        let folder = Folder::new();
        folder.write_npy("a.npy", &[m as u64, n as u64], &a);
        folder.succeed(&format!("ata a.npy -o whole.npy --center {kind} --threads 1"));
        let line = format!(
            "ata a.npy -o c.npy --center {kind} --threads 1 --block-rows 40 --checkpoint sums \
             --resume"
        );
        let begun = (0..20).any(|_| {
            let interrupted = is_interrupted(&folder, 3, &format!("{line} --checkpoint-every 0"));
            if !interrupted {
                std::fs::remove_file(folder.path("c.npy")).unwrap();
            }
            interrupted
        });
        assert!(begun, "no signal was sent in time");
        let names = ["sums.0-of-3", "sums.1-of-3", "sums.2-of-3"];
        assert_eq!(checkpoints(&folder), names);
        let run = mpirun(&folder, 2, &line);
        if is_exact {
            assert_eq!(run.code, Some(0), "{}", run.stderr);
            let told =
                |line: &str| line.starts_with("resumed") && line.contains("of all processes");
            assert!(run.stdout.lines().any(told), "{}", run.stdout);
            let read = |name: &str| std::fs::read(folder.path(name)).unwrap();
            assert!(read("c.npy") == read("whole.npy"));
            assert_eq!(checkpoints(&folder), [""; 0], "old parts are removed");
        } else {
            assert_ne!(run.code, Some(0), "{}", run.stdout);
            let why = "sums.0-of-3: a checkpoint of 3 processes, which only as many can continue";
            assert!(complaints(&run)[0].contains(why), "{}", run.stderr);
            assert_eq!(complaints(&run).len(), 1, "{}", run.stderr);
            let run = folder.run(&line);
            assert!(run.stderr.contains("and these are 1: "), "{}", run.stderr);
            assert_eq!(checkpoints(&folder), names, "nothing is lost");
            let run = mpirun(&folder, 3, &line);
            assert_eq!(run.code, Some(0), "{}", run.stderr);
            assert_eq!(checkpoints(&folder), [""; 0]);
        }
    }
}

#[test]
fn files_of_other_runs_are_refused_and_with_force_removed_in_the_end() {
    let folder = Folder::new();
    let (m, n) = (203, 11);
    folder.write_npy("a.npy", &[m as u64, n as u64], &table_of(m, n));
    folder.write("sums.0-of-5", "precious");
    let line = "lstsq a.npy --by-column 3 -o x.npz --checkpoint sums --threads 1";
    let run = mpirun(&folder, 2, line);
    assert_ne!(run.code, Some(0));
    assert!(run.stderr.contains("sums.0-of-5: exists already"), "{}", run.stderr);
    assert_eq!(folder.names(), ["a.npy", "sums.0-of-5"]);
    let run = mpirun(&folder, 2, &format!("{line} --force"));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_eq!(folder.names(), ["a.npy", "x.npz"]);
}
