//! What is distributed under `mpirun`: every case on 1, 2, 3, 4, 7 and 8 ranks, and scenes that
//! must end in an error on every rank, or in an abort, but never hang.
//!
//! Started by cargo, this program starts itself under `mpirun`; `MPIRUN` names another launcher,
//! and arguments select cases by parts of their names.

mod bricks;
mod columns;
#[path = "../common/counting.rs"]
mod counting;
mod cyclic;
mod eigen;
mod failures;
mod gram;
mod launch;
mod matrices;
mod memory;
mod ortho;
mod root;
mod rows;
mod same;
mod verify;

use std::process::ExitCode;

use catamaran::ranks::World;

/// A named check that all ranks make together; a panic is a failure.
pub type Case = (&'static str, fn(&World));

/// What must happen when something goes wrong.
#[derive(Clone, Copy)]
pub struct Scene {
    /// Says what must happen.
    pub name: &'static str,
    /// How many ranks play it.
    pub ranks: usize,
    /// The rank, if any, that the system gives no more threads.
    pub starved: Option<i32>,
    /// What each rank does.
    pub play: fn(&World),
    /// What must be printed, by all ranks and `mpirun` together.
    pub printed: &'static [&'static str],
    /// Whether the job succeeds nevertheless.
    pub succeeds: bool,
}

fn main() -> ExitCode {
    let cases = [
        rows::CASES,
        columns::CASES,
        bricks::CASES,
        root::CASES,
        cyclic::CASES,
        verify::CASES,
        memory::CASES,
        ortho::CASES,
        eigen::CASES,
        gram::CASES,
        same::CASES,
    ];
    let scenes = [
        failures::SCENES,
        bricks::SCENES,
        root::SCENES,
        cyclic::SCENES,
        ortho::SCENES,
        eigen::SCENES,
        gram::SCENES,
        same::SCENES,
    ];
    launch::run(&cases.concat(), &scenes.concat())
}
