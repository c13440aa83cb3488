//! Decides from the beginning of a table how all of it is read.

use std::path::Path;

use super::foreign;
use super::found::{Found, Kind};
use super::header::Header;
use super::message::{excerpt, option};
use super::missing::MissingWords;
use super::number::Notation;
use super::options::{Missing, Separator, TableOptions, Words};
use super::reading::{ColumnKind, TableColumn, TableReading};
use super::sample::{Cell, SampleRow};
use super::splitter::{Between, Syntax};
use super::syntax::{announced, find, line_end, may_hold_all, width};
use crate::base::Result;
use crate::io::columns::Columns;
use crate::io::names::FileFormat;
use crate::io::source::error;

/// The least records that are looked at, if there are more.
const LEAST_ROWS: usize = 4;

/// Bytes that are looked at for the end of a header whose names have ends of lines.
const LONGEST_HEADER: usize = 1 << 20;

/// Ends of lines, beside the one that a file has.
const LINE_ENDS: [&str; 4] = ["\r", "\u{85}", "\u{2028}", "\u{2029}"];

/// What is done with a field of each record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Use {
    /// It may hold anything.
    Skip,
    /// It must be empty: it follows the separator at the end of the row.
    Empty,
    /// It is a number, or missing, and goes to this place of the row.
    Number(usize),
    /// It is a word that goes to this place of the row, and this factor.
    Word(usize, usize),
}

/// How the records of a table are read.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub syntax: Syntax,
    pub notation: Notation,
    pub missing_words: MissingWords,
    pub missing: Missing,
    /// What is done with each field.
    pub uses: Vec<Use>,
    /// Entries of a row.
    pub ncols: usize,
    /// Factors of a row.
    pub nfactors: usize,
    /// The line of the first record that has numbers.
    pub first_line: usize,
    /// Whether the record before that one is the header.
    pub has_header: bool,
    /// The names of all columns of the file; none without a header.
    pub names: Vec<String>,
}

/// How a table is read, and where its numbers begin.
#[derive(Debug)]
pub(super) struct Decided {
    pub layout: Layout,
    pub reading: TableReading,
    /// Bytes before the first record or comment: those of lines that are skipped.
    pub first: usize,
    /// Bytes before the first record with numbers.
    pub start: usize,
}

/// Decides how a table that begins with `text` is read; `None` when more of it is needed.
///
/// # Errors
/// The file has no reading or several, or no numbers; it does not have the `columns`.
pub(super) fn decide(
    path: &Path,
    text: &[u8],
    is_last: bool,
    options: &TableOptions,
    columns: &Columns,
) -> Result<Option<Decided>> {
    options.check()?;
    let missing_words = MissingWords::new(options.missing_words.as_deref());
    let (mut start, mut line) = (0, 1);
    let next = |start: usize| {
        let end = memchr::memchr(line_end(text), &text[start..]);
        end.map_or(text.len(), |end| start + end + 1)
    };
    while line <= options.skip && start < text.len() {
        start = next(start);
        line += 1;
    }
    if start == text.len() && !is_last {
        return Ok(None);
    }
    let first = &text[start..next(start)];
    let said = announced(first);
    if said.is_some() {
        start = next(start);
        line += 1;
    }
    let separator = options.separator.or(said);
    let rest = &text[start..];
    if let (None, Some((at, what))) = (separator, foreign::text(rest)) {
        return Err(error(path, line - 1 + at, what));
    }
    let (syntax, sample) = find(rest, is_last, line, separator, options, &missing_words);
    if !is_last && sample.rows.len() < LEAST_ROWS {
        return Ok(None);
    }
    let is_open = sample.rows.first().is_some_and(|row| row.quotes % 2 == 1);
    if !is_last && is_open && text.len() < LONGEST_HEADER && may_hold_all(rest, syntax, line) {
        return Ok(None);
    }
    let table = Found { path, options, columns, sample, syntax, missing_words };
    if table.sample.rows.is_empty() {
        return Err(table.no_rows());
    }
    if separator.is_none() {
        table.check_commas(rest, is_last, line)?;
    }
    let is_one_column = separator.is_none()
        && (table.is_one_column_of_decimal_commas()? || table.is_one_column_of_thousands()?);
    if is_one_column {
        // No separator is left. What a comma within a number means is decided as elsewhere.
        let options = options.clone().separator(Separator::Char('\t'));
        return decide(path, text, is_last, &options, columns);
    }
    let mut decided = table.decide()?;
    decided.first = start;
    decided.start += start;
    decided.reading.skipped_lines = options.skip;
    if std::str::from_utf8(&text[..utf8_end(text, is_last)]).is_err() {
        decided.reading.encoding = "windows-1252";
    }
    Ok(Some(decided))
}

