//! Chapters 3 and 7 of the thesis, measured again.

#[cfg(feature = "opencl")]
mod devices;
mod newton;
mod polar;

#[cfg(feature = "opencl")]
pub use devices::slime_times;
pub use newton::{newton_figures, newton_times};
