//! The training of the pretrained weights of `catamaran_geometry::unions`: generates shapes, their
//! parts and data sets, and fits the weights.
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
