//! `catamaran unions`.

mod dataset;

use anyhow::Result;
use clap::Subcommand;

/// Spectral unions of partial shapes: data to learn from.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Dataset(dataset::Args),
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    match &args.command {
        Command::Dataset(args) => dataset::run(args),
    }
}
