//! `catamaran transfer`.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use catamaran::base::Progress;
use catamaran::faer::Mat;
use catamaran::io::{self as files, Output};
use catamaran_geometry::decimate::{DecimateOptions, decimate};
use catamaran_geometry::mesh::TriMesh;
use catamaran_geometry::mesh::io::{self as meshes, MeshFile};
use catamaran_geometry::spectral::coordinates;
use catamaran_geometry::spectral::functional_map::{
    FoundMap, MapFit, icp, map_from_points, points_from_map, pull_back, search_map, zoomout,
};
use catamaran_geometry::spectral::{
    Eigenbasis, Lift, Orthogonalization, ProductBasis, ProductBasisOptions, Transfer,
    relative_errors, transfer_details,
};
use clap::{ArgGroup, ValueEnum};

use crate::basis::refused;
use crate::common::Force;
use crate::defaults::{stated, variant};
use crate::output;
use crate::parse::at_least_one;
use crate::picture::{PLAIN, Paint, PictureArgs, first_column};
use crate::pieces::Need;
use crate::progress::Bar;
use crate::report::{note, report, status};
use crate::shape::{self, LaplacianArgs, Mode, Prepared, Shape, column};
use crate::tables::TableArgs;

/// Returns the help of --output.
fn output_help() -> String {
    let formats = meshes::MeshFormat::writable();
    format!(
        "Output file: the functions on the target (.npy, .csv, .tsv, .txt or .mtx, and .gz after \
         it), or with --details the mesh ({formats})"
    )
}

/// Iterations of ICP, at most.
const ITERATIONS: usize = 20;

/// The default of --zoom.
const ZOOM: usize = 100;

/// The default of --smooth-functions.
const SMOOTH: usize = 20;

/// Landmarks that are needed to tell a shape from its turned and mirrored images.
const FEWEST: usize = 3;

/// Number of eigenfunctions that --refine zoomout adds at a time to the map of landmarks or
/// segments.
const STEP: usize = 1;

