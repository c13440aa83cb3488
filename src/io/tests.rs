//! Tests of round trips, and of errors that name file and line.

use std::fs;
use std::io::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use faer::{Mat, c64, mat};
use tempfile::TempDir;

use super::*;
use crate::base::Error;
use crate::product::AtaOptions;
use crate::rows::{Accumulator, RowBlocks, RowBounds};

pub(super) struct Folder(TempDir);

impl Folder {
    pub(super) fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(super) fn file(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, content).expect("a temporary file");
        path
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).expect("the folder");
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect()
    }
}

pub(super) fn read_all(path: &Path) -> Result<Matrix> {
    read(path, &ReadOptions::default())
}

pub(super) fn doubles(matrix: &Matrix) -> Mat<f64> {
    let mut values = Mat::zeros(matrix.nrows(), matrix.ncols());
    match matrix {
        Matrix::F32(dense) => {
            let a = dense.as_ref();
            values = Mat::from_fn(a.nrows(), a.ncols(), |i, j| f64::from(a[(i, j)]));
        }
        Matrix::F64(dense) => values.copy_from(dense.as_ref()),
        Matrix::Complex(_) => panic!("complex numbers"),
        Matrix::Sparse(sparse) => SparseRows(sparse).read(0, values.as_mut()).expect("rows"),
    }
    values
}

/// Returns the `line` and `what` of the error that reading `content` gives, which names the file.
fn refusal(name: &str, content: impl AsRef<[u8]>) -> (Option<usize>, String) {
    let folder = Folder::new();
    let path = folder.file(name, content);
    match read_all(&path) {
        Err(Error::Io { path: named, line, what, .. }) => {
            assert_eq!(named, path);
            assert!(!what.contains('\n'), "{what}");
            (line, what)
        }
        other => panic!("expected an error of input, got {other:?}"),
    }
}

pub(super) fn npy(descr: &str, order: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let mut header =
        format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}");
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

fn awkward(m: usize, n: usize) -> Mat<f64> {
    Mat::from_fn(m, n, |i, j| (i as f64 - 2.5) / 3.0 * 10_f64.powi(7 * j as i32 - 20))
}

#[test]
fn what_is_written_is_read_back() {
    let folder = Folder::new();
    for (m, n) in [(1, 1), (5, 3), (3, 5), (127, 4)] {
        let a = awkward(m, n);
        let single = Mat::from_fn(m, n, |i, j| a[(i, j)] as f32);
        for name in ["a.npy", "a.mtx", "a.csv", "a.tsv", "a.txt", "a.npy.gz", "a.csv.gz"] {
            let path = folder.path(name);
            write(Output::create(&path, Overwrite::Replace).unwrap(), a.as_ref()).unwrap();
            assert_eq!(doubles(&read_all(&path).unwrap()), a, "{name} {m} x {n}");
            write(Output::create(&path, Overwrite::Replace).unwrap(), single.as_ref()).unwrap();
            let back = doubles(&read_all(&path).unwrap());
            assert!(
                (0..m).all(|i| (0..n).all(|j| back[(i, j)] as f32 == single[(i, j)])),
                "{name}"
            );
        }
    }
    assert_eq!(folder.names().len(), 7, "no temporary is left");
}

#[test]
fn integers_are_written_as_integers() {
    let folder = Folder::new();
    let a = Mat::from_fn(3, 2, |i, j| 3250 * i as i64 - j as i64);
    for (name, line) in [
        ("a.npy", "'<i8'"),
        ("a.mtx", "array integer general"),
        ("a.csv", "\n3250,3249\n"),
        ("a.tsv", "\n3250\t3249\n"),
        ("a.txt", "0 -1\n"),
    ] {
        let path = folder.path(name);
        write_integers(Output::create(&path, Overwrite::Replace).unwrap(), a.as_ref()).unwrap();
        let bytes = fs::read(&path).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        assert!(text.contains(line) && !text.contains(".0"), "{name}: {text}");
        let back = doubles(&read_all(&path).unwrap());
        assert!((0..3).all(|i| (0..2).all(|j| back[(i, j)] == a[(i, j)] as f64)), "{name}");
    }
}

#[test]
fn npy_of_zero_size_is_read() {
    let folder = Folder::new();
    let path = folder.file("a.npy", npy("<f8", "False", "(0, 3)", &[]));
    let a = read_all(&path).unwrap();
    assert_eq!((a.nrows(), a.ncols()), (0, 3));
}

