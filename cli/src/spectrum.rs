//! `catamaran spectrum`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use catamaran::Par;
use catamaran::base::Progress;
use catamaran::io::{Array, Output, Overwrite, write_npz};
use catamaran::mesh::io as files;
use catamaran::mesh::{Boundary, LaplacianKind, LaplacianOptions, MassKind, laplacian};
use catamaran::sparse::{EigenOptions, eigs};
use clap::ValueEnum;

use crate::progress::Bar;
use crate::report::{report, seconds};

/// Eigenvalues and eigenfunctions of the Laplacian of a triangle mesh.
///
/// The file has three arrays: `eigenvalues` (k, ascending), `eigenvectors` (vertices x k, orthonormal in the inner product
/// of the mass matrix) and `residuals` (k), |W phi - lambda M phi| / |W phi|.
#[derive(clap::Args)]
pub struct Args {
    /// The mesh: .obj, .ply, .off or .stl, each also as .gz or .xz.
    #[arg(value_name = "MESH")]
    input: PathBuf,
    /// Write the arrays to this .npz file.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Number of eigenpairs; at most as many as vertices that are not held at zero.
    #[arg(short, default_value_t = 100, value_name = "NUMBER")]
    k: usize,
    /// Those nearest to this number; the smallest unless given.
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true)]
    shift: Option<f64>,
    /// Triangles: those of the mesh, those of its intrinsic Delaunay triangulation, or of that of its tufted cover, for
    /// bad meshes.
    #[arg(long, default_value = "cotan")]
    laplacian: Kind,
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
    /// Threads; all cores unless given. Does not change the result.
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u32).range(1..))]
    threads: Option<u32>,
    /// Replace a file that exists.
    #[arg(long)]
    force: bool,
}

/// Which triangles.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Kind {
    Cotan,
    Intrinsic,
    Tufted,
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
    let output = args.output.as_deref().map(|path| create(path, args.force)).transpose()?;
    let par = args.threads.map_or_else(Par::all, |n| Par::Threads(n as usize));
    let name = args.input.display();

    let start = Instant::now();
    let bar = Bar::new("reading");
    let file = files::read_with(&args.input, Some(&|fraction| bar.update(fraction)))?;
    drop(bar);
    let options = LaplacianOptions {
        kind: match args.laplacian {
            Kind::Cotan => LaplacianKind::Cotangent,
            Kind::Intrinsic => LaplacianKind::IntrinsicDelaunay,
            Kind::Tufted => LaplacianKind::Tufted,
        },
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
    let pairs = eigs(operator.stiffness.view(), &operator.mass, &options)
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

    let Some(output) = output else { return Ok(()) };
    let vectors = operator.extend(pairs.vectors.as_ref())?;
    let path = output.path().display().to_string();
    let arrays = [
        ("eigenvalues", Array::Vector(&pairs.values)),
        ("eigenvectors", Array::Matrix(vectors.as_ref())),
        ("residuals", Array::Vector(&pairs.residuals)),
    ];
    write_npz(output, &arrays)?;
    report(format_args!("written     {path}"))
}

/// Eigenvalues in the table.
const SHOWN: usize = 10;

/// Starts the output, whose name says .npz.
fn create(path: &Path, force: bool) -> Result<Output> {
    if path.extension().is_none_or(|extension| extension != "npz") {
        bail!("{}: must be called .npz", path.display());
    }
    if !force && path.symlink_metadata().is_ok() {
        bail!("{}: exists already (--force replaces it)", path.display());
    }
    let overwrite = if force { Overwrite::Replace } else { Overwrite::Never };
    Ok(Output::create(path, overwrite)?)
}
