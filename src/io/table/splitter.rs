//! Records of a text table, and their fields. Records with quotes go through crate csv-core; lines
//! without quotes need only a search for separators.

use std::fmt;
use std::ops::Range;

use csv_core::{ReadRecordResult, Reader, ReaderBuilder, Terminator};
use memchr::{memchr, memchr_iter};

/// The byte with which DOS ends a text.
const END: u8 = 0x1a;

/// Makes a quote within quotes one of the field.
pub(super) const ESCAPE: u8 = b'\\';

/// Errors of spreadsheets that do not end with `!` or `?`.
const ERRORS: [&[u8]; 4] = [b"#N/A", b"#N/A N/A", b"#NA", b"#NV"];

/// What separates the fields of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Between {
    /// A byte.
    Byte(u8),
    /// Runs of blanks and tabs.
    Blanks,
}

/// How a table is divided into records and fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Syntax {
    pub between: Between,
    /// The byte that ends a line; a carriage return before it is no part of the line.
    pub line_end: u8,
    /// The byte that starts a comment at the start of a line.
    pub comment: u8,
    /// Whether that byte also starts a comment after a blank.
    pub has_trailing_comments: bool,
    /// Whether a backslash within quotes makes the next quote one of the field, as MySQL and Spark
    /// write it; not between blanks.
    pub has_escapes: bool,
}

/// What [`Splitter::step`] has found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Found {
    /// More text is needed.
    Nothing,
    /// A line without fields.
    Blank,
    /// A line that is a comment.
    Comment,
    /// A record.
    Record,
}

/// Divides text into records.
pub(super) struct Splitter {
    syntax: Syntax,
    quotes: Reader,
    /// The fields of the last record, one after the other, if it had quotes.
    unquoted: Vec<u8>,
    /// Where fields end in `unquoted`.
    ends: Vec<usize>,
    fields: Vec<Range<usize>>,
    /// Whether `fields` are those of `unquoted`.
    is_unquoted: bool,
    /// Whether the last record was ended by the end of the file, within quotes.
    is_open: bool,
}

impl fmt::Debug for Splitter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Splitter").field("syntax", &self.syntax).finish_non_exhaustive()
    }
}

impl Splitter {
    pub fn new(syntax: Syntax) -> Self {
        let delimiter = match syntax.between {
            Between::Byte(byte) => byte,
            Between::Blanks => b' ',
        };
        let quotes = ReaderBuilder::new()
            .delimiter(delimiter)
            .terminator(Terminator::Any(syntax.line_end))
            .escape(syntax.has_escapes.then_some(ESCAPE))
            .build();
        Self {
            syntax,
            quotes,
            unquoted: Vec::new(),
            ends: vec![0; 64],
            fields: Vec::new(),
            is_unquoted: false,
            is_open: false,
        }
    }

    /// Takes a line or a record from the start of `text`, which begins with a record, and returns
    /// what it is and its bytes. Nothing follows `text` if it `is_last`. The fields of a record are
    /// found if they are wanted.
    pub fn step(&mut self, text: &[u8], is_last: bool, wants_fields: bool) -> (Found, usize) {
        let (line, bytes) = match memchr(self.syntax.line_end, text) {
            Some(end) => (&text[..end], end + 1),
            None if is_last && !text.is_empty() => (text, text.len()),
            None => return (Found::Nothing, 0),
        };
        let content = line.trim_ascii_start();
        let is_blank = match self.syntax.between {
            // Tabs separate empty fields.
            Between::Byte(b'\t') => line.iter().all(|byte| b" \r\x1a".contains(byte)),
            _ => content.is_empty() || content.trim_ascii_end() == [END],
        };
        if is_blank {
            return (Found::Blank, bytes);
        }
        if content.first() == Some(&self.syntax.comment) && !self.is_error_value(content) {
            return (Found::Comment, bytes);
        }
        let has_quotes = memchr(b'"', line).is_some();
        let cut = match self.syntax.has_trailing_comments {
            true => comment_start(line, self.syntax.comment),
            false => None,
        };
        let kept = &line[..cut.unwrap_or(line.len())];
        match self.syntax.between {
            _ if !has_quotes => {
                if wants_fields {
                    self.split(kept);
                }
            }
            Between::Blanks => self.split_quoted_at_blanks(kept),
            Between::Byte(_) if cut.is_some() => {
                self.split_quoted(kept, true);
            }
            Between::Byte(_) => {
                return match self.split_quoted(text, is_last) {
                    Some(bytes) => (Found::Record, bytes),
                    None => (Found::Nothing, 0),
                };
            }
        }
        (Found::Record, bytes)
    }

