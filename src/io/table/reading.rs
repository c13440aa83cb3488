//! What was decided about a table.

use std::fmt;

use super::number::Notation;
use super::options::Separator;
use super::splitter::Between;
use crate::io::columns::listed;
use crate::io::names::FileFormat;
use crate::io::rounding::RoundedIntegers;

/// A column of a table that was read.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct TableColumn {
    /// The name in the header; empty without one.
    pub name: String,
    /// The number of the column in the file, from 0.
    pub number: usize,
    /// What its entries are.
    pub kind: ColumnKind,
}

/// What the entries of a column are.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum ColumnKind {
    /// Numbers.
    Numbers,
    /// Words, of which the matrix has the numbers: entry i stands for `levels[i]`, and NaN for a
    /// missing cell ([`Missing::Nan`](super::Missing::Nan)).
    Factor {
        /// The different words, sorted by their bytes.
        levels: Vec<String>,
    },
}

/// How a text table was read. A face prints it once ([`Display`](fmt::Display)).
///
/// ```
/// use catamaran::io::{ReadOptions, read_file};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("a.csv");
/// std::fs::write(path, "stadt;druck;temp\nUlm;1,25;20\nBonn;1,75;21\n").unwrap();
/// let reading = read_file(path, &ReadOptions::new())?.reading.unwrap();
/// let said = "separator ;, decimal comma, header, 1 text column left out (stadt)";
/// assert_eq!(reading.to_string(), said);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct TableReading {
    /// The format: text, or one in which columns have names and types, so that what is said here of
    /// text holds no decision.
    pub format: FileFormat,
    /// What separates fields; `None` for a table of one column.
    pub separator: Option<Separator>,
    /// The decimal separator.
    pub decimal: char,
    /// The separator of groups of three digits, if numbers may have one.
    pub thousands: Option<char>,
    /// The encoding, by its name in the WHATWG standard.
    pub encoding: &'static str,
    /// Whether the first row has the names of columns.
    pub header: bool,
    /// Whether a name in the header is a number.
    pub has_numbers_in_header: bool,
    /// Lines at the start that were left out.
    pub skipped_lines: usize,
    /// Whether the first column numbers or names the rows, and is left out.
    pub index: bool,
    /// Whether a separator at the end of each row is ignored.
    pub trailing_separator: bool,
    /// Whether comments are left out that would be rows without the sign of comments.
    pub has_commented_rows: bool,
    /// Whether `\"` within quotes is read as a quote, as MySQL and Spark write it.
    pub has_escaped_quotes: bool,
    /// The columns that are left out, those of words in text and all without numbers elsewhere:
    /// their names, or else numbers, from 0.
    pub left_out: Vec<String>,
    /// The columns that were read.
    pub columns: Vec<TableColumn>,
    /// Rows that were left out because a cell in a column that is used is missing.
    pub dropped_rows: u64,
    /// The integers that were rounded; `None` where there are none.
    pub rounded: Option<RoundedIntegers>,
}

impl TableReading {
    /// Returns the names of the columns that were read; none without a header.
    pub fn names(&self) -> Vec<String> {
        match self.columns.iter().any(|column| !column.name.is_empty()) {
            true => self.columns.iter().map(|column| column.name.clone()).collect(),
            false => Vec::new(),
        }
    }

    /// Returns whether the file says all by itself: fields between commas, tabs or blanks, decimal
    /// points, names that are words, nothing that is left out, and no integer that is rounded.
    pub fn is_plain(&self) -> bool {
        let is_usual =
            matches!(self.separator, None | Some(Separator::Blanks | Separator::Char(',' | '\t')));
        is_usual
            && self.decimal == '.'
            && self.thousands.is_none()
            && self.encoding == "UTF-8"
            && !self.has_numbers_in_header
            && self.skipped_lines == 0
            && !self.index
            && !self.trailing_separator
            && !self.has_commented_rows
            && !self.has_escaped_quotes
            && self.left_out.is_empty()
            && self.dropped_rows == 0
            && self.rounded.is_none()
            && self.columns.iter().all(|column| column.kind == ColumnKind::Numbers)
    }

    pub(super) fn set_notation(&mut self, notation: Notation) {
        (self.decimal, self.thousands) = (notation.decimal, notation.thousands);
    }

    pub(super) fn set_separator(&mut self, between: Between) {
        self.separator = Some(match between {
            Between::Byte(byte) => Separator::Char(char::from(byte)),
            Between::Blanks => Separator::Blanks,
        });
    }
}

/// Returns the word for a character.
pub(super) fn called(c: char) -> String {
    match c {
        '.' => "point".into(),
        ',' => "comma".into(),
        '\t' => "tab".into(),
        ' ' => "blank".into(),
        '\'' => "apostrophe".into(),
        c => c.into(),
    }
}

impl fmt::Display for TableReading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts = Vec::new();
        if self.format == FileFormat::Table {
            self.describe_text(&mut parts);
        }
        if self.index {
            parts.push("index column left out".into());
        }
        if self.trailing_separator {
            parts.push("separator at the end of rows ignored".into());
        }
        if self.has_commented_rows {
            parts.push("commented rows left out".into());
        }
        if self.has_escaped_quotes {
            parts.push("\\\" read as a quote".into());
        }
        let factors: Vec<String> = self.columns.iter().filter_map(factor).collect();
        if !factors.is_empty() {
            parts.push(format!("factor {}", factors.join(", ")));
        }
        let kind = if self.format == FileFormat::Table { "text" } else { "other" };
        match self.left_out.len() {
            0 => {}
            1 => parts.push(format!("1 {kind} column left out ({})", self.left_out[0])),
            count => {
                let names = listed(&self.left_out);
                parts.push(format!("{count} {kind} columns left out ({names})"));
            }
        }
        match self.dropped_rows {
            0 => {}
            1 => parts.push("1 row with a missing cell left out".into()),
            rows => parts.push(format!("{rows} rows with missing cells left out")),
        }
        parts.extend(self.rounded.as_ref().map(ToString::to_string));
        f.write_str(&parts.join(", "))
    }
}

impl TableReading {
    /// Says how text is read, up to the header.
    fn describe_text(&self, parts: &mut Vec<String>) {
        match self.separator {
            None => {}
            Some(Separator::Blanks) => parts.push("separated by blanks".into()),
            Some(Separator::Char('\t')) => parts.push("separator tab".into()),
            Some(Separator::Char(c)) => parts.push(format!("separator {c}")),
        }
        parts.push(format!("decimal {}", called(self.decimal)));
        if let Some(c) = self.thousands {
            parts.push(format!("thousands {}", called(c)));
        }
        if self.encoding != "UTF-8" {
            parts.push(format!("encoding {}", self.encoding));
        }
        match self.skipped_lines {
            0 => {}
            1 => parts.push("1 line skipped".into()),
            lines => parts.push(format!("{lines} lines skipped")),
        }
        parts.push(if self.header { "header" } else { "no header" }.into());
    }
}

/// Returns the name of a factor with the number of its levels.
fn factor(column: &TableColumn) -> Option<String> {
    let ColumnKind::Factor { levels } = &column.kind else { return None };
    let name = match &column.name[..] {
        "" => column.number.to_string(),
        name => name.to_owned(),
    };
    Some(format!("{name} of {} levels", levels.len()))
}
