//! Parquet and Arrow files: those of pyarrow and polars in `common/columnar`, and files of crate
//! parquet.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use catamaran::faer::Mat;
use catamaran::io::{
    ColumnKind, Columns, FileContent, FileFormat, Matrix, Missing, ReadOptions, TableFile,
    TableOptions, Words, read_file,
};
use catamaran::rows::RowBlocks;
use catamaran::{Error, Par};
use parquet::data_type::{
    ByteArray, ByteArrayType, DataType, DoubleType, FixedLenByteArray, FixedLenByteArrayType,
};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

/// The name of a column and its number in a row.
type Numbers = (&'static str, fn(f64) -> f64);

/// The numbers of `write.py`.
const KINDS: [Numbers; 15] = [
    ("f64", |i| i / 2.0 - 3.0),
    ("f32", |i| i / 4.0),
    ("f16", |i| i / 8.0),
    ("i8", |i| i - 25.0),
    ("u8", |i| i + 200.0),
    ("i16", |i| -300.0 * i),
    ("u16", |i| 60000.0 + i),
    ("i32", |i| -100000.0 * i),
    ("u32", |i| 4000000000.0 + i),
    ("i64", |i| -1e12 * i),
    ("u64", |i| 2_f64.powi(63) + 4096.0 * i),
    ("bool", |i| f64::from(i % 3.0 == 0.0)),
    ("d9", |i| 125.0 * i / 100.0),
    ("d18", |i| -i / 1000.0),
    ("d38", |i| format!("{}e-10", i as i128 * 10_i128.pow(20) + 1).parse().unwrap()),
];

/// The other columns of `write.py`.
const OTHERS: [&str; 8] = ["word", "large", "category", "day", "time", "list", "pair", "bytes"];

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/common/columnar").join(name)
}

fn options(table: TableOptions) -> ReadOptions<'static> {
    ReadOptions::new().table(table.par(Par::Threads(2)))
}

fn factors() -> ReadOptions<'static> {
    options(TableOptions::new().words(Words::Factor))
}

fn doubles(content: &FileContent) -> Mat<f64> {
    match &content.matrix {
        Matrix::F64(dense) => dense.as_ref().to_owned(),
        _ => panic!("another kind of matrix"),
    }
}

/// Reads a file as a whole, and checks that blocks of any height from any row on are the same.
fn content(path: &Path, options: &ReadOptions<'_>) -> FileContent {
    let content = read_file(path, options).unwrap();
    let (all, n) = (doubles(&content), content.matrix.ncols());
    let mut rows = TableFile::open(path, options).unwrap().unwrap();
    assert_eq!((rows.nrows(), rows.ncols()), all.shape());
    assert_eq!(Some(rows.reading()), content.reading.as_ref());
    let mut other = rows.try_clone().unwrap();
    for height in [1, 7, all.nrows()] {
        for first in (0..all.nrows()).step_by(height.max(1)) {
            let count = height.min(all.nrows() - first);
            let expected = all.get(first..first + count, ..);
            let mut block = Mat::<f64>::zeros(count, n);
            rows.read(first, block.as_mut()).unwrap();
            same(&block, &expected.to_owned());
            // Backwards, in the order of columns and in single precision.
            let first = all.nrows() - first - count;
            let mut block = Mat::<f32>::zeros(count, n);
            other.read(first, block.as_mut()).unwrap();
            for i in 0..count {
                for j in 0..n {
                    let (found, expected) = (block[(i, j)], all[(first + i, j)] as f32);
                    assert_eq!(found.to_bits(), expected.to_bits());
                }
            }
        }
    }
    content
}

fn same(found: &Mat<f64>, expected: &Mat<f64>) {
    assert_eq!(found.shape(), expected.shape());
    for j in 0..found.ncols() {
        for i in 0..found.nrows() {
            let (found, expected) = (found[(i, j)], expected[(i, j)]);
            let is_same = found == expected || found.is_nan() && expected.is_nan();
            assert!(is_same, "{found} where {expected} is in row {i}, column {j}");
        }
    }
}

fn levels(content: &FileContent, name: &str) -> Vec<String> {
    let columns = &content.reading.as_ref().unwrap().columns;
    match &columns.iter().find(|column| column.name == name).unwrap().kind {
        ColumnKind::Factor { levels } => levels.clone(),
        other => panic!("{other:?}"),
    }
}