#[test]
fn npy_types_and_orders_are_converted() {
    fn check<const N: usize>(descr: &str, to_bytes: impl Fn(i8) -> [u8; N]) {
        let folder = Folder::new();
        let data: Vec<u8> = [1, 2, 3, 4, 5, 6].into_iter().flat_map(to_bytes).collect();
        for (order, row_major) in [("False", true), ("True", false)] {
            let path = folder.file("a.npy", npy(descr, order, "(2, 3)", &data));
            let expected = Mat::from_fn(2, 3, |i, j| {
                (if row_major { 3 * i + j } else { i + 2 * j }) as f64 + 1.0
            });
            let a = read_all(&path).unwrap();
            assert_eq!(matches!(a, Matrix::F32(_)), descr.ends_with("f4"), "{descr}");
            assert_eq!(doubles(&a), expected, "{descr} {order}");
        }
    }
    check("|i1", |v| v.to_le_bytes());
    check("|u1", |v| (v as u8).to_le_bytes());
    check("<i1", |v| v.to_le_bytes());
    check("<i2", |v| i16::from(v).to_le_bytes());
    check(">u2", |v| (v as u16).to_be_bytes());
    check("<i4", |v| i32::from(v).to_le_bytes());
    check("<u4", |v| (v as u32).to_le_bytes());
    check(">i8", |v| i64::from(v).to_be_bytes());
    check("<u8", |v| (v as u64).to_le_bytes());
    check("<f4", |v| f32::from(v).to_le_bytes());
    check("<f8", |v| f64::from(v).to_le_bytes());
    check(">f8", |v| f64::from(v).to_be_bytes());
    check("=f8", |v| f64::from(v).to_ne_bytes());
    check("|i4", |v| i32::from(v).to_ne_bytes());
    // From 1 to 6: in half precision and as a long double of x86.
    let bits = |v: i8| f64::from(v).to_bits();
    let half = |v| (((bits(v) >> 52) - 1023 + 15) << 10 | bits(v) >> 42 & 0x3ff) as u16;
    check("<f2", |v| half(v).to_le_bytes());
    check(">f2", |v| half(v).to_be_bytes());
    let long = |v: i8| {
        let leading = (v as u64).leading_zeros();
        u128::from(16_383 + 63 - leading) << 64 | u128::from((v as u64) << leading)
    };
    check("<f16", |v| long(v).to_le_bytes());
    check(">f16", |v| long(v).to_be_bytes());
}

#[test]
fn npy_vector_is_a_column() {
    let folder = Folder::new();
    let path = folder.file("w.npy", npy("|u1", "False", "(3,)", &[7, 8, 9]));
    let w = doubles(&read_all(&path).unwrap());
    assert_eq!(w, Mat::from_fn(3, 1, |i, _| 7.0 + i as f64));
}

#[test]
fn broken_npy_is_refused() {
    let eight = 1.0_f64.to_le_bytes();
    let cases: [(Vec<u8>, &str); 13] = [
        (b"not numpy at all".to_vec(), "broken npy header: magic"),
        (npy("<f8", "False", "(1, 1)", &eight)[..40].to_vec(), "broken npy header: truncated"),
        (npy("<f8", "maybe", "(1, 1)", &eight), "broken npy header: True or False expected"),
        (npy("<f8", &"[".repeat(40), "(1, 1)", &eight), "broken npy header: True or False"),
        (npy("<f8", "False", "(1, 1)}\n{", &eight), "broken npy header: more than blanks"),
        (b"\x93NUMPY\x02\x00\xff\xff\xff\x7f{".to_vec(), "broken npy header: it announces"),
        (npy("<f8", "False", "(2, 1)", &eight), "truncated: fewer than the 2 entries"),
        (npy("<f8", "False", "(0, 1)", &eight), "data after the 0 entries"),
        (npy("<f8", "False", "(1, 1, 1)", &eight), "an array of 3 dimensions"),
        (npy("<c32", "False", "(1, 1)", &[0; 32]), "entries of type '<c32' are not real"),
        (npy("<U2", "False", "(1, 1)", &eight), "entries of type '<U2' are not real"),
        (npy("f8", "False", "(1, 1)", &eight), "entries of type 'f8' are not real"),
        (npy("<f08", "False", "(1, 1)", &eight), "entries of type '<f08' are not real"),
    ];
    for (content, expected) in cases {
        let (line, what) = refusal("a.npy", content);
        assert_eq!(line, None);
        assert!(what.starts_with(expected), "{what:?} instead of {expected:?}");
    }
}

#[test]
fn text_tables_of_every_separator_are_read() {
    let folder = Folder::new();
    for content in [
        "1,2.5,-3e2\n4,5,6\n",
        "1;2.5;-3e2\r\n4;5;6\r\n",
        "1\t2.5\t-3e2\n4\t5\t6",
        "  1   2.5 -3e2  \n4 5 6\n\n",
        "# by hand\nx, y, z\n1, 2.5, -3e2\n# halfway\n\n4, 5, 6\n",
        "\u{feff}\"x\",\"y\",\"z\"\n\"1\",2.5,-3e2\n4,5,6\n",
    ] {
        let path = folder.file("a.csv", content);
        let expected = [[1.0, 2.5, -300.0], [4.0, 5.0, 6.0]];
        let a = doubles(&read_all(&path).unwrap());
        assert_eq!(a, Mat::from_fn(2, 3, |i, j| expected[i][j]), "{content:?}");
    }
}

#[test]
fn broken_text_is_refused_with_its_line_and_the_option_that_decides() {
    let cases = [
        ("1,2\n# note\n\n3,4,5\n", 4, "3 fields in this row, 2 in that of line 1", "`separator`"),
        ("1,2\n3\n", 2, "1 field in this row, 2 in that of line 1", "`separator`"),
        ("1,2\n3,four\n", 2, "column 2: \"four\" is not a number", "`missing_words`"),
        ("1,2\n3,\n", 2, "column 2: nothing where a number should be", "`missing`"),
        (",,\n1,2,3\n", 1, "column 1: nothing where a number should be", "`missing`"),
        ("x,y\nm,kg\n1,2\n", 2, "column 1 (x): \"m\" is not a number, in the row", "`skip`"),
        ("By hand\nx,y\n1,2\n3,4\n", 1, "\"By hand\" has one name less than the rows", "`skip`"),
        ("\"10,000\",1\n\"5,500\",2\n", 1, "column 1: \"10,000\" is 10 with", "`thousands`"),
        ("x,y\n# none\n", 3, "the file ends without a row of numbers", ""),
        ("", 1, "the file ends without a row of numbers", ""),
    ];
    for (content, line, what, option) in cases {
        let (at, said) = refusal("a.csv", content);
        assert!(said.starts_with(what) && said.contains(option), "{content:?}: {said}");
        assert_eq!(at, Some(line), "{content:?}: {said}");
    }
}

