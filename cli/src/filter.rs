//! `catamaran filter`.

use std::ops::Range;
use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use catamaran::Par;
use catamaran::faer::Mat;
use catamaran::io as files;
use catamaran_geometry::mesh::io as meshes;
use catamaran_geometry::mesh::{Components, TriMesh};
use catamaran_geometry::spectral::coordinates;
use catamaran_geometry::spectral::{
    Basis, Orthogonalization, ProductBasis, ProductBasisOptions, Response, add_coefficient,
    dirichlet_energies, filter,
};
use clap::ArgGroup;

use crate::common::Force;
use crate::defaults::stated;
use crate::output;
use crate::parse::{at_least_one, at_least_zero, finite};
use crate::picture::{PLAIN, Paint, PictureArgs, first_column};
use crate::pieces::Need;
use crate::progress::Bar;
use crate::report::{note, status};
use crate::shape::{self, LaplacianArgs, Shape};
use crate::tables::TableArgs;

/// Returns the help of --output.
fn output_help() -> String {
    let formats = meshes::MeshFormat::writable();
    format!("Output file: the mesh ({formats}), or with --functions a table (.npy, .csv, ...)")
}

/// Frequencies up to this share of the highest count as zero: rounding leaves those of constants
/// there.
const ZERO: f64 = 1e-9;

/// The default of --amount.
const AMOUNT: f64 = 1.0;

/// The default of --share.
const SHARE: f64 = 0.1;

/// A component that is smaller than this share of its former size is a point, up to rounding.
const POINT: f64 = 1e-9;

/// Filter the shape of a mesh, or functions on it, by frequencies.
///
/// Frequencies are eigenvalues, or the Dirichlet energies of orthogonalized products of
/// eigenfunctions (--order). They are numbered in ascending order, and the constant function has
/// number 0. On a mesh with several components all functions that are constant on each component
/// have number 0, so that a filter that keeps number 0 leaves every component in its place.
#[derive(clap::Args)]
#[command(group = ArgGroup::new("response").args(["low_pass", "high_pass", "band", "heat", "sharpen", "coefficient"]).required(true))]
pub struct Args {
    #[arg(value_name = "MESH", help = crate::input::mesh_help("The mesh"))]
    mesh: PathBuf,
    /// Keep the first COUNT frequencies only, at least 1.
    #[arg(long, value_name = "COUNT", value_parser = at_least_one)]
    low_pass: Option<usize>,
    /// Remove the first COUNT frequencies.
    #[arg(long, value_name = "COUNT")]
    high_pass: Option<usize>,
    /// Keep the frequencies from number FIRST, counted from 0, up to but without number END.
    #[arg(long, value_name = "FIRST..END", value_parser = crate::parse::columns)]
    band: Option<Range<usize>>,
    /// Smooth as heat flow does in the time T, as a fraction of the surface area.
    #[arg(long, value_name = "T", value_parser = at_least_zero)]
    heat: Option<f64>,
    /// Sharpen: add what heat flow removes in the time T, as a fraction of the surface area.
    #[arg(long, value_name = "T", value_parser = at_least_zero)]
    sharpen: Option<f64>,
    #[arg(
        long,
        value_name = "A",
        value_parser = finite,
        help = stated("Factor of what --sharpen adds", AMOUNT)
    )]
    amount: Option<f64>,
    /// Change one coefficient: add a multiple of the function of frequency NUMBER, from 1, to every
    /// coordinate.
    #[arg(long, value_name = "NUMBER", value_parser = at_least_one)]
    coefficient: Option<usize>,
    #[arg(
        long,
        value_name = "SHARE",
        value_parser = finite,
        help = stated(
            "Size of the change by --coefficient, as a fraction of the root mean square of the \
             coordinates (or of the functions) about their means",
            SHARE
        )
    )]
    share: Option<f64>,
    /// Number of eigenfunctions, without the constant one.
    #[arg(short, value_name = "K", default_value_t = 100, value_parser = at_least_one)]
    k: usize,
    /// Largest number of factors in a product; 1 filters by eigenfunctions alone.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = at_least_one)]
    order: usize,
    /// Filter the functions in this table (a row for each vertex, a column for each function)
    /// instead of the coordinates; or the values of vertices in a file of VTK, GIFTI, Gmsh or
    /// FreeSurfer (.curv, .thickness and others).
    #[arg(long, value_name = "F")]
    functions: Option<PathBuf>,
    #[command(flatten)]
    table: TableArgs,
    #[command(flatten)]
    laplacian: LaplacianArgs,
    #[arg(short, long, value_name = "OUT", help = output_help())]
    output: PathBuf,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    force: Force,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    // clap does not enforce `requires` for an option of a group whose options exclude each other.
    for (option, given, needed, is_there) in [
        ("--amount", args.amount, "--sharpen", args.sharpen.is_some()),
        ("--share", args.share, "--coefficient", args.coefficient.is_some()),
    ] {
        if given.is_some() && !is_there {
            bail!("{option} is for {needed} only");
        }
    }
    match args.functions {
        Some(_) => files::check_name(&args.output)?,
        None => meshes::check_name(&args.output)?,
    }
    let output = args.force.create(&args.output)?;
    let picture = args.picture.create(args.force)?;
    let need = Need { option: "-k", len: args.k.saturating_add(1), positive: 0 };
    let prepared = args.laplacian.prepare(&args.mesh, &[need])?;
    let vertices = prepared.vertices();
    let f = match &args.functions {
        Some(path) => shape::functions(path, vertices, &args.table)?,
        None => coordinates(&prepared.file.mesh),
    };
    // Of a basis of products it is not known how many are independent.
    let (functions, constants, most) = match args.order {
        ..=1 => (args.k + 1, prepared.components, ""),
        order => (prepared.products(args.k, order)?.len().min(vertices), 1, "at most "),
    };
    check_frequencies(args, (functions, functions + 1 - constants), vertices, most)?;
    let shape = prepared.solve()?;
    let g = if args.order <= 1 {
        filtered(args, shape.eigenbasis.basis(), shape.eigenbasis.values(), &f)?
    } else {
        let (basis, energies) = products(args, &shape)?;
        filtered(args, &basis, &energies, &f)?
    };
    let path = output.path().to_owned();
    if args.functions.is_some() {
        files::write(output, g.as_ref())?;
        if let Some(picture) = picture {
            let [before, after] = [&f, &g].map(first_column);
            let mesh = &shape.file.mesh;
            let panel = |values, title| (mesh, Paint::Values(values), title);
            let panels = [panel(&before, "before"), panel(&after, "after")];
            args.picture.draw(picture, &args.mesh, &panels)?;
        }
    } else {
        let before = shape.file.mesh.clone();
        let moved = shape::moved(shape.file, &g, &path)?;
        note_points(&before, &moved.mesh);
        if let Some(picture) = picture {
            let panels = [(&before, PLAIN, "before"), (&moved.mesh, PLAIN, "after")];
            args.picture.draw(picture, &args.mesh, &panels)?;
        }
        output::mesh(output, &moved)?;
    }
    let path = path.display().to_string();
    status!("written", path = path; "{path}")
}

