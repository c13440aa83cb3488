//! `catamaran unions tune`.

use std::io::Write as _;
use std::path::PathBuf;

use anyhow::{Result, bail};
use catamaran::base::Progress;
use catamaran::mesh::TriMesh;
use catamaran_training::train::Trainer;
use catamaran_training::tune::{TuneOptions, family_examples, start};

use super::parts::model;
use crate::common::{Force, Threads};
use crate::input::MeshArgs;
use crate::progress::{self, Bar};
use crate::report::{report, status};

/// Fit the network of `unions predict` to a family of shapes, from 50 meshes or so.
///
/// Cuts parts out of each mesh by balls and planes, and goes on with the training on their spectra.
/// One mesh in ten is kept aside; its error, before and after, is printed. No template of the
/// family is known, so --localize has no meaning with the new weights.
#[derive(clap::Args)]
pub struct Args {
    /// Complete shapes of the family: .obj, .ply, .off, .stl, .glb or .gltf, each also as .gz or
    /// .xz.
    #[arg(value_name = "MESHES", num_args = 2.., required = true)]
    meshes: Vec<PathBuf>,
    /// The new weights: .safetensors.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Weights to begin with, instead of those that come with the program.
    #[arg(long, value_name = "FILE")]
    weights: Option<PathBuf>,
    /// Pairs of parts of each mesh, about.
    #[arg(long, value_name = "NUMBER", default_value_t = TuneOptions::default().pairs)]
    pairs: usize,
    /// Passes over the pairs.
    #[arg(long, value_name = "NUMBER", default_value_t = TuneOptions::default().epochs)]
    epochs: usize,
    /// Largest rate of the optimiser.
    #[arg(long, value_name = "NUMBER", default_value_t = TuneOptions::default().rate)]
    rate: f64,
    /// Seed of everything random.
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
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
    if args.pairs == 0 || args.epochs == 0 {
        bail!("--pairs and --epochs must be at least 1");
    }
    let mut output = args.force.create(&args.output)?;
    let base = model(args.weights.as_deref())?;
    let read = |path: &PathBuf| Ok(args.repair.read(path)?.mesh);
    let meshes: Vec<TriMesh> = args.meshes.iter().map(read).collect::<Result<_>>()?;
    let options = TuneOptions {
        pairs: args.pairs,
        epochs: args.epochs,
        rate: args.rate,
        seed: args.seed,
        ..TuneOptions::default()
    };
    let par = args.threads.par();
    let bar = Bar::new("parts");
    let update = |fraction| bar.update(fraction);
    let examples = family_examples(&meshes, &base, &options, par, Progress::new(&update))?;
    drop(bar);
    let (training, aside) = (examples.training.len(), examples.validation.len());
    status!(
        "data",
        training = training,
        validation = aside;
        "{training} pairs to learn from, {aside} of meshes kept aside"
    )?;
    let (settings, state) = start(&base, &options);
    let mut trainer = Trainer::new(examples, settings, Some(state), par)?;
    let before = 100.0 * trainer.best_error();
    report!("before", error_percent = before; "error {before:.3} %")?;
    for number in 1..=options.epochs {
        progress::check()?;
        let epoch = trainer.epoch()?;
        let [training, aside] = [epoch.training, epoch.validation].map(|x| 100.0 * x);
        report!(
            "epoch",
            number = number,
            training_error_percent = training,
            validation_error_percent = aside;
            "{number}: error {training:.3} %, kept aside {aside:.3} %"
        )?;
    }
    let after = 100.0 * trainer.best_error();
    report!("after", error_percent = after; "error {after:.3} %")?;
    let bytes = trainer.model()?.to_bytes()?;
    output.write_all(&bytes).map_err(|e| output.error(e))?;
    output.commit()?;
    let path = args.output.display().to_string();
    status!("written", path = path; "{path}")
}
