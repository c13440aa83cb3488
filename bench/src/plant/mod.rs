//! Chapter 4 of the thesis, measured again: figures 4.3, 4.4, 4.6, 4.7, 4.10 and 4.11, and a race of the water solver.

mod figures;
mod part;
mod race;
mod shares;
mod subjects;

pub use figures::{cut, errors_over_time, grid, sections, total_water};
pub use part::Part;
pub use race::race;
pub use shares::shares;
pub use subjects::{Subject, subjects};
