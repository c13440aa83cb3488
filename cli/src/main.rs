//! The `catamaran` command line: one file per subcommand.

mod arguments;
mod ata;
mod backend;
mod basis;
mod claims;
mod common;
mod completions;
mod curve;
mod decimate;
mod defaults;
mod demo;
mod descriptors;
mod device;
mod distance;
mod effects;
mod examples;
mod farthest;
mod filter;
mod folder;
mod generate;
mod gram;
mod headings;
#[cfg(test)]
mod help;
#[cfg(test)]
mod hints;
mod info;
mod input;
mod lstsq;
mod man;
mod merge;
mod mesh;
mod newton;
mod output;
mod parse;
mod pca;
mod picture;
mod pieces;
mod predict;
mod program;
mod progress;
mod ranks;
mod report;
mod rows;
mod shape;
mod shapedna;
mod shortage;
mod signals;
mod slime;
mod spectrum;
mod stdio;
mod svd;
mod tables;
mod topics;
mod transfer;
mod tune;
mod unexpected;
mod unions;
mod wilt;
mod wrap;

use std::io::{self, Write as _};
use std::process::ExitCode;

use anyhow::{Context, Result};
use catamaran::base::{FloatEnv, isa_limit, use_own_threads_only};
use clap::error::ErrorKind;
use clap::{FromArgMatches as _, Parser, Subcommand};

/// The end of the help text, with the exit codes of the process.
const AFTER_HELP: &str = "\
`catamaran COMMAND --help` describes a command and its options, and ends with examples.
`catamaran help topics` lists pages about files, memory, ranks and others.

Exit codes:
  0    success
  1    an error, which the last line on stderr names
  2    a wrong command line
  129  SIGHUP; 130: SIGINT (Ctrl-C); 138: SIGUSR1; 143: SIGTERM

Under mpirun or srun, the processes share the work of ata, lstsq, pca, svd and spectrum; other
commands refuse to run several times.";

/// A^T A, spectra and geometry at scale.
#[derive(Parser)]
#[command(
    name = "catamaran",
    version,
    arg_required_else_help = true,
    disable_help_subcommand = true,
    after_help = AFTER_HELP
)]
struct Cli {
    /// Most memory that one input file may take, in GiB: what it unpacks to, or what its header
    /// announces [default: a hundred times the size of the file, at least 1 GiB]. Also the most
    /// that a number of vertices, pixels, eigenpairs or frames may need [default: the available
    /// memory].
    #[arg(
        long,
        global = true,
        value_name = "GIB",
        value_parser = parse::gibibytes,
        help_heading = common::HEADING
    )]
    input_limit: Option<usize>,
    /// Print results only, without status lines and progress bars. Notes and errors still go to
    /// stderr.
    #[arg(long, global = true, help_heading = common::HEADING)]
    quiet: bool,
    /// Print JSON Lines on stdout instead of text: one object for each record, with the name of the
    /// record in `record`.
    #[arg(long, global = true, help_heading = common::HEADING)]
    json: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Ata(ata::Args),
    AtaMerge(merge::Args),
    Lstsq(lstsq::Args),
    Predict(predict::Args),
    Pca(pca::Args),
    Svd(svd::Args),
    Mesh(mesh::Args),
    Decimate(decimate::Args),
    #[command(alias = "fps")]
    Farthest(farthest::Args),
    Generate(generate::Args),
    Info(info::Args),
    Demo(demo::Args),
    Spectrum(spectrum::Args),
    Tune(tune::Args),
    Basis(basis::Args),
    Transfer(transfer::Args),
    Filter(filter::Args),
    Wilt(wilt::Args),
    Curve(curve::Args),
    Distance(distance::Args),
    Descriptors(descriptors::Args),
    #[command(name = "shapedna")]
    ShapeDna(shapedna::Args),
    Newton(newton::Args),
    Slime(slime::Args),
    Unions(unions::Args),
    Completions(completions::Args),
    Man(man::Args),
    Help(topics::Args),
}

impl Command {
    /// Returns whether the processes of `mpirun` share the work of the command.
    fn uses_ranks(&self) -> bool {
        match self {
            Self::Ata(_) | Self::Lstsq(_) | Self::Pca(_) | Self::Svd(_) | Self::Spectrum(_) => true,
            Self::AtaMerge(_)
            | Self::Predict(_)
            | Self::Mesh(_)
            | Self::Decimate(_)
            | Self::Farthest(_)
            | Self::Generate(_)
            | Self::Info(_)
            | Self::Demo(_)
            | Self::Tune(_)
            | Self::Basis(_)
            | Self::Transfer(_)
            | Self::Filter(_)
            | Self::Wilt(_)
            | Self::Curve(_)
            | Self::Distance(_)
            | Self::Descriptors(_)
            | Self::ShapeDna(_)
            | Self::Newton(_)
            | Self::Slime(_)
            | Self::Unions(_)
            | Self::Completions(_)
            | Self::Man(_)
            | Self::Help(_) => false,
        }
    }
}

