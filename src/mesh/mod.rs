//! Triangle meshes: what they are made of, how they hang together, what is wrong with them, files, and generated ones.

pub mod families;
pub mod io;
mod measure;
mod parts;
pub mod topology;
mod trimesh;
mod validation;

pub use measure::Normalization;
pub use parts::Part;
pub use topology::{Adjacency, Components, Edges, Genus};
pub use trimesh::TriMesh;
pub use validation::{Problem, Validation};
