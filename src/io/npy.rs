//! NumPy arrays: entries converted chunk by chunk.

use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::Path;

use faer::{MatRef, c64};

use super::columns::Columns;
use super::matrix::{Dense, Matrix};
use super::npy_header::{self, Header};
use super::rounding::{RoundedIntegers, is_rounded, place};
use super::source::Source;
use crate::base::{Real, Result, reserved};

/// Bytes converted at a time; a multiple of every entry size.
const CHUNK: usize = 1 << 16;

macro_rules! entries {
    ($($name:ident = $code:literal $type:ty),* $(,)?) => {
        /// A type of entries that can be read.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub(super) enum Entry {
            $($name),*
        }

        impl Entry {
            /// The names of all types, without the order of their bytes.
            pub(super) const NAMES: &[&str] = &[$($code),*];

            /// Returns the entries of a type string such as `<f8`, and whether their most
            /// significant byte comes first.
            pub(super) fn of(descr: &str) -> Option<(Self, bool)> {
                let (order, code) = descr.split_at_checked(1)?;
                let big = match order {
                    "<" => false,
                    ">" => true,
                    "=" | "|" => cfg!(target_endian = "big"),
                    _ => return None,
                };
                let entry = match code {
                    $($code => Self::$name,)*
                    _ => return None,
                };
                Some((entry, big))
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
                    $(Self::$name => values.extend(bytes.as_chunks::<{ size_of::<$type>() }>().0.iter().map(|&entry| {
                        T::from_f64(<$type as Stored<{ size_of::<$type>() }>>::value(entry, big))
                    }))),*
                }
            }

            /// Calls `found` with the position of each entry in `bytes` that is an integer and no
            /// f64.
            pub(super) fn each_rounded(self, big: bool, bytes: &[u8], found: impl FnMut(usize)) {
                match self {
                    Self::I8 => each_rounded(bytes, found, |entry| {
                        let value =
                            if big { i64::from_be_bytes(entry) } else { i64::from_le_bytes(entry) };
                        value.unsigned_abs()
                    }),
                    Self::U8 => each_rounded(bytes, found, |entry| {
                        if big { u64::from_be_bytes(entry) } else { u64::from_le_bytes(entry) }
                    }),
                    _ => {}
                }
            }
        }
    };
}

/// Calls `found` with the position of each entry whose magnitude is no f64.
fn each_rounded(
    bytes: &[u8],
    mut found: impl FnMut(usize),
    magnitude: impl Fn([u8; size_of::<u64>()]) -> u64,
) {
    for (i, &entry) in bytes.as_chunks().0.iter().enumerate() {
        if is_rounded(magnitude(entry).into()) {
            found(i);
        }
    }
}

/// A type of entries of N bytes.
trait Stored<const N: usize> {
    /// Returns the value of an entry, rounded to double precision.
    fn value(bytes: [u8; N], big: bool) -> f64;
}

macro_rules! stored {
    ($($type:ty),*) => {
        $(impl Stored<{ size_of::<$type>() }> for $type {
            #[inline]
            fn value(bytes: [u8; size_of::<$type>()], big: bool) -> f64 {
                let value =
                    if big { Self::from_be_bytes(bytes) } else { Self::from_le_bytes(bytes) };
                value as f64
            }
        })*
    };
}

stored!(f32, f64, i8, i16, i32, i64, u8, u16, u32, u64);

/// Half precision of IEEE 754.
#[allow(dead_code)] // only its size counts
struct Half([u8; 2]);

impl Stored<2> for Half {
    fn value(bytes: [u8; 2], big: bool) -> f64 {
        half(if big { u16::from_be_bytes(bytes) } else { u16::from_le_bytes(bytes) })
    }
}

/// Returns the number in half precision with these bits.
pub(super) fn half(bits: u16) -> f64 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1f), f64::from(bits & 0x3ff));
    let size = match exponent {
        0 => fraction * 2_f64.powi(-24),
        0x1f if fraction == 0.0 => f64::INFINITY,
        0x1f => f64::NAN,
        _ => (1024.0 + fraction) * 2_f64.powi(exponent - 25),
    };
    if bits >> 15 == 1 { -size } else { size }
}

/// The long double of x86: 80 bits, in 16 bytes.
#[allow(dead_code)] // only its size counts
struct Extended([u8; 16]);

