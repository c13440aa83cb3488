//! `catamaran shapedna`.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use catamaran::faer::Mat;
use catamaran::io::{self, Output};
use catamaran_geometry::mesh::{Boundary, LaplacianOptions, io::read_with};
use catamaran_geometry::unions::{ShapeDnaOptions, retrieve, shape_dna};

use crate::common::Force;
use crate::input;
use crate::pieces::Pieces;
use crate::progress::Bar;
use crate::report::{head, row, status};
use crate::shape::{LaplacianArgs, MassArgs};

/// Compare triangle meshes by their spectra (ShapeDNA).
///
/// The comparison depends neither on the pose nor on the triangulation.
/// The signature of a mesh is its first eigenvalues. For each mesh the command lists the other
/// meshes, the nearest first, with the Euclidean distance of the signatures.
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
    /// in the same formats.
    #[arg(long, value_name = "FILE")]
    distances: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    if args.nearest == 0 && args.signatures.is_none() && args.distances.is_none() {
        bail!("--nearest 0: lists nothing, which is for --signatures and --distances only");
    }
    let signatures = create(args.signatures.as_deref(), args.force)?;
    let distances = create(args.distances.as_deref(), args.force)?;
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
    for (i, name) in names.iter().enumerate() {
        let file = read_with(name, &input::source())?;
        input::accept(&file, name)?;
        let mesh = args.laplacian.repair.apply(file, name)?.mesh;
        let pieces = Pieces::new(&mesh, name, &args.laplacian.repair, &options.laplacian.boundary)?;
        pieces.check_signature(args.k)?;
        pieces.note();
        found.push(shape_dna(&mesh, &options).with_context(|| name.display().to_string())?);
        bar.step((i + 1) as f64 / names.len() as f64)?;
    }
    drop(bar);

    let asked = if args.query.is_some() { 1 } else { names.len() };
    for (i, name) in names.iter().enumerate().take(asked) {
        head(format_args!("{}", name.display()))?;
        // One more than requested: the mesh itself.
        let nearest = retrieve(&found[i], &found, args.nearest.saturating_add(1), par)?;
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
            for other in retrieve(&found[i], &found, count, par)? {
                table[(i, other.index)] = other.distance;
            }
        }
        written(output, &table)?;
    }
    Ok(())
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