#[test]
fn columns_are_selected_and_others_may_hold_text() {
    let folder = Folder::new();
    let options = ReadOptions::new().columns(1..3);
    let expected = Mat::from_fn(2, 2, |i, j| (3 * i + j + 2) as f64);
    let csv = folder.file("a.csv", "name,u,v\nann,2,3\nbob,5,6\n");
    assert_eq!(doubles(&read(&csv, &options).unwrap()), expected);
    let npy = folder.file("a.npy", npy("|u1", "False", "(2, 3)", &[1, 2, 3, 4, 5, 6]));
    assert_eq!(doubles(&read(&npy, &options).unwrap()), expected);
    let mtx = folder.file(
        "a.mtx",
        "%%MatrixMarket matrix coordinate integer general\n2 3 5\n1 1 1\n1 2 2\n1 3 3\n2 2 5\n2 3 6\n",
    );
    assert_eq!(doubles(&read(&mtx, &options).unwrap()), expected);
    let outside = ReadOptions::new().columns(1..4);
    for path in [csv, npy, mtx] {
        let error = read(&path, &outside).unwrap_err();
        assert!(matches!(error, Error::Argument { what: "columns", .. }), "{error}");
    }
}

#[test]
fn names_are_those_of_a_header_with_one_for_each_column() {
    let folder = Folder::new();
    let all = ReadOptions::new();
    let some = ReadOptions::new().columns(1..3);
    for (content, options, expected) in [
        ("# note\n\"a b\", c ,d\n1,2,3\n", &all, &["a b", "c", "d"][..]),
        ("name,u,v\nann,2,3\n", &some, &["u", "v"]),
        (",u,v\n0,2,3\n", &all, &["u", "v"]),
        ("u v\n2 3\n", &ReadOptions::new().columns(2..2), &[]),
        ("1,2,3\n", &all, &[]),
        ("u,v\n1,2,3\n", &all, &["u", "v"]),
        ("u,v\n1,2,3\n", &some, &["u", "v"]),
    ] {
        let path = folder.file("a.csv", content);
        let FileContent { matrix, names, .. } = read_file(&path, options).unwrap();
        assert_eq!(names, expected, "{content:?}");
        assert!(names.is_empty() || names.len() == matrix.ncols());
    }
    let npy = folder.file("a.npy", npy("|u1", "False", "(2, 3)", &[1, 2, 3, 4, 5, 6]));
    assert!(read_file(&npy, &all).unwrap().names.is_empty());
}

#[test]
fn matrix_market_of_every_kind_is_read() {
    let head = "%%MatrixMarket matrix";
    let cases = [
        ("coordinate real general\n% note\n2 2 3\n1 1 1.5\n2 1 2\n2 1 3\n", [1.5, 0.0, 5.0, 0.0]),
        ("coordinate integer symmetric\n2 2 2\n2 1 4\n2 2 -1\n", [0.0, 4.0, 4.0, -1.0]),
        ("coordinate real skew-symmetric\n2 2 1\n2 1 4\n", [0.0, -4.0, 4.0, 0.0]),
        ("coordinate pattern general\n2 2 1\n1 2\n", [0.0, 1.0, 0.0, 0.0]),
        ("coordinate unsigned-integer general\n2 2 1\n1 2 7\n", [0.0, 7.0, 0.0, 0.0]),
        ("coordinate real symmetric\n2 2 2\n1 2 4\n2 2 -1\n", [0.0, 4.0, 4.0, -1.0]),
        ("coordinate real skew-symmetric\n2 2 1\n1 2 4\n", [0.0, 4.0, -4.0, 0.0]),
        ("array real general\n2 2\n1\n2.0D+00\n3\n4d0\n", [1.0, 3.0, 2.0, 4.0]),
        ("array real general\n2 2\n1\n2\n3\n4\n", [1.0, 3.0, 2.0, 4.0]),
        ("array real symmetric\n2 2\n1\n2\n3\n", [1.0, 2.0, 2.0, 3.0]),
        ("array real skew-symmetric\n2 2\n2\n", [0.0, -2.0, 2.0, 0.0]),
    ];
    let folder = Folder::new();
    for (content, expected) in cases {
        let path = folder.file("a.mtx", format!("{head} {content}"));
        let a = read_all(&path).unwrap();
        assert_eq!(matches!(a, Matrix::Sparse(_)), content.starts_with("coordinate"));
        assert_eq!(doubles(&a), Mat::from_fn(2, 2, |i, j| expected[2 * i + j]), "{content}");
    }
}

