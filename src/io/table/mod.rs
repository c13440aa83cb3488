//! Text tables as people have them: what separates fields and digits, which rows have names and
//! which cells are missing is decided from the beginning of the file ([`layout`]) and said
//! ([`TableReading`]). What the file leaves open is an error that names the option
//! ([`TableOptions`]) that decides.
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

mod encoding;
mod engine;
mod factors;
mod file;
mod layout;
mod missing;
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
mod write;

use std::path::Path;

pub use self::file::TableFile;
pub use self::options::{Missing, Separator, TableOptions, Words};
pub use self::reading::{ColumnKind, TableColumn, TableReading};
pub(super) use self::write::write;

use self::encoding::Decoded;
use self::engine::{Engine, begin};
use self::factors::Factors;
use self::text::Text;
use super::columns::Columns;
use super::limits::check_memory;
use super::matrix::Dense;
use super::source::{Source, error};
use crate::base::{Error, Result, room};

/// Bytes from which the encoding is found.
const HEAD: usize = 1 << 10;

/// Characters of a field or a row in a message.
const EXCERPT: usize = 30;

/// Reads a whole table.
pub(super) fn read(
    source: &mut Source<'_>,
    options: &TableOptions,
    columns: &Columns,
) -> Result<(Dense<f64>, TableReading)> {
    let (path, limit) = (source.path().to_path_buf(), source.memory());
    let longest = super::limits::longest_line(limit);
    let encoding = encoding::detect(&source.peek(HEAD)?, options.encoding.as_deref())?;
    let mut text = Text::new(&path, Decoded::new(source, encoding), 0, 0, longest);
    let (layout, mut reading) = begin(&mut text, options, columns)?;
    if let Some(encoding) = encoding {
        reading.encoding = encoding.name();
    }
    let (ncols, mut factors) = (layout.ncols, Factors::new(&layout));
    let mut engine = Engine::new(text, layout, options.par);
    let mut values: Vec<f64> = Vec::new();
    let mut nrows = 0;
    while let Some(batch) = engine.next(false)? {
        nrows += batch.rows;
        reading.dropped_rows += batch.dropped;
        let bytes = (nrows * ncols * size_of::<f64>()) as u64;
        check_memory(limit, "the table so far", bytes)
            .map_err(|what| error(&path, engine.text.lines, what))?;
        for piece in engine.pieces() {
            factors.learn(piece);
            let start = values.len();
            room(&mut values, piece.values.len())?;
            values.extend_from_slice(&piece.values);
            factors.translate(piece, &mut values[start..], ncols.max(1));
        }
    }
    if nrows == 0 {
        return Err(no_rows(&path, engine.text.lines, reading.dropped_rows));
    }
    factors.sort(&mut values, ncols.max(1));
    with_levels(&mut reading, &factors);
    Ok((Dense::new(values, (nrows, ncols), true, 0..ncols), reading))
}

/// Returns the error for a table without rows, behind so many lines.
fn no_rows(path: &Path, lines: usize, dropped: u64) -> Error {
    let what = match dropped {
        0 => "the file ends without a row of numbers".into(),
        rows => format!("each of its {rows} rows has a missing cell"),
    };
    error(path, lines + 1, what)
}

/// Gives the levels of factors to the columns.
fn with_levels(reading: &mut TableReading, factors: &Factors) {
    let mut texts = factors.texts().into_iter();
    for column in &mut reading.columns {
        if let ColumnKind::Factor { levels } = &mut column.kind {
            *levels = texts.next().unwrap_or_default();
        }
    }
}

/// Returns an option for a message. The command line writes its own names of options in the place
/// of these.
fn option(name: &str) -> String {
    format!("option `{name}`")
}

/// Returns the beginning of a field or a row in quotes, for a message of one line.
fn excerpt(field: &[u8]) -> String {
    let text = encoding::text(field);
    match text.char_indices().nth(EXCERPT) {
        Some((end, _)) => format!("{:?}", format!("{}...", &text[..end])),
        None => format!("{text:?}"),
    }
}
