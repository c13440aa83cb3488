//! `catamaran basis`.

use std::path::{Path, PathBuf};

use anyhow::{Result, anyhow};
use catamaran::Error;
use catamaran::io::{Array, write_arrays};
use catamaran::sparse::Mass;
use catamaran_geometry::spectral::{ProductBasis, ProductBasisOptions};

use crate::common::Force;
use crate::defaults::variant;
use crate::output;
use crate::parse::at_least_one;
use crate::pieces::Need;
use crate::progress::Bar;
use crate::report::status;
use crate::shape::{LaplacianArgs, Mode};

/// Compute a basis of functions on a mesh from products of its eigenfunctions.
///
/// The products of the first eigenfunctions are orthogonalized.
///
/// Writes the arrays `functions` (a row for each vertex, a column for each function of the basis),
/// `r` (the coefficients of every product in the basis), `kept` (for each function, the index of
/// the product that it comes from), `factors` (for every product, the numbers of its eigenfunctions
/// from 1, filled up with 0), `eigenvalues` and `mass`.
#[derive(clap::Args)]
pub struct Args {
    #[arg(value_name = "MESH", help = crate::input::mesh_help("The mesh"))]
    mesh: PathBuf,
    /// Number of eigenfunctions to multiply, without the constant one.
    #[arg(short, value_name = "K", default_value_t = 30, value_parser = at_least_one)]
    k: usize,
    /// Largest number of factors in a product.
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = at_least_one)]
    order: usize,
    /// How products are orthogonalized.
    #[arg(
        value_enum,
        long,
        value_name = "MODE",
        default_value_t = variant(ProductBasisOptions::default().orthogonalization)
    )]
    mode: Mode,
    #[command(flatten)]
    laplacian: LaplacianArgs,
    /// Output file of the basis: .npz, or .h5 where HDF5 is built in.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    force: Force,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let output = output::arrays(&args.output, args.force)?;
    let need = Need { option: "-k", len: args.k.saturating_add(1), positive: 0 };
    let prepared = args.laplacian.prepare(&args.mesh, &[need])?;
    prepared.products(args.k, args.order)?;
    let shape = prepared.solve()?;
    let bar = Bar::new("products");
    let update = |fraction| bar.update(fraction);
    let options = ProductBasisOptions::new()
        .orthogonalization(args.mode.into())
        .par(args.laplacian.par())
        .progress(&update);
    let basis = ProductBasis::new(&shape.eigenbasis, args.order, &options)
        .map_err(|error| refused(error, &args.mesh))?;
    drop(bar);
    let products = basis.products();
    let count = products.len();
    status!(
        "basis",
        functions = basis.len(),
        products = count;
        "{} functions of {count} products",
        basis.len()
    )?;
    let factors = catamaran::faer::Mat::from_fn(count, args.order, |i, place| {
        products.factors(i).and_then(|factors| factors.get(place).copied()).unwrap_or(0) as f64
    });
    let mass = match shape.eigenbasis.basis().mass() {
        Mass::Lumped(mass) => mass.clone(),
        Mass::Full(mass) => mass.diag().to_dense().to_vec(),
    };
    let arrays = [
        ("functions", Array::Matrix(basis.functions())),
        ("r", Array::Matrix(basis.r())),
        ("kept", Array::Indices(basis.kept())),
        ("factors", Array::Matrix(factors.as_ref())),
        ("eigenvalues", Array::Vector(shape.eigenbasis.values())),
        ("mass", Array::Vector(&mass)),
    ];
    let path = output.path().display().to_string();
    write_arrays(output, &arrays)?;
    status!("written", path = path; "{path}")
}

/// Adds to an error about products of eigenfunctions the name of the mesh and, where the products
/// depend on each other, the option that helps.
pub fn refused(error: Error, mesh: &Path) -> anyhow::Error {
    let mesh = mesh.display();
    match error {
        Error::Argument { what: "orthogonalization", why } => {
            anyhow!("{mesh}: --mode: {why}; --mode rank-revealing leaves none")
        }
        error => anyhow::Error::from(error).context(mesh.to_string()),
    }
}
