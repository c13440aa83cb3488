//! `catamaran filter`.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use catamaran::io::{self as files, Output, Overwrite};
use catamaran::mesh::io::MeshFile;
use catamaran::mesh::{Components, TriMesh};
use catamaran::spectral::test_functions::coordinates;
use catamaran::spectral::{
    Basis, Orthogonalization, ProductBasis, ProductBasisOptions, Response, dirichlet_energies,
    filter,
};
use clap::ArgGroup;

use crate::output;
use crate::picture::{PLAIN, Paint, PictureArgs, first_column};
use crate::progress::Bar;
use crate::report::{complain, report};
use crate::shape::{self, LaplacianArgs, Shape};

/// Frequencies up to this share of the highest are zero: those of constants, and rounding.
const ZERO: f64 = 1e-9;

/// A component that is smaller than this share of what it was is a point, but for rounding.
const POINT: f64 = 1e-9;

/// Filter the shape of a mesh, or functions on it, by frequencies.
///
/// Frequencies are eigenvalues, or the Dirichlet energies of orthogonalised products of
/// eigenfunctions; they are counted in ascending order, from the constant, number 0. On a mesh of
/// several components the functions that are constant on each are number 0 all together, so that
/// what keeps it leaves every component in its place.
#[derive(clap::Args)]
#[command(group = ArgGroup::new("response").args(["low_pass", "high_pass", "band", "heat", "sharpen"]).required(true))]
pub struct Args {
    /// The mesh: .obj, .ply, .off, .stl, .glb or .gltf, and .gz after it.
    #[arg(value_name = "MESH")]
    mesh: PathBuf,
    /// Keep the first COUNT frequencies and nothing else.
    #[arg(long, value_name = "COUNT")]
    low_pass: Option<usize>,
    /// Take the first COUNT frequencies away.
    #[arg(long, value_name = "COUNT")]
    high_pass: Option<usize>,
    /// Keep the frequencies from number FIRST (from 0) to before number END.
    #[arg(long, value_name = "FIRST..END", value_parser = crate::parse::columns)]
    band: Option<std::ops::Range<usize>>,
    /// Smooth as heat does in the time T, as a part of the area.
    #[arg(long, value_name = "T")]
    heat: Option<f64>,
    /// Add what heat takes away in the time T, as a part of the area.
    #[arg(long, value_name = "T")]
    sharpen: Option<f64>,
    /// How many times --sharpen adds it.
    #[arg(long, value_name = "A", default_value_t = 1.0, requires = "sharpen")]
    amount: f64,
    /// Eigenfunctions, the constant one not counted.
    #[arg(short, value_name = "K", default_value_t = 100)]
    k: usize,
    /// Most factors of a product; 1 filters by eigenfunctions alone.
    #[arg(long, value_name = "N", default_value_t = 1)]
    order: usize,
    /// Filter these functions, in columns, a row for each vertex, instead of the coordinates.
    #[arg(long, value_name = "F")]
    functions: Option<PathBuf>,
    #[command(flatten)]
    laplacian: LaplacianArgs,
    /// Where the mesh goes (.obj, .ply, .off, .stl), or the functions (.npy, .csv, ...).
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    picture: PictureArgs,
    /// Replace a file that exists.
    #[arg(long)]
    force: bool,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let overwrite = if args.force { Overwrite::Replace } else { Overwrite::Never };
    if args.functions.is_some() {
        files::check_name(&args.output)?;
    }
    let output = Output::create(&args.output, overwrite)?;
    let picture = args.picture.create(overwrite)?;
    let shape = args.laplacian.shape(&args.mesh, args.k.saturating_add(1))?;
    let f = match &args.functions {
        Some(path) => shape::functions(path, shape.eigenbasis.basis().vertices())?,
        None => coordinates(&shape.file.mesh),
    };
    let par = args.laplacian.par();
    let g = if args.order <= 1 {
        let basis = shape.eigenbasis.basis();
        let (gains, rest) = gains(args, &shape, shape.eigenbasis.values())?;
        filter(basis, f.as_ref(), &gains, rest, par)?
    } else {
        let (basis, energies) = products(args, &shape)?;
        let (gains, rest) = gains(args, &shape, &energies)?;
        filter(&basis, f.as_ref(), &gains, rest, par)?
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
        let moved = moved(shape.file, &g, &path)?;
        note_points(&before, &moved.mesh);
        if let Some(picture) = picture {
            let panels = [(&before, PLAIN, "before"), (&moved.mesh, PLAIN, "after")];
            args.picture.draw(picture, &args.mesh, &panels)?;
        }
        output::mesh(output, &moved)?;
    }
    report(format_args!("written   {}", path.display()))
}