/// Transfer functions, or the shape itself, from one mesh to another.
///
/// Functions are written as sums of orthogonalized products of eigenfunctions.
///
/// The correspondence of vertices is given, or computed: a functional map is fitted to landmarks or
/// segments and to heat and wave kernel signatures; without any of these, it is searched for, among
/// maps that keep left and right. It is refined, and the vertices nearest under it correspond.
#[derive(clap::Args)]
#[command(
    group = ArgGroup::new("what").args(["functions", "details"]).required(true),
    group = ArgGroup::new("correspondence")
        .args(["identity", "points", "landmarks", "segments"])
        .multiple(true)
)]
pub struct Args {
    #[arg(value_name = "SOURCE", help = crate::input::mesh_help("Source mesh"))]
    source: PathBuf,
    /// Target mesh, in the same formats.
    #[arg(value_name = "TARGET")]
    target: PathBuf,
    /// The functions to transfer: a table (.npy, .csv, .txt, ...) with a row for each vertex of the
    /// source and a column for each function, or the values of vertices in a file of VTK, GIFTI,
    /// Gmsh or FreeSurfer (.curv, .thickness and others).
    #[arg(long, value_name = "F")]
    functions: Option<PathBuf>,
    /// Transfer the shape of the source instead of functions, and write the deformed target.
    #[arg(long, value_name = "HOW")]
    details: Option<Details>,
    #[arg(
        long,
        value_name = "K",
        help = stated(
            "Number of eigenfunctions of the smooth surface that --details heights starts from, \
             without the constant one",
            SMOOTH
        )
    )]
    smooth_functions: Option<usize>,
    /// Let vertices with the same number correspond.
    #[arg(long, conflicts_with_all = ["points", "landmarks", "segments"])]
    identity: bool,
    /// File with one column: for each vertex of the target, the number of the corresponding vertex
    /// of the source, from 0.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["landmarks", "segments"])]
    points: Option<PathBuf>,
    /// File with two columns: numbers of corresponding vertices of source and target, from 0, in
    /// three rows or more.
    #[arg(long, value_name = "FILE")]
    landmarks: Option<PathBuf>,
    /// Files with corresponding segments, with or instead of landmarks: one for the source and one
    /// for the target, each with a whole number for each vertex. Segments with the same number
    /// correspond.
    #[arg(long, value_names = ["SOURCE", "TARGET"], num_args = 2)]
    segments: Option<Vec<PathBuf>>,
    #[command(flatten)]
    table: TableArgs,
    /// Also make the functional map commute with multiplication by heat kernels around landmarks
    /// and by the indicators of segments. Slower, but needs fewer landmarks and segments.
    #[arg(long, conflicts_with_all = ["identity", "points"])]
    operators: bool,
    /// Refinement of the functional map, unless the correspondence is given.
    #[arg(
        long,
        value_name = "HOW",
        default_value = "zoomout",
        conflicts_with_all = ["identity", "points"]
    )]
    refine: Refine,
    #[arg(
        long,
        value_name = "K",
        value_parser = at_least_one,
        conflicts_with_all = ["identity", "points"],
        help = stated("Number of eigenfunctions that --refine zoomout ends with, at least -k", ZOOM)
    )]
    zoom: Option<usize>,
    /// Decimate both meshes to this number of vertices, transfer between the decimations, and
    /// interpolate: for meshes of a million vertices.
    #[arg(
        long,
        value_name = "VERTICES",
        value_parser = at_least_one,
        conflicts_with_all = ["identity", "points", "details"]
    )]
    via_decimation: Option<usize>,
    /// Number of eigenfunctions of the source to multiply, without the constant one.
    #[arg(short, value_name = "K", default_value_t = 30, value_parser = at_least_one)]
    k: usize,
    /// Number of eigenfunctions of the target to multiply, without the constant one [default: as
    /// -k].
    #[arg(long, value_name = "K", value_parser = at_least_one)]
    target_k: Option<usize>,
    /// Largest number of factors in a product; 1 transfers through eigenfunctions alone.
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
    #[arg(short, long, value_name = "OUT", help = output_help())]
    output: PathBuf,
    /// Write the correspondence to this file, in the format of --points.
    #[arg(long, value_name = "FILE")]
    points_output: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    force: Force,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Refine {
    /// No refinement: the vertices nearest under the map correspond.
    None,
    /// Alternates between nearest vertices and the orthogonal map that fits them best.
    Icp,
    /// Uses more and more eigenfunctions.
    Zoomout,
    /// Uses more and more orthogonalized products of the same few eigenfunctions, with at most
    /// --order factors.
    Products,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Details {
    /// The coordinates of the source: the target gets its shape and its pose.
    Coordinates,
    /// The heights of the source over a smooth surface: the target keeps its pose, and loses its
    /// own heights.
    Heights,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    if args.smooth_functions.is_some() && args.details != Some(Details::Heights) {
        bail!("--smooth-functions is for --details heights only");
    }
    if args.operators && args.landmarks.is_none() && args.segments.is_none() {
        bail!("--operators is for --landmarks and --segments only");
    }
    let of_bases = args.k.max(args.target_k.unwrap_or(args.k));
    if let Some(zoom) = args.zoom
        && zoom < of_bases
    {
        let option = if of_bases > args.k { "--target-k" } else { "-k" };
        bail!("--zoom {zoom}: must be at least the {of_bases} of {option}");
    }
    let create = |path: &Path| -> Result<Output> {
        files::check_name(path)?;
        args.force.create(path)
    };
    let output = match args.details {
        Some(_) => {
            meshes::check_name(&args.output)?;
            args.force.create(&args.output)?
        }
        None => create(&args.output)?,
    };
    let points_output = args.points_output.as_deref().map(create).transpose()?;
    let picture = args.picture.create(args.force)?;
    let par = args.laplacian.par();
    let lens = (args.k.saturating_add(1), args.target_k.unwrap_or(args.k).saturating_add(1));
    let of_target = if args.target_k.is_some() { "--target-k" } else { "-k" };
    let (source, from) = prepare(args, &args.source, &needs(args, "-k", lens.0))?;
    let (target, to) = prepare(args, &args.target, &needs(args, of_target, lens.1))?;
    let full = |fine: &Option<Fine>, shape: &Prepared<'_>| {
        fine.as_ref().map_or(shape.vertices(), |fine| fine.mesh.vertices().len())
    };
    let counts = [full(&from, &source), full(&to, &target)];
    source.products(lens.0 - 1, args.order)?;
    target.products(lens.1 - 1, args.order)?;
    let f = match &args.functions {
        Some(path) => shape::functions(path, counts[0], &args.table)?,
        None => coordinates(&source.file.mesh),
    };
    let known = Known::read(args, counts[0], counts[1])?.on_decimations(&from, &to);
    let coarse = from.as_ref().map(|fine| fine.lift.restrict(f.as_ref())).transpose()?;
    let f_near = coarse.as_ref().unwrap_or(&f);
    let (source, target) = (source.solve()?, target.solve()?);

    let points = correspondence(args, known, &source, &target, lens)?;
    let orthogonalization = Orthogonalization::from(args.mode);
    let bases = [
        products(args, &source, &args.source, lens.0, orthogonalization)?,
        products(args, &target, &args.target, lens.1, orthogonalization)?,
    ];
    let functions = [bases[0].len(), bases[1].len()];
    status!("bases", functions = functions; "{} and {} functions", functions[0], functions[1])?;
    let map = map_from_points(&points, bases[0].basis(), bases[1].basis(), par)?;
    let transfer = Transfer::new(bases[0].basis(), bases[1].basis(), map)?;
    let g = match args.details {
        Some(Details::Heights) => with_heights(args, &source, &target, &transfer)?,
        _ => {
            let g = transfer.apply(f_near.as_ref(), par)?;
            let moved = pull_back(&points, f_near.as_ref())?;
            let errors = relative_errors(moved.as_ref(), g.as_ref(), bases[1].basis().mass())?;
            let mean = 100.0 * errors.iter().sum::<f64>() / errors.len().max(1) as f64;
            report!(
                "transfer",
                functions = errors.len(),
                mean_error_percent = mean,
                errors_percent = errors.iter().map(|error| 100.0 * error).collect::<Vec<_>>();
                "{} functions, on average {mean:.2} % from the values at corresponding vertices",
                errors.len()
            )?;
            match &to {
                Some(fine) => fine.lift.prolong(g.as_ref())?,
                None => g,
            }
        }
    };
    if let Some(output) = points_output {
        let path = output.path().display().to_string();
        let points = match (&from, &to) {
            (None, None) => points,
            _ => lifted_points(&points, &from, &to)?,
        };
        files::write_integers(output, column(&points).as_ref())?;
        status!("written", path = path; "{path}")?;
    }
    let path = output.path().to_owned();
    match args.details {
        Some(_) => write_mesh(args, (output, picture), &source, target.file, &g)?,
        None => {
            let meshes = (
                from.as_ref().map_or(&source.file.mesh, |fine| &fine.mesh),
                to.as_ref().map_or(&target.file.mesh, |fine| &fine.mesh),
            );
            write_functions(args, (output, picture), (meshes.0, &f), (meshes.1, &g))?;
        }
    }
    let path = path.display().to_string();
    status!("written", path = path; "{path}")
}

