//! `catamaran newton`.

mod expression;
mod output;
mod voxels;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow, bail};
use catamaran::base::Progress;
use catamaran::{Error, Par};
use catamaran_geometry::mesh::{Normalization, TriMesh};
use catamaran_simulation::texture::newton::{
    Fractal, Gradient, Grid, Newton, NewtonOptions, Points, Polynomial, texels,
};
use catamaran_simulation::texture::slime;
use clap::{ArgGroup, ValueEnum};

use crate::common::{Force, Threads, as_option};
use crate::defaults::{Numbers, stated, variant};
use crate::device::{self, Device, DeviceArgs};
use crate::input::MeshArgs;
use crate::parse;
use crate::picture::{PictureArgs, RATE, frame_rate};
use crate::progress::Bar;
use crate::report::{note, seconds, status};
pub use output::colors;
use output::{Drawing, Outputs};
pub use voxels::surfaces;
use voxels::{Basins, Opacity};

/// Pixels or texels along each side, by default.
const PIXELS: u32 = 1024;

/// Voxels along each side, by default.
const VOXELS: u32 = 128;

/// The mesh, and the options for meshes only.
const OF_MESHES: [&str; 8] =
    ["mesh", "no_fit", "uv", "write_material", "inlay", REPAIRS[0], REPAIRS[1], REPAIRS[2]];

/// The options of [`MeshArgs`].
const REPAIRS: [&str; 3] = ["weld", "drop_specks", "strict"];

