//! Chapter 3 of the thesis, measured again: figures 3.4, 3.5, 3.8, 3.9 and 3.10, tables 3.1 to 3.4.

mod figures;
mod parameters;
mod surfaces;
mod times;

pub use figures::{evaporation, maze, rescaling, substeps};
pub use parameters::{grid, table};
pub use times::times;
