//! Faults are injected into every command: full disks, failing reads, kills, lack of memory.
//!
//! The quick part runs with all other tests. `CATAMARAN_FAULTS=full` injects more: every limit of
//! memory and of file sizes, twenty kills of each command that can resume, ten of a rank of
//! `mpirun`. `scripts/faults` does that and prints the table of docs/reliability.md.
//!
//! [`commands::LINES`] is the only list of commands; a command that `--help` names and the list
//! does not is a failure.
#![cfg(target_os = "linux")]

use std::collections::BTreeMap;

#[path = "../common/mod.rs"]
mod common;

mod commands;
mod disk;
mod kills;
mod memory;
#[cfg(feature = "mpi")]
mod ranks;
mod reads;
mod scene;

/// Whether all faults are to be injected, not a few.
fn is_full() -> bool {
    std::env::var_os("CATAMARAN_FAULTS").is_some_and(|value| value == "full")
}

/// A line of the table of docs/reliability.md.
fn record(fault: &str, command: &str, injected: usize, outcomes: &str) {
    println!("| {fault} | `{command}` | {injected} | {outcomes} |");
}

/// What came of the faults of one kind, by commands.
#[derive(Default)]
struct Tally(BTreeMap<String, [usize; 2]>);

impl Tally {
    /// Counts a run of this line.
    fn add(&mut self, line: &str, has_failed: bool) {
        let counts = self.0.entry(commands::command_of(line)).or_default();
        counts[usize::from(has_failed)] += 1;
    }

    /// A line of the table for each command.
    fn record(self, fault: &str) {
        for (command, [results, errors]) in self.0 {
            let outcomes = format!("{errors} errors, {results} whole results");
            record(fault, &command, errors + results, &outcomes);
        }
    }
}
