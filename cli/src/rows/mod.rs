//! The rows of commands that read a matrix once, block by block: where rows come from, and how sums
//! are saved for a run that was killed.

mod checkpoint;
mod source;

pub use checkpoint::CheckpointArgs;
pub use source::{Part, Source, Watched, fingerprint, open, read_weights};
