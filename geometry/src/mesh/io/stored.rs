//! Numbers and streams as binary files and XML files store them.

use std::io::Read;
use std::path::Path;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use flate2::bufread::{GzDecoder, ZlibDecoder};

use super::draft::{Checked, Fault, roomy};
use super::text::{number, words};
use catamaran::base::{Error, push, reserved};
use catamaran::io::{Source, unxz};

/// The type of stored numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F16,
    F32,
    F64,
}

impl Kind {
    /// Returns the size of a number of this type, in bytes.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 | Self::F16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// Returns the number in these bytes, of which there are [`Kind::size`]; integers beyond 2^53
    /// are rounded.
    #[inline(always)]
    pub fn number(self, bytes: &[u8], is_big: bool) -> f64 {
        // Copies of a known length are instructions, not calls.
        let bits = match (self.size(), is_big) {
            (1, _) => u64::from(first::<1>(bytes)[0]),
            (2, false) => u64::from(u16::from_le_bytes(first(bytes))),
            (2, true) => u64::from(u16::from_be_bytes(first(bytes))),
            (4, false) => u64::from(u32::from_le_bytes(first(bytes))),
            (4, true) => u64::from(u32::from_be_bytes(first(bytes))),
            (_, false) => u64::from_le_bytes(first(bytes)),
            (_, true) => u64::from_be_bytes(first(bytes)),
        };
        match self {
            Self::I8 => f64::from(bits as i8),
            Self::U8 => f64::from(bits as u8),
            Self::I16 => f64::from(bits as i16),
            Self::U16 => f64::from(bits as u16),
            Self::I32 => f64::from(bits as i32),
            Self::U32 => f64::from(bits as u32),
            Self::I64 => bits as i64 as f64,
            Self::U64 => bits as f64,
            Self::F16 => half(bits as u16),
            Self::F32 => f64::from(f32::from_bits(bits as u32)),
            Self::F64 => f64::from_bits(bits),
        }
    }

    /// Returns the numbers in these bytes; bytes after the last whole number are left out.
    pub fn numbers(self, bytes: &[u8], is_big: bool) -> Checked<Vec<f64>> {
        self.converted(bytes, is_big, |x| x)
    }

    /// Returns the numbers in these bytes, converted by `of`.
    fn converted<T>(self, bytes: &[u8], is_big: bool, of: impl Fn(f64) -> T) -> Checked<Vec<T>> {
        let mut values = reserved(bytes.len() / self.size())?;
        // A loop is compiled for each type and order.
        macro_rules! convert {
            ($($kind:ident $size:literal)*) => { match self { $(Self::$kind => {
                let parts = bytes.chunks_exact($size);
                match is_big {
                    true => values.extend(parts.map(|own| of(Self::$kind.number(own, true)))),
                    false => values.extend(parts.map(|own| of(Self::$kind.number(own, false)))),
                }
            })* } };
        }
        convert!(I8 1 U8 1 I16 2 U16 2 I32 4 U32 4 I64 8 U64 8 F16 2 F32 4 F64 8);
        Ok(values)
    }
}

/// Numbers of a file that are indices, lengths or codes: in 32 bits, and as the file has them.
pub(super) struct Indices<'a> {
    /// [`NO_INDEX`] in place of what is none of 32 bits.
    values: Vec<u32>,
    written: Written<'a>,
}

/// Numbers as a file has them.
enum Written<'a> {
    Numbers(Vec<f64>),
    /// Bytes of this type, and whether they are big endian.
    Bytes(&'a [u8], Kind, bool),
}

/// In place of a number that is negative, not whole, or too large for an index of 32 bits.
pub(super) const NO_INDEX: u32 = u32::MAX;

/// Returns a number as an index, or [`NO_INDEX`].
#[inline(always)]
pub(super) fn index(number: f64) -> u32 {
    let index = number as u32;
    if f64::from(index) == number { index } else { NO_INDEX }
}

