//! `catamaran curve`.

pub mod samples;
mod surface;
pub mod write;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow, bail};
use catamaran::Error;
use catamaran_geometry::curve::{
    Count, Curve, CurveOptions, Drawing, Drawn, Mode, Outcome, Placement, Reconstruction, Region,
    Site, cut, place, places,
};
use catamaran_geometry::mesh::vector::distance;
use catamaran_geometry::mesh::{Refined, TriMesh};
use clap::{ArgGroup, ValueEnum, ValueHint};
use samples::{Group, Samples};
use surface::{SurfaceArgs, paint, walls};
use write::Format;

use crate::common::Force;
use crate::defaults::variant;
use crate::input::{MeshArgs, TextFile};
use crate::picture::{Paint, PictureArgs, with_curves};
use crate::progress::Bar;
use crate::report::{note, report, seconds, status};

/// Reconstruct curves on a mesh from unordered samples, and cut the mesh along them.
///
/// --region writes the region that the curves enclose. Prints the outcome: closed, open, blocked,
/// close-blocked or disconnected. If a curve is not complete, the command writes the part that it
/// found, and fails. Each component of the mesh has separate curves; samples on a component with
/// fewer than three samples are left out, with a note.
#[derive(clap::Args)]
#[command(group = ArgGroup::new("result")
    .args(["output", "cut", "region", "rest", "paint"]).required(true).multiple(true))]
pub struct Args {
    #[arg(value_name = "MESH", help = crate::input::mesh_help("The mesh"))]
    mesh: PathBuf,
    /// File of samples, one per line: a vertex (numbered from 0), a face and barycentric
    /// coordinates (`face a b c`), or a point in space (`x y z`), which stands for the nearest
    /// vertex; `#` begins a comment. Files that `catamaran farthest` writes are accepted. A line
    /// `curve NAME [open] [single] [side=SIDE]` begins the samples of another curve, which is found
    /// independently. `-` reads stdin.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    samples: TextFile,
    /// Algorithm: from sample to sample (faithful: thesis, algorithm 6.1), the order first and then
    /// paths that do not meet (robust), or such paths in the order of the file (ordered).
    #[arg(
        value_enum,
        long,
        value_name = "MODE",
        default_value_t = variant(CurveOptions::default().mode)
    )]
    mode: How,
    /// Number of nearest samples among which --mode faithful chooses the next one.
    #[arg(
        short = 'l',
        long,
        value_name = "L",
        default_value_t = CurveOptions::default().candidates
    )]
    candidates: usize,
    /// Sample, numbered from 0, that --mode faithful starts at.
    #[arg(long, value_name = "NUMBER", default_value_t = CurveOptions::default().start)]
    start: usize,
    /// Find open curves instead of closed ones.
    #[arg(long)]
    open: bool,
    /// Find a single curve, even where gaps suggest several.
    #[arg(long)]
    single: bool,
    /// Drop outliers: one or two successive samples to which the curve makes a detour of more than
    /// three times the median distance between successive samples. At the ends of an open curve,
    /// twice that distance counts. At least half of the samples stay.
    #[arg(long)]
    drop_outliers: bool,
    /// Use vertices of the mesh only, instead of adding points where there is no other path.
    #[arg(long)]
    no_steiner: bool,
    /// Run straight over faces between samples instead of along edges (geodesics by edge flips).
    #[arg(long)]
    smooth: bool,
    /// Insert samples on faces as vertices, instead of moving them to the nearest corner.
    #[arg(long)]
    insert: bool,
    /// Output file of the curves: .obj (lines), or .json (outcome, order of the samples, samples
    /// left out, outliers, path of vertices, points with their faces and barycentric coordinates,
    /// length).
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    surface: SurfaceArgs,
    #[command(flatten)]
    repair: MeshArgs,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    force: Force,
}

#[derive(Clone, Copy, ValueEnum)]
enum How {
    Faithful,
    Robust,
    Ordered,
}