fn refusal(path: &Path, options: &ReadOptions<'_>) -> String {
    let error = read_file(path, options).unwrap_err();
    if let Error::Io { path: named, .. } = &error {
        assert_eq!(named, path);
    }
    // The same as a whole and by blocks, once and again.
    if let Ok(Some(mut rows)) = TableFile::open(path, options) {
        let mut all = Mat::<f64>::zeros(rows.nrows(), rows.ncols());
        if let Err(by_blocks) = rows.read(0, all.as_mut()) {
            assert_eq!(by_blocks, error);
            assert_eq!(rows.read(0, all.as_mut()), Err(error.clone()));
        }
    }
    error.to_string()
}

#[test]
fn numbers_of_every_kind_are_read_and_what_is_left_out_is_said() {
    for name in ["kinds.parquet", "kinds.arrow"] {
        let content = content(&file(name), &options(TableOptions::new()));
        assert_eq!(content.names, KINDS.map(|(name, _)| name));
        let expected = Mat::from_fn(50, KINDS.len(), |i, j| KINDS[j].1(i as f64));
        same(&doubles(&content), &expected);
        assert_eq!(content.number(3), 3);
        let reading = content.reading.unwrap();
        assert_eq!(reading.left_out, OTHERS);
        let said = "8 other columns left out (word, large, category, day, time, list, pair, bytes)";
        assert_eq!(reading.to_string(), said);
    }
}

#[test]
fn integers_that_are_rounded_are_counted_and_durations_are_left_out() {
    for name in ["large.parquet", "large.arrow"] {
        let some = |list: &str, missing: Missing| {
            let found = options(TableOptions::new().missing(missing));
            content(&file(name), &found.columns(Columns::parse(list))).reading.unwrap()
        };
        let whole = options(TableOptions::new().missing(Missing::Nan));
        let all = content(&file(name), &whole).reading.unwrap();
        assert_eq!(all.left_out, ["took"], "{name}");
        let said = "1 other column left out (took), 4 integers beyond 2^53 rounded, the first in \
                    row 0 (counted from 0), column u64";
        assert_eq!(all.to_string(), said, "{name}");
        let id = some("id,x", Missing::Nan).rounded.unwrap();
        assert_eq!((id.count, &id.place[..]), (2, "row 2 (counted from 0), column id"), "{name}");
        // Only cells that are used count.
        assert_eq!(some("id,x", Missing::Drop).rounded.unwrap().count, 1, "{name}");
        let exact = some("small,x", Missing::Nan);
        assert!(exact.rounded.is_none() && exact.is_plain(), "{name}");
        let refused = refusal(&file(name), &whole.columns(Columns::parse("took")));
        assert!(refused.contains("column took has durations, not numbers"), "{name}: {refused}");
    }
}

#[test]
fn decimals_of_256_bits_are_read_if_they_have_at_most_38_digits() {
    for name in ["decimals.arrow", "decimals.parquet"] {
        let found = content(&file(name), &options(TableOptions::new().missing(Missing::Nan)));
        let expected = Mat::from_fn(50, 2, |i, j| match (i, j) {
            (3, 0) => f64::NAN,
            (_, 0) => (125.0 * i as f64 - 1000.0) / 100.0,
            // 2^53 + 1 is rounded.
            (4, _) => 2_f64.powi(53),
            _ => -(i as f64),
        });
        same(&doubles(&found), &expected);
        let reading = found.reading.unwrap();
        assert_eq!(reading.names(), ["narrow", "whole"]);
        assert_eq!(reading.left_out, ["wide"]);
        assert_eq!(reading.rounded.unwrap().count, 1, "{name}");
        let wide = options(TableOptions::new()).columns(Columns::parse("wide"));
        let refused = refusal(&file(name), &wide);
        assert!(refused.contains("column wide has decimals of more than 38 digits"), "{refused}");
    }
}

