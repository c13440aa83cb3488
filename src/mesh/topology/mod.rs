//! How the faces of a mesh are connected: adjacency, edges, components, boundary, genus,
//! orientation.
//!
//! A corner of a mesh is the number 3 f + i of corner i of face f; as an edge of that face it goes
//! from its vertex to the next one of the face. Everything here takes time and memory linear in the
//! size of the mesh, but for sorting the edges at each vertex. A function of a mesh that takes
//! [`Edges`] does so to save time: those of another mesh are not used.

mod adjacency;
mod boundary;
mod components;
mod edges;
mod orientation;
mod surface;

pub use adjacency::Adjacency;
pub use components::Components;
pub use edges::Edges;
pub(super) use edges::face_list;
pub use surface::Genus;
pub(super) use surface::genus_of;
