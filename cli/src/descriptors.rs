//! `catamaran descriptors`.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use catamaran::faer::Mat;
use catamaran::io::{self as files};
use catamaran_geometry::mesh::TriMesh;
use catamaran_geometry::spectral::descriptors::{
    ShotOptions, global_point_signature, heat_kernel_signature, heat_times, shot,
    wave_kernel_signature, wave_scales,
};
use clap::ValueEnum;

use crate::common::Force;
use crate::defaults::stated;
use crate::parse;
use crate::picture::{Paint, PictureArgs, first_column};
use crate::pieces::Need;
use crate::progress::Bar;
use crate::report::status;
use crate::shape::LaplacianArgs;

/// The default of -k.
const K: usize = 100;
/// The default of --scales.
const SCALES: usize = 100;

/// Compute shape descriptors of the vertices of a mesh: numbers that distinguish them, in a row for
/// each vertex.
///
/// Heat kernel, wave kernel and global point signatures are computed from eigenfunctions, and thus
/// are the same for any pose. SHOT is computed from the normals nearby, and is the same for rigid
/// motions.
#[derive(clap::Args)]
pub struct Args {
    #[arg(value_name = "MESH", help = crate::input::mesh_help("The mesh"))]
    mesh: PathBuf,
    /// Kind of descriptor.
    #[arg(long, value_name = "KIND")]
    kind: Kind,
    #[arg(
        short,
        value_name = "K",
        value_parser = parse::at_least_one,
        help = stated("Number of eigenfunctions, without the constant one; not for shot", K)
    )]
    k: Option<usize>,
    #[arg(
        long,
        value_name = "N",
        value_parser = parse::at_least_one,
        help = stated(
            "Number of columns of hks (times in equal ratios) and of wks (energies), over the \
             range of the eigenvalues",
            SCALES
        )
    )]
    scales: Option<usize>,
    /// Radius of the ball around a vertex that shot describes, in units of the mesh; required for
    /// shot, and for shot only.
    #[arg(long, value_name = "R")]
    radius: Option<f64>,
    #[command(flatten)]
    laplacian: LaplacianArgs,
    /// Output file of the table, with a row for each vertex (.npy, .csv, .tsv, .txt or .mtx, and
    /// .gz after it); --picture shows its first column.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    force: Force,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// Heat kernel signature (Sun, Ovsjanikov and Guibas 2009), in 1 / area.
    Hks,
    /// Wave kernel signature (Aubry, Schlickewei and Cremers 2011), in 1 / area.
    Wks,
    /// Global point signature (Rustamov 2007), without a unit: a column for each eigenfunction that
    /// is not constant.
    Gps,
    /// Signature of histograms of orientations (Tombari, Salti and Di Stefano 2010): 352 columns.
    Shot,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    check(args)?;
    files::check_name(&args.output)?;
    let output = args.force.create(&args.output)?;
    let picture = args.picture.create(args.force)?;
    let (mesh, table) = match args.radius {
        Some(radius) => normals(args, radius)?,
        None => spectral(args)?,
    };
    let (vertices, columns) = (table.nrows(), table.ncols());
    status!(
        "table",
        vertices = vertices,
        columns = columns;
        "{vertices} vertices, {columns} columns"
    )?;
    if let Some(picture) = picture {
        let values = first_column(&table);
        args.picture.draw(picture, &args.mesh, &[(&mesh, Paint::Values(&values), "")])?;
    }
    let path = output.path().display().to_string();
    files::write(output, table.as_ref())?;
    status!("written", path = path; "{path}")
}

/// Refuses options that do not apply to the kind.
fn check(args: &Args) -> Result<()> {
    let is_shot = args.kind == Kind::Shot;
    if is_shot != args.radius.is_some() {
        bail!("--radius is required for --kind shot, and is for that kind only");
    }
    if is_shot && args.k.is_some() {
        bail!("-k: --kind shot uses no eigenfunctions");
    }
    if args.scales.is_some() && !matches!(args.kind, Kind::Hks | Kind::Wks) {
        bail!("--scales is for --kind hks and --kind wks only");
    }
    Ok(())
}

fn normals(args: &Args, radius: f64) -> Result<(TriMesh, Mat<f64>)> {
    let mesh = args.laplacian.repair.read(&args.mesh)?.mesh;
    let bar = Bar::new("descriptors");
    let update = |fraction| bar.update(fraction);
    let options = ShotOptions::new(radius).par(args.laplacian.par()).progress(&update);
    let table = shot(&mesh, &options).with_context(|| args.mesh.display().to_string())?;
    Ok((mesh, table))
}

fn spectral(args: &Args) -> Result<(TriMesh, Mat<f64>)> {
    // Energies of waves range between two different eigenvalues.
    let positive = if args.kind == Kind::Wks { 2 } else { 1 };
    let need = Need { option: "-k", len: args.k.unwrap_or(K).saturating_add(1), positive };
    let shape = args.laplacian.shape(&args.mesh, &[need])?;
    let (values, vectors) = (shape.eigenbasis.values(), shape.eigenbasis.functions());
    let (scales, par) = (args.scales.unwrap_or(SCALES), args.laplacian.par());
    let table = match args.kind {
        Kind::Wks => wave_scales(values, scales)
            .and_then(|scales| wave_kernel_signature(values, vectors, &scales, par)),
        Kind::Gps => global_point_signature(values, vectors),
        Kind::Hks | Kind::Shot => heat_times(values, scales)
            .and_then(|times| heat_kernel_signature(values, vectors, &times, par)),
    };
    Ok((shape.file.mesh, table.with_context(|| args.mesh.display().to_string())?))
}
