//! `catamaran unions train-regions`.

use std::io::Write as _;
use std::path::PathBuf;

use anyhow::Result;
use catamaran::io::{Output, Overwrite};
use catamaran::mesh::io::{self as meshes, MeshFile};
use catamaran_training::dataset;
use catamaran_training::regions::{RegionOptions, train_regions};

use crate::progress::Bar;
use crate::report::report;

/// Train the localizer of `unions predict --localize` on a data set of `unions dataset`.
#[derive(clap::Args)]
pub struct Args {
    /// The data set.
    #[arg(value_name = "DATA")]
    data: PathBuf,
    /// The weights: .safetensors.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Number of the family whose template is used, from 0.
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    family: usize,
    /// Write the template, which `unions predict --localize` needs: .obj, .ply, .off or .stl.
    #[arg(long, value_name = "MESH")]
    template: Option<PathBuf>,
    /// Passes over the data.
    #[arg(long, value_name = "NUMBER", default_value_t = 60)]
    epochs: usize,
    /// Seed of everything random.
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    seed: u64,
    /// Replace a file that exists.
    #[arg(long)]
    force: bool,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let overwrite = if args.force { Overwrite::Replace } else { Overwrite::Never };
    let mut output = Output::create(&args.output, overwrite)?;
    let create = |path: &PathBuf| Output::create(path, overwrite);
    let template = args.template.as_ref().map(create).transpose()?;
    let dataset = dataset::read(&args.data)?;
    let bar = Bar::new("training");
    let update = |fraction| bar.update(fraction);
    let Args { family, epochs, seed, .. } = *args;
    let progress = Some(&update as _);
    let options = RegionOptions { family, epochs, seed, progress, ..RegionOptions::default() };
    let localizer = train_regions(&dataset, &options)?;
    drop(bar);
    let bytes = localizer.to_bytes()?;
    output.write_all(&bytes).map_err(|e| output.error(&e))?;
    output.commit()?;
    if let (Some(output), Some(template)) = (template, dataset.templates.get(family)) {
        meshes::write(output, &MeshFile::from(template.mesh()?))?;
    }
    report(format_args!("written   {}", args.output.display()))
}
