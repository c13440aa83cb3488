//! `catamaran distance`.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use catamaran::faer::Mat;
use catamaran::io::{self as files, Output};
use catamaran_geometry::mesh::{
    Components, Dijkstra, Geodesics, Graph, HeatMethod, HeatOptions, SearchLimits, SurfacePoint,
    TriMesh,
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
    /// 3 % on a flat grid of 40 x 40 squares, less on finer meshes), exactly over the faces (exact,
    /// which takes longer on large meshes), or exactly along edges, which gives longer distances
    /// (edges).
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
    /// Report the shortest path from a vertex of --from to this vertex, numbered from 0, or to the
    /// first of several, separated by commas, and on to the others in their order: over the faces
    /// with --method exact, else along edges.
    #[arg(long, value_name = "VERTEX,...", value_delimiter = ',')]
    to: Vec<u32>,
    /// Output file of the path to --to: a line (.obj), or, with --method exact, a table of the
    /// points with their faces and barycentric coordinates (.csv).
    #[arg(long, value_name = "FILE", requires = "to")]
    path_output: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    force: Force,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum How {
    Heat,
    Exact,
    Edges,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    files::check_name(&args.output)?;
    let output = args.force.create(&args.output)?;
    let path_output =
        args.path_output.as_deref().map(|path| create_path(path, args)).transpose()?;
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
        How::Exact => exact(args, &mesh).with_context(named)?,
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

    if !args.to.is_empty() {
        let text = if args.method == How::Exact {
            path_over_faces(args, &mesh).with_context(named)?
        } else {
            path_along_edges(args, &mesh).with_context(named)?
        };
        if let Some(output) = path_output {
            write(output, &text)?;
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

fn exact(args: &Args, mesh: &TriMesh) -> catamaran::Result<Vec<f64>> {
    Geodesics::new(mesh)?.distances(&args.from)
}

/// Reports the shortest path along edges, and returns the text of its file.
fn path_along_edges(args: &Args, mesh: &TriMesh) -> Result<String> {
    let graph = Graph::of_mesh(mesh);
    let mut search = Dijkstra::new(&graph);
    let (mut path, mut length) = (Vec::new(), 0.0);
    let mut starts = sources(args);
    for &to in &args.to {
        let limits = SearchLimits { targets: &[to], ..SearchLimits::default() };
        search.search(&starts, &limits)?;
        let part = search.path(to);
        if part.is_empty() {
            bail!("--to: no edges lead to vertex {to}");
        }
        let known = usize::from(!path.is_empty());
        path.extend(part.into_iter().skip(known));
        length += search.distance(to);
        starts = vec![(to, 0.0)];
    }
    report!(
        "path",
        path = path,
        length = length;
        "{length:.6e} over {} edges",
        path.len() - 1
    )?;
    let points: Vec<_> = path.iter().map(|&v| mesh.vertices()[v as usize]).collect();
    Ok(line(&points, 1, false))
}

/// Reports the shortest path over faces, and returns the text of its file.
fn path_over_faces(args: &Args, mesh: &TriMesh) -> Result<String> {
    let path = Geodesics::new(mesh)?.path_through(&args.from, &args.to)?;
    if path.length.is_infinite() {
        let through: Vec<String> = args.to.iter().map(u32::to_string).collect();
        bail!("--to: no path over faces leads through {}", through.join(", "));
    }
    let (length, parts) = (path.length, path.points.len().saturating_sub(1));
    report!(
        "path",
        parts = parts,
        length = length;
        "{length:.6e} in {parts} straight parts"
    )?;
    let points = path.positions(mesh);
    Ok(match &args.path_output {
        Some(name) if has_extension(name, "csv") => table(&points, &path.points),
        _ => line(&points, 1, false),
    })
}

/// Returns the points of a path as a table.
fn table(points: &[[f64; 3]], places: &[SurfacePoint]) -> String {
    let mut text = String::from("x,y,z,face,a,b,c\n");
    for ([x, y, z], place) in points.iter().zip(places) {
        let (face, [a, b, c]) = (place.face, place.weights);
        let _ = writeln!(text, "{x},{y},{z},{face},{a},{b},{c}");
    }
    text
}

fn sources(args: &Args) -> Vec<(u32, f64)> {
    args.from.iter().map(|&vertex| (vertex, 0.0)).collect()
}

/// Starts the file of the path.
///
/// # Errors
/// The name ends in none of the formats; those of [`Force::create`].
fn create_path(path: &Path, args: &Args) -> Result<Output> {
    let name = path.display();
    match args.method {
        How::Exact if has_extension(path, "csv") => {}
        _ if has_extension(path, "obj") => {}
        How::Exact => bail!("{name}: the name must end in .obj or .csv"),
        _ if has_extension(path, "csv") => bail!("{name}: .csv is for --method exact only"),
        _ => bail!("{name}: the name must end in .obj"),
    }
    args.force.create(path)
}

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found == extension)
}

fn write(mut output: Output, text: &str) -> Result<()> {
    let path = output.path().display().to_string();
    output.write_all(text.as_bytes()).map_err(|e| output.error(e))?;
    output.commit()?;
    status!("written", path = path; "{path}")
}
