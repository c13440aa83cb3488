//! Massive uniform decimation: farthest point sampling by Voronoi cells, their dual triangulation,
//! resampling (thesis, chapter 5).
//!
//! See docs/algorithms/decimate.md for the mathematics.

mod batches;
mod bound;
mod carry;
mod cells;
mod closest;
mod collapse;
mod curvature;
mod density;
mod difference;
mod dual;
mod farthest;
mod faults;
mod fit;
mod gaps;
mod guard;
mod handles;
mod lloyd;
mod locks;
mod loss;
mod mend;
mod options;
mod order;
mod patch;
mod prepare;
mod prolongation;
mod quadric;
mod quality;
mod refine;
mod relax;
mod resample;
mod resolve;
mod result;
mod size;
mod solver;
mod splits;
mod strips;
mod surface;
mod topology;
mod within;

pub use cells::Cells;
pub use curvature::curvature_density;
pub use difference::Difference;
pub use farthest::FarthestPoints;
pub use options::{DecimateOptions, Method};
pub use prepare::Repairs;
pub use quality::Quality;
pub use resample::{Resampled, resample};
pub use result::{Decimation, Topology};
pub use size::{edge_length_for, vertices_for_edge_length, vertices_for_faces};
pub use solver::{Decimator, decimate};
pub use within::decimate_within;
