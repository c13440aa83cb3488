//! Spectral unions of partial shapes (thesis, chapter 2): the spectrum of a part of a surface, signatures, retrieval.
//!
//! See docs/algorithms/unions.md for the mathematics.