#[test]
fn broken_matrix_market_is_refused_with_its_line() {
    let cases = [
        ("%%MatrixMarket matrix\n", 1, "broken MatrixMarket header"),
        ("", 1, "broken MatrixMarket header"),
        ("%%MatrixMarket matrix array words general\n1 1\n", 1, "entries of type \"words\""),
        ("%%MatrixMarket matrix array real general\n% a\n1 x\n", 3, "broken size line"),
        (
            "%%MatrixMarket matrix array real symmetric\n1 2\n",
            2,
            "a symmetric matrix must be square: 1 x 2",
        ),
        ("%%MatrixMarket matrix array real general\n2 1\n1\n", 4, "truncated: no entry for row 2"),
        ("%%MatrixMarket matrix array real general\n1 1\none\n", 3, "\"one\" is not a number"),
        ("%%MatrixMarket matrix array real general\n1 1\n1\n2\n", 4, "data after the 1 entries"),
        (
            "%%MatrixMarket matrix coordinate real general\n1 1 1\n1 2 5\n",
            3,
            "entry (1, 2) is outside",
        ),
        (
            "%%MatrixMarket matrix coordinate real general\n1 1 1\n1.0 1 5\n",
            3,
            "\"1.0\" is not a whole number",
        ),
        (
            "%%MatrixMarket matrix coordinate real general\n1 1 1\n1 1\n",
            3,
            "expected row column value",
        ),
        ("%%MatrixMarket matrix coordinate real general\n1 1 2\n1 1 3\n", 4, "truncated: 1 of 2"),
        (
            "%%MatrixMarket matrix coordinate real symmetric\n2 2 2\n1 2 5\n2 1 5\n",
            4,
            "entries in both triangles",
        ),
        (
            "%%MatrixMarket matrix coordinate real skew-symmetric\n2 2 1\n2 2 5\n",
            3,
            "an entry on the diagonal",
        ),
    ];
    for (content, line, expected) in cases {
        let (at, what) = refusal("a.mtx", content);
        assert!(what.starts_with(expected), "{what:?} instead of {expected:?}");
        assert_eq!(at, Some(line), "{content}");
    }
}

#[test]
fn options_of_text_are_refused_for_arrays_unless_another_file_has_text() {
    let folder = Folder::new();
    let npy = folder.path("a.npy");
    write(Output::create(&npy, Overwrite::Never).unwrap(), mat![[1.0, 2.0]].as_ref()).unwrap();
    let mtx = folder.file("a.mtx", "%%MatrixMarket matrix array real general\n1 1\n1\n");
    for (table, name) in [
        (TableOptions::new().separator(Separator::Char(';')), "separator"),
        (TableOptions::new().decimal(','), "decimal"),
        (TableOptions::new().thousands(','), "thousands"),
        (TableOptions::new().header(false), "header"),
        (TableOptions::new().skip(1), "skip"),
        (TableOptions::new().comment('%'), "comment"),
        (TableOptions::new().missing_words(vec!["-999".to_owned()]), "missing_words"),
        (TableOptions::new().encoding("latin1".to_owned()), "encoding"),
        (TableOptions::new().index(true), "index"),
    ] {
        let options = ReadOptions::new().table(table);
        let tables = if name == "index" { "tables" } else { "text tables" };
        let why = format!("option `{name}` applies to {tables}, and this file is an array");
        for path in [&npy, &mtx] {
            let said = read(path, &options).unwrap_err().to_string();
            assert!(said.ends_with(&format!(": {why}")), "{said}");
            assert!(read_one_of_several(path, &options).is_ok(), "{name}");
        }
        let all = |formats: &[Option<FileFormat>], weights: bool| {
            options.check_effects(&npy, formats, weights).is_ok()
        };
        assert!(all(&[None, Some(FileFormat::Table)], false) && !all(&[None], false), "{name}");
        assert_eq!(all(&[Some(FileFormat::Parquet)], false), name == "index");
        let of_rows = ["header", "skip", "index"].contains(&name);
        assert_eq!(all(&[None], true), !of_rows, "{name}");
    }
    let nan = ReadOptions::new().table(TableOptions::new().missing(Missing::Nan));
    assert!(read(&npy, &nan).is_ok());
}

#[test]
fn integers_of_arrays_and_matrix_market_that_are_rounded_are_counted() {
    let folder = Folder::new();
    let rounded = |path: &Path, columns: &str| {
        let all = if columns.is_empty() { Columns::ALL } else { Columns::parse(columns) };
        let content = read_file(path, &ReadOptions::new().columns(all)).unwrap();
        content.rounded.map(|rounded| (rounded.count, rounded.place))
    };
    let found = |count: u64, place: &str| Some((count, place.to_owned()));
    let large = 1_i64 << 53;
    // By rows: 1, 2^53; 2^53 + 1, -2^53 - 3; 0, -1.
    let values = [1, large, large + 1, -large - 3, 0, -1];
    let little: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    let big: Vec<u8> = values.iter().flat_map(|value| value.to_be_bytes()).collect();
    for (descr, bytes) in [("<i8", &little), (">i8", &big)] {
        let path = folder.file("a.npy", npy(descr, "False", "(3, 2)", bytes));
        assert_eq!(rounded(&path, ""), found(2, "row 1, column 0 (counted from 0)"));
        assert_eq!(rounded(&path, "1..2"), found(1, "row 1, column 1 (counted from 0)"));
        assert_eq!(rounded(&path, "1"), found(1, "row 1, column 1 (counted from 0)"));
        let path = folder.file("a.npy", npy(descr, "True", "(3, 2)", bytes));
        assert_eq!(rounded(&path, ""), found(2, "row 2, column 0 (counted from 0)"));
        // -1 without a sign is 2^64 - 1.
        let unsigned = descr.replace('i', "u");
        let path = folder.file("a.npy", npy(&unsigned, "False", "(3, 2)", bytes));
        assert_eq!(rounded(&path, "1").unwrap().0, 2);
    }
    let exact = folder.file("e.npy", npy("<i8", "False", "(2,)", &little[..16]));
    assert_eq!(rounded(&exact, ""), None);
    let head = "%%MatrixMarket matrix coordinate integer";
    let entries = "1 1 9007199254740993\n3 1 9007199254740992\n3 2 -9007199254740995\n";
    let path = folder.file("a.mtx", format!("{head} general\n3 3 3\n{entries}"));
    assert_eq!(rounded(&path, ""), found(2, "line 3"));
    assert_eq!(rounded(&path, "1..3"), found(1, "line 5"));
    assert_eq!(rounded(&path, "2"), None);
    // Column 2 has the mirror image of the third entry.
    let path = folder.file("s.mtx", format!("{head} symmetric\n3 3 3\n{entries}"));
    assert_eq!(rounded(&path, "2"), found(1, "line 5"));
    let array = "%%MatrixMarket matrix array real general\n2 1\n0.12345678901234567\n";
    let path = folder.file("b.mtx", format!("{array}9007199254740993\n"));
    assert_eq!(rounded(&path, ""), found(1, "line 4"));
    let path = folder.file("c.mtx", format!("{array}9007199254740993e1\n"));
    assert_eq!(rounded(&path, ""), None);
}

