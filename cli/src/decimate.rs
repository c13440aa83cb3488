//! `catamaran decimate`.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow, bail};
use catamaran::Par;
use catamaran::io::Output;
use catamaran::sparse::CsMat;
use catamaran_geometry::decimate::{
    DecimateOptions, Decimation, Difference, Method, Quality, Topology, decimate, decimate_within,
    edge_length_for, vertices_for_edge_length, vertices_for_faces,
};
use catamaran_geometry::mesh::io::{self as files, MeshFile};
use catamaran_geometry::mesh::{RepairOptions, TriMesh, repair};
use clap::{ArgGroup, ValueEnum};

use crate::common::{Force, Threads, as_option};
use crate::defaults::variant;
use crate::input::{MeshArgs, TextFile};
use crate::mesh::genus;
use crate::output;
use crate::picture::{PLAIN, PictureArgs};
use crate::progress::Bar;
use crate::report::{note, report, row, seconds, status};

/// Decimate a mesh to a number of vertices, uniformly.
///
/// The result has exactly that many vertices, is a manifold, and has the components, boundary loops
/// and genus of the input. Impossible requests return an error that says why. Faces of the result
/// intersect only if those of the input do or if the vertices are too few to avoid it; a note says
/// so. Edges that are longer than those of the result are split first. Colours, texture
/// coordinates, materials and groups are carried over; normals are not.
#[derive(clap::Args)]
#[command(group = ArgGroup::new("size").required(true))]
pub struct Args {
    #[arg(value_name = "MESH", help = crate::input::mesh_help("The mesh"))]
    input: PathBuf,
    /// Number of vertices of the result.
    #[arg(short, value_name = "N", group = "size")]
    n: Option<usize>,
    /// Number of vertices of the result as a fraction of those of the input, above 0.
    #[arg(long, value_name = "R", group = "size")]
    ratio: Option<f64>,
    /// Number of faces of the result: exact to one face for a closed mesh, approximate for a mesh
    /// with a boundary.
    #[arg(long, value_name = "F", group = "size")]
    faces: Option<usize>,
    /// Approximate length of the edges of the result, in units of the mesh.
    #[arg(long, value_name = "LENGTH", group = "size")]
    edge_length: Option<f64>,
    /// Numbers of vertices of several results, each decimated from the one before, such as
    /// 5000,1000,200, for levels of detail. In the name of -o, {} stands for the number.
    #[arg(
        long,
        value_name = "N,...",
        value_delimiter = ',',
        group = "size",
        conflicts_with = "prolongation"
    )]
    levels: Vec<usize>,
    /// Largest distance of a point of either surface from the other one, in units of the mesh or as
    /// a percentage of the diagonal of its box, such as 0.5%: the result has as few vertices as the
    /// search finds, up to 2 % more than a number that is too small. The distance is measured on
    /// whole faces, and at most 1 % too large.
    #[arg(long, value_name = "E", group = "size", value_parser = tolerance)]
    error: Option<Tolerance>,
    #[arg(short, long, value_name = "FILE", help = output::mesh_help("Output file"))]
    output: PathBuf,
    /// Number of passes that move samples to the centroids of their cells.
    #[arg(long, value_name = "N", default_value_t = DecimateOptions::default().lloyd)]
    lloyd: usize,
    /// Number of passes that flip edges and move vertices of the result.
    #[arg(long, value_name = "N", default_value_t = DecimateOptions::default().relaxation)]
    relax: usize,
    /// Make the areas of triangles as equal as possible, at the cost of their shapes: areas vary
    /// half as much.
    #[arg(long)]
    uniform: bool,
    /// Cut handles that are too narrow for the triangles of the result, and close their ends.
    #[arg(long)]
    cut_handles: bool,
    /// Method that finds faces and places vertices.
    #[arg(
        value_enum,
        long,
        value_name = "METHOD",
        default_value_t = variant(DecimateOptions::default().method)
    )]
    method: Kind,
    /// Vertex of the first sample, numbered from 0 [default: the lowest vertex that a face has].
    #[arg(long, value_name = "VERTEX")]
    first: Option<u32>,
    /// Vertices that stay at their positions, the first of the result in this order: a file of
    /// their numbers from 0, one a line. Edges between them stay, too, unless they are longer than
    /// those of the result.
    #[arg(long, value_name = "FILE")]
    lock: Option<TextFile>,
    /// The same for the vertices at which this scalar of the mesh is not 0, in ascending order.
    #[arg(long, value_name = "NAME", conflicts_with = "lock")]
    lock_by: Option<String>,
    /// Vertices per area, relative to elsewhere: a file with a positive number for each vertex of
    /// the mesh, one a line. Only ratios count.
    #[arg(long, value_name = "FILE")]
    density: Option<TextFile>,
    /// The same by a scalar of the mesh.
    #[arg(long, value_name = "NAME", conflicts_with = "density")]
    density_by: Option<String>,
    /// More vertices where the surface bends: up to R times as many per area as where it is flat,
    /// such as 16. 1: as many everywhere. With --density, both factors count.
    #[arg(long, value_name = "R", default_value_t = DecimateOptions::default().curvature)]
    curvature: f64,
    /// Write the matrix that takes functions on the result to functions on the input, .mtx: a row
    /// for each vertex of the input, a column for each vertex of the result.
    #[arg(long, value_name = "FILE")]
    prolongation: Option<PathBuf>,
    /// Print measures of uniformity and of the distance from the input: a bound for all points of
    /// both surfaces, and the Hausdorff and Chamfer distances of their vertices.
    #[arg(long)]
    report: bool,
    #[command(flatten)]
    repair: MeshArgs,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    force: Force,
}

