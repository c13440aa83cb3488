//! Chapter 4 of the thesis, measured again: figures 4.3 to 4.11, and a race of the water solver.

mod figures;
mod part;
mod race;
mod shapes;
mod shares;
mod subjects;
mod weights;

pub use figures::{cut, errors_by_conductance, errors_over_time, grid, sections, total_water};
pub use part::Part;
pub use race::race;
pub use shapes::{hanging, held, naive};
pub use shares::shares;
pub use subjects::{Subject, subjects};
pub use weights::weights;
