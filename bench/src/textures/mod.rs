//! Chapters 3 and 7 of the thesis, measured again: figures 3.4, 3.5, 3.8, 3.9 and 3.10, tables 3.1
//! to 3.4; figures 7.1 and 7.2, and times of Newton's fractals.

mod figures;
#[cfg(feature = "opencl")]
mod gpu;
mod long;
mod newton;
mod parameters;
mod polar;
mod surfaces;
#[cfg(feature = "opencl")]
mod thesis;
#[cfg(feature = "opencl")]
mod times;

pub use figures::{evaporation, maze, rescaling, substeps};
#[cfg(feature = "opencl")]
pub use gpu::gpu;
pub use long::{long_walks, many_points};
pub use newton::{PICTURES, newton_figures, newton_times};
pub use parameters::{disagreements, grid, table};
#[cfg(feature = "opencl")]
pub use times::{ten_meshes, times};