    /// Returns the number of quotes that begin or end fields, or are doubled.
    fn quotes_in(&self, text: &[u8]) -> usize {
        if !self.syntax.has_escapes {
            return memchr_iter(b'"', text).count();
        }
        let mut is_escaped = false;
        let counts = |&&byte: &&u8| {
            let counted = byte == b'"' && !is_escaped;
            is_escaped = byte == ESCAPE && !is_escaped;
            counted
        };
        text.iter().filter(counts).count()
    }

    /// Returns the number of fields of the last record.
    pub fn len(&self) -> usize {
        self.fields.len()
    }

    /// Returns a field of the last record, which began `text`, without blanks and quotes around it.
    #[inline]
    pub fn field<'t>(&'t self, text: &'t [u8], j: usize) -> &'t [u8] {
        let range = self.fields[j].clone();
        if !self.is_unquoted {
            return text[range].trim_ascii();
        }
        match self.unquoted[range].trim_ascii() {
            // A blank came before the quote.
            [b'"', inner @ .., b'"'] => inner.trim_ascii(),
            field => field,
        }
    }

    /// Returns the last record, which began `text`, if it has no quotes and is UTF-8.
    pub fn line<'t>(&self, text: &'t [u8]) -> Option<&'t str> {
        let end = self.fields.last().filter(|_| !self.is_unquoted)?.end;
        std::str::from_utf8(&text[..end]).ok()
    }

    /// Returns a field of [`Splitter::line`], without blanks around it.
    #[inline]
    pub fn field_of_line<'t>(&self, line: &'t str, j: usize) -> &'t str {
        line[self.fields[j].clone()].trim_ascii()
    }

    /// Returns whether the last record had quotes, and so may have several lines.
    pub fn had_quotes(&self) -> bool {
        self.is_unquoted
    }

    /// Returns whether the last record ends with the file, within quotes that are not closed.
    pub fn is_open(&self) -> bool {
        self.is_open
    }

    /// Returns whether a line begins with a cell such as `#N/A` or `#DIV/0!`, by which spreadsheets
    /// say that there is no number.
    fn is_error_value(&self, line: &[u8]) -> bool {
        let end = match self.syntax.between {
            Between::Byte(separator) => memchr(separator, line),
            Between::Blanks => line.iter().position(is_blank),
        };
        let word = line[..end.unwrap_or(line.len())].trim_ascii();
        let is_part = |byte: &u8| byte.is_ascii_uppercase() || b"0123456789/".contains(byte);
        match word {
            [b'#', inner @ .., b'!' | b'?'] => !inner.is_empty() && inner.iter().all(is_part),
            word => ERRORS.contains(&word),
        }
    }

    /// Finds the fields of a line without quotes.
    fn split(&mut self, line: &[u8]) {
        self.fields.clear();
        (self.is_unquoted, self.is_open) = (false, false);
        match self.syntax.between {
            Between::Byte(separator) => {
                let mut start = 0;
                for end in memchr_iter(separator, line) {
                    self.fields.push(start..end);
                    start = end + 1;
                }
                self.fields.push(start..line.len());
            }
            Between::Blanks => {
                let mut start = None;
                let line = line.trim_ascii_end();
                for (i, byte) in line.iter().enumerate() {
                    match (is_blank(byte), start) {
                        (true, Some(first)) => {
                            self.fields.push(first..i);
                            start = None;
                        }
                        (false, None) => start = Some(i),
                        _ => {}
                    }
                }
                if let Some(first) = start {
                    self.fields.push(first..line.len());
                }
            }
        }
    }

    /// Finds the fields of a line at blanks outside of quotes; two quotes within quotes are one.
    fn split_quoted_at_blanks(&mut self, line: &[u8]) {
        self.fields.clear();
        self.unquoted.clear();
        (self.is_unquoted, self.is_open) = (true, false);
        let mut rest = line.trim_ascii();
        while let Some(&first) = rest.first() {
            let start = self.unquoted.len();
            if first == b'"' {
                rest = &rest[1..];
                loop {
                    let end = memchr(b'"', rest).unwrap_or(rest.len());
                    self.unquoted.extend_from_slice(&rest[..end]);
                    rest = rest.get(end + 1..).unwrap_or_default();
                    match rest.strip_prefix(b"\"") {
                        Some(more) => {
                            self.unquoted.push(b'"');
                            rest = more;
                        }
                        None => break,
                    }
                }
            }
            // What follows a closing quote belongs to the field, as between other separators.
            let end = rest.iter().position(is_blank).unwrap_or(rest.len());
            self.unquoted.extend_from_slice(&rest[..end]);
            rest = &rest[end..];
            self.fields.push(start..self.unquoted.len());
            rest = rest.trim_ascii_start();
        }
    }

    /// Finds the fields of the record at the start of `text` by the rules of RFC 4180, and returns
    /// its bytes; `None` when more text is needed.
    fn split_quoted(&mut self, text: &[u8], is_last: bool) -> Option<usize> {
        self.fields.clear();
        (self.is_unquoted, self.is_open) = (true, false);
        self.quotes.reset();
        if self.unquoted.len() <= text.len() {
            self.unquoted.resize(text.len() + 1, 0);
        }
        let (mut read, mut written, mut ended) = (0, 0, 0);
        let is_cut = loop {
            let rest = &text[read..];
            let (result, bytes, out, ends) = self.quotes.read_record(
                rest,
                &mut self.unquoted[written..],
                &mut self.ends[ended..],
            );
            read += bytes;
            written += out;
            ended += ends;
            match result {
                ReadRecordResult::Record | ReadRecordResult::End => break rest.is_empty(),
                // Without input the reader would take the record for the last one.
                _ if read == text.len() && !is_last => return None,
                ReadRecordResult::InputEmpty => {}
                ReadRecordResult::OutputFull => self.unquoted.resize(2 * self.unquoted.len(), 0),
                ReadRecordResult::OutputEndsFull => self.ends.resize(2 * self.ends.len(), 0),
            }
        };
        // Only quotes keep a record from ending with its line.
        let taken = &text[..read];
        self.is_open = is_cut
            && memchr(self.syntax.line_end, taken).is_some()
            && self.quotes_in(taken) % 2 == 1;
        let mut start = 0;
        for &end in &self.ends[..ended] {
            self.fields.push(start..end);
            start = end;
        }
        Some(read)
    }
}