#[test]
fn an_error_of_the_system_is_the_source_and_no_line_is_named() {
    let path = Folder::new().path("absent.csv");
    let error = read_all(&path).unwrap_err();
    assert!(matches!(&error, Error::Io { path: named, line: None, .. } if *named == path));
    let cause = std::error::Error::source(&error).unwrap();
    let cause: &std::io::Error = cause.downcast_ref().unwrap();
    assert_eq!(cause.kind(), std::io::ErrorKind::NotFound);
    assert_eq!(error.clone(), error);
}

#[test]
fn claims_beyond_all_memory_are_an_error() {
    let folder = Folder::new();
    let path =
        folder.file("a.mtx", "%%MatrixMarket matrix array real general\n9999999 999999999\n1\n");
    let unlimited = ReadOptions::new().max_memory(u64::MAX);
    assert!(matches!(read(&path, &unlimited), Err(Error::OutOfMemory { .. })));
    let path = folder.file("a.npy", npy("<f8", "False", "(9999999, 999999999)", &[]));
    let Err(Error::Io { what, .. }) = read(&path, &unlimited) else { panic!("no error") };
    assert!(what.contains("announces 9999998990000001 entries"), "{what}");
}

#[test]
fn matrices_without_entries_are_refused_when_no_loop_could_visit_them() {
    let content =
        |kind: &str, sizes: &str| format!("%%MatrixMarket matrix {kind} real general\n{sizes}\n");
    for (kind, sizes, shape) in [
        ("array", "9223372036854775808 0", "(9223372036854775808, 0)"),
        ("array", "0 18446744073709551615", "(0, 18446744073709551615)"),
        ("coordinate", "9223372036854775808 0 0", "(9223372036854775808,)"),
        ("coordinate", "0 18446744073709551615 0", "(18446744073709551615,)"),
    ] {
        let (line, what) = refusal("a.mtx", content(kind, sizes));
        assert_eq!((line, what), (Some(2), format!("shape too large: {shape}")));
    }
    let (_, what) = refusal("a.mtx", content("coordinate", "4000000000 0 0"));
    assert!(what.contains("would take 29.80 GiB of memory"), "{what}");
    let (_, what) = refusal("a.npy", npy("<f8", "False", "(0, 9223372036854775808)", &[]));
    assert_eq!(what, "shape too large: (0, 9223372036854775808)");
    // Rows of nothing are there without a loop.
    let folder = Folder::new();
    let path = folder.file("a.mtx", content("array", "4000000000 0"));
    let Matrix::F64(tall) = read_all(&path).unwrap() else { panic!("not dense") };
    assert_eq!(tall.as_ref().shape(), (4_000_000_000, 0));
}

#[test]
fn small_files_may_take_a_gibibyte_and_more_if_they_are_told() {
    let folder = Folder::new();
    let coordinate = "%%MatrixMarket matrix coordinate real general\n";
    let array = "%%MatrixMarket matrix array real general\n";
    let files = [
        ("a.mtx", format!("{coordinate}1500000000 3 1\n1 1 1\n").into_bytes()),
        ("b.mtx", format!("{array}99999 99999\n1\n").into_bytes()),
        ("c.npy", npy("<f8", "False", "(99999, 99999)", &[])),
    ];
    for (name, content) in files {
        let path = folder.file(name, content);
        let said = read_all(&path).unwrap_err().to_string();
        assert!(said.contains(name) && said.contains("this file may take 1.00 GiB"), "{said}");
    }
    // A matrix of 1000 x 2 entries takes 16,000 bytes.
    let path = folder.file("d.csv", "1,2\n".repeat(1000));
    let read = |bytes| read(&path, &ReadOptions::new().max_memory(bytes));
    assert!(read(16_000).is_ok());
    let said = read(15_999).unwrap_err().to_string();
    assert!(said.contains("a larger max_memory allows it"), "{said}");
}

