//! `catamaran newton`.

mod expression;
mod output;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use catamaran::Par;
use catamaran::base::Progress;
use catamaran::io::Overwrite;
use catamaran::mesh::{Normalization, TriMesh};
use catamaran::texture::newton::{
    Fractal, Gradient, Grid, Newton, NewtonOptions, Points, Polynomial, texels,
};
use clap::ValueEnum;

use crate::device::{self, Device, DeviceArgs};
use crate::input::MeshArgs;
use crate::parse;
use crate::picture::{Paint, PictureArgs};
use crate::progress::Bar;
use crate::report::{report, seconds};
pub use output::colors;
use output::{Drawing, Job};

/// Decorate a plane, a mesh or a volume with a Newton fractal in four dimensions (bicomplex numbers).
///
/// Each point gets the colour of the root that Newton's method takes it to, darker the longer that
/// takes. Without MESH the plane z = 0 is drawn; with it, its vertices, or with --uv the texels of
/// its texture; with --volume, voxels. A mesh is looked at as if its box, kept in proportion, had
/// its middle at the origin and a longest side of --extent, whatever its unit.
#[derive(clap::Args)]
pub struct Args {
    /// The mesh: .obj, .ply, .off, .stl, .glb or .gltf, and .gz or .xz after it.
    #[arg(value_name = "MESH")]
    mesh: Option<PathBuf>,
    /// The polynomial is z^N - 1, with N^2 roots; N from 2 to 64 [default: 3].
    #[arg(long, value_name = "N", conflicts_with = "roots")]
    power: Option<u32>,
    /// The polynomial has these roots, real and imaginary part: --roots 1,0:-0.5,0.8:-1,-0.3.
    #[arg(
        long,
        value_name = "RE,IM:RE,IM...",
        value_delimiter = ':',
        allow_hyphen_values = true,
        value_parser = numbers::<2>
    )]
    roots: Vec<[f64; 2]>,
    /// The polynomial, of a degree up to 64: --polynomial "z^3 - 2z + 2", "(1+2i) z^4 - (z - i)^2".
    #[arg(
        long,
        value_name = "EXPRESSION",
        conflicts_with_all = ["power", "roots"],
        allow_hyphen_values = true,
        value_parser = Coefficients::parse
    )]
    polynomial: Option<Coefficients>,
    /// The fourth coordinate.
    #[arg(long, value_name = "W", default_value_t = 0.0, allow_hyphen_values = true)]
    w: f64,
    /// So many outputs, w going from --w to --w-to; they are called NAME-000, NAME-001 and so on.
    #[arg(long, value_name = "N", requires = "w_to", value_parser = parse::frame_count)]
    frames: Option<usize>,
    /// The fourth coordinate of the last frame.
    #[arg(long, value_name = "W", requires = "frames", allow_hyphen_values = true)]
    w_to: Option<f64>,
    /// What points, fitted, are multiplied by, after the offset and w have been added.
    #[arg(long, value_name = "S", default_value_t = 1.0, allow_hyphen_values = true)]
    scale: f64,
    /// What is added to points, fitted.
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,0", allow_hyphen_values = true, value_parser = numbers::<3>)]
    offset: [f64; 3],
    /// Iterations.
    #[arg(long, value_name = "N", default_value_t = 32)]
    iterations: u32,
    /// The theta of the gradient: the larger, the earlier a point counts as not converged.
    #[arg(long, value_name = "THETA", default_value_t = 3.5, allow_hyphen_values = true)]
    theta: f64,
    /// The gradient: equation 7.3 of the thesis, or that of its authors' shader.
    #[arg(long, value_name = "WHICH", default_value = "thesis")]
    gradient: Which,
    /// Pixels, texels or voxels: N along each side, or WIDTHxHEIGHT [default: 1024; voxels 128].
    #[arg(long, value_name = "SIZE", value_parser = size)]
    size: Option<(u32, u32)>,
    /// Take the coordinates of a mesh as they are: don't fit them into the --extent.
    #[arg(long, requires = "mesh")]
    no_fit: bool,
    /// How wide the part of the plane, the volume, or what a mesh is fitted into is.
    #[arg(long, value_name = "WIDTH", default_value_t = 3.0)]
    extent: f64,
    /// Texels of the mesh's texture, not vertices.
    #[arg(long, requires = "mesh", conflicts_with = "volume")]
    uv: bool,
    /// Voxels of a cube around the origin.
    #[arg(long, conflicts_with = "mesh")]
    volume: bool,
    /// Where the result goes: .png for a plane or texels; a mesh with colours for vertices; for voxels the numbers of their
    /// roots, .npy, a line of voxels a row (numpy: reshape(N, N, N), indices z, y, x).
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Write how fast points converge: .png (16 bits, white is slow) for a plane or texels, else a table of numbers.
    #[arg(long, value_name = "FILE")]
    heights: Option<PathBuf>,
    #[command(flatten)]
    repair: MeshArgs,
    #[command(flatten)]
    device: DeviceArgs,
    /// Threads of the processor; all cores by default.
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    #[command(flatten)]
    picture: PictureArgs,
    /// Replace files that exist.
    #[arg(long)]
    force: bool,
}

