//! Parquet files, whose pages crate parquet finds and decodes.

mod guard;
mod numbers;
mod pages;

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{ConvertedType, LogicalType, Repetition, Type as Physical};
use parquet::file::metadata::{ColumnChunkMetaData, ParquetMetaData, ParquetMetaDataReader};
use parquet::file::statistics::Statistics;
use parquet::schema::types::ColumnDescriptor;

use self::guard::guarded;
use self::numbers::Entry;
use self::pages::Pages;
use super::fault::Fault;
use super::store::{ColumnReader, Contents, Field, Kind, Store};
use super::words::Words;
use super::{arrow, pandas};
use crate::base::Error;
use crate::io::source::{error, error_at};

/// The key of the metadata in which libraries of Arrow keep the types of columns.
const ARROW_SCHEMA: &str = "ARROW:schema";

/// An open Parquet file.
pub struct ParquetStore {
    path: PathBuf,
    metadata: ParquetMetaData,
    contents: Contents,
    /// The column of the file that a field is, and what its entries are.
    leaves: Vec<Option<(usize, Entry)>>,
    /// Bytes that a page may take.
    limit: u64,
}

impl ParquetStore {
    /// Reads the footer of a file of `len` bytes.
    pub fn open(path: &Path, len: u64, limit: u64) -> Result<Self, Error> {
        let file = File::open(path).map_err(|e| error_at(path, None, e))?;
        let fail = |what: String| error(path, None, format!("broken Parquet file: {what}"));
        let metadata = guarded(|| {
            ParquetMetaDataReader::new().parse_and_finish(&file).map_err(|e| e.to_string())
        })
        .map_err(fail)?;
        let schema = metadata.file_metadata().schema_descr();
        let mut fields = Vec::new();
        let mut leaves = Vec::new();
        for field in schema.root_schema().get_fields() {
            let kind = Kind::Other("nested values".into());
            fields.push(Field { name: field.name().to_owned(), kind });
            leaves.push(None);
        }
        for (leaf, column) in schema.columns().iter().enumerate() {
            let root = schema.get_column_root_idx(leaf);
            if !schema.get_column_root(leaf).is_primitive() || column.max_rep_level() > 0 {
                continue;
            }
            match entry(column) {
                Ok(entry) => {
                    let is_word = matches!(entry, Entry::Word);
                    fields[root].kind = if is_word { Kind::Words } else { Kind::Numbers };
                    leaves[root] = Some((leaf, entry));
                }
                Err(what) => fields[root].kind = Kind::Other(what.into()),
            }
        }
        let mut groups = Vec::with_capacity(metadata.num_row_groups());
        let mut all = 0_usize;
        let pairs = metadata.file_metadata().key_value_metadata();
        let value = |key: &str| {
            let pair = pairs.into_iter().flatten().find(|pair| pair.key == key);
            pair.and_then(|pair| pair.value.as_deref())
        };
        // Parquet has no type for durations, which are integers there.
        let of_arrow = value(ARROW_SCHEMA).map_or_else(Vec::new, arrow::durations);
        for (field, leaf) in fields.iter_mut().zip(&mut leaves) {
            if leaf.is_some() && of_arrow.contains(&field.name) {
                (field.kind, *leaf) = (Kind::Other(arrow::DURATIONS.into()), None);
            }
        }
        let index = value(pandas::KEY).map(pandas::index_columns).unwrap_or_default();
        for (number, group) in metadata.row_groups().iter().enumerate() {
            let rows = usize::try_from(group.num_rows()).ok();
            let sum = rows.and_then(|rows| all.checked_add(rows));
            let (Some(rows), Some(sum)) = (rows, sum) else {
                return Err(fail(format!("row group {number} has {} rows", group.num_rows())));
            };
            all = sum;
            groups.push(rows);
            for column in group.columns() {
                check_place(column, len).map_err(|what| {
                    let name = column.column_path().string();
                    fail(format!("column {name}, row group {number}: {what}"))
                })?;
            }
        }
        let contents = Contents { fields, index, groups, group_name: "row group" };
        Ok(Self { path: path.into(), metadata, contents, leaves, limit })
    }
}

impl Store for ParquetStore {
    fn contents(&self) -> &Contents {
        &self.contents
    }