#[test]
fn a_page_that_its_checksum_does_not_fit_is_refused() {
    let whole = file("checked.parquet");
    let expected = Mat::from_fn(50, 1, |i, _| KINDS[0].1(i as f64));
    same(&doubles(&content(&whole, &ReadOptions::new())), &expected);
    let mut bytes = fs::read(whole).unwrap();
    let entry = KINDS[0].1(21.0).to_le_bytes();
    let at = bytes.windows(entry.len()).position(|window| window == entry).unwrap();
    bytes[at] ^= 1;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    fs::write(&path, bytes).unwrap();
    let refused = refusal(&path, &ReadOptions::new());
    assert!(refused.contains("column f64, row group 0"), "{refused}");
    assert!(refused.contains("CRC checksum"), "{refused}");
}

#[test]
fn columns_are_chosen_by_name_and_what_has_no_numbers_is_refused_by_name() {
    for name in ["kinds.parquet", "kinds.arrow"] {
        let some = |list: &str| options(TableOptions::new()).columns(Columns::parse(list));
        let chosen = content(&file(name), &some("bool,f64,2..4"));
        assert_eq!(chosen.names, ["bool", "f64", "f16", "i8"]);
        assert_eq!(doubles(&chosen)[(3, 1)], -1.5);
        for (column, what) in [
            ("day", "dates"),
            ("time", "times"),
            ("word", "words"),
            ("pair", "nested values"),
            ("bytes", "bytes"),
        ] {
            let refusal = refusal(&file(name), &some(column));
            let expected = format!("column {column} has {what}, not numbers");
            assert!(refusal.contains(&expected), "{refusal}");
        }
        assert!(refusal(&file(name), &some("list")).contains("column list has "));
        assert!(refusal(&file(name), &some("g64")).contains("no column g64"));
    }
}

#[test]
fn words_are_factors_with_the_levels_that_rows_have() {
    for name in ["kinds.parquet", "kinds.arrow"] {
        let options = factors().columns(Columns::parse("word,large,category"));
        let content = content(&file(name), &options);
        assert_eq!(levels(&content, "word"), ["w0", "w1", "w2"]);
        assert_eq!(levels(&content, "large").len(), 4);
        assert_eq!(levels(&content, "category"), ["no", "yes"], "no row has never");
        let expected = Mat::from_fn(50, 3, |i, j| (i % [3, 4, 2][j]) as f64);
        same(&doubles(&content), &expected);
    }
}

#[test]
fn files_of_polars_are_read() {
    for name in ["polars.parquet", "polars.arrow"] {
        let content = content(&file(name), &factors());
        assert_eq!(content.names, ["f64", "i32", "word", "long", "category"]);
        let expected = Mat::from_fn(50, 5, |i, j| match j {
            0 => KINDS[0].1(i as f64),
            1 => KINDS[7].1(i as f64),
            _ => (i % [3, 4, 3][j - 2]) as f64,
        });
        same(&doubles(&content), &expected);
    }
}

#[test]
fn the_index_of_a_pandas_frame_is_left_out() {
    for name in ["pandas.parquet", "pandas.arrow"] {
        let found = content(&file(name), &ReadOptions::new());
        same(&doubles(&found), &Mat::from_fn(50, 1, |i, _| i as f64 / 2.0));
        let reading = found.reading.unwrap();
        assert_eq!(reading.names(), ["x"]);
        assert_eq!(reading.to_string(), "index column left out");
        let all = content(&file(name), &options(TableOptions::new().index(false)));
        let entry = |i: usize, j: usize| if j == 0 { i as f64 / 2.0 } else { 7.0 * i as f64 };
        same(&doubles(&all), &Mat::from_fn(50, 2, entry));
        let key = content(&file(name), &ReadOptions::new().columns(Columns::parse("the key")));
        same(&doubles(&key), &Mat::from_fn(50, 1, |i, _| 7.0 * i as f64));
    }
}

#[test]
fn packed_and_encoded_pages_are_read() {
    let expected = Mat::from_fn(50, 3, |i, j| match j {
        0 => KINDS[0].1(i as f64),
        1 => KINDS[7].1(i as f64),
        _ => (i % 3) as f64,
    });
    for name in [
        "snappy.parquet",
        "gzip.parquet",
        "zstd.parquet",
        "lz4.parquet",
        "encodings.parquet",
        "lz4.feather",
        "zstd.feather",
    ] {
        same(&doubles(&content(&file(name), &factors())), &expected);
    }
    let refusal = refusal(&file("brotli.parquet"), &options(TableOptions::new()));
    assert!(refusal.contains("packed by BROTLI"), "{refusal}");
    assert!(refusal.contains("column f64, row group 0 (counted from 0)"), "{refusal}");
}

