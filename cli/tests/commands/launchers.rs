//! Launchers that start several processes, known by the variables that they set: commands share
//! the work, or one of the processes says why not.

use std::process::Command;
use std::thread;

use crate::common::{Folder, Run};
use crate::lines::LINES;

/// The variables of all launchers that are known.
const VARIABLES: [&str; 10] = [
    "OMPI_COMM_WORLD_RANK",
    "OMPI_COMM_WORLD_SIZE",
    "PMI_RANK",
    "PMI_SIZE",
    "PALS_RANKID",
    "FLUX_TASK_RANK",
    "FLUX_JOB_SIZE",
    "SLURM_PROCID",
    "SLURM_STEP_NUM_TASKS",
    "PMIX_RANK",
];

/// `catamaran` in this folder, as a launcher starts it that sets these variables.
fn launched(folder: &Folder, variables: &[(&str, &str)], arguments: &str) -> Run {
    let mut command: Command = folder.program();
    for name in VARIABLES {
        command.env_remove(name);
    }
    command.envs(variables.iter().copied()).args(arguments.split_whitespace());
    // Open MPI: in a container one is root.
    for name in ["ALLOW_RUN_AS_ROOT", "ALLOW_RUN_AS_ROOT_CONFIRM"] {
        command.env(format!("OMPI_{name}"), "1");
    }
    Run::new(command.output().expect("the program starts"))
}

/// The lines in which the program complains.
fn complaints(run: &Run) -> Vec<&str> {
    run.stderr.lines().filter(|line| line.starts_with("catamaran: ")).collect()
}

#[test]
fn processes_that_are_alone_beside_others_are_refused_by_the_first_one() {
    let folder = Folder::new();
    folder.write("a.csv", "1,2\n3,4\n");
    for command in ["ata a.csv -o c.csv", "lstsq a.csv --by-column 1", "pca a.csv", "svd a.csv"] {
        let of = |rank| [("SLURM_PROCID", rank), ("SLURM_STEP_NUM_TASKS", "4")];
        let first = launched(&folder, &of("0"), command);
        assert_eq!(first.code, Some(1), "{}", first.stderr);
        let said = complaints(&first);
        assert_eq!(said.len(), 1, "{}", first.stderr);
        assert!(said[0].contains("Slurm's srun started 4 processes, but "), "{said:?}");
        let why = if cfg!(feature = "mpi") { "each is alone in" } else { "built without MPI" };
        assert!(said[0].contains(why) && said[0].contains("unset SLURM_PROCID"), "{said:?}");
        let other = launched(&folder, &of("3"), command);
        assert_eq!((other.code, complaints(&other).len()), (Some(1), 0), "{}", other.stderr);
        assert_eq!(other.stdout, "");
        assert!(!folder.path("c.csv").exists());
    }
    // A single process, and one that is told to forget the others.
    for variables in [&[("SLURM_PROCID", "0"), ("SLURM_STEP_NUM_TASKS", "1")][..], &[]] {
        let run = launched(&folder, variables, "ata a.csv");
        assert_eq!(run.code, Some(0), "{}", run.stderr);
    }
}

#[cfg(not(feature = "mpi"))]
#[test]
fn a_program_without_mpi_refuses_every_launcher() {
    let folder = Folder::new();
    folder.write("a.csv", "1,2\n3,4\n");
    for (variables, launcher) in [
        (&[("OMPI_COMM_WORLD_RANK", "0"), ("OMPI_COMM_WORLD_SIZE", "2")][..], "Open MPI's mpirun"),
        (&[("PMI_RANK", "0"), ("PMI_SIZE", "2")], "a launcher with PMI"),
        (&[("FLUX_TASK_RANK", "0"), ("FLUX_JOB_SIZE", "2")], "Flux"),
    ] {
        let run = launched(&folder, variables, "ata a.csv -o c.csv");
        let expected = format!("catamaran: launcher: {launcher} started 2 processes, but ");
        assert_eq!(run.code, Some(1), "{}", run.stderr);
        assert!(run.stderr.starts_with(&expected), "{}", run.stderr);
    }
    // Those that pass no number are noticed by the second process.
    for (name, launcher) in [("PALS_RANKID", "PALS"), ("PMIX_RANK", "a launcher with PMIx")] {
        let run = launched(&folder, &[(name, "1")], "ata a.csv -o c.csv");
        let expected =
            format!("catamaran: launcher: {launcher} started at least 2 processes, but ");
        assert_eq!(run.code, Some(1), "{}", run.stderr);
        assert!(run.stderr.starts_with(&expected), "{}", run.stderr);
        let run = launched(&folder, &[(name, "2")], "ata a.csv -o c.csv");
        assert_eq!((run.code, run.stderr.as_str()), (Some(1), ""), "{launcher}");
        assert_eq!(folder.names(), ["a.csv"], "{launcher}");
    }
}

/// The command of a line.
fn name(line: &str) -> &str {
    line.split(' ').next().unwrap_or_default()
}

#[test]
fn commands_that_share_no_work_refuse_by_their_name() {
    let folder = Folder::new();
    let shared = ["ata", "lstsq", "pca", "svd", "spectrum"];
    let others: Vec<&str> =
        LINES.iter().copied().filter(|line| !shared.contains(&name(line))).collect();
    let ran = |rank, line| launched(&folder, &[("PMI_RANK", rank), ("PMI_SIZE", "2")], line);
    for &line in &others {
        let run = ran("0", line);
        assert_eq!(run.code, Some(1), "{line}: {}", run.stderr);
        let expected = format!("started 2 processes, but `{}` runs in one process", name(line));
        assert!(run.stderr.contains(&expected), "{line}: {}", run.stderr);
    }
    // Those that do not speak fail too, a second later.
    thread::scope(|scope| {
        let start = |&line| (line, scope.spawn(move || ran("1", line)));
        let runs: Vec<(&str, _)> = others.iter().map(start).collect();
        for (line, run) in runs {
            let run = run.join().unwrap();
            assert_eq!((run.code, run.stderr.as_str()), (Some(1), ""), "{line}");
        }
    });
    let count = others.len();
    assert!(count > 20, "{count} lines");
    assert!(folder.names().is_empty(), "{:?}", folder.names());
    let help = folder.succeed("--help");
    assert!(help.contains("share the work of ata, lstsq, pca, svd and spectrum"), "{help}");
    for command in shared {
        let help = folder.succeed(&format!("{command} --help"));
        let words: Vec<&str> = help.split_whitespace().collect();
        assert!(words.join(" ").contains("Under `mpirun`"), "{command}: {help}");
    }
}

#[test]
fn help_and_errors_of_a_command_line_are_said_by_the_first_process() {
    let folder = Folder::new();
    let of = |rank| [("OMPI_COMM_WORLD_RANK", rank), ("OMPI_COMM_WORLD_SIZE", "2")];
    for (line, status) in [("ata --no-such-option", 2), ("atta", 2), ("--help", 0), ("-V", 0)] {
        let [first, other] = ["0", "1"].map(|rank| launched(&folder, &of(rank), line));
        assert_eq!((first.code, other.code), (Some(status), Some(status)), "{line}");
        assert_ne!(first.stdout.len() + first.stderr.len(), 0, "{line}");
        assert_eq!((other.stdout.as_str(), other.stderr.as_str()), ("", ""), "{line}");
    }
}
