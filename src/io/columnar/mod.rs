//! Columnar files as rows: Parquet, and files of Arrow's IPC format (Feather, version 2).
//!
//! - [`store`] is what the formats have in common: columns, groups of rows, readers of columns,
//! - [`parquet`] reads the pages of crate parquet, [`arrow`] the buffers of record batches,
//! - [`codec`] unpacks both, [`decimal`] and [`words`] turn entries into numbers,
//! - [`pandas`] knows the index of a frame, [`plan`] decides which columns are read,
//! - [`group`] decodes rows, [`mod@file`] is the matrix.
//!
//! Rows are decoded some thousands at a time. So memory is bounded by pages (Parquet) and packed
//! buffers (Arrow), not by groups of rows.

mod arrow;
mod codec;
mod decimal;
mod fault;
mod file;
mod group;
mod pandas;
mod parquet;
mod plan;
mod store;
mod words;

pub(in crate::io) use self::file::ColumnarFile;
