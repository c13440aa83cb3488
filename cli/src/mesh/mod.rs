//! `catamaran mesh`.

mod report;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, anyhow, bail};
use catamaran_geometry::mesh::io::{self as files, MeshFile, MeshFormat};
use catamaran_geometry::mesh::{
    Components, Normalization, Part, Problem, RepairOptions, RepairReport, RepairStep, TriMesh,
    Weld, repair,
};
use clap::ValueEnum;

use crate::common::{Force, as_option};
use crate::input;
use crate::output;
use crate::parse;
use crate::picture::{PLAIN, Paint, PictureArgs};
use crate::report::{seconds, status};
pub use report::genus;

/// Report on a triangle mesh, and convert, repair or compare it.
///
/// Prints the topology (components, boundary, genus), the size, and every kind of problem with the
/// first elements that have it, numbered from 0.
///
/// Nothing is repaired by default. Repairs are made in this order, whatever the order of the
/// options: weld, drop duplicates, drop degenerate, compact, cut (of --repair), keep largest, drop
/// specks, fill holes, orient. Each step reports what it did, and a report on the result follows.
/// --component and --normalize come last.
#[derive(clap::Args)]
pub struct Args {
    #[arg(value_name = "MESH", help = input::mesh_help("The mesh"))]
    input: PathBuf,
    #[arg(short, long, value_name = "FILE", help = output::mesh_help("Write the mesh"))]
    output: Option<PathBuf>,
    /// Write .stl, .ply and .vtk as text with every digit. Binary .stl has single precision, which
    /// moves vertices far from the origin.
    #[arg(long, requires = "output")]
    text: bool,
    /// Keep one component only: its number, from 0 in the order of the lowest vertices, or
    /// `largest` (most faces).
    #[arg(long, value_name = "NUMBER", value_parser = component, requires = "output")]
    component: Option<Which>,
    /// Repair everything but holes: --weld seams, --drop-duplicates, --drop-degenerate, --compact,
    /// cuts along edges of more than two faces and where the surface meets itself in a point,
    /// --orient.
    #[arg(long)]
    repair: bool,
    /// Join vertices that are at most TOLERANCE apart, in units of MESH; without TOLERANCE,
    /// vertices with equal positions. `seams` joins vertices with equal positions only where
    /// exactly two boundary edges coincide, so that surfaces that only touch stay apart. Texture
    /// coordinates and normals that differ are kept for each corner of a face.
    #[arg(long, value_name = "TOLERANCE", num_args = 0..=1, default_missing_value = "0",
          value_parser = parse::weld)]
    weld: Option<Weld>,
    /// Drop faces with the same vertices as an earlier face, in any order.
    #[arg(long)]
    drop_duplicates: bool,
    /// Remove faces without area without opening the surface: two corners in one place are joined,
    /// and a corner on the opposite edge becomes a vertex of the face beyond that edge. Faces that
    /// can't be removed this way are dropped.
    #[arg(long)]
    drop_degenerate: bool,
    /// Drop vertices that no face has.
    #[arg(long)]
    compact: bool,
    /// Keep the N components with the most faces.
    #[arg(long, value_name = "N", value_parser = parse::at_least_one, conflicts_with = "component")]
    keep_largest: Option<usize>,
    /// Drop components with less than this share of the area, from 0 to 1.
    #[arg(long, value_name = "SHARE", value_parser = parse::share, conflicts_with = "component")]
    drop_specks: Option<f64>,
    /// Fill holes: boundary loops of at most N edges.
    #[arg(long, value_name = "N")]
    fill_holes: Option<usize>,
    /// Flip faces until neighbours agree on the outside. Faces of closed components are
    /// counter-clockwise as seen from outside; a closed component in an odd number of others bounds
    /// a cavity, and its outside is within. In an open component as few faces as possible are
    /// flipped.
    #[arg(long)]
    orient: bool,
    /// Compare with another mesh: distances both ways, areas, angles between normals, topology.
    #[arg(long, value_name = "OTHER")]
    compare: Option<PathBuf>,
    /// Move the mesh to the origin and scale it: to a total area of 1 (area), or to a bounding box
    /// whose longest side is 1 (box). A mesh with coordinates above 1e70, or a size below 1e-70, is
    /// scaled before all other steps, too.
    #[arg(long, value_name = "SIZE", requires = "output")]
    normalize: Option<Size>,
    #[command(flatten)]
    picture: PictureArgs,
    /// Fail if the mesh, or the component of --component, has a problem after the requested
    /// repairs. A boundary, such as that of a hole, is no problem.
    #[arg(long)]
    check: bool,
    #[command(flatten)]
    force: Force,
}

