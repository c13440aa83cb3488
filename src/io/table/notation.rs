//! Decides how the numbers of a table are written, and whether a comma separates columns.

use super::found::{Found, Kind};
use super::message::{excerpt, option};
use super::number::{self, NOTATIONS, Notation, PLAIN, POINTS_OF_THOUSANDS, Readings};
use super::reading::called;
use super::sample::{Cell, SampleRow, divide};
use super::splitter::{Between, Syntax};
use crate::base::Result;

impl Found<'_> {
    /// Checks that rows which commas divide into a word and a number are not as well a word and a
    /// number with a decimal comma, between bars or blanks.
    pub(super) fn check_commas(&self, text: &[u8], is_last: bool, line: usize) -> Result<()> {
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
    pub(super) fn is_one_column_of_decimal_commas(&self) -> Result<bool> {
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
    pub(super) fn is_one_column_of_thousands(&self) -> Result<bool> {
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

    /// Returns the only notation in which all numbers of the columns that are used can be read.
    pub(super) fn notation(
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
    [NOTATIONS[1], POINTS_OF_THOUSANDS].into_iter().any(|n| number::parse(field, n).is_some())
}

fn described(notation: Notation) -> String {
    match notation.thousands {
        Some(c) => format!("a {} between thousands", called(c)),
        None => format!("a decimal {}", called(notation.decimal)),
    }
}
