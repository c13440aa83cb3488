//! Decides from the beginning of a table how all of it is read.

use std::path::Path;

use super::encoding;
use super::foreign;
use super::message::{excerpt, fields, option};
use super::missing::MissingWords;
use super::number::{self, NOTATIONS, Notation, PLAIN, POINTS_OF_THOUSANDS, Readings};
use super::options::{Missing, Separator, TableOptions, Words};
use super::reading::{ColumnKind, TableColumn, TableReading, called};
use super::sample::{Cell, Sample, SampleRow, divide};
use super::splitter::{Between, Syntax};
use super::syntax::{announced, find, line_end, width};
use crate::base::Result;
use crate::io::columns::Columns;
use crate::io::names::FileFormat;
use crate::io::source::error;

/// The least records that are looked at, if there are more.
const LEAST_ROWS: usize = 4;

/// How many times farther than the numbers of a column are from each other a number of the first
/// row must be to be taken for a name.
const FAR: f64 = 3.0;

/// Ends of lines, beside the one that a file has.
const LINE_ENDS: [&str; 4] = ["\r", "\u{85}", "\u{2028}", "\u{2029}"];

/// Numbers of a first row that are the least or the greatest of their columns by a smaller chance
/// than this may be names.
const CHANCE: f64 = 0.01;

/// Columns that the first row hardly counts by chance if it is the only one of integers.
const SURE: usize = 4;

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

/// What most fields of a column are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Numbers,
    Words,
    /// There are none, or all are missing.
    Unknown,
}

/// Which names columns have.
enum Header {
    /// The first row is one of numbers; the names are those of a comment, if there are any.
    No(Vec<String>),
    /// The names are those of the first row.
    Names,
    /// The names are those of the first row, and the first column has none.
    Short,
}

/// A table whose beginning was divided into records.
struct Found<'a> {
    path: &'a Path,
    options: &'a TableOptions,
    columns: &'a Columns,
    sample: Sample,
    syntax: Syntax,
    missing_words: MissingWords,
}

