//! `catamaran distance`.

use std::collections::HashSet;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use catamaran::faer::Mat;
use catamaran::io::{self as files, Output};
use catamaran_geometry::curve::{Placement, place};
use catamaran_geometry::mesh::vector::distance;
use catamaran_geometry::mesh::{
    Components, Dijkstra, GeodesicPath, Geodesics, Graph, HeatMethod, HeatOptions, SearchLimits,
    Site, SurfacePoint, TraceEnd, TriMesh,
};
use clap::ValueEnum;

use crate::common::{Force, Threads};
use crate::curve::samples::site;
use crate::curve::write::line;
use crate::defaults::variant;
use crate::input::MeshArgs;
use crate::parse;
use crate::picture::{Paint, PictureArgs};
use crate::report::{note, report, seconds, status};
use crate::shape::Kind;

/// Compute distances over a mesh, shortest paths and geodesics.
///
/// The distances are those of every vertex from the nearest point of --from, in units of the mesh.
/// The distance is infinite for a vertex that no path of faces or edges connects to a point of
/// --from. A point is a vertex, numbered from 0; a face and barycentric coordinates in it ('face a
/// b c', with --method exact or --trace); or a point in space ('x y z'), which stands for the
/// nearest vertex.
#[derive(clap::Args)]
pub struct Args {
    #[arg(value_name = "MESH", help = crate::input::mesh_help("The mesh"))]
    mesh: PathBuf,
    /// Points that distances are measured from, separated by commas: vertices, such as 0,7, or
    /// others, whose numbers are separated by blanks, such as '310 0.2 0.3 0.5' or '0.3 1.2 -0.4'.
    #[arg(
        long,
        value_name = "POINT,...",
        value_delimiter = ',',
        value_parser = point,
        required = true
    )]
    from: Vec<Site>,
    /// Method: over the faces (heat, the heat method; on meshes of 1,000 vertices up to 5 % of the
    /// largest distance off from one point, and about 20 % from several; half of that with four
    /// times as many vertices), exactly over the faces (exact, which takes longer on large meshes),
    /// or exactly along edges, which gives longer distances (edges).
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
    /// and .gz after it); needed unless there is a --trace.
    #[arg(short, long, value_name = "FILE", required_unless_present = "trace")]
    output: Option<PathBuf>,
    /// Report the shortest path from a point of --from to this point, or to the first of several,
    /// separated by commas, and on to the others in their order: over the faces with --method
    /// exact, else along edges.
    #[arg(long, value_name = "POINT,...", value_delimiter = ',', value_parser = point)]
    to: Vec<Site>,
    /// Report where the geodesic ends that leaves the point of --from in this direction, which is
    /// projected onto the face of the point, or, at a vertex, stands for the nearest direction over
    /// a face. It is straight over faces and edges, passes vertices with equal angles on both
    /// sides, and stops at the boundary.
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_parser = parse::numbers::<3>,
        allow_hyphen_values = true,
        requires = "length",
        conflicts_with = "to"
    )]
    trace: Option<[f64; 3]>,
    /// Length of the --trace, in units of the mesh.
    #[arg(
        long,
        value_name = "L",
        value_parser = parse::at_least_zero,
        requires = "trace",
        conflicts_with = "to"
    )]
    length: Option<f64>,
    /// Output file of the path to --to or of the --trace: a line (.obj), or, with --method exact or
    /// --trace, a table of the points with their faces and barycentric coordinates (.csv).
    #[arg(long, value_name = "FILE")]
    path_output: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    force: Force,
}

