//! `mpirun -n P catamaran-ata-mpi`: A^T A on many ranks, beside ScaLAPACK's pdsyrk in the same run.
//!
//! See README.md of the package for what is measured and how.

mod job;
mod ours;
mod race;
mod ranks;
mod report;
mod rival;
mod scalapack;

use std::path::{Path, PathBuf};

use catamaran::SchemeChoice;
use catamaran::ata::distributed::{Machine, Mode, Place, choose};
use catamaran_bench::contender::scheme_named;
use catamaran_bench::input::Shape;
use catamaran_bench::{Result, host};
use clap::Parser;

use job::Job;
use ranks::Ranks;

/// A^T A on the ranks of mpirun, repeated and measured.
#[derive(Parser)]
#[command(name = "catamaran-ata-mpi", args_override_self = true)]
struct Arguments {
    /// Rows of A.
    #[arg(short, default_value_t = 4096, value_parser = side)]
    m: usize,
    /// Columns of A.
    #[arg(short, default_value_t = 4096, value_parser = side)]
    n: usize,
    /// Where A is, and where C shall be: rows of A on every rank (rows), columns of A on every rank (grid), or whichever
    /// of these two should be faster (auto); or both on rank 0, by AtA-D (tree), by dealing rows (deal), or by whichever
    /// of these two should be faster (root).
    #[arg(long, value_name = "MODE", default_value = "auto")]
    mode: Choice,
    /// Entries are f32 instead of f64.
    #[arg(long)]
    f32: bool,
    /// Threads of each rank.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    threads: u16,
    /// What a rank does with its share: a scheme of A^T A, such as ata2, the thesis' own (AtA-S, a task a thread).
    #[arg(long, value_name = "SCHEME", default_value = "auto", value_parser = scheme_named)]
    scheme: SchemeChoice,
    /// Repetitions; one more comes first, and is not counted.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..))]
    repeat: u16,
    /// Seed of A.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Checks the last result: with random vectors, and against the rival's.
    #[arg(long)]
    check: bool,
    /// Prints words and messages of a rank beside the lower bound, and the distributions that the rival tries.
    #[arg(long)]
    explain: bool,
    /// Whom to race: pdsyrk, of the system's ScaLAPACK for this MPI, or pdsyrk=PATH of another one.
    #[arg(long)]
    rival: Option<Rival>,
    /// Writes the race into NAME.csv, in the place of an earlier one of the same shape, and host.txt under
    /// bench/record.
    #[arg(long, value_name = "NAME")]
    record: Option<String>,
}

/// A mode, or the best one at a place.
#[derive(Clone, Copy)]
enum Choice {
    Named(Mode),
    Best(Place),
}

impl std::str::FromStr for Choice {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let named = Mode::NAMES.iter().find(|(name, _)| *name == text);
        match (named, text) {
            (Some((_, mode)), _) => Ok(Self::Named(*mode)),
            (None, "auto") => Ok(Self::Best(Place::EveryRank)),
            (None, "root") => Ok(Self::Best(Place::OneRank)),
            _ => Err("no such mode: rows, grid, auto, tree, deal or root".into()),
        }
    }
}

#[derive(Clone)]
struct Rival {
    path: Option<PathBuf>,
}

impl std::str::FromStr for Rival {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text.split_once('=') {
            Some(("pdsyrk", path)) => Ok(Self { path: Some(path.into()) }),
            None if text == "pdsyrk" => Ok(Self { path: None }),
            _ => Err("no such rival: pdsyrk, or pdsyrk=PATH".into()),
        }
    }
}

/// A side of A, which pdsyrk counts in 32 bits.
fn side(text: &str) -> std::result::Result<usize, String> {
    match text.parse() {
        Ok(side) if (1..=i32::MAX as usize).contains(&side) => Ok(side),
        _ => Err("not between 1 and 2147483647".into()),
    }
}

impl Arguments {
    fn job(&self, ranks: usize) -> Job {
        let shape = Shape { m: self.m, n: self.n };
        let mode = match self.mode {
            Choice::Named(mode) => mode,
            Choice::Best(place) => choose(ranks, self.m, self.n, &Machine::default(), place),
        };
        Job { mode, shape, seed: self.seed, threads: self.threads.into(), scheme: self.scheme }
    }
}

fn main() {
    let arguments = Arguments::parse();
    let done = host::with_environment_for_rivals(Path::new("target/rivals"))
        .and_then(|()| with_mpi(&arguments));
    match done {
        Ok(true) => {}
        Ok(false) => std::process::exit(1),
        Err(error) => {
            eprintln!("catamaran-ata-mpi: {error}");
            std::process::exit(1);
        }
    }
}

/// The race between the start and the end of MPI. Its errors are those of all ranks: one tells them, and all return
/// false.
fn with_mpi(arguments: &Arguments) -> Result<bool> {
    let (universe, _) =
        mpi::initialize_with_threading(mpi::Threading::Funneled).ok_or("MPI runs already")?;
    let comm = universe.world();
    let ranks = Ranks(&comm);
    let done = if arguments.f32 {
        race::race::<f32>(arguments, &ranks)
    } else {
        race::race::<f64>(arguments, &ranks)
    };
    if let Err(error) = &done
        && ranks.own() == ours::ROOT
    {
        eprintln!("catamaran-ata-mpi: {error}");
    }
    Ok(done.is_ok())
}
