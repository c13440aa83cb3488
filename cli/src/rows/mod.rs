//! What commands share that read the rows of a matrix once, block by block: where rows come from,
//! and how sums are kept for a run that was killed to go on.

mod checkpoint;
mod source;

pub use checkpoint::CheckpointArgs;
pub use source::{Part, Source, Watched, fingerprint, open, read_weights};
