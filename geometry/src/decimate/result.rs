use std::fmt;

use super::cells::Cells;
use super::prepare::Repairs;
use crate::mesh::{Genus, SurfacePoint, TriMesh};

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
    pub places: Vec<SurfacePoint>,
    /// Number of locked vertices, the first ones of the new mesh: those of the options in their
    /// order, then further parts of those that repairs split.
    pub locked: usize,
    /// Number of edges of the input between locked vertices.
    pub locked_edges: usize,
    /// Number of these edges that the new mesh does not have: edges longer than those of the new
    /// mesh, which were split.
    pub lost_edges: usize,
    /// The repairs of the input before decimation.
    pub repairs: Repairs,
    /// The topology of the input, after repairs.
    pub before: Topology,
    /// The topology of the new mesh; `None` when it is not a manifold, which only happens with
    /// [`Method::Thesis`](super::Method::Thesis).
    pub after: Option<Topology>,
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
