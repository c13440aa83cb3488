//! `catamaran unions template`.

use std::path::PathBuf;

use anyhow::Result;
use catamaran::io::{Output, Overwrite};
use catamaran::mesh::TriMesh;
use catamaran::mesh::io::{self as meshes, MeshFile};
use catamaran_training::dataset::DatasetOptions;
use catamaran_training::families::{Family, Model};

use crate::report::report;

/// Write the template on which `unions predict --localize` finds unions: a human at rest.
#[derive(clap::Args)]
pub struct Args {
    /// The mesh: .obj, .ply, .off, .stl, .glb or .gltf.
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
    let template = model.template();
    // Along y, as pictures have it; families stand along z.
    let upright = template.vertices().iter().map(|&[x, y, z]| [x, z, -y]).collect();
    let mesh = TriMesh::new(upright, template.faces().to_vec())?;
    meshes::write(output, &MeshFile::from(mesh))?;
    report(format_args!("written   {}", args.output.display()))
}
