//! NumPy arrays: header by crate npyz, entries converted chunk by chunk.

use std::io::{self, Read, Write};
use std::ops::Range;

use faer::MatRef;
use npyz::{AutoSerialize, DType, Endianness, NpyHeader, Order, TypeChar, WriterBuilder};

use super::matrix::{Dense, Matrix};
use super::source::Source;
use super::{checked_columns, reserved};
use crate::base::{Error, Real, Result};

/// Bytes converted at a time; a multiple of every entry size.
const CHUNK: usize = 1 << 16;

pub(super) fn read(source: &mut Source<'_>, columns: Option<&Range<usize>>) -> Result<Matrix> {
    let header = NpyHeader::from_reader(&mut *source).map_err(|e| match source.io_error(&e) {
        Error::Io { path, line, what } => {
            // Where the syntax is wrong is drawn on further lines.
            let what = what.split(":  -->").next().unwrap_or_default();
            Error::Io { path, line, what: format!("broken npy header: {what}") }
        }
        other => other,
    })?;
    let fits = |d: u64| usize::try_from(d).map_err(|_| source.fail("shape too large"));
    let shape = match *header.shape() {
        [rows] => (fits(rows)?, 1),
        [rows, columns] => (fits(rows)?, fits(columns)?),
        ref other => {
            return Err(source
                .fail(format!("an array of {} dimensions, where a matrix has 2", other.len())));
        }
    };
    let len = shape.0.checked_mul(shape.1).ok_or_else(|| source.fail("shape too large"))?;
    let columns = checked_columns(columns, shape.1)?;
    let row_major = header.order() == Order::C;

    let refuse = |name: String| source.fail(format!("entries of type {name} are not real numbers"));
    let DType::Plain(dtype) = header.dtype() else {
        return Err(refuse(header.dtype().descr()));
    };
    let big = dtype.endianness() == Endianness::Big;
    macro_rules! values {
        ($file:ty as $memory:ty) => {
            values(source, len, |bytes| {
                let bytes = bytes.try_into().expect("a chunk is one entry long");
                let value =
                    if big { <$file>::from_be_bytes(bytes) } else { <$file>::from_le_bytes(bytes) };
                value as $memory
            })?
        };
    }
    let double = match (dtype.type_char(), dtype.num_bytes()) {
        (TypeChar::Float, Some(4)) => {
            let single = values!(f32 as f32);
            return Ok(Matrix::F32(Dense::new(single, shape, row_major, columns)));
        }
        (TypeChar::Float, Some(8)) => values!(f64 as f64),
        (TypeChar::Int, Some(1)) => values!(i8 as f64),
        (TypeChar::Int, Some(2)) => values!(i16 as f64),
        (TypeChar::Int, Some(4)) => values!(i32 as f64),
        (TypeChar::Int, Some(8)) => values!(i64 as f64),
        (TypeChar::Uint, Some(1)) => values!(u8 as f64),
        (TypeChar::Uint, Some(2)) => values!(u16 as f64),
        (TypeChar::Uint, Some(4)) => values!(u32 as f64),
        (TypeChar::Uint, Some(8)) => values!(u64 as f64),
        _ => return Err(refuse(format!("'{dtype}'"))),
    };
    Ok(Matrix::F64(Dense::new(double, shape, row_major, columns)))
}

/// `len` entries of `N` bytes, and nothing after them.
fn values<const N: usize, T>(
    source: &mut Source<'_>,
    len: usize,
    convert: impl Fn([u8; N]) -> T,
) -> Result<Vec<T>> {
    let mut values = reserved(len).map_err(|_| {
        source.fail(format!("its header announces {len} entries, more than memory can hold"))
    })?;
    let mut chunk = vec![0; CHUNK];
    while values.len() < len {
        let bytes = (len - values.len()).saturating_mul(N).min(CHUNK);
        let chunk = &mut chunk[..bytes];
        source.read_exact(chunk).map_err(|e| match e.kind() {
            io::ErrorKind::UnexpectedEof => {
                source.fail(format!("truncated: fewer than the {len} entries its header announces"))
            }
            _ => source.io_error(&e),
        })?;
        values.extend(chunk.as_chunks().0.iter().map(|&entry| convert(entry)));
    }
    match source.read(&mut chunk[..1]) {
        Ok(0) => Ok(values),
        Ok(_) => Err(source.fail(format!("data after the {len} entries its header announces"))),
        Err(e) => Err(source.io_error(&e)),
    }
}

pub(super) fn write<T: Real>(sink: &mut dyn Write, matrix: MatRef<'_, T>) -> io::Result<()> {
    let single = T::NAME == f32::NAME;
    let dtype = if single { f32::default_dtype() } else { f64::default_dtype() };
    npyz::WriteOptions::new_header_only()
        .dtype(dtype)
        .shape(&[matrix.nrows() as u64, matrix.ncols() as u64])
        .writer(&mut *sink)
        .write_header_only()?;
    let mut row = Vec::with_capacity(matrix.ncols() * size_of::<T>());
    for i in 0..matrix.nrows() {
        row.clear();
        for j in 0..matrix.ncols() {
            let value = matrix[(i, j)].to_f64();
            // default_dtype is in the order of the machine; f32 survives f64 and back.
            if single {
                row.extend_from_slice(&(value as f32).to_ne_bytes());
            } else {
                row.extend_from_slice(&value.to_ne_bytes());
            }
        }
        sink.write_all(&row)?;
    }
    Ok(())
}