/// Returns the length of a text without a character that its end may have cut.
fn utf8_end(text: &[u8], is_last: bool) -> usize {
    match text.iter().rposition(u8::is_ascii) {
        Some(last) if !is_last => last + 1,
        _ => text.len(),
    }
}

impl Found<'_> {
    fn decide(self) -> Result<Decided> {
        let width = width(&self.sample);
        self.check_line_ends()?;
        let trailing = self.trailing_separators(width);
        let ncells = width - trailing;
        let header = self.header(width, ncells)?;
        let (names, has_header) = match header {
            Header::No(names) => (names, false),
            Header::Names => (self.first_names(ncells, false), true),
            Header::Short => (self.first_names(ncells, true), true),
        };
        let data = usize::from(has_header);
        if self.sample.rows.len() == data {
            return Err(self.no_rows());
        }
        let is_short = has_header && self.sample.rows[0].fields.len() < ncells;
        let index = match self.options.index {
            Some(index) => index,
            None if is_short => self.is_index(width)?,
            None => {
                ncells > 1
                    && names.first().is_some_and(String::is_empty)
                    && names[1..].iter().all(|name| !name.is_empty())
            }
        };
        let kinds: Vec<Kind> = (0..ncells)
            .map(|j| match self.is_named_factor(&names, j) && self.has_word(data, width, j) {
                true => Kind::Words,
                false => self.kind(data, width, j),
            })
            .collect();
        let (used, left_out) = self.used(&kinds, &names, index, data, width)?;
        let notation = self.notation(&used, &kinds, data, width)?;
        let (start, first_line) = match has_header {
            true => (self.sample.rows[0].end, self.sample.rows[1].line),
            false => (self.sample.rows[0].start, self.sample.rows[0].line),
        };
        let has_numbers_in_header =
            has_header && self.sample.rows[0].fields.iter().any(|f| self.cell(f).is_number());
        let mut uses = vec![Use::Skip; width];
        let (mut columns, mut nfactors) = (Vec::new(), 0);
        for (place, &j) in used.iter().enumerate() {
            let name = names.get(j).cloned().unwrap_or_default();
            let is_factor = kinds[j] == Kind::Words;
            uses[j] = match is_factor {
                true => Use::Word(place, nfactors),
                false => Use::Number(place),
            };
            nfactors += usize::from(is_factor);
            let kind = match is_factor {
                true => ColumnKind::Factor { levels: Vec::new() },
                false => ColumnKind::Numbers,
            };
            columns.push(TableColumn { name, number: j, kind });
        }
        uses[ncells..].fill(Use::Empty);
        let mut reading = TableReading {
            format: FileFormat::Table,
            separator: None,
            decimal: '.',
            thousands: None,
            encoding: "UTF-8",
            header: !names.is_empty(),
            has_numbers_in_header,
            skipped_lines: 0,
            index: index && self.columns.is_all(),
            trailing_separator: trailing > 0,
            has_escaped_quotes: self.syntax.has_escapes,
            has_commented_rows: false,
            left_out,
            columns,
            dropped_rows: 0,
            rounded: None,
        };
        reading.set_notation(notation);
        if width > 1 {
            reading.set_separator(self.syntax.between);
        }
        let layout = Layout {
            syntax: self.syntax,
            notation,
            missing_words: self.missing_words.read_in(notation),
            missing: self.options.missing,
            uses,
            ncols: used.len(),
            nfactors,
            first_line,
            has_header,
            names,
        };
        Ok(Decided { layout, reading, first: 0, start })
    }

    /// Returns the number of separators at the end of each row, behind which there is nothing. The
    /// header may end without the only one.
    fn trailing_separators(&self, width: usize) -> usize {
        let rows = &self.sample.rows;
        let is_empty = |row: &SampleRow, back: usize| {
            row.fields.iter().rev().nth(back).is_some_and(Vec::is_empty)
        };
        let are_empty = |back: usize| self.rows(1, width).all(|row| is_empty(row, back));
        let is_whole = rows[0].fields.len() == width;
        let first = rows[0].fields.len() + 1 == width || is_empty(&rows[0], 0);
        let has_one = width > 1
            && self.syntax.between != Between::Blanks
            && first
            && are_empty(0)
            && (rows.len() > 1 || is_empty(&rows[0], 0))
            && (rows.len() == 1 || self.rows(1, width).next().is_some());
        if !has_one {
            return 0;
        }
        let is_another = |back: &usize| is_whole && is_empty(&rows[0], *back) && are_empty(*back);
        1 + (1..width - 1).take_while(is_another).count()
    }

    /// Checks that no row has within it what ends lines elsewhere: rows would be lost.
    fn check_line_ends(&self) -> Result<()> {
        let ends = |text: &[u8]| {
            LINE_ENDS.iter().any(|end| memchr::memmem::find(text, end.as_bytes()).is_some())
        };
        let is_joined = |row: &&SampleRow| row.quotes == 0 && row.fields.iter().any(|f| ends(f));
        match self.sample.rows.iter().find(is_joined) {
            None => Ok(()),
            Some(row) => Err(self.fail(
                row.line,
                format!(
                    "{} has the end of a line of another kind within it: write one kind of line \
                     ends",
                    excerpt(&row.fields.join(&b' '))
                ),
            )),
        }
    }

    /// Returns the columns that are used, in order, and the names of those of words that are left
    /// out.
    fn used(
        &self,
        kinds: &[Kind],
        names: &[String],
        index: bool,
        data: usize,
        width: usize,
    ) -> Result<(Vec<usize>, Vec<String>)> {
        let takes_words =
            |j: usize| self.options.words == Words::Factor || self.is_named_factor(names, j);
        let name = |j: usize| match names.get(j).filter(|name| !name.is_empty()) {
            Some(name) => name.clone(),
            None => j.to_string(),
        };
        let word = |j: usize| {
            let row = self.rows(data, width).find(|row| self.cell(&row.fields[j]) == Cell::Word);
            let found = row.map(|row| (row.line, excerpt(&row.fields[j])));
            found.unwrap_or((self.sample.next_line, String::new()))
        };
        let wrong = |j: usize| {
            let (line, word) = word(j);
            let columns = option("columns");
            let what = format!("column {} has words, such as {word}", name(j));
            self.fail(line, format!("{what}; {columns} leaves it out"))
        };
        if !self.columns.is_all() {
            let used = self.columns.of(names, kinds.len())?;
            match used.iter().find(|&&j| kinds[j] == Kind::Words && !takes_words(j)) {
                Some(&j) => return Err(wrong(j)),
                None => return Ok((used, Vec::new())),
            }
        }
        let (mut used, mut left_out) = (Vec::new(), Vec::new());
        for j in usize::from(index)..kinds.len() {
            match kinds[j] {
                Kind::Words if !takes_words(j) => left_out.push(name(j)),
                _ => used.push(j),
            }
        }
        match used.is_empty() && !left_out.is_empty() {
            true => {
                let j = usize::from(index);
                let (line, word) = word(j);
                let mut rows = self.rows(data, width);
                let how = match width == 1 && rows.all(SampleRow::is_quoted) {
                    true => {
                        "each row is in quotes, which hide its separators: take them off".into()
                    }
                    false => format!("{} divides rows otherwise", option("separator")),
                };
                let column = name(j);
                let what =
                    format!("no column of numbers: column {column} has words, such as {word}");
                Err(self.fail(line, format!("{what}; {how}")))
            }
            false => Ok((used, left_out)),
        }
    }
}
