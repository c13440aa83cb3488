//! The columns that a reader keeps.

use std::ops::Range;

use crate::base::{Error, Result};

/// Returns `columns`, checked against a matrix of `ncols` columns; all of them when `None`.
pub(super) fn checked_columns(
    columns: Option<&Range<usize>>,
    ncols: usize,
) -> Result<Range<usize>> {
    match columns {
        None => Ok(0..ncols),
        Some(r) if r.start <= r.end && r.end <= ncols => Ok(r.clone()),
        Some(r) => Err(Error::Argument {
            what: "columns",
            why: format!("{}..{} is not inside the {ncols} columns of the matrix", r.start, r.end),
        }),
    }
}
