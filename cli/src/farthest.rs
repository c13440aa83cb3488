//! `catamaran farthest`.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result, anyhow};
use catamaran::Error;
use catamaran::base::Progress;
use catamaran::faer::Mat;
use catamaran::io::{self as files, Output};
use catamaran_geometry::decimate::{Cells, FarthestPoints};
use catamaran_geometry::mesh::{Components, TriMesh};

use crate::common::{Force, as_option};
use crate::input::MeshArgs;
use crate::parse;
use crate::picture::{Paint, PictureArgs};
use crate::progress::Bar;
use crate::report::{note, report, seconds, status};
use crate::shape::column;

/// Sample a mesh by farthest points, along its edges.
///
/// Each sample is the vertex that is farthest from the samples before it; a component without a
/// sample is infinitely far. The first K samples are the same for every N of at least K.
#[derive(clap::Args)]
pub struct Args {
    #[arg(value_name = "MESH", help = crate::input::mesh_help("The mesh"))]
    input: PathBuf,
    /// Number of samples, at least 1.
    #[arg(short, value_name = "N", value_parser = parse::at_least_one)]
    n: usize,
    /// Vertex of the first sample, numbered from 0 [default: the lowest vertex that a face has].
    #[arg(long, value_name = "VERTEX")]
    first: Option<u32>,
    /// Output file of the samples, a row for each: the number of its vertex, from 0 (.npy, .csv,
    /// ...).
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Write the number of the cell of each vertex of the mesh: an integer from 0, or -1 for a
    /// vertex without a face or in a component without a sample (.npy, .csv, ...).
    #[arg(long, value_name = "FILE")]
    cells: Option<PathBuf>,
    /// Write the distance of each vertex of the mesh from the sample of its cell, along edges and
    /// in units of the mesh, computed in single precision (a relative error of about 1e-7);
    /// infinite for a vertex in no cell (.npy, .csv, ...).
    #[arg(long, value_name = "FILE")]
    distances: Option<PathBuf>,
    #[command(flatten)]
    repair: MeshArgs,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    force: Force,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let create = |path: &PathBuf| -> Result<Output> {
        files::check_name(path)?;
        args.force.create(path)
    };
    let output = create(&args.output)?;
    let of_cells = args.cells.as_ref().map(create).transpose()?;
    let of_distances = args.distances.as_ref().map(create).transpose()?;
    let picture = args.picture.create(args.force)?;
    let input = crate::decimate::read(&args.input, &args.repair)?;

    let bar = Bar::new("sampling");
    let start = Instant::now();
    let named = || args.input.display().to_string();
    let mut points =
        FarthestPoints::new(&input.mesh, args.first).map_err(refused).with_context(named)?;
    points
        .extend_to(args.n, Progress::new(&|fraction| bar.update(fraction)))
        .map_err(refused)
        .with_context(named)?;
    let elapsed = start.elapsed();
    drop(bar);
    let samples = points.samples();
    let cells = points.cells();
    let count = samples.len();
    let radius = match note_unreached(&input.mesh, &cells, count) {
        0 => cells.radius(),
        _ => f64::INFINITY,
    };
    report!(
        "samples",
        count = count,
        radius = radius,
        seconds = elapsed.as_secs_f64();
        "{count}, cells of radius {radius:.4e}, in {}",
        seconds(elapsed)
    )?;

    if let Some(output) = of_cells {
        let number = |cell: u32| if cell == Cells::NONE { -1 } else { i64::from(cell) };
        let all = cells.of_vertices();
        let table = Mat::from_fn(all.len(), 1, |v, _| number(all[v]));
        files::write_integers(output, table.as_ref())?;
    }
    if let Some(output) = of_distances {
        let all = cells.lengths();
        files::write(output, Mat::from_fn(all.len(), 1, |v, _| all[v]).as_ref())?;
    }
    if let Some(picture) = picture {
        // NaN is drawn in grey.
        let shown = |length: f64| if length.is_finite() { length } else { f64::NAN };
        let values: Vec<f64> = cells.lengths().into_iter().map(shown).collect();
        let panel = (&input.mesh, Paint::Values(&values), "distance");
        args.picture.draw(picture, &args.input, &[panel])?;
    }
    let path = output.path().display().to_string();
    files::write_integers(output, column(samples).as_ref())?;
    status!("written", path = path; "{path}")
}

/// Notes that components have no sample, because there are more of them than samples, and returns
/// how many.
fn note_unreached(mesh: &TriMesh, cells: &Cells, samples: usize) -> usize {
    let components = Components::new(mesh);
    let numbers = components.of_vertices().iter().zip(cells.of_vertices());
    let unreached = |&(&of, &cell): &(&u32, &u32)| of != Components::NONE && cell == Cells::NONE;
    let (vertices, all) = (numbers.filter(unreached).count(), components.len());
    let without = all.saturating_sub(samples);
    if without > 0 {
        note(format_args!(
            "{without} of {all} components have no sample: {vertices} vertices are in no cell, and \
             infinitely far from all samples; -n {all} is enough for one in each"
        ));
    }
    without
}

/// Names the option that an error of the library is about.
fn refused(error: Error) -> anyhow::Error {
    match error {
        Error::Argument { what: "n", why } => anyhow!("-n: {why}"),
        error => as_option(error),
    }
}
