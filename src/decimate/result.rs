use std::fmt;

use super::cells::Cells;
use super::prepare::Repairs;
use crate::mesh::{Genus, TriMesh};

/// The result of a decimation.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Decimation {
    /// The new mesh.
    pub mesh: TriMesh,
    /// For each vertex of the input its nearest vertex of the new mesh, along edges, with the
    /// distance. When there are nearly as many vertices as in the input, a cell may be empty.
    pub cells: Cells,
    /// The place on the input nearest to each vertex of the new mesh, which is beside it by half
    /// the height of the input above the faces around it.
    pub places: Vec<Place>,
    /// What had to be done to the input first.
    pub repairs: Repairs,
    /// The topology of the input, after repairs.
    pub before: Topology,
    /// The topology of the new mesh; `None` when it is not a manifold, which only
    /// [`Method::Thesis`](super::Method::Thesis) makes.
    pub after: Option<Topology>,
}

/// A point on a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Its face.
    pub face: u32,
    /// Its barycentric coordinates there, from 0 to 1, of sum 1.
    pub weights: [f64; 3],
}

impl Place {
    /// Returns the value here of a function that is linear on the face and has these values at its
    /// corners.
    pub(super) fn mix<const N: usize>(&self, values: [[f64; N]; 3]) -> [f64; N] {
        std::array::from_fn(|k| (0..3).map(|i| self.weights[i] * values[i][k]).sum())
    }

    /// Returns the corner of the face that the place is nearest to in these coordinates, 0 to 2.
    pub(super) fn heaviest(&self) -> usize {
        (0..3).max_by(|&i, &j| self.weights[i].total_cmp(&self.weights[j])).unwrap_or(0)
    }
}

/// The topology of a surface: what deformations leave as it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Topology {
    /// Connected components.
    pub components: usize,
    /// Boundary loops.
    pub boundary_loops: usize,
    /// Handles, or cross-caps.
    pub genus: Genus,
}

impl fmt::Display for Topology {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { components, boundary_loops, genus } = self;
        write!(f, "components {components}, boundary loops {boundary_loops}, genus {genus}")
    }
}
