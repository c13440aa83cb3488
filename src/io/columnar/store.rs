//! What columnar files have in common.

use std::sync::Arc;

use super::fault::Fault;
use super::words::Words;

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

/// Some rows of a column.
#[derive(Debug, Default)]
pub struct Cells {
    /// Numbers, or numbers of words; NaN where a cell is missing.
    pub values: Vec<f64>,
}

impl Cells {
    pub fn clear(&mut self) {
        self.values.clear();
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

    /// Opens a column of numbers, or one of words with their numbers.
    fn column(
        &self,
        group: usize,
        field: usize,
        words: Option<&Arc<Words>>,
    ) -> Result<Box<dyn ColumnReader>, Fault>;
}
