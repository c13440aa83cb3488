//! The command line of the driver.

use std::path::PathBuf;

use catamaran::SchemeChoice;
use catamaran::io::RowFile;
use catamaran::ranks::plan::{Machine, Mode, Place, choose};
use catamaran_bench::contender::scheme_named;
use catamaran_bench::input::Shape;
use clap::Parser;

use crate::job::Job;

/// Measures A^T A on the ranks of mpirun or srun: time, GFLOP/s, % of peak, words and messages.
#[derive(Clone, Parser)]
#[command(name = "catamaran-ata-mpi", args_override_self = true, after_help = AFTER, version)]
pub struct Arguments {
    /// Rows of A.
    #[arg(short, default_value_t = 4096, value_parser = side, help_heading = PROBLEM)]
    pub m: usize,
    /// Columns of A.
    #[arg(short, default_value_t = 4096, value_parser = side, help_heading = PROBLEM)]
    pub n: usize,
    /// Uses entries of 4 bytes (f32) instead of 8 (f64).
    #[arg(long, help_heading = PROBLEM)]
    pub f32: bool,
    /// Reads A from FILE (.npy, or F.h5:/dataset with HDF5), in mode rows.
    #[arg(long, value_name = "FILE", help_heading = PROBLEM)]
    #[arg(conflicts_with_all = ["m", "n", "rival"])]
    pub file: Option<PathBuf>,
    /// Seed of A, which is uniform in [-1, 1).
    #[arg(long, default_value_t = 1, help_heading = PROBLEM)]
    pub seed: u64,

    /// Where A is before and C after: see the table below.
    #[arg(long, value_name = "MODE", default_value = "auto", help_heading = WAY)]
    mode: Choice,
    /// Threads of each rank.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    #[arg(value_name = "T", help_heading = WAY)]
    pub threads: u16,
    /// Scheme of a rank's share, such as ata2 (the thesis' AtA-S).
    #[arg(long, default_value = "auto", value_parser = scheme_named, help_heading = WAY)]
    scheme: SchemeChoice,

    /// Measured repetitions; one more comes first and is not counted.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..))]
    #[arg(value_name = "R", help_heading = MEASUREMENT)]
    pub repeat: u16,
    /// Checks the last product, and words and messages against the plan.
    #[arg(long, help_heading = MEASUREMENT)]
    pub check: bool,
    /// Races pdsyrk by turns, of the system's ScaLAPACK or of pdsyrk=PATH.
    #[arg(long, help_heading = MEASUREMENT)]
    pub rival: Option<Rival>,

    /// Prints words and messages beside the lower bound, and the rival's trials.
    #[arg(long, help_heading = OUTPUT)]
    pub explain: bool,
    /// Appends a line to FILE, after a header if it is new.
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub csv: Option<PathBuf>,
    /// Measures strong and weak scaling; writes NAME.csv and NAME.svg.
    #[arg(long, value_name = "NAME", help_heading = OUTPUT)]
    #[arg(conflicts_with_all = ["check", "rival", "explain", "csv", "record"])]
    pub scaling: Option<String>,
    /// Writes NAME.csv and host.txt under bench/record, NAME.svg into target/record.
    #[arg(long, value_name = "NAME", help_heading = OUTPUT)]
    pub record: Option<String>,
}

const PROBLEM: &str = "Product";
const WAY: &str = "Computation";
const MEASUREMENT: &str = "Measurement";
const OUTPUT: &str = "Output";

const AFTER: &str = "\
Modes:
  rows    rows of A on every rank, C stays distributed      tall A
  grid    columns of A on every rank, C stays distributed   square and wide A
  bricks  rows of columns of A, C stays distributed         square A, many ranks
  auto    the fastest one of rows, grid and bricks, as predicted
  tree    A and C on rank 0, by AtA-D (the thesis)
  deal    A and C on rank 0, rows are dealt
  root    the faster one of tree and deal, as predicted

Units:
  seconds of wall time; GFLOP/s of m n^2 operations, whatever the scheme does;
  words are entries of A or C, messages those of MPI, both of the rank with most;
  % of peak is of the multiply-adds in registers that all threads reach together.

Examples:
  mpirun -n 4 catamaran-ata-mpi -m 600000 -n 500 --mode rows --check
  mpirun -n 2 --bind-to none catamaran-ata-mpi -m 8192 -n 8192 --threads 8 --csv runs.csv
  mpirun -n 8 catamaran-ata-mpi -m 600000 -n 500 --scaling scaling
  srun -N 8 --ntasks-per-node=1 --cpus-per-task=16 \\
      catamaran-ata-mpi -m 60000 -n 60000 --mode tree --threads 16 --check

Exit codes:
  0  measured; checks passed, if there were any
  1  a check failed
  2  wrong arguments
  3  any other error: memory, files, libraries, MPI";

/// A mode, or the best mode for a placement of A and C.
#[derive(Clone, Copy)]
enum Choice {
    Named(Mode),
    Best(Place),
}

