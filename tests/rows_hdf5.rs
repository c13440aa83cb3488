//! Blocks of rows out of HDF5 datasets, which the HDF5 library itself writes here.

use std::fs::{self, OpenOptions};
use std::path::{Path, PathBuf};

use catamaran::faer::prelude::ReborrowMut;
use catamaran::faer::{Mat, MatMut};
use catamaran::io::RowFile;
use catamaran::rows::RowBlocks;
use catamaran::{Error, Real};
use hdf5::types::{FixedAscii, VarLenUnicode};
use hdf5::{Datatype, File, H5Type};
use tempfile::TempDir;

fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// Rows and columns: a prime number of each.
const SHAPE: (usize, usize) = (13, 7);

/// m x n entries 0, 1, ... by rows, the small ones of every type.
fn counting<T>((m, n): (usize, usize), convert: impl Fn(u8) -> T) -> Vec<T> {
    (0..m * n).map(|k| convert((k % 101) as u8)).collect()
}

fn counted((m, n): (usize, usize), convert: impl Fn(u8) -> f64) -> Mat<f64> {
    Mat::from_fn(m, n, |i, j| convert(((i * n + j) % 101) as u8))
}

fn store<T: H5Type>(file: &File, name: &str, shape: (usize, usize), values: &[T]) {
    let dataset = file.new_dataset::<T>().shape(shape).create(name).unwrap();
    dataset.write_raw(values).unwrap();
}

/// A file with doubles 0, 1, ... in `/g/x`.
fn simple(path: &Path) {
    let file = File::create(path).unwrap();
    file.create_group("g").unwrap();
    store(&file, "g/x", SHAPE, &counting(SHAPE, f64::from));
}

/// `path:dataset`
fn named(path: &Path, dataset: &str) -> PathBuf {
    format!("{}:{dataset}", path.display()).into()
}

/// The block of `count` rows from `first` on, as T.
fn block<T: Real>(rows: &mut RowFile, first: usize, count: usize) -> Mat<f64> {
    let mut out = Mat::<T>::from_fn(count, rows.ncols(), |_, _| T::from_f64(f64::NAN));
    rows.read(first, out.as_mut()).unwrap();
    Mat::from_fn(count, rows.ncols(), |i, j| out[(i, j)].to_f64())
}

/// The `what` of an error that names the file.
fn what<T: std::fmt::Debug>(path: &Path, result: Result<T, Error>) -> String {
    match result {
        Err(Error::Io { path: named, line: None, what, .. }) => {
            assert_eq!(named, path);
            assert!(!what.contains('\n'), "{what}");
            what
        }
        other => panic!("expected an error of the file, got {other:?}"),
    }
}

fn refusal(path: &Path, dataset: &str) -> String {
    what(path, RowFile::open(named(path, dataset)))
}

#[test]
fn every_type_gives_its_rows() {
    fn check<T: H5Type>(name: &str, scale: f64, convert: impl Fn(u8) -> T) {
        let folder = folder();
        let path = folder.path().join("a.h5");
        let file = File::create(&path).unwrap();
        store(&file, name, SHAPE, &counting(SHAPE, convert));
        drop(file);
        let all = counted(SHAPE, |v| scale * f64::from(v));
        let mut rows = RowFile::open(named(&path, name)).unwrap();
        assert_eq!((rows.nrows(), rows.ncols()), SHAPE);
        assert_eq!(rows.is_single(), name == "f4");
        assert_eq!(rows.path(), path);
        for (first, count) in [(0, 13), (0, 1), (12, 1), (3, 5), (4, 0), (13, 0)] {
            let expected = all.get(first..first + count, ..);
            assert_eq!(block::<f64>(&mut rows, first, count), expected, "{name}");
            assert_eq!(block::<f32>(&mut rows, first, count), expected, "{name}");
        }
    }
    check("i1", -1.0, |v| -(v as i8));
    check("i2", -1.0, |v| -i16::from(v));
    check("i4", -1.0, |v| -i32::from(v));
    check("i8", -1.0, |v| -i64::from(v));
    check("u1", 1.0, |v| v);
    check("u2", 1.0, u16::from);
    check("u4", 1.0, u32::from);
    check("u8", 1.0, u64::from);
    check("f4", 0.25, |v| f32::from(v) / 4.0);
    check("f8", 0.25, |v| f64::from(v) / 4.0);
}

