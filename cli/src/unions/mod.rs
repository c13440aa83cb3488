//! `catamaran unions`.

mod curve;
mod dataset;
mod predict;
mod train;
mod train_regions;

use anyhow::Result;
use clap::Subcommand;

/// Spectral unions of partial shapes: predict them, and data and training for that.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Predict(predict::Args),
    Dataset(dataset::Args),
    Train(train::Args),
    TrainRegions(train_regions::Args),
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    match &args.command {
        Command::Predict(args) => predict::run(args),
        Command::Dataset(args) => dataset::run(args),
        Command::Train(args) => train::run(args),
        Command::TrainRegions(args) => train_regions::run(args),
    }
}
