//! The driver as its user runs it, under `mpirun`; `MPIRUN` names another launcher.

use std::collections::HashMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use catamaran::Par;
use catamaran::faer::Mat;
use catamaran::io::{Overwrite, write};
use catamaran::ranks::plan::{Mode, proposition_8_3};

/// The driver on some ranks.
fn driver(ranks: usize, arguments: &str) -> Output {
    let launcher = std::env::var("MPIRUN").unwrap_or_else(|_| "mpirun".into());
    Command::new(&launcher)
        .args(["-n", &ranks.to_string(), env!("CARGO_BIN_EXE_catamaran-ata-mpi")])
        .args(arguments.split_whitespace())
        // Open MPI: in a container one is root, and has fewer cores than ranks.
        .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
        .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
        .env("OMPI_MCA_rmaps_base_oversubscribe", "1")
        .env("OMPI_MCA_mpi_yield_when_idle", "1")
        .output()
        .unwrap_or_else(|error| panic!("{launcher}: {error}"))
}

/// The exit code and everything that is printed.
fn run(ranks: usize, arguments: &str) -> (Option<i32>, String) {
    let output = driver(ranks, arguments);
    let all = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8_lossy(&all).into_owned())
}

/// The lines of a table by the names of their columns.
fn table(path: &Path) -> Vec<HashMap<String, String>> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned));
    let columns: Vec<_> = lines.next().unwrap().collect();
    lines.map(|fields| columns.iter().cloned().zip(fields).collect()).collect()
}

#[test]
fn every_mode_passes_its_checks_and_appends_its_row() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("runs.csv");
    for (name, _) in Mode::NAMES {
        let arguments = "-m 531 -n 257 --repeat 1 --check --mode";
        let (code, said) = run(3, &format!("{arguments} {name} --csv {}", path.display()));
        assert_eq!(code, Some(0), "{said}");
        assert!(said.contains("\nresult: PASSED\n"), "{said}");
    }
    let rows = table(&path);
    assert_eq!(rows.len(), Mode::NAMES.len());
    // More columns than rows: what is gathered in `deal` is more than what is dealt.
    let (code, said) = run(3, "-m 10 -n 300 --repeat 1 --check --mode deal");
    assert_eq!(code, Some(0), "{said}");
    for (row, (name, _)) in rows.iter().zip(Mode::NAMES) {
        let fields = ["mode", "ranks", "check"].map(|column| row[column].as_str());
        assert_eq!(fields, [name, "3", "passed"]);
        let percent: f64 = row["percent_of_peak"].parse().unwrap();
        assert!(percent > 0.0, "{row:?}");
    }
}

#[test]
fn process_0_has_the_messages_of_proposition_8_3_where_levels_are_complete() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("runs.csv");
    for ranks in [1, 6, 32] {
        let arguments =
            format!("-m 256 -n 256 --mode tree --repeat 1 --check --csv {}", path.display());
        let (code, said) = run(ranks, &arguments);
        assert_eq!(code, Some(0), "{said}");
        let row = table(&path).pop().unwrap();
        let (messages, _) = proposition_8_3(ranks, 256, 256);
        assert_eq!(row["rank_0_messages"], messages.to_string());
        assert_eq!(row["words"], row["planned_words"]);
    }
}

/// A ScaLAPACK that computes nothing.
const IDLE: &str = "
void pdsyrk_(void) {}
void Cpdgemr2d(void) {}
void Cpdtrmr2d(void) {}
void Cblacs_get(void) {}
void Cblacs_gridinit(void) {}
void Cblacs_gridexit(void) {}
void Cblacs_gridinfo(int context, int *rows, int *columns, int *row, int *column) {
  (void)context, *rows = *columns = 1, *row = *column = 0;
}
";

#[test]
fn a_failed_check_ends_in_1_and_is_the_result() {
    let folder = tempfile::tempdir().unwrap();
    let [source, library, path] =
        ["idle.c", "libidle.so", "runs.csv"].map(|name| folder.path().join(name));
    fs::write(&source, IDLE).unwrap();
    let compiled =
        Command::new("cc").args(["-shared", "-fPIC", "-o"]).arg(&library).arg(&source).status();
    assert!(compiled.unwrap().success());
    let rival = format!("--rival pdsyrk={} --csv {}", library.display(), path.display());
    let (code, said) = run(1, &format!("-m 40 -n 30 --repeat 1 --check {rival}"));
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("FAILED\n") && said.contains("\nresult: FAILED\n"), "{said}");
    assert_eq!(table(&path)[0]["check"], "failed");
}