impl Stored<16> for Extended {
    fn value(mut bytes: [u8; 16], big: bool) -> f64 {
        if big {
            bytes.reverse();
        }
        let bits = u128::from_le_bytes(bytes);
        let (fraction, exponent) = (bits as u64, (bits >> 64) as i32 & 0x7fff);
        let size = match (exponent, fraction) {
            (0x7fff, fraction) if fraction << 1 == 0 => f64::INFINITY,
            (0x7fff, _) => f64::NAN,
            // In two steps: a power of two alone may be out of range.
            _ => {
                let power = (exponent - 16_383 - 63).clamp(-2000, 2000);
                fraction as f64 * 2_f64.powi(power / 2) * 2_f64.powi(power - power / 2)
            }
        };
        if bits >> 79 & 1 == 1 { -size } else { size }
    }
}

entries! {
    B1 = "b1" u8,
    F2 = "f2" Half,
    F4 = "f4" f32,
    F8 = "f8" f64,
    I1 = "i1" i8,
    I2 = "i2" i16,
    I4 = "i4" i32,
    I8 = "i8" i64,
    U1 = "u1" u8,
    U2 = "u2" u16,
    U4 = "u4" u32,
    U8 = "u8" u64,
    F16 = "f16" Extended,
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
        let header = npy_header::read(source).map_err(|e| source.io_error(e))?;
        Self::of(source, header)
    }

    fn of(source: &Source<'_>, header: Header) -> Result<Self> {
        let shape = match header.shape[..] {
            [rows] => (rows, 1),
            [rows, columns] => (rows, columns),
            ref other => {
                return Err(source.fail(format!(
                    "an array of {} dimensions, where a matrix has 2",
                    other.len()
                )));
            }
        };
        let (entry, big) = Entry::of(&header.descr).ok_or_else(|| {
            let names = Entry::NAMES.join(", ");
            source.fail(header.refusal(&format!("real numbers of a type that is read: {names}")))
        })?;
        let Header { by_columns, offset, .. } = header;
        Ok(Self { shape, row_major: !by_columns, entry, big, offset })
    }

    /// Returns the row and the column of an entry, given by its number in the file.
    pub(super) fn place(&self, entry: usize) -> (usize, usize) {
        let (nrows, ncols) = self.shape;
        match self.row_major {
            true => (entry / ncols, entry % ncols),
            false => (entry % nrows, entry / nrows),
        }
    }

    /// Returns the number of entries.
    pub(super) fn len(&self) -> usize {
        self.shape.0 * self.shape.1
    }

    /// Returns whether f32 holds the entries exactly; otherwise f64 is used.
    pub(super) fn is_single(&self) -> bool {
        self.entry == Entry::F4
    }
}

/// Returns the message for fewer entries than announced.
pub(super) fn truncated(len: usize) -> String {
    format!("truncated: fewer than the {len} entries its header announces")
}

/// Returns the message for data after the entries.
pub(super) fn trailing(len: usize) -> String {
    format!("data after the {len} entries its header announces")
}

/// Reads an array, and returns which integers in these columns were rounded.
pub(super) fn read(
    source: &mut Source<'_>,
    columns: &Columns,
) -> Result<(Matrix, Option<RoundedIntegers>)> {
    read_counting(source, columns, columns)
}

/// Reads an array, and returns which integers in the columns that are used were rounded.
pub(super) fn read_counting(
    source: &mut Source<'_>,
    columns: &Columns,
    used: &Columns,
) -> Result<(Matrix, Option<RoundedIntegers>)> {
    let mut header = npy_header::read(source).map_err(|e| source.io_error(e))?;
    let parts = parts(&header.descr);
    let is_complex = parts.is_some();
    if let Some(parts) = parts {
        header.descr = parts;
    }
    let layout = Layout::of(source, header)?;
    let (is_used, columns) = (used.kept(layout.shape.1)?, columns.range(layout.shape.1)?);
    if is_complex {
        let values = complex_values(source, &layout)?;
        let dense = Dense::new(values, layout.shape, layout.row_major, columns);
        return Ok((Matrix::Complex(dense), None));
    }
    let (len, mut rounded) = (layout.len(), None);
    let count = |entry: usize| {
        let (row, column) = layout.place(entry);
        if is_used(column) {
            RoundedIntegers::add(&mut rounded, 1, || place(row, column));
        }
    };
    let matrix = if layout.is_single() {
        let values = values(source, &layout, len, count)?;
        Matrix::F32(Dense::new(values, layout.shape, layout.row_major, columns))
    } else {
        let values = values(source, &layout, len, count)?;
        Matrix::F64(Dense::new(values, layout.shape, layout.row_major, columns))
    };
    Ok((matrix, rounded))
}

