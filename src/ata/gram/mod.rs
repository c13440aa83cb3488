//! A^T A of rows that come in blocks, from memory, files, sparse matrices or other ranks. One
//! accumulator serves all sources; its sums can be saved, continued and merged. See
//! docs/algorithms/ata.md, "Streaming".

mod accumulator;
mod blocks;
mod exact;
mod extended;
mod float;
mod format;
mod grid;
mod moments;
mod pass;
mod plan;
mod rows;
mod source;
mod sparse;
mod stream;
mod strip;
#[cfg(test)]
mod tests;
mod wide;

pub use accumulator::Accumulator;
pub use blocks::block_rows;
pub use extended::ExtendedGram;
pub use format::scalar_of;
pub use grid::RowBounds;
pub use plan::StreamPlan;
pub use rows::{Center, RowOptions, ata_extended, ata_rows};
pub use source::{DenseRows, RowBlocks};
pub use sparse::{ata_sparse, sparse_is_faster, sparse_multiplications};
pub use stream::{AfterBlock, stream};
pub use strip::Strip;

pub(crate) use extended::About;
pub(crate) use rows::AdjustedRows;
#[cfg(feature = "mpi")]
pub(crate) use stream::exact_sums;
