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
    /// For each vertex of the input, the nearest vertex of the new mesh along edges, with the
    /// distance. A cell may be empty when there are nearly as many vertices as in the input.
    pub cells: Cells,
    /// For each vertex of the new mesh, the nearest point of the input. The vertex is off the input
    /// by half of the height of the input above the surrounding faces.
    pub places: Vec<Place>,
    /// The repairs of the input before decimation.
    pub repairs: Repairs,
    /// The topology of the input, after repairs.
    pub before: Topology,
    /// The topology of the new mesh; `None` when it is not a manifold, which only happens with
    /// [`Method::Thesis`](super::Method::Thesis).
    pub after: Option<Topology>,
}

/// A point on a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// The face of the point.
    pub face: u32,
    /// Its barycentric coordinates in the face, from 0 to 1, with sum 1.
    pub weights: [f64; 3],
}

impl Place {
    /// Returns the value at this point of a function that is linear on the face and has these
    /// values at its corners.
    pub(super) fn mix<const N: usize>(&self, values: [[f64; N]; 3]) -> [f64; N] {
        std::array::from_fn(|k| (0..3).map(|i| self.weights[i] * values[i][k]).sum())
    }

    /// Returns the corner of the face with the largest barycentric coordinate, 0 to 2.
    pub(super) fn heaviest(&self) -> usize {
        (0..3).max_by(|&i, &j| self.weights[i].total_cmp(&self.weights[j])).unwrap_or(0)
    }
}

/// The topology of a surface, which deformations do not change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Topology {
    /// Number of connected components.
    pub components: usize,
    /// Number of boundary loops.
    pub boundary_loops: usize,
    /// Number of handles, or of cross-caps.
    pub genus: Genus,
}

impl fmt::Display for Topology {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { components, boundary_loops, genus } = self;
        write!(f, "components {components}, boundary loops {boundary_loops}, genus {genus}")
    }
}
