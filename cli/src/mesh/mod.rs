//! `catamaran mesh`.

mod report;

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use catamaran::mesh::io::{self as files, MeshFile};
use catamaran::mesh::{
    Components, Normalization, Part, RepairOptions, RepairReport, RepairStep, TriMesh, Weld, repair,
};
use clap::ValueEnum;

use crate::common::Force;
use crate::input;
use crate::output;
use crate::parse;
use crate::picture::{PLAIN, Paint, PictureArgs};
use crate::report::{seconds, status};
pub use report::genus;

/// Report on a triangle mesh, and convert, repair or compare it.
///
/// Reads .obj, .ply, .off, .stl, .glb and .gltf, each also as .gz or .xz. Says what it is made of
/// (components, boundary, genus), how large it is, and every kind of problem with the first
/// elements that have it, numbered from 0.
///
/// Nothing is repaired unless asked. The steps of a repair are done in this order, whatever the
/// order of the options: weld, drop duplicates, drop degenerate, compact, cut (of --repair), keep
/// largest, fill holes, orient. Each says what it did, and the report on the result follows. Then
/// come --component and --normalize.
#[derive(clap::Args)]
pub struct Args {
    /// The mesh.
    #[arg(value_name = "MESH")]
    input: PathBuf,
    /// Write the mesh: .obj, .ply, .off, .stl, .glb or .gltf, and .gz after it.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Keep one component only: a number from 0, in the order of their lowest vertices, or
    /// `largest` (most faces).
    #[arg(long, value_name = "NUMBER", value_parser = component, requires = "output")]
    component: Option<Which>,
    /// Repair everything but holes: --weld seams, --drop-duplicates, --drop-degenerate, --compact,
    /// cuts along edges of more than two faces and where the surface meets itself in a point,
    /// --orient.
    #[arg(long)]
    repair: bool,
    /// Join vertices at most TOLERANCE apart, a length; with equal positions where no TOLERANCE is
    /// given; `seams`: with equal positions along boundary edges that are in one place, two and
    /// two, so that what only touches stays apart. Texture coordinates and normals that differ
    /// become those of corners.
    #[arg(long, value_name = "TOLERANCE", num_args = 0..=1, default_missing_value = "0",
          value_parser = parse::weld)]
    weld: Option<Weld>,
    /// Drop faces with the vertices of an earlier one, in any order.
    #[arg(long)]
    drop_duplicates: bool,
    /// Remove faces without area, without opening the surface: two corners in one place are joined,
    /// a corner on the opposite edge becomes a vertex of the face beyond it. What can't be removed
    /// so is dropped.
    #[arg(long)]
    drop_degenerate: bool,
    /// Drop vertices that no face has.
    #[arg(long)]
    compact: bool,
    /// Keep the N components with the most faces.
    #[arg(long, value_name = "N", conflicts_with = "component")]
    keep_largest: Option<usize>,
    /// Leave out components with less than this share of the area, from 0 to 1.
    #[arg(long, value_name = "SHARE", conflicts_with = "component")]
    drop_specks: Option<f64>,
    /// Fill holes: boundary loops of at most N edges.
    #[arg(long, value_name = "N")]
    fill_holes: Option<usize>,
    /// Flip faces until all agree on what is outside. Closed components are counter-clockwise as
    /// seen from outside, but those in an odd number of others bound cavities. Of open ones, as few
    /// faces as possible are flipped.
    #[arg(long)]
    orient: bool,
    /// Compare with another mesh: distances both ways, areas, angles between normals, topology.
    #[arg(long, value_name = "OTHER")]
    compare: Option<PathBuf>,
    /// Move to the origin and scale: to a total area of 1, or to a longest side of the bounding box
    /// of 1.
    #[arg(long, value_name = "SIZE", requires = "output")]
    normalize: Option<Size>,
    #[command(flatten)]
    picture: PictureArgs,
    /// Fail when there is a problem; after repairs, if any are asked for.
    #[arg(long)]
    check: bool,
    #[command(flatten)]
    force: Force,
}

/// A component.
#[derive(Debug, Clone, Copy)]
enum Which {
    Largest,
    Number(usize),
}

