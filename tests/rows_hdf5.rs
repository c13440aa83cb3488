//! Blocks of rows out of HDF5 datasets, which the HDF5 library itself writes here.

use std::ffi::{c_uint, c_void};
use std::fs::{self, OpenOptions};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use catamaran::faer::prelude::ReborrowMut;
use catamaran::faer::{Mat, MatMut};
use catamaran::io::{self, Output, Overwrite, RowFile};
use catamaran::rows::RowBlocks;
use catamaran::{Error, Real};
use hdf5::types::{FixedAscii, VarLenUnicode};
use hdf5::{Dataset, Datatype, File, H5Type};
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
    file.new_dataset::<[f64; 3]>().shape(2).create("arrays").unwrap();
    file.new_dataset::<f64>().shape((1, 1, 1)).create("cube").unwrap();
    file.new_dataset::<f64>().shape(()).create("scalar").unwrap();
    let out = file.new_dataset::<f64>().shape((2, 2)).external("raw.bin", 0, 32).create("outside");
    out.unwrap();
    drop(file);
    for name in ["text", "names", "complex", "arrays"] {
        let what = refusal(&path, name);
        assert!(what.starts_with(&format!("dataset {name} has entries of type ")), "{what}");
        assert!(what.ends_with(", not real numbers"), "{what}");
    }
    assert_eq!(refusal(&path, "cube"), "dataset cube has 3 dimensions, where a matrix has 2");
    assert_eq!(refusal(&path, "scalar"), "dataset scalar has 0 dimensions, where a matrix has 2");
    let what = refusal(&path, "outside");
    assert!(what.starts_with("dataset outside has its entries in other files that are not HDF5"));
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
    assert!(what.contains("32999") && what.contains("which this HDF5 library lacks"), "{what}");
    assert!(what.contains("HDF5_PLUGIN_PATH"), "{what}");
}

fn attribute<T: H5Type>(dataset: &Dataset, name: &str, value: T) {
    dataset.new_attr::<T>().create(name).unwrap().write_scalar(&value).unwrap();
}

#[test]
fn attributes_of_netcdf_give_entries_their_meaning_and_notes_say_so() {
    let folder = folder();
    let path = folder.path().join("a.nc");
    let file = File::create(&path).unwrap();
    let dataset = file.new_dataset::<i16>().shape((2, 3)).create("t2m").unwrap();
    dataset.write_raw(&[100_i16, -100, 0, -32_767, 3, 9_999]).unwrap();
    attribute(&dataset, "scale_factor", 0.5_f64);
    attribute(&dataset, "add_offset", 250.0_f32);
    attribute(&dataset, "_FillValue", -32_767_i16);
    attribute(&dataset, "missing_value", 9_999_i16);
    attribute(&dataset, "valid_min", -200_i16);
    let bytes = file.new_dataset::<i8>().shape(3).create("bytes").unwrap();
    bytes.write_raw(&[1_i8, -1, -128]).unwrap();
    attribute(&bytes, "_Unsigned", FixedAscii::<4>::from_ascii("true").unwrap());
    let plain = file.new_dataset::<f32>().shape(3).create("plain").unwrap();
    plain.write_raw(&[1.5_f32, 1e20, 1e30]).unwrap();
    attribute(&plain, "scale_factor", 1.0_f64);
    attribute(&plain, "_FillValue", 1e20_f32);
    attribute(&plain, "missing_value", 1e30_f64);
    let broken = file.new_dataset::<f32>().shape(2).create("broken").unwrap();
    broken.new_attr::<f64>().shape(2).create("scale_factor").unwrap().write_raw(&[1.0; 2]).unwrap();
    drop((dataset, bytes, plain, broken, file));

    let mut rows = RowFile::open(named(&path, "t2m")).unwrap();
    let found = block::<f64>(&mut rows, 0, 2);
    let first = Mat::from_fn(1, 3, |_, j| [300.0, 200.0, 250.0][j]);
    assert_eq!(found.get(..1, ..).to_owned(), first);
    assert!(found[(1, 0)].is_nan() && found[(1, 2)].is_nan());
    assert_eq!(found[(1, 1)], 251.5);
    let notes = rows.notes().join("; ");
    assert!(notes.contains("t2m: read by its attributes of netCDF: scale_factor 0.5"), "{notes}");
    assert!(notes.contains("missing -32767 and 9999 (read as NaN)"), "{notes}");
    assert!(notes.contains("valid_min are not applied"), "{notes}");
    assert!(rows.identity().contains("add_offset 250"), "{}", rows.identity());

    let mut rows = RowFile::open(named(&path, "bytes")).unwrap();
    assert_eq!(block::<f64>(&mut rows, 0, 3), Mat::from_fn(3, 1, |i, _| [1.0, 255.0, 128.0][i]));
    let mut rows = RowFile::open(named(&path, "plain")).unwrap();
    assert!(rows.is_single());
    let found = block::<f32>(&mut rows, 0, 3);
    assert!(found[(0, 0)] == 1.5 && found[(1, 0)].is_nan() && found[(2, 0)].is_nan());
    let said = refusal(&path, "broken");
    assert!(said.contains("scale_factor that is not one finite number"), "{said}");
}

