//! What the pretrained weights of `catamaran::unions` come from: generated shapes, their parts,
//! data sets, training.
//!
//! Thesis, chapter 2. The protocol is in docs/algorithms/unions.md.

pub mod adam;
pub mod cuts;
pub mod dataset;
pub mod evaluate;
pub mod families;
pub mod mlp;
pub mod network;
pub mod regions;
pub mod remesh;
pub mod train;
pub mod transformer;
pub mod tune;
