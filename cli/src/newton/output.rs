//! Writes a fractal as pictures, meshes, volumes and tables.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use catamaran::Par;
use catamaran::base::Progress;
use catamaran::faer::MatRef;
use catamaran::io::{self as files, Output};
use catamaran_geometry::mesh::TriMesh;
use catamaran_geometry::mesh::io::{self as meshes, MeshFile, MeshFormat};
use catamaran_simulation::texture::newton::{
    Fractal, Grid, Inlay, Newton, Points, Texels, UNREACHED_COLOR, VolumeFormat, Voxels, darkened,
    root_color, write_volume,
};

use super::voxels::{self, Opacity, Transfer};
use super::{Args, Stuff};
use crate::output;
use crate::picture::{
    AnimationFormat, Frames, Image, Paint, PictureFormat, RATE, Scene, Up, frame_names,
    render_volume, write_gray,
};
use crate::report::report;

/// The colour of texels without a surface.
const NOTHING: [u8; 3] = [0; 3];

/// The points to compute, and the kind of drawing.
pub enum Drawing {
    Plane { grid: Grid },
    Vertices { file: Box<MeshFile>, positions: Vec<[f32; 3]> },
    Texels { file: Box<MeshFile>, texels: Texels, width: usize, height: usize },
    Voxels { grid: Grid },
}

impl Drawing {
    pub fn points(&self) -> Points<'_> {
        match self {
            Self::Plane { grid } | Self::Voxels { grid } => Points::Grid(*grid),
            Self::Vertices { positions, .. } => Points::List(positions),
            Self::Texels { texels, .. } => Points::List(&texels.positions),
        }
    }

    /// Returns the width and height of the picture, if the drawing is one.
    fn pixels(&self) -> Option<(usize, usize)> {
        match self {
            Self::Plane { grid } => Some((grid.counts[0] as usize, grid.counts[1] as usize)),
            Self::Texels { width, height, .. } => Some((*width, *height)),
            Self::Vertices { .. } | Self::Voxels { .. } => None,
        }
    }

    /// Returns values of points as values of pixels.
    fn spread<T: Copy>(&self, values: Vec<T>, nothing: T) -> Vec<T> {
        let Self::Texels { texels, width, height, .. } = self else { return values };
        let mut all = vec![nothing; width * height];
        for (&number, value) in texels.numbers.iter().zip(values) {
            all[number as usize] = value;
        }
        all
    }
}

/// Returns whether the name of a file is that of a picture.
fn is_png(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"))
}

/// Returns whether the name of a file is that of a mesh.
fn is_mesh(path: &Path) -> bool {
    MeshFormat::of(path).is_ok()
}

/// Refuses names of files that do not fit their content, and options without the options that they
/// need.
pub fn check_names(args: &Args) -> Result<()> {
    let is_picture = args.uv || (args.mesh.is_none() && !args.volume);
    let is_image = |path: &Path| is_png(path) || AnimationFormat::of(path).is_some();
    if args.size.is_some() && !is_picture && !args.volume {
        bail!("--size is for a plane, a texture (--uv) and --volume only: MESH has its vertices");
    }
    if let Some(path) = &args.output {
        let name = path.display();
        if is_picture {
            if !is_image(path) {
                bail!("{name}: a plane or a texture is written as .png, .apng or .gif");
            }
        } else if AnimationFormat::of(path).is_some() {
            bail!("{name}: only --picture writes animations of meshes and volumes");
        } else if !args.volume {
            meshes::check_name(path)?;
        } else if !is_mesh(path) {
            check_voxels(path, "voxels are written as .vti, .nrrd, a mesh such as .ply")?;
        }
    }
    match args.heights.as_deref() {
        Some(path) if args.volume => {
            check_voxels(path, "the convergence of voxels is written as .vti, .nrrd")?;
        }
        Some(path) if !(is_picture && is_png(path)) => files::check_name(path)?,
        _ => {}
    }
    if let Some(path) = args.picture.path() {
        if is_picture {
            bail!("--picture shows vertices or voxels: it needs MESH or --volume, and not --uv");
        }
        if PictureFormat::of(path).is_none() && AnimationFormat::of(path).is_none() {
            let name = path.display();
            bail!("{name}: the name of a picture must end in .png, .svg, .apng or .gif");
        }
    }
    if let Some(path) = &args.write_material {
        if !matches!(MeshFormat::of(path), Ok(MeshFormat::Gltf(_))) {
            bail!("{}: a material is written as .glb or .gltf", path.display());
        }
        if let Some((width, height)) = args.size.filter(|(width, height)| width != height) {
            bail!("--size {width}x{height}: the textures of a material are square");
        }
    }
    let draws_volume = args.volume && args.picture.path().is_some() && !args.draws_surface();
    if args.opacity.is_some() && !draws_volume {
        bail!("--opacity is for pictures of voxels: it needs --picture, and no mesh as -o");
    }
    if args.basins.is_some() && !draws_volume && !args.draws_surface() {
        bail!(
            "--basins chooses what a surface or a picture shows: it needs a mesh as -o, or --picture"
        );
    }
    let files = [args.output.as_deref(), args.picture.path()];
    if args.fps.is_some() && !files.into_iter().flatten().any(|p| AnimationFormat::of(p).is_some())
    {
        bail!("--fps is for animations: it needs an output named .apng or .gif");
    }
    let volume_file = |path: &PathBuf| VolumeFormat::of(path, true).is_some();
    if args.compress && ![&args.output, &args.heights].into_iter().flatten().any(volume_file) {
        bail!("--compress is for .vti and .nrrd: it needs such an output");
    }
    Ok(())
}

