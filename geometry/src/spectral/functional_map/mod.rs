//! Functional maps: linear maps from functions on a source to functions on a target, as matrices of
//! coefficients.
//!
//! A point-to-point map `points` holds, for each vertex of the target, a vertex of the source. Its
//! functional map takes a function f on the source to `f o points` on the target (Ovsjanikov et al.
//! 2012).

mod embedding;
mod fit;
mod nearest;
mod operators;
mod orientation;
mod points;
mod refine;
mod search;

#[doc(hidden)]
pub use fit::Correspondences;
pub use fit::MapFit;
pub use nearest::nearest_rows;
pub use points::{map_from_points, points_from_map, pull_back};
pub use refine::{Refined, icp, zoomout};
pub use search::{FoundMap, commutativity, search_map};
