use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use flate2::bufread::MultiGzDecoder;

use crate::base::{Error, Flow, Progress, Result};

/// Bytes read from the disk at a time.
const BUFFER: usize = 1 << 20;

const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// A file being read: unpacked, watched by a progress callback, and counting lines.
pub(super) struct Source<'a> {
    path: PathBuf,
    reader: Box<dyn BufRead + 'a>,
    /// Lines taken by [`Source::next_line`] so far.
    line: usize,
    buffer: Vec<u8>,
}

impl<'a> Source<'a> {
    pub(super) fn open(path: &Path, gzipped: bool, progress: Option<Progress<'a>>) -> Result<Self> {
        let opened = || {
            let file = File::open(path)?;
            let about = file.metadata()?;
            if about.is_dir() {
                return Err(io::Error::other("is a directory"));
            }
            Ok(Watched { file, size: about.len(), done: 0, progress })
        };
        let watched = opened().map_err(|e| error_at(path, 0, &e))?;
        let raw = BufReader::with_capacity(BUFFER, watched);
        let reader: Box<dyn BufRead + 'a> = if gzipped {
            Box::new(BufReader::with_capacity(BUFFER, MultiGzDecoder::new(raw)))
        } else {
            Box::new(raw)
        };
        Ok(Self { path: path.into(), reader, line: 0, buffer: Vec::new() })
    }

    /// The next line, without its end, or `None` at the end of the file.
    pub(super) fn next_line(&mut self) -> Result<Option<&str>> {
        self.buffer.clear();
        self.line += 1;
        match self.reader.read_until(b'\n', &mut self.buffer) {
            Ok(0) => return Ok(None),
            Ok(_) => {}
            Err(e) => return Err(error_at(&self.path, self.line, &e)),
        }
        if self.line == 1 && self.buffer.starts_with(BYTE_ORDER_MARK) {
            self.buffer.drain(..BYTE_ORDER_MARK.len());
        }
        while self.buffer.last().is_some_and(|byte| matches!(byte, b'\n' | b'\r')) {
            self.buffer.pop();
        }
        if std::str::from_utf8(&self.buffer).is_err() {
            return Err(error(&self.path, self.line, "not text (UTF-8)"));
        }
        Ok(Some(self.last_line()))
    }

    /// The line that [`Source::next_line`] returned last.
    pub(super) fn last_line(&self) -> &str {
        std::str::from_utf8(&self.buffer).unwrap_or_default()
    }

    /// The number of the last line, from 1.
    pub(super) fn line(&self) -> usize {
        self.line
    }

    /// An error at the last line.
    pub(super) fn fail(&self, what: impl Into<String>) -> Error {
        error(&self.path, self.line, what)
    }

    /// What went wrong in reading bytes.
    pub(super) fn io_error(&self, e: &io::Error) -> Error {
        error_at(&self.path, self.line, e)
    }
}

impl Read for Source<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        self.reader.read(out)
    }
}

/// An [`Error::Io`].
pub(super) fn error(path: &Path, line: usize, what: impl Into<String>) -> Error {
    Error::Io { path: path.into(), line, what: what.into() }
}

/// An [`Error::Io`] out of the system's, or the request to stop that it carries.
pub(super) fn error_at(path: &Path, line: usize, e: &io::Error) -> Error {
    if e.get_ref().is_some_and(|inner| inner.is::<Stopped>()) {
        return Error::Cancelled;
    }
    match e.kind() {
        io::ErrorKind::UnexpectedEof => error(path, line, "truncated: the file ends too early"),
        io::ErrorKind::NotFound => error(path, line, "no such file"),
        _ => error(path, line, e.to_string()),
    }
}

/// The file itself; each read of a buffer is progress.
struct Watched<'a> {
    file: File,
    size: u64,
    done: u64,
    progress: Option<Progress<'a>>,
}

impl Read for Watched<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(out)?;
        self.done += count as u64;
        if let Some(progress) = self.progress {
            let fraction = (self.done as f64 / self.size.max(1) as f64).min(1.0);
            if progress(fraction) == Flow::Cancel {
                return Err(io::Error::other(Stopped));
            }
        }
        Ok(count)
    }
}

/// Carries a request to stop through the readers above.
#[derive(Debug)]
struct Stopped;

impl std::fmt::Display for Stopped {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("cancelled")
    }
}

impl std::error::Error for Stopped {}