#[test]
fn nulls_are_missing_cells() {
    for name in ["missing.parquet", "missing.arrow"] {
        let with = |missing| options(TableOptions::new().words(Words::Factor).missing(missing));
        let refused = refusal(&file(name), &with(Missing::Error));
        assert!(refused.contains("column x, r"), "{refused}");
        assert!(refused.contains("a missing value in row 3 of it; option `missing`"), "{refused}");

        let found = content(&file(name), &with(Missing::Nan));
        assert_eq!(levels(&found, "word"), ["rare", "w0", "w1"]);
        let word = |i: usize| if i % 7 == 3 { 0.0 } else { (i % 2) as f64 + 1.0 };
        let expected = Mat::from_fn(50, 4, |i, j| match j {
            0 if i % 7 == 3 => f64::NAN,
            2 if i == 20 => f64::NAN,
            3 if i == 30 => f64::NAN,
            0 => i as f64,
            1 => -(i as f64),
            2 => word(i),
            _ => f64::from(i % 2 == 0),
        });
        same(&doubles(&found), &expected);

        let found = content(&file(name), &with(Missing::Drop));
        let kept: Vec<usize> = (0..50).filter(|&i| i % 7 != 3 && i != 20 && i != 30).collect();
        assert_eq!(levels(&found, "word"), ["w0", "w1"], "no row that is kept is rare");
        let fewer = Mat::from_fn(kept.len(), 4, |i, j| {
            expected[(kept[i], j)] - if j == 2 { 1.0 } else { 0.0 }
        });
        same(&doubles(&found), &fewer);
        let reading = found.reading.unwrap();
        assert_eq!(reading.dropped_rows as usize, 50 - kept.len());
        assert!(reading.to_string().contains("9 rows with missing cells left out"), "{reading}");

        // A cell that is missing in a column that is not used drops no row.
        let options = with(Missing::Drop).columns(Columns::parse("y"));
        assert_eq!(content(&file(name), &options).matrix.nrows(), 50);
    }
}

#[test]
fn nan_is_a_missing_cell_as_it_is_in_text() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let schema = "message m { required double x; }";
    write(&path, schema, WriterProperties::default(), |writer| {
        group::<DoubleType>(writer, &[0.0, 1.0]);
        group::<DoubleType>(writer, &[2.0, f64::NAN, 4.0]);
    });
    let with = |missing| options(TableOptions::new().missing(missing));
    let refused = refusal(&path, &with(Missing::Error));
    assert!(refused.contains("column x, row group 1 (counted from 0)"), "{refused}");
    assert!(refused.contains("a missing value in row 1 of it; option `missing`"), "{refused}");
    let found = content(&path, &with(Missing::Drop));
    same(&doubles(&found), &Mat::from_fn(4, 1, |i, _| [0.0, 1.0, 2.0, 4.0][i]));
    assert_eq!(found.reading.unwrap().dropped_rows, 1);
    assert!(doubles(&content(&path, &with(Missing::Nan)))[(3, 0)].is_nan());
}

#[test]
fn options_of_text_are_refused_and_others_are_not() {
    for (name, kind) in [("pandas.parquet", "Parquet"), ("pandas.arrow", "Arrow")] {
        let refused = refusal(&file(name), &options(TableOptions::new().header(true)));
        let why = format!("option `header` applies to text tables, and this file is {kind}");
        assert!(refused.ends_with(&why), "{refused}");
        assert!(read_file(&file(name), &options(TableOptions::new().index(false))).is_ok());
    }
}

#[test]
fn the_content_says_the_format() {
    let folder = tempfile::tempdir().unwrap();
    for (name, given) in [("kinds.parquet", "a.data"), ("kinds.arrow", "b")] {
        let path = folder.path().join(given);
        fs::copy(file(name), &path).unwrap();
        assert_eq!(read_file(&path, &ReadOptions::new()).unwrap().names.len(), KINDS.len());
    }
    let path = folder.path().join("a.csv");
    fs::copy(file("kinds.arrow"), &path).unwrap();
    let options = ReadOptions::new().format(FileFormat::Arrow);
    assert_eq!(read_file(&path, &options).unwrap().names.len(), KINDS.len());
    let path = folder.path().join("a.parquet");
    fs::write(&path, "x,y\n1,2\n").unwrap();
    assert!(refusal(&path, &ReadOptions::new()).contains("broken Parquet file"));
    let refusal = refusal(&file("version1.feather"), &ReadOptions::new());
    assert!(refusal.contains("version 1 of Feather"), "{refusal}");
}

