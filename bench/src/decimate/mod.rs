//! Decimation beside other libraries (thesis, chapter 5).

mod contenders;
mod inputs;
mod measures;
mod race;
mod sets;
mod summary;

pub use contenders::{Contender, Job, Rivals, solve};
pub use inputs::{Input, Inputs};
pub use measures::{Intersecting, Measures, Soundness};
pub use race::{Row, race};
pub use sets::Set;
pub use summary::{Run, summary};