#[test]
fn the_other_byte_order_is_read() {
    let folder = folder();
    let path = folder.path().join("a.h5");
    let file = File::create(&path).unwrap();
    // SAFETY: a copy of a type of the library, which the handle then owns.
    let big: Datatype = hdf5::sync::sync(|| unsafe {
        hdf5::from_id(hdf5_sys::h5t::H5Tcopy(*hdf5::globals::H5T_IEEE_F64BE)).unwrap()
    });
    let dataset = file.new_dataset_builder().empty_as(&big).shape(SHAPE).create("x").unwrap();
    dataset.write_raw(&counting(SHAPE, f64::from)).unwrap();
    drop((dataset, file));
    let mut rows = RowFile::open(&path).unwrap();
    assert_eq!(block::<f64>(&mut rows, 0, SHAPE.0), counted(SHAPE, f64::from));
}

#[test]
fn packed_chunks_give_every_block() {
    let folder = folder();
    let path = folder.path().join("a.hdf5");
    let shape = (101, 31);
    let file = File::create(&path).unwrap();
    let chunked = file.new_dataset::<f64>().shape(shape).chunk((10, 8)).shuffle().deflate(4);
    chunked.create("x").unwrap().write_raw(&counting(shape, f64::from)).unwrap();
    drop(file);
    let all = counted(shape, f64::from);
    for columns in [0..31, 7..9, 30..31] {
        let rows = RowFile::open(&path).unwrap();
        let mut rows = rows.with_columns(columns.clone()).unwrap();
        for height in [1, 7, 10, 101] {
            for first in (0..101).step_by(height) {
                let count = height.min(101 - first);
                let expected = all.get(first..first + count, columns.clone());
                assert_eq!(block::<f64>(&mut rows, first, count), expected);
            }
        }
    }
}

#[test]
fn destinations_of_any_strides_are_filled_and_nothing_beside_them() {
    let folder = folder();
    let path = folder.path().join("a.h5");
    simple(&path);
    let all = counted(SHAPE, f64::from);
    for columns in [0..7, 1..4, 2..3, 5..5] {
        let rows = RowFile::open(&path).unwrap();
        let mut rows = rows.with_columns(columns.clone()).unwrap();
        let (m, n) = (9, columns.len());
        let expected = all.get(2..2 + m, columns.clone());
        for (row_stride, column_stride) in [(n, 1), (n + 3, 1), (1, m), (1, m + 4), (3 * n + 2, 3)]
        {
            for reversed in [false, true] {
                let mut memory = vec![f64::INFINITY; 400];
                // SAFETY: the last entry is at 8 * 23 + 3 * 6 at most.
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
                assert_eq!(out.as_ref(), expected, "{row_stride} {column_stride}");
                let written = memory.iter().filter(|v| v.is_finite()).count();
                assert_eq!(written, m * n, "{row_stride} {column_stride}");
            }
        }
    }
}

#[test]
fn rows_longer_and_shorter_than_the_buffer_are_read() {
    let folder = folder();
    for shape in [(3, 40_007), (70_001, 2)] {
        let path = folder.path().join("a.h5");
        let file = File::create(&path).unwrap();
        store(&file, "x", shape, &counting(shape, f64::from));
        drop(file);
        let mut rows = RowFile::open(&path).unwrap();
        let all = counted(shape, f64::from);
        assert!(block::<f64>(&mut rows, 0, shape.0) == all);
        assert!(block::<f32>(&mut rows, 1, shape.0 - 1) == all.get(1.., ..));
    }
}