/// Refuses the name of a file that is neither an array of voxels nor a table; `kinds` are those
/// that it may have instead.
fn check_voxels(path: &Path, kinds: &str) -> Result<()> {
    if VolumeFormat::of(path, false).is_none() && files::check_name(path).is_err() {
        bail!("{}: {kinds} or a table such as .npy; --picture draws them", path.display());
    }
    Ok(())
}

impl Args {
    /// Returns whether the output is the surface of basins.
    pub fn draws_surface(&self) -> bool {
        self.volume && self.output.as_deref().is_some_and(is_mesh)
    }
}

/// Files that are about to be written.
pub struct Outputs<'a> {
    args: &'a Args,
    output: Option<Frames>,
    heights: Option<Frames>,
    picture: Option<Frames>,
    material: Option<Frames>,
    /// The transfer function of the first frame.
    transfer: Option<Transfer>,
}

impl<'a> Outputs<'a> {
    pub fn create(args: &'a Args) -> Result<Self> {
        let rate = args.fps.unwrap_or(RATE);
        let create = |path: &Path| Frames::create(path, args.frames, rate, args.force);
        Ok(Self {
            args,
            output: args.output.as_deref().map(create).transpose()?,
            heights: args.heights.as_deref().map(create).transpose()?,
            picture: args.picture.path().map(create).transpose()?,
            material: args.write_material.as_deref().map(create).transpose()?,
            transfer: None,
        })
    }

    /// Returns the names of all files.
    pub fn names(args: &Args) -> Vec<PathBuf> {
        let [output, heights, material] =
            [&args.output, &args.heights, &args.write_material].map(Option::as_deref);
        let all = [output, heights, args.picture.path(), material];
        all.into_iter().flatten().flat_map(|path| frame_names(path, args.frames)).collect()
    }

    /// Writes a frame.
    pub fn add(
        &mut self,
        drawing: &Drawing,
        newton: &Newton,
        fractal: &Fractal,
        par: Par,
        progress: Progress<'_>,
    ) -> Result<()> {
        if let Some(heights) = &mut self.heights {
            write_heights(heights.file()?, drawing, newton, fractal, self.args.compress)?;
        }
        if let (Drawing::Texels { file, texels, width, .. }, Some(material)) =
            (drawing, &mut self.material)
        {
            let uv = file.uv.as_ref().context("no texture coordinates")?;
            let inlay = match self.args.inlay.unwrap_or_default() {
                Stuff::Enamel => Inlay::enamel(newton.roots()),
                Stuff::Stones => Inlay::stones(),
            };
            let source = self.args.mesh.as_deref().unwrap_or(Path::new(""));
            let made = newton
                .material(&file.mesh, uv, texels, *width, fractal, &inlay, par)
                .with_context(|| source.display().to_string())?;
            output::mesh_with_material(material.file()?, file, &made)?;
        }
        match drawing {
            Drawing::Plane { .. } | Drawing::Texels { .. } => {
                let Some(output) = &mut self.output else { return Ok(()) };
                let (width, _) = drawing.pixels().context("not a picture")?;
                let colors = drawing.spread(colors(newton, fractal), NOTHING);
                output.image(&Image::from_pixels(width, colors))
            }
            Drawing::Vertices { file, .. } => {
                let colors = colors(newton, fractal);
                let source = self.args.mesh.as_deref().unwrap_or(Path::new(""));
                self.draw_mesh(&file.mesh, &colors, source)?;
                let Some(output) = &mut self.output else { return Ok(()) };
                let channel = |c: u8| f64::from(c) / 255.0;
                let colors = colors.iter().map(|c| c.map(channel));
                let mut file = MeshFile::clone(file);
                file.colors = Some(colors.map(|[r, g, b]| [r, g, b, 1.0]).collect());
                Ok(output::mesh(output.file()?, &file)?)
            }
            Drawing::Voxels { grid } => self.add_voxels(grid, newton, fractal, par, progress),
        }
    }

