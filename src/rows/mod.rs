//! A^T A of rows that come in blocks, from memory, files or other ranks. One accumulator serves all
//! sources; its sums can be saved, continued and merged. See docs/algorithms/ata.md, "Streaming".

mod accumulator;
mod ata;
mod blocks;
mod coded;
mod coding;
mod design;
mod exact;
mod extended;
mod factor;
mod float;
mod format;
mod grid;
mod moments;
mod pass;
mod pieces;
mod plan;
mod source;
mod stream;
mod strip;
#[cfg(test)]
mod tests;
mod verify;
mod wide;

pub use accumulator::Accumulator;
pub use ata::{Center, RowOptions, ata_extended, ata_rows};
pub use coding::Coding;
pub use design::{Design, DesignColumn, DesignRows, Survey};
pub use extended::ExtendedGram;
pub use factor::Factor;
pub use format::scalar_of;
pub use grid::RowBounds;
pub use plan::StreamPlan;
pub use source::{DenseRows, RowBlocks};
pub use stream::{AfterBlock, stream};
pub use strip::Strip;
pub use verify::verify_rows;

#[cfg(feature = "mpi")]
pub(crate) use exact::ExactSums;
pub(crate) use extended::About;
pub(crate) use format::labels_of;
#[cfg(feature = "mpi")]
pub(crate) use stream::{add_exact, exact_sums, no_exact_sums};
