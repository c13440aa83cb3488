//! How the faces of a mesh are connected: adjacency, edges, components, boundary, genus,
//! orientation.
//!
//! Corner i of face f has the number 3 f + i, which also stands for the edge of the face from this
//! corner to the next one. Everything here takes time and memory linear in the size of the mesh,
//! except for sorting the edges at each vertex. A function of a mesh that takes [`Edges`] does so
//! to save time; if they belong to another mesh, it finds the edges itself.

mod adjacency;
mod boundary;
mod components;
mod edges;
mod orientation;
mod surface;

pub use adjacency::Adjacency;
pub(super) use adjacency::corners;
pub use components::Components;
pub use edges::Edges;
pub(super) use edges::face_list;
pub use surface::Genus;
pub(super) use surface::genus_of;
