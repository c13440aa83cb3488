//! The options of commands that read matrices: one meaning for each, over all commands.

use std::ffi::OsString;
use std::ops::Deref;
use std::path::{Path, PathBuf};

use anyhow::Result;
use catamaran::io::{
    Columns, FileFormat, Missing, ReadOptions, Separator, TableOptions, TableReading,
};
use clap::builder::{PossibleValuesParser, TypedValueParser};

use crate::input;
use crate::report::{is_json, note, status};

/// The heading of these options in help texts.
pub const HEADING: &str = "Options of input tables";

/// Names of characters.
const NAMES: [(&str, char); 9] = [
    ("tab", '\t'),
    ("\\t", '\t'),
    ("semicolon", ';'),
    ("comma", ','),
    ("bar", '|'),
    ("blank", ' '),
    ("space", ' '),
    ("point", '.'),
    ("apostrophe", '\''),
];

/// Which columns of A are used, and how its file is read.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct MatrixArgs {
    /// Use these columns of A only: names in the header of a text table, numbers counted from 0,
    /// ranges FIRST..END without END, or a list of these between commas.
    #[arg(long, value_name = "COLUMNS", value_parser = columns)]
    pub columns: Option<Columns>,
    #[command(flatten)]
    pub table: TableArgs,
}

impl MatrixArgs {
    /// Returns the options of the library, within the memory that an input may take.
    pub fn read<'a>(&self) -> ReadOptions<'a> {
        self.table.read().columns(self.columns.clone().unwrap_or(Columns::ALL))
    }

    /// Returns options as [`TableArgs::read_all_rows`] does.
    pub fn read_all_rows<'a>(&self) -> ReadOptions<'a> {
        self.table.read_all_rows().columns(self.columns.clone().unwrap_or(Columns::ALL))
    }
}

/// How a file with a matrix is read. By default the file decides; where it has several readings,
/// an error names the option that decides.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct TableArgs {
    /// What separates fields: a character, or tab, comma, semicolon, bar or blank.
    #[arg(long, value_name = "CHARACTER", value_parser = character, help_heading = HEADING)]
    separator: Option<char>,
    /// The decimal separator: a point or a comma.
    #[arg(long, value_name = "CHARACTER", value_parser = character, help_heading = HEADING)]
    decimal: Option<char>,
    /// What separates groups of three digits: a comma, point, blank or apostrophe.
    #[arg(long, value_name = "CHARACTER", value_parser = character, help_heading = HEADING)]
    thousands: Option<char>,
    /// Take the first row for names of columns, also if they are numbers.
    #[arg(long, conflicts_with = "no_header", help_heading = HEADING)]
    header: bool,
    /// Take the first row for data.
    #[arg(long, help_heading = HEADING)]
    no_header: bool,
    /// Leave out this number of lines at the start.
    #[arg(long, value_name = "LINES", help_heading = HEADING)]
    skip: Option<usize>,
    /// The character that starts a comment, at the start of a line or after a blank.
    #[arg(long, value_name = "CHARACTER", value_parser = character, help_heading = HEADING)]
    comment: Option<char>,
    /// What becomes of rows with a missing cell in a column that is used: an error, dropped rows,
    /// or NaN in their place.
    #[arg(long, value_name = "WHAT", default_value = missing_name(), value_parser = missing(),
          help_heading = HEADING)]
    missing: Option<Missing>,
    /// The words of missing cells, between commas, instead of those of pandas such as NA. Empty
    /// cells are always missing.
    #[arg(long, value_name = "WORDS", value_delimiter = ',', allow_hyphen_values = true,
          help_heading = HEADING)]
    missing_words: Option<Vec<String>>,
    /// Leave out the first column, which numbers or names the rows.
    #[arg(long, conflicts_with = "no_index", help_heading = HEADING)]
    index: bool,
    /// Use the first column as the others.
    #[arg(long, help_heading = HEADING)]
    no_index: bool,
    /// The encoding of text, such as latin1.
    #[arg(long, value_name = "NAME", help_heading = HEADING)]
    encoding: Option<String>,
    /// The format of the file, whatever its name ends in.
    #[arg(long, value_name = "FORMAT", value_parser = format(), help_heading = HEADING)]
    format: Option<FileFormat>,
}

impl TableArgs {
    /// Returns the options of the library for the weights of the rows, which have the notation of
    /// A, but rows and columns of their own.
    pub fn of_weights<'a>(&self) -> ReadOptions<'a> {
        let Self { separator, decimal, thousands, comment, .. } = *self;
        let (missing_words, encoding) = (self.missing_words.clone(), self.encoding.clone());
        let others = Self::default();
        Self { separator, decimal, thousands, comment, missing_words, encoding, ..others }.read()
    }

    /// Returns what becomes of rows with a missing cell.
    pub fn missing(&self) -> Missing {
        self.missing.unwrap_or(TableOptions::new().missing)
    }