impl<'a> Indices<'a> {
    /// Takes numbers as indices.
    pub fn of_numbers(numbers: Vec<f64>) -> Checked<Self> {
        let mut values = reserved(numbers.len())?;
        values.extend(numbers.iter().map(|&number| index(number)));
        Ok(Self { values, written: Written::Numbers(numbers) })
    }

    /// Takes the numbers in these bytes as indices.
    pub fn of_bytes(bytes: &'a [u8], kind: Kind, is_big: bool) -> Checked<Self> {
        let values = kind.converted(bytes, is_big, index)?;
        Ok(Self { values, written: Written::Bytes(bytes, kind, is_big) })
    }

    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Returns number `i` as the file has it.
    pub fn number(&self, i: usize) -> f64 {
        match &self.written {
            Written::Numbers(numbers) => numbers[i],
            Written::Bytes(bytes, kind, is_big) => kind.number(&bytes[kind.size() * i..], *is_big),
        }
    }

    /// Returns number `i` as an index or a count.
    #[inline]
    pub fn whole(&self, i: usize) -> Checked<usize> {
        match self.values[i] {
            NO_INDEX => whole(self.number(i)),
            value => Ok(value as usize),
        }
    }

    /// Returns number `i` as that of a vertex, where `base` vertices come before the one with
    /// number 0.
    #[inline]
    pub fn vertex(&self, i: usize, base: u32) -> Checked<u32> {
        match self.values[i].checked_add(base) {
            Some(vertex) if self.values[i] != NO_INDEX => Ok(vertex),
            _ => vertex(self.number(i), base as usize),
        }
    }

    /// Drops the first number, if there is one.
    pub fn drop_first(&mut self) {
        self.values.drain(..self.values.len().min(1));
        match &mut self.written {
            Written::Numbers(numbers) => drop(numbers.drain(..numbers.len().min(1))),
            Written::Bytes(bytes, kind, _) => *bytes = bytes.get(kind.size()..).unwrap_or(&[]),
        }
    }
}

/// Returns the first bytes, of which there are enough.
fn first<const N: usize>(bytes: &[u8]) -> [u8; N] {
    bytes.first_chunk().copied().unwrap_or([0; N])
}

/// Returns the number of half precision (IEEE 754, binary16) with these bits.
fn half(bits: u16) -> f64 {
    let fraction = f64::from(bits & 0x3ff) / 1024.0;
    let magnitude = match i32::from((bits >> 10) & 0x1f) {
        0 => fraction * 2f64.powi(-14),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        exponent => (1.0 + fraction) * 2f64.powi(exponent - 15),
    };
    if bits >> 15 == 1 { -magnitude } else { magnitude }
}

/// Returns the numbers of a text.
pub(super) fn text_numbers(text: &[u8]) -> Checked<Vec<f64>> {
    let mut values = roomy(text.len() / 2);
    for word in words(text) {
        push(&mut values, number(word)?)?;
    }
    Ok(values)
}

/// Returns a number as an index or a count.
pub(super) fn whole(number: f64) -> Checked<usize> {
    /// From here on, doubles skip integers.
    const END: f64 = 9_007_199_254_740_992.0;
    let index = number as u64;
    let is_whole = number < END && index as f64 == number;
    // Machines of 32 bits have fewer indices.
    let found = if is_whole { usize::try_from(index).ok() } else { None };
    found.ok_or_else(|| format!("{number} is not an index or a count").into())
}

/// Returns the number of a vertex, where `base` vertices come before the one with number 0.
pub(super) fn vertex(number: f64, base: usize) -> Checked<u32> {
    let moved = whole(number).ok().and_then(|v| u32::try_from(v.checked_add(base)?).ok());
    moved.ok_or_else(|| format!("vertex {number} does not exist").into())
}

