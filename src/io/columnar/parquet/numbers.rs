//! The entries of a column as numbers.

use std::sync::Arc;

use parquet::basic::{Repetition, Type as Physical};
use parquet::column::reader::ColumnReaderImpl;
use parquet::data_type::{
    BoolType, ByteArrayType, DataType, DoubleType, FixedLenByteArrayType, FloatType, Int32Type,
    Int64Type,
};
use parquet::errors::ParquetError;
use parquet::schema::types::{ColumnDescPtr, ColumnDescriptor, Type};

use super::guard::guarded;
use super::pages::Pages;
use crate::io::columnar::decimal::{big_endian, decimal};
use crate::io::columnar::fault::Fault;
use crate::io::columnar::store::{Cells, ColumnReader, Integer};
use crate::io::columnar::words;
use crate::io::npy::half;

/// What the entries of a column are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Entry {
    Bool,
    I32,
    U32,
    I64,
    U64,
    F16,
    F32,
    F64,
    /// With this scale.
    Decimal(i32),
    Word,
}

/// Opens a column.
pub fn open(
    column: ColumnDescPtr,
    pages: Pages,
    entry: Entry,
) -> Result<Box<dyn ColumnReader>, Fault> {
    Ok(match (entry, column.physical_type()) {
        (Entry::Bool, _) => open_as::<BoolType>(column, pages, |&v| f64::from(u8::from(v))),
        (Entry::I32, _) => open_as::<Int32Type>(column, pages, |&v| f64::from(v)),
        (Entry::U32, _) => open_as::<Int32Type>(column, pages, |&v| f64::from(v.cast_unsigned())),
        (Entry::I64, _) => open_whole::<Int64Type, _>(column, pages, |&v| Some(v)),
        (Entry::U64, _) => open_whole::<Int64Type, _>(column, pages, |&v| Some(v.cast_unsigned())),
        (Entry::F32, _) => open_as::<FloatType>(column, pages, |&v| f64::from(v)),
        (Entry::F64, _) => open_as::<DoubleType>(column, pages, |&v| v),
        (Entry::F16, Physical::FIXED_LEN_BYTE_ARRAY) => {
            open_as::<FixedLenByteArrayType>(column, pages, |v| match *v.data() {
                [low, high] => half(u16::from_le_bytes([low, high])),
                _ => f64::NAN,
            })
        }
        (Entry::Decimal(scale), Physical::INT32) => {
            open_as::<Int32Type>(column, pages, move |&v| decimal(v.into(), scale))
        }
        (Entry::Decimal(0), Physical::INT64) => {
            open_whole::<Int64Type, _>(column, pages, |&v| Some(v))
        }
        (Entry::Decimal(0), Physical::FIXED_LEN_BYTE_ARRAY) => {
            open_whole::<FixedLenByteArrayType, _>(column, pages, |v| big_endian(v.data()))
        }
        (Entry::Decimal(0), Physical::BYTE_ARRAY) => {
            open_whole::<ByteArrayType, _>(column, pages, |v| big_endian(v.data()))
        }
        (Entry::Decimal(scale), Physical::INT64) => {
            open_as::<Int64Type>(column, pages, move |&v| decimal(v.into(), scale))
        }
        (Entry::Decimal(scale), Physical::FIXED_LEN_BYTE_ARRAY) => {
            open_as::<FixedLenByteArrayType>(column, pages, move |v| {
                big_endian(v.data()).map_or(f64::NAN, |v| decimal(v, scale))
            })
        }
        (Entry::Decimal(scale), Physical::BYTE_ARRAY) => {
            open_as::<ByteArrayType>(column, pages, move |v| {
                big_endian(v.data()).map_or(f64::NAN, |v| decimal(v, scale))
            })
        }
        (Entry::Word, _) => {
            let column = numbers_of(&column)?;
            open_as::<Int32Type>(column, pages, |&v| words::entry(v))
        }
        _ => return Err("entries of another size than their type has".into()),
    })
}

/// Returns the column of integers that a column of words becomes in [`Pages`].
fn numbers_of(column: &ColumnDescriptor) -> Result<ColumnDescPtr, Fault> {
    let optional = column.max_def_level() > 0;
    let of_column = Type::primitive_type_builder(column.name(), Physical::INT32)
        .with_repetition(if optional { Repetition::OPTIONAL } else { Repetition::REQUIRED })
        .build()
        .map_err(|e| e.to_string())?;
    let levels = column.max_def_level();
    let path = column.path().clone();
    Ok(Arc::new(ColumnDescriptor::new(Arc::new(of_column), levels, 0, path)))
}

/// A column with entries of type T.
struct Numbers<T: DataType, F> {
    reader: ColumnReaderImpl<T>,
    /// Adds the number of an entry.
    push: F,
    /// The level of an entry that is there.
    present: i16,
    entries: Vec<T::T>,
    levels: Vec<i16>,
}

/// Opens a column with entries of type T, of which `number` returns the numbers.
fn open_as<T: DataType>(
    column: ColumnDescPtr,
    pages: Pages,
    number: impl Fn(&T::T) -> f64 + Send + 'static,
) -> Box<dyn ColumnReader> {
    open_with::<T>(column, pages, move |entry, cells| cells.values.push(number(entry)))
}

/// Opens a column with entries of type T, of which `integer` returns the integers, or `None` for
/// one that is too large.
fn open_whole<T: DataType, I: Integer + 'static>(
    column: ColumnDescPtr,
    pages: Pages,
    integer: impl Fn(&T::T) -> Option<I> + Send + 'static,
) -> Box<dyn ColumnReader> {
    open_with::<T>(column, pages, move |entry, cells| match integer(entry) {
        Some(integer) => cells.push_integer(integer),
        None => cells.miss(),
    })
}

fn open_with<T: DataType>(
    column: ColumnDescPtr,
    pages: Pages,
    push: impl Fn(&T::T, &mut Cells) + Send + 'static,
) -> Box<dyn ColumnReader> {
    let present = column.max_def_level();
    let reader = ColumnReaderImpl::<T>::new(column, Box::new(pages));
    Box::new(Numbers { reader, push, present, entries: Vec::new(), levels: Vec::new() })
}

impl<T: DataType, F: Fn(&T::T, &mut Cells) + Send> ColumnReader for Numbers<T, F> {
    fn read(&mut self, rows: usize, cells: &mut Cells) -> Result<(), Fault> {
        let Self { reader, push, present, entries, levels } = self;
        let (push, present) = (&*push, *present);
        cells.values.reserve(rows);
        entries.clear();
        levels.clear();
        let (found, count, _) = guarded(|| {
            let found = reader.read_records(rows, Some(&mut *levels), None, &mut *entries);
            found.map_err(|e| match e {
                ParquetError::General(what) => what,
                other => other.to_string(),
            })
        })?;
        if found != rows {
            return Err(format!("it ends {} rows too early", rows.saturating_sub(found)));
        }
        if count == rows {
            entries.iter().for_each(|entry| push(entry, cells));
            return Ok(());
        }
        let mut entries = entries.iter();
        for &level in levels.iter() {
            match if level == present { entries.next() } else { None } {
                Some(entry) => push(entry, cells),
                None => cells.miss(),
            }
        }
        Ok(())
    }
}
