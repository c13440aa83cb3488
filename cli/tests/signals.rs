//! SIGINT, SIGTERM and SIGHUP end every command soon, and no temporary file stays.
#![cfg(unix)]

mod common;

use std::fs::{self, File};
use std::io::Write as _;
use std::os::unix::process::ExitStatusExt as _;
use std::path::Path;
use std::process::{Child, Command, ExitStatus};
use std::sync::Arc;
use std::time::{Duration, Instant};

use catamaran::io::{Output, Overwrite, read_accumulator};
use catamaran_geometry::mesh::{TriMesh, families, io};
use common::Folder;

/// What a signal may take: a second, and some patience with a busy machine.
const SOON: Duration = Duration::from_secs(5);

/// Where the standard output and the errors go.
const SAID: &str = "said.txt";

/// A command at work.
struct Run {
    folder: Folder,
    child: Child,
}

impl Run {
    /// Starts the command and waits until it has begun: said something, or made a file.
    fn start(folder: Folder, arguments: &str) -> Self {
        let mut command = folder.program();
        command.args(arguments.split_whitespace());
        Self::begin(folder, command)
    }

    fn begin(folder: Folder, mut command: Command) -> Self {
        // A signal that is handled here has its default effect there: these tests may run where
        // hangups are ignored, which programs inherit.
        signal_hook::flag::register(signal_hook::consts::SIGHUP, Arc::default()).unwrap();
        let said = File::create(folder.path(SAID)).unwrap();
        let before = folder.names();
        let child = command.stderr(said.try_clone().unwrap()).stdout(said).spawn().unwrap();
        let mut run = Self { folder, child };
        let begun = |folder: &Folder| {
            fs::metadata(folder.path(SAID)).unwrap().len() > 0 || folder.names() != before
        };
        while !begun(&run.folder) {
            assert!(run.child.try_wait().unwrap().is_none(), "{command:?} ended");
            std::thread::sleep(Duration::from_millis(2));
        }
        run
    }

    fn send(&self, signal: &str) {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args([signal, &id]).status().unwrap().success());
    }

    /// Waits until a handler runs for every signal that was sent, where Linux says so.
    fn wait_for_delivery(&self) {
        let path = format!("/proc/{}/status", self.child.id());
        let pending = |status: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix("ShdPnd:"));
            line.is_some_and(|signals| signals.contains(|c| matches!(c, '1'..='9' | 'a'..='f')))
        };
        while fs::read_to_string(&path).is_ok_and(|status| pending(&status)) {
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Waits for the end, which must come soon; no temporary file may be left then.
    fn end(&mut self) -> ExitStatus {
        let start = Instant::now();
        let status = loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                break status;
            }
            if start.elapsed() > SOON {
                self.child.kill().unwrap();
                panic!("still there {SOON:?} after the signal");
            }
            std::thread::sleep(Duration::from_millis(2));
        };
        assert_eq!(temporaries(&self.folder.path(".")), [""; 0]);
        status
    }
}

/// Names of unfinished outputs, in subfolders too.
fn temporaries(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.path().is_dir() {
            found.extend(temporaries(&entry.path()));
        } else if name.starts_with(".catamaran-") {
            found.push(name);
        }
    }
    found
}

fn with_mesh(mesh: TriMesh) -> Folder {
    let folder = Folder::new();
    let output = Output::create(&folder.path("mesh.ply"), Overwrite::Never).unwrap();
    io::write(output, &mesh.into()).unwrap();
    folder
}

/// A .npy file of zeros that takes no room on the disk.
fn with_zeros(m: usize, n: usize) -> Folder {
    let folder = Folder::new();
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({m}, {n}), }}");
    let mut file = File::create(folder.path("a.npy")).unwrap();
    file.write_all(b"\x93NUMPY\x01\x00\x76\x00").unwrap();
    file.write_all(format!("{header:117}\n").as_bytes()).unwrap();
    file.set_len((128 + 8 * m * n) as u64).unwrap();
    folder
}

