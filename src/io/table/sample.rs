//! The beginning of a table, from which its dialect is found.

use super::missing::MissingWords;
use super::number::{self, Readings};
use super::splitter::{Between, ESCAPE, Found, Splitter, Syntax};

/// Most records that are looked at.
const MOST: usize = 1000;

/// A record of the beginning of a table.
#[derive(Debug)]
pub(super) struct SampleRow {
    /// The number of its line, from 1.
    pub line: usize,
    /// Where it begins and ends in the text.
    pub start: usize,
    pub end: usize,
    pub fields: Vec<Vec<u8>>,
    /// Quotes in the text of the record.
    pub quotes: usize,
    /// Whether it begins with one of them.
    pub begins_quoted: bool,
    /// Whether its first field goes on behind its closing quote, as no writer leaves it.
    pub is_torn: bool,
}

impl SampleRow {
    /// Returns whether each of its fields is in quotes.
    pub fn is_quoted(&self) -> bool {
        self.quotes >= 2 * self.fields.len()
    }
}

/// The records at the beginning of a table.
#[derive(Debug)]
pub(super) struct Sample {
    pub rows: Vec<SampleRow>,
    /// The comment before the first record.
    pub comment: Option<Vec<u8>>,
    /// Whether there are comments after it.
    pub has_later_comments: bool,
    /// The line behind the last one that was looked at.
    pub next_line: usize,
}

/// What a field of a sample is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cell {
    Missing,
    /// A number, in these notations.
    Number(Readings),
    /// A word that stands for a number: infinity, or NaN where it is not missing.
    NotFinite,
    Word,
}

impl Cell {
    pub fn of(field: &[u8], missing: &MissingWords) -> Self {
        if missing.holds(field) {
            return Self::Missing;
        }
        match number::readings(field) {
            0 if number::parse(field, number::PLAIN).is_some() => Self::NotFinite,
            0 => Self::Word,
            readings => Self::Number(readings),
        }
    }

    pub fn is_number(self) -> bool {
        matches!(self, Self::Number(_))
    }
}

/// Returns whether a field of a record goes on behind its closing quote, never has one, or has
/// quotes without beginning with one, between separators that are a byte.
pub(super) fn has_torn_field(record: &[u8], separator: u8, syntax: Syntax) -> bool {
    let mut rest = record;
    loop {
        if let Some(inner) = rest.strip_prefix(b"\"") {
            rest = inner;
            loop {
                rest = match rest {
                    [ESCAPE, _, more @ ..] if syntax.has_escapes => more,
                    [b'"', b'"', more @ ..] => more,
                    [b'"', more @ ..] => {
                        rest = more;
                        break;
                    }
                    [_, more @ ..] => more,
                    [] => return true,
                };
            }
            let next = rest.iter().find(|&&byte| byte == separator || byte != b' ');
            let is_end = |&byte: &u8| byte == b'\r' || byte == syntax.line_end;
            match next {
                Some(&byte) if byte == separator => {}
                next => return !next.is_none_or(is_end),
            }
        }
        let end = memchr::memchr(separator, rest).unwrap_or(rest.len());
        let field = rest[..end].trim_ascii();
        let is_whole = match field.strip_prefix(b"=").unwrap_or(field) {
            [b'"', .., b'"'] => true,
            inner => !inner.contains(&b'"'),
        };
        match rest.get(end + 1..) {
            _ if !is_whole => return true,
            Some(more) => rest = more,
            None => return false,
        }
    }
}

fn is_torn(record: &[u8], syntax: Syntax) -> bool {
    let Some(mut rest) = record.trim_ascii_start().strip_prefix(b"\"") else { return false };
    loop {
        let Some(end) = memchr::memchr(b'"', rest) else { return false };
        rest = &rest[end + 1..];
        // Two quotes are one of the field.
        match rest.strip_prefix(b"\"") {
            Some(more) => rest = more,
            None => break,
        }
    }
    let next = match syntax.between {
        Between::Byte(_) => rest.iter().find(|&&byte| byte != b' '),
        Between::Blanks => rest.first(),
    };
    next.is_some_and(|&byte| {
        let is_comment = syntax.has_trailing_comments && byte == syntax.comment;
        let ends = byte == b'\r' || byte == syntax.line_end || is_comment;
        !ends
            && match syntax.between {
                Between::Byte(separator) => byte != separator,
                Between::Blanks => !byte.is_ascii_whitespace(),
            }
    })
}

/// Divides a text, which begins with line `line`, into records.
pub(super) fn divide(text: &[u8], syntax: Syntax, is_last: bool, mut line: usize) -> Sample {
    let mut splitter = Splitter::new(syntax);
    let (mut rows, mut comment, mut has_later_comments, mut at) = (Vec::new(), None, false, 0);
    while rows.len() < MOST && at < text.len() {
        let rest = &text[at..];
        let (found, bytes) = splitter.step(rest, is_last, true);
        match found {
            Found::Nothing => break,
            Found::Blank => {}
            Found::Comment if rows.is_empty() => comment = Some(rest[..bytes].to_vec()),
            Found::Comment => has_later_comments = true,
            Found::Record => {
                let fields = (0..splitter.len()).map(|j| splitter.field(rest, j).to_vec());
                let (start, end) = (at, at + bytes);
                let quotes = memchr::memchr_iter(b'"', &rest[..bytes]).count();
                let begins_quoted = rest.trim_ascii_start().first() == Some(&b'"');
                let fields = fields.collect();
                // Escapes are read only where no field is torn with them.
                let is_torn = !syntax.has_escapes && is_torn(&rest[..bytes], syntax);
                rows.push(SampleRow { line, start, end, fields, quotes, begins_quoted, is_torn });
            }
        }
        line += memchr::memchr_iter(syntax.line_end, &rest[..bytes]).count();
        at += bytes;
    }
    // A last line without an end counts, too.
    let next_line = line + usize::from(at > 0 && text[at - 1] != syntax.line_end);
    Sample { rows, comment, has_later_comments, next_line }
}