/// Stands for the number of vertices in the names of results.
const NUMBER: &str = "{}";

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Kind {
    /// A manifold with exactly N vertices, relaxed.
    Uniform,
    /// The algorithm of the thesis as printed: farthest points, and a face for every three-cycle of
    /// cells.
    Thesis,
}

impl From<Kind> for Method {
    fn from(kind: Kind) -> Self {
        match kind {
            Kind::Uniform => Self::Uniform,
            Kind::Thesis => Self::Thesis,
        }
    }
}

/// A distance between surfaces.
#[derive(Debug, Clone, Copy)]
enum Tolerance {
    /// In units of the mesh.
    Length(f64),
    /// In per cent of the diagonal of the mesh.
    Percent(f64),
}

/// Parses a positive length or percentage.
fn tolerance(text: &str) -> Result<Tolerance, String> {
    let (number, of): (&str, fn(f64) -> Tolerance) = match text.strip_suffix('%') {
        Some(number) => (number, Tolerance::Percent),
        None => (text, Tolerance::Length),
    };
    match number.trim().parse() {
        Ok(number) if number > 0.0 && f64::is_finite(number) => Ok(of(number)),
        _ => Err("expected a positive length, or a percentage of the diagonal such as 0.5%".into()),
    }
}

impl Tolerance {
    /// Returns the distance in units of the mesh.
    fn of(self, mesh: &TriMesh) -> f64 {
        match self {
            Self::Length(length) => length,
            Self::Percent(percent) => {
                // Vertices without a face have no distance, and do not count here either.
                let used = mesh.faces().iter().flatten().map(|&v| mesh.vertices()[v as usize]);
                let mut sides = [(f64::INFINITY, f64::NEG_INFINITY); 3];
                for p in used {
                    for (side, x) in sides.iter_mut().zip(p) {
                        *side = (side.0.min(x), side.1.max(x));
                    }
                }
                let square: f64 = sides.iter().map(|(low, high)| (high - low).powi(2)).sum();
                percent / 100.0 * square.sqrt()
            }
        }
    }
}

