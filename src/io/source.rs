use std::fmt::{self, Display};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use memchr::memchr;

use super::limits::{LARGER_MAX_MEMORY, SourceOptions, check_memory, longest_line, memory_limit};
use super::packing::{Packing, TRUNCATED};
#[cfg(feature = "columnar")]
use super::zstd;
use super::{bz2, gzip, xz, zipped};
use crate::base::{Error, Progress, Result, reserved, room};

/// Bytes read from the disk at a time.
const BUFFER: usize = 1 << 20;

/// The smallest buffer.
const SMALLEST: u64 = 1 << 16;

const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// A file being read: unpacked, watched by a progress callback, and counting lines.
pub struct Source<'a> {
    path: PathBuf,
    reader: Box<dyn BufRead + 'a>,
    /// Lines taken by [`Source::next_line`] so far.
    line: usize,
    buffer: Vec<u8>,
    /// Bytes of memory that the file may take.
    memory: u64,
    /// Bytes of the file, if they are known.
    size: Option<u64>,
    packing: Packing,
}

impl<'a> Source<'a> {
    /// Opens a file that is packed as its content says, or else so.
    ///
    /// # Errors
    /// [`Error::Io`] where the file can't be opened or unpacked.
    pub fn open(path: &Path, packing: Packing, options: &SourceOptions<'a>) -> Result<Self> {
        Self::open_packed(path, |head| packing.or_of_content(head), options)
    }