#[test]
fn the_head_of_an_accumulator_tells_its_rows_and_labels() {
    let folder = Folder::new();
    let path = folder.path("sums");
    let mut sum = Accumulator::<f32>::new(2, false).unwrap();
    sum.add_block(mat![[1.0_f32, 2.0], [3.0, 4.0]], None, &AtaOptions::new()).unwrap();
    let labels = vec![("rows".to_owned(), "0..9".to_owned())];
    sum.set_labels(labels.clone());
    sum.set_expected_rows(9);
    assert_eq!((sum.rows(), sum.expected_rows()), (2, 9));
    write_accumulator(Output::create(&path, Overwrite::Never).unwrap(), &sum).unwrap();
    assert_eq!(accumulator_labels(&path).unwrap(), (2, labels));
    // Its sums need not be whole, but its head must be.
    let bytes = fs::read(&path).unwrap();
    let cut = folder.file("cut", &bytes[..bytes.len() - 1]);
    assert_eq!(accumulator_labels(&cut).unwrap().0, 2);
    let cut = folder.file("cut", &bytes[..40]);
    let said = accumulator_labels(&cut).unwrap_err().to_string();
    assert!(said.contains("cut: truncated"), "{said}");
    let said = accumulator_labels(&folder.file("text", "not one of ours")).unwrap_err();
    assert!(said.to_string().contains("text: not an accumulator"), "{said}");
}

#[test]
fn labels_that_no_reader_accepts_are_not_written() {
    /// Bytes of one label in a head of 1 MiB, of which 53 are of numbers and 8 of lengths.
    const ROOM: usize = (1 << 20) - 53 - 8;
    let folder = Folder::new();
    let path = folder.path("sums");
    let mut sum = Accumulator::<f64>::new(2, false).unwrap();
    let write = |sum: &Accumulator<f64>| {
        write_accumulator(Output::create(&path, Overwrite::Replace).unwrap(), sum)
    };
    write(&sum).unwrap();
    let before = fs::read(&path).unwrap();
    for (len, why) in [
        (ROOM, "can't be written: all labels: 1048577 bytes, but a file has room for 1048576"),
        (1 << 21, "can't be written: label a: 2097152 bytes, but a file has room for 1048576"),
    ] {
        sum.set_labels(vec![("a".into(), "x".repeat(len))]);
        let said = write(&sum).unwrap_err().to_string();
        assert!(said.ends_with(why), "{said}");
        assert!(fs::read(&path).unwrap() == before);
    }
    sum.set_labels(vec![("a".into(), "x".repeat(ROOM - 1))]);
    write(&sum).unwrap();
    assert!(accumulator_labels(&path).unwrap().1 == sum.labels());
    assert!(read_accumulator::<f64>(&path).unwrap().labels() == sum.labels());
}

#[test]
fn an_accumulator_gets_memory_for_what_is_there() {
    // The offsets of the number of columns and of the end of the strip, and where the head ends.
    const COLUMNS: [usize; 2] = [20, 36];
    const HEAD_LENGTH: usize = 16;
    let folder = Folder::new();
    let path = folder.path("a.acc");
    for (exact, columns) in
        [(false, 40), (true, 40), (false, 61), (true, 61), (false, 31), (true, 31)]
    {
        let bounds = RowBounds::new(vec![-1.0], vec![1.0], 1).unwrap();
        let sum = match exact {
            false => Accumulator::<f64>::new(1, false).unwrap(),
            true => Accumulator::exact(&bounds, false).unwrap(),
        };
        write_accumulator(Output::create(&path, Overwrite::Replace).unwrap(), &sum).unwrap();
        let mut bytes = fs::read(&path).unwrap();
        for at in COLUMNS {
            bytes[at..at + 8].copy_from_slice(&(1_u64 << columns).to_le_bytes());
        }
        let head = u32::from_le_bytes(bytes[HEAD_LENGTH..][..4].try_into().unwrap()) as usize;
        let end = HEAD_LENGTH + 4 + head;
        let check = crc32fast::hash(&bytes[..end]);
        bytes[end..end + 4].copy_from_slice(&check.to_le_bytes());
        fs::write(&path, bytes).unwrap();
        let refused = read_accumulator::<f64>(&path);
        assert!(matches!(refused, Err(Error::Io { .. })), "2^{columns} columns: {refused:?}");
    }
}

#[test]
fn an_accumulator_whose_weights_are_damaged_is_refused() {
    let bounds = RowBounds::new(vec![-1.0], vec![1.0], 1).unwrap();
    let mut sum = Accumulator::exact(&bounds, true).unwrap();
    sum.add_block(mat![[0.5]], None, &AtaOptions::new()).unwrap();
    let mut bytes = Vec::new();
    sum.write(&mut bytes).unwrap();
    // The sum of the weights and that of their sizes come before the sum, the entry and the
    // checksum.
    let end = bytes.len() - 4;
    let weights = end - 2 * 16 - 2 * 16;
    bytes[weights..][..16].fill(0);
    bytes[weights + 16..][..16].fill(0xff);
    let head = u32::from_le_bytes(bytes[16..20].try_into().unwrap()) as usize;
    let check = crc32fast::hash(&bytes[20 + head + 4..end]);
    bytes[end..].copy_from_slice(&check.to_le_bytes());
    let refused = Accumulator::<f64>::read(&mut &bytes[..]).map(drop).unwrap_err();
    assert!(refused.to_string().contains("sums that its rows can't have"), "{refused}");
}