/// The size of the result.
#[derive(Clone, Copy)]
enum Size {
    Vertices(usize),
    /// Largest distance of the surfaces, in units of the mesh.
    Within(f64),
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    if args.uniform && (args.relax == 0 || args.method == Kind::Thesis) {
        bail!("--uniform: needs relaxation passes, not --relax 0 or --method thesis");
    }
    let names = outputs(args)?;
    for name in &names {
        files::check_name(name)?;
    }
    let outputs = names.iter().map(|name| args.force.create(name)).collect::<Result<Vec<_>>>()?;
    let picture = args.picture.create(args.force)?;
    let prolongation = match &args.prolongation {
        Some(path) if path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("mtx")) => {
            bail!("{}: the name of --prolongation must end in .mtx", path.display())
        }
        Some(path) => Some(args.force.create(path)?),
        None => None,
    };
    let input = read(&args.input, &args.repair)?;
    let sizes = wanted(args, &input.mesh)?;
    let locked = locked(args, &input)?;
    let density = density(args, &input)?;
    let par = args.threads.par();

    let mut levels: Vec<Level> = Vec::new();
    for size in sizes {
        let level = match levels.last() {
            None => Level::new(args, &input, size, args.first, &locked, &density)?,
            Some(before) => {
                // The locked vertices are the first ones of each level.
                let stay: Vec<u32> = (0..before.found.locked as u32).collect();
                Level::new(args, &before.file, size, None, &stay, &before.density)?
            }
        };
        report_result(args, &input, &level, par)?;
        if !locked.is_empty() {
            report_locked(&locked, &level.found)?;
        }
        levels.push(level);
    }

    if let (Some(output), Some(level)) = (prolongation, levels.first()) {
        let path = output.path().display().to_string();
        let matrix = level.found.weights(&input.mesh, par)?;
        write_sparse(output, &matrix)?;
        let (rows, columns) = matrix.shape();
        let entries = matrix.nnz();
        status!(
            "prolongation": "matrix",
            path = path,
            rows = rows,
            columns = columns,
            entries = entries;
            "{path}: {rows} x {columns}, {entries} entries"
        )?;
    }
    if let Some(picture) = picture {
        let mut panels = vec![(&input.mesh, PLAIN, "before")];
        panels.extend(levels.iter().map(|level| (&level.found.mesh, PLAIN, "after")));
        args.picture.draw_faces(picture, &args.input, &panels)?;
    }
    let left_out = Decimation::left_out(&input);
    for (output, level) in outputs.into_iter().zip(levels) {
        let path = output.path().display().to_string();
        output::mesh(output, &level.file)?;
        if !left_out.is_empty() {
            let what = left_out.join(", ");
            note(format_args!("{path}: {what} of the input are not carried over"));
        }
        status!("written", path = path; "{path}")?;
    }
    Ok(())
}

/// Returns the names of the results.
fn outputs(args: &Args) -> Result<Vec<PathBuf>> {
    if args.levels.is_empty() {
        return Ok(vec![args.output.clone()]);
    }
    if !args.levels.is_sorted_by(|n, next| n > next) {
        bail!("--levels: each must have fewer vertices than the one before");
    }
    let Some(name) = args.output.to_str().filter(|name| name.contains(NUMBER)) else {
        bail!(
            "{}: with --levels, {NUMBER} must stand for the number of vertices in the name of -o, \
             as in lod-{NUMBER}.ply",
            args.output.display()
        );
    };
    Ok(args.levels.iter().map(|n| name.replace(NUMBER, &n.to_string()).into()).collect())
}

/// A result.
struct Level {
    found: Decimation,
    /// With what is carried over.
    file: MeshFile,
    /// At the vertices of the result; empty if it is the same everywhere.
    density: Vec<f64>,
    elapsed: Duration,
}

impl Level {
    /// Decimates a mesh.
    fn new(
        args: &Args,
        from: &MeshFile,
        size: Size,
        first: Option<u32>,
        locked: &[u32],
        density: &[f64],
    ) -> Result<Self> {
        let bar = Bar::new("decimate");
        let update = |fraction| bar.update(fraction);
        let options = DecimateOptions::new()
            .method(args.method.into())
            .lloyd(args.lloyd)
            .relaxation(args.relax)
            .uniform(args.uniform)
            .cut_narrow_handles(args.cut_handles)
            .first(first)
            .locked(locked)
            .density(density)
            .curvature(args.curvature)
            .par(args.threads.par())
            .progress(&update);
        let start = Instant::now();
        let path = args.input.display();
        let found = match size {
            Size::Vertices(n) => decimate(&from.mesh, n, &options)
                .map_err(|error| refused(error, args))
                .with_context(|| format!("{path}: can't be decimated to {n} vertices"))?,
            Size::Within(error) => decimate_within(&from.mesh, error, &options)
                .map_err(|error| refused(error, args))
                .with_context(|| format!("{path}: can't be decimated within {error:e}"))?,
        };
        let elapsed = start.elapsed();
        let file = found.carry(from)?;
        let density = match density.is_empty() {
            true => Vec::new(),
            false => found.carry_values(&from.mesh, 1, density)?,
        };
        Ok(Self { found, file, density, elapsed })
    }
}