/// Which component.
#[derive(Debug, Clone, Copy)]
enum Which {
    Largest,
    Number(usize),
}

fn component(text: &str) -> Result<Which, String> {
    match text {
        "largest" => Ok(Which::Largest),
        _ => text.parse().map(Which::Number).map_err(|_| "expected a number or `largest`".into()),
    }
}

/// The size that becomes 1.
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
            let format = format(path, args.text)?;
            Some((args.force.create(path)?, format))
        }
        None => None,
    };

    let picture = args.picture.create(args.force)?;
    let start = Instant::now();
    let (mut file, factor) = match args.normalize {
        Some(_) => input::mesh_of_any_size(&args.input)?,
        None => (input::mesh(&args.input)?, 1.0),
    };
    let name = args.input.display();
    let (path, time) = (name.to_string(), start.elapsed());
    status!(
        "mesh",
        path = path,
        seconds = time.as_secs_f64();
        "{path}, read in {}",
        seconds(time)
    )?;
    let mut found = file.validate();
    report::validation(&file.mesh, &found)?;
    report::measures(&file)?;

    if let Some(options) = args.repairs(factor) {
        let mut done = repair(file, &options)
            .map_err(|error| args.refused(error))
            .with_context(|| name.to_string())?;
        // In units of the file, as the option has it.
        for step in &mut done.report.steps {
            if let (RepairStep::Welded { tolerance, .. }, Some(Weld::Within(given))) =
                (step, args.weld)
            {
                *tolerance = given;
            }
        }
        if !args.repair {
            require_orientable(&done.report).with_context(|| name.to_string())?;
        }
        file = done.file;
        done.report.steps.iter().try_for_each(report::repair)?;
        // A mesh has no face with a vertex twice.
        found.problems.retain(|problem| !matches!(problem, Problem::CollapsedFaces { .. }));
        if done.report.changed() {
            found = file.mesh.validate();
            status!("repaired", path = path; "{path}")?;
            report::validation(&file.mesh, &found)?;
            report::measures(&file)?;
        }
    }
    let file = changed(args, file).with_context(|| name.to_string())?;
    if args.component.is_some() {
        found = file.mesh.validate();
    }
    if args.check && !found.problems.is_empty() {
        bail!("{name}: problems found: {}", found.problems.len());
    }
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
    let Some((output, format)) = output else { return Ok(()) };
    let path = output.path().display().to_string();
    output::mesh_as(output, &file, format)?;
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
    /// Returns the requested repairs of a mesh whose lengths were multiplied by `factor`, if there
    /// are any.
    fn repairs(&self, factor: f64) -> Option<RepairOptions> {
        let mut options =
            if self.repair { RepairOptions::everything() } else { RepairOptions::new() };
        match self.weld {
            Some(Weld::Within(tolerance)) => options.weld = Weld::Within(factor * tolerance),
            Some(weld) => options.weld = weld,
            None => {}
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

    /// Names the option of an error of the library: --repair, if that alone selects the step.
    fn refused(&self, error: catamaran::Error) -> anyhow::Error {
        let is_implied = |what: &str| match what {
            "weld" => self.weld.is_none(),
            "drop_duplicates" => !self.drop_duplicates,
            "drop_degenerate" => !self.drop_degenerate,
            "compact" => !self.compact,
            "orient" => !self.orient,
            _ => false,
        };
        match error {
            catamaran::Error::Argument { what, why } if is_implied(what) => {
                anyhow!("--repair, which implies --{}: {why}", what.replace('_', "-"))
            }
            error => as_option(error),
        }
    }
}

/// Returns the format of a file with this name.
fn format(path: &Path, text: bool) -> Result<MeshFormat> {
    let format = MeshFormat::of(path)?;
    match format.as_text() {
        Some(as_text) if text => Ok(as_text),
        None if text => {
            bail!("{}: --text: this format has no text with every digit", path.display())
        }
        _ => Ok(format),
    }
}

/// Refuses a mesh that is not orientable, on which `--orient` can't succeed.
fn require_orientable(done: &RepairReport) -> Result<()> {
    for step in &done.steps {
        if let RepairStep::Oriented { edge: Some([a, b]), .. } = step {
            bail!("edge {a}-{b}: its faces can't be flipped to agree: not orientable");
        }
    }
    Ok(())
}

/// Applies --component and --normalize.
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
        Which::Largest => components
            .largest()
            .context("--component: the mesh has no face, and thus no component")?,
    };
    Ok(mesh.component(&components, number)?)
}
