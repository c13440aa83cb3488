//! `catamaran descriptors`.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use catamaran::base::check_request;
use catamaran::faer::Mat;
use catamaran::io::{self as files};
use catamaran_geometry::mesh::TriMesh;
use catamaran_geometry::spectral::descriptors::{
    RingOptions, ShotOptions, geodesic_rings, global_point_signature, heat_kernel_signature,
    heat_times, shot, wave_kernel_signature, wave_scales,
};
use clap::ValueEnum;

use crate::common::Force;
use crate::defaults::stated;
use crate::parse;
use crate::picture::{Paint, PictureArgs, first_column};
use crate::pieces::Need;
use crate::progress::Bar;
use crate::report::{note, status};
use crate::shape::{LaplacianArgs, functions};
use crate::tables::TableArgs;

/// The default of -k.
const K: usize = 100;
/// The default of --scales.
const SCALES: usize = 100;

/// Compute shape descriptors of the vertices of a mesh.
///
/// Descriptors are numbers that distinguish vertices, in a row for each vertex.
/// Heat kernel, wave kernel and global point signatures are computed from eigenfunctions, and thus
/// are the same for any pose. SHOT is computed from the normals nearby, and is the same for rigid
/// motions. Rings are means of functions over the surface nearby.
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
        help = stated(
            "Number of eigenfunctions, without the constant one; not for shot and rings",
            K
        )
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
    /// Radius of the ball around a vertex that shot describes, or of the rings, along edges; in
    /// units of the mesh. Required for shot and rings, and for these only. Rows of shot are 0 where
    /// the ball has fewer than five other vertices.
    #[arg(long, value_name = "R")]
    radius: Option<f64>,
    /// Number of rings that divide the radius; required for rings, and for rings only.
    #[arg(long, value_name = "N", value_parser = parse::at_least_one)]
    rings: Option<usize>,
    /// The functions of rings: a table (a row for each vertex, a column for each function), or the
    /// values of vertices in a file of VTK, GIFTI, Gmsh or FreeSurfer; required for rings, and for
    /// rings only.
    #[arg(long, value_name = "F")]
    functions: Option<PathBuf>,
    #[command(flatten)]
    table: TableArgs,
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
    /// Means of --functions over --rings around each vertex. The columns, ring after ring from the
    /// middle: the share of the ring in the area, then the mean of each function.
    Rings,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    check(args)?;
    files::check_name(&args.output)?;
    let output = args.force.create(&args.output)?;
    let picture = args.picture.create(args.force)?;
    let (mesh, table) = match (args.radius, args.rings, &args.functions) {
        (Some(radius), Some(rings), Some(path)) => means(args, radius, rings, path)?,
        (Some(radius), ..) => normals(args, radius)?,
        _ => spectral(args)?,
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
    let is_rings = args.kind == Kind::Rings;
    let is_local = is_rings || args.kind == Kind::Shot;
    for (option, is_given) in
        [("--rings", args.rings.is_some()), ("--functions", args.functions.is_some())]
    {
        if is_rings != is_given {
            bail!("{option} is required for --kind rings, and is for that kind only");
        }
    }
    if is_local != args.radius.is_some() {
        bail!("--radius is required for --kind shot and --kind rings, and is for these only");
    }
    if is_local && args.k.is_some() {
        bail!("-k: --kind shot and --kind rings use no eigenfunctions");
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
    let empty = table.row_iter().filter(|row| row.iter().all(|x| *x == 0.0)).count();
    if empty > 0 {
        let rows = table.nrows();
        note(format_args!(
            "--radius {radius}: {empty} of {rows} rows are 0: too few vertices near"
        ));
    }
    Ok((mesh, table))
}

fn means(args: &Args, radius: f64, rings: usize, path: &Path) -> Result<(TriMesh, Mat<f64>)> {
    let mesh = args.laplacian.repair.read(&args.mesh)?.mesh;
    let vertices = mesh.vertices().len();
    let functions = functions(path, vertices, &args.table)?;
    let columns = rings as f64 * (1 + functions.ncols()) as f64;
    let request = format_args!("{rings} rings around {vertices} vertices");
    check_request("--rings", request, 8.0 * columns * vertices as f64)?;
    let bar = Bar::new("descriptors");
    let update = |fraction| bar.update(fraction);
    let options = RingOptions::new(radius, rings).par(args.laplacian.par()).progress(&update);
    let table = geodesic_rings(&mesh, functions.as_ref(), &options)
        .with_context(|| args.mesh.display().to_string())?;
    // The columns with the shares of the area in the rings around the one in the middle.
    let outer = || (1..rings).map(|ring| ring * (1 + functions.ncols()));
    let empty = table.row_iter().filter(|row| outer().all(|column| row[column] == 0.0)).count();
    if rings > 1 && empty > 0 {
        note(format_args!(
            "--radius {radius}: {empty} of {vertices} rows have rings without vertices around the \
             middle: too few vertices near"
        ));
    }
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
        Kind::Hks | Kind::Shot | Kind::Rings => heat_times(values, scales)
            .and_then(|times| heat_kernel_signature(values, vectors, &times, par)),
    };
    Ok((shape.file.mesh, table.with_context(|| args.mesh.display().to_string())?))
}