/// Writes a Parquet file with the groups of rows that `groups` writes.
fn write(
    path: &Path,
    schema: &str,
    properties: WriterProperties,
    groups: impl FnOnce(&mut SerializedFileWriter<File>),
) {
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let file = File::create(path).unwrap();
    let mut writer = SerializedFileWriter::new(file, schema, Arc::new(properties)).unwrap();
    groups(&mut writer);
    writer.close().unwrap();
}

/// Writes a group with a column of these entries.
fn group<T: DataType>(writer: &mut SerializedFileWriter<File>, entries: &[T::T]) {
    let mut group = writer.next_row_group().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    column.typed::<T>().write_batch(entries, None, None).unwrap();
    column.close().unwrap();
    group.close().unwrap();
}

#[test]
fn groups_without_rows_and_files_without_groups_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let schema = "message m { required double x; }";
    write(&path, schema, WriterProperties::default(), |writer| {
        for entries in [&[][..], &[1.0, 2.0], &[], &[], &[3.0], &[]] {
            group::<DoubleType>(writer, entries);
        }
    });
    let found = content(&path, &options(TableOptions::new()));
    same(&doubles(&found), &Mat::from_fn(3, 1, |i, _| i as f64 + 1.0));
    write(&path, schema, WriterProperties::default(), |_| {});
    let found = content(&path, &options(TableOptions::new().missing(Missing::Drop)));
    assert_eq!((found.matrix.nrows(), found.matrix.ncols()), (0, 1));
}

#[test]
fn groups_may_be_larger_than_the_memory_of_a_file_but_not_pages() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let entries: Vec<f64> = (0..300_000).map(f64::from).collect();
    let pages = |bytes: usize| {
        WriterProperties::builder()
            .set_dictionary_enabled(false)
            .set_write_batch_size(1000)
            .set_data_page_size_limit(bytes)
            .build()
    };
    write(&path, "message m { required double x; }", pages(20_000), |writer| {
        group::<DoubleType>(writer, &entries);
    });
    let options = options(TableOptions::new()).max_memory(100_000);
    let mut rows = TableFile::open(&path, &options).unwrap().unwrap();
    let mut block = Mat::<f64>::zeros(100_000, 1);
    rows.read(200_000, block.as_mut()).unwrap();
    assert_eq!(block[(99_999, 0)], 299_999.0);
    let whole = read_file(&path, &options).unwrap_err().to_string();
    assert!(whole.contains("a larger max_memory allows it"), "{whole}");
    // Of a packed buffer.
    let options = options.max_memory(100);
    let mut rows = TableFile::open(&file("lz4.feather"), &options).unwrap().unwrap();
    let refused = RowBlocks::<f64>::read(&mut rows, 0, Mat::zeros(1, 2).as_mut()).unwrap_err();
    assert!(refused.to_string().contains("a larger max_memory allows it"), "{refused}");
}

#[test]
fn words_in_pages_without_a_dictionary_have_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let words: Vec<_> = (0..3000).map(|i| format!("word {:04}", i * 7 % 3000)).collect();
    let entries: Vec<ByteArray> = words.iter().map(|word| word.as_str().into()).collect();
    // A dictionary that is too large, so that later pages are plain.
    let properties = WriterProperties::builder()
        .set_dictionary_page_size_limit(1000)
        .set_write_batch_size(100)
        .build();
    let schema = "message m { required binary word (STRING); }";
    write(&path, schema, properties, |writer| group::<ByteArrayType>(writer, &entries));
    let found = content(&path, &factors());
    same(&doubles(&found), &Mat::from_fn(3000, 1, |i, _| (i * 7 % 3000) as f64));
    assert_eq!(levels(&found, "word")[77], "word 0077");
    let refused = refusal(&path, &factors().max_memory(100_000));
    assert!(refused.contains("words of more bytes than it may take: a larger"), "{refused}");
}

