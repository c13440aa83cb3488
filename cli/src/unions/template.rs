//! `catamaran unions template`.

use std::path::PathBuf;

use anyhow::Result;
use catamaran::io::{Output, Overwrite};
use catamaran::mesh::io::{self as meshes, MeshFile};
use catamaran_training::dataset::DatasetOptions;
use catamaran_training::families::{Family, Model};

use crate::report::report;

/// Write the template on which `unions predict --localize` finds unions: a human at rest.
#[derive(clap::Args)]
pub struct Args {
    /// The mesh: .obj, .ply, .off or .stl.
    #[arg(short, long, value_name = "MESH")]
    output: PathBuf,
    /// Vertices, about; as many as the data set has that the weights are of.
    #[arg(long, value_name = "NUMBER", default_value_t = DatasetOptions::default().vertices)]
    vertices: usize,
    /// Replace a file that exists.
    #[arg(long)]
    force: bool,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let overwrite = if args.force { Overwrite::Replace } else { Overwrite::Never };
    let output = Output::create(&args.output, overwrite)?;
    let model = Model::new(Family::Humanoid, args.vertices)?;
    meshes::write(output, &MeshFile::from(model.template().clone()))?;
    report(format_args!("written   {}", args.output.display()))
}
