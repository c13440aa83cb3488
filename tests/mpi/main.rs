//! The distributed products under `mpirun`: every case on 1, 2, 3, 4, 7 and 8 ranks, and what must end in
//! an error on every rank, or in an abort, but never hang.
//!
//! Started by cargo, this program starts itself under `mpirun`; `MPIRUN` names another launcher, and
//! arguments select cases by parts of their names.

mod columns;
mod failures;
mod launch;
mod matrices;
mod rows;

use catamaran::mpi::World;

/// A named check that all ranks make together; a panic is a failure.
pub type Case = (&'static str, fn(&World));

fn main() {
    let cases: Vec<Case> = [rows::CASES, columns::CASES].concat();
    launch::run(&cases, failures::SCENES);
}
