//! One program in two roles: the launcher, which cargo starts, and a rank, which `mpirun` starts.

use std::io::Read;
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use catamaran::ranks::{Launch, World};
use mpi::topology::Communicator;

use crate::{Case, Scene};

const RANKS: [usize; 6] = [1, 2, 3, 4, 7, 8];
/// Set for ranks: the names of what they do, and how many they must be.
const ROLE: &str = "CATAMARAN_TEST_ROLE";
const SIZE: &str = "CATAMARAN_TEST_SIZE";
/// A job that takes longer hangs.
const LIMIT: Duration = Duration::from_secs(180);

/// Plays the part that this process has.
pub fn run(cases: &[Case], scenes: &[Scene]) -> ExitCode {
    match std::env::var(ROLE) {
        Ok(role) => be_rank(&role, cases, scenes),
        Err(_) => launch(cases, scenes),
    }
}

fn be_rank(role: &str, cases: &[Case], scenes: &[Scene]) -> ExitCode {
    let scene = scenes.iter().find(|scene| scene.name == role);
    if let Some(rank) = scene.and_then(|scene| scene.starved) {
        // Before MPI starts, and with it the first thread, which settles the size of all stacks.
        let own = Launch::of_process().map(|launch| launch.rank());
        if own == usize::try_from(rank).ok() {
            // SAFETY: this process has no other thread yet. The stack of a thread is then larger
            // than the address space.
            unsafe { std::env::set_var("RUST_MIN_STACK", (1_u64 << 47).to_string()) };
        }
    }
    let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
    let (universe, _) = start.expect("MPI starts");
    let world = universe.world();
    let expected = std::env::var(SIZE).expect("the number of ranks").parse();
    assert_eq!(Ok(world.size()), expected, "mpirun belongs to another MPI than this program");
    if let Some(scene) = scene {
        (scene.play)(&World::new(&world).expect("threads are allowed"));
        return ExitCode::SUCCESS;
    }
    // A failed assertion on one rank must not leave the others waiting.
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        hook(info);
        // SAFETY: MPI runs until the end of this function.
        unsafe { mpi::ffi::MPI_Abort(mpi::ffi::RSMPI_COMM_WORLD, 1) };
    }));
    for (name, case) in cases.iter().filter(|(name, _)| role.split(',').any(|r| r == *name)) {
        if world.rank() == 0 {
            print!("test {name} on {} ranks ... ", world.size());
        }
        case(&World::new(&world).expect("threads are allowed"));
        if world.rank() == 0 {
            println!("ok");
        }
    }
    ExitCode::SUCCESS
}

/// Runs what the arguments select, and reports as cargo's own harness does.
fn launch(cases: &[Case], scenes: &[Scene]) -> ExitCode {
    let filters: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let chosen = |name: &str| filters.is_empty() || filters.iter().any(|f| name.contains(f));
    let (mut passed, mut failed) = (0, 0);
    let names: Vec<&str> = cases.iter().map(|c| c.0).filter(|name| chosen(name)).collect();
    if !names.is_empty() {
        for ranks in RANKS {
            let job = mpirun(ranks, &names.join(","));
            print!("{}", job.stdout);
            let ok = job.stdout.lines().filter(|line| line.ends_with("... ok")).count();
            passed += ok;
            if job.success != Some(true) || ok != names.len() {
                failed += names.len() - ok;
                println!("\n{}\n{}", job.ended(), job.stderr);
            }
        }
    }
    for scene in scenes.iter().filter(|scene| chosen(scene.name)) {
        let job = mpirun(scene.ranks, scene.name);
        let all = format!("{}{}", job.stdout, job.stderr);
        let missing = scene.printed.iter().find(|text| !all.contains(**text));
        let ended = job.success == Some(scene.succeeds);
        if ended && missing.is_none() {
            passed += 1;
            println!("test {} on {} ranks ... ok", scene.name, scene.ranks);
        } else {
            failed += 1;
            println!("test {} on {} ranks ... FAILED", scene.name, scene.ranks);
            println!("{}; missing: {missing:?}; printed:\n{all}", job.ended());
        }
    }
    let verdict = if failed == 0 { "ok" } else { "FAILED" };
    println!("\ntest result: {verdict}. {passed} passed; {failed} failed; 0 ignored");
    if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

struct Job {
    /// `None` when it had to be killed.
    success: Option<bool>,
    stdout: String,
    stderr: String,
}

impl Job {
    fn ended(&self) -> &'static str {
        match self.success {
            Some(true) => "the job succeeded",
            Some(false) => "the job failed",
            None => "the job hung, and was killed",
        }
    }
}

/// This program on some ranks, with a time limit.
fn mpirun(ranks: usize, role: &str) -> Job {
    let launcher = std::env::var("MPIRUN").unwrap_or_else(|_| "mpirun".into());
    let program = std::env::current_exe().expect("this program");
    let mut child = Command::new(&launcher)
        .args(["-n", &ranks.to_string()])
        .arg(program)
        .env(ROLE, role)
        .env(SIZE, ranks.to_string())
        .env("RAYON_NUM_THREADS", "2")
        // Open MPI: in a container one is root, and has fewer cores than ranks.
        .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
        .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
        .env("OMPI_MCA_rmaps_base_oversubscribe", "1")
        .env("OMPI_MCA_mpi_yield_when_idle", "1")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap_or_else(|e| panic!("{launcher}: {e} (MPIRUN names another launcher)"));
    let stdout = reader(child.stdout.take().expect("a pipe"));
    let stderr = reader(child.stderr.take().expect("a pipe"));
    let start = Instant::now();
    let success = loop {
        match child.try_wait().expect("a child") {
            Some(status) => break Some(status.success()),
            None if start.elapsed() > LIMIT => {
                let _ = child.kill();
                let _ = child.wait();
                break None;
            }
            None => std::thread::sleep(Duration::from_millis(10)),
        }
    };
    let text = |reader: std::thread::JoinHandle<String>| match success {
        // Orphans of a killed launcher may keep the pipe open.
        None => String::new(),
        Some(_) => reader.join().expect("a reader"),
    };
    Job { success, stdout: text(stdout), stderr: text(stderr) }
}

fn reader(mut pipe: impl Read + Send + 'static) -> std::thread::JoinHandle<String> {
    std::thread::spawn(move || {
        let mut text = Vec::new();
        let _ = pipe.read_to_end(&mut text);
        String::from_utf8_lossy(&text).into()
    })
}
