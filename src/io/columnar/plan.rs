//! Decides which columns of a file are read.

use std::path::Path;

use super::store::{Contents, Field, Kind};
use crate::base::{Error, Result};
use crate::io::columns::{Columns, listed};
use crate::io::names::FileFormat;
use crate::io::source::error;
use crate::io::table::{ColumnKind, TableColumn, TableOptions, TableReading, Words};

/// How the columns begin in which pandas keeps the index of a frame.
const INDEX: &str = "__index_level_";

/// Returns how the file is read: its columns are those of the matrix, in order.
///
/// # Errors
/// No such column, or one that has no numbers.
pub fn plan(
    path: &Path,
    format: FileFormat,
    contents: &Contents,
    options: &TableOptions,
    columns: &Columns,
) -> Result<TableReading> {
    let fields = &contents.fields[..];
    let names: Vec<String> = fields.iter().map(|field| field.name.clone()).collect();
    let chosen = columns.of(&names, fields.len())?;
    let mut reading = TableReading {
        format,
        separator: None,
        decimal: '.',
        thousands: None,
        encoding: "UTF-8",
        header: true,
        has_numbers_in_header: false,
        skipped_lines: 0,
        index: false,
        trailing_separator: false,
        has_commented_rows: false,
        has_escaped_quotes: false,
        left_out: Vec::new(),
        columns: Vec::new(),
        dropped_rows: 0,
        rounded: None,
    };
    for number in chosen {
        let Field { name, kind } = &fields[number];
        let is_index = match options.index {
            Some(is_index) => is_index && number == 0,
            None => name.starts_with(INDEX) || contents.index.contains(name),
        };
        if is_index && columns.is_all() {
            reading.index = true;
            continue;
        }
        let is_named = |factor: &String| factor == name || *factor == number.to_string();
        let is_factor = options.words == Words::Factor || options.factors.iter().any(is_named);
        let kind = match kind {
            Kind::Numbers => ColumnKind::Numbers,
            Kind::Words if is_factor => ColumnKind::Factor { levels: Vec::new() },
            _ if columns.is_all() => {
                reading.left_out.push(name.clone());
                continue;
            }
            Kind::Words => return refuse(name, "words"),
            Kind::Other(what) => return refuse(name, what),
        };
        reading.columns.push(TableColumn { name: name.clone(), number, kind });
    }
    if reading.columns.is_empty() && columns.is_all() {
        let what = match fields {
            [] => "it has no columns".into(),
            _ => format!("no column has numbers; the columns are {}", listed(&names)),
        };
        return Err(error(path, None, what));
    }
    Ok(reading)
}

fn refuse<T>(name: &str, what: &str) -> Result<T> {
    let why = format!("column {name} has {what}, not numbers");
    Err(Error::Argument { what: "columns", why })
}
