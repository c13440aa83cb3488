//! `catamaran shapedna`.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use catamaran::Error;
use catamaran::faer::Mat;
use catamaran::io::{self, Output};
use catamaran_geometry::mesh::{Boundary, LaplacianOptions, io::read_with};
use catamaran_geometry::unions::{
    MetricOptions, RetrievalMetric, ShapeDnaOptions, retrieve, shape_dna,
};

use crate::common::Force;
use crate::input::{self, TextFile};
use crate::pieces::Pieces;
use crate::progress::Bar;
use crate::report::{head, row, status};
use crate::shape::{LaplacianArgs, MassArgs, has_faces};

/// The options of comparisons, which a fit of a metric does not make.
const NOT_FITTED: [&str; 3] = ["query", "distances", "metric"];

/// Compare triangle meshes by their spectra (ShapeDNA).
///
/// The comparison depends neither on the pose nor on the triangulation.
/// The signature of a mesh is its first eigenvalues. For each mesh the command lists the other
/// meshes, the nearest first, with the Euclidean distance of the signatures, or with the distance
/// of a metric that was fitted to shapes in several poses.
#[derive(clap::Args)]
pub struct Args {
    #[arg(value_name = "MESH", required = true, help = input::mesh_help("Meshes"))]
    inputs: Vec<PathBuf>,
    /// Compare this mesh with the others, instead of each with each.
    #[arg(long, value_name = "MESH")]
    query: Option<PathBuf>,
    /// Number of eigenvalues in a signature.
    #[arg(short, default_value_t = ShapeDnaOptions::default().k, value_name = "NUMBER")]
    k: usize,
    /// Number of nearest meshes to list.
    #[arg(long, default_value_t = 5, value_name = "NUMBER")]
    nearest: usize,
    /// Distinguish meshes of different size: do not multiply eigenvalues by the area.
    #[arg(long)]
    sized: bool,
    /// Use functions that are zero at the boundary (Dirichlet), instead of functions whose normal
    /// derivative is zero there (Neumann).
    #[arg(long)]
    dirichlet: bool,
    #[command(flatten)]
    mass: MassArgs,
    #[command(flatten)]
    laplacian: LaplacianArgs,
    /// Write the signatures, a row for each mesh (that of the query first): .npy, .csv, .tsv, .txt
    /// or .mtx, and .gz after it.
    #[arg(long, value_name = "FILE")]
    signatures: Option<PathBuf>,
    /// Write the table of distances, a row and a column for each mesh (those of the query first),
    /// in the same formats. With --metric, rows are queries: the table is not symmetric.
    #[arg(long, value_name = "FILE")]
    distances: Option<PathBuf>,
    /// Write a metric that is fitted to the meshes, whose shapes --labels names, instead of the
    /// lists of nearest meshes: a .json file for --metric.
    #[arg(
        long,
        value_name = "FILE",
        requires = "labels",
        conflicts_with_all = NOT_FITTED
    )]
    fit_metric: Option<PathBuf>,
    /// Which meshes are poses of one shape: a text file with a line for each mesh, in the order of
    /// the meshes, that names its shape.
    #[arg(
        long,
        value_name = "FILE",
        requires = "fit_metric",
        conflicts_with_all = NOT_FITTED
    )]
    labels: Option<TextFile>,
    /// Fit the metric to differences of poses alone: for a few shapes in many poses. Without it,
    /// 2 K + 3 shapes are needed for K eigenvalues that are not zero.
    #[arg(long, requires = "fit_metric", conflicts_with_all = NOT_FITTED)]
    poses_only: bool,
    /// Compare with a metric that --fit-metric wrote, for signatures of the same kind: a distance
    /// that is small for poses of one shape.
    #[arg(long, value_name = "FILE")]
    metric: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let writes = [&args.signatures, &args.distances, &args.fit_metric].iter().any(|x| x.is_some());
    if args.nearest == 0 && !writes {
        bail!(
            "--nearest 0: lists nothing, which is for --signatures, --distances and --fit-metric \
             only"
        );
    }
    if let ([only], None, false) = (&args.inputs[..], &args.query, writes) {
        let name = only.display();
        bail!(
            "{name}: one mesh has no neighbors: name more, or write its signature (--signatures)"
        );
    }
    let signatures = create(args.signatures.as_deref(), args.force)?;
    let distances = create(args.distances.as_deref(), args.force)?;
    let fit = args.fit_metric.as_deref().map(|path| metric_file(path, args.force)).transpose()?;
    let identities = args.labels.as_ref().map(|labels| identities(args, labels)).transpose()?;
    let metric = args.metric.as_deref().map(|path| read_metric(path, args)).transpose()?;
    let names: Vec<&Path> = args.query.iter().chain(&args.inputs).map(PathBuf::as_path).collect();
    let boundary = if args.dirichlet { Boundary::Dirichlet } else { Boundary::Neumann };
    let par = args.laplacian.par();
    let laplacian = LaplacianOptions::new()
        .kind(args.laplacian.kind())
        .mass(args.mass.kind())
        .boundary(boundary)
        .par(par);
    let options = ShapeDnaOptions::new().k(args.k).normalized(!args.sized).laplacian(laplacian);
    let bar = Bar::new("shapes");
    let mut found = Vec::with_capacity(names.len());
    // With a metric, the number of zeros of all signatures and the mesh that it is of.
    let mut zeros = metric.as_ref().map(|metric| (metric.zeros(), Path::new("the metric")));
    for (i, name) in names.iter().enumerate() {
        let file = read_with(name, &input::source())?;
        input::accept(&file, name)?;
        let mesh = args.laplacian.repair.apply(file, name)?.mesh;
        has_faces(&mesh, name)?;
        let pieces = Pieces::new(&mesh, name, &args.laplacian.repair, &options.laplacian.boundary)?;
        pieces.check_signature(args.k)?;
        pieces.note();
        if metric.is_some() || fit.is_some() {
            let (expected, of) = *zeros.get_or_insert((pieces.free(), *name));
            if pieces.free() != expected {
                let are = match pieces.free() {
                    1 => "1 eigenvalue is".to_owned(),
                    count => format!("{count} eigenvalues are"),
                };
                bail!(
                    "{}: {are} zero, {} has {expected}: a metric compares shapes with as many",
                    name.display(),
                    of.display()
                );
            }
        }
        found.push(shape_dna(&mesh, &options).with_context(|| name.display().to_string())?);
        bar.step((i + 1) as f64 / names.len() as f64)?;
    }
    drop(bar);

    let listed = match (&fit, &args.query) {
        (Some(_), _) => 0,
        (None, Some(_)) => 1,
        (None, None) => names.len(),
    };
    if let (Some(output), Some(identities)) = (fit, identities) {
        let zeros = zeros.map_or(0, |(zeros, _)| zeros);
        write_metric(output, &fitted(&found, &identities, zeros, args)?, names.len())?;
    }
    // The signatures of queries and of shapes, whose Euclidean distances are those of the metric.
    let (queries, shapes) = match &metric {
        Some(metric) => {
            let all = |of: &dyn Fn(&[f64]) -> catamaran::Result<Vec<f64>>| {
                let pairs = found.iter().zip(&names);
                pairs
                    .map(|(x, name)| of(x).with_context(|| name.display().to_string()))
                    .collect::<Result<Vec<_>>>()
            };
            (all(&|x: &[f64]| metric.of_query(x))?, all(&|x: &[f64]| metric.of_shape(x))?)
        }
        None => (found.clone(), found.clone()),
    };
    for (i, name) in names.iter().enumerate().take(listed) {
        head(format_args!("{}", name.display()))?;
        // One more than requested: the mesh itself.
        let nearest = retrieve(&queries[i], &shapes, args.nearest.saturating_add(1), par)?;
        let others = nearest.iter().filter(|other| other.index != i).take(args.nearest);
        for other in others {
            let (distance, nearest) = (other.distance, names[other.index].display().to_string());
            row!(
                "neighbor",
                mesh = name.display().to_string(),
                neighbor = nearest,
                distance = distance;
                "  {distance:<12.6} {nearest}"
            )?;
        }
    }
    let count = names.len();
    if let Some(output) = signatures {
        let rows = Mat::from_fn(count, args.k, |i, j| found[i][j]);
        written(output, &rows)?;
    }
    if let Some(output) = distances {
        let mut table = Mat::zeros(count, count);
        for i in 0..count {
            for other in retrieve(&queries[i], &shapes, count, par)? {
                table[(i, other.index)] = other.distance;
            }
        }
        written(output, &table)?;
    }
    Ok(())
}