fn write_functions(
    args: &Args,
    (output, picture): (Output, Option<Output>),
    (source, f): (&TriMesh, &Mat<f64>),
    (target, g): (&TriMesh, &Mat<f64>),
) -> Result<()> {
    if let Some(picture) = picture {
        let [before, after] = [f, g].map(first_column);
        let panels =
            [(source, Paint::Values(&before), "source"), (target, Paint::Values(&after), "target")];
        args.picture.draw(picture, &args.source, &panels)?;
    }
    Ok(files::write(output, g.as_ref())?)
}

/// Writes the target with its vertices at the given positions.
fn write_mesh(
    args: &Args,
    (output, picture): (Output, Option<Output>),
    source: &Shape,
    target: MeshFile,
    positions: &Mat<f64>,
) -> Result<()> {
    let before = target.mesh.clone();
    let moved = shape::moved(target, positions, output.path())?;
    if let Some(picture) = picture {
        let panels = [
            (&source.file.mesh, PLAIN, "source"),
            (&before, PLAIN, "target"),
            (&moved.mesh, PLAIN, "target with the details of the source"),
        ];
        args.picture.draw(picture, &args.source, &panels)?;
    }
    Ok(output::mesh(output, &moved)?)
}

/// A mesh that is represented by its decimation.
struct Fine {
    mesh: TriMesh,
    lift: Lift,
}

