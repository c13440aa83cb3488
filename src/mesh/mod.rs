//! Triangle meshes.

mod trimesh;

pub use trimesh::TriMesh;
