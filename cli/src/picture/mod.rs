//! Pictures as PNG: heat maps of matrices, and meshes coloured by a function.

mod color;
mod image;
mod matrix;
// No command draws meshes yet; the tests do.
#[cfg_attr(not(test), expect(dead_code))]
mod mesh;
mod text;

pub use matrix::{Scale, levels, write};