#[test]
fn a_file_that_changes_while_it_is_read_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    fs::copy(file("kinds.parquet"), &path).unwrap();
    let mut rows = TableFile::open(&path, &ReadOptions::new()).unwrap().unwrap();
    fs::copy(file("snappy.parquet"), &path).unwrap();
    let mut block = Mat::<f64>::zeros(50, KINDS.len());
    let refused = rows.read(0, block.as_mut()).unwrap_err().to_string();
    assert!(refused.contains("since it was opened"), "{refused}");
    assert!(rows.try_clone().is_err());
}

#[test]
fn decimals_are_read_up_to_38_digits_and_named_beyond() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let schema = "message m { required fixed_len_byte_array (17) wide (DECIMAL (40, 2)); \
                  required binary long (DECIMAL (38, 1)); }";
    write(&path, schema, WriterProperties::default(), |writer| {
        let mut group = writer.next_row_group().unwrap();
        let mut column = group.next_column().unwrap().unwrap();
        let wide = FixedLenByteArray::from(vec![0; 17]);
        column.typed::<FixedLenByteArrayType>().write_batch(&[wide], None, None).unwrap();
        column.close().unwrap();
        let mut column = group.next_column().unwrap().unwrap();
        let long = ByteArray::from([&[0xff_u8; 17][..], &[0xfb]].concat());
        column.typed::<ByteArrayType>().write_batch(&[long], None, None).unwrap();
        column.close().unwrap();
        group.close().unwrap();
    });
    let found = content(&path, &options(TableOptions::new()));
    assert_eq!(found.reading.as_ref().unwrap().left_out, ["wide"]);
    assert_eq!(doubles(&found)[(0, 0)], -0.5);
    let options = ReadOptions::new().columns(Columns::parse("wide"));
    let refused = refusal(&path, &options);
    assert!(refused.contains("column wide has decimals of more than 38 digits"), "{refused}");
}

#[test]
fn a_dictionary_is_as_long_as_its_header_says() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let schema = "message m { required double x; }";
    write(&path, schema, WriterProperties::default(), |writer| {
        group::<DoubleType>(writer, &[1.0, 2.0, 3.0]);
    });
    // The header of the dictionary within that of its page: field 1 is the number of entries, 3.
    let mut bytes = fs::read(&path).unwrap();
    let header = [0x4c, 0x15, 6, 0x15];
    let at = bytes.windows(4).position(|window| window == header).unwrap();
    bytes[at + 2] = 2 * 60;
    fs::write(&path, bytes).unwrap();
    let refused = refusal(&path, &ReadOptions::new());
    assert!(refused.contains("a dictionary with fewer entries than its header"), "{refused}");
}

/// Returns an Arrow file whose footer lists the first block of a field `count` times.
fn repeated(good: &[u8], field: usize, count: u32) -> Vec<u8> {
    let number = |bytes: &[u8], at: usize| u32::from_le_bytes(*bytes[at..].first_chunk().unwrap());
    let end = good.len() - 10;
    let start = end - number(good, end) as usize;
    let mut footer = good[start..end].to_vec();
    let table = number(&footer, 0) as usize;
    let places = table - number(&footer, table) as usize;
    let place = &footer[places + 4 + 2 * field..];
    let at = table + usize::from(u16::from_le_bytes(*place.first_chunk().unwrap()));
    let blocks = at + number(&footer, at) as usize + 4;
    let block = footer[blocks..blocks + 24].to_vec();
    let distance = (footer.len() - at) as u32;
    footer[at..at + 4].copy_from_slice(&distance.to_le_bytes());
    footer.extend(count.to_le_bytes());
    (0..count).for_each(|_| footer.extend_from_slice(&block));
    let size = footer.len() as u32;
    [&good[..start], &footer, &size.to_le_bytes(), b"ARROW1"].concat()
}