impl From<How> for Mode {
    fn from(how: How) -> Self {
        match how {
            How::Faithful => Self::Faithful,
            How::Robust => Self::Robust,
            How::Ordered => Self::Ordered,
        }
    }
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    if args.drop_outliers && matches!(args.mode, How::Faithful) {
        bail!("--drop-outliers: --mode faithful takes every sample");
    }
    let output = match &args.output {
        Some(path) => Some((Format::of(path)?, args.force.create(path)?)),
        None => None,
    };
    let outputs = args.surface.create(args.force)?;
    let picture = args.picture.create(args.force)?;
    let file = args.repair.read(&args.mesh)?;
    args.surface.check_pieces(&file, args.force)?;
    let given = samples::parse(&args.samples.read()?, &args.samples.name())?;
    let placement = if args.insert { Placement::Insert } else { Placement::Snap };
    let name = args.samples.name();
    let placed = place(&file.mesh, &given.sites, placement);
    let placed = placed.map_err(|error| refused(error, &given, &name))?;
    note_far(&given, &placed.vertices, &file.mesh, &name);
    let placed_on = placed.mesh.unwrap_or_else(|| Refined::new(file.mesh.clone()));
    let mut drawing = Drawing::new(placed_on.mesh.clone())?;
    let time = draw(args, &mut drawing, &given.groups, &placed.vertices)?;
    if args.smooth {
        let smooth = drawing.smooth();
        if !smooth.with_context(|| args.mesh.display().to_string())? {
            note(format_args!(
                "--smooth: the steps did not suffice, so the curves are not geodesics yet"
            ));
        }
    }
    let (samples, vertices) = (given.sites.len(), placed_on.mesh.vertices().len());
    status!(
        "samples",
        count = samples,
        vertices = vertices,
        seconds = time.as_secs_f64();
        "{samples} on {vertices} vertices, {}",
        seconds(time)
    )?;
    let found: Vec<(&Group, &Reconstruction)> = given.groups.iter().zip(drawing.found()).collect();
    let Some((first, Reconstruction { outcome, .. })) = write::first(&found) else {
        bail!("no curves")
    };
    for (group, found) in &found {
        describe(group, found)?;
    }
    if let Some((format, output)) = output {
        let path = output.path().display().to_string();
        let refined = placed_on.then(drawing.refinement().clone());
        let on_faces = found.iter().map(|(_, found)| places(&found.curves, &refined, &file.mesh));
        let on_faces: Vec<_> = on_faces.collect::<catamaran::Result<_>>()?;
        write::write(output, &found, &on_faces, format)?;
        status!("written", path = path; "{path}")?;
    }
    if !outcome.is_complete() {
        let (file, outcome) = (args.samples.name(), first.outcome(*outcome));
        match &first.name {
            Some(name) => bail!("{file}: curve {name}: not complete: {outcome}"),
            None => bail!("{file}: a curve is not complete: {outcome}"),
        }
    }
    let mut region = None;
    let mut drawn = None;
    if args.surface.any() {
        let Drawn { refined, layers } =
            drawing.inscribe().with_context(|| args.mesh.display().to_string())?;
        let all = Drawn { refined: placed_on.then(refined), layers };
        region = args.surface.write(outputs, &file, &all, &given.groups, args.force)?;
        drawn = Some(all);
    }
    if let Some(picture) = picture {
        let curves: Vec<Curve> =
            drawing.found().flat_map(|found| found.curves.iter().cloned()).collect();
        let samples: Vec<_> =
            placed.vertices.iter().map(|&v| placed_on.mesh.vertices()[v as usize]).collect();
        let drawn = drawn.as_ref().zip(region.as_ref());
        let (painted, colors) = painted(&file.mesh, drawn, &curves, &samples)?;
        args.picture.draw(picture, &args.mesh, &[(&painted, Paint::Colors(&colors), "")])?;
    }
    Ok(())
}

/// Names the line of the file `name` with the sample that an error of the library is about.
fn refused(error: Error, given: &Samples, name: &str) -> anyhow::Error {
    if let Error::Argument { what: "sites", why } = &error
        && let Some((number, why)) = why.strip_prefix("site ").and_then(|why| why.split_once(": "))
        && let Some(line) = number.parse().ok().and_then(|i: usize| given.lines.get(i))
    {
        return anyhow!("{name}:{line}: {why}");
    }
    anyhow::Error::from(error).context(name.to_owned())
}

