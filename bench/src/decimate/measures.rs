//! What a decimated mesh is like.

use catamaran::Par;
use catamaran::decimate::{Difference, Quality};
use catamaran::mesh::{Components, TriMesh};

use crate::Result;

/// What a decimated mesh is like.
#[derive(Debug, Clone)]
pub struct Measures {
    /// Vertices that a face has.
    pub vertices: usize,
    /// Faces.
    pub faces: usize,
    /// Connected components.
    pub components: usize,
    /// Uniformity.
    pub quality: Quality,
    /// Distances from the input.
    pub difference: Difference,
}

impl Measures {
    /// Of the decimation `made` of `input`.
    ///
    /// # Errors
    /// When nothing is left of it.
    pub fn new(input: &TriMesh, made: &TriMesh) -> Result<Self> {
        Ok(Self {
            vertices: made.vertices().len() - made.unreferenced_vertices().len(),
            faces: made.faces().len(),
            components: Components::new(made).len(),
            quality: Quality::of(made),
            difference: Difference::between(input, made, Par::all())?,
        })
    }
}
