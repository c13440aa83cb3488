//! What is made of a fractal: pictures, meshes, tables.

use std::path::Path;

use anyhow::{Context, Result, bail};
use catamaran::faer::MatRef;
use catamaran::io::{self as files, Output, Overwrite};
use catamaran::mesh::io::{self as meshes, MeshFile};
use catamaran::texture::newton::{Fractal, Grid, Newton, Points, Texels, darkened, root_color};

use super::Args;
use crate::output;
use crate::picture::{Image, write_gray};

/// Where no surface is.
const NOTHING: [u8; 3] = [0; 3];

/// What is computed, and what it is drawn as.
pub enum Drawing {
    Plane { grid: Grid },
    Vertices { file: Box<MeshFile>, positions: Vec<[f32; 3]> },
    Texels { texels: Texels, width: usize, height: usize },
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

    /// Width and height of the picture, if it is one.
    fn pixels(&self) -> Option<(usize, usize)> {
        match self {
            Self::Plane { grid } => Some((grid.counts[0] as usize, grid.counts[1] as usize)),
            Self::Texels { width, height, .. } => Some((*width, *height)),
            Self::Vertices { .. } | Self::Voxels { .. } => None,
        }
    }

    /// Values of points as values of pixels.
    fn spread<T: Copy>(&self, values: Vec<T>, nothing: T) -> Vec<T> {
        let Self::Texels { texels, width, height } = self else { return values };
        let mut all = vec![nothing; width * height];
        for (&number, value) in texels.numbers.iter().zip(values) {
            all[number as usize] = value;
        }
        all
    }
}

/// Whether the files are called what they will be.
pub fn check_names(args: &Args) -> Result<()> {
    let is_png = |path: &Path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
    let is_picture = args.uv || (args.mesh.is_none() && !args.volume);
    let output = args.output.as_path();
    if is_picture && !is_png(output) {
        bail!("{}: a plane, or texels, are written as .png", output.display());
    }
    if args.volume {
        files::check_name(output)?;
    } else if !is_picture {
        meshes::check_name(output)?;
    }
    if let Some(heights) = args.heights.as_deref()
        && !(is_picture && is_png(heights))
    {
        files::check_name(heights)?;
    }
    Ok(())
}

/// Files that are about to be written.
pub struct Job {
    output: Output,
    heights: Option<Output>,
}

impl Job {
    pub fn create(output: &Path, heights: Option<&Path>, overwrite: Overwrite) -> Result<Self> {
        let heights = heights.map(|path| Output::create(path, overwrite)).transpose()?;
        Ok(Self { output: Output::create(output, overwrite)?, heights })
    }

    /// Writes them.
    pub fn write(self, drawing: &Drawing, newton: &Newton, fractal: &Fractal) -> Result<()> {
        if let Some(heights) = self.heights {
            write_heights(heights, drawing, newton, fractal)?;
        }
        match drawing {
            Drawing::Plane { .. } | Drawing::Texels { .. } => {
                let (width, _) = drawing.pixels().context("not a picture")?;
                let colors = drawing.spread(colors(newton, fractal), NOTHING);
                Image::from_pixels(width, colors).write_png(self.output)
            }
            Drawing::Vertices { file, .. } => {
                let channel = |c: u8| f64::from(c) / 255.0;
                let colors = colors(newton, fractal).into_iter();
                let colors = colors.map(|[r, g, b]| [channel(r), channel(g), channel(b), 1.0]);
                let mut file = MeshFile::clone(file);
                file.colors = Some(colors.collect());
                Ok(output::mesh(self.output, &file)?)
            }
            Drawing::Voxels { grid } => {
                let numbers: Vec<f32> = fractal.roots.iter().copied().map(f32::from).collect();
                Ok(files::write(self.output, lines(&numbers, grid.counts[0] as usize))?)
            }
        }
    }
}

/// Values of points as a matrix of so many columns: a line of them a row.
fn lines(values: &[f32], columns: usize) -> MatRef<'_, f32> {
    MatRef::from_row_major_slice(values, values.len() / columns.max(1), columns)
}

fn write_heights(
    output: Output,
    drawing: &Drawing,
    newton: &Newton,
    fractal: &Fractal,
) -> Result<()> {
    let is_png = output.path().extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
    if let (true, Some((width, height))) = (is_png, drawing.pixels()) {
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

/// The colours of points: of their roots, darker the slower they converge.
pub fn colors(newton: &Newton, fractal: &Fractal) -> Vec<[u8; 3]> {
    let n = newton.roots();
    let palette: Vec<_> = (0..n * n).map(|root| root_color(root as u16, n)).collect();
    let all = fractal.roots.iter().zip(&fractal.convergence);
    all.map(|(&root, &t)| darkened(palette[usize::from(root)], newton.share(t))).collect()
}