/// Of a polynomial, the highest power first.
#[derive(Debug, Clone)]
struct Coefficients(Vec<[f64; 2]>);

impl Coefficients {
    fn parse(text: &str) -> Result<Self, String> {
        expression::polynomial(text).map(Self)
    }
}

#[derive(Clone, Copy, ValueEnum)]
enum Which {
    Thesis,
    Shader,
}

/// One output.
struct Frame {
    w: f64,
    output: PathBuf,
    heights: Option<PathBuf>,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let overwrite = if args.force { Overwrite::Replace } else { Overwrite::Never };
    let options = options(args)?;
    Newton::new(&options)?;
    let device = args.device.open()?;
    let mut picture = args.picture.create(overwrite)?;
    if picture.is_some() && (args.mesh.is_none() || args.uv) {
        bail!("--picture shows the vertices of a mesh: it needs MESH, and not --uv");
    }
    output::check_names(args)?;
    let frames = frames(args);
    let jobs = frames
        .iter()
        .map(|frame| Job::create(&frame.output, frame.heights.as_deref(), overwrite))
        .collect::<Result<Vec<_>>>()?;
    let drawing = drawing(args)?;
    let par = args.threads.map_or(Par::all(), Par::Threads);
    let bar = Bar::new("newton");
    let update = |fraction| bar.update(fraction);
    let share = |i: usize| i as f64 / frames.len() as f64;
    let (mut time, mut points) = (Duration::ZERO, 0);
    for (i, (job, frame)) in jobs.into_iter().zip(&frames).enumerate() {
        let newton = Newton::new(&options.clone().w(frame.w))?;
        let progress = Progress::new(&update).part(share(i)..share(i + 1));
        let start = Instant::now();
        let fractal = evaluate(device.as_ref(), &newton, drawing.points(), par, progress)?;
        time += start.elapsed();
        points += fractal.roots.len();
        if let (Drawing::Vertices { file, .. }, Some(source), Some(picture)) =
            (&drawing, &args.mesh, picture.take())
        {
            let colors = colors(&newton, &fractal);
            args.picture.draw(picture, source, &[(&file.mesh, Paint::Colors(&colors), "")])?;
        }
        job.write(&drawing, &newton, &fractal)?;
    }
    drop(bar);
    report(format_args!(
        "points    {points} on {}, {} iterations, {}",
        device.as_ref().map_or("cpu", device::name),
        args.iterations,
        seconds(time)
    ))?;
    for frame in &frames {
        for path in [Some(&frame.output), frame.heights.as_ref()].into_iter().flatten() {
            report(format_args!("written   {}", path.display()))?;
        }
    }
    Ok(())
}

#[cfg(feature = "opencl")]
fn evaluate(
    device: Option<&Device>,
    newton: &Newton,
    points: Points<'_>,
    par: Par,
    progress: Progress<'_>,
) -> Result<Fractal> {
    Ok(match device {
        Some(device) => catamaran::opencl::evaluate_newton(device, newton, points, progress)?,
        None => newton.evaluate(points, par, progress)?,
    })
}

#[cfg(not(feature = "opencl"))]
fn evaluate(
    device: Option<&Device>,
    newton: &Newton,
    points: Points<'_>,
    par: Par,
    progress: Progress<'_>,
) -> Result<Fractal> {
    match device {
        Some(device) => match *device {},
        None => Ok(newton.evaluate(points, par, progress)?),
    }
}

