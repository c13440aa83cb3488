//! Decimation beside other libraries (thesis, chapter 5).

mod contenders;
mod inputs;
mod measures;
mod race;

pub use contenders::{Contender, Job, Rivals, solve};
pub use inputs::{Input, Inputs};
pub use measures::Measures;
pub use race::{Row, race};
