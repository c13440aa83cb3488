//! `catamaran decimate`.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use catamaran::Par;
use catamaran::decimate::{
    DecimateOptions, Decimation, Difference, Method, Quality, decimate, edge_length_for,
    vertices_for_edge_length, vertices_for_faces,
};
use catamaran::io::{Output, Overwrite};
use catamaran::mesh::io::{self as files, MeshFile};
use catamaran::mesh::{RepairOptions, TriMesh, repair};
use catamaran::sparse::CsMat;
use clap::{ArgGroup, ValueEnum};

use crate::input::MeshArgs;
use crate::output;
use crate::picture::{PLAIN, PictureArgs};
use crate::progress::Bar;
use crate::report::{note, report, seconds};

/// Decimate a mesh to a number of vertices, uniformly.
///
/// The result has exactly that many vertices, is a manifold, and has the components, boundary loops
/// and genus of the input; what can't be is refused, with the reason. Faces do not intersect unless
/// those of the input do or there are too few to do better, which is said. Edges longer than those
/// of the result are split first. Colours, texture coordinates, materials and groups are carried
/// over; normals are not.
#[derive(clap::Args)]
#[command(group = ArgGroup::new("size").required(true))]
pub struct Args {
    /// The mesh: .obj, .ply, .off, .stl, .glb or .gltf, and .gz or .xz after it.
    #[arg(value_name = "MESH")]
    input: PathBuf,
    /// Vertices of the result.
    #[arg(short, value_name = "N", group = "size")]
    n: Option<usize>,
    /// Vertices of the result as a part of those of the input, above 0.
    #[arg(long, value_name = "R", group = "size")]
    ratio: Option<f64>,
    /// Faces of the result: to one face where the mesh is closed, about where it has a boundary.
    #[arg(long, value_name = "F", group = "size")]
    faces: Option<usize>,
    /// The length that edges of the result have about, in units of the input.
    #[arg(long, value_name = "LENGTH", group = "size")]
    edge_length: Option<f64>,
    /// Where the result goes: .obj, .ply, .off, .stl, .glb or .gltf, and .gz after it.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Passes that move samples to the centroids of their cells [default: 0].
    #[arg(long, value_name = "N")]
    lloyd: Option<usize>,
    /// Passes that flip edges and move vertices of the result [default: 12].
    #[arg(long, value_name = "N")]
    relax: Option<usize>,
    /// Cut handles that are too narrow for the triangles of the result, and close their ends.
    #[arg(long)]
    cut_handles: bool,
    /// How faces are found and vertices placed.
    #[arg(long, value_name = "METHOD", default_value = "uniform")]
    method: Kind,
    /// The first sample, a vertex from 0; the lowest by default.
    #[arg(long, value_name = "VERTEX")]
    first: Option<u32>,
    /// Write the matrix that takes functions on the result to the input, .mtx: a row for each
    /// vertex of the input, a column for each of the result.
    #[arg(long, value_name = "FILE")]
    weights: Option<PathBuf>,
    /// Report on uniformity, and on the distance from the input.
    #[arg(long)]
    report: bool,
    #[command(flatten)]
    repair: MeshArgs,
    #[command(flatten)]
    picture: PictureArgs,
    /// Threads; all cores by default. The result is the same.
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
    /// Replace files that exist.
    #[arg(long)]
    force: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Kind {
    /// Manifold, relaxed, exactly N vertices.
    Uniform,
    /// The thesis literally: farthest points, every three-cycle of cells a face.
    Thesis,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let overwrite = if args.force { Overwrite::Replace } else { Overwrite::Never };
    files::check_name(&args.output)?;
    let output = Output::create(&args.output, overwrite)?;
    let picture = args.picture.create(overwrite)?;
    let weights = match &args.weights {
        Some(path) if path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("mtx")) => {
            bail!("{}: weights must be called .mtx", path.display())
        }
        Some(path) => Some(Output::create(path, overwrite)?),
        None => None,
    };
    let input = read(&args.input, &args.repair)?;
    let n = wanted(args, &input.mesh)?;
    let par = args.threads.map_or_else(Par::all, |n| Par::Threads(n.get()));

    let bar = Bar::new("decimate");
    let update = |fraction| bar.update(fraction);
    let defaults = DecimateOptions::default();
    let options = DecimateOptions::new()
        .method(match args.method {
            Kind::Uniform => Method::Uniform,
            Kind::Thesis => Method::Thesis,
        })
        .lloyd(args.lloyd.unwrap_or(defaults.lloyd))
        .relaxation(args.relax.unwrap_or(defaults.relaxation))
        .cut_narrow_handles(args.cut_handles)
        .first(args.first)
        .par(par)
        .progress(&update);
    let start = Instant::now();
    let found = decimate(&input.mesh, n, &options)
        .with_context(|| format!("{}: can't be decimated to {n}", args.input.display()))?;
    let elapsed = start.elapsed();
    drop(bar);
    tell(args, &input, &found, elapsed, par)?;

