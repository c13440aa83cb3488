//! `catamaran unions tune`.

use std::io::Write as _;
use std::num::NonZeroUsize;
use std::path::PathBuf;

use anyhow::{Result, bail};
use catamaran::Par;
use catamaran::base::Progress;
use catamaran::io::{Output, Overwrite};
use catamaran::mesh::TriMesh;
use catamaran_training::train::Trainer;
use catamaran_training::tune::{TuneOptions, family_examples, start};

use super::parts::model;
use crate::input::MeshArgs;
use crate::progress::{self, Bar};
use crate::report::report;

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
    /// Threads; all cores by default. The result does not depend on the number.
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
    /// Replace a file that exists.
    #[arg(long)]
    force: bool,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    if args.pairs == 0 || args.epochs == 0 {
        bail!("--pairs and --epochs must be at least 1");
    }
    let overwrite = if args.force { Overwrite::Replace } else { Overwrite::Never };
    let mut output = Output::create(&args.output, overwrite)?;
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
    let par = args.threads.map_or_else(Par::all, |n| Par::Threads(n.get()));
    let bar = Bar::new("parts");
    let update = |fraction| bar.update(fraction);
    let examples = family_examples(&meshes, &base, &options, par, Progress::new(&update))?;
    drop(bar);
    report(format_args!(
        "data      {} pairs to learn from, {} of meshes kept aside",
        examples.training.len(),
        examples.validation.len()
    ))?;
    let (settings, state) = start(&base, &options);
    let mut trainer = Trainer::new(examples, settings, Some(state), par)?;
    report(format_args!("before    error {:.3} %", 100.0 * trainer.best_error()))?;
    for number in 1..=options.epochs {
        progress::check()?;
        let epoch = trainer.epoch()?;
        let [training, aside] = [epoch.training, epoch.validation].map(|x| 100.0 * x);
        report(format_args!("epoch     {number}: error {training:.3} %, kept aside {aside:.3} %"))?;
    }
    report(format_args!("after     error {:.3} %", 100.0 * trainer.best_error()))?;
    let bytes = trainer.model()?.to_bytes()?;
    output.write_all(&bytes).map_err(|e| output.error(e))?;
    output.commit()?;
    report(format_args!("written   {}", args.output.display()))
}