/// Reads a mesh, repairs it, and reports its size.
pub fn read(path: &Path, repair: &MeshArgs) -> Result<MeshFile> {
    let start = Instant::now();
    let file = repair.read(path)?;
    let (vertices, faces) = (file.mesh.vertices().len(), file.mesh.faces().len());
    let time = start.elapsed();
    let path = path.display().to_string();
    status!(
        "mesh",
        path = path,
        vertices = vertices,
        faces = faces,
        seconds = time.as_secs_f64();
        "{path}: {vertices} vertices, {faces} faces, read in {}",
        seconds(time)
    )?;
    Ok(file)
}

/// Returns the vertices that stay.
fn locked(args: &Args, input: &MeshFile) -> Result<Vec<u32>> {
    if let Some(file) = &args.lock {
        return numbers(file, input.mesh.vertices().len());
    }
    let Some(name) = &args.lock_by else { return Ok(Vec::new()) };
    let values = scalar(args, input, "--lock-by", name)?;
    let is_set = |value: f64| value != 0.0 && !value.is_nan();
    let all = (0..).zip(values).filter(|(_, value)| is_set(**value));
    let vertices: Vec<u32> = all.map(|(v, _)| v).collect();
    if vertices.is_empty() {
        bail!("--lock-by {name}: {} is 0 at all vertices", args.input.display());
    }
    Ok(vertices)
}

/// Returns the values of a scalar of the mesh, which this option names.
fn scalar<'a>(args: &Args, input: &'a MeshFile, option: &str, name: &str) -> Result<&'a [f64]> {
    let Some(scalars) = input.scalars.iter().find(|scalars| scalars.name == name) else {
        let known: Vec<&str> = input.scalars.iter().map(|scalars| scalars.name.as_str()).collect();
        let known = if known.is_empty() { "none".into() } else { known.join(", ") };
        bail!("{option} {name}: {} has no such scalar: {known}", args.input.display());
    };
    Ok(&scalars.values)
}

/// Returns the densities at the vertices of the mesh; none if they are the same everywhere.
fn density(args: &Args, input: &MeshFile) -> Result<Vec<f64>> {
    if let Some(name) = &args.density_by {
        return Ok(scalar(args, input, "--density-by", name)?.to_vec());
    }
    let Some(file) = &args.density else { return Ok(Vec::new()) };
    let text = file.read()?;
    let mut values = Vec::new();
    for (at, word) in words(&text) {
        match word.parse::<f64>() {
            Ok(value) if value > 0.0 && value.is_finite() => values.push(value),
            _ => bail!("{}: line {at}: '{word}' is not a positive number", file.name()),
        }
    }
    let vertices = input.mesh.vertices().len();
    if values.len() != vertices {
        let count = values.len();
        bail!("{}: expected a number for each of {vertices} vertices, got {count}", file.name());
    }
    Ok(values)
}

/// Returns the lines of a text without blanks around them, each with its number; empty lines and
/// those that begin with `#` are skipped.
fn words(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines = (1..).zip(text.lines().map(str::trim));
    lines.filter(|(_, word)| !word.is_empty() && !word.starts_with('#'))
}

/// Reads numbers of vertices, one a line.
fn numbers(file: &TextFile, vertices: usize) -> Result<Vec<u32>> {
    let text = file.read()?;
    let mut known = HashMap::new();
    let mut numbers = Vec::new();
    for (at, word) in words(&text) {
        let here = || format!("{}: line {at}", file.name());
        let number = word.parse().ok().filter(|&v: &u32| (v as usize) < vertices);
        let Some(number) = number else {
            bail!("{}: '{word}' is not a vertex from 0 to {}", here(), vertices.saturating_sub(1));
        };
        if let Some(before) = known.insert(number, at) {
            bail!("{}: vertex {number} is also in line {before}", here());
        }
        numbers.push(number);
    }
    if numbers.is_empty() {
        bail!("{}: names no vertex", file.name());
    }
    Ok(numbers)
}

