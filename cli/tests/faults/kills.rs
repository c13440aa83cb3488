//! Kills (SIGKILL) at random moments of the commands that can go on where they were.

use std::fs::{self, File};
use std::os::unix::fs::symlink;
use std::os::unix::process::ExitStatusExt as _;
use std::thread;
use std::time::{Duration, Instant};

use catamaran::io::{read_accumulator, read_arrays};
use catamaran_geometry::unions::SpectralUnion;
use catamaran_training::train::read_state;

use crate::commands::inputs;
use crate::common::Folder;
use crate::scene::{Files, all_files, is_temporary};
use crate::{is_full, record};

/// A command that can go on.
struct Job {
    command: &'static str,
    /// Files of [`inputs`] that it reads.
    inputs: &'static [&'static str],
    /// The next run; none when all is done. Whether the last run came to its end is given.
    next: fn(&Folder, bool) -> Option<String>,
    /// How much is done, in any unit: what there is to go on from must be readable.
    kept: fn(&Folder) -> usize,
    /// Files that must be the same bytes in the end.
    results: &'static [&'static str],
    /// Whether they may be there before the end, as the best so far.
    is_early: bool,
}

const JOBS: &[Job] = &[
    Job {
        command: "ata --checkpoint --resume",
        inputs: &["large.npy"],
        next: |_, ended| (!ended).then(|| ATA.to_owned()),
        kept: |folder| {
            let path = folder.path("sums");
            if path.exists() { read_accumulator::<f64>(&path).unwrap().rows() as usize } else { 0 }
        },
        results: &["c.npy"],
        is_early: false,
    },
    Job {
        command: "slime --state --resume",
        inputs: &["square.obj", "c.toml"],
        next: |folder, ended| {
            let done = slime_steps(folder);
            let steps = (done + SLIME_STEPS).min(ROUNDS * SLIME_STEPS);
            let line = format!("{SLIME} --steps {steps} -o out --state s.state --resume --force");
            (!ended || done < ROUNDS * SLIME_STEPS).then_some(line)
        },
        kept: slime_steps,
        results: &["s.state", "out/frame-0120.png", "out/coverage.csv"],
        is_early: true,
    },
    Job {
        command: "unions dataset",
        inputs: &[],
        next: |_, ended| (!ended).then(|| DATASET.to_owned()),
        kept: |folder| {
            let shapes = all_files(&folder.path("d.npz.parts")).into_keys();
            let shapes: Vec<_> = shapes.filter(|name| name.ends_with(".npz")).collect();
            for shape in &shapes {
                read_arrays(&folder.path(&format!("d.npz.parts/{shape}"))).unwrap();
            }
            shapes.len()
        },
        results: &["d.npz"],
        is_early: false,
    },
    Job {
        command: "unions train --resume",
        inputs: &["data.npz"],
        next: |folder, ended| {
            let done = epochs(folder);
            let resume = if done == 0 { "" } else { "--resume" };
            let line = format!("{TRAIN} --epochs {ROUNDS} --minutes 0 {resume}");
            (!ended || done < ROUNDS).then_some(line)
        },
        kept: epochs,
        results: &["w.safetensors", "w.safetensors.state.npz", "w.safetensors.svg"],
        is_early: true,
    },
];

const ATA: &str = "ata large.npy --center --block-rows 320 -o c.npy --checkpoint sums \
                   --checkpoint-every 0 --resume";
const SLIME: &str = "slime square.obj --config c.toml --size 128 --agents 4000";
const DATASET: &str = "unions dataset -o d.npz --size small --vertices 500 --known 1 --unknown 0 \
                       --others 0 --poses 1 --pairs 4 --creatures 2 --varied 1";
const TRAIN: &str = "unions train data.npz -o w.safetensors --width 16 --hidden 16";

/// Runs of a command that ends before all is done.
const ROUNDS: usize = 4;
/// Steps of one of them.
const SLIME_STEPS: usize = 30;

/// The steps after which the state is, as the program says that reads it.
fn slime_steps(folder: &Folder) -> usize {
    if !folder.path("s.state").exists() {
        return 0;
    }
    let said = folder.run(&format!("{SLIME} --steps 0 -o none --state s.state --resume")).stderr;
    let steps = said.trim().strip_suffix(" steps already").and_then(|said| said.rsplit(' ').next());
    steps.and_then(|steps| steps.parse().ok()).expect(&said)
}

