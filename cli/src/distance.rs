//! `catamaran distance`.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use catamaran::faer::Mat;
use catamaran::io::{self as files, Output};
use catamaran_geometry::mesh::{
    Components, Dijkstra, Graph, HeatMethod, HeatOptions, SearchLimits, TriMesh,
};
use clap::ValueEnum;

use crate::common::{Force, Threads};
use crate::curve::write::line;
use crate::defaults::variant;
use crate::input::MeshArgs;
use crate::picture::{Paint, PictureArgs};
use crate::report::{report, seconds, status};
use crate::shape::Kind;

/// Compute the distance of every vertex of a mesh from the nearest of some vertices.
///
/// Distances are in units of the mesh. The distance is infinite for a vertex that no path of faces
/// or edges connects to a vertex of --from.
#[derive(clap::Args)]
pub struct Args {
    #[arg(value_name = "MESH", help = crate::input::mesh_help("The mesh"))]
    mesh: PathBuf,
    /// Vertices that distances are measured from, numbered from 0 and separated by commas.
    #[arg(long, value_name = "VERTEX,...", value_delimiter = ',', required = true)]
    from: Vec<u32>,
    /// Method: over the faces (heat, the heat method; a few per cent of the largest distance off:
    /// 3 % on a flat grid of 40 x 40 squares, less on finer meshes), or exactly along edges, which
    /// gives longer distances (edges).
    #[arg(long, value_name = "METHOD", default_value = "heat")]
    method: How,
    /// Time that heat flows in the heat method, in units of the squared mean edge length of the
    /// triangulation; a longer time gives smoother distances and reaches farther.
    #[arg(long, value_name = "T", default_value_t = HeatOptions::default().time)]
    time: f64,
    /// Triangulation on which heat flows: the intrinsic Delaunay triangulation of the tufted cover,
    /// for any mesh (tufted), that of a surface whose edges have two faces at most (intrinsic), or
    /// the triangles of the mesh (cotan), where long ones make distances wrong.
    #[arg(
        value_enum,
        long,
        value_name = "KIND",
        default_value_t = variant(HeatOptions::default().kind)
    )]
    laplacian: Kind,
    #[command(flatten)]
    repair: MeshArgs,
    #[command(flatten)]
    threads: Threads,
    /// Output file of the distances, with a row for each vertex (.npy, .csv, .tsv, .txt or .mtx,
    /// and .gz after it).
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Report the shortest path along edges from a vertex of --from to this vertex, numbered from
    /// 0.
    #[arg(long, value_name = "VERTEX")]
    to: Option<u32>,
    /// Output file of the path to --to (.obj).
    #[arg(long, value_name = "FILE", requires = "to")]
    path_output: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    force: Force,
}

#[derive(Clone, Copy, ValueEnum)]
enum How {
    Heat,
    Edges,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    files::check_name(&args.output)?;
    let output = args.force.create(&args.output)?;
    let path_output = args.path_output.as_deref().map(|path| obj(path, args.force)).transpose()?;
    let picture = args.picture.create(args.force)?;
    let mesh = args.repair.read(&args.mesh)?.mesh;
    let components = Components::new(&mesh);
    let is_alone = |v: &&u32| components.of_vertices().get(**v as usize) == Some(&Components::NONE);
    if let Some(vertex) = args.from.iter().find(is_alone) {
        bail!("{}: vertex {vertex} is in no face", args.mesh.display());
    }

    let start = Instant::now();
    let named = || args.mesh.display().to_string();
    let distances = match args.method {
        How::Heat => over_faces(args, &mesh).with_context(named)?,
        How::Edges => along_edges(args, &mesh).with_context(named)?,
    };
    let finite = || distances.iter().copied().filter(|distance| distance.is_finite());
    let (reached, vertices) = (finite().count(), distances.len());
    let (largest, time) = (finite().fold(0.0, f64::max), start.elapsed());
    report!(
        "distances",
        reached = reached,
        vertices = vertices,
        largest = largest,
        seconds = time.as_secs_f64();
        "{reached} of {vertices} vertices reached, up to {largest:.6e}, in {}",
        seconds(time)
    )?;

    if let Some(to) = args.to {
        let (path, length) = path(args, &mesh, to).with_context(named)?;
        report!(
            "path",
            path = path,
            length = length;
            "{length:.6e} over {} edges",
            path.len() - 1
        )?;
        if let Some(output) = path_output {
            let points: Vec<_> = path.iter().map(|&v| mesh.vertices()[v as usize]).collect();
            write(output, &line(&points, 1, false))?;
        }
    }
    if let Some(picture) = picture {
        // NaN is drawn in grey.
        let shown = |&distance: &f64| if distance.is_finite() { distance } else { f64::NAN };
        let values: Vec<f64> = distances.iter().map(shown).collect();
        args.picture.draw(picture, &args.mesh, &[(&mesh, Paint::Values(&values), "distance")])?;
    }
    let path = output.path().display().to_string();
    files::write(output, Mat::from_fn(distances.len(), 1, |v, _| distances[v]).as_ref())?;
    status!("written", path = path; "{path}")
}

fn over_faces(args: &Args, mesh: &TriMesh) -> catamaran::Result<Vec<f64>> {
    let (kind, par) = (args.laplacian.into(), args.threads.par());
    let options = HeatOptions::default().time(args.time).kind(kind).par(par);
    HeatMethod::new(mesh, &options)?.distances(&args.from)
}

fn along_edges(args: &Args, mesh: &TriMesh) -> catamaran::Result<Vec<f64>> {
    let graph = Graph::of_mesh(mesh);
    let mut search = Dijkstra::new(&graph);
    search.search(&sources(args), &SearchLimits::default())?;
    Ok(search.distances())
}

/// Returns the vertices of the shortest path along edges, and its length.
fn path(args: &Args, mesh: &TriMesh, to: u32) -> Result<(Vec<u32>, f64)> {
    let graph = Graph::of_mesh(mesh);
    let mut search = Dijkstra::new(&graph);
    let limits = SearchLimits { targets: &[to], ..SearchLimits::default() };
    search.search(&sources(args), &limits)?;
    let path = search.path(to);
    if path.is_empty() {
        bail!("--to: no edges lead to vertex {to}");
    }
    Ok((path, search.distance(to)))
}

fn sources(args: &Args) -> Vec<(u32, f64)> {
    args.from.iter().map(|&vertex| (vertex, 0.0)).collect()
}

/// Starts a file of a path.
///
/// # Errors
/// The name does not end in .obj; those of [`Force::create`].
fn obj(path: &Path, force: Force) -> Result<Output> {
    if path.extension().is_none_or(|extension| extension != "obj") {
        bail!("{}: the name must end in .obj", path.display());
    }
    force.create(path)
}

fn write(mut output: Output, text: &str) -> Result<()> {
    let path = output.path().display().to_string();
    output.write_all(text.as_bytes()).map_err(|e| output.error(e))?;
    output.commit()?;
    status!("written", path = path; "{path}")
}