#[test]
fn wrong_arguments_end_in_2_and_are_reported_once() {
    let (code, said) = run(3, "-m 0");
    assert_eq!(code, Some(2), "{said}");
    assert_eq!(said.matches("'0' for '-m <M>'").count(), 1, "{said}");
}

#[test]
fn a_table_with_other_columns_is_refused_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("runs.csv");
    fs::write(&path, "mode,seconds\n").unwrap();
    let (code, said) = run(2, &format!("-m 40 -n 30 --csv {}", path.display()));
    assert_eq!(code, Some(3), "{said}");
    assert_eq!(said.matches("has another header").count(), 1, "{said}");
    assert!(!said.contains("GFLOP/s"), "{said}");
    assert_eq!(fs::read_to_string(&path).unwrap(), "mode,seconds\n");
}

#[test]
fn a_table_that_can_not_be_written_is_refused_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("none/runs.csv");
    let (code, said) = run(2, &format!("-m 40 -n 30 --csv {}", path.display()));
    assert_eq!(code, Some(3), "{said}");
    assert_eq!(said.matches("runs.csv: can't be written").count(), 1, "{said}");
    assert!(!said.contains("GFLOP/s"), "{said}");
}

#[test]
fn scaling_is_a_table_and_a_picture_of_some_of_the_ranks() {
    let folder = tempfile::tempdir().unwrap();
    let name = folder.path().join("scaling");
    let (code, said) =
        run(3, &format!("-m 600 -n 40 --mode rows --repeat 1 --scaling {}", name.display()));
    assert_eq!(code, Some(0), "{said}");
    let rows = table(&name.with_extension("csv"));
    let of = |kind: &str, column: &str| -> Vec<String> {
        let own = rows.iter().filter(|row| row["kind"] == kind);
        own.map(|row| row[column].clone()).collect()
    };
    for kind in ["strong", "weak"] {
        assert_eq!(of(kind, "ranks"), ["1", "2", "3"]);
        assert_eq!(of(kind, "speedup")[0], "1.0000");
    }
    assert_eq!(of("strong", "m"), ["600", "600", "600"]);
    assert_eq!(of("weak", "m"), ["200", "400", "600"]);
    assert!(fs::read_to_string(name.with_extension("svg")).unwrap().contains("\nideal\n"));
    let (code, said) = run(2, "-m 40 -n 30 --scaling none/scaling");
    assert_eq!(code, Some(3), "{said}");
    assert_eq!(said.matches("scaling.csv: can't be written").count(), 1, "{said}");
}

#[test]
fn rows_of_a_file_take_the_place_of_a_generated_matrix() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.npy");
    let a = Mat::<f64>::from_fn(90, 7, |i, j| (i * 3 + j) as f64);
    write(catamaran::io::Output::create(&path, Overwrite::Never).unwrap(), a.as_ref()).unwrap();
    let file = format!("--repeat 1 --file {}", path.display());
    let (code, said) = run(3, &format!("{file} --check"));
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("A         90x7, mode rows, f64"), "{said}");
    let name = folder.path().join("scaling");
    let (code, said) = run(2, &format!("{file} --scaling {}", name.display()));
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(table(&name.with_extension("csv"))[1]["m"], "45");
    let (code, said) = run(2, &format!("{file} --mode grid"));
    assert_eq!(code, Some(3), "{said}");
    assert_eq!(said.matches("--file: each rank reads").count(), 1, "{said}");
}

#[test]
fn threads_are_labelled_as_many_as_are_used() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("runs.csv");
    let most = Par::Threads(60_000).threads();
    assert!(most < 60_000);
    // The mask of this process is that of the only rank, unless mpirun binds it.
    let (code, said) =
        run(1, &format!("-m 40 -n 30 --repeat 1 --threads 60000 --csv {}", path.display()));
    assert_eq!(code, Some(0), "{said}");
    let used: usize = table(&path)[0]["threads"].parse().unwrap();
    assert!(used <= most, "{used} threads in the table, at most {most} are used");
    let note = format!("note      {used} threads of a rank instead of 60000");
    assert!(said.contains(&note), "{said}");
}

#[test]
fn a_launcher_whose_processes_are_alone_in_mpi_is_refused_once_with_both_names() {
    let alone = |rank: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_catamaran-ata-mpi"))
            .args(["-m", "40", "-n", "30"])
            .env("SLURM_PROCID", rank)
            .env("SLURM_STEP_NUM_TASKS", "4")
            .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
            .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
            .output()
            .unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, said) = alone("0");
    assert_eq!(code, Some(3), "{said}");
    assert!(said.contains("Slurm's srun started 4 processes, but each is alone in"), "{said}");
    let (code, said) = alone("1");
    assert_eq!((code, said.contains("srun")), (Some(0), false), "{said}");
}
