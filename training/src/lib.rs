//! What the pretrained weights of `catamaran::unions` come from: generated shapes, their parts, data sets, training.
//!
//! Thesis, chapter 2. The protocol is in docs/algorithms/unions.md.

pub mod cuts;
pub mod dataset;
pub mod families;
pub mod remesh;