#[test]
fn sparse_matrices_and_text_take_no_more_memory_than_they_may() {
    let folder = Folder::new();
    let head = "%%MatrixMarket matrix coordinate pattern";
    let entries = "1 1\n".repeat(20_000);
    let within = |path: &Path, bytes: u64| read(path, &ReadOptions::new().max_memory(bytes));
    // 48 bytes an entry, twice as many if it is mirrored, and 16 for the rows.
    for (symmetry, bytes) in [("general", 960_016), ("symmetric", 1_920_016)] {
        let text = format!("{head} {symmetry}\n1 1 20000\n{entries}");
        let path = folder.file("a.mtx", text);
        assert_eq!(within(&path, bytes).unwrap().nrows(), 1);
        let said = within(&path, bytes - 1).unwrap_err().to_string();
        assert!(said.contains("20000 entries would take") && said.contains("max_memory"), "{said}");
    }
    // The number announced counts before the entries are there.
    let path = folder.file("a.mtx", format!("{head} general\n1 1 99999999999\n1 1\n"));
    assert!(read_all(&path).unwrap_err().to_string().contains("this file may take 1.00 GiB"));
    let path = folder.file("a.csv", "# a long comment\n".repeat(100_000) + "1,2\n");
    let said = within(&path, 1 << 20).unwrap_err().to_string();
    assert!(said.contains("is larger than the memory that this file may take"), "{said}");
}

#[test]
fn packed_files_and_lines_end_where_their_memory_does() {
    let folder = Folder::new();
    let zeros = vec![b'1'; 3 << 20];
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    packed.write_all(&zeros).unwrap();
    let path = folder.file("a.csv.gz", packed.finish().unwrap());
    let said =
        |memory: u64| read(&path, &ReadOptions::new().max_memory(memory)).unwrap_err().to_string();
    assert!(said(1 << 20).contains("a line of 16384 bytes or more"));
    // All of the line is one number, which is infinite.
    assert!(read(&path, &ReadOptions::new().max_memory(1_u64 << 30)).is_ok());
    let rows = b"1\n".repeat(1 << 20);
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    packed.write_all(&rows).unwrap();
    let path = folder.file("a.csv.gz", packed.finish().unwrap());
    let error = read(&path, &ReadOptions::new().max_memory(1_u64 << 20)).unwrap_err();
    assert!(error.to_string().contains("this file may take"), "{error}");
}

#[test]
fn damaged_gzip_is_refused() {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all("1,2\n".repeat(5000).as_bytes()).unwrap();
    let packed = encoder.finish().unwrap();
    refusal("a.csv.gz", &packed[..packed.len() / 2]);
    refusal("a.csv.gz", b"1,2\n");
}

#[test]
fn missing_files_folders_and_unknown_content_are_refused() {
    let folder = Folder::new();
    let message = |path: &Path| read_all(path).unwrap_err().to_string();
    assert!(message(&folder.path("none.npy")).ends_with("none.npy: no such file"));
    fs::create_dir(folder.path("d.csv")).unwrap();
    assert!(message(&folder.path("d.csv")).ends_with("d.csv: is a directory"));
    let zeros = folder.file("a.xls", b"\xd0\xcf\x11\xe0\0\0\0\0");
    assert!(message(&zeros).contains("a.xls:1: an Excel workbook (.xls): save a sheet as CSV"));
    let packed = folder.file("a.csv", b"\x04\x22\x4d\x18\x60");
    assert!(message(&packed).contains("is packed by LZ4 ("));
}

#[test]
fn reading_stops_when_progress_says_so() {
    let folder = Folder::new();
    let path = folder.file("a.csv", "1,2\n");
    let stop = |_: f64| ControlFlow::Break(());
    let options = ReadOptions::new().progress(&stop);
    assert_eq!(read(&path, &options).unwrap_err(), Error::Cancelled);
}

#[test]
fn output_never_replaces_unless_told_to() {
    let folder = Folder::new();
    let path = folder.path("c.csv");
    let mut early = Output::create(&path, Overwrite::Never).unwrap();
    early.write_all(b"mine").unwrap();
    fs::write(&path, "theirs").unwrap();
    assert!(early.commit().unwrap_err().to_string().contains("exists already"));
    assert!(Output::create(&path, Overwrite::Never).is_err());
    assert_eq!(fs::read_to_string(&path).unwrap(), "theirs");
    let mut output = Output::create(&path, Overwrite::Replace).unwrap();
    output.write_all(b"mine").unwrap();
    drop(output);
    assert_eq!(fs::read_to_string(&path).unwrap(), "theirs");
    assert_eq!(folder.names(), ["c.csv"], "no temporary is left");
}

#[cfg(unix)]
#[test]
fn output_keeps_the_permissions_and_the_owner_of_what_it_replaces() {
    use std::os::unix::fs::{MetadataExt, PermissionsExt};
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("c.npy");
    let write = || {
        let output = Output::create(&path, Overwrite::Replace).unwrap();
        write(output, awkward(2, 2).as_ref()).unwrap();
        path.metadata().unwrap()
    };
    assert_eq!(write().mode() & 0o600, 0o600);
    for mode in [0o600, 0o640, 0o444, 0o777] {
        fs::set_permissions(&path, PermissionsExt::from_mode(mode)).unwrap();
        let before = path.metadata().unwrap();
        let after = write();
        assert_ne!(before.ino(), after.ino(), "written in place");
        assert_eq!(after.mode() & 0o7777, mode, "{mode:o}");
        assert_eq!((after.uid(), after.gid()), (before.uid(), before.gid()));
    }
    // Root may change the owner of files, and change it back.
    if std::os::unix::fs::chown(&path, Some(65534), Some(65534)).is_ok() {
        let after = write();
        assert_eq!((after.uid(), after.gid()), (65534, 65534));
    }
}