#[test]
fn numbers_of_any_kind_are_read() {
    let folder = folder();
    let path = folder.path().join("a.h5");
    let file = File::create(&path).unwrap();
    let truths = file.new_dataset::<bool>().shape((2, 2)).create("bool").unwrap();
    truths.write_raw(&[true, false, false, true]).unwrap();
    // SAFETY: copies of types of the library, which the handles then own, and whose fields are
    // those of IEEE half precision.
    let [half, long]: [Datatype; 2] = hdf5::sync::sync(|| unsafe {
        let half = hdf5_sys::h5t::H5Tcopy(*hdf5::globals::H5T_IEEE_F32LE);
        assert!(hdf5_sys::h5t::H5Tset_fields(half, 15, 10, 5, 0, 10) >= 0);
        assert!(hdf5_sys::h5t::H5Tset_size(half, 2) >= 0);
        assert!(hdf5_sys::h5t::H5Tset_ebias(half, 15) >= 0);
        let long = hdf5_sys::h5t::H5Tcopy(*hdf5::globals::H5T_NATIVE_LDOUBLE);
        [hdf5::from_id(half).unwrap(), hdf5::from_id(long).unwrap()]
    });
    for (name, kind) in [("half", &half), ("long", &long)] {
        let dataset = file.new_dataset_builder().empty_as(kind).shape((2, 2)).create(name).unwrap();
        dataset.write_raw(&[0.5, -2.0, 1024.0, 0.0]).unwrap();
    }
    drop((truths, file));
    let truths = Mat::from_fn(2, 2, |i, j| f64::from(u8::from(i == j)));
    let mut rows = RowFile::open(named(&path, "bool")).unwrap();
    assert_eq!(block::<f64>(&mut rows, 0, 2), truths);
    assert_eq!(block::<f32>(&mut rows, 0, 2), truths);
    for (name, notes) in [("half", 0), ("long", 1)] {
        let mut rows = RowFile::open(named(&path, name)).unwrap();
        let expected = Mat::from_fn(2, 2, |i, j| [0.5, -2.0, 1024.0, 0.0][2 * i + j]);
        assert_eq!(block::<f64>(&mut rows, 0, 2), expected, "{name}");
        assert_eq!(rows.notes().len(), notes, "{name}: {:?}", rows.notes());
    }
}

