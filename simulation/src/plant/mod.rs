//! Plants that lose water and wilt (thesis, chapter 4; docs/algorithms/plant.md): their graph and
//! files, the water in them, and rods that bend as water is lost.

mod elasticity;
pub mod families;
mod fit;
mod graph;
mod parts;
mod read;
mod rods;
mod sway;
mod tissue;
mod tubes;
mod water;
mod wilt;
mod wind;

pub use elasticity::Elasticity;
pub use fit::{
    Air, DryingLeaf, Estimate, Fit, FitOptions, FittedLeaf, LeafOptions, LeavesFit, Mark,
    Measurements, OtherSteepness, OtherWater, air_demand, fit, fit_leaves, turgor_loss_point,
};
pub use graph::{Plant, Segment};
pub use parts::Part;
pub use read::{
    LeafGroup, LeafTable, PlantFormat, ReadOptions, read, read_bytes, read_leaves, read_with,
};
pub use rods::{Energy, Motion, MotionOptions, Pose, RelaxOptions, Relaxation, RodOptions, Rods};
pub use sway::{Sway, SwayOptions, sway};
pub use tissue::Tissue;
pub use tubes::tubes;
pub use water::{
    Balance, Bdf6, Conductivity, CurveOptions, Interval, Method, Rewatering, Soil,
    SpectralSolution, Start, Stomata, WaterCourse, WaterModel, WaterOptions, grams_per_hour,
    water_course, water_curve,
};
pub use wilt::{WiltOptions, Wilting, wilt};
pub use wind::{Gusts, Wind};