    /// Returns the options of [`TableArgs::read`], but rows that are dropped have NaN: they are
    /// left out later, with the rows of other files that belong to them.
    pub fn read_all_rows<'a>(&self) -> ReadOptions<'a> {
        let mut options = self.read();
        if options.table.missing == Missing::Drop {
            options.table.missing = Missing::Nan;
        }
        options
    }

    /// Returns the options of the library, within the memory that an input may take.
    pub fn read<'a>(&self) -> ReadOptions<'a> {
        let flag = |yes: bool, no: bool| if yes { Some(true) } else { no.then_some(false) };
        let mut table = TableOptions::new()
            .separator(self.separator.map(Separator::from))
            .decimal(self.decimal)
            .thousands(self.thousands)
            .header(flag(self.header, self.no_header))
            .comment(self.comment)
            .missing_words(self.missing_words.clone())
            .index(flag(self.index, self.no_index))
            .encoding(self.encoding.clone());
        table.skip = self.skip.unwrap_or(table.skip);
        table.missing = self.missing();
        ReadOptions::new().format(self.format).table(table).max_memory(input::limit())
    }
}

/// Says once how a table was read: in JSON always, and on stderr unless there was nothing to
/// decide.
pub fn say(path: &Path, reading: &TableReading, options: &ReadOptions<'_>) -> Result<()> {
    let name = path.display().to_string();
    if !reading.is_plain() {
        note(format_args!("{name}: {reading}"));
    }
    if !is_json() {
        return Ok(());
    }
    // Of rows with NaN it is said later which are left out.
    let dropped_rows = (options.table.missing != Missing::Nan).then_some(reading.dropped_rows);
    let separator = reading.separator.map(|separator| match separator {
        Separator::Char(c) => c.to_string(),
        _ => "blanks".into(),
    });
    status!(
        "table",
        path = name,
        separator = separator,
        decimal = reading.decimal.to_string(),
        thousands = reading.thousands.map(String::from),
        encoding = reading.encoding,
        header = reading.header,
        skipped_lines = reading.skipped_lines,
        index = reading.index,
        trailing_separator = reading.trailing_separator,
        commented_rows = reading.has_commented_rows,
        escaped_quotes = reading.has_escaped_quotes,
        left_out = reading.left_out,
        dropped_rows = dropped_rows,
        rounded_integers = reading.rounded.as_ref().map_or(0, |rounded| rounded.count);
        "{name}: {reading}"
    )
}

/// Parses columns.
fn columns(text: &str) -> Result<Columns, String> {
    let bound = |text: &str| text.parse::<usize>().ok();
    let range = text.split_once("..").map(|(first, end)| (bound(first), bound(end)));
    match range {
        Some((Some(first), Some(end))) if first >= end => {
            Err("expected FIRST..END with FIRST < END, such as 0..64".into())
        }
        _ => Ok(Columns::parse(text)),
    }
}

/// Parses a character or the name of one.
fn character(text: &str) -> Result<char, String> {
    let named = NAMES.into_iter().find(|(name, _)| *name == text).map(|(_, c)| c);
    let mut characters = text.chars();
    match (named, characters.next(), characters.next()) {
        (Some(c), ..) | (None, Some(c), None) => Ok(c),
        _ => Err("expected a character, or a name such as tab or comma".into()),
    }
}

/// Parses what becomes of rows with missing cells.
fn missing() -> impl TypedValueParser<Value = Missing> {
    PossibleValuesParser::new(Missing::NAMES.map(|(name, _)| name)).map(|name| {
        let found = Missing::NAMES.into_iter().find(|(known, _)| *known == name);
        found.map_or(Missing::Error, |(_, missing)| missing)
    })
}

/// Returns the name of what becomes of such rows by default.
fn missing_name() -> &'static str {
    let default = TableOptions::new().missing;
    let found = Missing::NAMES.into_iter().find(|(_, missing)| *missing == default);
    found.map_or("another", |(name, _)| name)
}

/// Parses a format.
fn format() -> impl TypedValueParser<Value = FileFormat> {
    PossibleValuesParser::new(FileFormat::NAMES.map(|(name, _)| name)).map(|name| {
        let found = FileFormat::NAMES.into_iter().find(|(known, _)| *known == name);
        found.map_or(FileFormat::Table, |(_, format)| format)
    })
}

/// A file with a matrix, or stdin if the name is `-`.
#[derive(Debug, Clone)]
pub struct MatrixFile(PathBuf);

impl From<OsString> for MatrixFile {
    fn from(name: OsString) -> Self {
        Self(if name == "-" { "/dev/stdin".into() } else { name.into() })
    }
}

impl Deref for MatrixFile {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn characters_have_names() {
        for (text, c) in [(";", Some(';')), ("tab", Some('\t')), ("\t", Some('\t')), ("ab", None)] {
            assert_eq!(character(text).ok(), c, "{text:?}");
        }
    }

    #[test]
    fn columns_are_a_range_or_a_list() {
        assert_eq!(columns("1..3"), Ok(Columns::parse("1..3")));
        assert_eq!(columns("x,0,2..4"), Ok(Columns::parse("x,0,2..4")));
        assert!(columns("3..1").is_err());
    }
}