    fn add_voxels(
        &mut self,
        grid: &Grid,
        newton: &Newton,
        fractal: &Fractal,
        par: Par,
        progress: Progress<'_>,
    ) -> Result<()> {
        let args = self.args;
        let basins = args.basins.as_ref().map(|basins| basins.of(newton)).transpose()?;
        let all: Vec<u16> = (0..newton.roots().pow(2) as u16).collect();
        let shown = basins.as_deref().unwrap_or(&all);
        if let (true, Some(path)) = (args.draws_surface(), &args.output) {
            let file = voxels::surfaces(newton, grid, fractal, shown, par, progress)?;
            let (vertices, faces) = (file.mesh.vertices().len(), file.mesh.faces().len());
            let volume = file.mesh.volume();
            let text = volume.map_or_else(String::new, |volume| format!(", volume {volume:.6}"));
            report!(
                "surface",
                vertices = vertices,
                faces = faces,
                volume = volume;
                "{vertices} vertices, {faces} faces{text}"
            )?;
            let byte = |c: f64| (255.0 * c).round() as u8;
            let colors = file.colors.iter().flatten();
            let colors: Vec<_> = colors.map(|&[r, g, b, _]| [r, g, b].map(byte)).collect();
            self.draw_mesh(&file.mesh, &colors, path)?;
            let Some(output) = &mut self.output else { return Ok(()) };
            return Ok(output::mesh(output.file()?, &file)?);
        }
        if let Some(picture) = &mut self.picture {
            let solid = if basins.is_some() { Opacity::Solid } else { Opacity::Slow };
            let opacity = args.opacity.unwrap_or(solid);
            let transfer = *self.transfer.get_or_insert_with(|| Transfer::new(newton, fractal));
            let volume = voxels::volume(newton, grid, fractal, shown, opacity, transfer);
            let view = args.picture.view(Up::Y);
            let threads = par.threads();
            picture.image(&render_volume(&volume, &view, PICTURE, threads, progress)?)?;
        }
        let Some(output) = &mut self.output else { return Ok(()) };
        let output = output.file()?;
        if let Some(format) = VolumeFormat::of(output.path(), args.compress) {
            let arrays = [Voxels::Roots(&fractal.roots), Voxels::Convergence(&fractal.convergence)];
            // NRRD holds one array.
            let count = if matches!(format, VolumeFormat::Vti { .. }) { 2 } else { 1 };
            return Ok(write_volume(output, format, grid, &arrays[..count])?);
        }
        let numbers: Vec<f32> = fractal.roots.iter().copied().map(f32::from).collect();
        Ok(files::write(output, lines(&numbers, grid.counts[0] as usize))?)
    }

    /// Draws a mesh, if a picture is requested.
    fn draw_mesh(&mut self, mesh: &TriMesh, colors: &[[u8; 3]], source: &Path) -> Result<()> {
        let Some(picture) = &mut self.picture else { return Ok(()) };
        let panels = [(mesh, Paint::Colors(colors), "")];
        picture.image(&self.args.picture.image(source, &panels, Scene::default())?)
    }

    /// Completes animations.
    pub fn finish(self) -> Result<()> {
        let all = [self.output, self.heights, self.picture, self.material];
        all.into_iter().flatten().try_for_each(Frames::finish)
    }
}

/// Width and height of a picture of a volume, in pixels.
const PICTURE: (usize, usize) = (800, 800);

/// Returns values of points as a matrix with this number of columns: a line of points in each row.
fn lines(values: &[f32], columns: usize) -> MatRef<'_, f32> {
    MatRef::from_row_major_slice(values, values.len() / columns.max(1), columns)
}

fn write_heights(
    output: Output,
    drawing: &Drawing,
    newton: &Newton,
    fractal: &Fractal,
    compress: bool,
) -> Result<()> {
    if let (Drawing::Voxels { grid }, Some(format)) =
        (drawing, VolumeFormat::of(output.path(), compress))
    {
        let array = Voxels::Convergence(&fractal.convergence);
        return Ok(write_volume(output, format, grid, &[array])?);
    }
    if let (true, Some((width, height))) = (is_png(output.path()), drawing.pixels()) {
        let gray = |&t: &f32| (65535.0 * newton.share(t)).round() as u16;
        let values = drawing.spread(fractal.convergence.iter().map(gray).collect(), 0);
        return write_gray(output, width, height, &values);
    }
    let values = drawing.spread(fractal.convergence.clone(), f32::NAN);
    let width = match drawing {
        Drawing::Voxels { grid } => grid.counts[0] as usize,
        _ => drawing.pixels().map_or(1, |(width, _)| width),
    };
    Ok(files::write(output, lines(&values, width))?)
}

/// Returns the colours of points: those of their roots, darker the slower the points converge, and
/// a separate one for points that reach no root.
pub fn colors(newton: &Newton, fractal: &Fractal) -> Vec<[u8; 3]> {
    let n = newton.roots();
    let palette: Vec<_> = (0..n * n).map(|root| root_color(root as u16, n)).collect();
    let all = fractal.roots.iter().zip(&fractal.convergence);
    let color = |(&root, &t): (&u16, &f32)| darkened(palette[usize::from(root)], newton.share(t));
    let mut colors: Vec<[u8; 3]> = all.map(color).collect();
    for &i in &fractal.unreached {
        colors[i as usize] = UNREACHED_COLOR;
    }
    colors
}
