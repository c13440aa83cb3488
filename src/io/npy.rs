//! NumPy arrays: header by crate npyz, entries converted chunk by chunk.

use std::io::{self, Read, Write};
use std::ops::Range;

use faer::MatRef;
use npyz::{AutoSerialize, DType, Endianness, NpyHeader, Order, TypeChar, TypeStr, WriterBuilder};

use super::columns::checked_columns;
use super::matrix::{Dense, Matrix};
use super::source::Source;
use crate::base::{Error, Real, Result, reserved};

/// Bytes converted at a time; a multiple of every entry size.
const CHUNK: usize = 1 << 16;

/// Most bytes of a header; its three entries take some hundred.
const LONGEST_HEADER: u64 = 1 << 20;

/// Deepest nesting of brackets in a header: a structured type has five.
const DEEPEST: usize = 8;

macro_rules! entries {
    ($($name:ident = $kind:ident $type:ty),* $(,)?) => {
        /// A type of entries that can be read.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub(super) enum Entry {
            $($name),*
        }

        impl Entry {
            fn of(dtype: &TypeStr) -> Option<Self> {
                $(
                    if dtype.type_char() == TypeChar::$kind
                        && dtype.num_bytes() == Some(size_of::<$type>())
                    {
                        return Some(Self::$name);
                    }
                )*
                None
            }

            /// Returns the bytes of one entry.
            pub(super) fn bytes(self) -> usize {
                match self {
                    $(Self::$name => size_of::<$type>()),*
                }
            }

            /// Returns whether an entry is stored as a T.
            pub(super) fn is<T: Real>(self) -> bool {
                match self {
                    Self::F4 => T::NAME == f32::NAME,
                    Self::F8 => T::NAME == f64::NAME,
                    _ => false,
                }
            }

            /// Appends the entries in `bytes` to `values`.
            pub(super) fn decode<T: Real>(self, big: bool, bytes: &[u8], values: &mut Vec<T>) {
                match self {
                    $(Self::$name => values.extend(bytes.as_chunks().0.iter().map(|&entry| {
                        let value =
                            if big { <$type>::from_be_bytes(entry) } else { <$type>::from_le_bytes(entry) };
                        T::from_f64(value as f64)
                    }))),*
                }
            }
        }
    };
}

entries! {
    F4 = Float f32,
    F8 = Float f64,
    I1 = Int i8,
    I2 = Int i16,
    I4 = Int i32,
    I8 = Int i64,
    U1 = Uint u8,
    U2 = Uint u16,
    U4 = Uint u32,
    U8 = Uint u64,
}

/// The contents of the header.
#[derive(Debug)]
pub(super) struct Layout {
    /// Rows and columns; their product fits a `usize`.
    pub(super) shape: (usize, usize),
    pub(super) row_major: bool,
    pub(super) entry: Entry,
    /// Whether the most significant byte comes first.
    pub(super) big: bool,
    /// Bytes before the first entry.
    pub(super) offset: u64,
}

impl Layout {
    /// Reads the header from the start of `source`.
    pub(super) fn read(source: &mut Source<'_>) -> Result<Self> {
        let head = head(source).map_err(|e| source.io_error(e))?;
        let header = NpyHeader::from_reader(&head[..]);
        let header = header.map_err(|e| match source.io_error(e) {
            Error::Io { path, line, what, cause } => {
                // The further lines of the message show where the syntax is wrong.
                let what = what.split(":  -->").next().unwrap_or_default();
                Error::Io { path, line, what: format!("broken npy header: {what}"), cause }
            }
            other => other,
        })?;
        let fits = |d: u64| usize::try_from(d).map_err(|_| source.fail("shape too large"));
        let shape = match *header.shape() {
            [rows] => (fits(rows)?, 1),
            [rows, columns] => (fits(rows)?, fits(columns)?),
            ref other => {
                return Err(source.fail(format!(
                    "an array of {} dimensions, where a matrix has 2",
                    other.len()
                )));
            }
        };
        shape.0.checked_mul(shape.1).ok_or_else(|| source.fail("shape too large"))?;
        let refuse =
            |name: String| source.fail(format!("entries of type {name} are not real numbers"));
        let DType::Plain(dtype) = header.dtype() else {
            return Err(refuse(header.dtype().descr()));
        };
        Ok(Self {
            shape,
            row_major: header.order() == Order::C,
            entry: Entry::of(&dtype).ok_or_else(|| refuse(format!("'{dtype}'")))?,
            big: dtype.endianness() == Endianness::Big,
            offset: head.len() as u64,
        })
    }

    /// Returns the number of entries.
    pub(super) fn len(&self) -> usize {
        self.shape.0 * self.shape.1
    }

    /// Returns whether f32 holds the entries exactly; otherwise f64 is used.
    pub(super) fn is_single(&self) -> bool {
        self.entry == Entry::F4
    }

    /// Returns the message for entries that end too early.
    pub(super) fn truncated(&self) -> String {
        format!("truncated: fewer than the {} entries its header announces", self.len())
    }

    /// Returns the message for data after the entries.
    pub(super) fn trailing(&self) -> String {
        format!("data after the {} entries its header announces", self.len())
    }
}