/// Draw a Newton fractal of bicomplex numbers on a plane, a mesh or a volume.
///
/// Each point gets the colour of the root that Newton's method takes it to; slow convergence
/// darkens the colour. Without MESH the plane z = 0 is drawn; with MESH its vertices, or with --uv
/// the texels of its texture; with --volume voxels. A mesh is first scaled and moved: its bounding
/// box then has its centre at the origin and a longest side of --extent.
///
/// There are more examples in docs/guide/newton.md.
#[derive(clap::Args)]
#[command(group = ArgGroup::new("repairs").args(REPAIRS).multiple(true).requires("mesh"))]
pub struct Args {
    #[arg(value_name = "MESH", help = crate::input::mesh_help("The mesh"))]
    mesh: Option<PathBuf>,
    /// Use the polynomial z^N - 1, with N^2 roots; N from 2 to 64.
    #[arg(long, value_name = "N", default_value_t = power(), conflicts_with = "roots")]
    power: u32,
    /// Use the polynomial with these roots, each as real and imaginary part: --roots
    /// 1,0:-0.5,0.8:-1,-0.3.
    #[arg(
        long,
        value_name = "RE,IM:RE,IM...",
        value_delimiter = ':',
        allow_hyphen_values = true,
        value_parser = parse::numbers::<2>
    )]
    roots: Vec<[f64; 2]>,
    /// Use this polynomial, of a degree up to 64: --polynomial "z^3 - 2z + 2", "(1+2i) z^4 - (z -
    /// i)^2".
    #[arg(
        long,
        value_name = "EXPRESSION",
        conflicts_with_all = ["power", "roots"],
        allow_hyphen_values = true,
        value_parser = Coefficients::parse
    )]
    polynomial: Option<Coefficients>,
    /// Fourth coordinate of the points.
    #[arg(
        long,
        value_name = "W",
        default_value_t = NewtonOptions::default().w,
        allow_hyphen_values = true
    )]
    w: f64,
    /// Number of frames, with w going from --w to --w-to: an animation where the name of --output
    /// or --picture ends in .apng or .gif, else files NAME-000, NAME-001 and so on.
    #[arg(long, value_name = "N", requires = "w_to", value_parser = parse::frame_count)]
    frames: Option<usize>,
    /// Fourth coordinate of the last frame.
    #[arg(long, value_name = "W", requires = "frames", allow_hyphen_values = true)]
    w_to: Option<f64>,
    #[arg(
        long,
        value_name = "RATE",
        requires = "frames",
        value_parser = frame_rate,
        help = stated("Frames per second of an animation, from 0.1 to 50", RATE)
    )]
    fps: Option<f64>,
    /// Factor of the (fitted) coordinates, applied after --offset and --w are added.
    #[arg(
        long,
        value_name = "S",
        default_value_t = NewtonOptions::default().scale,
        allow_hyphen_values = true
    )]
    scale: f64,
    /// Vector that is added to the (fitted) coordinates.
    #[arg(
        long,
        value_name = "X,Y,Z",
        default_value_t = Numbers(NewtonOptions::default().offset),
        allow_hyphen_values = true,
        value_parser = |text: &str| parse::numbers::<3>(text).map(Numbers)
    )]
    offset: Numbers<3>,
    /// Number of iterations of Newton's method.
    #[arg(long, value_name = "N", default_value_t = NewtonOptions::default().iterations)]
    iterations: u32,
    /// Parameter theta of the gradient: the larger it is, the earlier a point counts as not
    /// converged.
    #[arg(
        long,
        value_name = "THETA",
        default_value_t = NewtonOptions::default().theta,
        allow_hyphen_values = true
    )]
    theta: f64,
    /// Gradient: equation 7.3 of the thesis (thesis), or that of its authors' shader (shader).
    #[arg(
        value_enum,
        long,
        value_name = "WHICH",
        default_value_t = variant(NewtonOptions::default().gradient)
    )]
    gradient: Formula,
    #[arg(
        long,
        value_name = "SIZE",
        value_parser = size,
        help = stated(
            "Number of pixels, texels or voxels: N along each side, or WIDTHxHEIGHT",
            format_args!("{PIXELS}; for voxels {VOXELS}")
        )
    )]
    size: Option<(u32, u32)>,
    /// Use the coordinates of a mesh as they are, instead of fitting them into --extent.
    #[arg(long, requires = "mesh", conflicts_with = "extent")]
    no_fit: bool,
    /// Width of the part of the plane, of the volume, or of the box that a mesh is fitted into.
    #[arg(long, value_name = "WIDTH", default_value_t = 3.0)]
    extent: f64,
    /// Compute texels of the mesh's texture instead of vertices.
    #[arg(long, requires = "mesh")]
    uv: bool,
    /// Compute voxels of a cube around the origin.
    #[arg(long, conflicts_with_all = OF_MESHES)]
    volume: bool,
    /// Basins that --volume shows as a surface or a picture: `all`, or numbers of roots such as
    /// 0,4. Root (a, b) of n^2 has the number a n + b, from 0 [default: all].
    #[arg(
        long,
        value_name = "ROOTS",
        requires = "volume",
        conflicts_with_all = OF_MESHES,
        value_parser = Basins::parse
    )]
    basins: Option<Basins>,
    /// Opaque part of a picture of voxels: whole basins (solid), or points that converge slowly
    /// (slow) [default: solid with --basins, else slow].
    #[arg(long, value_name = "WHAT", requires = "volume", conflicts_with_all = OF_MESHES)]
    opacity: Option<Opacity>,
    /// Output file: .png for a plane or texels, or with --frames .apng or .gif; a mesh with colours
    /// for vertices. For voxels: .vti (ParaView; roots and convergence), .nrrd (roots), a mesh (the
    /// closed surfaces of basins), or a table of roots such as .npy, with a line of voxels in each
    /// row (numpy: reshape(N, N, N), indices z, y, x).
    #[arg(
        short,
        long,
        value_name = "FILE",
        required_unless_present_any = ["picture", "heights", "write_material"]
    )]
    output: Option<PathBuf>,
    /// Write the speed of convergence of each point: .png (16 bits, white is slow) for a plane or
    /// texels, .vti or .nrrd for voxels, else a table of numbers.
    #[arg(long, value_name = "FILE")]
    heights: Option<PathBuf>,
    /// Write the mesh with a material on its surface to this .glb or .gltf file: roots select the
    /// parts of the material, with joints where points converge slowly.
    #[arg(long, value_name = "FILE", requires = "uv")]
    write_material: Option<PathBuf>,
    /// Kind of material: enamel in the colours of the roots between lines of gold (enamel), or
    /// stone, metal and wood between dark joints (stones) [default: enamel].
    #[arg(long, value_name = "WHICH", requires = "write_material")]
    inlay: Option<Stuff>,
    /// Compress the numbers in .vti (zlib) and .nrrd (gzip).
    #[arg(long, requires = "volume", conflicts_with_all = OF_MESHES)]
    compress: bool,
    #[command(flatten)]
    repair: MeshArgs,
    #[command(flatten)]
    device: DeviceArgs,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    force: Force,
}

/// The coefficients of a polynomial, that of the highest power first.
#[derive(Debug, Clone)]
struct Coefficients(Vec<[f64; 2]>);

impl Coefficients {
    fn parse(text: &str) -> Result<Self, String> {
        expression::polynomial(text).map(Self)
    }
}

#[derive(Clone, Copy, ValueEnum)]
enum Formula {
    Thesis,
    Shader,
}

