//! Records that a thread reads.

use std::collections::HashMap;

use super::encoding;
use super::layout::{Layout, Use};
use super::message::{excerpt, fields, option};
use super::number;
use super::options::Missing;
use super::sample::has_torn_field;
use super::splitter::{Between, Found, Splitter, comment_start, without_signs};

/// What is wrong with a record.
#[derive(Debug)]
pub(super) struct Fault {
    /// Lines of the piece before the record.
    pub line: usize,
    pub what: String,
}

/// The words of a factor, in the order of their numbers.
#[derive(Debug, Default)]
pub(in crate::io) struct Levels {
    numbers: HashMap<Vec<u8>, u32>,
    pub words: Vec<Vec<u8>>,
}

impl Levels {
    /// Returns the number of a word, a new one if the word is new.
    pub fn number(&mut self, word: &[u8]) -> u32 {
        if let Some(&number) = self.numbers.get(word) {
            return number;
        }
        let number = self.words.len() as u32;
        self.numbers.insert(word.into(), number);
        self.words.push(word.into());
        number
    }

    /// Returns the number of a word that is known.
    pub fn find(&self, word: &[u8]) -> Option<u32> {
        self.numbers.get(word).copied()
    }
}

/// A part of the text of a table, and what it holds.
#[derive(Debug)]
pub(super) struct Piece {
    splitter: Splitter,
    /// The entries of the rows, row by row.
    pub values: Vec<f64>,
    /// The words of each factor, by whose numbers `values` name them.
    pub levels: Vec<Levels>,
    pub rows: usize,
    /// Rows that were left out because of a missing cell.
    pub dropped: u64,
    pub lines: usize,
    /// Bytes of all whole records.
    pub bytes: usize,
    pub fault: Option<Fault>,
    pub rounded: Option<Rounded>,
    /// Whether a comment would be a row without the sign of comments.
    pub has_commented_row: bool,
    /// Whether the first record is the first one of the table.
    pub is_start: bool,
    /// The blank lines behind the last record.
    pub gap: Option<Gap>,
}

/// Blank lines behind a record of a table of one column, where an empty cell is a blank line. They
/// are missing cells if a record follows, and nothing at the end of the file.
#[derive(Debug)]
pub(super) struct Gap {
    /// Bytes and lines of the piece before the first of them.
    pub bytes: usize,
    pub line: usize,
    pub lines: usize,
}

/// Integers that were rounded.
#[derive(Debug)]
pub struct Rounded {
    pub count: u64,
    /// The line of the first one in the piece, from 0.
    pub line: usize,
    /// The column of the first one as messages call it.
    pub column: String,
}

/// Whether a row is kept.
enum Row {
    Kept,
    Dropped,
}

impl Piece {
    pub fn new(layout: &Layout) -> Self {
        Self {
            splitter: Splitter::new(layout.syntax),
            values: Vec::new(),
            levels: (0..layout.nfactors).map(|_| Levels::default()).collect(),
            rows: 0,
            dropped: 0,
            lines: 0,
            bytes: 0,
            fault: None,
            rounded: None,
            has_commented_row: false,
            is_start: false,
            gap: None,
        }
    }

    /// Forgets what was read.
    pub fn clear(&mut self) {
        self.values.clear();
        (self.rows, self.dropped, self.lines, self.bytes) = (0, 0, 0, 0);
        (self.fault, self.rounded, self.gap) = (None, None, None);
        self.has_commented_row = false;
        self.levels.iter_mut().for_each(|levels| *levels = Levels::default());
    }

    /// Reads the records of a text, or only counts them. Nothing follows the text if it `is_last`.
    pub fn read(&mut self, layout: &Layout, text: &[u8], is_last: bool, counts_only: bool) {
        self.clear();
        let has_long = number::may_be_rounded(text, layout.notation);
        let has_gaps = layout.uses.len() == 1;
        while self.bytes < text.len() {
            let rest = &text[self.bytes..];
            let (found, bytes) = self.splitter.step(rest, is_last, !counts_only || has_long);
            if found == Found::Record {
                self.fill_gap(layout);
                if self.fault.is_some() {
                    return;
                }
            }
            match found {
                Found::Nothing => return,
                Found::Record if counts_only => {
                    self.rows += 1;
                    if has_long {
                        self.count_rounded(layout, rest);
                    }
                }
                Found::Record => match self.row(layout, rest, bytes) {
                    Ok(Row::Kept) => {
                        self.rows += 1;
                        if has_long {
                            self.count_rounded(layout, rest);
                        }
                    }
                    Ok(Row::Dropped) => self.dropped += 1,
                    Err(what) => {
                        self.fault = Some(Fault { line: self.lines, what });
                        return;
                    }
                },
                Found::Blank if has_gaps => {
                    let (bytes, line) = (self.bytes, self.lines);
                    self.gap.get_or_insert(Gap { bytes, line, lines: 0 }).lines += 1;
                }
                Found::Blank => {}
                Found::Comment => {
                    self.has_commented_row =
                        self.has_commented_row || self.is_row(layout, &rest[..bytes]);
                }
            }
            let line_end = layout.syntax.line_end;
            // A record without quotes is a line.
            let has_lines = found == Found::Record && (counts_only || self.splitter.had_quotes());
            self.lines += match rest[..bytes].split_last() {
                Some((_, inner)) if has_lines && memchr::memchr(line_end, inner).is_some() => {
                    memchr::memchr_iter(line_end, &rest[..bytes]).count()
                }
                _ => 1,
            };
            self.bytes += bytes;
        }
    }

