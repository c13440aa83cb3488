//! Plants that lose water and wilt (thesis, chapter 4; docs/algorithms/plant.md): their graph and
//! files, the water in them, and rods that bend as water is lost.

mod bdf;
mod course;
mod curve;
mod elasticity;
mod elimination;
pub mod families;
mod fit;
mod graph;
mod levenberg;
mod parts;
mod rational;
mod read;
mod rods;
mod sdirk;
mod soil;
mod spectral;
mod stomata;
mod sway;
mod tissue;
mod tubes;
mod walk;
mod water;
mod wilt;
mod wind;

pub use bdf::{Bdf6, Start};
pub use course::{WaterCourse, water_course, water_curve};
pub use curve::{CurveOptions, Interval, Method};
pub use elasticity::Elasticity;
pub use fit::{Estimate, Fit, FitOptions, Mark, Measurements, OtherSteepness, OtherWater, fit};
pub use graph::{Plant, Segment};
pub use parts::Part;
pub use read::{PlantFormat, read, read_bytes, read_with};
pub use rods::{Energy, Motion, MotionOptions, Pose, RelaxOptions, Relaxation, RodOptions, Rods};
pub use soil::{Balance, Rewatering, Soil};
pub use spectral::SpectralSolution;
pub use stomata::Stomata;
pub use sway::{Sway, SwayOptions, sway};
pub use tissue::Tissue;
pub use tubes::tubes;
pub use water::{Conductivity, WaterModel, WaterOptions, grams_per_hour};
pub use wilt::{WiltOptions, Wilting, wilt};
pub use wind::{Gusts, Wind};
