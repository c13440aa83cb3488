//! Plans of A^T A on many ranks, as data: which rank holds which part of the triangle, which rank
//! sends what to which, and the cost. Nothing communicates here, so plans for thousands of ranks
//! are tested on one; [`ranks`](super) executes them.
//!
//! Three algorithms leave the result distributed ([`TriangleLayout`]): rows of A summed chunk by
//! chunk ([`Chunks`]), columns of A exchanged so that each pair of them meets once ([`Blocks`]),
//! and both, where each rank has some rows of some columns ([`Bricks`]). With A and C on one rank
//! there are the algorithm of the thesis ([`TaskTree`]) and distributed rows ([`row_shares`]).
//! [`choose`] returns the fastest.

mod blocks;
mod bricks;
mod chunks;
mod cost;
mod cover;
mod cyclic;
mod deal;
mod layout;
mod machine;
mod planes;
mod segment;
mod tree;

#[cfg(feature = "mpi")]
pub(crate) use blocks::piece_height;
pub use blocks::{BlockPair, Blocks};
pub use bricks::Bricks;
pub use chunks::{Chunks, Round, rounds};
pub use cost::{
    Cost, Explanation, LowerBound, Mode, Place, choose, lower_bound, lower_bound_of_rows, predict,
    proposition_8_3, simulate,
};
pub use cover::difference_cover;
pub use cyclic::{BlockCyclic, CutInto, Dealing, Delivery, Grid, GridOrder, Parts, Piece, Run};
pub use deal::row_shares;
pub use layout::TriangleLayout;
pub use machine::Machine;
pub use segment::Segment;
pub use tree::{Load, PlannedSend, TaskTree, TreeNode, rank_levels};
#[cfg(feature = "mpi")]
pub(crate) use tree::{RESULTS_IN_FLIGHT, STRIPS};
