//! `catamaran curve`.

mod samples;

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use catamaran::curve::{Count, CurveOptions, CurveSolver, Mode, Placement, Reconstruction, place};
use catamaran::io::{Output, Overwrite};
use clap::ValueEnum;

use crate::input::MeshArgs;
use crate::picture::{Paint, PictureArgs, with_curves};
use crate::progress::Bar;
use crate::report::{complain, report, seconds};

/// Find the curve on a mesh that samples without an order are of.
///
/// Says how it ended: closed, open, blocked, close-blocked or disconnected; when the curve is not
/// complete, what there is of it is written, and the program fails. Each component of the mesh has
/// curves of its own; samples on a component with fewer than three are left out, with a note.
#[derive(clap::Args)]
pub struct Args {
    /// The mesh: .obj, .ply, .off, .stl, .glb or .gltf, and .gz or .xz after it.
    #[arg(value_name = "MESH")]
    mesh: PathBuf,
    /// The samples, one a line: a vertex (from 0), a face and barycentric coordinates (`face a b c`), or a point in space
    /// (`x y z`), which stands for the vertex nearest to it; what follows # is left out. What `catamaran fps` writes will do.
    #[arg(long, value_name = "FILE")]
    samples: PathBuf,
    /// How: from sample to sample (thesis, algorithm 6.1), or the order first and then paths that do not meet.
    #[arg(long, value_name = "MODE", default_value = "robust")]
    mode: How,
    /// In the faithful mode: among how many of the nearest samples the next one is chosen.
    #[arg(short = 'l', long, value_name = "L", default_value_t = 5)]
    candidates: usize,
    /// In the faithful mode: the sample (from 0) that the curve starts at.
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    start: usize,
    /// An open curve, not a closed one.
    #[arg(long)]
    open: bool,
    /// One curve, even where there are gaps as between several.
    #[arg(long)]
    single: bool,
    /// Only vertices of the mesh: no points are added where there is no other way.
    #[arg(long)]
    no_steiner: bool,
    /// Straight over the faces between samples, not along edges (geodesics by edge flips).
    #[arg(long)]
    smooth: bool,
    /// Samples on faces become vertices; without this the nearest corner stands for them.
    #[arg(long)]
    insert: bool,
    /// Where the curve goes: .obj (lines), or .json (outcome, order of the samples, samples left
    /// out, path of vertices, points, length).
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    repair: MeshArgs,
    #[command(flatten)]
    picture: PictureArgs,
    /// Replace files that exist.
    #[arg(long)]
    force: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum How {
    Faithful,
    Robust,
}

/// What is written.
#[derive(Clone, Copy)]
enum Format {
    Obj,
    Json,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let overwrite = if args.force { Overwrite::Replace } else { Overwrite::Never };
    let format = match args.output.extension().and_then(|e| e.to_str()) {
        Some("obj") => Format::Obj,
        Some("json") => Format::Json,
        _ => bail!("{}: a curve is written as .obj or .json", args.output.display()),
    };
    let output = Output::create(&args.output, overwrite)?;
    let picture = args.picture.create(overwrite)?;
    let file = args.repair.read(&args.mesh)?;
    let sites = samples::read(&args.samples)?;
    let placement = if args.insert { Placement::Insert } else { Placement::Snap };
    let placed =
        place(&file.mesh, &sites, placement).with_context(|| args.samples.display().to_string())?;
    let mesh = placed.mesh.as_ref().map_or(&file.mesh, |refined| &refined.mesh);
    let mut solver = CurveSolver::new(mesh)?;
    let bar = Bar::new("curve");
    let update = |fraction| bar.update(fraction);
    let options = CurveOptions::new()
        .mode(match args.mode {
            How::Faithful => Mode::Faithful,
            How::Robust => Mode::Robust,
        })
        .open(args.open)
        .count(if args.single { Count::One } else { Count::Automatic })
        .steiner(!args.no_steiner)
        .candidates(args.candidates)
        .start(args.start)
        .progress(&update);
    let start = Instant::now();
    let mut found = solver
        .reconstruct(&placed.vertices, &options)
        .with_context(|| args.samples.display().to_string())?;
    let time = start.elapsed();
    drop(bar);
    if args.smooth {
        let smooth = found.smooth(mesh, &placed.vertices);
        if !smooth.with_context(|| args.mesh.display().to_string())? {
            complain(format_args!("smoothing ended before it was done"));
        }
    }
    report(format_args!(
        "samples   {} on {} vertices, {}",
        sites.len(),
        mesh.vertices().len(),
        seconds(time)
    ))?;
    report(format_args!("outcome   {}", found.outcome))?;
    for curve in &found.curves {
        let (count, steps) = (curve.order.len(), curve.path.len());
        let length = curve.length;
        report(format_args!("curve     {count} samples, {steps} vertices, length {length}"))?;
    }
    if let (Some(first), true) = (found.left_out.first(), found.outcome.is_complete()) {
        complain(format_args!(
            "note: {} of {} samples left out, such as sample {first} (from 0): fewer than three on \
             their component of the mesh",
            found.left_out.len(),
            sites.len()
        ));
    }
    write(output, &found, format)?;
    if let Some(picture) = picture {
        let samples: Vec<_> =
            placed.vertices.iter().map(|&v| mesh.vertices()[v as usize]).collect();
        let (painted, colors) = with_curves(&file.mesh, &found.curves, &samples)?;
        args.picture.draw(picture, &args.mesh, &[(&painted, Paint::Colors(&colors), "")])?;
    }
    report(format_args!("written   {}", args.output.display()))?;
    if !found.outcome.is_complete() {
        bail!("{}: no complete curve: {}", args.mesh.display(), found.outcome);
    }
    Ok(())
}

fn write(mut output: Output, found: &Reconstruction, format: Format) -> Result<()> {
    let text = match format {
        Format::Obj => obj(found),
        Format::Json => json(found),
    };
    output.write_all(text.as_bytes()).map_err(|e| output.error(e))?;
    Ok(output.commit()?)
}

fn obj(found: &Reconstruction) -> String {
    let mut text = String::new();
    let mut first = 1;
    for curve in &found.curves {
        for [x, y, z] in &curve.points {
            let _ = writeln!(text, "v {x} {y} {z}");
        }
        let numbers = (first..first + curve.points.len()).chain(curve.closed.then_some(first));
        if curve.points.len() > 1 {
            let numbers: Vec<String> = numbers.map(|i| i.to_string()).collect();
            let _ = writeln!(text, "l {}", numbers.join(" "));
        }
        first += curve.points.len();
    }
    text
}

/// `order` and `path` are of all curves, one after the other; `curves` has them one by one.
fn json(found: &Reconstruction) -> String {
    let list = |all: &mut dyn Iterator<Item = &u32>| {
        let numbers: Vec<String> = all.map(u32::to_string).collect();
        format!("[{}]", numbers.join(", "))
    };
    let curves = &found.curves;
    let each: Vec<String> = (curves.iter())
        .map(|curve| {
            let points: Vec<String> =
                curve.points.iter().map(|[x, y, z]| format!("[{x}, {y}, {z}]")).collect();
            format!(
                "    {{\"closed\": {}, \"length\": {}, \"order\": {}, \"path\": {}, \"points\": [{}]}}",
                curve.closed,
                curve.length,
                list(&mut curve.order.iter()),
                list(&mut curve.path.iter()),
                points.join(", ")
            )
        })
        .collect();
    format!(
        "{{\n  \"outcome\": \"{}\",\n  \"length\": {},\n  \"order\": {},\n  \"left_out\": {},\n  \
         \"path\": {},\n  \"curves\": [\n{}\n  ]\n}}\n",
        found.outcome.name(),
        found.length(),
        list(&mut curves.iter().flat_map(|c| &c.order)),
        list(&mut found.left_out.iter()),
        list(&mut curves.iter().flat_map(|c| &c.path)),
        each.join(",\n")
    )
}