/// The epochs in the state.
fn epochs(folder: &Folder) -> usize {
    let weights = folder.path("w.safetensors");
    if weights.exists() {
        SpectralUnion::read(&weights).unwrap();
    }
    let state = folder.path("w.safetensors.state.npz");
    if state.exists() { read_state(&state).unwrap().1.history.len() } else { 0 }
}

fn folder_of(job: &Job) -> Folder {
    let folder = Folder::new();
    for name in job.inputs {
        symlink(inputs().path(name), folder.path(name)).unwrap();
    }
    folder
}

/// The results that are there.
fn results(job: &Job, folder: &Folder) -> Files {
    let mut files = all_files(&folder.path("."));
    files.retain(|name, _| job.results.contains(&&**name));
    files
}

/// What a run without kills gives, and how long one of its runs takes at most.
fn undisturbed(job: &Job) -> (Files, Duration) {
    let folder = folder_of(job);
    let (mut ended, mut longest) = (false, Duration::ZERO);
    while let Some(line) = (job.next)(&folder, ended) {
        let start = Instant::now();
        folder.succeed(&line);
        longest = longest.max(start.elapsed());
        ended = true;
    }
    let found = results(job, &folder);
    assert_eq!(found.len(), job.results.len(), "{:?}", found.keys());
    (found, longest)
}

/// Numbers in 0..1 that a seed gives.
pub struct Moments(u64);

impl Moments {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as f64 / (1_u64 << 31) as f64
    }
}

#[test]
fn what_is_killed_goes_on_and_gives_the_same_bytes() {
    let kills = if is_full() { 20 } else { 2 };
    for (seed, job) in (1..).zip(JOBS) {
        let (whole, longest) = undisturbed(job);
        let mut moments = Moments::new(seed);
        let mut folder = folder_of(job);
        let (mut killed, mut whole_before, mut kept, mut leftovers) = (0, 0, 0, 0);
        let mut is_going_on = 0;
        while killed < kills {
            let line = (job.next)(&folder, false).unwrap();
            is_going_on += usize::from(kept > 0);
            let said = File::create(folder.path("said.txt")).unwrap();
            let mut command = folder.program();
            command.args(line.split_whitespace()).stdout(said.try_clone().unwrap()).stderr(said);
            let mut child = command.spawn().unwrap();
            thread::sleep(longest.mul_f64(moments.next()));
            child.kill().unwrap();
            let status = child.wait().unwrap();
            let said = fs::read_to_string(folder.path("said.txt")).unwrap();
            let context = format!("{line}, kill {killed}: {status}\n{said}");
            assert!(status.signal() == Some(libc::SIGKILL) || status.success(), "{context}");
            let was_killed = !status.success();
            killed += usize::from(was_killed);
            let found = results(job, &folder);
            let is_whole = found == whole;
            if was_killed {
                assert!(job.is_early || is_whole || found.is_empty(), "{context}");
                // Those that a later run replaces are all gone, or all there.
                let now = (job.kept)(&folder);
                assert!(is_whole || now >= kept, "{context}: {now} after {kept}");
                kept = now;
            } else {
                kept = (job.kept)(&folder);
            }
            if is_whole || (job.next)(&folder, !was_killed).is_none() {
                // Killed amid its last act, or faster than the kill: once more from the beginning.
                assert!(is_whole, "{context}");
                whole_before += 1;
                leftovers += temporaries(&folder);
                (folder, kept) = (folder_of(job), 0);
            }
        }
        let mut ended = false;
        while let Some(line) = (job.next)(&folder, ended) {
            folder.succeed(&line);
            ended = true;
        }
        leftovers += temporaries(&folder);
        assert!(results(job, &folder) == whole, "{}: other bytes after kills", job.command);
        let outcomes = format!(
            "{is_going_on} went on from what was kept; {} results, all the same bytes; \
             {leftovers} temporary files left",
            whole_before + 1
        );
        record("SIGKILL", job.command, kills, &outcomes);
    }
}

/// Nobody can remove the temporary files of a process that was killed.
fn temporaries(folder: &Folder) -> usize {
    all_files(&folder.path(".")).keys().filter(|name| is_temporary(name)).count()
}
