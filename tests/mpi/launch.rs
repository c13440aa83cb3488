//! One program in two roles: the launcher, which cargo starts, and a rank, which `mpirun` starts.

use std::io::Read;
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use catamaran::mpi::World;
use mpi::topology::Communicator;

use crate::Case;

/// What happens when something goes wrong on one of `ranks` ranks.
pub struct Scene {
    pub name: &'static str,
    pub ranks: usize,
    /// What each rank does.
    pub play: fn(&World),
    /// What must be printed, by all together.
    pub printed: &'static [&'static str],
    /// Whether the job succeeds nevertheless.
    pub succeeds: bool,
}

const RANKS: [usize; 6] = [1, 2, 3, 4, 7, 8];
/// Set for ranks: what they do, and how many they must be.
const ROLE: &str = "CATAMARAN_TEST_ROLE";
const SIZE: &str = "CATAMARAN_TEST_SIZE";
/// A job that takes longer hangs.
const LIMIT: Duration = Duration::from_secs(120);

/// Plays the part that this process has.
pub fn run(cases: &[Case], scenes: &[Scene]) {
    match std::env::var(ROLE) {
        Ok(role) => be_rank(&role, cases, scenes),
        Err(_) => launch(cases, scenes),
    }
}

fn be_rank(role: &str, cases: &[Case], scenes: &[Scene]) {
    let universe = mpi::initialize().expect("MPI starts");
    let world = universe.world();
    let expected = std::env::var(SIZE).expect("the number of ranks").parse();
    assert_eq!(Ok(world.size()), expected, "mpirun belongs to another MPI than the program");
    if let Some(scene) = scenes.iter().find(|scene| scene.name == role) {
        return (scene.play)(&World::new(&world));
    }
    // A failed assertion on one rank must not leave the others waiting.
    let hook = std::panic::take_hook();
    let abort = world.duplicate();
    let abort = move || abort.abort(1);
    std::panic::set_hook(Box::new(move |info| {
        hook(info);
        let _ = &hook;
    }));
    for (name, case) in cases.iter().filter(|(name, _)| role.split(',').any(|r| r == *name)) {
        let passed = std::panic::catch_unwind(|| case(&World::new(&world)));
        if passed.is_err() {
            eprintln!("rank {}: {name} failed", world.rank());
            abort();
        }
        if world.rank() == 0 {
            println!("test {name} on {} ranks ... ok", world.size());
        }
    }
}

fn launch(cases: &[Case], scenes: &[Scene]) {
    todo!()
}