#[test]
fn vectors_are_columns_and_empty_datasets_are_read() {
    let folder = folder();
    let path = folder.path().join("a.h5");
    let file = File::create(&path).unwrap();
    let vector = file.new_dataset::<i32>().shape(5).create("v").unwrap();
    vector.write_raw(&[0, 1, 2, 3, 4]).unwrap();
    file.new_dataset::<f32>().shape((0, 3)).create("e").unwrap();
    drop((vector, file));
    let mut rows = RowFile::open(named(&path, "/v")).unwrap();
    assert_eq!((rows.nrows(), rows.ncols()), (5, 1));
    assert_eq!(block::<f64>(&mut rows, 1, 3), Mat::from_fn(3, 1, |i, _| i as f64 + 1.0));
    let mut rows = RowFile::open(&path).unwrap();
    assert_eq!((rows.nrows(), rows.ncols()), (0, 3));
    assert_eq!(block::<f32>(&mut rows, 0, 0).shape(), (0, 3));
}

#[test]
fn the_only_matrix_needs_no_name_and_others_are_listed() {
    let folder = folder();
    let path = folder.path().join("a.he5");
    drop(File::create(&path).unwrap());
    assert_eq!(
        what(&path, RowFile::open(&path)),
        "no dataset of two dimensions, so name one (a.he5:/path/to/dataset); the file has no datasets"
    );
    let file = File::open_rw(&path).unwrap();
    let group = file.create_group("g").unwrap();
    group.new_dataset::<f64>().shape(4).create("v").unwrap();
    // Groups that contain themselves, and names that lead nowhere.
    group.link_hard("/", "root").unwrap();
    group.link_soft("/none", "soft").unwrap();
    group.link_external("none.h5", "/x", "out").unwrap();
    store(&file, "g/x", SHAPE, &counting(SHAPE, f64::from));
    drop((group, file));
    assert_eq!(RowFile::open(&path).unwrap().nrows(), 13);
    store(&File::open_rw(&path).unwrap(), "y", (2, 3), &[0.0; 6]);
    let list = "the file has /g/v (4), /g/x (13 x 7), /y (2 x 3)";
    assert_eq!(
        what(&path, RowFile::open(&path)),
        format!("several datasets of two dimensions, so name one (a.he5:/path/to/dataset); {list}")
    );
    for missing in ["/z", "/g", "/g/soft", "", "/"] {
        assert_eq!(refusal(&path, missing), format!("no dataset {missing}; {list}"));
    }
}

#[derive(H5Type, Clone, Copy)]
#[repr(C)]
struct Complex {
    r: f64,
    i: f64,
}

#[test]
fn other_types_and_dimensions_are_refused() {
    let folder = folder();
    let path = folder.path().join("a.h5");
    let file = File::create(&path).unwrap();
    file.new_dataset::<VarLenUnicode>().shape((2, 2)).create("text").unwrap();
    file.new_dataset::<FixedAscii<8>>().shape(2).create("names").unwrap();
    file.new_dataset::<Complex>().shape((2, 2)).create("complex").unwrap();
    file.new_dataset::<bool>().shape((2, 2)).create("bool").unwrap();
    file.new_dataset::<[f64; 3]>().shape(2).create("arrays").unwrap();
    file.new_dataset::<f64>().shape((1, 1, 1)).create("cube").unwrap();
    file.new_dataset::<f64>().shape(()).create("scalar").unwrap();
    let out = file.new_dataset::<f64>().shape((2, 2)).external("raw.bin", 0, 32).create("outside");
    out.unwrap();
    drop(file);
    for name in ["text", "names", "complex", "bool", "arrays"] {
        let what = refusal(&path, name);
        assert!(what.starts_with(&format!("dataset {name} has entries of type ")), "{what}");
        assert!(what.ends_with(", not real numbers"), "{what}");
    }
    assert_eq!(refusal(&path, "cube"), "dataset cube has 3 dimensions, where a matrix has 2");
    assert_eq!(refusal(&path, "scalar"), "dataset scalar has 0 dimensions, where a matrix has 2");
    assert_eq!(refusal(&path, "outside"), "dataset outside has its entries in other files");
}

