//! Pictures as PNG: heat maps of matrices, and meshes coloured by a function.

mod color;
mod image;
mod matrix;
mod mesh;
mod text;

pub use mesh::{Paint, Panel, Scene, Up, View, render};
pub use matrix::{Scale, levels, write};