/// Returns the type of the real and imaginary parts of complex entries.
fn parts(descr: &str) -> Option<String> {
    let (order, code) = descr.split_at_checked(1)?;
    let part = match code {
        "c8" => "f4",
        "c16" => "f8",
        _ => return None,
    };
    Some(format!("{order}{part}"))
}

/// Returns whether the file at `path` is an array of complex numbers, which is not read by rows.
pub(super) fn is_complex(path: &Path) -> bool {
    let header = File::open(path).and_then(|file| npy_header::read(&mut BufReader::new(file)));
    header.is_ok_and(|header| parts(&header.descr).is_some())
}

/// Reads all entries of a complex array, whose layout is that of their parts.
fn complex_values(source: &mut Source<'_>, layout: &Layout) -> Result<Vec<c64>> {
    let what = format_args!("a matrix of the {} entries announced", layout.len());
    source.check_memory::<c64>(what, layout.len())?;
    let parts: Vec<f64> = values(source, layout, 2 * layout.len(), |_| {})?;
    let mut values = reserved(layout.len())?;
    values.extend(parts.as_chunks::<2>().0.iter().map(|&[re, im]| c64 { re, im }));
    Ok(values)
}

/// Reads `len` numbers, calls `rounded` with the number of each integer that is no f64, and checks
/// that nothing follows them.
fn values<T: Real>(
    source: &mut Source<'_>,
    layout: &Layout,
    len: usize,
    mut rounded: impl FnMut(usize),
) -> Result<Vec<T>> {
    let announced = layout.len();
    let what = format_args!("a matrix of the {announced} entries announced");
    source.check_memory::<T>(what, len)?;
    let mut values = reserved(len).map_err(|_| {
        source.fail(format!("its header announces {announced} entries, more than memory can hold"))
    })?;
    let mut chunk = vec![0; CHUNK];
    while values.len() < len {
        let bytes = (len - values.len()).saturating_mul(layout.entry.bytes()).min(CHUNK);
        let chunk = &mut chunk[..bytes];
        source.read_exact(chunk).map_err(|e| match e.kind() {
            io::ErrorKind::UnexpectedEof => source.fail(truncated(announced)),
            _ => source.io_error(e),
        })?;
        let first = values.len();
        layout.entry.each_rounded(layout.big, chunk, |i| rounded(first + i));
        layout.entry.decode(layout.big, chunk, &mut values);
    }
    match source.read(&mut chunk[..1]) {
        Ok(0) => Ok(values),
        Ok(_) => Err(source.fail(trailing(announced))),
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
    npy_header::write(sink, "i8", false, &[matrix.nrows(), matrix.ncols()])?;
    for i in 0..matrix.nrows() {
        for j in 0..matrix.ncols() {
            // The header announces the byte order of the machine.
            sink.write_all(&matrix[(i, j)].to_ne_bytes())?;
        }
    }
    Ok(())
}

pub(super) fn write_complex(sink: &mut dyn Write, matrix: MatRef<'_, c64>) -> io::Result<()> {
    npy_header::write(sink, "c16", false, &[matrix.nrows(), matrix.ncols()])?;
    for i in 0..matrix.nrows() {
        for j in 0..matrix.ncols() {
            // The header announces the byte order of the machine.
            sink.write_all(&matrix[(i, j)].re.to_ne_bytes())?;
            sink.write_all(&matrix[(i, j)].im.to_ne_bytes())?;
        }
    }
    Ok(())
}

/// Writes the header of an m x n matrix in C order and the precision of T.
pub(super) fn write_header<T: Real>(sink: &mut dyn Write, m: usize, n: usize) -> io::Result<()> {
    npy_header::write(sink, if T::NAME == f32::NAME { "f4" } else { "f8" }, false, &[m, n])
}

/// Appends the bytes of entries, in the byte order of the machine as their header announces.
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
