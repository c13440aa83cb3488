//! What columnar files have in common.

use std::sync::Arc;

use super::fault::Fault;
use super::words::Words;
use crate::io::rounding::is_rounded;

/// A column of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Field {
    pub name: String,
    pub kind: Kind,
}

/// The type of the entries of a column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Kind {
    Numbers,
    Words,
    /// Entries that no row of a matrix has, as a message names them: "dates".
    Other(String),
}

/// An integer of any size.
pub trait Integer: Copy {
    fn magnitude(self) -> u128;

    /// Returns the nearest f64.
    fn number(self) -> f64;
}

impl Integer for i64 {
    #[inline]
    fn magnitude(self) -> u128 {
        self.unsigned_abs().into()
    }

    #[inline]
    fn number(self) -> f64 {
        self as f64
    }
}

impl Integer for u64 {
    #[inline]
    fn magnitude(self) -> u128 {
        self.into()
    }

    #[inline]
    fn number(self) -> f64 {
        self as f64
    }
}

impl Integer for i128 {
    #[inline]
    fn magnitude(self) -> u128 {
        self.unsigned_abs()
    }

    #[inline]
    fn number(self) -> f64 {
        self as f64
    }
}

/// Some rows of a column.
#[derive(Debug, Default)]
pub struct Cells {
    /// Numbers, or numbers of words; NaN where a cell is missing.
    pub values: Vec<f64>,
    /// The places in `values` of integers that were rounded, ascending.
    pub rounded: Vec<usize>,
}

impl Cells {
    pub fn clear(&mut self) {
        self.values.clear();
        self.rounded.clear();
    }

    /// Adds an integer, rounded to the nearest f64.
    pub fn push_integer(&mut self, integer: impl Integer) {
        if is_rounded(integer.magnitude()) {
            self.rounded.push(self.values.len());
        }
        self.values.push(integer.number());
    }

    /// Adds a missing cell.
    pub fn miss(&mut self) {
        self.values.push(f64::NAN);
    }
}

/// Reads the cells of a column, from the first row of a group on.
pub trait ColumnReader: Send {
    /// Adds the cells of the next `rows` rows, which the group has.
    fn read(&mut self, rows: usize, cells: &mut Cells) -> Result<(), Fault>;
}

/// What a columnar file says that it has.
#[derive(Debug)]
pub struct Contents {
    pub fields: Vec<Field>,
    /// The names of the columns that are the index of a pandas frame.
    pub index: Vec<String>,
    /// The number of rows of each group, which together are a number, too.
    pub groups: Vec<usize>,
    /// What a group is called.
    pub group_name: &'static str,
}

/// An open columnar file.
pub trait Store: Send + Sync {
    fn contents(&self) -> &Contents;

    /// Returns whether a column may have integers that are no f64.
    fn may_round(&self, field: usize) -> bool;

    /// Opens a column of numbers, or one of words with their numbers.
    fn column(
        &self,
        group: usize,
        field: usize,
        words: Option<&Arc<Words>>,
    ) -> Result<Box<dyn ColumnReader>, Fault>;
}