    /// Opens a file, packed as `packing` concludes from the first bytes.
    #[doc(hidden)]
    pub fn open_packed(
        path: &Path,
        packing: impl FnOnce(&[u8]) -> Packing,
        options: &SourceOptions<'a>,
    ) -> Result<Self> {
        let progress = options.progress;
        let opened = || {
            let file = File::open(path)?;
            let about = file.metadata()?;
            if about.is_dir() {
                return Err(io::Error::other("is a directory"));
            }
            let size = about.len();
            let memory = memory_limit(size, options.max_memory);
            Ok(Watched { file, size, done: 0, memory, progress })
        };
        let watched = opened().map_err(|e| error_at(path, None, e))?;
        let memory = watched.memory;
        // A small file gets a small buffer; the size of a pipe is unknown.
        let buffer = BUFFER.min(watched.size.max(SMALLEST) as usize);
        let size = watched.size;
        let mut raw = BufReader::with_capacity(buffer, watched);
        let head = raw.fill_buf().map_err(|e| error_at(path, None, e))?;
        let packing = packing(head);
        packing.check(head).map_err(|e| error_at(path, None, e))?;
        let limited = |inner: Box<dyn Read + 'a>| -> Box<dyn BufRead + 'a> {
            Box::new(BufReader::with_capacity(buffer, Limited { inner, left: memory }))
        };
        let reader: Box<dyn BufRead + 'a> = match packing {
            Packing::None => Box::new(raw),
            Packing::Gzip => limited(Box::new(gzip::Unpacker::new(raw))),
            Packing::Xz => limited(Box::new(xz::Unpacker::new(raw))),
            Packing::Bzip2 => limited(Box::new(bz2::Unpacker::new(raw))),
            #[cfg(feature = "columnar")]
            Packing::Zstd => limited(Box::new(zstd::Unpacker::new(raw, memory))),
            // Refused above.
            #[cfg(not(feature = "columnar"))]
            Packing::Zstd => Box::new(raw),
            Packing::Zip => {
                let inner = zipped::Unpacker::open(path, raw);
                limited(Box::new(inner.map_err(|e| error_at(path, None, e))?))
            }
        };
        // The size of a pipe reads as 0.
        let size = (packing == Packing::None && size > 0).then_some(size);
        Ok(Self { path: path.into(), reader, line: 0, buffer: Vec::new(), memory, size, packing })
    }

    /// Creates a source of the bytes of a file that would be called `path`.
    #[doc(hidden)]
    pub fn of_bytes(path: &Path, bytes: &'a [u8]) -> Self {
        Self {
            path: path.into(),
            reader: Box::new(bytes),
            line: 0,
            buffer: Vec::new(),
            memory: memory_limit(bytes.len() as u64, None),
            size: Some(bytes.len() as u64),
            packing: Packing::None,
        }
    }

    /// Returns a source of the text of this file in another encoding, which may take as much memory
    /// as this file.
    #[doc(hidden)]
    pub fn rewritten<'b>(&self, text: &'b [u8]) -> Source<'b> {
        Source { memory: self.memory, packing: self.packing, ..Source::of_bytes(&self.path, text) }
    }

    /// Returns the path of the file.
    #[doc(hidden)]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the bytes of the file, where they are known.
    #[doc(hidden)]
    pub fn size(&self) -> Option<u64> {
        self.size
    }

    /// Returns the bytes of memory that the file may take.
    pub fn memory(&self) -> u64 {
        self.memory
    }

    /// Returns how the file is packed.
    pub fn packing(&self) -> Packing {
        self.packing
    }

    /// Returns up to `count` of the next bytes without consuming them.
    #[doc(hidden)]
    pub fn peek(&mut self, count: usize) -> Result<Vec<u8>> {
        let mut head = Vec::new();
        let read = (&mut self.reader).take(count as u64).read_to_end(&mut head);
        read.map_err(|e| self.io_error(e))?;
        let rest = std::mem::replace(&mut self.reader, Box::new(io::empty()));
        self.reader = Box::new(io::Cursor::new(head.clone()).chain(rest));
        Ok(head)
    }

    /// Returns all bytes that are left.
    #[doc(hidden)]
    pub fn read_all(&mut self) -> Result<Vec<u8>> {
        let is_empty = loop {
            match self.reader.fill_buf() {
                Ok(piece) => break piece.is_empty(),
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(self.io_error(e)),
            }
        };
        if is_empty {
            return Ok(Vec::new());
        }
        // A byte more than the file has, as its end shows in a read of nothing.
        let size = self.size.map_or(BUFFER as u64, |size| size.saturating_add(1));
        let mut bytes = reserved(usize::try_from(size.min(self.memory)).unwrap_or(usize::MAX))?;
        let mut len = 0;
        loop {
            if len == bytes.capacity() {
                room(&mut bytes, BUFFER)?;
            }
            // Room for a whole buffer: then bytes are read to their place, without a copy.
            let end = bytes.capacity().min(len + BUFFER);
            if bytes.len() < end {
                bytes.resize(end, 0);
            }
            match self.reader.read(&mut bytes[len..end]) {
                Ok(0) => break,
                Ok(count) => len += count,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(self.io_error(e)),
            }
            self.check_memory::<u8>("the file", len)?;
        }
        bytes.truncate(len);
        Ok(bytes)
    }

    /// Returns an error when `what`, which takes the memory of `len` values of T, exceeds the
    /// memory that this file may take.
    #[doc(hidden)]
    pub fn check_memory<T>(&self, what: impl Display, len: usize) -> Result<()> {
        let bytes = (len as u64).saturating_mul(size_of::<T>() as u64);
        check_memory(self.memory, what, bytes).map_err(|what| self.fail(what))
    }

    /// Returns the next line, without its end, or `None` at the end of the file.
    pub(super) fn next_line(&mut self) -> Result<Option<&str>> {
        if self.next_bytes()?.is_none() {
            return Ok(None);
        }
        if std::str::from_utf8(&self.buffer).is_err() {
            return Err(self.fail("not text (UTF-8)"));
        }
        Ok(Some(self.last_line()))
    }

    /// Returns the next line as bytes, without its end, or `None` at the end of the file.
    #[doc(hidden)]
    pub fn next_bytes(&mut self) -> Result<Option<&[u8]>> {
        self.buffer.clear();
        self.line += 1;
        let longest = longest_line(self.memory);
        let piece = match self.reader.fill_buf() {
            Ok(piece) => piece,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => &[],
            Err(e) => return Err(self.io_error(e)),
        };
        // Most lines are in what has been read.
        let end = memchr(b'\n', &piece[..piece.len().min(longest.saturating_sub(1))]);
        if let Some(end) = end {
            self.buffer.extend_from_slice(&piece[..end]);
            self.reader.consume(end + 1);
        } else {
            let mut reader = (&mut self.reader).take(longest as u64);
            match reader.read_until(b'\n', &mut self.buffer) {
                Ok(0) => return Ok(None),
                Ok(count) if count == longest => {
                    let what = format!("a line of {count} bytes or more: {LARGER_MAX_MEMORY}");
                    return Err(self.fail(what));
                }
                Ok(_) => {}
                Err(e) => return Err(self.io_error(e)),
            }
        }
        if self.line == 1 && self.buffer.starts_with(BYTE_ORDER_MARK) {
            self.buffer.drain(..BYTE_ORDER_MARK.len());
        }
        while self.buffer.last().is_some_and(|byte| matches!(byte, b'\n' | b'\r')) {
            self.buffer.pop();
        }
        Ok(Some(&self.buffer))
    }

    /// Returns the line that [`Source::next_line`] returned last.
    pub(super) fn last_line(&self) -> &str {
        std::str::from_utf8(&self.buffer).unwrap_or_default()
    }

    /// Returns the number of the last line, from 1.
    #[doc(hidden)]
    pub fn line(&self) -> usize {
        self.line
    }

    /// Returns an error at the last line.
    #[doc(hidden)]
    pub fn fail(&self, what: impl Into<String>) -> Error {
        error(&self.path, self.at(), what)
    }

    /// Returns an error at another line, or without a line.
    #[doc(hidden)]
    pub fn fail_at(&self, line: impl Into<Option<usize>>, what: impl Into<String>) -> Error {
        error(&self.path, line, what)
    }

    /// Returns the error of a failed read.
    #[doc(hidden)]
    pub fn io_error(&self, e: io::Error) -> Error {
        error_at(&self.path, self.at(), e)
    }

    /// Returns the last line for an error: none before the first, or in a file that is not text.
    fn at(&self) -> Option<usize> {
        (self.line > 0).then_some(self.line)
    }
}

