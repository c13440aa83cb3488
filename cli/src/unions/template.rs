//! `catamaran unions template`.

use std::path::PathBuf;

use anyhow::Result;
use catamaran_geometry::mesh::TriMesh;
use catamaran_geometry::mesh::io::{self as meshes, MeshFile};
use catamaran_training::dataset::DatasetOptions;
use catamaran_training::families::{Family, Model};

use crate::common::{Force, as_option};
use crate::output;
use crate::report::status;

/// Write the template of `unions predict --localize`: a human at rest.
#[derive(clap::Args)]
pub struct Args {
    #[arg(
        short,
        long,
        value_name = "MESH",
        help = output::mesh_help("Output file of the mesh")
    )]
    output: PathBuf,
    /// Approximate number of vertices. The pretrained weights are for the default.
    #[arg(long, value_name = "NUMBER", default_value_t = DatasetOptions::default().vertices)]
    vertices: usize,
    #[command(flatten)]
    force: Force,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    meshes::check_name(&args.output)?;
    let output = args.force.create(&args.output)?;
    let model = Model::new(Family::Humanoid, args.vertices).map_err(as_option)?;
    let template = model.template();
    // y is up, as in pictures; families have z up.
    let upright = template.vertices().iter().map(|&[x, y, z]| [x, z, -y]).collect();
    let mesh = TriMesh::new(upright, template.faces().to_vec())?;
    output::mesh(output, &MeshFile::from(mesh))?;
    let path = args.output.display().to_string();
    status!("written", path = path; "{path}")
}
