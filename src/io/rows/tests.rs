//! Blocks of rows out of `.npy`, against the reader of whole matrices. HDF5: `tests/rows_hdf5.rs`.

use std::fmt;
use std::fs::{self, OpenOptions};
use std::io::Write;
use std::time::UNIX_EPOCH;

use faer::Mat;
use faer::prelude::ReborrowMut;

use super::file::BUFFER;
use super::*;
use crate::io::tests::{Folder, doubles, npy, read_all};
use crate::io::{Output, Overwrite, write};

/// Returns the block of `count` rows from `first` on, as T.
fn block<T: Real>(rows: &mut RowFile, first: usize, count: usize) -> Mat<f64> {
    let mut out = Mat::<T>::from_fn(count, rows.ncols(), |_, _| T::from_f64(f64::NAN));
    rows.read(first, out.as_mut()).unwrap();
    Mat::from_fn(count, rows.ncols(), |i, j| out[(i, j)].to_f64())
}

/// Returns the `what` of the error that opening `content` gives, which names the file.
fn refusal(name: &str, content: impl AsRef<[u8]>) -> String {
    let folder = Folder::new();
    what(&folder.file(name, content), RowFile::open(folder.path(name)))
}

fn what<T: fmt::Debug>(path: &Path, result: Result<T>) -> String {
    match result {
        Err(Error::Io { path: named, line: None, what, .. }) => {
            assert_eq!(named, path);
            assert!(!what.contains('\n'), "{what}");
            what
        }
        other => panic!("expected an error of the file, got {other:?}"),
    }
}

/// Returns the bytes of m x n entries 0, 1, ... in the order of the file.
fn counting<const N: usize>(len: usize, to_bytes: impl Fn(u8) -> [u8; N]) -> Vec<u8> {
    (0..len).flat_map(|i| to_bytes((i % 101) as u8)).collect()
}

#[test]
fn every_type_in_both_orders_gives_what_read_gives() {
    fn check<const N: usize>(descr: &str, to_bytes: impl Fn(u8) -> [u8; N]) {
        let folder = Folder::new();
        let (m, n) = (13, 7);
        for order in ["False", "True"] {
            let content = npy(descr, order, "(13, 7)", &counting(m * n, &to_bytes));
            let path = folder.file("a.npy", content);
            let all = doubles(&read_all(&path).unwrap());
            let mut rows = RowFile::open(&path).unwrap();
            assert_eq!((rows.nrows(), rows.ncols()), (m, n));
            assert_eq!(rows.is_single(), descr.ends_with("f4"));
            for (first, count) in [(0, 13), (0, 1), (12, 1), (3, 5), (4, 0), (13, 0)] {
                let expected = all.get(first..first + count, ..).to_owned();
                assert_eq!(block::<f64>(&mut rows, first, count), expected, "{descr} {order}");
                assert_eq!(block::<f32>(&mut rows, first, count), expected, "{descr} {order}");
            }
        }
    }
    check("|i1", |v| (v as i8 - 50).to_le_bytes());
    check("|u1", |v| [v]);
    check("<i2", |v| (v as i16 - 50).to_le_bytes());
    check(">i2", |v| (v as i16 - 50).to_be_bytes());
    check("<u2", |v| (v as u16).to_le_bytes());
    check(">u2", |v| (v as u16).to_be_bytes());
    check("<i4", |v| (v as i32 - 50).to_le_bytes());
    check(">i4", |v| (v as i32 - 50).to_be_bytes());
    check("<u4", |v| (v as u32).to_le_bytes());
    check(">u4", |v| (v as u32).to_be_bytes());
    check("<i8", |v| (v as i64 - 50).to_le_bytes());
    check(">i8", |v| (v as i64 - 50).to_be_bytes());
    check("<u8", |v| (v as u64).to_le_bytes());
    check(">u8", |v| (v as u64).to_be_bytes());
    check("<f4", |v| (v as f32 / 4.0).to_le_bytes());
    check(">f4", |v| (v as f32 / 4.0).to_be_bytes());
    check("<f8", |v| (v as f64 / 4.0).to_le_bytes());
    check(">f8", |v| (v as f64 / 4.0).to_be_bytes());
}

