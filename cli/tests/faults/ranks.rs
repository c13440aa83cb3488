//! One of the processes of `mpirun` is killed.

use std::fs::{self, File};
use std::os::unix::fs::symlink;
use std::process::{Child, Command};
use std::thread;
use std::time::{Duration, Instant};

use crate::commands::inputs;
use crate::common::Folder;
use crate::kills::Moments;
use crate::{is_full, record};

const RANKS: usize = 4;
const LINE: &str = "ata large.npy --center --block-rows 8 -o c.npy --threads 1";

/// The time after which all processes must be gone.
const SOON: Duration = Duration::from_secs(10);

fn start(folder: &Folder) -> Child {
    let program = folder.program();
    let mut command = Command::new(std::env::var("MPIRUN").unwrap_or_else(|_| "mpirun".into()));
    command.args(["-n", &RANKS.to_string()]).arg(program.get_program());
    command.args(LINE.split_whitespace()).current_dir(folder.path("."));
    // Open MPI: in a container one is root, and has fewer cores than ranks.
    for name in ["ALLOW_RUN_AS_ROOT", "ALLOW_RUN_AS_ROOT_CONFIRM", "MCA_rmaps_base_oversubscribe"] {
        command.env(format!("OMPI_{name}"), "1");
    }
    let said = File::create(folder.path("said.txt")).unwrap();
    command.stdout(said.try_clone().unwrap()).stderr(said).spawn().expect("mpirun starts")
}

/// The processes of our program that run in this folder.
fn ranks(folder: &Folder) -> Vec<i32> {
    let there = fs::canonicalize(folder.path(".")).unwrap();
    let program = fs::canonicalize(env!("CARGO_BIN_EXE_catamaran")).unwrap();
    let is_ours = |id: &i32| {
        let of = |what: &str| fs::read_link(format!("/proc/{id}/{what}")).ok();
        of("cwd").as_ref() == Some(&there) && of("exe").as_ref() == Some(&program)
    };
    let ids = fs::read_dir("/proc").unwrap().filter_map(|entry| {
        entry.ok().and_then(|entry| entry.file_name().to_string_lossy().parse().ok())
    });
    ids.filter(is_ours).collect()
}

#[test]
fn a_rank_that_is_killed_ends_all_of_them_and_leaves_no_output() {
    let kills = if is_full() { 10 } else { 2 };
    let new_folder = || {
        let folder = Folder::new();
        symlink(inputs().path("large.npy"), folder.path("large.npy")).unwrap();
        folder
    };
    // What a run takes after all ranks are there.
    let folder = new_folder();
    let mut child = start(&folder);
    wait_for_ranks(&folder, &mut child);
    let begun = Instant::now();
    assert!(child.wait().unwrap().success());
    let whole = begun.elapsed();

    let mut moments = Moments::new(7);
    let (mut killed, mut tried, mut stayed, mut slowest) = (0, 0, 0, Duration::ZERO);
    while killed < kills {
        tried += 1;
        assert!(tried < 5 * kills, "ranks end before they are killed");
        let folder = new_folder();
        let mut child = start(&folder);
        wait_for_ranks(&folder, &mut child);
        thread::sleep(whole.mul_f64(moments.next()));
        let there = ranks(&folder);
        if there.len() < RANKS {
            // At its end already.
            child.wait().unwrap();
            continue;
        }
        let victim = there[(moments.next() * RANKS as f64) as usize];
        // SAFETY: a system call; the process is a grandchild of ours, or has just ended.
        unsafe { libc::kill(victim, libc::SIGKILL) };
        let start = Instant::now();
        let status = loop {
            let status = child.try_wait().unwrap();
            if status.is_some() || start.elapsed() > SOON {
                break status;
            }
            thread::sleep(Duration::from_millis(5));
        };
        let said = fs::read_to_string(folder.path("said.txt")).unwrap();
        while !ranks(&folder).is_empty() && start.elapsed() < SOON {
            thread::sleep(Duration::from_millis(5));
        }
        let left = states(&folder);
        let Some(status) = status else {
            // Open MPI 4.1 may stay for ever when a rank is killed while it connects, in MPI_Init.
            // That is no rank's fault: all of them must be gone.
            child.kill().unwrap();
            child.wait().unwrap();
            assert!(left.is_empty() && said.contains("PMIX ERROR: UNREACHABLE"), "{left}\n{said}");
            assert!(!folder.path("c.npy").exists());
            (killed, stayed) = (killed + 1, stayed + 1);
            continue;
        };
        assert!(left.is_empty(), "{left}\n{said}");
        slowest = slowest.max(start.elapsed());
        // The output may be there already when the victim had no more to do for it.
        if folder.path("c.npy").exists() {
            assert!(said.contains("written"), "{said}");
            continue;
        }
        assert!(!status.success(), "{said}");
        killed += 1;
    }
    let outcomes = format!(
        "mpirun ends with an error within {} ms, with all ranks; no output; {stayed} times mpirun \
         itself stayed, without ranks",
        slowest.as_millis()
    );
    record("SIGKILL of a rank", "mpirun -n 4 ata", kills, &outcomes);
}

/// What the processes do.
fn states(folder: &Folder) -> String {
    let state = |id: &i32| fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
    ranks(folder).iter().map(state).collect()
}

fn wait_for_ranks(folder: &Folder, child: &mut Child) {
    while ranks(folder).len() < RANKS {
        assert!(child.try_wait().unwrap().is_none(), "mpirun ended");
        thread::sleep(Duration::from_millis(2));
    }
}