/// A folder with a pipe called a.csv, from which `ata` reads without an end.
fn with_pipe() -> Folder {
    let folder = Folder::new();
    assert!(Command::new("mkfifo").arg(folder.path("a.csv")).status().unwrap().success());
    folder
}

/// Sends SIGTERM a moment after the start.
fn ends_amid_its_work(folder: Folder, arguments: &str) -> Run {
    let mut run = Run::start(folder, arguments);
    std::thread::sleep(Duration::from_millis(150));
    assert!(run.child.try_wait().unwrap().is_none(), "{arguments}: ended before the signal");
    run.send("-TERM");
    let status = run.end();
    assert_eq!(status.code(), Some(143), "{arguments}: {status}");
    run
}

#[test]
fn ata_ends_and_keeps_its_checkpoint() {
    let options = "--checkpoint sums --checkpoint-every 0 --block-rows 100";
    let run =
        ends_amid_its_work(with_zeros(60_000, 2000), &format!("ata a.npy -o c.npy {options}"));
    assert!(run.folder.names().iter().all(|name| ["a.npy", SAID, "sums"].contains(&&**name)));
    let threads = "--threads 8000 --scheme exact";
    ends_amid_its_work(with_zeros(60_000, 2000), &format!("ata a.npy -o c.npy {threads}"));
    let folder = Folder::new();
    // The output of C, which tells no progress, takes most of the time.
    folder.write("wide.csv", vec![vec!["1"; 4000].join(","); 3].join("\n"));
    ends_amid_its_work(folder, "ata wide.csv -o c.csv.gz");
}

/// Numbers that every order of additions rounds differently.
fn with_numbers(m: usize, n: usize) -> Folder {
    let folder = Folder::new();
    let numbers: Vec<f64> = (0..m * n).map(|k| ((k * 7919 + 13) % 10007) as f64 * 0.37).collect();
    folder.write_npy("a.npy", &[m as u64, n as u64], &numbers);
    folder
}

/// A signal comes long before a checkpoint is due.
#[test]
fn a_signal_writes_a_checkpoint_at_once_and_the_run_goes_on_from_it() {
    let (m, n) = (100_000, 40);
    for (signal, status, kind) in
        [("-TERM", 143, "--center"), ("-INT", 130, "--reproducible"), ("-USR1", 138, "--center")]
    {
        let whole = with_numbers(m, n);
        let options = format!("ata a.npy -o c.npy {kind} --block-rows 8 --threads 1");
        whole.succeed(&options);
        let whole = fs::read(whole.path("c.npy")).unwrap();
        // The run may be faster than the signal.
        for attempt in 0.. {
            assert!(attempt < 40, "no signal was sent in time");
            let options = format!("{options} --checkpoint sums");
            let mut run = Run::start(with_numbers(m, n), &options);
            std::thread::sleep(Duration::from_millis(10 * attempt));
            run.send(signal);
            if run.end().code() != Some(status) || !run.folder.path("sums").exists() {
                // At its end, or before its first block.
                continue;
            }
            let sum = read_accumulator::<f64>(&run.folder.path("sums")).unwrap();
            assert!(sum.rows() > 0 && sum.rows() <= m as u64);
            let said = fs::read_to_string(run.folder.path(SAID)).unwrap();
            assert!(said.contains(&format!("sums: row {} of {m}", sum.rows())), "{said}");
            let report = run.folder.succeed(&format!("{options} --resume"));
            assert!(report.contains("resumed     sums: row "), "{report}");
            assert!(fs::read(run.folder.path("c.npy")).unwrap() == whole, "{kind}");
            assert!(!run.folder.path("sums").exists());
            break;
        }
    }
}