/// Returns the bytes of a text in base64, which may have blanks in it, and in which streams with
/// their paddings may follow each other.
pub(super) fn from_base64(text: &[u8]) -> Checked<Vec<u8>> {
    let config =
        GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
    let engine = GeneralPurpose::new(&STANDARD, config);
    let compact: Vec<u8> = text.iter().copied().filter(|b| !b.is_ascii_whitespace()).collect();
    let mut bytes = Vec::new();
    for stream in compact.split(|&byte| byte == b'=').filter(|stream| !stream.is_empty()) {
        let decoded = engine.decode_vec(stream, &mut bytes);
        decoded.map_err(|e| Fault::from(format!("broken base64: {e}")))?;
    }
    Ok(bytes)
}

/// The memory that the unpacked parts of a file take, which is limited as that of the file.
pub(super) struct Budget<'s, 'a> {
    source: &'s Source<'a>,
    taken: usize,
}

impl<'s, 'a> Budget<'s, 'a> {
    pub fn new(source: &'s Source<'a>) -> Self {
        Self { source, taken: 0 }
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        self.source.path()
    }

    /// Takes more bytes, or returns an error that says how many the file would take.
    pub fn take(&mut self, bytes: usize) -> Checked<()> {
        self.taken = self.taken.saturating_add(bytes);
        Ok(self.source.check_memory::<u8>("what it unpacks to", self.taken)?)
    }

    /// Takes the memory of so many numbers.
    pub fn take_numbers(&mut self, count: usize) -> Checked<()> {
        self.take(count.saturating_mul(size_of::<f64>()))
    }

    /// Appends to `out` what a block of LZ4 unpacks to, which is `size` bytes.
    pub fn lz4(&mut self, packed: &[u8], size: usize, out: &mut Vec<u8>) -> Checked<()> {
        self.take(size)?;
        // A byte of a block unpacks to 255 at most: a wrong size takes no memory.
        if size / 255 > packed.len() {
            return Err(format!("{} bytes of LZ4 do not unpack to {size}", packed.len()).into());
        }
        let before = out.len();
        out.try_reserve(size).map_err(|_| Error::OutOfMemory { bytes: size })?;
        out.resize(before + size, 0);
        let unpacked = lz4_flex::block::decompress_into(packed, &mut out[before..]);
        match unpacked.map_err(|e| Fault::from(format!("can't be unpacked: {e}")))? {
            unpacked if unpacked == size => Ok(()),
            unpacked => Err(format!("unpacks to {unpacked} of {size} bytes").into()),
        }
    }

    /// Appends to `out` what a stream of xz unpacks to, which is `size` bytes.
    pub fn xz(&mut self, packed: &[u8], size: usize, out: &mut Vec<u8>) -> Checked<()> {
        self.exactly(unxz(packed), size, out)
    }

    /// Appends to `out` what a stream of zlib or gzip unpacks to, which is `size` bytes.
    pub fn inflate(&mut self, packed: &[u8], size: usize, out: &mut Vec<u8>) -> Checked<()> {
        match packed.starts_with(b"\x1f\x8b") {
            true => self.exactly(GzDecoder::new(packed), size, out),
            false => self.exactly(ZlibDecoder::new(packed), size, out),
        }
    }

    /// Appends to `out` what a stream unpacks to, which is `size` bytes.
    fn exactly(&mut self, stream: impl Read, size: usize, out: &mut Vec<u8>) -> Checked<()> {
        self.take(size)?;
        let before = out.len();
        // One byte more than announced, so that the content of a wrong size is not all unpacked.
        let read = stream.take((size as u64).saturating_add(1)).read_to_end(out);
        read.map_err(|e| Fault::from(format!("can't be unpacked: {e}")))?;
        match out.len() - before {
            unpacked if unpacked == size => Ok(()),
            unpacked if unpacked < size => {
                Err(format!("unpacks to {unpacked} of {size} bytes").into())
            }
            _ => Err(format!("unpacks to more than {size} bytes").into()),
        }
    }
}
