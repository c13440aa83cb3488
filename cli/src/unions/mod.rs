//! `catamaran unions`.

mod curve;
mod dataset;
mod interpolate;
mod parts;
mod predict;
mod shape;
mod template;
mod train;
mod tune;

use anyhow::Result;
use clap::Subcommand;

/// Predict the spectra of unions of partial shapes, and train the network for them.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Predict(predict::Args),
    Interpolate(interpolate::Args),
    Shape(shape::Args),
    Dataset(dataset::Args),
    Train(train::Args),
    Tune(tune::Args),
    Template(template::Args),
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    match &args.command {
        Command::Predict(args) => predict::run(args),
        Command::Interpolate(args) => interpolate::run(args),
        Command::Shape(args) => shape::run(args),
        Command::Dataset(args) => dataset::run(args),
        Command::Train(args) => train::run(args),
        Command::Tune(args) => tune::run(args),
        Command::Template(args) => template::run(args),
    }
}