impl Found<'_> {
    fn fail(&self, line: usize, what: impl Into<String>) -> crate::Error {
        error(self.path, line, what)
    }

    fn no_rows(&self) -> crate::Error {
        let what = "the file ends without a row of numbers";
        match self.sample.later_comments.is_empty() {
            true => self.fail(self.sample.next_line, what),
            false => {
                let comment = option("comment");
                let what = format!("{what}, but with comments; {comment} names another sign");
                self.fail(self.sample.next_line, what)
            }
        }
    }

    fn cell(&self, field: &[u8]) -> Cell {
        Cell::of(field, &self.missing_words)
    }

    /// Returns the rows from `from` on that have `width` fields.
    fn rows(&self, from: usize, width: usize) -> impl Iterator<Item = &SampleRow> {
        self.sample.rows[from..].iter().filter(move |row| row.fields.len() == width)
    }

    /// Checks that rows which commas divide into a word and a number are not as well a word and a
    /// number with a decimal comma, between bars or blanks.
    fn check_commas(&self, text: &[u8], is_last: bool, line: usize) -> Result<()> {
        if self.syntax.between != Between::Byte(b',') || self.options.decimal.is_some() {
            return Ok(());
        }
        let rows = &self.sample.rows;
        let names = rows[0].fields.len();
        // A header of one name says nothing about the separator.
        let data = usize::from(rows.len() > 1 && names == 1);
        let is_fraction = |field: &[u8]| {
            let comma = memchr::memchr(b',', field);
            comma.is_some_and(|at| at + 1 < field.len())
                && number::parse(field, NOTATIONS[1]).is_some()
        };
        let is_pair = |row: &SampleRow| {
            matches!(&row.fields[..], [word, number]
                if self.cell(word) == Cell::Word && is_fraction(number))
        };
        for (between, by) in [(Between::Byte(b'|'), "bars"), (Between::Blanks, "blanks")] {
            let other = divide(text, Syntax { between, ..self.syntax }, is_last, line).rows;
            let is_whole = other.len() == rows.len() && other[0].fields.len() == names;
            if is_whole && other[data..].iter().all(is_pair) {
                let (separator, decimal) = (option("separator"), option("decimal"));
                return Err(self.fail(
                    other[data].line,
                    format!(
                        "{} is a word and a number between commas, or between {by} with a decimal \
                         comma: {separator} or {decimal} decides",
                        excerpt(text[other[data].start..other[data].end].trim_ascii())
                    ),
                ));
            }
        }
        Ok(())
    }

    /// Returns whether the rows below a header of one name are pairs between commas that are
    /// numbers with a decimal comma, or single numbers and missing cells.
    ///
    /// # Errors
    /// They may also be row numbers and numbers, or two numbers below a title.
    fn is_one_column_of_decimal_commas(&self) -> Result<bool> {
        let (first, rest) = match &self.sample.rows[..] {
            [first, rest @ ..] if !rest.is_empty() => (first, rest),
            _ => return Ok(false),
        };
        let is_number = |row: &SampleRow| match &row.fields[..] {
            [field] => self.cell(field) != Cell::Word,
            [_, _] => is_decimal_comma(&row.fields.join(&b',')),
            _ => false,
        };
        // As integers, these would not be written so.
        let is_sure = |row: &SampleRow| match &row.fields[..] {
            [whole, fraction] => whole == b"-0" || fraction.len() > 1 && fraction[0] == b'0',
            _ => true,
        };
        let is_name = first.fields.len() == 1 && self.cell(&first.fields[0]) == Cell::Word;
        let comma = Between::Byte(b',');
        if self.syntax.between != comma || !is_name || !rest.iter().all(is_number) {
            return Ok(false);
        }
        if self.options.index == Some(true) || self.options.decimal.is_some() {
            return Ok(false);
        }
        if self.options.index.is_none() && self.is_counted(2) {
            let (index, decimal) = (option("index"), option("decimal"));
            return Err(self.fail(
                rest[0].line,
                format!(
                    "{} is a row number and a number, or a number with a decimal comma: {index} \
                     or {decimal} decides",
                    excerpt(&rest[0].fields.join(&b','))
                ),
            ));
        }
        if self.options.index.is_none() && !rest.iter().any(is_sure) {
            let (decimal, skip) = (option("decimal"), option("skip"));
            return Err(self.fail(
                rest[0].line,
                format!(
                    "{} is a number with a decimal comma below a name, or two numbers below a \
                     title: {decimal} decides, or {skip} = {} leaves the title out",
                    excerpt(&rest[0].fields.join(&b',')),
                    first.line
                ),
            ));
        }
        Ok(true)
    }

    /// Returns whether all rows are pairs between commas that are numbers such as 1.234.567,89,
    /// with points between thousands.
    ///
    /// # Errors
    /// They may also be pairs, as 1.234,89.
    fn is_one_column_of_thousands(&self) -> Result<bool> {
        let rows = &self.sample.rows;
        let is_number = |row: &SampleRow| match &row.fields[..] {
            [_, fraction] => !fraction.is_empty() && is_decimal_comma(&row.fields.join(&b',')),
            _ => false,
        };
        let has_point = |row: &&SampleRow| row.fields[0].contains(&b'.');
        if self.syntax.between != Between::Byte(b',')
            || self.options.decimal.is_some()
            || !rows.iter().all(is_number)
        {
            return Ok(false);
        }
        let Some(row) = rows.iter().find(has_point) else { return Ok(false) };
        if rows.iter().any(|row| number::parse(&row.fields[0], PLAIN).is_none()) {
            return Ok(true);
        }
        let (separator, decimal) = (option("separator"), option("decimal"));
        let text = excerpt(&row.fields.join(&b','));
        Err(self.fail(
            row.line,
            format!(
                "{text} is two numbers, or one with a decimal comma: {separator} or {decimal} \
                 decides"
            ),
        ))
    }

    /// Returns whether the first column counts the rows below the header, from 0 or 1.
    fn is_counted(&self, width: usize) -> bool {
        let number = |row: &SampleRow| -> Option<u64> {
            std::str::from_utf8(&row.fields[0]).ok()?.parse().ok()
        };
        let mut numbers = self.rows(1, width).map(number);
        let Some(Some(first @ 0..=1)) = numbers.next() else { return false };
        numbers.zip(first + 1..).all(|(number, expected)| number == Some(expected))
    }

    fn kind(&self, from: usize, width: usize, j: usize) -> Kind {
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
    fn is_named_factor(&self, names: &[String], j: usize) -> bool {
        let is_own = |factor: &String| names.get(j) == Some(factor) || *factor == j.to_string();
        self.options.factors.iter().any(is_own)
    }

    fn has_word(&self, from: usize, width: usize, j: usize) -> bool {
        self.rows(from, width).any(|row| self.cell(&row.fields[j]) == Cell::Word)
    }

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
        Ok(Decided { layout, reading, start })
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

    /// Decides whether the first row has names.
    fn header(&self, width: usize, ncells: usize) -> Result<Header> {
        let first = &self.sample.rows[0];
        let len = match first.fields.len() {
            len if len == width => ncells,
            // Only the header has separators at its end.
            len if len > ncells && first.fields[ncells..].iter().all(Vec::is_empty) => ncells,
            len => len,
        };
        let cells: Vec<Cell> = first.fields[..len].iter().map(|field| self.cell(field)).collect();
        let has_word = cells.contains(&Cell::Word);
        let has_number = cells.iter().any(|cell| cell.is_number());
        match self.options.header {
            Some(false) => return self.without(len, ncells),
            Some(true) if len + 1 == ncells => return Ok(Header::Short),
            None if len + 1 == ncells && (has_word && !has_number || self.numbers_rows(width)) => {
                return Ok(Header::Short);
            }
            _ => {}
        }
        if len != ncells {
            return Err(self.ragged(len, width));
        }
        if self.options.header == Some(true) {
            return Ok(Header::Names);
        }
        if self.sample.rows.len() == 1 {
            return if has_word && !has_number {
                Ok(Header::Names)
            } else {
                Ok(Header::No(self.comment_names(ncells)))
            };
        }
        if has_word {
            return self.header_of_words(&cells, width);
        }
        let has_unnamed_index = first.fields[0].is_empty()
            && cells[1..].iter().all(|cell| cell.is_number())
            && self.numbers_rows(width);
        if has_unnamed_index || self.only_first_is_quoted() {
            return Ok(Header::Names);
        }
        if cells.contains(&Cell::NotFinite) && !has_number {
            return Ok(Header::Names);
        }
        let names = self.comment_names(ncells);
        let is_doubtful =
            || self.may_be_names(&cells, width, true) || self.counts_columns(&cells, width);
        if names.is_empty() && ncells > 1 && is_doubtful() {
            return Err(self.two_readings());
        }
        Ok(Header::No(names))
    }

    /// Returns whether the first column counts or names the rows below the first one.
    fn numbers_rows(&self, width: usize) -> bool {
        width > 1 && (self.is_counted(width) || self.kind(1, width, 0) == Kind::Words)
    }

    /// Returns whether each field of the first row is in quotes, and no other row is like that.
    fn only_first_is_quoted(&self) -> bool {
        let rows = &self.sample.rows;
        rows[0].is_quoted() && !rows[1..].iter().any(SampleRow::is_quoted)
    }

    fn without(&self, len: usize, ncells: usize) -> Result<Header> {
        match len == ncells {
            true => Ok(Header::No(self.comment_names(ncells))),
            false => Err(self.ragged(len, ncells)),
        }
    }

    /// Decides whether a first row with a word, as wide as the others, has names.
    fn header_of_words(&self, cells: &[Cell], width: usize) -> Result<Header> {
        let kind = |j: usize| self.kind(1, width, j);
        let words = || (0..cells.len()).filter(move |&j| cells[j] == Cell::Word);
        let first = &self.sample.rows[0];
        let has_number = cells.iter().any(|cell| cell.is_number());
        let mut above_numbers = words().filter(|&j| kind(j) != Kind::Words).peekable();
        if above_numbers.peek().is_some() {
            // Beside a number `1.5*` or `?` is as well a cell that can't be read, and so is any
            // word beside a fraction that could be one of its column.
            let is_fraction =
                |j: usize| cells[j].is_number() && !first.fields[j].iter().all(u8::is_ascii_digit);
            let is_doubtful = has_number && above_numbers.all(|j| is_no_name(&first.fields[j]))
                || (0..cells.len()).any(is_fraction) && !self.may_be_names(cells, width, false);
            return match is_doubtful && !self.only_first_is_quoted() {
                true => Err(self.two_readings()),
                false => Ok(Header::Names),
            };
        }
        // All its words are in columns of words.
        let is_level = |j: usize| self.rows(1, width).any(|row| row.fields[j] == first.fields[j]);
        if words().any(is_level) {
            return Ok(Header::No(Vec::new()));
        }
        if !has_number || self.may_be_names(cells, width, false) {
            return Ok(Header::Names);
        }
        Err(self.two_readings())
    }

    /// Returns whether the numbers of the first row increase, and each is far from the other
    /// numbers of its column, if there are any: [`FAR`] times farther than these are from each
    /// other, or than a single one is from 0. Numbers of three digits or more with equal steps, as
    /// years and wavelengths, need only be outside of the range, and so do numbers that would all
    /// be there by a small chance ([`CHANCE`]) if they were data: the first of m numbers is the
    /// least or the greatest in 2 of m cases, unless the column is sorted. Without a word beside
    /// them they must be integers.
    fn may_be_names(&self, cells: &[Cell], width: usize, must_be_integers: bool) -> bool {
        let far = if self.is_regular(width) { 0.0 } else { FAR };
        let (mut last, mut is_far, mut chance) = (f64::NEG_INFINITY, true, 1.0);
        for (j, cell) in cells.iter().enumerate() {
            let field = &self.sample.rows[0].fields[j];
            match cell {
                Cell::Number(_) => {}
                Cell::Word if !must_be_integers => continue,
                // An index has no name.
                Cell::Missing if !must_be_integers && j == 0 => continue,
                _ => return false,
            }
            if must_be_integers && !field.iter().all(u8::is_ascii_digit) {
                return false;
            }
            let Some(value) = any_reading(field) else { return false };
            let others: Vec<f64> =
                self.rows(1, width).filter_map(|row| any_reading(&row.fields[j])).collect();
            let low = others.iter().copied().fold(f64::INFINITY, f64::min);
            let high = others.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let reach = match others.len() {
                0 if !must_be_integers => 0.0,
                0 | 1 => high.abs(),
                _ => far * (high - low),
            };
            let is_outside = |reach: f64| low - value > reach || value - high > reach;
            if value <= last || !is_outside(0.0) {
                return false;
            }
            is_far &= is_outside(reach);
            if !others.is_sorted() && !others.iter().rev().is_sorted() {
                chance *= 2.0 / (others.len() + 1) as f64;
            }
            last = value;
        }
        is_far || must_be_integers && chance < CHANCE
    }

    /// Returns whether the first row counts the columns from 0 or 1, as pandas names those without
    /// names, and hardly would as a row of data. If no other row counts, that is so where
    /// - there are [`SURE`] columns or more, and no other number is an integer, or
    /// - the numbers of the first row would all be there by a small chance ([`CHANCE`]): each
    ///   number of a column is as likely to be the first. Of fewer columns than [`SURE`], this
    ///   holds only for unsorted ones, and there must be two.
    fn counts_columns(&self, cells: &[Cell], width: usize) -> bool {
        let count = |field: &Vec<u8>| -> Option<u64> {
            let is_count = field.iter().all(u8::is_ascii_digit);
            std::str::from_utf8(field).ok().filter(|_| is_count)?.parse().ok()
        };
        let counts = |row: &SampleRow| {
            let mut numbers = row.fields.iter().take(cells.len()).map(count);
            let first = numbers.next().flatten();
            first.is_some_and(|first| numbers.zip(first + 1..).all(|(n, next)| n == Some(next)))
        };
        let first = &self.sample.rows[0];
        if count(&first.fields[0]).is_none_or(|first| first > 1)
            || !counts(first)
            || self.rows(1, width).any(counts)
        {
            return false;
        }
        let has_many = cells.len() >= SURE;
        let (mut chance, mut used) = (1.0, 0);
        for j in 0..cells.len() {
            let value = any_reading(&first.fields[j]);
            let others: Vec<f64> =
                self.rows(1, width).filter_map(|row| any_reading(&row.fields[j])).collect();
            if has_many || !others.is_sorted() && !others.iter().rev().is_sorted() {
                let equal = others.iter().filter(|&&other| Some(other) == value).count();
                chance *= (equal + 1) as f64 / (others.len() + 1) as f64;
                used += 1;
            }
        }
        let has_integers =
            || self.rows(1, width).any(|row| row.fields.iter().any(|field| count(field).is_some()));
        has_many && !has_integers() || used > 1 && chance < CHANCE
    }

    /// Returns whether the first row has three numbers or more with equal steps, of 100 or more; or
    /// of 10 or more, if not all rows have these steps.
    fn is_regular(&self, width: usize) -> bool {
        let numbers = |row: &SampleRow| -> Vec<f64> {
            row.fields.iter().take(width).filter_map(|field| any_reading(field)).collect()
        };
        // The step of a row, if it has one.
        let step = |row: &SampleRow| {
            let numbers = numbers(row);
            let mut steps = numbers.windows(2).map(|pair| pair[1] - pair[0]);
            let first = steps.next()?;
            (numbers.len() > 2 && steps.all(|step| step == first)).then_some(first)
        };
        let rows = &self.sample.rows;
        let (first, own) = (numbers(&rows[0]), step(&rows[0]));
        match first.first() {
            Some(&least) if own.is_some() && least >= 100.0 => true,
            Some(&least) if own.is_some() && least >= 10.0 => {
                !self.rows(1, width).all(|row| step(row) == own)
            }
            _ => false,
        }
    }

    fn two_readings(&self) -> crate::Error {
        let first = &self.sample.rows[0];
        let header = option("header");
        self.fail(
            first.line,
            format!(
                "{} are names of columns or the first row of numbers: {header} decides",
                excerpt(&first.fields.join(&b' '))
            ),
        )
    }

    fn ragged(&self, len: usize, width: usize) -> crate::Error {
        let first = &self.sample.rows[0];
        let (found, text) = (fields(len), excerpt(&first.fields.join(&b' ')));
        let (skip, separator) = (option("skip"), option("separator"));
        let line = first.line;
        // Rows may have an index without a name.
        let names = match len + 1 == width {
            true => format!(", {} takes it for names", option("header")),
            false => String::new(),
        };
        self.fail(
            line,
            format!(
                "{found} in this row, {width} in those after it: {text}; {skip} = {line} \
                 leaves it out, {separator} divides it otherwise{names}"
            ),
        )
    }

    /// Returns whether the first column, which has no name, is an index.
    fn is_index(&self, width: usize) -> Result<bool> {
        // R writes names of rows, which may be numbers, in quotes.
        let is_name = |row: &SampleRow| row.begins_quoted && !row.is_quoted();
        let is_words = self.kind(1, width, 0) == Kind::Words;
        if is_words || self.is_counted(width) || self.rows(1, width).all(is_name) {
            return Ok(true);
        }
        let (index, skip) = (option("index"), option("skip"));
        let first = &self.sample.rows[0];
        Err(self.fail(
            first.line,
            format!(
                "{} has one name less than the rows have fields: {index} says whether the first \
                 column is data, {skip} leaves lines out",
                excerpt(&first.fields.join(&b' '))
            ),
        ))
    }

    /// Returns the names in the first row; in a short one the first column has none.
    fn first_names(&self, ncells: usize, is_short: bool) -> Vec<String> {
        let fields = &self.sample.rows[0].fields;
        let named = fields.iter().take(ncells).map(|field| encoding::text(field).into_owned());
        let unnamed = is_short.then(String::new);
        unnamed.into_iter().chain(named).collect()
    }

    /// Returns the names in the comment before the first row, as `numpy.savetxt` writes them: a
    /// word for each column. In `#,a,b` the sign of comments is the first one.
    fn comment_names(&self, ncells: usize) -> Vec<String> {
        let comment = self.sample.comment.as_ref();
        let Some(mut fields) = comment.and_then(|line| self.in_comment(line, ncells)) else {
            return Vec::new();
        };
        if ncells > 1 && fields[0].is_empty() {
            fields[0].push(self.syntax.comment);
        }
        match fields.iter().all(|field| self.cell(field) == Cell::Word) {
            true => fields.iter().map(|field| encoding::text(field).into_owned()).collect(),
            false => Vec::new(),
        }
    }

    /// Returns the fields of a comment if there are as many as columns.
    fn in_comment(&self, line: &[u8], ncells: usize) -> Option<Vec<Vec<u8>>> {
        let is_sign = |byte: &u8| *byte == self.syntax.comment || byte.is_ascii_whitespace();
        let start = line.iter().position(|byte| !is_sign(byte)).unwrap_or(line.len());
        let row = divide(&line[start..], self.syntax, true, 1).rows.into_iter().next()?;
        (row.fields.len() == ncells).then_some(row.fields)
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

    /// Returns the only notation in which all numbers of the columns that are used can be read.
    fn notation(
        &self,
        used: &[usize],
        kinds: &[Kind],
        data: usize,
        width: usize,
    ) -> Result<Notation> {
        let options = self.options;
        let fits = |notation: Notation| {
            options.decimal.is_none_or(|c| c == notation.decimal)
                && (options.thousands.is_none() || options.thousands == notation.thousands)
        };
        let allowed = (0..NOTATIONS.len()).filter(|&i| fits(NOTATIONS[i]));
        let allowed: Readings = allowed.map(|i| 1_u8 << i).sum();
        let mut left = allowed;
        let numbers = || {
            let columns = used.iter().filter(move |&&j| kinds[j] != Kind::Words);
            self.rows(data, width).flat_map(move |row| {
                columns.clone().map(move |&j| (row.line, j, &row.fields[j][..]))
            })
        };
        for (line, j, field) in numbers() {
            let Cell::Number(readings) = self.cell(field) else { continue };
            if left & readings == 0 {
                let (decimal, thousands) = (option("decimal"), option("thousands"));
                return Err(self.fail(
                    line,
                    format!(
                        "column {}: {} is no number in the notation of those before it: {decimal} \
                         or {thousands}",
                        j + 1,
                        excerpt(field)
                    ),
                ));
            }
            left &= readings;
        }
        let mut notations =
            (0..NOTATIONS.len()).filter(|i| left >> i & 1 == 1).map(|i| NOTATIONS[i]);
        let Some(chosen) = notations.next() else { return Ok(PLAIN) };
        // Where semicolons separate, commas are decimal and points may be between thousands.
        let has_semicolons = self.syntax.between == Between::Byte(b';');
        let is_other =
            |other: &Notation| chosen != PLAIN || has_semicolons && *other == POINTS_OF_THOUSANDS;
        for other in notations.filter(is_other) {
            for (line, j, field) in numbers() {
                if !self.cell(field).is_number() {
                    continue;
                }
                let [one, two] = [chosen, other].map(|n| number::parse(field, n));
                if let (Some(one), Some(two)) = (one, two)
                    && one != two
                {
                    let text = excerpt(field);
                    let (decimal, thousands) = (option("decimal"), option("thousands"));
                    let [first, second] = [chosen, other].map(described);
                    return Err(self.fail(
                        line,
                        format!(
                            "column {}: {text} is {one} with {first}, {two} with {second}: \
                             {decimal} or {thousands} decides",
                            j + 1
                        ),
                    ));
                }
            }
        }
        Ok(chosen)
    }
}

/// Returns whether a field is a number with a decimal comma, and perhaps points between thousands.
fn is_decimal_comma(field: &[u8]) -> bool {
    [NOTATIONS[1], NOTATIONS[3]].into_iter().any(|n| number::parse(field, n).is_some())
}

/// Words of missing cells that are none by default, in small letters.
const NO_NAMES: [&str; 7] = ["\\n", "missing", "n.a.", "n.d.", "nd", "nil", "undefined"];

/// Returns whether a word has no letter before its first digit, or is an error of a spreadsheet or
/// stands for a missing cell elsewhere: names are hardly so.
fn is_no_name(word: &[u8]) -> bool {
    let text = encoding::text(word);
    let is_missing = NO_NAMES.contains(&&text.to_lowercase()[..]);
    let first = text.chars().find(|c| c.is_alphanumeric());
    let is_error = text.starts_with('#') && text.ends_with(['!', '?']);
    is_error || is_missing || !first.is_some_and(char::is_alphabetic)
}

/// Returns a number in whichever notation reads it first.
fn any_reading(field: &[u8]) -> Option<f64> {
    let readings = number::readings(field);
    let first = (0..NOTATIONS.len()).find(|i| readings >> i & 1 == 1)?;
    number::parse(field, NOTATIONS[first])
}

fn described(notation: Notation) -> String {
    match notation.thousands {
        Some(c) => format!("a {} between thousands", called(c)),
        None => format!("a decimal {}", called(notation.decimal)),
    }
}