/// Reads a mesh; with --via-decimation, prepares its decimation, unless it has few vertices.
fn prepare<'a>(
    args: &'a Args,
    path: &'a Path,
    needs: &[Need],
) -> Result<(Prepared<'a>, Option<Fine>)> {
    let Some(n) = args.via_decimation else {
        return Ok((args.laplacian.prepare(path, needs)?, None));
    };
    let file = args.laplacian.repair.read(path)?;
    shape::has_faces(&file.mesh, path)?;
    let (vertices, named) = (file.mesh.vertices().len(), path.display().to_string());
    if vertices <= n {
        return Ok((args.laplacian.prepare_file(file, path, needs)?, None));
    }
    let bar = Bar::new("decimation");
    let update = |fraction| bar.update(fraction);
    let options = DecimateOptions::new().par(args.laplacian.par()).progress(&update);
    let found = decimate(&file.mesh, n, &options).with_context(|| named.clone())?;
    let lift =
        Lift::new(&file.mesh, &found, args.laplacian.par()).with_context(|| named.clone())?;
    drop(bar);
    status!(
        "decimation",
        path = named,
        vertices = vertices,
        to = n;
        "{named}: {vertices} vertices, represented by {n}"
    )?;
    let coarse = args.laplacian.prepare_file(found.mesh.into(), path, needs)?;
    Ok((coarse, Some(Fine { mesh: file.mesh, lift })))
}

/// Returns the vertex of the source for each vertex of the target, of meshes of which one or both
/// are represented by decimations with these points.
fn lifted_points(points: &[u32], source: &Option<Fine>, target: &Option<Fine>) -> Result<Vec<u32>> {
    let corners = source.as_ref().map(|fine| fine.lift.corners());
    let on_source = |&x: &u32| corners.as_ref().map_or(x, |corners| corners[x as usize]);
    let points: Vec<u32> = points.iter().map(on_source).collect();
    Ok(match target {
        Some(fine) => fine.lift.nearest().iter().map(|&y| points[y as usize]).collect(),
        None => points,
    })
}

/// Returns the eigenfunctions that the transfer of `len` functions, which `option` sets, needs.
fn needs(args: &Args, option: &'static str, len: usize) -> Vec<Need> {
    let is_computed = !args.identity && args.points.is_none();
    // Wave kernel signatures range between two different eigenvalues.
    let mut needs = vec![Need { option, len, positive: if is_computed { 2 } else { 0 } }];
    if is_computed && args.refine == Refine::Zoomout {
        // Refinement may use more eigenfunctions than the transfer, and uses no fewer.
        needs.push(Need { option: "--zoom", len: args.zoom.unwrap_or(ZOOM).max(len), positive: 0 });
    }
    if args.details == Some(Details::Heights) {
        needs.push(Need { option: "--smooth-functions", len: smooth(args), positive: 0 });
    }
    needs
}

/// Returns the number of eigenfunctions of the smooth surfaces of --details heights.
fn smooth(args: &Args) -> usize {
    args.smooth_functions.unwrap_or(SMOOTH).saturating_add(1)
}

/// Returns the orthogonalized products of the first `len` eigenfunctions of the mesh of a file.
fn products(
    args: &Args,
    shape: &Shape,
    path: &Path,
    len: usize,
    orthogonalization: Orthogonalization,
) -> Result<ProductBasis> {
    let bar = Bar::new("products");
    let update = |fraction| bar.update(fraction);
    let options = ProductBasisOptions::new()
        .orthogonalization(orthogonalization)
        .par(args.laplacian.par())
        .progress(&update);
    ProductBasis::new(&shape.eigenbasis.truncated(len)?, args.order, &options)
        .map_err(|error| refused(error, path))
}

/// Returns the coordinates of the target with the heights of the source over its smooth surface.
fn with_heights(
    args: &Args,
    source: &Shape,
    target: &Shape,
    transfer: &Transfer<'_>,
) -> Result<Mat<f64>> {
    let len = smooth(args);
    let smooth = (source.eigenbasis.truncated(len)?, target.eigenbasis.truncated(len)?);
    let moved = transfer_details(
        &source.file.mesh,
        &target.file.mesh,
        (smooth.0.basis(), smooth.1.basis()),
        transfer,
        args.laplacian.par(),
    )?;
    Ok(coordinates(&moved))
}