#[test]
fn arrow_files_that_contradict_themselves_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.arrow");
    let said = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        refusal(&path, &factors())
    };
    let good = fs::read(file("kinds.arrow")).unwrap();
    let (dictionaries, batches) = (2, 3);
    let refused = said(&repeated(&good, dictionaries, 2));
    assert!(refused.contains("a dictionary that replaces another one"), "{refused}");
    let refused = said(&repeated(&good, batches, 1000));
    assert!(refused.contains("its parts overlap"), "{refused}");

    let place = |bytes: &[u8], wanted: &[u8]| {
        bytes.windows(wanted.len()).position(|window| window == wanted).unwrap()
    };
    // The bits of missing cells of the first column: where they are, and how many bytes.
    let mut bytes = fs::read(file("missing.arrow")).unwrap();
    let at = place(&bytes, &[0_i64, 7].map(i64::to_le_bytes).concat());
    bytes[at + 8] = 0;
    let refused = said(&bytes);
    assert!(refused.contains("column x, record batch 0"), "{refused}");
    assert!(refused.contains("missing cells, but no bits that say which"), "{refused}");
    // The size of a packed buffer.
    let mut bytes = fs::read(file("lz4.feather")).unwrap();
    let at = place(&bytes, &160_i64.to_le_bytes());
    bytes[at] = 152;
    let refused = said(&bytes);
    assert!(refused.contains("does not unpack to the size that it says"), "{refused}");
}

#[test]
fn more_rows_than_a_file_of_this_size_can_have_are_refused_before_they_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.arrow");
    let options = options(TableOptions::new().missing(Missing::Nan));
    // A column of nulls takes no bytes, whatever the number of rows.
    let mut bytes = fs::read(file("nulls.arrow")).unwrap();
    fs::write(&path, &bytes).unwrap();
    let nulls = doubles(&read_file(&path, &options).unwrap());
    assert!(nulls.nrows() == 12345 && nulls.col(0).iter().all(|x| x.is_nan()));
    let places = 0..bytes.len() - 8;
    for at in places.filter(|&at| bytes[at..at + 8] == 12345_i64.to_le_bytes()).collect::<Vec<_>>()
    {
        bytes[at..at + 8].copy_from_slice(&(1_i64 << 60).to_le_bytes());
    }
    fs::write(&path, &bytes).unwrap();
    let refused = TableFile::open(&path, &options).unwrap_err().to_string();
    assert!(refused.contains("a.arrow: announces 1152921504606846976 rows"), "{refused}");
}

#[test]
fn a_group_that_changes_between_its_blocks_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    write(&path, "message m { required double x; }", WriterProperties::default(), |writer| {
        group::<DoubleType>(writer, &[1.5; 100_000]);
    });
    let mut rows = TableFile::open(&path, &ReadOptions::new()).unwrap().unwrap();
    let mut block = Mat::<f64>::zeros(50_000, 1);
    rows.read(0, block.as_mut()).unwrap();
    let bytes = [fs::read(&path).unwrap(), vec![0]].concat();
    fs::write(&path, bytes).unwrap();
    let refused = rows.read(50_000, block.as_mut()).unwrap_err().to_string();
    assert!(refused.contains("changed since it was opened"), "{refused}");
}

#[test]
fn damaged_files_give_errors_that_name_them() {
    let folder = tempfile::tempdir().unwrap();
    let missing = TableOptions::new().words(Words::Factor).missing(Missing::Nan).par(Par::Seq);
    let options = ReadOptions::new().table(missing).max_memory(1_000_000);
    // Crate parquet panics on some of these pages, which is caught.
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    for name in ["encodings.parquet", "zstd.parquet", "missing.arrow", "lz4.feather"] {
        let good = fs::read(file(name)).unwrap();
        let path = folder.path().join(name);
        for at in (0..good.len()).step_by(3) {
            for damaged in [0x00, 0xff, good[at] ^ 0x10] {
                let mut bytes = good.clone();
                bytes[at] = damaged;
                fs::write(&path, &bytes).unwrap();
                match read_file(&path, &options) {
                    Ok(_) | Err(Error::Argument { .. }) => {}
                    Err(Error::Io { path: named, .. }) => assert_eq!(named, path),
                    Err(other) => panic!("byte {at} of {name}: {other}"),
                }
            }
        }
        for len in (0..good.len()).step_by(50) {
            fs::write(&path, &good[..len]).unwrap();
            assert!(refusal(&path, &options).contains("broken"), "{len} bytes of {name}");
        }
    }
    std::panic::set_hook(hook);
}
