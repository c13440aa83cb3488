//! Chapters 3 and 7 of the thesis, measured again.

mod newton;
mod polar;

pub use newton::{newton_figures, newton_times};
