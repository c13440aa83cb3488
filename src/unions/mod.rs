//! Spectral unions of partial shapes (thesis, chapter 2): the spectrum of a part of a surface, signatures, retrieval.
//!
//! See docs/algorithms/unions.md for the mathematics.

mod partial;
mod shape_dna;
#[cfg(test)]
mod tests;

pub use partial::PartSpectra;
pub use shape_dna::{Match, ShapeDnaOptions, retrieve, shape_dna};
