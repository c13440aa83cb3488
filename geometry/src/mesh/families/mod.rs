//! Generated meshes with known counts, genus and boundary, for tests and demonstrations.
//!
//! All faces are counter-clockwise as seen from outside (for flat surfaces, from above). V and F
//! are the numbers of vertices and faces; a closed orientable surface of genus g has
//! V = F / 2 + 2 - 2 g. The same arguments give the same mesh, except for the last bits on machines
//! that round sines differently.

mod bent;
mod broken;
mod by_name;
mod closed;
mod draft;
mod figure;
mod flat;
mod voxels;

pub use bent::{Bend, bent};
pub use broken::{bow_tie, pages, slivers, soup, split_sphere};
pub use by_name::by_name;
pub use closed::{genus, icosphere, knot, spheres, torus};
pub use figure::figure;
pub use flat::{cylinder, disk, grid, moebius, terrain};
