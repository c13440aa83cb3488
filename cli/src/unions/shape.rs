//! `catamaran unions shape`.

use std::fs::File;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use catamaran::Error;
use catamaran::base::Progress;
use catamaran_geometry::mesh::io::{MeshFile, check_name};
use catamaran_geometry::mesh::{Boundary, Edges};
use catamaran_geometry::spectral::{ShapeOptions, shape_from_spectrum};

use crate::common::{Force, Threads};
use crate::input::MeshArgs;
use crate::output;
use crate::parse;
use crate::picture::{PLAIN, PictureArgs};
use crate::pieces::Pieces;
use crate::progress::Bar;
use crate::report::{note, report, status};
use crate::shape::dense;
use crate::tables::TableArgs;

/// Deform a mesh until it has a given spectrum: the shape of a predicted union.
///
/// Many shapes have the same eigenvalues; the result is one near the template, with its faces. If
/// the template has a boundary, the spectrum is that of Dirichlet conditions, as `unions predict`
/// prints it; if the template is closed, the spectrum leaves out the zero eigenvalues.
#[derive(clap::Args)]
pub struct Args {
    #[arg(value_name = "TEMPLATE", help = crate::input::mesh_help("The mesh to deform"))]
    template: PathBuf,
    /// Table of eigenvalues (.csv, .npy, ...), of which the last column is used, such as that of
    /// `unions predict -o`.
    #[arg(long, value_name = "FILE")]
    spectrum: PathBuf,
    #[command(flatten)]
    table: TableArgs,
    /// Number of eigenvalues to use, the first ones of the table [default: all].
    #[arg(short, value_name = "K", value_parser = parse::at_least_one)]
    k: Option<usize>,
    /// Largest number of steps.
    #[arg(long, value_name = "N", default_value_t = ShapeOptions::default().steps)]
    steps: usize,
    /// Mean relative difference of eigenvalues at which the deformation ends.
    #[arg(long, value_name = "SHARE", default_value_t = ShapeOptions::default().tolerance)]
    tolerance: f64,
    #[arg(
        short,
        long,
        value_name = "MESH",
        help = output::mesh_help("Output file of the deformed mesh")
    )]
    output: PathBuf,
    #[command(flatten)]
    repair: MeshArgs,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    force: Force,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    check_name(&args.output)?;
    let output = args.force.create(&args.output)?;
    let picture = args.picture.create(args.force)?;
    let template = args.repair.read(&args.template)?.mesh;
    let closed = Edges::new(&template).boundary().next().is_none();
    let boundary = if closed { Boundary::Neumann } else { Boundary::Dirichlet };
    Pieces::new(&template, &args.template, &args.repair, &boundary)?.note();
    let table = dense(&args.spectrum, &args.table)?;
    let named = || args.spectrum.display().to_string();
    let last = table.ncols().checked_sub(1).context("no columns").with_context(named)?;
    if closed && is_predicted(&args.spectrum) {
        note(format_args!(
            "{} is closed, and its eigenvalues are those without a boundary; `unions predict` \
             writes those of a part with its boundary held at zero",
            args.template.display()
        ));
    }
    let (rows, count) = (table.nrows(), args.k.unwrap_or(table.nrows()));
    if count > rows {
        bail!("{}: -k {count}, but the table has {rows} eigenvalues", args.spectrum.display());
    }
    let wanted: Vec<f64> = (0..count).map(|i| table[(i, last)]).collect();
    let bar = Bar::new("deforming");
    let update = |fraction| bar.update(fraction);
    let options = ShapeOptions::new()
        .steps(args.steps)
        .tolerance(args.tolerance)
        .par(args.threads.par())
        .progress(Progress::new(&update));
    let found = shape_from_spectrum(&template, &wanted, &options)
        .map_err(|error| with_culprit(error, args, last))?;
    drop(bar);
    let (steps, error) = (found.steps, 100.0 * found.error);
    report!("steps", count = steps; "{steps}")?;
    report!(
        "error",
        mean_percent = error;
        "{error:.3} % mean relative difference of the eigenvalues"
    )?;
    if found.error > args.tolerance {
        let (wanted, why) = (
            100.0 * args.tolerance,
            match found.steps < args.steps {
                true => {
                    "no further step brings them nearer; perhaps no shape near the template has \
                     this spectrum"
                }
                false => "more steps may bring them nearer (--steps)",
            },
        );
        note(format_args!("the eigenvalues are not within {wanted} %; {why}"));
    }
    if let Some(picture) = picture {
        let panels = [(&template, PLAIN, "template"), (&found.mesh, PLAIN, "deformed")];
        args.picture.draw(picture, &args.template, &panels)?;
    }
    output::mesh(output, &MeshFile::from(found.mesh))?;
    let path = args.output.display().to_string();
    status!("written", path = path; "{path}")
}

/// Names the file that an error is about: the template, or the spectrum with its column.
fn with_culprit(error: Error, args: &Args, column: usize) -> anyhow::Error {
    let (file, error) = match error {
        Error::NonFinite { what: what @ "eigenvalues", index: (row, _) } => {
            (&args.spectrum, Error::NonFinite { what, index: (row, column) })
        }
        Error::Argument { what: "eigenvalues", .. } => (&args.spectrum, error),
        _ => (&args.template, error),
    };
    anyhow::Error::from(error).context(file.display().to_string())
}

/// Returns whether a table is one that `unions predict` writes.
fn is_predicted(path: &Path) -> bool {
    /// Bytes of the titles of more parts than anyone unites.
    const TITLES: u64 = 1 << 16;
    let mut titles = String::new();
    let read = File::open(path)
        .and_then(|file| BufReader::new(file.take(TITLES)).read_line(&mut titles))
        .is_ok();
    read && titles.starts_with("number,part 1,") && titles.trim_end().ends_with(",union")
}