/// Reports the vertices that stay, and the edges between them.
fn report_locked(locked: &[u32], found: &Decimation) -> Result<()> {
    let (vertices, edges, lost) = (locked.len(), found.locked_edges, found.lost_edges);
    if lost > 0 {
        note(format_args!(
            "{lost} of {edges} edges between locked vertices are longer than those of the result, \
             and not in it"
        ));
    }
    status!(
        "locked",
        vertices = vertices,
        edges = edges - lost;
        "{vertices} vertices, and {} edges between them",
        edges - lost
    )
}

/// Returns the option that sets the size of the results.
fn size_option(args: &Args) -> &'static str {
    match (args.ratio, args.faces, args.edge_length, args.error) {
        (Some(_), ..) => "--ratio",
        (_, Some(_), ..) => "--faces",
        (_, _, Some(_), _) => "--edge-length",
        (.., Some(_)) => "--error",
        _ if !args.levels.is_empty() => "--levels",
        _ => "-n",
    }
}

/// Names the option that set the number of vertices, where an error of the library is about it.
fn refused(error: catamaran::Error, args: &Args) -> anyhow::Error {
    let option = match (args.ratio, args.faces, args.edge_length) {
        (Some(ratio), ..) => format!("--ratio {ratio}"),
        (_, Some(faces), _) => format!("--faces {faces}"),
        (.., Some(length)) => format!("--edge-length {length:e}"),
        _ if !args.levels.is_empty() => "--levels".into(),
        _ => "-n".into(),
    };
    match error {
        catamaran::Error::Argument { what: "locked", why } => {
            anyhow!("{}: {why}", if args.lock_by.is_some() { "--lock-by" } else { "--lock" })
        }
        catamaran::Error::Argument { what: "density", why } => {
            let by_name = args.density_by.is_some();
            anyhow!("{}: {why}", if by_name { "--density-by" } else { "--density" })
        }
        error @ catamaran::Error::Argument { what: "curvature" | "first", .. } => as_option(error),
        catamaran::Error::Argument { what: "n" | "error", why } if args.error.is_some() => {
            anyhow!("--error: {why}")
        }
        catamaran::Error::Argument { what: "n", why } => anyhow!("{option}: {why}"),
        error => error.into(),
    }
}

/// Returns the sizes of the results.
fn wanted(args: &Args, input: &TriMesh) -> Result<Vec<Size>> {
    if !args.levels.is_empty() {
        return Ok(args.levels.iter().copied().map(Size::Vertices).collect());
    }
    if let Some(error) = args.error {
        return Ok(vec![Size::Within(error.of(input))]);
    }
    Ok(vec![Size::Vertices(number(args, input)?)])
}

/// Returns the number of vertices of a single result.
fn number(args: &Args, input: &TriMesh) -> Result<usize> {
    if let Some(ratio) = args.ratio {
        if !(ratio > 0.0 && ratio.is_finite()) {
            bail!("--ratio {ratio}: a finite number above 0 is needed");
        }
        return Ok((ratio * input.vertices().len() as f64).round().max(1.0) as usize);
    }
    if let Some(faces) = args.faces {
        return vertices_for_faces(input, faces).map_err(as_option);
    }
    if let Some(length) = args.edge_length {
        return vertices_for_edge_length(input.area(), length).map_err(|error| match error {
            catamaran::Error::Argument { what: "length", why } => anyhow!("--edge-length: {why}"),
            error => error.into(),
        });
    }
    args.n.context("-n is needed")
}