/// What is known about the correspondence.
enum Known {
    /// The vertex of the source for each vertex of the target.
    Points(Vec<u32>),
    /// Pairs of vertices of source and target, and the labels of both.
    Pairs {
        landmarks: Vec<(u32, u32)>,
        segments: Option<[Vec<u32>; 2]>,
    },
    Nothing,
}

impl Known {
    /// Reads the correspondence between meshes of `n` and `m` vertices.
    fn read(args: &Args, n: usize, m: usize) -> Result<Self> {
        if let Some(path) = &args.points {
            let points = shape::vertices(path, &[n], &args.table)?;
            if points.len() != m {
                bail!("{}: {} rows for {m} vertices of the target", path.display(), points.len());
            }
            return Ok(Self::Points(points.concat()));
        }
        if args.identity {
            if n != m {
                bail!("--identity needs meshes with equal numbers of vertices, not {n} and {m}");
            }
            return Ok(Self::Points((0..m as u32).collect()));
        }
        if args.landmarks.is_none() && args.segments.is_none() {
            return Ok(Self::Nothing);
        }
        let landmarks = match &args.landmarks {
            Some(path) => landmarks(path, shape::vertices(path, &[n, m], &args.table)?)?,
            None => Vec::new(),
        };
        let segments = match args.segments.as_deref() {
            Some([source, target]) => {
                let labels = |path, rows| shape::labels(path, rows, &args.table);
                let labels = [labels(source, n)?, labels(target, m)?];
                MapFit::common_labels(&labels[0], &labels[1])
                    .with_context(|| format!("{}, {}", source.display(), target.display()))?;
                Some(labels)
            }
            _ => None,
        };
        Ok(Self::Pairs { landmarks, segments })
    }
}

/// Returns the pairs of vertices in the rows of a file, in which each vertex has one partner.
fn landmarks(path: &Path, rows: Vec<Vec<u32>>) -> Result<Vec<(u32, u32)>> {
    for (own, other, mesh) in [(0, 1, "source"), (1, 0, "target")] {
        let mut partners = HashMap::new();
        for (row, pair) in rows.iter().enumerate() {
            let (vertex, partner) = (pair[own], pair[other]);
            let &mut (first, before) = partners.entry(vertex).or_insert((row, partner));
            if partner != before {
                bail!(
                    "{}: rows {first} and {row} (from 0): vertex {vertex} of the {mesh} has the \
                     partners {before} and {partner}",
                    path.display()
                );
            }
        }
    }
    Ok(rows.iter().map(|pair| (pair[0], pair[1])).collect())
}

impl Known {
    /// Returns what is known on the decimations of the meshes.
    fn on_decimations(self, source: &Option<Fine>, target: &Option<Fine>) -> Self {
        let near = |fine: &Option<Fine>, v: u32| {
            fine.as_ref().map_or(v, |fine| fine.lift.nearest()[v as usize])
        };
        let labels = |fine: &Option<Fine>, labels: Vec<u32>| match fine {
            Some(fine) => fine.lift.corners().iter().map(|&v| labels[v as usize]).collect(),
            None => labels,
        };
        match self {
            Self::Pairs { landmarks, segments } => Self::Pairs {
                landmarks: landmarks
                    .iter()
                    .map(|&(v, w)| (near(source, v), near(target, w)))
                    .collect(),
                segments: segments.map(|[a, b]| [labels(source, a), labels(target, b)]),
            },
            // Not together with --via-decimation.
            Self::Points(points) => Self::Points(points),
            Self::Nothing => Self::Nothing,
        }
    }
}

