//! `catamaran unions`.

mod curve;
mod dataset;
mod predict;
mod shape;
mod template;
mod train;

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
    Shape(shape::Args),
    Dataset(dataset::Args),
    Train(train::Args),
    Template(template::Args),
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    match &args.command {
        Command::Predict(args) => predict::run(args),
        Command::Shape(args) => shape::run(args),
        Command::Dataset(args) => dataset::run(args),
        Command::Train(args) => train::run(args),
        Command::Template(args) => template::run(args),
    }
}