fn report_result(args: &Args, input: &MeshFile, level: &Level, par: Par) -> Result<()> {
    let Level { found, elapsed, .. } = level;
    let elapsed = *elapsed;
    let (vertices, faces) = (found.mesh.vertices().len(), found.mesh.faces().len());
    status!(
        "decimated",
        vertices = vertices,
        faces = faces,
        seconds = elapsed.as_secs_f64();
        "{vertices} vertices, {faces} faces, in {}",
        seconds(elapsed)
    )?;
    if args.error.is_some() && vertices > input.mesh.vertices().len() {
        note(format_args!(
            "{vertices} vertices are more than the input has: --error is small for its faces"
        ));
    }
    let repairs = found.repairs;
    status!(
        "repairs",
        repeated_faces = repairs.repeated_faces,
        cut_edges = repairs.cut_edges,
        split_vertices = repairs.split_vertices,
        unreferenced_vertices = repairs.unreferenced_vertices,
        oriented = repairs.oriented;
        "{repairs}"
    )?;
    report_topology("topology", Some(found.before))?;
    if found.after != Some(found.before) {
        report_topology("changed to", found.after)?;
    }
    let intersecting = found.mesh.intersecting_faces(par).len();
    let before = match args.report || intersecting > 0 {
        true => input.mesh.intersecting_faces(par).len(),
        false => 0,
    };
    let option = size_option(args);
    if intersecting > before {
        let more = intersecting - before;
        note(format_args!(
            "{more} more faces intersect others than in the input: try another value of {option}"
        ));
    }
    let flat = found.mesh.faces_without_area().len();
    if flat > 0 {
        note(format_args!(
            "{flat} faces of the result have no area: try another value of {option}"
        ));
    }
    if !args.report && args.error.is_none() {
        return Ok(());
    }
    let difference = Difference::between(&input.mesh, &found.mesh, par)?;
    if !args.report {
        return report_bound(&difference);
    }
    report!(
        "intersect",
        faces = intersecting,
        before = before;
        "{intersecting} faces, {before} before"
    )?;
    report_quality(found)?;
    report_bound(&difference)?;
    report_difference(&difference)?;
    let length = edge_length_for(found.mesh.area(), vertices)?;
    report!("edges", length = length; "{length:.4e} long if all triangles were equilateral")
}

/// Reports the uniformity of a result, and that of its largest component if there are several.
fn report_quality(found: &Decimation) -> Result<()> {
    let quality = Quality::of(&found.mesh);
    row!(
        "quality",
        mean_area = quality.mean_area,
        area_variation = quality.area_variation,
        mean_quality = quality.mean_quality,
        quality_deviation = quality.quality_deviation,
        least_quality = quality.least_quality,
        mean_valence = quality.mean_valence,
        regular_percent = 100.0 * quality.regular_vertices,
        non_manifold_edges = quality.non_manifold_edges;
        "{quality}"
    )?;
    if found.after.is_some_and(|after| after.components > 1) {
        // Specks have as few faces as they can, which says nothing about the rest.
        let largest = repair(found.mesh.clone().into(), &RepairOptions::new().keep_largest(1))?;
        let Quality { area_variation, mean_quality, .. } = Quality::of(&largest.file.mesh);
        report!(
            "largest",
            area_variation = area_variation,
            mean_quality = mean_quality;
            "component alone: variation of areas {area_variation:.3}, mean quality \
             {mean_quality:.3}"
        )?;
    }
    Ok(())
}

/// Reports how far a point of the result or of the input is from the other surface at most.
fn report_bound(difference: &Difference) -> Result<()> {
    let bound = difference.hausdorff_bound;
    report!("distance", bound = bound; "{bound:.4e} at most, of any point of either surface")
}

/// Reports the distances of the vertices of a result from its input, and back.
fn report_difference(difference: &Difference) -> Result<()> {
    let &Difference { hausdorff, chamfer, printed_hausdorff, printed_chamfer, .. } = difference;
    report!(
        "hausdorff": "Hausdorff",
        of_vertices = hausdorff,
        as_printed = printed_hausdorff;
        "{hausdorff:.4e} of the vertices, eq. 5.8 as printed {printed_hausdorff:.4e}"
    )?;
    report!(
        "chamfer": "Chamfer",
        distance = chamfer,
        as_printed = printed_chamfer;
        "{chamfer:.4e}, eq. 5.8 as printed {printed_chamfer:.4e}"
    )
}

/// Reports the topology of a mesh; `None` stands for a mesh that is not a manifold.
fn report_topology(label: &str, topology: Option<Topology>) -> Result<()> {
    let text = topology.map_or("not a manifold".into(), |topology| topology.to_string());
    status!(
        "topology": label,
        of = if label == "topology" { "input" } else { "output" },
        components = topology.map(|topology| topology.components),
        loops = topology.map(|topology| topology.boundary_loops),
        genus = topology.map(|topology| genus(topology.genus));
        "{text}"
    )
}

/// Writes a sparse matrix as Matrix Market coordinates.
fn write_sparse(mut output: Output, matrix: &CsMat<f64>) -> Result<()> {
    let written = sprs::io::write_matrix_market_to_bufwrite(&mut output, matrix);
    written.map_err(|e| output.error(e))?;
    Ok(output.commit()?)
}
