//! Spectral unions of partial shapes (thesis, chapter 2): the spectrum of a part of a surface, signatures, retrieval.
//!
//! See docs/algorithms/unions.md for the mathematics.

mod familiar;
mod model;
pub mod network;
mod question;
mod spectrum;
mod tensors;

pub use familiar::Familiar;
pub use model::{Scaling, SpectralUnion};
pub use network::K;
pub use question::Question;
pub use spectrum::interpolate;
