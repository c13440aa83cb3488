//! Blocks of rows.