    fn may_round(&self, field: usize) -> bool {
        const EXACT: i64 = 1 << f64::MANTISSA_DIGITS;
        let Some((leaf, entry)) = self.leaves[field] else { return false };
        // An unsigned integer beyond those with a sign is negative here.
        let least_exact = if entry == Entry::U64 { 0 } else { -EXACT };
        let is_exact = |bound: i64| (least_exact..=EXACT).contains(&bound);
        let is_known = |column: &ColumnChunkMetaData| match column.statistics() {
            Some(Statistics::Int64(found)) => match (found.min_opt(), found.max_opt()) {
                (Some(&least), Some(&most)) => is_exact(least) && is_exact(most),
                _ => false,
            },
            _ => false,
        };
        let is_long = matches!(entry, Entry::I64 | Entry::U64 | Entry::Decimal(0));
        is_long && !self.metadata.row_groups().iter().all(|group| is_known(group.column(leaf)))
    }

    fn column(
        &self,
        group: usize,
        field: usize,
        words: Option<&Arc<Words>>,
    ) -> Result<Box<dyn ColumnReader>, Fault> {
        let Some((leaf, entry)) = self.leaves[field] else {
            return Err("no numbers".into());
        };
        let file = File::open(&self.path).map_err(|e| e.to_string())?;
        let column = self.metadata.row_group(group).column(leaf);
        let rows = self.contents.groups[group];
        let pages = Pages::new(file, column, rows, self.limit, words.cloned())?;
        numbers::open(column.column_descr_ptr(), pages, entry)
    }
}

/// Checks that a column lies inside a file of `len` bytes.
fn check_place(column: &ColumnChunkMetaData, len: u64) -> Result<(), Fault> {
    if column.file_path().is_some() {
        return Err("its pages are in another file".into());
    }
    let start = column.dictionary_page_offset().unwrap_or(column.data_page_offset());
    let end = start.checked_add(column.compressed_size());
    match (u64::try_from(start), end.and_then(|end| u64::try_from(end).ok())) {
        (Ok(start), Some(end)) if start <= end && end <= len => Ok(()),
        _ => Err("its pages lie outside of the file".into()),
    }
}

/// Returns what the entries of a column are, or what they are instead of numbers and words.
fn entry(column: &ColumnDescriptor) -> Result<Entry, &'static str> {
    use Entry::{Bool, Decimal, F16, F32, F64, I32, I64, U32, U64, Word};
    if column.self_type().get_basic_info().repetition() == Repetition::REPEATED {
        return Err("lists");
    }
    let by_size = match column.physical_type() {
        Physical::BOOLEAN => Ok(Bool),
        Physical::INT32 => Ok(I32),
        Physical::INT64 => Ok(I64),
        Physical::FLOAT => Ok(F32),
        Physical::DOUBLE => Ok(F64),
        Physical::INT96 => Err("times"),
        Physical::BYTE_ARRAY | Physical::FIXED_LEN_BYTE_ARRAY => Err("bytes"),
    };
    let decimal = |scale: i32| match column.type_precision() {
        ..=38 => Ok(Decimal(scale)),
        _ => Err("decimals of more than 38 digits"),
    };
    let is_bytes = column.physical_type() == Physical::BYTE_ARRAY;
    let word = if is_bytes { Ok(Word) } else { Err("values of another type") };
    if let Some(logical) = column.logical_type_ref() {
        return match logical {
            LogicalType::String | LogicalType::Enum => word,
            LogicalType::Decimal(logical) => decimal(logical.scale),
            LogicalType::Integer(int) if int.is_signed => by_size,
            LogicalType::Integer(_) => Ok(if by_size == Ok(I32) { U32 } else { U64 }),
            LogicalType::Float16 if column.type_length() == 2 => Ok(F16),
            LogicalType::Date => Err("dates"),
            LogicalType::Time(_) | LogicalType::Timestamp(_) => Err("times"),
            LogicalType::Unknown => by_size,
            LogicalType::Uuid => Err("identifiers"),
            _ => Err("values of another type"),
        };
    }
    match column.converted_type() {
        ConvertedType::UTF8 | ConvertedType::ENUM => word,
        ConvertedType::DECIMAL => decimal(column.type_scale()),
        ConvertedType::UINT_8 | ConvertedType::UINT_16 | ConvertedType::UINT_32 => Ok(U32),
        ConvertedType::UINT_64 => Ok(U64),
        ConvertedType::DATE => Err("dates"),
        ConvertedType::TIME_MILLIS
        | ConvertedType::TIME_MICROS
        | ConvertedType::TIMESTAMP_MILLIS
        | ConvertedType::TIMESTAMP_MICROS
        | ConvertedType::INTERVAL => Err("times"),
        ConvertedType::JSON | ConvertedType::BSON => Err("values of another type"),
        _ => by_size,
    }
}