fn main() -> ExitCode {
    // Before any other code allocates memory.
    let watched = shortage::watch();
    // A library that is linked with -ffast-math sets flush-to-zero when it is loaded.
    let _nearest = FloatEnv::nearest();
    use_own_threads_only();
    let (cli, name) = parse_command_line();
    input::set_limit(cli.input_limit);
    if cli.quiet {
        report::be_quiet();
    }
    if cli.json {
        report::use_json();
    }
    let done = watched
        .and_then(|()| signals::watch())
        .context("the handling of signals can't be started")
        .and_then(|()| Ok(isa_limit().map(drop)?))
        .and_then(|()| if cli.command.uses_ranks() { Ok(()) } else { ranks::refuse(&name) })
        .and_then(|()| shortage::guard(|| run(&cli.command)));
    let Err(error) = done else { return ExitCode::SUCCESS };
    signals::wait_for_end();
    shortage::wait_for_abort();
    if let Some(ranks::Said { status }) = error.downcast_ref() {
        return ExitCode::from(*status);
    }
    if matches!(error.downcast_ref(), Some(catamaran::Error::Cancelled)) {
        report::complain(format_args!("cancelled"));
        return signals::exit_code();
    }
    // The reader of stdout is gone, as in `catamaran info | head -1`: nobody can read a message.
    if error.downcast_ref().is_some_and(|e: &io::Error| e.kind() == io::ErrorKind::BrokenPipe) {
        return ExitCode::SUCCESS;
    }
    report::complain(format_args!("{}", report::message(&error)));
    ExitCode::FAILURE
}

/// Parses the command line, and returns it with the name of the command; exits with status 2 if it
/// is wrong.
fn parse_command_line() -> (Cli, String) {
    let mut command = program::program();
    let words: Vec<_> = std::env::args_os().collect();
    let mut matches = command.try_get_matches_from_mut(&words).unwrap_or_else(|error| {
        let error = unexpected::explained(parse::explained(error, &command), &command, &words);
        // `-V` prints the version only.
        let is_long = words.iter().any(|word| word == "--version");
        if error.kind() == ErrorKind::DisplayVersion && is_long {
            // Nobody reads what can't be printed.
            let _ = io::stdout().write_all(info::long_version().as_bytes());
            std::process::exit(0);
        }
        ranks::leave(&wrap::wrapped(error))
    });
    if let Some(what) = stdio::refusal(&command, &matches) {
        ranks::leave(&command.error(ErrorKind::ValueValidation, what));
    }
    if let Some(what) = topics::refusal(&command, &matches) {
        ranks::leave(&command.error(ErrorKind::InvalidSubcommand, what));
    }
    if let Some(what) = effects::missing(&matches) {
        ranks::leave(&command.error(ErrorKind::ArgumentConflict, what));
    }
    claims::claim_inputs(&command, &matches);
    arguments::set_command(&command, &matches);
    let name = matches.subcommand_name().unwrap_or_default().to_owned();
    let cli = Cli::from_arg_matches_mut(&mut matches);
    (cli.unwrap_or_else(|e| ranks::leave(&e.format(&mut command))), name)
}

fn run(command: &Command) -> Result<()> {
    match command {
        Command::Ata(args) => ata::run(args),
        Command::AtaMerge(args) => merge::run(args),
        Command::Lstsq(args) => lstsq::run(args),
        Command::Predict(args) => predict::run(args),
        Command::Pca(args) => pca::run(args),
        Command::Svd(args) => svd::run(args),
        Command::Mesh(args) => mesh::run(args),
        Command::Decimate(args) => decimate::run(args),
        Command::Farthest(args) => farthest::run(args),
        Command::Generate(args) => generate::run(args),
        Command::Info(args) => info::run(args),
        Command::Demo(args) => demo::run(args),
        Command::Spectrum(args) => spectrum::run(args),
        Command::Tune(args) => tune::run(args),
        Command::Basis(args) => basis::run(args),
        Command::Transfer(args) => transfer::run(args),
        Command::Filter(args) => filter::run(args),
        Command::Wilt(args) => wilt::run(args),
        Command::Curve(args) => curve::run(args),
        Command::Distance(args) => distance::run(args),
        Command::Descriptors(args) => descriptors::run(args),
        Command::ShapeDna(args) => shapedna::run(args),
        Command::Newton(args) => newton::run(args),
        Command::Slime(args) => slime::run(args),
        Command::Unions(args) => unions::run(args),
        Command::Completions(args) => completions::run(args),
        Command::Man(args) => man::run(args),
        Command::Help(args) => topics::run(args),
    }
}