/// Says how many points in space are far from the vertices that they stand for, as they are in
/// other units than the mesh.
fn note_far(given: &Samples, vertices: &[u32], mesh: &TriMesh, name: &str) {
    /// Share of the diagonal of the mesh above which a point is far from it.
    const FAR: f64 = 0.1;
    let [low, high] = mesh.bounding_box().unwrap_or_default();
    let gap = |i: &usize| match given.sites[*i] {
        Site::Near(point) => distance(point, mesh.vertices()[vertices[*i] as usize]),
        Site::Vertex(_) | Site::Face(_) => 0.0,
    };
    let is_far = |i: &usize| gap(i) > FAR * distance(low, high);
    let far: Vec<usize> = (0..given.sites.len()).filter(is_far).collect();
    let Some(first) = far.first() else { return };
    let (line, vertex, gap) = (given.lines[*first], vertices[*first], gap(first));
    note(format_args!(
        "{name}:{line}: the point is {gap:.3e} from the mesh, and stands for vertex {vertex}: is \
         it in the units of the mesh? {} of {} samples are as far",
        far.len(),
        given.sites.len()
    ));
}

/// Finds the curves of all groups, and returns the time that this took.
fn draw(
    args: &Args,
    drawing: &mut Drawing,
    groups: &[Group],
    vertices: &[u32],
) -> Result<Duration> {
    let bar = Bar::new("curve");
    let start = Instant::now();
    for (i, group) in groups.iter().enumerate() {
        let update = |fraction| bar.update((i as f64 + fraction) / groups.len() as f64);
        let options = CurveOptions::new()
            .mode(args.mode.into())
            .open(args.open || group.open)
            .count(if args.single || group.single { Count::One } else { Count::Automatic })
            .steiner(!args.no_steiner)
            .drop_outliers(args.drop_outliers)
            .candidates(args.candidates)
            .start(args.start)
            .progress(&update);
        drawing.add(&vertices[group.samples.clone()], &options).with_context(|| {
            let name = group.name.as_ref().map_or(String::new(), |name| format!(": curve {name}"));
            format!("{}{name}", args.samples.name())
        })?;
    }
    Ok(start.elapsed())
}

/// Reports what was found for one group.
fn describe(group: &Group, found: &Reconstruction) -> Result<()> {
    let name = group.name.as_ref().map_or(String::new(), |name| format!("{name}: "));
    let outcome = group.outcome(found.outcome);
    let (blocked_at, remaining, components) = match outcome {
        Outcome::Blocked { at, remaining } => (Some(at), Some(remaining), None),
        Outcome::Disconnected { components } => (None, None, Some(components)),
        _ => (None, None, None),
    };
    report!(
        "outcome",
        name = group.name,
        outcome = outcome.name(),
        blocked_at = blocked_at,
        remaining = remaining,
        components = components;
        "{name}{outcome}"
    )?;
    if !found.outliers.is_empty() {
        let numbers: Vec<usize> = group.numbers(&found.outliers).collect();
        let listed: Vec<String> = numbers.iter().map(usize::to_string).collect();
        report!(
            "outliers",
            name = group.name,
            samples = numbers;
            "{name}{} of {} samples dropped: {} (from 0)",
            listed.len(),
            group.samples.len(),
            listed.join(", ")
        )?;
    }
    for curve in &found.curves {
        let (count, steps) = (curve.order.len(), curve.path.len());
        let length = curve.length;
        report!(
            "curve",
            name = group.name,
            closed = curve.closed,
            samples = count,
            vertices = steps,
            length = length;
            "{name}{count} samples, {steps} vertices, length {length}"
        )?;
    }
    if let (Some(&first), true) = (found.left_out.first(), found.outcome.is_complete()) {
        note(format_args!(
            "{name}{} of {} samples left out, such as sample {} (from 0): fewer than \
             three on their component of the mesh",
            found.left_out.len(),
            group.samples.len(),
            group.samples.start + first as usize,
        ));
    }
    Ok(())
}

/// Returns the mesh with the curves, and the colours of its vertices: those of the region differ.
fn painted(
    mesh: &TriMesh,
    region: Option<(&Drawn, &Region)>,
    curves: &[Curve],
    samples: &[[f64; 3]],
) -> Result<(TriMesh, Vec<[u8; 3]>)> {
    let Some((drawn, region)) = region else { return with_curves(mesh, curves, samples) };
    let open = cut(&drawn.refined.mesh, &walls(&drawn.layers.concat()))?;
    let (mesh, mut colors) = with_curves(&open.mesh, curves, samples)?;
    for (color, painted) in colors.iter_mut().zip(paint(&open, region)) {
        *color = painted.map(|x| (255.0 * x).round() as u8);
    }
    Ok((mesh, colors))
}