#[test]
fn destinations_of_any_strides_are_filled_and_nothing_beside_them() {
    let folder = Folder::new();
    for order in ["False", "True"] {
        let data = counting(11 * 5, |v| f64::from(v).to_le_bytes());
        let path = folder.file("a.npy", npy("<f8", order, "(11, 5)", &data));
        let expected = doubles(&read_all(&path).unwrap()).get(2..9, ..).to_owned();
        for columns in [0..5, 1..4, 2..3, 5..5] {
            let mut rows = RowFile::open(&path).unwrap().with_columns(columns.clone()).unwrap();
            let (m, n) = (7, columns.len());
            let expected = expected.get(.., columns.clone());
            // Rows without and with gaps, columns likewise, neither; forwards and backwards.
            for (row_gap, column_gap) in [(0, 1), (3, 1), (1, 0), (1, 4), (2, 3)] {
                for reversed in [false, true] {
                    let (row_stride, column_stride) = match (row_gap, column_gap) {
                        (gap, 1) => (n + gap, 1),
                        (1, gap) => (1, m + gap),
                        (_, step) => (n * step + 2, step),
                    };
                    let mut memory = vec![f64::INFINITY; 400];
                    // SAFETY: the last entry is at 6 * 17 + 4 * 3 at most.
                    let out = unsafe {
                        MatMut::from_raw_parts_mut(
                            memory.as_mut_ptr(),
                            m,
                            n,
                            row_stride as isize,
                            column_stride as isize,
                        )
                    };
                    let mut out = if reversed { out.reverse_rows_mut() } else { out };
                    rows.read(2, out.rb_mut()).unwrap();
                    assert_eq!(out.as_ref(), expected, "{order} {row_stride} {column_stride}");
                    let written = memory.iter().filter(|v| v.is_finite()).count();
                    assert_eq!(written, m * n, "{order} {row_stride} {column_stride}");
                }
            }
        }
    }
}

#[test]
fn lines_longer_and_shorter_than_the_buffer_are_read() {
    let folder = Folder::new();
    let entry = |i: usize, j: usize| (i * 7 + j * 13 % 1009) as f64;
    // Long rows, long columns, and a square of several buffers.
    for (m, n) in [(3, BUFFER / 8 + 5), (BUFFER / 4 + 3, 2), (509, 251)] {
        for (order, fortran) in [("False", false), ("True", true)] {
            let data: Vec<u8> = (0..m * n)
                .map(|k| if fortran { entry(k % m, k / m) } else { entry(k / n, k % n) })
                .flat_map(f64::to_le_bytes)
                .collect();
            let path = folder.file("a.npy", npy("<f8", order, &format!("({m}, {n})"), &data));
            for columns in [0..n, n / 2..n / 2 + 1, 1..n] {
                let mut rows = RowFile::open(&path).unwrap().with_columns(columns.clone()).unwrap();
                for (first, count) in [(0, m), (1, m - 1), (m / 2, 1)] {
                    let expected = Mat::from_fn(count, columns.len(), |i, j| {
                        entry(first + i, columns.start + j)
                    });
                    assert!(block::<f64>(&mut rows, first, count) == expected, "{m} {n} {order}");
                    assert!(block::<f32>(&mut rows, first, count) == expected, "{m} {n} {order}");
                    let mut out = vec![0.0; count * columns.len()];
                    let mut out = MatMut::from_row_major_slice_mut(&mut out, count, columns.len());
                    rows.read(first, out.rb_mut()).unwrap();
                    assert!(out.as_ref() == expected.as_ref(), "{m} {n} {order}");
                }
            }
        }
    }
}