/// Fits a metric to signatures that begin with this number of zeros; `identities` has the number
/// of the shape of each.
fn fitted(
    signatures: &[Vec<f64>],
    identities: &[usize],
    zeros: usize,
    args: &Args,
) -> Result<RetrievalMetric> {
    let options =
        MetricOptions::new().zeros(zeros).poses_only(args.poses_only).spectrum(kind(args));
    RetrievalMetric::fit(signatures, identities, &[], &options).map_err(|e| match e {
        Error::Argument { why, .. } => {
            anyhow!("--labels: {}", why.replace("poses_only", "--poses-only"))
        }
        other => other.into(),
    })
}

/// Returns what the signatures are, as files of metrics say it.
fn kind(args: &Args) -> String {
    let size = if args.sized { "" } else { ", multiplied by the area" };
    let boundary = if args.dirichlet { "Dirichlet" } else { "Neumann" };
    format!("{boundary} eigenvalues{size}")
}

/// Reads a metric, and refuses one for other signatures.
fn read_metric(path: &Path, args: &Args) -> Result<RetrievalMetric> {
    let metric = RetrievalMetric::read(path)?;
    let (fitted, own) = (metric.spectrum(), kind(args));
    let name = path.display();
    if metric.k() != args.k {
        let k = metric.k();
        bail!("{name}: compares {k} eigenvalues, not {}: give -k {k}", args.k);
    }
    if fitted != own {
        bail!(
            "{name}: was fitted to \"{fitted}\", these options compute \"{own}\": give --sized and \
             --dirichlet as for the fit"
        );
    }
    Ok(metric)
}