/// Share of the diagonal of the mesh above which a point in space is far from it.
const FAR: f64 = 0.1;

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum How {
    Heat,
    Exact,
    Edges,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    if args.path_output.is_some() && args.to.is_empty() && args.trace.is_none() {
        bail!("--path-output needs a path: --to or --trace");
    }
    if args.trace.is_some() && args.from.len() > 1 {
        bail!("--trace starts from one point: --from has {}", args.from.len());
    }
    let output = args.output.as_deref().map(|path| create(path, args)).transpose()?;
    let path_output =
        args.path_output.as_deref().map(|path| create_path(path, args)).transpose()?;
    let picture = args.picture.create(args.force)?;
    if args.method == How::Edges && output.is_none() && picture.is_none() {
        bail!("--method edges has no effect on --trace, which goes over faces: it is for -o");
    }
    let mesh = args.repair.read(&args.mesh)?.mesh;
    let components = Components::new(&mesh);
    let mut seen = HashSet::new();
    for site in &args.from {
        let Site::Vertex(v) = site else { continue };
        if components.of_vertices().get(*v as usize) == Some(&Components::NONE) {
            bail!("{}: vertex {v} is in no face", args.mesh.display());
        }
        if !seen.insert(v) {
            bail!("--from: vertex {v} twice; the numbers of one point are separated by blanks");
        }
    }

    note_far(args, &mesh)?;
    let named = || args.mesh.display().to_string();
    let distances = if output.is_some() || picture.is_some() {
        Some(distances(args, &mesh).with_context(named)?)
    } else {
        None
    };
    let path = match (args.trace, args.method) {
        (Some(direction), _) => Some(trace(args, &mesh, direction).with_context(named)?),
        (None, _) if args.to.is_empty() => None,
        (None, How::Exact) => Some(path_over_faces(args, &mesh).with_context(named)?),
        (None, _) => Some(path_along_edges(args, &mesh).with_context(named)?),
    };
    if let (Some(output), Some(text)) = (path_output, path) {
        write(output, &text)?;
    }
    let Some(distances) = distances else { return Ok(()) };
    if let Some(picture) = picture {
        // NaN is drawn in grey.
        let shown = |&distance: &f64| if distance.is_finite() { distance } else { f64::NAN };
        let values: Vec<f64> = distances.iter().map(shown).collect();
        args.picture.draw(picture, &args.mesh, &[(&mesh, Paint::Values(&values), "distance")])?;
    }
    let Some(output) = output else { return Ok(()) };
    let path = output.path().display().to_string();
    files::write(output, Mat::from_fn(distances.len(), 1, |v, _| distances[v]).as_ref())?;
    status!("written", path = path; "{path}")
}

/// Says which points in space are far from the vertices that they stand for, as they are in other
/// units than the mesh.
fn note_far(args: &Args, mesh: &TriMesh) -> Result<()> {
    let [low, high] = mesh.bounding_box().unwrap_or_default();
    for (option, sites) in [("--from", &args.from), ("--to", &args.to)] {
        for site in sites {
            let &Site::Near(point) = site else { continue };
            let [x, y, z] = point;
            let vertex = place(mesh, &[*site], Placement::Snap).context(option)?.vertices[0];
            let gap = distance(point, mesh.vertices()[vertex as usize]);
            if gap > FAR * distance(low, high) {
                note(format_args!(
                    "{option}: {x} {y} {z} is {gap:.3e} from the mesh, and stands for vertex \
                     {vertex}: is it in the units of the mesh?"
                ));
            }
        }
    }
    Ok(())
}

/// Parses a point as files of samples have it.
fn point(text: &str) -> Result<Site, String> {
    let words: Vec<&str> = text.split_whitespace().collect();
    site(&words).ok_or_else(|| {
        "expected a vertex, a face and three barycentric coordinates ('face a b c'), or a point \
         ('x y z')"
            .into()
    })
}