#[test]
fn broken_and_missing_files_are_refused() {
    let folder = folder();
    let path = folder.path().join("a.h5");
    assert_eq!(refusal(&path, "/x"), "no such file");
    for content in [&b""[..], b"no HDF5"] {
        fs::write(&path, content).unwrap();
        assert_eq!(refusal(&path, "/x"), "not an HDF5 file");
    }
    simple(&path);
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let what = refusal(&path, "/g/x");
    assert!(what.starts_with("HDF5 says: ") && what.contains("truncated"), "{what}");
}

#[test]
fn files_that_change_shrink_or_vanish_while_they_are_read_are_refused() {
    let folder = folder();
    let path = folder.path().join("a.h5");
    simple(&path);
    let mut rows = RowFile::open(&path).unwrap();
    let mut out = Mat::<f64>::zeros(3, 7);
    rows.read(0, out.as_mut()).unwrap();
    let file = OpenOptions::new().write(true).open(&path).unwrap();
    let about = file.metadata().unwrap();
    file.set_modified(about.modified().unwrap() + std::time::Duration::from_secs(1)).unwrap();
    assert_eq!(what(&path, rows.read(0, out.as_mut())), "changed since it was opened");
    assert_eq!(what(&path, rows.try_clone()), "changed since it was opened");
    file.set_len(about.len() / 2).unwrap();
    assert_eq!(what(&path, rows.read(3, out.as_mut())), "truncated: it shrank since it was opened");
    fs::remove_file(&path).unwrap();
    assert_eq!(what(&path, rows.read(0, out.as_mut())), "no such file");
    assert_eq!(what(&path, rows.try_clone()), "no such file");
}

#[test]
fn clones_outlive_the_first_and_read_in_threads() {
    let folder = folder();
    let path = folder.path().join("a.h5");
    simple(&path);
    let all = counted(SHAPE, f64::from);
    let rows = RowFile::open(&path).unwrap().with_columns(1..6).unwrap();
    let clones: Vec<_> = (0..4).map(|_| rows.try_clone().unwrap()).collect();
    drop(rows);
    std::thread::scope(|scope| {
        for (k, mut clone) in clones.into_iter().enumerate() {
            let all = &all;
            scope.spawn(move || {
                for _ in 0..20 {
                    let expected = all.get(3 * k..3 * k + 3, 1..6);
                    assert_eq!(block::<f64>(&mut clone, 3 * k, 3), expected);
                }
            });
        }
    });
}

#[test]
fn identity_names_the_dataset_and_the_file_that_holds_it() {
    let folder = folder();
    let (path, other) = (folder.path().join("a.h5"), folder.path().join("b.h5"));
    simple(&path);
    File::create(&other).unwrap().link_external("a.h5", "/g/x", "far").unwrap();
    let mut far = RowFile::open(named(&other, "far")).unwrap();
    let identity = RowFile::open(&path).unwrap().identity();
    assert!(identity.contains("a.h5:/g/x, float64, 13 x 7, columns 0..7, "), "{identity}");
    assert_eq!(far.identity(), identity);
    assert_eq!(far.path(), other);
    assert_eq!(block::<f64>(&mut far, 0, 13), counted(SHAPE, f64::from));
    assert_eq!(RowFile::open(named(&path, "g/x")).unwrap().identity(), identity);
}

#[test]
fn packing_that_this_library_lacks_is_refused_when_opened() {
    let folder = folder();
    let path = folder.path().join("a.h5");
    let file = File::create(&path).unwrap();
    file.new_dataset::<f64>().shape(SHAPE).chunk((4, 7)).deflate(1).create("x").unwrap();
    drop(file);
    // Number, length of the name, flags and count of parameters, two bytes each, precede the name.
    let mut bytes = fs::read(&path).unwrap();
    let name = bytes.windows(8).position(|window| window == b"deflate\0").unwrap();
    assert_eq!(bytes[name - 8..name - 4], [1, 0, 8, 0]);
    bytes[name - 8..name - 6].copy_from_slice(&32_999_u16.to_le_bytes());
    fs::write(&path, bytes).unwrap();
    let what = refusal(&path, "x");
    assert!(what.contains("32999") && what.ends_with("which this HDF5 library lacks"), "{what}");
}