/// Returns whether a byte separates fields between blanks; a carriage return does not.
fn is_blank(byte: &u8) -> bool {
    matches!(byte, b' ' | b'\t')
}

/// Returns a line that is a comment without the signs and blanks before it.
pub(super) fn without_signs(line: &[u8], comment: u8) -> &[u8] {
    let is_sign = |&byte: &u8| byte == comment || byte.is_ascii_whitespace();
    let start = line.iter().position(|byte| !is_sign(byte)).unwrap_or(line.len());
    &line[start..]
}

/// Returns where the comment of a line starts: after a blank, outside of quotes.
pub(super) fn comment_start(line: &[u8], comment: u8) -> Option<usize> {
    memchr_iter(comment, line).find(|&at| {
        at > 0
            && matches!(line[at - 1], b' ' | b'\t')
            && memchr_iter(b'"', &line[..at]).count().is_multiple_of(2)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const COMMA: Syntax = Syntax {
        between: Between::Byte(b','),
        line_end: b'\n',
        comment: b'#',
        has_trailing_comments: false,
        has_escapes: false,
    };

    /// Returns the records of a text, given to the splitter in two parts.
    fn records(syntax: Syntax, text: &str, cut: usize) -> Vec<Vec<String>> {
        let (mut splitter, mut at, mut end) = (Splitter::new(syntax), 0, cut);
        let mut found = Vec::new();
        while at < text.len() {
            let rest = &text.as_bytes()[at..end];
            let (kind, bytes) = splitter.step(rest, end == text.len(), true);
            if kind == Found::Nothing {
                assert!(end < text.len(), "{text:?} ends at {at}");
                end = text.len();
                continue;
            }
            if kind == Found::Record {
                let field = |j| String::from_utf8_lossy(splitter.field(rest, j)).into_owned();
                found.push((0..splitter.len()).map(field).collect());
            }
            at += bytes;
        }
        found
    }

    #[test]
    fn records_are_the_same_wherever_the_text_is_cut() {
        let blanks = Syntax { between: Between::Blanks, ..COMMA };
        let tabs = Syntax { between: Between::Byte(b'\t'), ..COMMA };
        let comments = Syntax { has_trailing_comments: true, ..COMMA };
        let escapes = Syntax { has_escapes: true, ..COMMA };
        for (syntax, text, expected) in [
            (COMMA, "a, b\r\n# no\n\n1,2\r\n3,", "a|b/1|2/3|"),
            (COMMA, "\"a, b\",\"say \"\"c\"\"\"\n1,2", "a, b|say \"c\"/1|2"),
            (COMMA, "\"two\nlines\",1\n\"x\",2\n", "two\nlines|1/x|2"),
            (COMMA, "5\" pipe,1\n6,2\n", "5\" pipe|1/6|2"),
            (COMMA, "#N/A,1\n#NAME,2\n", "#N/A|1"),
            (COMMA, "#DIV/0!,1\n#NAME?,2\n#NV,3\n#no!,4\n", "#DIV/0!|1/#NAME?|2/#NV|3"),
            (blanks, "#VALUE! 1\n# VALUE! 2\n", "#VALUE!|1"),
            (blanks, "1 2\r3 4\r\n", "1|2\r3|4"),
            (COMMA, "1,2\n\x1a", "1|2"),
            (comments, "1,2 # a, b\n\"x # y\",3 # z\n", "1|2/x # y|3"),
            (blanks, " 1 2\t3 \n\"a b\"  \"\" c\n", "1|2|3/a b||c"),
            (blanks, "\"1\",2,\"A\" 3\n", "1,2,\"A\"|3"),
            (tabs, "1\t\n\t\n2\t3\n", "1|/|/2|3"),
            (escapes, r#""5\", 3\"",1,a\b"#, r#"5", 3"|1|a\b"#),
            (escapes, "\"a\\\\\",\"b\n\\\"\",\"\"\"\"\n1,2,3\n", "a\\|b\n\"|\"/1|2|3"),
        ] {
            for cut in 0..=text.len() {
                let found: Vec<String> =
                    records(syntax, text, cut).iter().map(|fields| fields.join("|")).collect();
                assert_eq!(found.join("/"), expected, "{text:?} cut at {cut}");
            }
        }
    }

    #[test]
    fn quotes_that_are_not_closed_are_known() {
        for (text, is_open) in
            [("1,\"a\n2,3\n", true), ("1,\"a", false), ("1,5\" pipe", false), ("1,\"a\nb\"", false)]
        {
            let mut splitter = Splitter::new(COMMA);
            splitter.step(text.as_bytes(), true, true);
            assert_eq!(splitter.is_open(), is_open, "{text:?}");
        }
    }
}
