//! Text tables, with a reader of our own: the usual crates take one delimiter byte, not runs of
//! blanks, and lose count of lines at comments.

use std::fmt::Debug;
use std::io::{self, Write};
use std::ops::Range;

use faer::MatRef;

use super::columns::checked_columns;
use super::matrix::{Dense, Matrix};
use super::source::Source;
use crate::base::{Result, push};

/// Reads the table, and the names of the columns that are kept if the header has one for each.
pub(super) fn read(
    source: &mut Source<'_>,
    columns: Option<&Range<usize>>,
) -> Result<(Matrix, Vec<String>)> {
    let mut names: Vec<String> = Vec::new();
    let mut values: Vec<f64> = Vec::new();
    let mut nrows = 0;
    let mut separator = None;
    let mut rows: Option<Rows> = None;
    loop {
        let number = source.line() + 1;
        let Some(line) = source.next_line()? else { break };
        if line.trim_ascii().is_empty() || line.trim_ascii_start().starts_with('#') {
            continue;
        }
        let may_be_header = separator.is_none();
        let separator = *separator.get_or_insert_with(|| separator_of(line));
        if may_be_header && is_header(line, separator) {
            names = fields(line, separator).map(str::to_owned).collect();
            continue;
        }
        let rows = match &rows {
            Some(rows) => rows,
            None => {
                let width = fields(line, separator).count();
                let kept = checked_columns(columns, width)?;
                rows.insert(Rows { separator, width, first_line: number, kept })
            }
        };
        if let Some(what) = rows.append(line, &mut values)? {
            return Err(source.fail(what));
        }
        source.check_memory::<f64>("the table so far", values.len())?;
        nrows += 1;
    }
    let Some(Rows { width, kept, .. }) = rows else {
        return Err(source.fail("the file ends without a row of numbers"));
    };
    if width != names.len() {
        names.clear();
    }
    names.truncate(kept.end);
    names.drain(..kept.start.min(names.len()));
    let shape = (nrows, kept.len());
    Ok((Matrix::F64(Dense::new(values, shape, true, 0..kept.len())), names))
}

/// The rows of a table, which have as many fields as the first one.
struct Rows {
    separator: char,
    /// The number of fields.
    width: usize,
    /// The line of the first row.
    first_line: usize,
    /// The columns that are read.
    kept: Range<usize>,
}

impl Rows {
    /// Appends the numbers of a row to `values`, or returns what is wrong with the row.
    fn append(&self, line: &str, values: &mut Vec<f64>) -> Result<Option<String>> {
        let before = values.len();
        let mut count = 0;
        let mut wrong = None;
        for field in fields(line, self.separator) {
            if self.kept.contains(&count) && wrong.is_none() {
                match field.parse::<f64>() {
                    Ok(value) => push(values, value)?,
                    Err(_) => wrong = Some(not_a_number(count, field)),
                }
            }
            count += 1;
        }
        if count != self.width {
            let Self { width, first_line, .. } = self;
            return Ok(Some(format!(
                "{count} fields in this row, {width} in that of line {first_line}"
            )));
        }
        debug_assert!(wrong.is_some() || values.len() - before == self.kept.len());
        Ok(wrong)
    }
}

/// Says that a field is not a number.
fn not_a_number(column: usize, field: &str) -> String {
    let number = column + 1;
    if field.is_empty() {
        return format!("column {number}: nothing where a number should be");
    }
    format!("column {number}: {:?} is not a number", shortened(field))
}

/// Returns the first of tab, semicolon and comma that the line holds, or a blank.
fn separator_of(line: &str) -> char {
    ['\t', ';', ','].into_iter().find(|&c| line.contains(c)).unwrap_or(' ')
}

/// Returns whether a line has names and no numbers.
fn is_header(line: &str, separator: char) -> bool {
    fields(line, separator).all(|field| !may_be_number(field))
        && fields(line, separator).any(|field| !field.is_empty())
}

/// Returns whether a field is a number here or in another notation (`1,5`, `1.234,5`, `1.5d0`,
/// `1'000`), whose row must not be lost as a header.
fn may_be_number(field: &str) -> bool {
    let decimal_comma = field.contains(',');
    let plain = |c: char| match c {
        '.' if decimal_comma => None,
        ',' => Some('.'),
        'd' | 'D' => Some('e'),
        '\'' | ' ' | '\u{a0}' => None,
        _ => Some(c),
    };
    field.chars().filter_map(plain).collect::<String>().parse::<f64>().is_ok()
}

/// Returns the fields of a line, without blanks and quotes around them; a run of blanks separates
/// once.
fn fields(line: &str, separator: char) -> impl Iterator<Item = &str> {
    let blank = separator == ' ';
    line.split(separator)
        .map(|field| field.trim().trim_matches('"').trim())
        .filter(move |field| !blank || !field.is_empty())
}

/// Returns the beginning of a field, for a message of one line.
fn shortened(field: &str) -> String {
    match field.char_indices().nth(30) {
        Some((end, _)) => format!("{}...", &field[..end]),
        None => field.to_owned(),
    }
}

pub(super) fn write<T: Debug>(
    sink: &mut dyn Write,
    matrix: MatRef<'_, T>,
    separator: char,
) -> io::Result<()> {
    for i in 0..matrix.nrows() {
        for j in 0..matrix.ncols() {
            if j > 0 {
                write!(sink, "{separator}")?;
            }
            // The shortest text that reads back as the same number.
            write!(sink, "{:?}", matrix[(i, j)])?;
        }
        writeln!(sink)?;
    }
    Ok(())
}