#[test]
fn vectors_are_columns_and_empty_matrices_are_read() {
    let folder = Folder::new();
    let data = counting(5, |v| f64::from(v).to_le_bytes());
    let mut rows = RowFile::open(folder.file("a.npy", npy("<f8", "False", "(5,)", &data))).unwrap();
    assert_eq!((rows.nrows(), rows.ncols()), (5, 1));
    assert_eq!(block::<f64>(&mut rows, 1, 3), Mat::from_fn(3, 1, |i, _| i as f64 + 1.0));
    for (shape, m, n) in [("(0, 3)", 0, 3), ("(3, 0)", 3, 0), ("(0,)", 0, 1)] {
        let mut rows =
            RowFile::open(folder.file("a.npy", npy("<f4", "False", shape, &[]))).unwrap();
        assert_eq!((rows.nrows(), rows.ncols()), (m, n));
        assert_eq!(block::<f32>(&mut rows, 0, m).shape(), (m, n));
    }
}

#[test]
fn blocks_and_columns_outside_the_matrix_are_refused() {
    let folder = Folder::new();
    let path = folder.file("a.npy", npy("|u1", "False", "(2, 3)", &[1, 2, 3, 4, 5, 6]));
    let mut rows = RowFile::open(&path).unwrap();
    for (first, m) in [(1, 2), (3, 0), (usize::MAX, 1)] {
        let error = rows.read(first, Mat::<f64>::zeros(m, 3).as_mut()).unwrap_err();
        assert!(matches!(error, Error::Argument { what: "rows", .. }), "{error}");
    }
    let error = rows.read(0, Mat::<f32>::zeros(2, 2).as_mut()).unwrap_err();
    assert_eq!(error, Error::Shape { what: "block of rows", expected: (2, 3), got: (2, 2) });
    let error = rows.with_columns(1..4).unwrap_err();
    assert!(matches!(error, Error::Argument { what: "columns", .. }), "{error}");
}

#[test]
fn broken_arrays_are_refused_when_they_are_opened() {
    let good = npy("<f8", "False", "(2, 3)", &[0; 48]);
    assert_eq!(
        refusal("a.npy", &good[..good.len() - 1]),
        "truncated: fewer than the 6 entries its header announces"
    );
    let mut long = good.clone();
    long.push(0);
    assert_eq!(refusal("a.npy", &long), "data after the 6 entries its header announces");
    assert!(refusal("a.npy", &good[..40]).starts_with("broken npy header"));
    assert!(refusal("a.npy", "no array").starts_with("broken npy header"));
    assert!(refusal("a.npy", "").starts_with("broken npy header"));
    for (descr, size) in [("<c16", 16), ("|S8", 8), ("|V1", 1), ("<U2", 8)] {
        let content = npy(descr, "False", "(1, 2)", &vec![0; 2 * size]);
        let said = refusal("a.npy", content);
        assert!(
            said.contains("are not real numbers of a type that is read: b1, f2, f4, "),
            "{said}"
        );
    }
    let cube = npy("<f8", "False", "(1, 1, 1)", &[0; 8]);
    assert_eq!(refusal("a.npy", cube), "an array of 3 dimensions, where a matrix has 2");
    let scalar = npy("<f8", "False", "()", &[0; 8]);
    assert_eq!(refusal("a.npy", scalar), "an array of 0 dimensions, where a matrix has 2");
    let huge = npy("<f8", "False", "(4294967296, 1048576)", &[]);
    assert!(refusal("a.npy", huge).starts_with("truncated"));
    let order = "{'shape': (4294967296, 4294967296), 'fortran_order': False, 'descr': '<f8'}\n";
    let beyond_first = [b"\x93NUMPY\x02\x00", &(order.len() as u32).to_le_bytes()[..]].concat();
    let beyond_first = [beyond_first, order.into()].concat();
    let too_large = "shape too large: (4294967296, 4294967296)";
    assert_eq!(refusal("a.npy", beyond_first), too_large);
    let beyond = npy("<f8", "False", "(4294967296, 4294967296)", &[]);
    assert_eq!(refusal("a.npy", beyond), too_large);
    // Without entries, but rows that no loop could visit.
    let tall = npy("<f8", "False", "(9223372036854775808, 0)", &[]);
    assert_eq!(refusal("a.npy", tall), "shape too large: (9223372036854775808, 0)");
}