    /// Returns whether the piece has records.
    pub fn has_records(&self) -> bool {
        self.rows > 0 || self.dropped > 0 || self.fault.is_some()
    }

    /// Treats the blank lines behind the last record as missing cells.
    pub fn fill_gap(&mut self, layout: &Layout) {
        let Some(Gap { line, lines, .. }) = self.gap.take() else { return };
        match missing(layout, 0, b"") {
            Ok(true) => self.dropped += lines as u64,
            Ok(false) => {
                self.rows += lines;
                self.values.resize(self.values.len() + lines * layout.ncols, f64::NAN);
            }
            Err(what) => {
                let what =
                    format!("a blank line is an empty cell of a table of one column: {what}");
                self.fault = Some(Fault { line, what });
            }
        }
    }

    /// Returns whether a comment would be a row without the sign of comments.
    fn is_row(&mut self, layout: &Layout, comment: &[u8]) -> bool {
        let text = without_signs(comment, layout.syntax.comment);
        let width = layout.uses.len();
        if self.splitter.step(text, true, true).0 != Found::Record {
            return false;
        }
        let fits = |(j, used): (usize, &Use)| match used {
            Use::Number(_) => !matches!(value(layout, self.splitter.field(text, j)), Cell::Wrong),
            Use::Empty => self.splitter.field(text, j).is_empty(),
            Use::Word(..) | Use::Skip => true,
        };
        self.splitter.len() == width && layout.uses.iter().enumerate().all(fits)
    }

    /// Appends the entries of the record of `bytes` that begins `text`, or returns what is wrong
    /// with it.
    fn row(&mut self, layout: &Layout, text: &[u8], bytes: usize) -> Result<Row, String> {
        if self.splitter.is_open() {
            return Err("a quote that starts in this row is not closed".into());
        }
        if self.swallows_lines(layout, &text[..bytes]) {
            return Err("a field in quotes has several lines, and text behind its closing quote: \
                        a quote is missing, or one too many"
                .into());
        }
        if self.splitter.len() != layout.uses.len() && !self.differs_by_empty_fields(layout, text) {
            return Err(self.ragged(layout));
        }
        let start = self.values.len();
        self.values.resize(start + layout.ncols, f64::NAN);
        let mut is_dropped = false;
        // The common case, in which UTF-8 is checked once for a line.
        let is_plain = layout.notation.decimal == '.' && layout.missing_words.numbers.is_empty();
        let line = if is_plain { self.splitter.line(text) } else { None };
        for (j, &used) in layout.uses.iter().enumerate() {
            if let (Use::Number(place), Some(line)) = (used, line)
                && let Ok(value) = self.splitter.field_of_line(line, j).parse::<f64>()
                && !value.is_nan()
            {
                self.values[start + place] = value;
                continue;
            }
            let field = match used {
                Use::Empty if j >= self.splitter.len() => continue,
                Use::Skip => continue,
                _ => self.splitter.field(text, j),
            };
            match used {
                Use::Number(place) => match value(layout, field) {
                    Cell::Number(value) => self.values[start + place] = value,
                    Cell::Missing => is_dropped |= missing(layout, j, field)?,
                    Cell::Wrong => return Err(self.not_a_number(layout, text, j)),
                },
                Use::Word(..) if layout.missing_words.holds(field) => {
                    is_dropped |= missing(layout, j, field)?;
                }
                Use::Word(place, factor) => {
                    let number = self.levels[factor].number(field);
                    self.values[start + place] = f64::from(number);
                }
                Use::Empty if !field.is_empty() => {
                    return Err(format!(
                        "{} behind the separator at the end of the rows before it",
                        excerpt(field)
                    ));
                }
                Use::Empty | Use::Skip => {}
            }
        }
        if is_dropped {
            self.values.truncate(start);
            return Ok(Row::Dropped);
        }
        Ok(Row::Kept)
    }