/// The orthogonal basis of products, and its frequencies.
fn products(args: &Args, shape: &Shape) -> Result<(Basis, Vec<f64>)> {
    let bar = Bar::new("products");
    let update = |fraction| bar.update(fraction);
    let options = ProductBasisOptions::new()
        .orthogonalization(Orthogonalization::Reorthogonalized)
        .par(args.laplacian.par())
        .progress(&update);
    let basis = ProductBasis::new(&shape.eigenbasis, args.order, &options)?;
    drop(bar);
    report(format_args!(
        "basis     {} functions of {} products",
        basis.len(),
        basis.products().len()
    ))?;
    let mass = shape.eigenbasis.basis().mass();
    let energies = dirichlet_energies(basis.functions(), shape.stiffness.view(), mass)?;
    Ok((basis.into_basis(), energies))
}

/// A gain for each function, and that for what is beyond them.
fn gains(args: &Args, shape: &Shape, frequencies: &[f64]) -> Result<(Vec<f64>, f64)> {
    let mut ascending: Vec<usize> = (0..frequencies.len()).collect();
    ascending.sort_by(|&a, &b| frequencies[a].total_cmp(&frequencies[b]));
    let highest = ascending.last().map_or(0.0, |&function| frequencies[function]);
    let constants =
        ascending.iter().filter(|&&function| frequencies[function] <= ZERO * highest).count();
    let mut rank = vec![0; frequencies.len()];
    for (place, &function) in ascending.iter().enumerate() {
        rank[function] = (place + 1).saturating_sub(constants.max(1));
    }
    let in_band = |band: std::ops::Range<usize>, inside: f64| {
        let gain = |place: &usize| if band.contains(place) { inside } else { 1.0 - inside };
        (rank.iter().map(gain).collect(), 1.0 - inside)
    };
    if let Some(count) = args.low_pass {
        return Ok(in_band(0..count, 1.0));
    }
    if let Some(count) = args.high_pass {
        return Ok(in_band(0..count, 0.0));
    }
    if let Some(band) = &args.band {
        return Ok(in_band(band.clone(), 1.0));
    }
    let time = args.heat.or(args.sharpen).unwrap_or_default();
    if !(time.is_finite() && time >= 0.0 && args.amount.is_finite()) {
        bail!(
            "--heat and --sharpen need a time that is finite and at least 0, and a finite amount"
        );
    }
    let time = time * shape.eigenbasis.basis().area()?;
    let response = match args.heat {
        Some(_) => Response::Heat(time),
        None => Response::Sharpen { time, amount: args.amount },
    };
    Ok((frequencies.iter().map(|&f| response.gain(f)).collect(), response.limit()))
}

/// Says how many components of the mesh are no more than points now: none of their own frequencies
/// was kept.
fn note_points(before: &TriMesh, after: &TriMesh) {
    let components = Components::new(before);
    let [was, is] = [before, after].map(|mesh| sizes(mesh, &components));
    let points = was.iter().zip(&is).filter(|(was, is)| **is < POINT * **was).count();
    if points > 0 {
        complain(format_args!(
            "note: {points} of {} components are points now, as none of their own frequencies is \
             kept",
            components.len()
        ));
    }
}

/// The longest side of the box of each component.
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

/// The mesh with its vertices moved; normals, which no longer fit, are left out.
fn moved(file: MeshFile, positions: &catamaran::faer::Mat<f64>, path: &Path) -> Result<MeshFile> {
    if let Some(vertex) =
        (0..positions.nrows()).find(|&i| (0..3).any(|c| !positions[(i, c)].is_finite()))
    {
        bail!("{}: vertex {vertex} would not be finite", path.display());
    }
    let (_, faces) = file.mesh.into_parts();
    let vertices = (0..positions.nrows()).map(|i| [0, 1, 2].map(|c| positions[(i, c)])).collect();
    let mut moved = MeshFile::from(TriMesh::new(vertices, faces)?);
    moved.uv = file.uv;
    moved.colors = file.colors;
    Ok(moved)
}