    if let Some(output) = weights {
        let path = output.path().display().to_string();
        let weights = found.weights(&input.mesh, par)?;
        write_sparse(output, &weights)?;
        let (rows, columns) = weights.shape();
        report(format_args!("weights     {path}: {rows} x {columns}, {} entries", weights.nnz()))?;
    }
    if let Some(picture) = picture {
        let panels = [(&input.mesh, PLAIN, "before"), (&found.mesh, PLAIN, "after")];
        args.picture.draw_faces(picture, &args.input, &panels)?;
    }
    let path = output.path().display().to_string();
    let left_out = Decimation::left_out(&input);
    output::mesh(output, &found.carry(&input)?)?;
    if !left_out.is_empty() {
        let what = left_out.join(", ");
        note(format_args!("{path}: {what} of the input are not carried over"));
    }
    report(format_args!("written     {path}"))
}

pub fn read(path: &Path, repair: &MeshArgs) -> Result<MeshFile> {
    let start = Instant::now();
    let file = repair.read(path)?;
    let (vertices, faces) = (file.mesh.vertices().len(), file.mesh.faces().len());
    let time = seconds(start.elapsed());
    let name = path.display();
    report(format_args!("mesh        {name}: {vertices} vertices, {faces} faces, read in {time}"))?;
    Ok(file)
}

fn wanted(args: &Args, input: &TriMesh) -> Result<usize> {
    if let Some(ratio) = args.ratio {
        if !(ratio > 0.0 && ratio.is_finite()) {
            bail!("--ratio {ratio}: a positive number is needed");
        }
        return Ok((ratio * input.vertices().len() as f64).round().max(1.0) as usize);
    }
    if let Some(faces) = args.faces {
        return vertices_for_faces(input, faces).context("--faces");
    }
    if let Some(length) = args.edge_length {
        return vertices_for_edge_length(input.area(), length).context("--edge-length");
    }
    args.n.context("-n is needed")
}

fn tell(
    args: &Args,
    input: &MeshFile,
    found: &Decimation,
    elapsed: std::time::Duration,
    par: Par,
) -> Result<()> {
    let (vertices, faces) = (found.mesh.vertices().len(), found.mesh.faces().len());
    let time = seconds(elapsed);
    report(format_args!("decimated   {vertices} vertices, {faces} faces, in {time}"))?;
    report(format_args!("repairs     {}", found.repairs))?;
    report(format_args!("topology    {}", found.before))?;
    match found.after {
        Some(after) if after == found.before => {}
        Some(after) => report(format_args!("changed to  {after}"))?,
        None => report(format_args!("changed to  no manifold"))?,
    }
    let intersecting = found.mesh.intersecting_faces(par).len();
    let before = match args.report || intersecting > 0 {
        true => input.mesh.intersecting_faces(par).len(),
        false => 0,
    };
    if intersecting > before {
        let more = intersecting - before;
        note(format_args!("{more} faces more intersect others than did before: try another -n"));
    }
    if !args.report {
        return Ok(());
    }
    report(format_args!("intersect   {intersecting} faces, {before} before"))?;
    report(format_args!("{}", Quality::of(&found.mesh)))?;
    if found.after.is_some_and(|after| after.components > 1) {
        // Specks have the fewest faces that they can, which says nothing of the rest.
        let largest = repair(found.mesh.clone().into(), &RepairOptions::new().keep_largest(1))?;
        let Quality { area_variation, mean_quality, .. } = Quality::of(&largest.file.mesh);
        report(format_args!(
            "largest     component alone: variation of areas {area_variation:.3}, mean quality \
             {mean_quality:.3}"
        ))?;
    }
    let difference = Difference::between(&input.mesh, &found.mesh, par)?;
    let Difference { hausdorff, chamfer, printed_hausdorff, printed_chamfer } = difference;
    report(format_args!(
        "Hausdorff   {hausdorff:.4e}, eq. 5.8 as printed {printed_hausdorff:.4e}"
    ))?;
    report(format_args!("Chamfer     {chamfer:.4e}, eq. 5.8 as printed {printed_chamfer:.4e}"))?;
    let longest = edge_length_for(found.mesh.area(), vertices)?;
    report(format_args!("edges       {longest:.4e} long, were all triangles equilateral"))
}

/// Matrix Market, coordinates.
fn write_sparse(mut output: Output, matrix: &CsMat<f64>) -> Result<()> {
    let written = sprs::io::write_matrix_market_to_bufwrite(&mut output, matrix);
    written.map_err(|e| output.error(e))?;
    Ok(output.commit()?)
}
