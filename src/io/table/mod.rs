//! Text tables: the beginning of the file decides ([`layout`]) what separates fields ([`syntax`]),
//! how numbers are written ([`notation`]) and which row has names ([`header`]), and
//! [`TableReading`] reports it. What the file leaves open is an error that names the option of
//! [`TableOptions`] that decides.
//!
//! The columns that are read are one matrix of numbers. A column of words ([`Words::Factor`]) is a
//! factor: its entries are numbers of levels, and its [`TableColumn`] has the levels. Of a row with
//! a missing cell the caller decides what becomes ([`Missing`]).
//!
//! The text goes through these steps:
//! - [`encoding`] turns it into UTF-8,
//! - [`text`] holds a part of it, which [`engine`] divides among threads,
//! - [`piece`] reads the records of a part, which [`splitter`] divides into fields,
//! - [`number`] and [`missing`] read a field.
//!
//! [`foreign`] names files that are no tables.

mod encoding;
mod engine;
mod factors;
mod file;
mod foreign;
mod found;
mod header;
mod layout;
mod message;
mod missing;
mod notation;
mod number;
mod options;
mod piece;
mod reading;
mod sample;
mod splitter;
mod syntax;
#[cfg(test)]
mod tests;
mod text;
mod whole;
mod write;

pub(super) use self::file::TextFile;
pub(super) use self::message::option;
pub(super) use self::number::rounded_words;
pub use self::options::{Missing, Separator, TableOptions, Words};
#[cfg(feature = "columnar")]
pub(super) use self::piece::{Levels, texts};
pub use self::reading::{ColumnKind, TableColumn, TableReading};
pub(super) use self::whole::read;
pub(super) use self::write::write;
