//! Triangle meshes.

mod distance;
mod edges;
mod laplacian;
mod normals;
mod operators;
#[cfg(test)]
pub(crate) mod shapes;
mod trimesh;
pub(crate) mod vector;

pub use distance::{Dijkstra, Graph, HeatMethod, HeatOptions, SearchLimits};
pub use laplacian::{Boundary, Laplacian, LaplacianKind, LaplacianOptions, MassKind, laplacian};
pub use normals::{vertex_areas, vertex_normals};
pub use operators::{divergence, gradient};
pub use trimesh::TriMesh;
