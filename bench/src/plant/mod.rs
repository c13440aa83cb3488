//! Chapter 4 of the thesis, measured again: figures 4.3 to 4.11, and races of water and rods.

mod accuracy;
mod figures;
mod leaves;
mod part;
mod pvldcurve;
mod race;
#[allow(dead_code)] // tests have more of it
#[path = "../../../simulation/tests/simulation/plant/reference.rs"]
mod reference;
mod rods;
mod shapes;
mod shares;
mod storms;
mod subjects;
mod weights;

pub use accuracy::accuracy;
pub use figures::{cut, errors_by_conductance, errors_over_time, grid, sections, total_water};
pub use leaves::leaves;
pub use part::Part;
pub use race::race;
pub use rods::{beam, rods};
pub use shapes::{hanging, held, naive};
pub use shares::shares;
pub use storms::storms;
pub use subjects::{Subject, subjects};
pub use weights::weights;
