//! `mpirun -n P catamaran-ata-mpi`: A^T A on many ranks, beside ScaLAPACK's pdsyrk in the same run.
//!
//! docs/guide/cluster.md says how to run it, README.md of the package what is measured and how.

mod arguments;
mod checks;
mod job;
mod ours;
mod picture;
mod race;
mod ranks;
mod report;
mod rival;
mod row;
mod scalapack;
mod scaling;

use std::path::Path;
use std::process::ExitCode;

use catamaran::ranks::Launch;
use catamaran_bench::host::Kernels;
use catamaran_bench::{Result, host};
use clap::Parser;

use arguments::Arguments;
use ranks::Ranks;

/// Exit code of a failed check. The exit code of wrong arguments is 2, that of clap.
const CHECK_FAILED: u8 = 1;
/// Exit code of all other errors.
const ERROR: u8 = 3;

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            return of_job(error.exit_code() as u8, || {
                // If help can't be printed, an error message can't be printed either.
                let _ = error.print();
            });
        }
    };
    let done = host::with_environment_for_rivals(Path::new("target/rivals"), Kernels::OfOldLibrary)
        .and_then(|()| with_mpi(&arguments));
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => of_job(CHECK_FAILED, || ()),
        Err(error) => of_job(ERROR, || eprintln!("catamaran-ata-mpi: {error}")),
    }
}

/// Returns the exit code of a job that ends with the same error on all ranks: the first reports it
/// and returns `code`, the others return success, for mpirun ends all when the first process fails,
/// possibly before the report.
fn of_job(code: u8, report: impl FnOnce()) -> ExitCode {
    if Launch::of_process().is_some_and(|launch| !launch.speaks()) {
        return ExitCode::SUCCESS;
    }
    report();
    code.into()
}

/// Runs the race between the start and the end of MPI; returns whether all checks passed.
///
/// On all ranks if any rank has an error.
fn with_mpi(arguments: &Arguments) -> Result<bool> {
    let (universe, _) =
        mpi::initialize_with_threading(mpi::Threading::Funneled).ok_or("MPI is already running")?;
    let comm = universe.world();
    let ranks = Ranks(&comm);
    let arguments = &ranks.agree(arguments.with_sides_of_file())?;
    if arguments.f32 {
        race::race::<f32>(arguments, &ranks)
    } else {
        race::race::<f64>(arguments, &ranks)
    }
}