    /// Counts the integers of the record that begins `text` which are rounded.
    fn count_rounded(&mut self, layout: &Layout, text: &[u8]) {
        let words = &layout.missing_words;
        for (j, &used) in layout.uses.iter().enumerate().take(self.splitter.len()) {
            let field = self.splitter.field(text, j);
            let is_number = matches!(used, Use::Number(_)) && !words.holds(field);
            if !is_number || !number::is_rounded(field, layout.notation) {
                continue;
            }
            let value = number::parse(field, layout.notation).unwrap_or_default();
            if words.numbers.contains(&value) {
                continue;
            }
            let line = self.lines;
            let first = || Rounded { count: 0, line, column: column(layout, j) };
            self.rounded.get_or_insert_with(first).count += 1;
        }
    }

    /// Returns whether quotes join the lines of a record, but not as writers set them.
    fn swallows_lines(&self, layout: &Layout, record: &[u8]) -> bool {
        let Between::Byte(separator) = layout.syntax.between else { return false };
        let inner = &record[..record.len().max(1) - 1];
        self.splitter.had_quotes()
            && memchr::memchr(layout.syntax.line_end, inner).is_some()
            && has_torn_field(record, separator, layout.syntax)
    }

    /// Returns whether the record, which begins `text`, has more or fewer fields than others only
    /// because of separators at its end.
    fn differs_by_empty_fields(&self, layout: &Layout, text: &[u8]) -> bool {
        let last = layout.uses.iter().rposition(|&used| used != Use::Empty);
        let needed = last.map_or(0, |last| last + 1);
        let len = self.splitter.len();
        len >= needed && (needed..len).all(|j| self.splitter.field(text, j).is_empty())
    }

    fn ragged(&self, layout: &Layout) -> String {
        let (found, width) = (fields(self.splitter.len()), layout.uses.len());
        let line = layout.first_line;
        let options = ["separator", "comment", "skip"].map(option).join(", ");
        format!(
            "{found} in this row, {width} in that of line {line}: options that divide rows \
             otherwise are {options}"
        )
    }

    fn not_a_number(&self, layout: &Layout, text: &[u8], j: usize) -> String {
        let field = self.splitter.field(text, j);
        let cell = format!("{}: {}", column(layout, j), excerpt(field));
        let [decimal, thousands, skip] = ["decimal", "thousands", "skip"].map(option);
        if number::readings(field) != 0 {
            return format!("{cell} is not a number; {decimal} or {thousands} may make it one");
        }
        let [words, columns, comment] = ["missing_words", "columns", "comment"].map(option);
        if comment_start(field, layout.syntax.comment).is_some() {
            let sign = char::from(layout.syntax.comment);
            return format!("{cell} is not a number; {comment} = {sign} ends rows before it");
        }
        let is_first = self.is_start && self.rows == 0 && self.dropped == 0;
        if is_first && layout.has_header {
            let line: Vec<&[u8]> =
                (0..self.splitter.len()).map(|j| self.splitter.field(text, j)).collect();
            return format!(
                "{cell} is not a number, in the row below the header: {}; {words} adds it to the \
                 words of missing cells, {skip} leaves lines at the start out",
                excerpt(&line.join(&b' '))
            );
        }
        format!(
            "{cell} is not a number; {words} adds it to the words of missing cells, {columns} \
             leaves the column out"
        )
    }
}

/// What a field is that should be a number.
enum Cell {
    Number(f64),
    Missing,
    Wrong,
}

#[inline]
fn value(layout: &Layout, field: &[u8]) -> Cell {
    let words = &layout.missing_words;
    match number::parse(field, layout.notation) {
        Some(value) if !value.is_nan() && !words.numbers.contains(&value) => Cell::Number(value),
        Some(_) => Cell::Missing,
        None if words.holds(field) => Cell::Missing,
        None => Cell::Wrong,
    }
}

/// Returns whether the row of a missing cell is left out, or that it is an error.
fn missing(layout: &Layout, j: usize, field: &[u8]) -> Result<bool, String> {
    match layout.missing {
        Missing::Drop => Ok(true),
        Missing::Nan => Ok(false),
        Missing::Error => {
            let field = if field.is_empty() { "nothing".to_owned() } else { excerpt(field) };
            let kind = if matches!(layout.uses[j], Use::Word(..)) { "word" } else { "number" };
            let what = format!("{field} where a {kind} should be");
            let (column, missing) = (column(layout, j), option("missing"));
            Err(format!(
                "{column}: {what}; {missing} = drop leaves out such rows, {missing} = nan keeps \
                 them"
            ))
        }
    }
}

/// Returns the number of a column, from 1, and its name.
fn column(layout: &Layout, j: usize) -> String {
    match layout.names.get(j).filter(|name| !name.is_empty()) {
        Some(name) => format!("column {} ({name})", j + 1),
        None => format!("column {}", j + 1),
    }
}

/// Returns the words of factors as text.
pub(in crate::io) fn texts(words: &[Vec<u8>]) -> Vec<String> {
    words.iter().map(|word| encoding::text(word).into_owned()).collect()
}