#[test]
fn output_into_a_missing_folder_names_the_file() {
    let folder = Folder::new();
    let error = Output::create(&folder.path("none/c.npy"), Overwrite::Never).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("none/c.npy: can't be written"), "{text}");
    assert!(!text.contains(".catamaran-"), "{text}");
}

#[cfg(unix)]
#[test]
fn symbolic_links_stay_and_what_they_lead_to_is_replaced() {
    use std::os::unix::fs::symlink;
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::create_dir(path("there")).unwrap();
    fs::write(path("there/old"), "old").unwrap();
    symlink("second", path("first")).unwrap();
    symlink("there/old", path("second")).unwrap();
    symlink(path("there/new"), path("dangling")).unwrap();
    symlink("circle", path("circle")).unwrap();
    symlink("/dev/null", path("device")).unwrap();
    for (link, target) in [("first", "there/old"), ("dangling", "there/new")] {
        assert!(Output::create(&path(link), Overwrite::Never).is_err(), "{link}");
        let mut output = Output::create(&path(link), Overwrite::Replace).unwrap();
        assert_eq!(output.path(), path(link));
        output.write_all(b"whole").unwrap();
        output.commit().unwrap();
        assert!(path(link).symlink_metadata().unwrap().is_symlink(), "{link}");
        assert_eq!(fs::read(path(target)).unwrap(), b"whole", "{link}");
    }
    // No file is left beside them.
    assert_eq!(fs::read_dir(path("there")).unwrap().count(), 2);
    let refused = |name| Output::create(&path(name), Overwrite::Replace).unwrap_err().to_string();
    assert!(refused("circle").contains("symbolic links"), "{}", refused("circle"));
    assert!(refused("device").contains("not a regular file"), "{}", refused("device"));
}

#[test]
fn complex_matrices_are_read_and_written() {
    let folder = Folder::new();
    let complex = |path: &Path, options: &ReadOptions<'_>| match read(path, options).unwrap() {
        Matrix::Complex(dense) => dense.as_ref().to_owned(),
        other => panic!("{other:?}"),
    };
    let all = ReadOptions::new();
    let a =
        mat![[c64::new(2.0, 0.0), c64::new(0.5, 1.25)], [c64::new(0.5, -1.25), c64::new(3.0, 0.0)]];
    let header = "%%MatrixMarket matrix coordinate complex";
    let market = [
        ("hermitian", "2 2 3\n1 1 2.0 0.0\n2 1 0.5 -1.25\n2 2 3.0 0.0\n"),
        ("hermitian", "2 2 3\n1 1 2.0 0.0\n1 2 0.5 1.25D0\n2 2 3.0 0.0\n"),
        ("general", "2 2 5\n1 1 2 0\n2 1 0.5 -1\n2 1 0 -0.25\n1 2 0.5 1.25\n2 2 3 0\n"),
    ];
    for (symmetry, entries) in market {
        let path = folder.file("a.mtx", format!("{header} {symmetry}\n{entries}"));
        assert_eq!(complex(&path, &all), a, "{entries}");
        assert_eq!(complex(&path, &ReadOptions::new().columns(1..2)), a.get(.., 1..2));
    }
    let array = "%%MatrixMarket matrix array complex hermitian\n2 2\n2 0\n0.5 -1.25\n3 0\n";
    assert_eq!(complex(&folder.file("b.mtx", array), &all), a);
    let pairs: Vec<u8> = [2.0_f32, 0.0, 0.5, -1.25, 0.5, 1.25, 3.0, 0.0]
        .iter()
        .flat_map(|x| x.to_be_bytes())
        .collect();
    let path = folder.file("a.npy", npy(">c8", "True", "(2, 2)", &pairs));
    assert_eq!(complex(&path, &all), a);
    assert!(!RowFile::is_one(&path));
    for name in ["c.npy", "c.mtx"] {
        let path = folder.path(name);
        write_complex(Output::create(&path, Overwrite::Never).unwrap(), a.as_ref()).unwrap();
        assert_eq!(complex(&path, &all), a, "{name}");
    }
    let output = Output::create(&folder.path("c.csv"), Overwrite::Never).unwrap();
    assert!(write_complex(output, a.as_ref()).is_err());
    assert!(!folder.path("c.csv").exists());
}

#[test]
fn broken_complex_matrices_are_refused() {
    let head = "%%MatrixMarket matrix coordinate complex hermitian\n2 2 1\n";
    for (text, line, what) in [
        (format!("{head}1 1 2.0 1.0\n"), 3, "not real on the diagonal of a Hermitian matrix"),
        (format!("{head}2 1 2.0\n"), 3, "expected row column real imaginary"),
        (format!("{head}2 1 2.0 x\n"), 3, "\"x\" is not a number"),
        (head.replace("complex", "real"), 1, "symmetry \"hermitian\" is not one of a real matrix"),
        (format!("{}2 1 1 1\n1 2 1 -1\n", head.replace("2 2 1", "2 2 2")), 4, "both triangles"),
    ] {
        let (found, said) = refusal("a.mtx", &text);
        assert!(found == Some(line) && said.contains(what), "{text:?}: {found:?} {said}");
    }
    let short = npy("<c16", "False", "(1, 2)", &[0; 16]);
    assert!(refusal("a.npy", short).1.starts_with("truncated: fewer than the 2 entries"));
}
