//! Errors in columns.

/// What is wrong with a column; the caller adds the file, the column and the group.
pub type Fault = String;