/// Returns the orthogonal basis of products, and its frequencies.
fn products(args: &Args, shape: &Shape) -> Result<(Basis, Vec<f64>)> {
    let bar = Bar::new("products");
    let update = |fraction| bar.update(fraction);
    let options = ProductBasisOptions::new()
        .orthogonalization(Orthogonalization::Reorthogonalized)
        .par(args.laplacian.par())
        .progress(&update);
    let basis = ProductBasis::new(&shape.eigenbasis, args.order, &options)
        .with_context(|| args.mesh.display().to_string())?;
    drop(bar);
    let (functions, products) = (basis.len(), basis.products().len());
    status!(
        "basis",
        functions = functions,
        products = products;
        "{functions} functions of {products} products"
    )?;
    let mass = shape.eigenbasis.basis().mass();
    let energies = dirichlet_energies(basis.functions(), shape.stiffness.view(), mass)?;
    Ok((basis.into_basis(), energies))
}

/// Filters the functions `f` in a basis whose functions have these frequencies.
fn filtered(args: &Args, basis: &Basis, frequencies: &[f64], f: &Mat<f64>) -> Result<Mat<f64>> {
    let numbers = numbers(frequencies);
    let Some(number) = args.coefficient else {
        let (gains, rest) = gains(args, basis, frequencies, &numbers)?;
        return Ok(filter(basis, f.as_ref(), &gains, rest, args.laplacian.par())?);
    };
    let known = known(&numbers);
    check_frequencies(args, (numbers.len(), known), basis.vertices(), "")?;
    let function = numbers.iter().position(|&n| n == number).context("no such frequency")?;
    let amount = args.share.unwrap_or(SHARE) * deviation(basis, f)?;
    Ok(add_coefficient(basis, f.as_ref(), function, amount)?)
}

