//! Closed and open curves on triangle meshes through samples without an order (thesis, chapter 6).
//!
//! [`Mode::Faithful`] is algorithm 6.1 with its maximum-angle heuristic: it grows the curve from
//! one sample to the next, and the curve can block its own way. [`Mode::Robust`] first determines
//! the order of all samples, and then finds paths that do not meet. The result is an [`Outcome`],
//! with the part of the curve that was found.
//!
//! ```
//! use catamaran_geometry::curve::{CurveOptions, CurveSolver, Outcome};
//! use catamaran_geometry::mesh::families;
//!
//! let mesh = families::torus(40, 20, 2.0, 0.8)?;
//! let mut solver = CurveSolver::new(&mesh)?;
//! // Vertices around the outer equator, not in order.
//! let found = solver.reconstruct(&[0, 400, 200, 600, 100, 700], &CurveOptions::default())?;
//! assert_eq!(found.outcome, Outcome::Closed);
//! # Ok::<(), catamaran::Error>(())
//! ```

mod cut;
pub mod dataset;
mod drawing;
mod faithful;
mod inscribe;
mod outliers;
mod places;
mod proximity;
mod refinement;
mod region;
mod result;
mod route;
mod sites;
mod smooth;
mod solver;
mod split;
mod surface;
#[cfg(test)]
mod tests;
mod tour;
mod walls;

pub use crate::mesh::Site;
pub use cut::cut;
pub use drawing::{Drawing, Drawn};
pub use inscribe::{Inscribed, inscribe};
pub use places::places;
pub use region::{Region, Side};
pub use result::{Curve, Outcome, Reconstruction, Waypoint, same_order};
pub use sites::{Placed, Placement, place, refined, with_steiner};
pub use smooth::{Smoothed, smooth};
pub use solver::{Count, CurveOptions, CurveSolver, Mode};

/// Compiles the code of the guide as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/guide/curves.md")]
struct Guide;