impl SourceOptions<'_> {
    /// Returns an error when `what`, which a file announces and which takes so many bytes of
    /// memory, exceeds the memory that the file may take. For readers of other formats than those
    /// of this crate.
    ///
    /// ```
    /// use catamaran::io::SourceOptions;
    ///
    /// # let folder = tempfile::tempdir().unwrap();
    /// # let path = &folder.path().join("large.png");
    /// std::fs::write(path, "a header").unwrap();
    /// let options = SourceOptions::new();
    /// assert!(options.check_memory(path, "200 x 200 pixels", 120_000).is_ok());
    /// assert!(options.check_memory(path, "200000 x 200000 pixels", 120_000_000_000).is_err());
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Io`], also when the size of the file can't be read.
    pub fn check_memory(&self, path: &Path, what: impl Display, bytes: u64) -> Result<()> {
        let about = path.metadata().map_err(|e| error_at(path, None, e))?;
        check_memory(memory_limit(about.len(), self.max_memory), what, bytes)
            .map_err(|what| error(path, None, what))
    }
}

impl Read for Source<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        self.reader.read(out)
    }

    fn read_exact(&mut self, out: &mut [u8]) -> io::Result<()> {
        self.reader.read_exact(out)
    }
}

impl BufRead for Source<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.reader.fill_buf()
    }

    fn consume(&mut self, amount: usize) {
        self.reader.consume(amount);
    }
}

/// The unpacked bytes of a file, up to a limit.
struct Limited<R> {
    inner: R,
    left: u64,
}

impl<R: Read> Read for Limited<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(out)?;
        match self.left.checked_sub(count as u64) {
            Some(left) => self.left = left,
            None => {
                return Err(io::Error::other(format!(
                    "unpacks to more than this file may take: {LARGER_MAX_MEMORY}"
                )));
            }
        }
        Ok(count)
    }
}

/// Creates an [`Error::Io`].
pub(super) fn error(path: &Path, line: impl Into<Option<usize>>, what: impl Into<String>) -> Error {
    Error::Io { path: path.into(), line: line.into(), what: what.into(), cause: None }
}

/// Creates an [`Error::Io`] from the system's error, or [`Error::Cancelled`] if the error carries
/// that.
pub(super) fn error_at(path: &Path, line: Option<usize>, e: io::Error) -> Error {
    if e.get_ref().is_some_and(|inner| inner.is::<Stopped>()) {
        return Error::Cancelled;
    }
    let what = match e.kind() {
        io::ErrorKind::UnexpectedEof => TRUNCATED.into(),
        io::ErrorKind::NotFound => "no such file".into(),
        _ => e.to_string(),
    };
    Error::Io { path: path.into(), line, what, cause: Some(e.into()) }
}

/// The file itself; each read of a buffer reports progress.
struct Watched<'a> {
    file: File,
    size: u64,
    done: u64,
    /// Bytes that may be read, also where a reader keeps only some columns: a file of unknown
    /// length must end.
    memory: u64,
    progress: Progress<'a>,
}

impl Read for Watched<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(out)?;
        self.done += count as u64;
        if self.done > self.memory {
            return Err(io::Error::other(format!(
                "is larger than the memory that this file may take: {LARGER_MAX_MEMORY}"
            )));
        }
        let fraction = self.done as f64 / self.size.max(1) as f64;
        self.progress.report(fraction).map_err(|_| io::Error::other(Stopped))?;
        Ok(count)
    }
}

/// Carries a request to stop through the readers.
#[derive(Debug)]
struct Stopped;

impl Display for Stopped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("cancelled")
    }
}

impl std::error::Error for Stopped {}
