//! Pictures as PNG or SVG: heat maps of matrices, meshes coloured by a function, volumes, charts;
//! animations.

mod animation;
mod args;
mod color;
mod format;
mod image;
mod matrix;
mod mesh;
mod plot;
mod text;
mod tube;
mod volume;

pub use animation::{
    Format as AnimationFormat, Frames, RATE, names as frame_names, rate as frame_rate,
};
pub use args::PictureArgs;
pub use color::{ColorMap, ColorScale};
pub use format::{Format as PictureFormat, create};
pub use image::{Image, write_gray};
pub use matrix::{Scale, levels, write};
pub use mesh::up::guess as guess_up;
pub use mesh::{Material, Paint, Panel, Projection, Scene, Texture, Up, View, render};
pub use plot::write_chart;
pub use tube::with_curves;
pub use volume::{Volume, render_volume};

use catamaran::faer::Mat;

/// The paint of a surface that shows nothing but its shape.
pub const PLAIN: Paint<'static> = Paint::Plain([205, 214, 224]);

/// Returns the first column of functions on a mesh, for drawing.
pub fn first_column(functions: &Mat<f64>) -> Vec<f64> {
    functions.col_iter().next().map_or_else(Vec::new, |column| column.iter().copied().collect())
}
