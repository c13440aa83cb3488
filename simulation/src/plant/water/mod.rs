//! The water of a plant (thesis, equations 4.1 to 4.8): its diffusion along the plant, solutions by
//! the exponential of a matrix, by eigenvalues, by BDF6 and by SDIRK, and the stomata and the soil
//! to which they respond.

mod bdf;
mod course;
mod diffusion;
mod eigenvalues;
mod elimination;
mod exponential;
mod options;
mod sdirk;
mod soil;
mod stomata;
mod walk;

pub use bdf::{Bdf6, Start};
pub use course::{WaterCourse, water_course, water_curve};
pub use diffusion::{Conductivity, WaterModel, WaterOptions, grams_per_hour};
pub use eigenvalues::SpectralSolution;
pub use options::{CurveOptions, Interval, Method};
pub use soil::{Balance, Rewatering, Soil};
pub use stomata::Stomata;
pub(crate) use walk::{Times, Walk};