fn component(text: &str) -> Result<Which, String> {
    match text {
        "largest" => Ok(Which::Largest),
        _ => text.parse().map(Which::Number).map_err(|_| "not a number, and not `largest`".into()),
    }
}

/// What becomes 1.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Size {
    Area,
    Box,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let output = match &args.output {
        Some(path) => {
            files::check_name(path)?;
            Some(args.force.create(path)?)
        }
        None => None,
    };

    let picture = args.picture.create(args.force)?;
    let start = Instant::now();
    let mut file = input::mesh(&args.input)?;
    let name = args.input.display();
    let (path, time) = (name.to_string(), start.elapsed());
    status!(
        "mesh",
        path = path,
        seconds = time.as_secs_f64();
        "{path}, read in {}",
        seconds(time)
    )?;
    let mut found = file.mesh.validate();
    report::validation(&found)?;
    report::measures(&file, &found)?;

    if let Some(options) = args.repairs() {
        let done = repair(file, &options).with_context(|| name.to_string())?;
        if !args.repair {
            require_orientable(&done.report).with_context(|| name.to_string())?;
        }
        file = done.file;
        done.report.steps.iter().try_for_each(report::repair)?;
        if done.report.changed() {
            found = file.mesh.validate();
            status!("repaired", path = path; "{path}")?;
            report::validation(&found)?;
            report::measures(&file, &found)?;
        }
    }
    if args.check && !found.problems.is_empty() {
        bail!("{name}: problems found: {}", found.problems.len());
    }
    let file = changed(args, file).with_context(|| name.to_string())?;
    if let Some(other) = &args.compare {
        report::compare(&file.mesh, &found, other).with_context(|| name.to_string())?;
    }
    if let Some(picture) = picture {
        let screen = |color: &[f64; 4]| [0, 1, 2].map(|k| (255.0 * color[k].clamp(0.0, 1.0)) as u8);
        let colors =
            file.colors.as_ref().map(|colors| colors.iter().map(screen).collect::<Vec<_>>());
        let paint = colors.as_deref().map_or(PLAIN, Paint::Colors);
        args.picture.draw(picture, &args.input, &[(&file.mesh, paint, "")])?;
    }
    let Some(output) = output else { return Ok(()) };
    let path = output.path().display().to_string();
    output::mesh(output, &file)?;
    let (vertices, faces) = (file.mesh.vertices().len(), file.mesh.faces().len());
    status!(
        "written",
        path = path,
        vertices = vertices,
        faces = faces;
        "{path}: {vertices} vertices, {faces} faces"
    )
}

impl Args {
    /// The repairs that are asked for.
    fn repairs(&self) -> Option<RepairOptions> {
        let mut options =
            if self.repair { RepairOptions::everything() } else { RepairOptions::new() };
        if let Some(weld) = self.weld {
            options.weld = weld;
        }
        options.drop_duplicates |= self.drop_duplicates;
        options.drop_degenerate |= self.drop_degenerate;
        options.compact |= self.compact;
        options.orient |= self.orient;
        options.keep_largest = self.keep_largest;
        options.drop_specks = self.drop_specks;
        options.fill_holes = self.fill_holes;
        (options != RepairOptions::new()).then_some(options)
    }
}

/// What is not orientable can't be what `--orient` asks for.
fn require_orientable(done: &RepairReport) -> Result<()> {
    for step in &done.steps {
        if let RepairStep::Oriented { edge: Some([a, b]), .. } = step {
            bail!("edge {a}-{b}: its faces can't be turned to agree: not orientable");
        }
    }
    Ok(())
}

/// The mesh as it is to be written.
fn changed(args: &Args, mut file: MeshFile) -> Result<MeshFile> {
    if let Some(which) = args.component {
        file = file.part(one_component(&file.mesh, which)?)?;
    }
    if let Some(size) = args.normalize {
        file.mesh = file.mesh.normalized(match size {
            Size::Area => Normalization::UnitArea,
            Size::Box => Normalization::UnitBox,
        })?;
    }
    Ok(file)
}

fn one_component(mesh: &TriMesh, which: Which) -> Result<Part> {
    let components = Components::new(mesh);
    let number = match which {
        Which::Number(number) => number,
        Which::Largest => components.largest().context("no component, as there is no face")?,
    };
    Ok(mesh.component(&components, number)?)
}