impl std::str::FromStr for Choice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let named = Mode::NAMES.iter().find(|(name, _)| *name == text);
        match (named, text) {
            (Some((_, mode)), _) => Ok(Self::Named(*mode)),
            (None, "auto") => Ok(Self::Best(Place::EveryRank)),
            (None, "root") => Ok(Self::Best(Place::OneRank)),
            _ => Err("no such mode, must be rows, grid, bricks, auto, tree, deal or root".into()),
        }
    }
}

/// A library to race against.
#[derive(Clone)]
pub struct Rival {
    /// The file of the library; `None` for that of the system.
    pub path: Option<PathBuf>,
}

impl std::str::FromStr for Rival {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some(("pdsyrk", path)) => Ok(Self { path: Some(path.into()) }),
            None if text == "pdsyrk" => Ok(Self { path: None }),
            _ => Err("no such rival, must be pdsyrk or pdsyrk=PATH".into()),
        }
    }
}

/// Parses a side of A, which pdsyrk counts in 32 bits.
fn side(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(side) if (1..=i32::MAX as usize).contains(&side) => Ok(side),
        _ => Err("a side is a whole number from 1 to 2147483647".into()),
    }
}

impl Arguments {
    /// Returns the arguments with the sides of the matrix in the file, if there is one.
    ///
    /// # Errors
    /// When the file can't be read by rows, or another mode was requested.
    pub fn with_sides_of_file(&self) -> catamaran_bench::Result<Self> {
        let mut all = self.clone();
        let Some(file) = &self.file else { return Ok(all) };
        if matches!(self.mode, Choice::Named(mode) if mode != Mode::Rows) {
            return Err("--file: each rank reads some rows of A, which is --mode rows".into());
        }
        let rows = RowFile::open(file)?;
        (all.m, all.n) = (rows.nrows(), rows.ncols());
        if all.m == 0 || all.n == 0 {
            return Err(
                format!("{}: {} x {}, without entries", file.display(), all.m, all.n).into()
            );
        }
        Ok(all)
    }

    /// Returns the product on this number of ranks.
    pub fn job(&self, ranks: usize) -> Job {
        let shape = Shape { m: self.m, n: self.n };
        let mode = match self.mode {
            Choice::Named(mode) => mode,
            Choice::Best(_) if self.file.is_some() => Mode::Rows,
            Choice::Best(place) => choose(ranks, self.m, self.n, &Machine::default(), place),
        };
        Job { mode, shape, seed: self.seed, threads: self.threads.into(), scheme: self.scheme }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn wrong_values_are_named() {
        let refused = |arguments: &[&str]| {
            let all = ["catamaran-ata-mpi"].iter().chain(arguments);
            Arguments::try_parse_from(all).err().expect("refused").to_string()
        };
        assert!(refused(&["-m", "0"]).contains("'0' for '-m"));
        assert!(refused(&["-n", "-3"]).contains("-3"));
        assert!(refused(&["--threads", "0"]).contains("'0' for '--threads"));
        assert!(refused(&["--repeat", "0"]).contains("'0' for '--repeat"));
        assert!(
            refused(&["--mode", "square"]).contains("rows, grid, bricks, auto, tree, deal or root")
        );
        assert!(refused(&["--rival", "dsyrk"]).contains("pdsyrk=PATH"));
        assert!(refused(&["--scheme", "ata9"]).contains("ata9"));
        assert!(refused(&["--scaling", "s", "--check"]).contains("--check"));
    }

    /// Returns the arguments of every command of a text that names the driver after a launcher.
    fn commands(text: &str) -> Vec<String> {
        let joined = text.replace("\\\n", " ");
        let is_command = |line: &&str| line.contains("mpirun") || line.contains("srun");
        let arguments = |line: &str| {
            let (_, arguments) = line.split_once("catamaran-ata-mpi")?;
            let arguments = arguments.split('`').next()?;
            Some(arguments.replace("\"$SLURM_CPUS_PER_TASK\"", "16").replace("\"$mode\"", "rows"))
        };
        joined.lines().filter(is_command).filter_map(arguments).collect()
    }

    #[test]
    fn the_commands_of_the_help_and_the_guide_are_accepted() {
        let guide = include_str!("../../../../docs/guide/cluster.md");
        let all = [commands(AFTER), commands(guide)].concat();
        assert!(all.len() >= 10, "{all:?}");
        for arguments in all {
            let words = ["catamaran-ata-mpi"].into_iter().chain(arguments.split_whitespace());
            assert!(Arguments::try_parse_from(words).is_ok(), "{arguments}");
        }
    }

    #[test]
    fn the_help_has_a_heading_for_every_option_and_fits_100_columns() {
        let mut command = Arguments::command();
        let own = command.get_arguments().filter(|a| a.get_help_heading().is_none());
        let without: Vec<_> = own.map(|argument| argument.get_id().to_string()).collect();
        assert_eq!(without, ["help", "version"].map(str::to_owned)[..without.len()]);
        let help = command.render_help().to_string();
        assert!(help.lines().all(|line| line.chars().count() <= 100), "{help}");
        for part in ["Product:", "Computation:", "Measurement:", "Output:", "Units:", "Exit codes:"]
        {
            assert!(help.contains(&format!("\n{part}\n")), "{part}: {help}");
        }
    }
}
