//! The beginning of a table, divided into records, from which all is decided.

use std::path::Path;

use super::message::option;
use super::missing::MissingWords;
use super::options::TableOptions;
use super::sample::{Cell, Sample, SampleRow};
use super::splitter::Syntax;
use crate::io::columns::Columns;
use crate::io::source::error;

/// What most fields of a column are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Numbers,
    Words,
    /// There are none, or all are missing.
    Unknown,
}

/// A table whose beginning was divided into records.
pub(super) struct Found<'a> {
    pub path: &'a Path,
    pub options: &'a TableOptions,
    pub columns: &'a Columns,
    pub sample: Sample,
    pub syntax: Syntax,
    pub missing_words: MissingWords,
}

impl Found<'_> {
    pub fn fail(&self, line: usize, what: impl Into<String>) -> crate::Error {
        error(self.path, line, what)
    }

    pub fn no_rows(&self) -> crate::Error {
        let what = "the file ends without a row of numbers";
        let line = self.sample.next_line;
        match self.sample.has_later_comments {
            true => {
                let comment = option("comment");
                self.fail(line, format!("{what}, but with comments; {comment} names another sign"))
            }
            false => self.fail(line, what),
        }
    }

    pub fn cell(&self, field: &[u8]) -> Cell {
        Cell::of(field, &self.missing_words)
    }

    /// Returns the rows from `from` on that have `width` fields.
    pub fn rows(&self, from: usize, width: usize) -> impl Iterator<Item = &SampleRow> {
        self.sample.rows[from..].iter().filter(move |row| row.fields.len() == width)
    }

    /// Returns whether the first column counts the rows below the header, from 0 or 1.
    pub fn is_counted(&self, width: usize) -> bool {
        let number = |row: &SampleRow| -> Option<u64> {
            std::str::from_utf8(&row.fields[0]).ok()?.parse().ok()
        };
        let mut numbers = self.rows(1, width).map(number);
        let Some(Some(first @ 0..=1)) = numbers.next() else { return false };
        numbers.zip(first + 1..).all(|(number, expected)| number == Some(expected))
    }

    pub fn kind(&self, from: usize, width: usize, j: usize) -> Kind {
        let (mut numbers, mut words) = (0, 0);
        for row in self.rows(from, width) {
            match self.cell(&row.fields[j]) {
                Cell::Missing => {}
                Cell::Word => words += 1,
                Cell::Number(_) | Cell::NotFinite => numbers += 1,
            }
        }
        match (numbers, words) {
            (0, 0) => Kind::Unknown,
            _ if words > numbers => Kind::Words,
            _ => Kind::Numbers,
        }
    }

    /// Returns whether the caller asks for this column as a factor.
    pub fn is_named_factor(&self, names: &[String], j: usize) -> bool {
        let is_own = |factor: &String| names.get(j) == Some(factor) || *factor == j.to_string();
        self.options.factors.iter().any(is_own)
    }

    pub fn has_word(&self, from: usize, width: usize, j: usize) -> bool {
        self.rows(from, width).any(|row| self.cell(&row.fields[j]) == Cell::Word)
    }
}
