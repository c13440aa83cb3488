//! A^T A on many ranks, as data: who holds which part of the triangle, who sends what to whom, and
//! what it costs. No communication happens here, so that plans for thousands of ranks are tested on
//! one; `mpi` executes them.
//!
//! Two ways leave the result distributed ([`Layout`]): rows of A summed chunk by chunk
//! ([`Chunks`]), and columns of A exchanged so that each pair of them meets once ([`Blocks`]).

mod blocks;
mod chunks;
mod cover;
mod segment;
mod tree;

pub use blocks::{Blocks, Product};
pub use chunks::{Chunks, Round, rounds};
pub use cover::difference_cover;
pub use segment::{Layout, Segment, packed_len};
pub(crate) use tree::RESULTS_AT_ONCE;
pub use tree::{Load, TaskTree, TreeNode, levels};