#[test]
fn names_say_what_is_read() {
    let hdf5 = |path: &str, dataset: Option<&str>| RowsFormat::Hdf5 {
        path: path.into(),
        dataset: dataset.map(Into::into),
    };
    let kind = |name: &str| RowsFormat::of(Path::new(name)).unwrap();
    assert_eq!(kind("d/a.NPY"), RowsFormat::Npy);
    assert_eq!(kind("d/a.h5"), hdf5("d/a.h5", None));
    assert_eq!(kind("a.he5:/g/x"), hdf5("a.he5", Some("/g/x")));
    assert_eq!(kind("a.HDF5:/b.h5:c"), hdf5("a.HDF5", Some("/b.h5:c")));
    assert_eq!(kind("c:a.h5:x.npy"), hdf5("c:a.h5", Some("x.npy")));
    assert_eq!(kind("a.h5:"), hdf5("a.h5", Some("")));
    assert!(refusal("a.npy.gz", "").starts_with("gzipped"));
    for name in ["a.csv", "a.mtx", "npy", "a.h5x"] {
        assert!(refusal(name, "1,2\n").starts_with("unknown kind of file"), "{name}");
    }
}

#[cfg(not(feature = "hdf5"))]
#[test]
fn hdf5_asks_for_its_feature() {
    for name in ["a.h5", "a.hdf5:/x"] {
        let error = RowFile::open(name).unwrap_err().to_string();
        assert!(error.ends_with("build it with --features hdf5"), "{error}");
        assert!(error.starts_with(name.split(':').next().unwrap()), "{error}");
    }
}

#[test]
fn missing_files_folders_and_pipes_are_refused() {
    let folder = Folder::new();
    let missing = folder.path("none.npy");
    assert_eq!(what(&missing, RowFile::open(&missing)), "no such file");
    let inner = folder.path("d.npy");
    fs::create_dir(&inner).unwrap();
    assert_eq!(what(&inner, RowFile::open(&inner)), "is a directory");
    #[cfg(unix)]
    {
        let device = folder.path("null.npy");
        std::os::unix::fs::symlink("/dev/null", &device).unwrap();
        assert!(what(&device, RowFile::open(&device)).starts_with("not a plain file"));
    }
}

#[test]
fn files_that_change_while_they_are_read_are_refused() {
    let folder = Folder::new();
    for order in ["False", "True"] {
        let path = folder.file("a.npy", npy("<f8", order, "(2, 3)", &[0; 48]));
        let mut rows = RowFile::open(&path).unwrap();
        let mut out = Mat::<f64>::zeros(2, 3);
        rows.read(0, out.as_mut()).unwrap();
        let mut file = OpenOptions::new().append(true).open(&path).unwrap();
        file.write_all(&[0; 8]).unwrap();
        assert_eq!(what(&path, rows.read(0, out.as_mut())), CHANGED);
        let len = file.metadata().unwrap().len();
        file.set_len(len - 16).unwrap();
        // Rows that are still there can't be trusted any more.
        for count in [1, 2] {
            let out = out.as_mut().subrows_mut(0, count);
            assert_eq!(what(&path, rows.read(0, out)), "truncated: it shrank since it was opened");
        }
        assert!(what(&path, rows.try_clone()).starts_with("truncated: fewer"));
        fs::remove_file(&path).unwrap();
        assert_eq!(what(&path, rows.try_clone()), "no such file");
    }
}

