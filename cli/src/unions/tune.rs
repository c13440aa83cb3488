//! `catamaran unions tune`.

use std::io::Write as _;
use std::path::PathBuf;

use anyhow::{Context, Result};
use catamaran_geometry::mesh::{Boundary, TriMesh};
use catamaran_training::train::Trainer;
use catamaran_training::tune::{TuneOptions, divide_pairs, family_pairs, start};

use super::parts::model;
use crate::common::{Force, Threads, as_option};
use crate::input::MeshArgs;
use crate::parse;
use crate::pieces::Pieces;
use crate::progress::{self, Bar};
use crate::report::{note, report, status};

/// Fit the network of `unions predict` to a family of shapes, from about 50 meshes.
///
/// Cuts parts out of each mesh by balls and planes, and continues the training on their spectra.
/// One mesh in ten is held out, and the error on its pairs is printed before and after. The family
/// has no template, so that `unions predict --localize` has no meaning with the new weights.
#[derive(clap::Args)]
pub struct Args {
    #[arg(
        value_name = "MESHES",
        num_args = 2..,
        required = true,
        help = crate::input::mesh_help("Complete shapes of the family")
    )]
    meshes: Vec<PathBuf>,
    /// Output file of the new weights: .safetensors.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Weights to start from: .safetensors [default: those of the program].
    #[arg(long, value_name = "FILE")]
    weights: Option<PathBuf>,
    /// Approximate number of pairs of parts of each mesh.
    #[arg(
        long,
        value_name = "NUMBER",
        default_value_t = TuneOptions::default().pairs,
        value_parser = parse::at_least_one
    )]
    pairs: usize,
    /// Number of passes over the pairs.
    #[arg(
        long,
        value_name = "NUMBER",
        default_value_t = TuneOptions::default().epochs,
        value_parser = parse::at_least_one
    )]
    epochs: usize,
    /// Largest learning rate.
    #[arg(long, value_name = "NUMBER", default_value_t = TuneOptions::default().rate)]
    rate: f64,
    /// Seed of all randomness.
    #[arg(long, value_name = "NUMBER", default_value_t = TuneOptions::default().seed)]
    seed: u64,
    #[command(flatten)]
    repair: MeshArgs,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    force: Force,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let mut output = args.force.create(&args.output)?;
    let base = model(args.weights.as_deref())?;
    let read = |path: &PathBuf| {
        let mesh = args.repair.read(path)?.mesh;
        Pieces::new(&mesh, path, &args.repair, &Boundary::Neumann)?.note();
        Ok(mesh)
    };
    let options = TuneOptions {
        pairs: args.pairs,
        epochs: args.epochs,
        rate: args.rate,
        seed: args.seed,
        ..TuneOptions::default()
    };
    let (settings, state) = start(&base, &options);
    settings.check().map_err(as_option)?;
    let meshes: Vec<TriMesh> = args.meshes.iter().map(read).collect::<Result<_>>()?;
    let par = args.threads.par();
    let bar = Bar::new("parts");
    let (mut pairs, mut without) = (Vec::with_capacity(meshes.len()), Vec::new());
    for (number, (mesh, path)) in meshes.iter().zip(&args.meshes).enumerate() {
        bar.step(number as f64 / meshes.len() as f64)?;
        let name = || path.display().to_string();
        let own = family_pairs(mesh, number, &options, par).with_context(name)?;
        if own.is_empty() {
            without.push(name());
        }
        pairs.push(own);
    }
    drop(bar);
    if let Some(first) = without.first() {
        note(format_args!(
            "{first}: no pair of parts could be cut; of {} meshes, {} give none",
            meshes.len(),
            without.len()
        ));
    }
    let examples = divide_pairs(pairs, &base, &options)?;
    let (training, aside) = (examples.training.len(), examples.validation.len());
    status!(
        "data",
        training = training,
        validation = aside;
        "{training} training pairs, {aside} validation pairs of meshes that are held out"
    )?;
    let mut trainer = Trainer::new(examples, settings, Some(state), par)?;
    let before = 100.0 * trainer.best_error();
    report!("before", error_percent = before; "validation error {before:.3} %")?;
    for number in 1..=options.epochs {
        progress::check()?;
        let epoch = trainer.epoch()?;
        let [training, aside] = [epoch.training, epoch.validation].map(|x| 100.0 * x);
        report!(
            "epoch",
            number = number,
            training_error_percent = training,
            validation_error_percent = aside;
            "{number}: training error {training:.3} %, validation error {aside:.3} %"
        )?;
    }
    let after = 100.0 * trainer.best_error();
    report!("after", error_percent = after; "validation error {after:.3} %")?;
    let bytes = trainer.model()?.to_bytes()?;
    output.write_all(&bytes).map_err(|e| output.error(e))?;
    output.commit()?;
    let path = args.output.display().to_string();
    status!("written", path = path; "{path}")
}