/// Returns the bytes before the entries, or as many as there are; of another kind of file only the
/// first ones. Three kinds of headers are errors, because crate npyz would allocate gigabytes, take
/// too long or panic: long ones, deep brackets, and more entries than can be counted.
pub(super) fn head(source: &mut impl Read) -> io::Result<Vec<u8>> {
    let broken = |what: String| Err(io::Error::new(io::ErrorKind::InvalidData, what));
    let mut head = Vec::new();
    source.by_ref().take(8).read_to_end(&mut head)?;
    if head.starts_with(b"\x93NUMPY") {
        let length_bytes = if head.get(6) == Some(&1) { 2 } else { 4 };
        source.by_ref().take(length_bytes).read_to_end(&mut head)?;
        let length = head.get(8..).unwrap_or_default();
        let length = length.iter().rev().fold(0, |length, &byte| (length << 8) | u64::from(byte));
        if length > LONGEST_HEADER {
            return broken(format!("broken npy header: it announces {length} bytes"));
        }
        source.by_ref().take(length).read_to_end(&mut head)?;
    }
    if depth(&head) > DEEPEST {
        return broken("broken npy header: too many brackets inside of each other".into());
    }
    if shape_overflows(&head) {
        return broken("shape too large".into());
    }
    Ok(head)
}

/// Returns the depth of nested brackets. The time of crate npyz doubles with each level.
fn depth(head: &[u8]) -> usize {
    let (mut open, mut most) = (0_usize, 0);
    for byte in head {
        match byte {
            b'(' | b'[' | b'{' => open += 1,
            b')' | b']' | b'}' => open = open.saturating_sub(1),
            _ => {}
        }
        most = most.max(open);
    }
    most
}

/// Returns whether the header announces more entries than can be counted.
fn shape_overflows(head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(head);
    let Some((_, rest)) = text.rsplit_once("shape") else { return false };
    let shape = rest.split(')').next().unwrap_or_default();
    let mut product = Some(1_u64);
    for digits in shape.split(|c: char| !c.is_ascii_digit()).filter(|part| !part.is_empty()) {
        product = product.and_then(|product| product.checked_mul(digits.parse().ok()?));
    }
    product.is_none()
}

pub(super) fn read(source: &mut Source<'_>, columns: Option<&Range<usize>>) -> Result<Matrix> {
    let layout = Layout::read(source)?;
    let columns = checked_columns(columns, layout.shape.1)?;
    Ok(if layout.is_single() {
        let values = values(source, &layout)?;
        Matrix::F32(Dense::new(values, layout.shape, layout.row_major, columns))
    } else {
        let values = values(source, &layout)?;
        Matrix::F64(Dense::new(values, layout.shape, layout.row_major, columns))
    })
}

/// Reads all entries, and checks that nothing follows them.
fn values<T: Real>(source: &mut Source<'_>, layout: &Layout) -> Result<Vec<T>> {
    let len = layout.len();
    source.check_memory::<T>(format_args!("a matrix of the {len} entries announced"), len)?;
    let mut values = reserved(len).map_err(|_| {
        source.fail(format!("its header announces {len} entries, more than memory can hold"))
    })?;
    let mut chunk = vec![0; CHUNK];
    while values.len() < len {
        let bytes = (len - values.len()).saturating_mul(layout.entry.bytes()).min(CHUNK);
        let chunk = &mut chunk[..bytes];
        source.read_exact(chunk).map_err(|e| match e.kind() {
            io::ErrorKind::UnexpectedEof => source.fail(layout.truncated()),
            _ => source.io_error(e),
        })?;
        layout.entry.decode(layout.big, chunk, &mut values);
    }
    match source.read(&mut chunk[..1]) {
        Ok(0) => Ok(values),
        Ok(_) => Err(source.fail(layout.trailing())),
        Err(e) => Err(source.io_error(e)),
    }
}

pub(super) fn write<T: Real>(sink: &mut dyn Write, matrix: MatRef<'_, T>) -> io::Result<()> {
    write_header::<T>(sink, matrix.nrows(), matrix.ncols())?;
    let mut row = Vec::with_capacity(matrix.ncols() * size_of::<T>());
    for i in 0..matrix.nrows() {
        row.clear();
        encode((0..matrix.ncols()).map(|j| matrix[(i, j)]), &mut row);
        sink.write_all(&row)?;
    }
    Ok(())
}

pub(super) fn write_integers(sink: &mut dyn Write, matrix: MatRef<'_, i64>) -> io::Result<()> {
    header(sink, i64::default_dtype(), matrix.nrows(), matrix.ncols())?;
    for i in 0..matrix.nrows() {
        for j in 0..matrix.ncols() {
            // `default_dtype` has the byte order of the machine.
            sink.write_all(&matrix[(i, j)].to_ne_bytes())?;
        }
    }
    Ok(())
}

/// Writes the header of an m x n matrix in C order and the precision of T.
pub(super) fn write_header<T: Real>(sink: &mut dyn Write, m: usize, n: usize) -> io::Result<()> {
    let single = T::NAME == f32::NAME;
    header(sink, if single { f32::default_dtype() } else { f64::default_dtype() }, m, n)
}

/// Writes the header of an m x n matrix in C order.
fn header(sink: &mut dyn Write, dtype: DType, m: usize, n: usize) -> io::Result<()> {
    npyz::WriteOptions::new_header_only()
        .dtype(dtype)
        .shape(&[m as u64, n as u64])
        .writer(sink)
        .write_header_only()
        .map(drop)
}

/// Appends the bytes of entries: `default_dtype` has the byte order of the machine.
pub(super) fn encode<T: Real>(values: impl Iterator<Item = T>, bytes: &mut Vec<u8>) {
    for value in values {
        let value = value.to_f64();
        // An f32 is converted to f64 and back without a change.
        if T::NAME == f32::NAME {
            bytes.extend_from_slice(&(value as f32).to_ne_bytes());
        } else {
            bytes.extend_from_slice(&value.to_ne_bytes());
        }
    }
}