fn options(args: &Args) -> catamaran::Result<NewtonOptions> {
    let polynomial = match &args.polynomial {
        Some(Coefficients(coefficients)) => Polynomial::from_coefficients(coefficients)?,
        None if args.roots.is_empty() => Polynomial::Power(args.power.unwrap_or(3)),
        None => Polynomial::Roots(args.roots.clone()),
    };
    Ok(NewtonOptions::new()
        .polynomial(polynomial)
        .iterations(args.iterations)
        .theta(args.theta)
        .gradient(match args.gradient {
            Which::Thesis => Gradient::Thesis,
            Which::Shader => Gradient::Shader,
        })
        .scale(args.scale)
        .offset(args.offset)
        .w(args.w))
}

/// What is computed, and where each result goes.
fn frames(args: &Args) -> Vec<Frame> {
    let (Some(count), Some(end)) = (args.frames, args.w_to) else {
        return vec![Frame {
            w: args.w,
            output: args.output.clone(),
            heights: args.heights.clone(),
        }];
    };
    let frame = |i: usize| Frame {
        w: args.w + (end - args.w) * i as f64 / count.saturating_sub(1).max(1) as f64,
        output: numbered(&args.output, i),
        heights: args.heights.as_ref().map(|path| numbered(path, i)),
    };
    (0..count).map(frame).collect()
}

/// `folder/name.png` as `folder/name-007.png`.
fn numbered(path: &Path, i: usize) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{i:03}.{extension}"))
}

fn drawing(args: &Args) -> Result<Drawing> {
    if args.extent <= 0.0 || !args.extent.is_finite() {
        bail!("--extent {}: a positive number is needed", args.extent);
    }
    let (width, height) = args.size.unwrap_or(if args.volume { (128, 128) } else { (1024, 1024) });
    if args.volume {
        if width != height {
            bail!("--size {width}x{height}: a volume has as many voxels in each way");
        }
        return Ok(Drawing::Voxels { grid: Grid::cube(width, args.extent) });
    }
    let Some(path) = &args.mesh else {
        return Ok(Drawing::Plane { grid: Grid::plane(width, height, [0.0; 2], args.extent) });
    };
    let file = crate::decimate::read(path, &args.repair)?;
    let named = || path.display().to_string();
    let fitted = match args.no_fit {
        true => file.mesh.clone(),
        false => fitted(&file.mesh, args.extent).with_context(named)?,
    };
    if !args.uv {
        let positions = fitted.vertices().iter().map(|p| p.map(|x| x as f32)).collect();
        return Ok(Drawing::Vertices { file: Box::new(file), positions });
    }
    let uv = file.uv.as_ref().context("has no texture coordinates").with_context(named)?;
    let texels = texels(&fitted, uv, width, height).with_context(named)?;
    Ok(Drawing::Texels { texels, width: width as usize, height: height as usize })
}

/// The mesh moved and scaled such that its box has its middle at the origin and a longest side of
/// `extent`.
fn fitted(mesh: &TriMesh, extent: f64) -> catamaran::Result<TriMesh> {
    let (mut vertices, faces) = mesh.normalized(Normalization::UnitBox)?.into_parts();
    vertices.as_flattened_mut().iter_mut().for_each(|x| *x *= extent);
    TriMesh::new(vertices, faces)
}

/// N numbers with commas between them.
fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let all: Result<Vec<f64>, _> = text.split(',').map(|word| word.trim().parse()).collect();
    let all = all.map_err(|e| format!("{e}: {N} numbers with commas between them are needed"))?;
    all.try_into().map_err(|all: Vec<f64>| format!("{} numbers, where {N} are needed", all.len()))
}

/// `N` or `WIDTHxHEIGHT`.
fn size(text: &str) -> Result<(u32, u32), String> {
    let (width, height) = text.split_once('x').unwrap_or((text, text));
    let side = |text: &str| match text.trim().parse::<u32>() {
        Ok(n @ 1..=65_536) => Ok(n),
        Ok(n) => Err(format!("{n}: sides are from 1 to 65,536")),
        Err(e) => Err(e.to_string()),
    };
    Ok((side(width)?, side(height)?))
}