impl From<Formula> for Gradient {
    fn from(formula: Formula) -> Self {
        match formula {
            Formula::Thesis => Self::Thesis,
            Formula::Shader => Self::Shader,
        }
    }
}

/// Returns the power of the polynomial that is used by default.
fn power() -> u32 {
    match NewtonOptions::default().polynomial {
        Polynomial::Power(power) => power,
        other => unreachable!("{other:?} is no default for --power"),
    }
}

#[derive(Clone, Copy, Default, ValueEnum)]
enum Stuff {
    #[default]
    Enamel,
    Stones,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let options = options(args).map_err(|e| refused(e, args))?;
    let newton = Newton::new(&options).map_err(|e| refused(e, args))?;
    if let Some(w) = args.w_to {
        Newton::new(&options.clone().w(w)).context("--w-to")?;
    }
    let device = args.device.open()?;
    output::check_names(args)?;
    if let Some(basins) = &args.basins {
        basins.of(&newton)?;
    }
    let mut outputs = Outputs::create(args)?;
    let drawing = drawing(args)?;
    let par = args.threads.par();
    let bar = Bar::new("newton");
    let update = |fraction| bar.update(fraction);
    let all = fourth_coordinates(args);
    let share = |i: usize| i as f64 / all.len() as f64;
    let (mut time, mut points, mut unreached) = (Duration::ZERO, 0, 0);
    for (i, &w) in all.iter().enumerate() {
        let newton = Newton::new(&options.clone().w(w))?;
        let progress = Progress::new(&update).part(share(i)..share(i + 1));
        let start = Instant::now();
        let evaluated = progress.part(0.0..0.5);
        let fractal = evaluate(device.as_ref(), &newton, drawing.points(), par, evaluated)
            .map_err(|e| refused(e, args))?;
        time += start.elapsed();
        points += fractal.roots.len();
        unreached += fractal.unreached.len();
        outputs.add(&drawing, &newton, &fractal, par, progress.part(0.5..1.0))?;
    }
    outputs.finish()?;
    drop(bar);
    let (name, iterations) = (device.as_ref().map_or("cpu", device::name), args.iterations);
    status!(
        "points",
        count = points,
        unreached = unreached,
        device = name,
        iterations = iterations,
        seconds = time.as_secs_f64();
        "{points} on {name}, {iterations} iterations, {}",
        seconds(time)
    )?;
    device::report_times(device.as_ref())?;
    if unreached > 0 {
        let percent = 100.0 * unreached as f64 / points as f64;
        note(format_args!(
            "{unreached} of {points} points ({percent:.3} %) reach no root in {iterations} \
             iterations, and are black in pictures and colours: they are on the border of basins, \
             in a cycle, or need more iterations (--iterations). Numbers of roots and basins count \
             them to the nearest root"
        ));
    }
    for path in Outputs::names(args) {
        let path = path.display().to_string();
        status!("written", path = path; "{path}")?;
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
) -> catamaran::Result<Fractal> {
    match device {
        Some(device) => {
            catamaran_simulation::opencl::evaluate_newton(device, newton, points, progress)
        }
        None => newton.evaluate(points, par, progress),
    }
}

#[cfg(not(feature = "opencl"))]
fn evaluate(
    device: Option<&Device>,
    newton: &Newton,
    points: Points<'_>,
    par: Par,
    progress: Progress<'_>,
) -> catamaran::Result<Fractal> {
    match device {
        Some(device) => match *device {},
        None => newton.evaluate(points, par, progress),
    }
}

/// Names the options that an error of the library is about.
fn refused(error: Error, args: &Args) -> anyhow::Error {
    match error {
        Error::Argument { what: "polynomial", why } if !args.roots.is_empty() => {
            anyhow!("--roots: {why}")
        }
        Error::Argument { what: "polynomial", why } if args.polynomial.is_none() => {
            anyhow!("--power: {why}")
        }
        Error::Argument { what: "points", why } if args.volume => {
            let side = args.size.map_or(VOXELS, |(side, _)| side);
            anyhow!("--size: {side}^3 voxels {why}")
        }
        Error::Argument { what: "grid" | "points", why } => anyhow!("--size: {why}"),
        Error::NonFinite { what: "grid" | "points", .. } => {
            anyhow!("--extent, --offset, --w, --scale: coordinates must be within 1e9 of 0")
        }
        error => as_option(error),
    }
}

fn options(args: &Args) -> catamaran::Result<NewtonOptions> {
    let polynomial = match &args.polynomial {
        Some(Coefficients(coefficients)) => Polynomial::from_coefficients(coefficients)?,
        None if args.roots.is_empty() => Polynomial::Power(args.power),
        None => Polynomial::Roots(args.roots.clone()),
    };
    Ok(NewtonOptions::new()
        .polynomial(polynomial)
        .iterations(args.iterations)
        .theta(args.theta)
        .gradient(args.gradient.into())
        .scale(args.scale)
        .offset(args.offset.0)
        .w(args.w))
}

/// Returns the fourth coordinate of each frame.
fn fourth_coordinates(args: &Args) -> Vec<f64> {
    let (Some(count), Some(end)) = (args.frames, args.w_to) else { return vec![args.w] };
    let steps = count.saturating_sub(1).max(1) as f64;
    (0..count).map(|i| args.w + (end - args.w) * i as f64 / steps).collect()
}

fn drawing(args: &Args) -> Result<Drawing> {
    if args.extent <= 0.0 || !args.extent.is_finite() {
        bail!("--extent {}: a finite number above 0 is needed", args.extent);
    }
    if args.scale == 0.0 {
        bail!("--scale 0: makes one point of all; another number is needed");
    }
    let side = if args.volume { VOXELS } else { PIXELS };
    let (width, height) = args.size.unwrap_or((side, side));
    if args.volume {
        if width != height {
            bail!("--size {width}x{height}: a volume needs the same number along each side");
        }
        return Ok(Drawing::Voxels { grid: Grid::cube(width, args.extent) });
    }
    let Some(path) = &args.mesh else {
        return Ok(Drawing::Plane { grid: Grid::plane(width, height, [0.0; 2], args.extent) });
    };
    let mut file = crate::decimate::read(path, &args.repair)?;
    let named = || path.display().to_string();
    if file.mesh.faces().is_empty() && (args.uv || args.picture.path().is_some()) {
        bail!("{}: has no faces, which textures and pictures show", named());
    }
    if args.write_material.is_some() {
        // A relief crosses seams, for which the texture must not repeat.
        let within = file.uv.as_ref().map(slime::fitted);
        if within != file.uv {
            note(format_args!("{}: texture coordinates are scaled into 0 to 1", named()));
        }
        file.uv = within;
    }
    let fitted = match args.no_fit {
        true => file.mesh.clone(),
        false => fitted(&file.mesh, args.extent).with_context(named)?,
    };
    if !args.uv {
        let positions = fitted.vertices().iter().map(|p| p.map(|x| x as f32)).collect();
        return Ok(Drawing::Vertices { file: Box::new(file), positions });
    }
    let uv = file.uv.as_ref().context("no texture coordinates (--uv)").with_context(named)?;
    let texels = texels(&fitted, uv, width, height).with_context(named)?;
    if args.write_material.is_none() && slime::fitted(uv) != *uv {
        note(format_args!(
            "{}: parts with texture coordinates outside of 0 to 1 are not in the texture \
             (--write-material scales them into it)",
            named()
        ));
    }
    let bare = (0..fitted.faces().len()).filter(|&f| uv.of_face(&fitted, f).is_none()).count();
    if bare > 0 {
        note(format_args!(
            "{}: {bare} of {} faces have no texture coordinates, and are not in the texture",
            named(),
            fitted.faces().len()
        ));
    }
    if texels.shared > 0 {
        note(format_args!(
            "{}: faces overlap in the texture: {} of {} texels belong to several faces, and show \
             the first one",
            named(),
            texels.shared,
            texels.numbers.len()
        ));
    }
    let (width, height) = (width as usize, height as usize);
    Ok(Drawing::Texels { file: Box::new(file), texels, width, height })
}

/// Moves and scales the mesh: its bounding box then has its centre at the origin and a longest side
/// of `extent`.
fn fitted(mesh: &TriMesh, extent: f64) -> catamaran::Result<TriMesh> {
    let (mut vertices, faces) = mesh.normalized(Normalization::UnitBox)?.into_parts();
    vertices.as_flattened_mut().iter_mut().for_each(|x| *x *= extent);
    TriMesh::new(vertices, faces)
}

/// Parses `N` or `WIDTHxHEIGHT`.
fn size(text: &str) -> Result<(u32, u32), String> {
    let (width, height) = text.split_once('x').unwrap_or((text, text));
    let side = |text: &str| match text.trim().parse::<u32>() {
        Ok(n @ 1..=65_536) => Ok(n),
        Ok(n) => Err(format!("expected sides from 1 to 65,536, not {n}")),
        Err(e) => Err(format!("expected N or WIDTHxHEIGHT, such as 800x600: {e}")),
    };
    Ok((side(width)?, side(height)?))
}