/// Returns the distances of all vertices, after their report.
fn distances(args: &Args, mesh: &TriMesh) -> Result<Vec<f64>> {
    let start = Instant::now();
    let distances = match args.method {
        How::Heat => over_faces(args, mesh)?,
        How::Exact => Geodesics::new(mesh)?.distances(&args.from)?,
        How::Edges => along_edges(args, mesh)?,
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
    Ok(distances)
}

fn over_faces(args: &Args, mesh: &TriMesh) -> Result<Vec<f64>> {
    let (kind, par) = (args.laplacian.into(), args.threads.par());
    let options = HeatOptions::default().time(args.time).kind(kind).par(par);
    Ok(HeatMethod::new(mesh, &options)?.distances(&vertices("--from", &args.from, mesh)?)?)
}

fn along_edges(args: &Args, mesh: &TriMesh) -> Result<Vec<f64>> {
    let graph = Graph::of_mesh(mesh);
    let mut search = Dijkstra::new(&graph);
    search.search(&sources(args, mesh)?, &SearchLimits::default())?;
    Ok(search.distances())
}

/// Returns the vertices of the points of an option.
///
/// # Errors
/// A point is inside a face, where only exact distances and paths start and end.
fn vertices(option: &str, points: &[Site], mesh: &TriMesh) -> Result<Vec<u32>> {
    let vertex = |site: &Site| match *site {
        Site::Vertex(v) => Ok(v),
        Site::Face(_) => bail!("{option}: points of faces are for --method exact"),
        Site::Near(_) => {
            let placed = place(mesh, &[*site], Placement::Snap).context(option.to_owned())?;
            Ok(placed.vertices[0])
        }
    };
    points.iter().map(vertex).collect()
}

/// Reports the shortest path along edges, and returns the text of its file.
fn path_along_edges(args: &Args, mesh: &TriMesh) -> Result<String> {
    let graph = Graph::of_mesh(mesh);
    let mut search = Dijkstra::new(&graph);
    let (mut path, mut length) = (Vec::new(), 0.0);
    let mut starts = sources(args, mesh)?;
    for to in vertices("--to", &args.to, mesh)? {
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
    let solver = Geodesics::new(mesh)?;
    let mut path = solver.path(&args.from, args.to[0])?;
    if args.to.len() > 1 && path.length.is_finite() {
        let rest = solver.path_through(&args.to)?;
        path.points.extend(rest.points.into_iter().skip(1));
        path.length += rest.length;
    }
    if path.length.is_infinite() {
        bail!("--to: no path over faces leads through all of these points");
    }
    let (length, parts) = (path.length, path.points.len().saturating_sub(1));
    report!(
        "path",
        parts = parts,
        length = length;
        "{length:.6e} in {parts} straight parts"
    )?;
    Ok(text(args, mesh, &path))
}

/// Reports the geodesic in a direction, and returns the text of its file.
fn trace(args: &Args, mesh: &TriMesh, direction: [f64; 3]) -> Result<String> {
    let length = args.length.context("--trace needs --length")?;
    let trace = Geodesics::new(mesh)?.trace(args.from[0], direction, length)?;
    let (end, says) = match trace.end {
        TraceEnd::Complete => ("complete", ""),
        TraceEnd::Boundary => ("boundary", ", stopped at the boundary"),
        _ => ("non-manifold", ", stopped where more than one way leads on"),
    };
    let Some(last) = trace.path.points.last() else { bail!("the geodesic has no points") };
    let (face, weights, [x, y, z]) = (last.face, last.weights, last.position(mesh));
    let (length, direction) = (trace.path.length, trace.direction);
    report!(
        "trace",
        end = end,
        length = length,
        face = face,
        weights = weights,
        point = [x, y, z],
        direction = direction;
        "{length:.6e} to {x} {y} {z}, on face {face}{says}"
    )?;
    Ok(text(args, mesh, &trace.path))
}

/// Returns the text of the file of a path over faces.
fn text(args: &Args, mesh: &TriMesh, path: &GeodesicPath) -> String {
    let points = path.positions(mesh);
    match &args.path_output {
        Some(name) if has_extension(name, "csv") => table(&points, &path.points),
        _ => line(&points, 1, false),
    }
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

fn sources(args: &Args, mesh: &TriMesh) -> Result<Vec<(u32, f64)>> {
    let all = vertices("--from", &args.from, mesh)?;
    Ok(all.into_iter().map(|vertex| (vertex, 0.0)).collect())
}

/// Starts the file of the distances.
fn create(path: &Path, args: &Args) -> Result<Output> {
    files::check_name(path)?;
    args.force.create(path)
}

/// Starts the file of the path.
///
/// # Errors
/// The name ends in none of the formats; those of [`Force::create`].
fn create_path(path: &Path, args: &Args) -> Result<Output> {
    let name = path.display();
    let is_over_faces = args.method == How::Exact || args.trace.is_some();
    match is_over_faces {
        true if has_extension(path, "csv") => {}
        _ if has_extension(path, "obj") => {}
        true => bail!("{name}: the name must end in .obj or .csv"),
        false if has_extension(path, "csv") => bail!("{name}: .csv is for --method exact only"),
        false => bail!("{name}: the name must end in .obj"),
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
