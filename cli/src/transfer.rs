//! `catamaran transfer`.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use catamaran::Par;
use catamaran::base::Progress;
use catamaran::faer::{Mat, Scale};
use catamaran::io::{self as files, Output, Overwrite};
use catamaran::spectral::descriptors::{wave_kernel_signature, wave_scales};
use catamaran::spectral::functional_map::{
    MapFit, icp, map_from_points, points_from_map, pull_back, zoomout,
};
use catamaran::spectral::{
    Eigenbasis, Orthogonalization, ProductBasis, ProductBasisOptions, Transfer, relative_errors,
};
use clap::{ArgGroup, ValueEnum};

use crate::picture::{Paint, PictureArgs, first_column};
use crate::progress::Bar;
use crate::report::report;
use crate::shape::{self, LaplacianArgs, Mode, Shape, column};

/// Iterations of ICP, at most.
const ITERATIONS: usize = 20;

/// Wave kernel signatures that help landmarks.
const SIGNATURES: usize = 50;

/// Transfer functions from one mesh to another, through orthogonalised products of eigenfunctions.
///
/// Which vertices correspond is given, or found from a few landmarks: by a functional map that fits them and wave kernel
/// signatures, refined, and the vertices nearest under it.
#[derive(clap::Args)]
#[command(group = ArgGroup::new("correspondence").args(["identity", "points", "landmarks"]).required(true))]
pub struct Args {
    /// The mesh that the functions are on: .obj, .ply, .off, .stl, .glb or .gltf, and .gz after it.
    #[arg(value_name = "SOURCE")]
    source: PathBuf,
    /// The mesh that they go to.
    #[arg(value_name = "TARGET")]
    target: PathBuf,
    /// The functions, in columns, a row for each vertex of the source: .npy, .csv, .txt, ...
    #[arg(long, value_name = "F")]
    functions: PathBuf,
    /// Vertices of the same number correspond.
    #[arg(long)]
    identity: bool,
    /// The corresponding vertex of the source, from 0, for each vertex of the target: a file with one column.
    #[arg(long, value_name = "FILE")]
    points: Option<PathBuf>,
    /// Corresponding vertices, from 0: a file with two columns, source and target.
    #[arg(long, value_name = "FILE")]
    landmarks: Option<PathBuf>,
    /// How the functional map of landmarks is refined.
    #[arg(long, value_name = "HOW", default_value = "zoomout")]
    refine: Refine,
    /// Eigenfunctions that refinement by zoomout ends with.
    #[arg(long, value_name = "K", default_value_t = 100)]
    zoom: usize,
    /// Eigenfunctions of the source that are multiplied, the constant one not counted.
    #[arg(short, value_name = "K", default_value_t = 30)]
    k: usize,
    /// The same on the target; as on the source by default.
    #[arg(long, value_name = "K")]
    target_k: Option<usize>,
    /// Most factors of a product; 1 transfers through eigenfunctions alone.
    #[arg(long, value_name = "N", default_value_t = 2)]
    order: usize,
    /// How products are orthogonalised.
    #[arg(long, value_name = "MODE", default_value = "single-pass")]
    mode: Mode,
    #[command(flatten)]
    laplacian: LaplacianArgs,
    /// Where the functions on the target go: .npy, .csv, .tsv, .txt or .mtx, and .gz after it.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Where the correspondence that was used goes, as in --points.
    #[arg(long, value_name = "FILE")]
    points_output: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArgs,
    /// Replace files that exist.
    #[arg(long)]
    force: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Refine {
    None,
    Icp,
    Zoomout,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let overwrite = if args.force { Overwrite::Replace } else { Overwrite::Never };
    let create = |path: &Path| -> Result<Output> {
        files::check_name(path)?;
        Ok(Output::create(path, overwrite)?)
    };
    let output = create(&args.output)?;
    let points_output = args.points_output.as_deref().map(create).transpose()?;
    let picture = args.picture.create(overwrite)?;
    let par = args.laplacian.par();
    let lens = (args.k.saturating_add(1), args.target_k.unwrap_or(args.k).saturating_add(1));
    let zooms = args.landmarks.is_some() && args.refine == Refine::Zoomout;
    let more = |len: usize| if zooms { len.max(args.zoom) } else { len };
    let source = args.laplacian.shape(&args.source, more(lens.0))?;
    let target = args.laplacian.shape(&args.target, more(lens.1))?;
    // Refinement may have more of them than the transfer.
    shape::check_components(&source.file.mesh, &args.source, lens.0)?;
    shape::check_components(&target.file.mesh, &args.target, lens.1)?;
    let f = shape::functions(&args.functions, source.eigenbasis.basis().vertices())?;

    let points = correspondence(args, &source, &target, lens)?;
    let transfer_basis = |shape: &Shape, len: usize| -> Result<ProductBasis> {
        let bar = Bar::new("products");
        let update = |fraction| bar.update(fraction);
        let orthogonalization = Orthogonalization::from(args.mode);
        let options = ProductBasisOptions::new()
            .orthogonalization(orthogonalization)
            .par(par)
            .progress(&update);
        Ok(ProductBasis::new(&shape.eigenbasis.truncated(len)?, args.order, &options)?)
    };
    let from = transfer_basis(&source, lens.0)?;
    let to = transfer_basis(&target, lens.1)?;
    report(format_args!("bases     {} and {} functions", from.len(), to.len()))?;
    let map = map_from_points(&points, from.basis(), to.basis(), par)?;
    let g = Transfer::new(from.basis(), to.basis(), map)?.apply(f.as_ref(), par)?;
    let moved = pull_back(&points, f.as_ref())?;
    let errors = relative_errors(moved.as_ref(), g.as_ref(), to.basis().mass())?;
    let mean = 100.0 * errors.iter().sum::<f64>() / errors.len().max(1) as f64;
    report(format_args!(
        "transfer  {} functions, on average {mean:.2} % from those of corresponding vertices",
        errors.len()
    ))?;
    if let Some(output) = points_output {
        let path = output.path().display().to_string();
        files::write_integers(output, column(&points).as_ref())?;
        report(format_args!("written   {path}"))?;
    }
    if let Some(picture) = picture {
        let [before, after] = [&f, &g].map(first_column);
        let panels = [
            (&source.file.mesh, Paint::Values(&before), "source"),
            (&target.file.mesh, Paint::Values(&after), "target"),
        ];
        args.picture.draw(picture, &args.source, &panels)?;
    }
    write(output, &g)
}

fn write(output: Output, matrix: &Mat<f64>) -> Result<()> {
    let path = output.path().to_owned();
    files::write(output, matrix.as_ref())?;
    report(format_args!("written   {}", path.display()))
}

/// The vertex of the source for each vertex of the target.
fn correspondence(
    args: &Args,
    source: &Shape,
    target: &Shape,
    lens: (usize, usize),
) -> Result<Vec<u32>> {
    let (n, m) = (source.eigenbasis.basis().vertices(), target.eigenbasis.basis().vertices());
    if let Some(path) = &args.points {
        let points = shape::vertices(path, &[n])?;
        if points.len() != m {
            bail!("{}: {} rows for {m} vertices of the target", path.display(), points.len());
        }
        return Ok(points.concat());
    }
    let Some(path) = &args.landmarks else {
        if n != m {
            bail!("--identity needs as many vertices on both meshes, not {n} and {m}");
        }
        return Ok((0..m as u32).collect());
    };
    let pairs = shape::vertices(path, &[n, m])?;
    let pairs: Vec<(u32, u32)> = pairs.iter().map(|pair| (pair[0], pair[1])).collect();
    let par = args.laplacian.par();
    let low = (source.eigenbasis.truncated(lens.0)?, target.eigenbasis.truncated(lens.1)?);
    let mut fit = MapFit::new(&low.0, &low.1, par);
    fit.landmarks(&pairs)?;
    let [f, g] = signatures(&low.0, &low.1, par)?;
    fit.functions(f.as_ref(), g.as_ref())?;
    let c = fit.solve(MapFit::COMMUTATIVITY)?;
    let bar = Bar::new("points");
    let update = |fraction| bar.update(fraction);
    let progress = Progress::new(&update);
    Ok(match args.refine {
        Refine::None => points_from_map(c.as_ref(), low.0.basis(), low.1.basis(), par, progress)?,
        Refine::Icp => icp(c.as_ref(), &low.0, &low.1, ITERATIONS, par, progress)?.points,
        Refine::Zoomout => {
            let (source, target) = (&source.eigenbasis, &target.eigenbasis);
            zoomout(c.as_ref(), source, target, 1, par, progress)?.points
        }
    })
}

/// Wave kernel signatures of both, as on meshes of area 1.
fn signatures(source: &Eigenbasis, target: &Eigenbasis, par: Par) -> Result<[Mat<f64>; 2]> {
    let normalised = |basis: &Eigenbasis| -> Result<(Vec<f64>, Mat<f64>)> {
        let area = basis.basis().area()?;
        let values = basis.values().iter().map(|value| value * area).collect();
        Ok((values, Scale(area.sqrt()) * basis.functions()))
    };
    let (source, target) = (normalised(source)?, normalised(target)?);
    let scales = wave_scales(&source.0, SIGNATURES)?;
    let signature = |(values, vectors): &(Vec<f64>, Mat<f64>)| {
        wave_kernel_signature(values, vectors.as_ref(), &scales, par)
    };
    Ok([signature(&source)?, signature(&target)?])
}