#[test]
fn the_first_integer_that_is_rounded_is_known_once_it_is_read() {
    let folder = folder();
    let path = folder.path().join("a.h5");
    let file = File::create(&path).unwrap();
    let mut signed = [0_i64; 6];
    (signed[2], signed[5]) = ((1 << 53) + 1, -(1 << 53) - 3);
    store(&file, "signed", (3, 2), &signed);
    store(&file, "unsigned", (3, 2), &signed.map(i64::cast_unsigned));
    store(&file, "exact", (3, 2), &[1_i64 << 53; 6]);
    drop(file);
    let note = "integers beyond 2^53 rounded, the first in row 1, column 0 (counted from 0)";
    for name in ["signed", "unsigned", "exact"] {
        let mut rows = RowFile::open(named(&path, name)).unwrap();
        block::<f64>(&mut rows, 0, 1);
        assert_eq!(rows.rounded_integers(), None, "{name}");
        let found = block::<f64>(&mut rows, 0, 3);
        let expected = (name != "exact").then_some(note);
        assert_eq!(rows.rounded_integers().as_deref(), expected, "{name}");
        assert_eq!(found[(1, 0)], 9007199254740992.0, "{name}");
    }
}

#[test]
fn missing_integers_are_not_rounded_ones() {
    /// That of netCDF for integers of 8 bytes; it is no f64.
    const FILL: i64 = -9_223_372_036_854_775_806;
    let folder = folder();
    let path = folder.path().join("a.h5");
    let file = File::create(&path).unwrap();
    for (name, last) in [("small", 7), ("large", (1 << 53) + 1)] {
        let dataset = file.new_dataset::<i64>().shape((3, 1)).create(name).unwrap();
        let values = [5, FILL, last];
        dataset.write_raw(&values[..]).unwrap();
        attribute(&dataset, "_FillValue", FILL);
    }
    drop(file);
    let note = "integers beyond 2^53 rounded, the first in row 2, column 0 (counted from 0)";
    for (name, expected) in [("small", None), ("large", Some(note))] {
        let mut rows = RowFile::open(named(&path, name)).unwrap();
        let found = block::<f64>(&mut rows, 0, 3);
        assert!(found[(0, 0)] == 5.0 && found[(1, 0)].is_nan(), "{name}: {found:?}");
        assert_eq!(rows.rounded_integers().as_deref(), expected, "{name}");
    }
}

#[test]
fn matrices_of_matlab_have_the_shape_that_matlab_shows() {
    let folder = folder();
    let path = folder.path().join("a.mat");
    let file = File::create(&path).unwrap();
    // By columns: MATLAB's 3 x 4 matrix is a dataset of 4 x 3.
    let dataset = file.new_dataset::<f64>().shape((4, 3)).create("A").unwrap();
    let entry = |i: usize, j: usize| (10 * i + j) as f64;
    let values: Vec<f64> = (0..12).map(|k| entry(k % 3, k / 3)).collect();
    dataset.write_raw(&values).unwrap();
    attribute(&dataset, "MATLAB_class", FixedAscii::<6>::from_ascii("double").unwrap());
    let text = file.new_dataset::<u16>().shape((2, 1)).create("text").unwrap();
    attribute(&text, "MATLAB_class", FixedAscii::<4>::from_ascii("char").unwrap());
    let sparse = file.create_group("S").unwrap();
    sparse.new_attr::<u64>().create("MATLAB_sparse").unwrap().write_scalar(&3_u64).unwrap();
    drop((dataset, text, sparse, file));
    assert!(refusal(&path, "text").ends_with("is text of MATLAB, not real numbers"));
    let rows = RowFile::open(named(&path, "A")).unwrap();
    assert_eq!((rows.nrows(), rows.ncols()), (3, 4));
    let mut rows = rows.with_columns(1..4).unwrap();
    for (first, count) in [(0, 3), (1, 1), (2, 1)] {
        let expected = Mat::from_fn(count, 3, |i, j| entry(first + i, j + 1));
        assert_eq!(block::<f64>(&mut rows, first, count), expected);
        assert_eq!(block::<f32>(&mut rows, first, count), expected);
    }
    assert!(refusal(&path, "S").starts_with("S is a sparse matrix (MATLAB)"));
}

