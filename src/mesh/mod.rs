//! Triangle meshes: what they are made of, how they hang together, what is wrong with them, files, and generated ones.

mod distance;
mod edges;
pub mod families;
pub mod io;
mod laplacian;
mod measure;
mod normals;
mod operators;
mod parts;
#[cfg(test)]
pub(crate) mod shapes;
pub mod topology;
mod trimesh;
mod validation;
pub(crate) mod vector;

pub use distance::{Dijkstra, Graph, HeatMethod, HeatOptions, SearchLimits};
pub use laplacian::{Boundary, Laplacian, LaplacianKind, LaplacianOptions, MassKind, laplacian};
pub use measure::Normalization;
pub use normals::{vertex_areas, vertex_normals};
pub use operators::{divergence, gradient};
pub use parts::Part;
pub use topology::{Adjacency, Components, Edges, Genus};
pub use trimesh::TriMesh;
pub use validation::{Problem, Validation};
