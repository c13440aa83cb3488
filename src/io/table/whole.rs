//! Reads a table into memory.

use super::encoding::{self, Decoded, HEAD};
use super::engine::{Engine, begin};
use super::factors::Factors;
use super::message::no_rows;
use super::options::TableOptions;
use super::reading::TableReading;
use super::text::Text;
use crate::base::{Result, room};
use crate::io::columns::Columns;
use crate::io::limits::{check_memory, longest_line};
use crate::io::matrix::Dense;
use crate::io::source::{Source, error};

/// Reads a whole table.
pub(in crate::io) fn read(
    source: &mut Source<'_>,
    options: &TableOptions,
    columns: &Columns,
) -> Result<(Dense<f64>, TableReading)> {
    let (path, limit) = (source.path().to_path_buf(), source.memory());
    let encoding = encoding::detect(&source.peek(HEAD)?, options.encoding.as_deref())?;
    let mut text = Text::new(&path, Decoded::new(source, encoding), 0, 0, longest_line(limit));
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
    factors.give_levels(&mut reading);
    reading.has_commented_rows |= engine.has_commented_rows;
    reading.rounded = engine.rounded;
    Ok((Dense::new(values, (nrows, ncols), true, 0..ncols), reading))
}
