//! `catamaran mesh`.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use catamaran::io::{Output, Overwrite};
use catamaran::mesh::io::{self as files, MeshFile};
use catamaran::mesh::{Components, Normalization, Part, Problem, TriMesh, Validation};
use clap::ValueEnum;

use crate::input;
use crate::output;
use crate::picture::{PLAIN, Paint, PictureArgs};
use crate::report::{report, seconds};

/// Report on a triangle mesh, and convert or clean it.
///
/// Reads .obj, .ply, .off, .stl, .glb and .gltf, each also as .gz or .xz. Says what it is made of (components, boundary, genus), how
/// large it is, and every kind of problem with the first elements that have it, numbered from 0.
#[derive(clap::Args)]
pub struct Args {
    /// The mesh.
    #[arg(value_name = "MESH")]
    input: PathBuf,
    /// Write the mesh: .obj, .ply, .off, .stl, .glb or .gltf, and .gz after it.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Keep one component only: a number from 0, in the order of their lowest vertices, or `largest` (most faces).
    #[arg(long, value_name = "NUMBER", value_parser = component, requires = "output")]
    component: Option<Which>,
    /// Drop vertices that no face has.
    #[arg(long, requires = "output")]
    compact: bool,
    /// Flip faces until all agree on what is outside.
    #[arg(long, requires = "output")]
    orient: bool,
    /// Move to the origin and scale: to a total area of 1, or to a longest side of the bounding box of 1.
    #[arg(long, value_name = "SIZE", requires = "output")]
    normalize: Option<Size>,
    #[command(flatten)]
    picture: PictureArgs,
    /// Fail when there is a problem.
    #[arg(long)]
    check: bool,
    /// Replace a file that exists.
    #[arg(long)]
    force: bool,
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
    let overwrite = if args.force { Overwrite::Replace } else { Overwrite::Never };
    let output = match &args.output {
        Some(path) => {
            files::check_name(path)?;
            if !args.force && path.symlink_metadata().is_ok() {
                bail!("{}: exists already (--force replaces it)", path.display());
            }
            Some(Output::create(path, overwrite)?)
        }
        None => None,
    };

    let picture = args.picture.create(overwrite)?;
    let start = Instant::now();
    let file = input::mesh(&args.input)?;
    let name = args.input.display();
    report(format_args!("mesh        {name}, read in {}", seconds(start.elapsed())))?;
    let found = file.mesh.validate();
    report(format_args!("{found}"))?;
    measures(&file, &found)?;

    if args.check && !found.problems.is_empty() {
        bail!("{name}: problems found: {}", found.problems.len());
    }
    let file = changed(args, file).with_context(|| name.to_string())?;
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
    report(format_args!("written     {path}: {vertices} vertices, {faces} faces"))
}

/// Sizes and qualities.
fn measures(file: &MeshFile, found: &Validation) -> Result<()> {
    let mesh = &file.mesh;
    report(format_args!("area        {}", mesh.area()))?;
    let oriented =
        |p: &Problem| !matches!(p, Problem::Inconsistent { .. } | Problem::NonManifoldEdge { .. });
    if found.is_closed() && found.faces > 0 && found.problems.iter().all(oriented) {
        let volume = mesh.volume();
        let note = if volume < 0.0 { ", faces clockwise from outside" } else { "" };
        report(format_args!("volume      {volume}{note}"))?;
    }
    if let Some([low, high]) = mesh.bounding_box() {
        report(format_args!("box         {low:?} to {high:?}"))?;
    }
    let qualities = mesh.qualities();
    if !qualities.is_empty() {
        let count = qualities.len() as f64;
        let mean = qualities.iter().sum::<f64>() / count;
        let least = qualities.iter().copied().fold(1.0, f64::min);
        let slivers = 100.0 * qualities.iter().filter(|&&q| q < 0.1).count() as f64 / count;
        report(format_args!(
            "quality     {mean:.3} mean, {least:.3} least, {slivers:.2} % below 0.1 (1: equilateral)"
        ))?;
    }
    let extras = [
        (file.uv.is_some(), "texture coordinates"),
        (file.normals.is_some(), "normals"),
        (file.colors.is_some(), "colours"),
    ];
    let extras: Vec<_> =
        extras.into_iter().filter(|(there, _)| *there).map(|(_, what)| what).collect();
    if !extras.is_empty() {
        report(format_args!("attributes  {}", extras.join(", ")))?;
    }
    if file.collapsed_faces > 0 {
        report(format_args!("left out    {} facets with two equal corners", file.collapsed_faces))?;
    }
    Ok(())
}

/// The mesh as it is to be written.
fn changed(args: &Args, mut file: MeshFile) -> Result<MeshFile> {
    if let Some(which) = args.component {
        file = file.part(one_component(&file.mesh, which)?)?;
    }
    if args.compact {
        file = file.part(file.mesh.without_unreferenced()?)?;
    }
    if args.orient {
        file = file.oriented()?;
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
