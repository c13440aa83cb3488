//! Arrays of several dimensions in memory, in the order of their files.

use crate::base::Result;

/// An array of a file, with its entries in the order of the file.
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

/// A function that is called before array `i` of `count` is read, which takes this many bytes. An
/// error ends the reading.
pub(super) type Begin<'a> = &'a mut dyn FnMut(usize, usize, u64) -> Result<()>;