/// Returns a number for the shape of each mesh, from the lines of the labels.
fn identities(args: &Args, labels: &TextFile) -> Result<Vec<usize>> {
    let (text, name) = (labels.read()?, labels.name());
    let (mut numbers, mut found) = (BTreeMap::new(), Vec::new());
    for (i, line) in text.lines().map(str::trim).enumerate() {
        if line.is_empty() {
            bail!("{name}:{}: names no shape", i + 1);
        }
        let next = numbers.len();
        found.push(*numbers.entry(line).or_insert(next));
    }
    let (lines, meshes) = (found.len(), args.inputs.len());
    if lines != meshes {
        bail!("{name}: must have a line for each of the {meshes} meshes, has {lines}");
    }
    Ok(found)
}

fn metric_file(path: &Path, force: Force) -> Result<Output> {
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("json")) {
        bail!("{}: the name must end in .json", path.display());
    }
    force.create(path)
}

fn write_metric(mut output: Output, metric: &RetrievalMetric, count: usize) -> Result<()> {
    let path = output.path().display().to_string();
    output.write_all(&metric.to_bytes()?).map_err(|e| output.error(e))?;
    output.commit()?;
    status!(
        "written",
        path = path,
        meshes = count,
        eigenvalues = metric.k();
        "{path}: fitted to {count} meshes, {} eigenvalues", metric.k()
    )
}

fn create(path: Option<&Path>, force: Force) -> Result<Option<Output>> {
    let Some(path) = path else { return Ok(None) };
    io::check_name(path)?;
    force.create(path).map(Some)
}

fn written(output: Output, matrix: &Mat<f64>) -> Result<()> {
    let path = output.path().display().to_string();
    io::write(output, matrix.as_ref())?;
    let (rows, columns) = (matrix.nrows(), matrix.ncols());
    status!("written", path = path, rows = rows, columns = columns; "{path}: {rows} x {columns}")
}
