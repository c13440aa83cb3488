//! The `catamaran` command line: one file per subcommand.

mod ata;
mod backend;
mod basis;
mod curve;
mod decimate;
mod demo;
mod descriptors;
mod device;
mod distance;
mod filter;
mod fps;
mod gram;
mod info;
mod input;
mod lstsq;
mod merge;
mod mesh;
mod newton;
mod output;
mod parse;
mod pca;
mod picture;
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
mod svd;
mod transfer;
mod tune;
mod unions;
mod wilt;

use std::io;
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::{Parser, Subcommand};

/// A^T A, spectra and geometry at scale.
#[derive(Parser)]
#[command(name = "catamaran", version, about, arg_required_else_help = true)]
struct Cli {
    /// Memory that a file read may take, for what it unpacks to and for what its header announces;
    /// default a hundred times its size, or 1 GiB if that is more.
    #[arg(long, global = true, value_name = "GIB", value_parser = parse::gibibytes)]
    max_memory: Option<usize>,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Ata(ata::Args),
    AtaMerge(merge::Args),
    Lstsq(lstsq::Args),
    Pca(pca::Args),
    Svd(svd::Args),
    Mesh(mesh::Args),
    Decimate(decimate::Args),
    Fps(fps::Args),
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
}

fn main() -> ExitCode {
    // Before anything else needs memory.
    let watched = shortage::watch();
    let cli = Cli::parse();
    input::limit_memory(cli.max_memory);
    let done = watched
        .and_then(|()| signals::watch())
        .context("the thread that waits for signals can't be started")
        .and_then(|()| shortage::guard(|| run(&cli.command)));
    let Err(error) = done else { return ExitCode::SUCCESS };
    if matches!(error.downcast_ref(), Some(catamaran::Error::Cancelled)) {
        report::complain(format_args!("cancelled"));
        return signals::exit_code();
    }
    // The reader of our output has gone, as in `catamaran info | head -1`: nobody to tell.
    if error.downcast_ref().is_some_and(|e: &io::Error| e.kind() == io::ErrorKind::BrokenPipe) {
        return ExitCode::SUCCESS;
    }
    report::complain(format_args!("{}", report::message(&error)));
    ExitCode::FAILURE
}

fn run(command: &Command) -> Result<()> {
    match command {
        Command::Ata(args) => ata::run(args),
        Command::AtaMerge(args) => merge::run(args),
        Command::Lstsq(args) => lstsq::run(args),
        Command::Pca(args) => pca::run(args),
        Command::Svd(args) => svd::run(args),
        Command::Mesh(args) => mesh::run(args),
        Command::Decimate(args) => decimate::run(args),
        Command::Fps(args) => fps::run(args),
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
    }
}
