//! Decides whether the first row of a table has the names of columns.

use super::encoding;
use super::found::{Found, Kind};
use super::message::{excerpt, fields, option};
use super::number::{self, NOTATIONS};
use super::sample::{Cell, SampleRow, divide};
use super::splitter::without_signs;
use crate::base::Result;

/// How many times farther than the numbers of a column are from each other a number of the first
/// row must be to be taken for a name.
const FAR: f64 = 3.0;

/// Numbers of a first row that are the least or the greatest of their columns by a smaller chance
/// than this may be names.
const CHANCE: f64 = 0.01;

/// Columns that the first row hardly counts by chance if it is the only one of integers.
const SURE: usize = 4;

/// Which names columns have.
pub(super) enum Header {
    /// The first row is one of numbers; the names are those of a comment, if there are any.
    No(Vec<String>),
    /// The names are those of the first row.
    Names,
    /// The names are those of the first row, and the first column has none.
    Short,
}

impl Found<'_> {
    /// Decides whether the first row has names.
    pub(super) fn header(&self, width: usize, ncells: usize) -> Result<Header> {
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
            let others = self.numbers_below(width, j);
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
            if !is_monotonic(&others) {
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
            let others = self.numbers_below(width, j);
            if has_many || !is_monotonic(&others) {
                let equal = others.iter().filter(|&&other| Some(other) == value).count();
                chance *= (equal + 1) as f64 / (others.len() + 1) as f64;
                used += 1;
            }
        }
        let has_integers =
            || self.rows(1, width).any(|row| row.fields.iter().any(|field| count(field).is_some()));
        has_many && !has_integers() || used > 1 && chance < CHANCE
    }

    /// Returns the numbers of a column below the first row.
    fn numbers_below(&self, width: usize, j: usize) -> Vec<f64> {
        self.rows(1, width).filter_map(|row| any_reading(&row.fields[j])).collect()
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
    pub(super) fn is_index(&self, width: usize) -> Result<bool> {
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
    pub(super) fn first_names(&self, ncells: usize, is_short: bool) -> Vec<String> {
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
        let text = without_signs(line, self.syntax.comment);
        let row = divide(text, self.syntax, true, 1).rows.into_iter().next()?;
        (row.fields.len() == ncells).then_some(row.fields)
    }
}

fn is_monotonic(numbers: &[f64]) -> bool {
    numbers.is_sorted() || numbers.iter().rev().is_sorted()
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