/// Refuses an option with a frequency beyond those of a basis: `functions` and `known` are the
/// numbers of its functions and of their frequencies, exactly or at most, as `most` says.
fn check_frequencies(
    args: &Args,
    (functions, known): (usize, usize),
    vertices: usize,
    most: &str,
) -> Result<()> {
    if let Some(number) = args.coefficient.filter(|number| *number >= known) {
        bail!("--coefficient {number}: the last frequency is {most}number {}", known - 1);
    }
    // All frequencies of the mesh are as many as there can be.
    match args.band() {
        Some((option, band)) if band.end > known && functions < vertices => {
            // Several components have several constant functions.
            let need = match args.order {
                ..=1 => format!("-k {} or more", functions - 1 + band.end - known),
                _ => "a larger -k or --order".into(),
            };
            bail!("{option}: {most}{known} frequencies are computed; {need} is needed")
        }
        _ => Ok(()),
    }
}

/// Returns how many frequencies there are, given the number of that of each function.
fn known(numbers: &[usize]) -> usize {
    numbers.iter().max().map_or(0, |last| last + 1)
}

impl Args {
    /// Returns the frequencies that an option names, and the option.
    fn band(&self) -> Option<(&'static str, Range<usize>)> {
        let low = self.low_pass.map(|count| ("--low-pass", 0..count));
        let high = || self.high_pass.map(|count| ("--high-pass", 0..count));
        low.or_else(high).or_else(|| Some(("--band", self.band.clone()?)))
    }
}

/// Returns the norm of the columns of `f` without their means: the root of its mean square over the
/// columns.
fn deviation(basis: &Basis, f: &Mat<f64>) -> Result<f64> {
    let (mass, par) = (basis.mass(), Par::Seq);
    let mut weighted = Mat::zeros(f.nrows(), f.ncols());
    mass.multiply(f.as_ref(), weighted.as_mut(), par)?;
    let area = basis.area()?;
    let square = |j: usize| {
        let mean = weighted.col(j).iter().sum::<f64>() / area;
        let square: f64 = f.col(j).transpose() * weighted.col(j);
        (square - area * mean * mean).max(0.0)
    };
    let squares: f64 = (0..f.ncols()).map(square).sum();
    Ok((squares / f.ncols().max(1) as f64).sqrt())
}

/// Numbers the frequencies of the functions, ascending from 0; all frequencies that are zero have
/// number 0.
fn numbers(frequencies: &[f64]) -> Vec<usize> {
    let mut ascending: Vec<usize> = (0..frequencies.len()).collect();
    ascending.sort_by(|&a, &b| frequencies[a].total_cmp(&frequencies[b]));
    let highest = ascending.last().map_or(0.0, |&function| frequencies[function]);
    let constants =
        ascending.iter().filter(|&&function| frequencies[function] <= ZERO * highest).count();
    let mut numbers = vec![0; frequencies.len()];
    for (place, &function) in ascending.iter().enumerate() {
        numbers[function] = (place + 1).saturating_sub(constants.max(1));
    }
    numbers
}

/// Returns a gain for each function, and the gain for what is outside of the basis.
fn gains(
    args: &Args,
    basis: &Basis,
    frequencies: &[f64],
    numbers: &[usize],
) -> Result<(Vec<f64>, f64)> {
    if let Some((_, band)) = args.band() {
        check_frequencies(args, (numbers.len(), known(numbers)), basis.vertices(), "")?;
        let inside = if args.high_pass.is_some() { 0.0 } else { 1.0 };
        let gain = |number: &usize| if band.contains(number) { inside } else { 1.0 - inside };
        return Ok((numbers.iter().map(gain).collect(), 1.0 - inside));
    }
    let amount = args.amount.unwrap_or(AMOUNT);
    let time = args.heat.or(args.sharpen).unwrap_or_default() * basis.area()?;
    let response = match args.heat {
        Some(_) => Response::Heat(time),
        None => Response::Sharpen { time, amount },
    };
    Ok((frequencies.iter().map(|&f| response.gain(f)).collect(), response.limit()))
}

/// Notes how many components of the mesh have become points, because none of their own frequencies
/// was kept.
fn note_points(before: &TriMesh, after: &TriMesh) {
    let components = Components::new(before);
    let [was, is] = [before, after].map(|mesh| sizes(mesh, &components));
    let points = was.iter().zip(&is).filter(|(was, is)| **is < POINT * **was).count();
    if points > 0 {
        note(format_args!(
            "{points} of {} components are points now, as none of their own frequencies is \
             kept",
            components.len()
        ));
    }
}

/// Returns the longest side of the bounding box of each component.
fn sizes(mesh: &TriMesh, components: &Components) -> Vec<f64> {
    let mut boxes = vec![[[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]]; components.len()];
    for (p, &component) in mesh.vertices().iter().zip(components.of_vertices()) {
        let Some([low, high]) = boxes.get_mut(component as usize) else { continue };
        for k in 0..3 {
            (low[k], high[k]) = (low[k].min(p[k]), high[k].max(p[k]));
        }
    }
    boxes.iter().map(|[low, high]| (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max)).collect()
}
