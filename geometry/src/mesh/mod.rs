//! Triangle meshes: topology, measures, distances, Laplacians, validation, repair, files and
//! generated families.

mod cloud;
mod compare;
mod distance;
pub mod families;
pub(crate) mod intersections;
pub mod io;
mod isosurface;
mod laplacian;
mod masks;
mod measure;
mod operators;
mod parts;
mod point;
mod refined;
mod repair;
#[cfg(test)]
pub(crate) mod shapes;
pub(crate) mod slots;
pub mod topology;
mod trimesh;
mod validation;
pub mod vector;

pub use cloud::{CloudOptions, cloud_laplacian, cloud_laplacian_rows};
pub use compare::{Comparison, OneSided};
pub(crate) use compare::{Triangles, nearest_on_triangle, squares};
pub(crate) use distance::Search;
pub use distance::{
    Dijkstra, GeodesicPath, GeodesicTrace, Geodesics, Graph, HeatMethod, HeatOptions, SearchLimits,
    TraceEnd,
};
pub use isosurface::{Lattice, Rim, isosurface, label_surface, label_surface_by};
pub use laplacian::{
    Boundary, Laplacian, LaplacianKind, LaplacianOptions, MassKind, free_components, laplacian,
    laplacian_rows,
};
pub use measure::Normalization;
pub(crate) use measure::quality;
pub use operators::{divergence, gradient, vertex_areas};
pub use parts::Part;
pub use point::{Site, SurfacePoint};
pub(crate) use point::{interpolate, nearest_vertex};
pub use refined::{Origin, Refined};
pub(crate) use repair::manifold;
pub use repair::{
    RepairOptions, RepairReport, RepairStep, Repaired, Repairs, Weld, needs_repair, repair,
};
pub use topology::{Adjacency, Components, Edges, Genus};
pub use trimesh::TriMesh;
pub(crate) use trimesh::has_corner_twice;
pub use validation::{Problem, Validation};
