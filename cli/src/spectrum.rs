//! `catamaran spectrum`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use catamaran::base::Progress;
use catamaran::io::{Array, Output, Overwrite, check_arrays_name, write_arrays};
use catamaran::mesh::io as files;
use catamaran::mesh::{Boundary, LaplacianOptions, MassKind, laplacian};
use catamaran::sparse::EigenOptions;
use clap::ValueEnum;

use crate::picture::{Paint, PictureArgs};
use crate::progress::Bar;
use crate::ranks::Ranks;
use crate::report::{report, seconds};
use crate::shape::LaplacianArgs;

/// Eigenvalues and eigenfunctions of the Laplacian of a triangle mesh.
///
/// The file has three arrays: `eigenvalues` (k, ascending), `eigenvectors` (vertices x k, orthonormal in the inner product
/// of the mass matrix) and `residuals` (k), |W phi - lambda M phi| / |W phi|.
///
/// Under `mpirun` (where MPI is built in) the eigenvectors are spread over the processes until they are written; each uses
/// `--threads`.
#[derive(clap::Args)]
pub struct Args {
    /// The mesh: .obj, .ply, .off or .stl, each also as .gz or .xz.
    #[arg(value_name = "MESH")]
    input: PathBuf,
    /// Write the arrays to this .npz file, or .h5 where HDF5 is built in.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Number of eigenpairs; at most as many as vertices that are not held at zero.
    #[arg(short, default_value_t = 100, value_name = "NUMBER")]
    k: usize,
    /// Those nearest to this number; the smallest unless given.
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true)]
    shift: Option<f64>,
    #[command(flatten)]
    laplacian: LaplacianArgs,
    /// Mass matrix: a diagonal, or the inner product of linear functions.
    #[arg(long, default_value = "lumped")]
    mass: Mass,
    /// At the boundary the normal derivative is zero, or the function.
    #[arg(long, default_value = "neumann")]
    boundary: Edge,
    /// Residual that every pair must reach.
    #[arg(long, default_value_t = 1e-9, value_name = "NUMBER")]
    tolerance: f64,
    /// Make sure, by another factorisation, that no eigenvalue is missing.
    #[arg(long)]
    verify: bool,
    #[command(flatten)]
    picture: PictureArgs,
    /// Replace a file that exists.
    #[arg(long)]
    force: bool,
}

/// Which mass matrix.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Mass {
    Lumped,
    Full,
}

/// What holds at the boundary.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Edge {
    Neumann,
    Dirichlet,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let ranks = Ranks::join()?;
    let done = run_as(args, &ranks);
    ranks.end(done)
}

fn run_as(args: &Args, ranks: &Ranks) -> Result<()> {
    let overwrite = if args.force { Overwrite::Replace } else { Overwrite::Never };
    let path = args.output.as_deref().filter(|_| ranks.is_first());
    let output = path.map(|path| create(path, overwrite)).transpose()?;
    let picture = match ranks.is_first() {
        true => args.picture.create(overwrite)?,
        false => None,
    };
    let par = args.laplacian.par();
    let name = args.input.display();

    let start = Instant::now();
    let bar = Bar::new("reading");
    let file = files::read_with(&args.input, Some(&|fraction| bar.update(fraction)))?;
    drop(bar);
    let options = LaplacianOptions {
        kind: args.laplacian.kind(),
        mass: match args.mass {
            Mass::Lumped => MassKind::Barycentric,
            Mass::Full => MassKind::Consistent,
        },
        boundary: match args.boundary {
            Edge::Neumann => Boundary::Neumann,
            Edge::Dirichlet => Boundary::Dirichlet,
        },
        par,
    };
    let operator = laplacian(&file.mesh, &options).with_context(|| name.to_string())?;
    let (rows, vertices) = (operator.kept.len(), operator.vertices);
    report(format_args!("mesh        {name}: {vertices} vertices, {rows} of them free"))?;
    report(format_args!(
        "matrices    {} entries, in {}",
        operator.stiffness.nnz(),
        seconds(start.elapsed())
    ))?;

    let start = Instant::now();
    let bar = Bar::new("spectrum");
    let watch = |fraction| bar.update(fraction);
    let options = EigenOptions {
        k: args.k,
        shift: args.shift,
        tolerance: args.tolerance,
        verify_count: args.verify,
        par,
        progress: Some(&watch as Progress<'_>),
        ..EigenOptions::default()
    };
    let pairs = ranks
        .eigenpairs(&operator.stiffness, &operator.mass, &options)
        .with_context(|| name.to_string())?;
    drop(bar);
    report(format_args!("eigenpairs  {} in {}", args.k, seconds(start.elapsed())))?;
    let largest = pairs.residuals.iter().copied().fold(0.0, f64::max);
    report(format_args!("residual    {largest:.1e} at most"))?;
    for (i, (value, residual)) in pairs.values.iter().zip(&pairs.residuals).take(SHOWN).enumerate()
    {
        report(format_args!("{i:>10}  {value:<22.15e} {residual:.1e}"))?;
    }
    if args.k > SHOWN {
        report(format_args!("{:>10}  {:.15e}", args.k - 1, pairs.values[args.k - 1]))?;
    }

    if !ranks.is_first() {
        return Ok(());
    }
    let vectors = operator.extend(pairs.vectors.as_ref())?;
    if let Some(picture) = picture {
        let columns: Vec<_> =
            vectors.col_iter().take(DRAWN).map(|v| v.iter().copied().collect()).collect();
        let titles: Vec<_> = pairs.values.iter().map(|value| format!("{value:.4}")).collect();
        let panel = |(values, title)| {
            (&file.mesh, Paint::Values(Vec::as_slice(values)), String::as_str(title))
        };
        let panels: Vec<_> = columns.iter().zip(&titles).map(panel).collect();
        args.picture.draw(picture, &panels)?;
    }
    let Some(output) = output else { return Ok(()) };
    let path = output.path().display().to_string();
    let arrays = [
        ("eigenvalues", Array::Vector(&pairs.values)),
        ("eigenvectors", Array::Matrix(vectors.as_ref())),
        ("residuals", Array::Vector(&pairs.residuals)),
    ];
    write_arrays(output, &arrays)?;
    report(format_args!("written     {path}"))
}

/// Eigenvalues in the table.
const SHOWN: usize = 10;

/// Eigenfunctions in the picture.
const DRAWN: usize = 4;

/// Starts the output, whose name says what it is.
fn create(path: &Path, overwrite: Overwrite) -> Result<Output> {
    check_arrays_name(path)?;
    if overwrite == Overwrite::Never && path.symlink_metadata().is_ok() {
        bail!("{}: exists already (--force replaces it)", path.display());
    }
    Ok(Output::create(path, overwrite)?)
}
