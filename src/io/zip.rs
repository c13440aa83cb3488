//! Writes zip archives of files that are not packed (PKWARE, APPNOTE.TXT 6.3.10, sections 4.3 and
//! 4.5.3), with sizes of 64 bits where they are needed.

use std::io::{self, Seek, SeekFrom, Write};

use crc32fast::Hasher;

use super::Output;
use crate::base::Result;

/// Version 4.5, which has sizes of 64 bits.
const VERSION: u16 = 45;

/// The version, with permissions as in Unix.
const MADE_BY: u16 = (3 << 8) | VERSION;

/// A regular file that everyone reads and its owner writes, in the upper half.
const PERMISSIONS: u32 = 0o100_644 << 16;

/// The first day of 1980, at midnight: archives of the same arrays have the same bytes.
const TIME_AND_DATE: u32 = 0x21 << 16;

/// A name is in UTF-8.
const UTF8: u16 = 1 << 11;

/// The extra field of sizes of 64 bits.
const ZIP64: u16 = 1;

/// The part of a local header before the name, in bytes, and where its checksum is.
const LOCAL_HEADER: u64 = 30;
const CHECKSUM: u64 = 14;

/// An archive of which the last file may still be written.
pub(super) struct ZipWriter {
    output: Output,
    files: Vec<Entry>,
    /// Where the content of the last file begins, until it ends.
    content: Option<u64>,
    checksum: Hasher,
    /// Where the next byte goes.
    position: u64,
    has_failed: bool,
}

struct Entry {
    name: String,
    /// Where the local header is.
    offset: u64,
    size: u64,
    checksum: u32,
}

impl ZipWriter {
    /// Creates an archive without files.
    pub fn new(output: Output) -> Self {
        let checksum = Hasher::new();
        Self { output, files: Vec::new(), content: None, checksum, position: 0, has_failed: false }
    }

    /// Ends the file before and begins a file, whose content is written to `self`.
    pub fn begin(&mut self, name: String) -> io::Result<()> {
        self.end()?;
        if self.files.iter().any(|file| file.name == name) {
            return Err(io::Error::other(format!("`{name}` is there already")));
        }
        let Ok(length) = u16::try_from(name.len()) else {
            return Err(io::Error::other("a name has more than 65535 bytes"));
        };
        let mut header = Fields::default();
        header.u32(0x0403_4b50).u16(VERSION).u16(flags(&name)).u16(0).u32(TIME_AND_DATE);
        // Checksum and sizes follow at the end of the file.
        header.u32(0).u32(u32::MAX).u32(u32::MAX).u16(length).u16(20).bytes(name.as_bytes());
        header.u16(ZIP64).u16(16).u64(0).u64(0);
        self.files.push(Entry { name, offset: self.position, size: 0, checksum: 0 });
        self.put(&header.0)?;
        self.content = Some(self.position);
        self.checksum = Hasher::new();
        Ok(())
    }

    /// Ends the last file and the archive. The output is not yet committed.
    pub fn finish(mut self) -> Result<Output> {
        match self.end().and_then(|()| self.put_directory()) {
            Ok(()) if !self.has_failed => Ok(self.output),
            Ok(()) => Err(self.output.error(io::Error::other("an earlier write has failed"))),
            Err(e) => Err(self.output.error(e)),
        }
    }

    fn end(&mut self) -> io::Result<()> {
        let (Some(content), Some(file)) = (self.content.take(), self.files.last_mut()) else {
            return Ok(());
        };
        file.size = self.position - content;
        file.checksum = self.checksum.clone().finalize();
        let (size, checksum) = (file.size.to_le_bytes(), file.checksum.to_le_bytes());
        let at_checksum = file.offset + CHECKSUM;
        // Behind the name, and the identifier and the length of the extra field.
        let at_sizes = file.offset + LOCAL_HEADER + file.name.len() as u64 + 4;
        let mut patch = || {
            self.output.seek(SeekFrom::Start(at_checksum))?;
            self.output.write_all(&checksum)?;
            self.output.seek(SeekFrom::Start(at_sizes))?;
            self.output.write_all(&[size, size].concat())?;
            self.output.seek(SeekFrom::Start(self.position)).map(drop)
        };
        let patched = patch();
        self.has_failed |= patched.is_err();
        patched
    }

    /// Writes the list of all files.
    fn put_directory(&mut self) -> io::Result<()> {
        let start = self.position;
        let mut directory = Fields::default();
        for file in &self.files {
            let is_large = file.size >= u64::from(u32::MAX);
            let is_far = file.offset >= u64::from(u32::MAX);
            let mut extra = Fields::default();
            if is_large || is_far {
                extra.u16(ZIP64).u16(16 * u16::from(is_large) + 8 * u16::from(is_far));
            }
            if is_large {
                extra.u64(file.size).u64(file.size);
            }
            if is_far {
                extra.u64(file.offset);
            }
            directory.u32(0x0201_4b50).u16(MADE_BY).u16(VERSION).u16(flags(&file.name)).u16(0);
            directory.u32(TIME_AND_DATE).u32(file.checksum).least(file.size).least(file.size);
            // No comment, on the first disk, without internal attributes.
            directory.u16(file.name.len() as u16).u16(extra.0.len() as u16).u16(0).u16(0).u16(0);
            directory.u32(PERMISSIONS).least(file.offset);
            directory.bytes(file.name.as_bytes()).bytes(&extra.0);
        }
        let (count, size) = (self.files.len() as u64, directory.0.len() as u64);
        let end = start + size;
        if count >= u64::from(u16::MAX) || end >= u64::from(u32::MAX) {
            directory.u32(0x0606_4b50).u64(44).u16(MADE_BY).u16(VERSION).u32(0).u32(0);
            directory.u64(count).u64(count).u64(size).u64(start);
            directory.u32(0x0706_4b50).u32(0).u64(end).u32(1);
        }
        let count = count.min(u64::from(u16::MAX)) as u16;
        directory.u32(0x0605_4b50).u16(0).u16(0).u16(count).u16(count);
        directory.least(size).least(start).u16(0);
        self.put(&directory.0)
    }

    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        let written = self.output.write_all(bytes);
        self.has_failed |= written.is_err();
        self.position += bytes.len() as u64;
        written
    }
}

impl Write for ZipWriter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.output.write(bytes);
        match &written {
            Ok(count) => {
                self.checksum.update(&bytes[..*count]);
                self.position += *count as u64;
            }
            Err(e) => self.has_failed |= e.kind() != io::ErrorKind::Interrupted,
        }
        written
    }

    fn flush(&mut self) -> io::Result<()> {
        self.output.flush()
    }
}

fn flags(name: &str) -> u16 {
    if name.is_ascii() { 0 } else { UTF8 }
}

/// Numbers and bytes, one after the other, the lowest byte of a number first.
#[derive(Default)]
struct Fields(Vec<u8>);

impl Fields {
    fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.0.extend_from_slice(bytes);
        self
    }

    fn u16(&mut self, value: u16) -> &mut Self {
        self.bytes(&value.to_le_bytes())
    }

    fn u32(&mut self, value: u32) -> &mut Self {
        self.bytes(&value.to_le_bytes())
    }

    fn u64(&mut self, value: u64) -> &mut Self {
        self.bytes(&value.to_le_bytes())
    }

    /// Adds a number of 32 bits, all of them set where the value has more.
    fn least(&mut self, value: u64) -> &mut Self {
        self.u32(value.min(u64::from(u32::MAX)) as u32)
    }
}