#[test]
fn virtual_datasets_are_read_and_their_parts_are_watched() {
    let folder = folder();
    let part = |k: usize| folder.path().join(format!("part{k}.h5"));
    for k in 0..2 {
        let values: Vec<f64> = (0..6).map(|i| (6 * k + i) as f64).collect();
        store(&File::create(part(k)).unwrap(), "x", (2, 3), &values);
    }
    let path = folder.path().join("all.h5");
    // A file that is open for writing would open its parts for writing.
    {
        let file = File::create(&path).unwrap();
        let all = file.new_dataset::<f64>().shape((4, 3)).with_dcpl(|list| {
            list.virtual_map("part0.h5", "x", (2, 3), (0..2, 0..3), (4, 3), (0..2, 0..3))
                .virtual_map("part1.h5", "x", (2, 3), (0..2, 0..3), (4, 3), (2..4, 0..3))
        });
        all.create("all").unwrap();
        let lacking = file.new_dataset::<f64>().shape((4, 3)).with_dcpl(|list| {
            list.virtual_map("part0.h5", "x", (2, 3), (0..2, 0..3), (4, 3), (0..2, 0..3))
                .virtual_map("part0.h5", "y", (2, 3), (0..2, 0..3), (4, 3), (2..4, 0..3))
        });
        lacking.create("other").unwrap();
        let lacking = file.new_dataset::<f64>().shape((2, 3)).with_dcpl(|list| {
            list.virtual_map(".", "z", (2, 3), (0..2, 0..3), (2, 3), (0..2, 0..3))
        });
        lacking.create("own").unwrap();
    }
    for (name, part) in [("other", "part0.h5:y"), ("own", ".:z")] {
        let said = refusal(&path, name);
        assert!(said.contains(&format!("its part {part} is missing")), "{said}");
    }
    let all = named(&path, "all");
    let mut rows = RowFile::open(&all).unwrap();
    let expected = Mat::from_fn(4, 3, |i, j| (3 * i + j) as f64);
    assert_eq!(block::<f64>(&mut rows, 0, 4), expected);
    assert!(rows.identity().contains("part1.h5"), "{}", rows.identity());
    let changed = OpenOptions::new().write(true).open(part(1)).unwrap();
    let time = changed.metadata().unwrap().modified().unwrap();
    changed.set_modified(time + std::time::Duration::from_secs(1)).unwrap();
    let mut out = Mat::<f64>::zeros(4, 3);
    assert_eq!(what(&part(1), rows.read(0, out.as_mut())), "changed since it was opened");
    drop(rows);
    // HDF5 itself would read zeros.
    fs::remove_file(part(0)).unwrap();
    let said = what(&path, RowFile::open(&all));
    assert!(said.contains("its part part0.h5:x is missing"), "{said}");
}

#[test]
fn files_of_any_name_whose_content_is_hdf5_are_read() {
    let folder = folder();
    for name in ["a.nc", "a.h5ad", "a.mat", "a"] {
        let path = folder.path().join(name);
        simple(&path);
        assert!(RowFile::is_one(&path));
        for name in [path.clone(), named(&path, "/g/x")] {
            let mut rows = RowFile::open(name).unwrap();
            assert_eq!(block::<f64>(&mut rows, 0, SHAPE.0), counted(SHAPE, f64::from));
        }
        assert!(refusal(&path, "/none").contains("/g/x (13 x 7)"));
    }
}

#[test]
fn files_that_others_have_locked_are_read_with_a_note() {
    let folder = folder();
    let path = folder.path().join("a.h5");
    simple(&path);
    assert!(RowFile::open(&path).unwrap().notes().is_empty());
    let other = OpenOptions::new().write(true).open(&path).unwrap();
    other.lock().unwrap();
    let mut rows = RowFile::open(&path).unwrap();
    // Commands open a file once more, for each thread that reads.
    let mut again = RowFile::open(&path).unwrap();
    for rows in [&mut rows, &mut again] {
        assert!(rows.notes().join("; ").contains("without a lock"), "{:?}", rows.notes());
        assert_eq!(block::<f64>(rows, 0, SHAPE.0), counted(SHAPE, f64::from));
    }
}