#[test]
fn mesh_commands_end() {
    let sphere = || with_mesh(families::icosphere(6).unwrap());
    ends_amid_its_work(sphere(), "spectrum mesh.ply -k 400 -o s.npz");
    ends_amid_its_work(sphere(), "decimate mesh.ply -n 30000 --lloyd 50 -o d.ply --report");
    let folder = sphere();
    folder.succeed("farthest mesh.ply -n 3000 -o samples.csv");
    ends_amid_its_work(folder, "curve mesh.ply --samples samples.csv --smooth -o c.json");
    let folder = sphere();
    folder.write_npy("f.npy", &[40962, 1], &vec![1.0; 40962]);
    ends_amid_its_work(
        folder,
        "transfer mesh.ply mesh.ply --functions f.npy --identity -k 100 -o g.npy",
    );
}

#[test]
fn simulations_end_and_slime_keeps_its_state() {
    let folder = Folder::new();
    folder.write("square.obj", SQUARE);
    let slime = "slime square.obj --size 256 --agents 2000 --steps 10000000 -o out";
    let run = ends_amid_its_work(folder, &format!("{slime} --state some.state"));
    assert!(run.folder.path("some.state").exists());
    ends_amid_its_work(run.folder, slime);
    ends_amid_its_work(Folder::new(), "wilt --grow 3000 --hours 480 --frames 300 -o out");
    ends_amid_its_work(Folder::new(), "newton --power 7 --size 8000x8000 -o a.png");
    ends_amid_its_work(Folder::new(), "demo -o page");
    ends_amid_its_work(Folder::new(), "tune --dry-run");
}

/// A square with its own texture coordinates.
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
                      f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";

// `unions train` is in commands/unions.rs, which has a data set.
#[test]
fn the_data_set_of_unions_ends() {
    ends_amid_its_work(Folder::new(), "unions dataset -o data.npz");
}

#[test]
fn a_command_that_hears_nothing_is_ended_and_leaves_no_file() {
    for (signal, status) in [("-INT", 130), ("-TERM", 143), ("-HUP", 129), ("-USR1", 138)] {
        // Blocked until somebody writes into the pipe, which nobody does.
        let mut run = Run::start(with_pipe(), "ata a.csv -o c.npy");
        run.send(signal);
        assert_eq!(run.end().code(), Some(status));
        assert_eq!(run.folder.names(), ["a.csv", SAID]);
    }
}

#[test]
fn an_abort_that_is_not_for_lack_of_memory_leaves_no_file_and_stays_an_abort() {
    let mut run = Run::start(with_pipe(), "ata a.csv -o c.npy");
    // A thread that is just creating the output, which the test has seen, can't remove it.
    std::thread::sleep(Duration::from_millis(100));
    run.send("-ABRT");
    assert_eq!(run.end().signal(), Some(6));
    assert_eq!(run.folder.names(), ["a.csv", SAID]);
}

#[test]
fn the_second_signal_ends_at_once() {
    // On a busy machine, the first signal may have ended the process before the second one is sent.
    for _ in 0..20 {
        let mut run = Run::start(with_pipe(), "ata a.csv -o c.npy");
        let start = Instant::now();
        run.send("-INT");
        run.wait_for_delivery();
        run.send("-TERM");
        let in_time = start.elapsed() < Duration::from_millis(200);
        let status = run.end().code();
        if in_time {
            // Otherwise the process would end later, with the status of the first signal.
            assert_eq!(status, Some(143));
            return;
        }
    }
    panic!("no second signal was sent in time");
}

#[test]
fn a_hangup_that_the_parent_ignores_stays_ignored() {
    let folder = with_pipe();
    let mut command = Command::new("nohup");
    command.arg(folder.program().get_program()).args(["ata", "a.csv", "-o", "c.npy"]);
    command.current_dir(folder.path("."));
    let mut run = Run::begin(folder, command);
    run.send("-HUP");
    let mut pipe = File::options().write(true).open(run.folder.path("a.csv")).unwrap();
    pipe.write_all(b"1,2\n3,4\n").unwrap();
    drop(pipe);
    let status = run.child.wait().unwrap();
    assert_eq!((status.code(), status.signal()), (Some(0), None));
    assert_eq!(run.folder.read_npy::<f64>("c.npy", &[2, 2]), [10.0, 14.0, 14.0, 20.0]);
}
