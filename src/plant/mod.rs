//! Plants that lose water and wilt (thesis, chapter 4; docs/algorithms/plant.md): their graph and files, the water in them,
//! and the rods that bend as it goes.

mod bdf;
mod curve;
mod elasticity;
mod elimination;
pub mod families;
mod fit;
mod graph;
mod levenberg;
mod rational;
mod read;
mod rods;
mod spectral;
mod sway;
mod tubes;
mod water;
mod wilt;
mod wind;

pub use bdf::{Bdf6, Start};
pub use curve::{CurveOptions, Interval, Method, water_curve};
pub use elasticity::Elasticity;
pub use fit::{Estimate, Fit, FitOptions, Measurements, fit};
pub use graph::{Plant, Segment};
pub use read::{PlantFormat, read, read_bytes, read_with};
pub use rods::{Motion, MotionOptions, Pose, RelaxOptions, Relaxation, RodOptions, Rods};
pub use spectral::SpectralSolution;
pub use sway::{Sway, SwayOptions, sway};
pub use tubes::tubes;
pub use water::{Conductivity, WaterModel, WaterOptions, grams_per_hour};
pub use wilt::{WiltOptions, Wilting, wilt};
pub use wind::{Gusts, Wind};