#[test]
fn matrices_are_written_in_their_precision() {
    let folder = folder();
    let path = folder.path().join("c.h5");
    let a = Mat::from_fn(5, 3, |i, j| (3 * i + j) as f64);
    let output = || Output::create(&path, Overwrite::Replace).unwrap();
    io::write(output(), a.as_ref()).unwrap();
    let mut rows = RowFile::open(&path).unwrap();
    assert!(!rows.is_single() && rows.identity().contains("c.h5:/matrix, float64"));
    assert_eq!(block::<f64>(&mut rows, 0, 5), a);
    let b = Mat::from_fn(4, 2, |i, j| (2 * i + j) as f32);
    io::write(output(), b.as_ref()).unwrap();
    let mut rows = RowFile::open(&path).unwrap();
    assert!(rows.is_single());
    assert_eq!(block::<f32>(&mut rows, 0, 4), Mat::from_fn(4, 2, |i, j| (2 * i + j) as f64));
    let integers = Mat::from_fn(2, 2, |i, j| i as i64 - j as i64);
    io::write_integers(output(), integers.as_ref()).unwrap();
    let mut rows = RowFile::open(&path).unwrap();
    assert_eq!(block::<f64>(&mut rows, 0, 2), Mat::from_fn(2, 2, |i, j| i as f64 - j as f64));
}

/// How often chunks were unpacked.
static UNPACKED: AtomicUsize = AtomicUsize::new(0);

/// A filter that leaves bytes as they are, and counts.
unsafe extern "C" fn count(
    flags: c_uint,
    _: usize,
    _: *const c_uint,
    bytes: usize,
    _: *mut usize,
    _: *mut *mut c_void,
) -> usize {
    if flags & hdf5_sys::h5z::H5Z_FLAG_REVERSE != 0 {
        UNPACKED.fetch_add(1, Ordering::Relaxed);
    }
    bytes
}

#[test]
fn chunks_of_one_column_are_unpacked_once_whatever_the_blocks() {
    const FILTER: i32 = 500;
    let class = hdf5_sys::h5z::H5Z_class2_t {
        version: 1,
        id: FILTER,
        encoder_present: 1,
        decoder_present: 1,
        name: c"count".as_ptr(),
        can_apply: None,
        set_local: None,
        filter: Some(count),
    };
    // SAFETY: HDF5 copies the class; its name and function live as long as the program.
    let status =
        hdf5::sync::sync(|| unsafe { hdf5_sys::h5z::H5Zregister((&raw const class).cast()) });
    assert!(status >= 0);
    let folder = folder();
    let path = folder.path().join("a.h5");
    // A row of chunks takes 40 MB, more than HDF5 keeps by default and more than 32 MiB.
    let (m, n) = (100_000, 50);
    let file = File::create(&path).unwrap();
    let chunked = file.new_dataset::<f64>().shape((m, n)).chunk((m, 1)).add_filter(FILTER, &[]);
    let values: Vec<f64> = (0..m * n).map(|k| (k % 1009) as f64).collect();
    chunked.create("x").unwrap().write_raw(&values).unwrap();
    drop(file);
    let rows = RowFile::open(&path).unwrap();
    assert_eq!(rows.chunk_rows(), m);
    let mut rows = rows.try_clone().unwrap();
    let before = UNPACKED.load(Ordering::Relaxed);
    for first in (0..m).step_by(20_000) {
        let found = block::<f64>(&mut rows, first, 20_000);
        assert_eq!(found[(7, 3)], ((first + 7) * n + 3) as f64 % 1009.0);
    }
    assert_eq!(UNPACKED.load(Ordering::Relaxed) - before, n);
}
