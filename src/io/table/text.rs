//! The text of a table, a part of which is in memory.

use std::io::{self, Read};
use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::base::{Error, Result, room};
use crate::io::limits::LARGER_MAX_MEMORY;
use crate::io::source::{error, error_at};

/// Bytes of the smallest buffer.
const SMALLEST: usize = 1 << 16;

const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// A reader of text that keeps what was not taken yet.
pub(super) struct Text<R> {
    path: PathBuf,
    inner: R,
    buffer: Vec<u8>,
    /// The part of `buffer` that was read and not taken.
    held: Range<usize>,
    /// Bytes of the file that were taken.
    pub offset: u64,
    /// Lines that were taken.
    pub lines: usize,
    is_ended: bool,
    /// Most bytes of a record.
    longest: usize,
}

impl<R: Read> Text<R> {
    /// Creates a reader of `inner`, the file at `path` from byte `offset` and line `lines` on.
    pub fn new(path: &Path, inner: R, offset: u64, lines: usize, longest: usize) -> Self {
        Self {
            path: path.into(),
            inner,
            buffer: Vec::new(),
            held: 0..0,
            offset,
            lines,
            is_ended: false,
            longest,
        }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the text that was read and not taken.
    pub fn held(&self) -> &[u8] {
        &self.buffer[self.held.clone()]
    }

    /// Returns whether no text follows that which is held.
    pub fn is_ended(&self) -> bool {
        self.is_ended
    }

    /// Reads until `count` bytes are held or the file ends.
    pub fn hold(&mut self, count: usize) -> Result<()> {
        if self.held.start > 0 {
            self.buffer.copy_within(self.held.clone(), 0);
            self.held = 0..self.held.len();
        }
        while self.held.end < count && !self.is_ended {
            if self.held.end == self.buffer.len() {
                // A small file takes a small buffer.
                let len = (2 * self.buffer.len()).max(SMALLEST).min(count);
                room(&mut self.buffer, len - self.held.end)?;
                self.buffer.resize(len, 0);
            }
            let end = self.buffer.len().min(count);
            match self.inner.read(&mut self.buffer[self.held.end..end]) {
                Ok(0) => self.is_ended = true,
                Ok(read) => self.held.end += read,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(error_at(&self.path, Some(self.lines + 1), e)),
            }
        }
        if self.offset == 0 && self.held().starts_with(BYTE_ORDER_MARK) {
            self.held.start += BYTE_ORDER_MARK.len();
            self.offset = BYTE_ORDER_MARK.len() as u64;
        }
        Ok(())
    }

    /// Takes text from the start of what is held.
    pub fn take(&mut self, bytes: usize, lines: usize) {
        self.held.start += bytes;
        self.offset += bytes as u64;
        self.lines += lines;
    }

    /// Returns an error when a record, of which `held` bytes were read without its end, is longer
    /// than records may be.
    pub fn check_length(&self, held: usize) -> Result<()> {
        match held >= self.longest {
            true => Err(self
                .fail(0, format!("a line of {} bytes or more: {LARGER_MAX_MEMORY}", self.longest))),
            false => Ok(()),
        }
    }

    /// Returns an error at a line, counted from the first one that is held.
    pub fn fail(&self, line: usize, what: impl Into<String>) -> Error {
        error(&self.path, self.lines + line + 1, what)
    }
}
