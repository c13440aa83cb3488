//! Arrays of several dimensions, in memory, as files have them.

/// An array of a file, as its entries lie there.
#[derive(Debug, Clone)]
pub(super) struct Stored {
    pub shape: Vec<usize>,
    pub entries: Entries,
    /// Whether the first index runs fastest.
    pub by_columns: bool,
}

/// The entries of an array, one after the other.
#[derive(Debug, Clone)]
pub(super) enum Entries {
    Numbers(Vec<f64>),
    Indices(Vec<u64>),
}