/// Returns the vertex of the source for each vertex of the target.
fn correspondence(
    args: &Args,
    known: Known,
    source: &Shape,
    target: &Shape,
    lens: (usize, usize),
) -> Result<Vec<u32>> {
    let par = args.laplacian.par();
    let low = (source.eigenbasis.truncated(lens.0)?, target.eigenbasis.truncated(lens.1)?);
    let bases = (low.0.basis(), low.1.basis());
    let all = (&source.eigenbasis, &target.eigenbasis);
    let (start, step) = match known {
        Known::Points(points) => return Ok(points),
        Known::Pairs { landmarks, segments } => {
            (fitted(args, &landmarks, segments, all, &low)?, STEP)
        }
        Known::Nothing => {
            let found = searched(args, source, target)?;
            match args.refine {
                Refine::Zoomout => (found.map, FoundMap::STEP),
                _ => (found.between(bases, all, par, Progress::none())?, STEP),
            }
        }
    };
    let bar = Bar::new("points");
    let update = |fraction| bar.update(fraction);
    let progress = Progress::new(&update);
    let c = start.as_ref();
    Ok(match args.refine {
        Refine::None => points_from_map(c, bases.0, bases.1, par, progress)?,
        Refine::Icp => icp(c, bases.0, bases.1, ITERATIONS, par, progress)?.points,
        Refine::Zoomout => zoomout(c, all.0.basis(), all.1.basis(), step, par, progress)?.points,
        Refine::Products => {
            let orthogonal = Orthogonalization::Reorthogonalized;
            let from = products(args, source, &args.source, lens.0, orthogonal)?;
            let to = products(args, target, &args.target, lens.1, orthogonal)?;
            let step = lens.0.max(lens.1);
            zoomout(c, from.basis(), to.basis(), step, par, progress)?.points
        }
    })
}

/// Returns the functional map between the eigenfunctions `low` that fits what is known.
fn fitted(
    args: &Args,
    pairs: &[(u32, u32)],
    segments: Option<[Vec<u32>; 2]>,
    all: (&Eigenbasis, &Eigenbasis),
    low: &(Eigenbasis, Eigenbasis),
) -> Result<Mat<f64>> {
    let bar = Bar::new("map");
    let update = |fraction| bar.update(fraction);
    let mut fit = MapFit::new(&low.0, &low.1, args.laplacian.par()).progress(&update);
    if !pairs.is_empty() {
        if segments.is_none() && pairs.len() < FEWEST {
            let landmarks = if pairs.len() == 1 { "landmark" } else { "landmarks" };
            note(format_args!(
                "{} {landmarks}, where {FEWEST} are needed to tell a shape from its turned and \
                 mirrored images: check the result, or leave out --landmarks for a search",
                pairs.len()
            ));
        }
        fit.landmarks(pairs)?;
        if args.operators {
            fit.kernels(pairs, all.0, all.1)?;
        }
    }
    if let Some(labels) = segments {
        fit.segments(&labels[0], &labels[1])?;
        if args.operators {
            let [f, g] = indicators(&labels);
            fit.operators(f.as_ref(), g.as_ref(), MapFit::MULTIPLICATIONS)?;
        }
    }
    fit.signatures(all.0, all.1).context("signatures (raise -k)")?;
    Ok(fit.solve(MapFit::COMMUTATIVITY)?)
}

/// Returns a functional map that is found without known correspondences.
fn searched(args: &Args, source: &Shape, target: &Shape) -> Result<FoundMap> {
    let bar = Bar::new("search");
    let update = |fraction| bar.update(fraction);
    let found = search_map(
        (&source.file.mesh, &source.eigenbasis),
        (&target.file.mesh, &target.eigenbasis),
        args.laplacian.par(),
        Progress::new(&update),
    )
    .context("no correspondence is known, and the search for one fails")?;
    drop(bar);
    let (defect, orientation) = (found.commutativity, found.orientation);
    let next = found.next.map(|next| format!(", next {next:.4}")).unwrap_or_default();
    report!(
        "map",
        commutativity = defect,
        next = found.next,
        orientation = orientation;
        "found by a search: commutes with the Laplacians up to {defect:.4}{next}; orientation \
         {orientation:.2}"
    )?;
    if let Some(doubt) = found.doubt() {
        note(format_args!("{doubt}: check the result, or give --landmarks"));
    }
    Ok(found)
}

/// Returns the indicators of the segments, which are on both meshes.
fn indicators(labels: &[Vec<u32>; 2]) -> [Mat<f64>; 2] {
    let mut distinct = labels[0].clone();
    distinct.sort_unstable();
    distinct.dedup();
    [0, 1].map(|side| {
        let of = &labels[side];
        Mat::from_fn(of.len(), distinct.len(), |i, j| f64::from(u8::from(of[i] == distinct[j])))
    })
}
