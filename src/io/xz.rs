//! `.xz` through crate lzma-rust2, which has no memory limit of its own.

use std::io::{self, BufRead, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};

use lzma_rust2::XzReader;

/// The largest dictionary that a file may need, in the encoding of LZMA2: 256 MiB. `xz -9` takes 64
/// MiB.
const LARGEST_DICTIONARY: u8 = 32;

/// The identifier of LZMA2 among filters.
const LZMA2: u64 = 0x21;

/// A file being unpacked.
pub(super) struct Unpacker<R: Read>(XzReader<R>);

impl<R: BufRead> Unpacker<R> {
    /// Creates an unpacker of a packed file at its start.
    pub(super) fn new(mut packed: R) -> io::Result<Self> {
        if dictionary(packed.fill_buf()?).is_some_and(|size| size > LARGEST_DICTIONARY) {
            return Err(io::Error::other("needs a dictionary of more than 256 MiB"));
        }
        Ok(Self(XzReader::new(packed, true)))
    }
}

impl<R: Read> Read for Unpacker<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        // The crate is safe code, which may panic on unexpected input.
        catch_unwind(AssertUnwindSafe(|| self.0.read(out)))
            .unwrap_or_else(|_| Err(io::Error::other("broken .xz file")))
    }
}

/// Returns the size of the dictionary of the first block, in the encoding of LZMA2, or `None` when
/// there is no such block.
fn dictionary(file: &[u8]) -> Option<u8> {
    // After the stream header of 12 bytes: size of the block header, flags, sizes if flagged,
    // filters.
    let mut rest = file.get(13..)?;
    let flags = take(&mut rest)?;
    for flag in [0x40, 0x80] {
        if flags & flag != 0 {
            number(&mut rest)?;
        }
    }
    for _ in 0..=flags & 3 {
        let filter = number(&mut rest)?;
        let size = usize::try_from(number(&mut rest)?).ok()?;
        let (properties, after) = rest.split_at_checked(size)?;
        if filter == LZMA2 {
            return properties.first().copied();
        }
        rest = after;
    }
    None
}

fn take(bytes: &mut &[u8]) -> Option<u8> {
    let (&first, rest) = bytes.split_first()?;
    *bytes = rest;
    Some(first)
}

/// Reads a number in groups of seven bits, lowest first.
fn number(bytes: &mut &[u8]) -> Option<u64> {
    let mut value = 0;
    for shift in (0..63).step_by(7) {
        let byte = take(bytes)?;
        value |= u64::from(byte & 0x7f) << shift;
        if byte & 0x80 == 0 {
            return Some(value);
        }
    }
    None
}