#[test]
fn the_first_integer_that_is_rounded_is_known_once_it_is_read() {
    let folder = Folder::new();
    let mut values = vec![0_i64; 5 * 300];
    // Rows of 300 entries: row 2, column 7, and row 4, column 299.
    (values[607], values[1499]) = ((1 << 53) + 1, i64::MAX);
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    let said = |row: usize, column: usize| {
        let place = format!("row {row}, column {column} (counted from 0)");
        Some(format!("integers beyond 2^53 rounded, the first in {place}"))
    };
    for (order, shape) in [("False", "(5, 300)"), ("True", "(300, 5)")] {
        let path = folder.file("a.npy", npy("<i8", order, shape, &bytes));
        let mut rows = RowFile::open(&path).unwrap();
        let mut clone = rows.try_clone().unwrap();
        let count = rows.nrows() - 1;
        block::<f64>(&mut clone, 0, 2);
        assert_eq!(rows.rounded_integers(), None);
        let (first, last) = match order {
            "False" => (said(2, 7), said(4, 299)),
            _ => (said(7, 2), said(299, 4)),
        };
        block::<f32>(&mut rows, count, 1);
        assert_eq!(clone.rounded_integers(), last);
        block::<f64>(&mut clone, 1, count);
        assert_eq!(rows.rounded_integers(), first);
        let mut some = RowFile::open(&path).unwrap().with_columns(0..2).unwrap();
        block::<f64>(&mut some, 0, count + 1);
        assert_eq!(some.rounded_integers(), None);
    }
}

#[test]
fn clones_read_the_same_rows_on_their_own() {
    let folder = Folder::new();
    let path = folder.path("a.npy");
    let a = Mat::<f64>::from_fn(5, 4, |i, j| (10 * i + j) as f64);
    write(Output::create(&path, Overwrite::Never).unwrap(), a.as_ref()).unwrap();
    let mut rows = RowFile::open(&path).unwrap().with_columns(1..3).unwrap();
    let mut other = rows.try_clone().unwrap();
    let reader = std::thread::spawn(move || block::<f64>(&mut other, 3, 2));
    assert_eq!(block::<f64>(&mut rows, 0, 2), a.get(0..2, 1..3));
    assert_eq!(reader.join().unwrap(), a.get(3..5, 1..3));
    write(Output::create(&path, Overwrite::Replace).unwrap(), a.get(0..4, ..)).unwrap();
    assert_eq!(what(&path, rows.try_clone()), CHANGED);
    assert_eq!(block::<f64>(&mut rows, 3, 2), a.get(3..5, 1..3), "the old file is still there");
}

#[test]
fn identity_tells_files_types_columns_and_changes_apart() {
    let folder = Folder::new();
    let identity = |path: &Path| RowFile::open(path).unwrap().identity();
    let a = folder.file("a.npy", npy("<f8", "False", "(2, 3)", &[0; 48]));
    let before = identity(&a);
    assert_eq!(identity(&folder.path("./a.npy")), before);
    assert!(before.contains("F8 in C order, 2 x 3, columns 0..3, 176 bytes"), "{before}");
    let part = RowFile::open(&a).unwrap().with_columns(0..2).unwrap();
    assert_ne!(part.identity(), before);
    let mut others = vec![before];
    others.push(identity(&folder.file("b.npy", npy("<f8", "False", "(2, 3)", &[0; 48]))));
    others.push(identity(&folder.file("a.npy", npy("<f8", "True", "(2, 3)", &[0; 48]))));
    others.push(identity(&folder.file("a.npy", npy("<i8", "False", "(2, 3)", &[0; 48]))));
    others.push(identity(&folder.file("a.npy", npy("<f8", "False", "(3, 2)", &[0; 48]))));
    let file = OpenOptions::new().append(true).open(&a).unwrap();
    file.set_modified(UNIX_EPOCH).unwrap();
    others.push(identity(&a));
    assert!(others.last().unwrap().ends_with("modified 0.000000000"), "{others:?}");
    let count = others.len();
    others.sort();
    others.dedup();
    assert_eq!(others.len(), count, "{others:?}");
}
