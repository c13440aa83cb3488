//! The rows of commands that read a matrix once, block by block: where rows come from, and how sums
//! are saved for a run that was killed.

mod add;
mod checkpoint;
mod list;
mod parts;
mod source;

pub use add::{Shown, add_rows};
pub use checkpoint::{Begun, CheckpointArgs, labels_with_rows};
pub use list::RowList;
pub use parts::{COLUMNS, NUMBERS, PARTS, ROWS, WEIGHTS, WITHOUT_WEIGHTS, option_labels};
pub use source::{
    Part, Source, Watched, check_options, check_same_weights, check_size_of_weights, fingerprint,
    fingerprint_of_indices, fingerprint_of_text, open, read_weights,
};
