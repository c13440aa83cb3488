//! A position in a file that is read as a whole: words, lines and bytes.

use std::fmt::Display;

use super::draft::{Checked, Fault, roomy};
use super::stored::{Indices, Kind};
use super::text::{count, first_word, number};
use catamaran::base::{Error, push};
use catamaran::io::Source;

/// A position in the bytes of a file.
pub(super) struct Cursor<'a> {
    all: &'a [u8],
    at: usize,
    /// Where the part that was taken last begins, and whether it is binary.
    last: usize,
    is_binary: bool,
}

impl<'a> Cursor<'a> {
    pub fn new(all: &'a [u8]) -> Self {
        Self { all, at: 0, last: 0, is_binary: false }
    }

    /// Returns what is not taken yet.
    pub fn rest(&self) -> &'a [u8] {
        self.all.get(self.at..).unwrap_or_default()
    }

    /// Takes up to `count` bytes of text.
    pub fn skip(&mut self, count: usize) -> &'a [u8] {
        let rest = self.rest();
        let taken = &rest[..count.min(rest.len())];
        (self.last, self.is_binary) = (self.at, false);
        self.at += taken.len();
        taken
    }

    /// Takes the rest of the line, without its end; `None` at the end of the file.
    pub fn line(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest();
        if rest.is_empty() {
            return None;
        }
        let length = rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len());
        let line = self.skip(length + 1);
        let line = line.strip_suffix(b"\n").unwrap_or(line);
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }

    /// Takes lines up to the first that is not blank, and returns that one.
    pub fn full_line(&mut self) -> Option<&'a [u8]> {
        loop {
            let line = self.line()?.trim_ascii();
            if !line.is_empty() {
                return Some(line);
            }
        }
    }

    /// Takes the next word; an error at the end of the file names `what`.
    pub fn word(&mut self, what: impl Display) -> Checked<&'a [u8]> {
        let Some((blanks, length)) = first_word(self.rest()) else { return Err(truncated(what)) };
        self.skip(blanks);
        Ok(self.skip(length))
    }

    /// Takes a number written as a word.
    pub fn number(&mut self, what: impl Display) -> Checked<f64> {
        number(self.word(what)?)
    }

    /// Takes a count written as a word.
    pub fn count(&mut self, what: impl Display) -> Checked<usize> {
        count(self.word(what)?)
    }

    /// Takes `count` bytes; an error at the end of the file names `what`.
    pub fn bytes(&mut self, count: usize, what: impl Display) -> Checked<&'a [u8]> {
        let Some(taken) = self.rest().get(..count) else { return Err(truncated(what)) };
        (self.last, self.is_binary) = (self.at, true);
        self.at += count;
        Ok(taken)
    }

    /// Takes a number of this type.
    pub fn stored(&mut self, kind: Kind, is_big: bool, what: impl Display) -> Checked<f64> {
        Ok(kind.number(self.bytes(kind.size(), what)?, is_big))
    }

    /// Takes `count` numbers: words, or bytes in this type and order.
    pub fn numbers(
        &mut self,
        count: usize,
        stored: Option<(Kind, bool)>,
        what: &str,
    ) -> Checked<Vec<f64>> {
        if let Some((kind, is_big)) = stored {
            let bytes = self.bytes(count.saturating_mul(kind.size()), what)?;
            return kind.numbers(bytes, is_big);
        }
        let mut values = roomy(count);
        for i in 0..count {
            push(&mut values, self.number(format_args!("{what} ({i} of {count} numbers)"))?)?;
        }
        Ok(values)
    }

    /// Takes `count` indices stored in this type and order.
    pub fn indices(
        &mut self,
        count: usize,
        (kind, is_big): (Kind, bool),
        what: &str,
    ) -> Checked<Indices<'a>> {
        let bytes = self.bytes(count.saturating_mul(kind.size()), what)?;
        Indices::of_bytes(bytes, kind, is_big)
    }

    /// Returns the number of the line of the part that was taken last, from 1.
    pub fn line_number(&self) -> usize {
        1 + self.all[..self.last].iter().filter(|&&byte| byte == b'\n').count()
    }

    /// Returns the error of a fault in the part that was taken last: its line, or its byte.
    pub fn fail(&self, fault: Fault, source: &Source<'_>) -> Error {
        match fault {
            Fault::What(what) if self.is_binary => {
                source.fail_at(None, format!("at byte {}: {what}", self.last))
            }
            Fault::What(what) => source.fail_at(self.line_number(), what),
            Fault::Error(error) => error,
        }
    }
}

fn truncated(what: impl Display) -> Fault {
    format!("truncated: the file ends before {what}").into()
}
