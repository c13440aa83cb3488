//! Reads the files of [`write_arrays`](super::write_arrays).

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use faer::Mat;
use zip::result::ZipError;

use super::archive::array_name;
use super::extents::{padded_bytes, tuple};
use super::limits::SourceOptions;
use super::names::ArraysFormat;
use super::npy::{Entry, trailing, truncated};
use super::npy_header;
use super::packing;
use super::source::{error, error_at};
use super::stored::{Begin, Entries, Stored};
use crate::base::{Error, Result, reserved};

/// Named arrays of a file, in memory.
#[derive(Debug, Clone)]
pub struct Arrays {
    path: PathBuf,
    arrays: BTreeMap<String, Stored>,
}

/// Reads all arrays of an `.npz` (also packed) or, with feature `hdf5`, HDF5 file: numbers (f8) and
/// unsigned integers (u8), as [`write_arrays`](super::write_arrays) writes them.
///
/// ```
/// use catamaran::{faer::Mat, io::{Array, Output, Overwrite, read_arrays, write_arrays}};
///
/// let path = std::env::temp_dir().join(format!("catamaran-arrays-{}.npz", std::process::id()));
/// let (values, vectors) = ([1.0, 2.0], Mat::<f64>::identity(3, 2));
/// let output = Output::create(&path, Overwrite::Replace)?;
/// let matrix = Array::Matrix(vectors.as_ref());
/// write_arrays(output, &[("values", Array::Vector(&values)), ("vectors", matrix)])?;
/// let arrays = read_arrays(&path)?;
/// assert_eq!((arrays.vector("values")?, arrays.matrix("vectors")?), (values.to_vec(), vectors));
/// # std::fs::remove_file(path).unwrap();
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Io`] names the file, and the array that is broken or of another type.
pub fn read_arrays(path: &Path) -> Result<Arrays> {
    read_arrays_with(path, &SourceOptions::new())
}

/// Reads as [`read_arrays`] does, within a limit of memory, and reports the fraction of the arrays
/// read to a callback that may cancel.
///
/// ```
/// use catamaran::io::{Array, Output, Overwrite, SourceOptions, read_arrays_with, write_arrays};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("a.npz");
/// let output = Output::create(path, Overwrite::Never)?;
/// write_arrays(output, &[("values", Array::Vector(&[0.0; 100]))])?;
/// assert!(read_arrays_with(path, &SourceOptions::new().max_memory(64)).is_err());
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`read_arrays`]; [`Error::Io`] when all arrays take more than the limit,
/// [`Error::Cancelled`].
pub fn read_arrays_with(path: &Path, options: &SourceOptions<'_>) -> Result<Arrays> {
    let mut total = 0_u64;
    let mut begin = |i: usize, count: usize, bytes: u64| {
        options.progress.report(i as f64 / count as f64)?;
        total = total.saturating_add(bytes);
        options.check_memory(path, "all its arrays", total)
    };
    let arrays = match ArraysFormat::of(path)? {
        ArraysFormat::Npz => read_npz(path, &mut begin)?,
        #[cfg(feature = "hdf5")]
        ArraysFormat::Hdf5 => super::hdf5::read(path, &mut begin)?,
    };
    for (name, Stored { shape, .. }) in &arrays {
        let bytes = padded_bytes(shape, size_of::<f64>())
            .map_err(|what| error(path, None, format!("`{name}`: {what}")))?;
        // An array without entries is checked too: its rows or columns are created one by one.
        let shape = tuple(shape);
        let what = format_args!("`{name}` of shape {shape}, where 0 counts as 1,");
        options.check_memory(path, what, bytes as u64)?;
    }
    Ok(Arrays { path: path.into(), arrays })
}

impl Arrays {
    /// Returns the names, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.arrays.keys().map(String::as_str)
    }

    /// Returns the one-dimensional array of numbers with this name.
    ///
    /// # Errors
    /// [`Error::Io`] when there is none.
    pub fn vector(&self, name: &str) -> Result<Vec<f64>> {
        match self.stored(name)? {
            Stored { shape, entries: Entries::Numbers(values), .. } if shape.len() == 1 => {
                Ok(values.clone())
            }
            stored => Err(self.other(name, "a vector of numbers", stored)),
        }
    }

    /// Returns the one-dimensional array of unsigned integers with this name.
    ///
    /// # Errors
    /// [`Error::Io`] when there is none, or a number in it is too large for this machine.
    pub fn indices(&self, name: &str) -> Result<Vec<usize>> {
        match self.stored(name)? {
            Stored { shape, entries: Entries::Indices(values), .. } if shape.len() == 1 => values
                .iter()
                .map(|&value| usize::try_from(value))
                .collect::<std::result::Result<_, _>>()
                .map_err(|_| error(&self.path, None, format!("`{name}`: a number is too large"))),
            stored => Err(self.other(name, "a vector of unsigned integers", stored)),
        }
    }

    /// Returns the two-dimensional array of numbers with this name.
    ///
    /// # Errors
    /// [`Error::Io`] when there is none.
    pub fn matrix(&self, name: &str) -> Result<Mat<f64>> {
        let stored = self.stored(name)?;
        let (Entries::Numbers(values), &[rows, columns]) = (&stored.entries, &stored.shape[..])
        else {
            return Err(self.other(name, "a matrix of numbers", stored));
        };
        let at = |i: usize, j: usize| match stored.by_columns {
            true => values[j * rows + i],
            false => values[i * columns + j],
        };
        Ok(Mat::from_fn(rows, columns, at))
    }

    fn stored(&self, name: &str) -> Result<&Stored> {
        self.arrays
            .get(name)
            .ok_or_else(|| error(&self.path, None, format!("has no array `{name}`")))
    }

    fn other(&self, name: &str, wanted: &str, stored: &Stored) -> Error {
        let kind = match stored.entries {
            Entries::Numbers(_) => "numbers",
            Entries::Indices(_) => "unsigned integers",
        };
        let why = format!("`{name}` is not {wanted}, but {kind} of shape {:?}", stored.shape);
        error(&self.path, None, why)
    }
}

fn read_npz(path: &Path, begin: Begin<'_>) -> Result<BTreeMap<String, Stored>> {
    let fail = |e: &dyn std::fmt::Display| error(path, None, e.to_string());
    let file = File::open(path).map_err(|e| error_at(path, None, e))?;
    let mut archive = zip::ZipArchive::new(BufReader::new(file)).map_err(|e| fail(&plain(e)))?;
    let mut arrays = BTreeMap::new();
    for i in 0..archive.len() {
        let count = archive.len();
        let mut entry = archive.by_index(i).map_err(|e| fail(&plain(e)))?;
        let name = array_name(&entry.name().map_err(|e| fail(&plain(e)))?).to_owned();
        let size = entry.size();
        begin(i, count, size)?;
        let mut content = reserved(usize::try_from(size).map_err(|e| fail(&e))?)?;
        // One byte more than announced, so that the content of a wrong size is not all unpacked.
        let read = entry.by_ref().take(size.saturating_add(1)).read_to_end(&mut content);
        read.map_err(|e| fail(&format!("`{name}`: {}", plain(e.into()))))?;
        if content.len() as u64 > size {
            return Err(fail(&format!("`{name}`: more than the {size} bytes that are announced")));
        }
        let stored = decode(&content).map_err(|e| fail(&format!("`{name}`: {e}")))?;
        arrays.insert(name, stored);
    }
    Ok(arrays)
}

/// Returns the error of an archive in words of this crate; that of a disk stays.
fn plain(e: ZipError) -> io::Error {
    match e {
        ZipError::Io(e) if e.raw_os_error().is_some() => e,
        ZipError::Io(e) if e.kind() == io::ErrorKind::UnexpectedEof => packing::truncated(),
        ZipError::UnsupportedArchive(_)
        | ZipError::CompressionMethodNotSupported(_)
        | ZipError::InvalidPassword => io::Error::other(
            "is packed or encrypted in a way that is not supported; numpy.savez writes others",
        ),
        _ => io::Error::other("damaged or truncated .npz file: it can't be unpacked"),
    }
}

fn decode(content: &[u8]) -> io::Result<Stored> {
    let mut rest = content;
    let header = npy_header::read(&mut rest)?;
    let Some((entry @ (Entry::F8 | Entry::U8), big)) = Entry::of(&header.descr) else {
        return Err(io::Error::other(header.refusal("numbers (f8) or unsigned integers (u8)")));
    };
    // A header can't make more memory be allocated than the file has bytes.
    let (bytes, remainder) = rest.as_chunks::<8>();
    if bytes.len() < header.len {
        return Err(io::Error::other(truncated(header.len)));
    }
    if bytes.len() > header.len || !remainder.is_empty() {
        return Err(io::Error::other(trailing(header.len)));
    }
    let entries = match (entry, big) {
        (Entry::U8, false) => Entries::Indices(values(bytes, u64::from_le_bytes)?),
        (Entry::U8, true) => Entries::Indices(values(bytes, u64::from_be_bytes)?),
        (_, false) => Entries::Numbers(values(bytes, f64::from_le_bytes)?),
        (_, true) => Entries::Numbers(values(bytes, f64::from_be_bytes)?),
    };
    Ok(Stored { shape: header.shape, entries, by_columns: header.by_columns })
}

fn values<T>(bytes: &[[u8; 8]], value: fn([u8; 8]) -> T) -> io::Result<Vec<T>> {
    let mut values = reserved(bytes.len()).map_err(io::Error::other)?;
    values.extend(bytes.iter().map(|&entry| value(entry)));
    Ok(values)
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use faer::mat;
    use zip::CompressionMethod;
    use zip::write::SimpleFileOptions;

    use super::*;
    use crate::io::tests::npy;
    use crate::io::{Array, ArraysWriter, Output, Overwrite};

    #[test]
    fn what_was_written_is_read_in_every_format() {
        let folder = tempfile::tempdir().unwrap();
        let names = ["a.npz", "a.h5"];
        for name in &names[..if cfg!(feature = "hdf5") { 2 } else { 1 }] {
            let path = folder.path().join(name);
            let matrix = mat![[1.0, 2.5, -1.0], [3.0, -4.0, f64::MAX]];
            let output = Output::create(&path, Overwrite::Never).unwrap();
            let mut writer = ArraysWriter::new(output).unwrap();
            writer.array("v", Array::Vector(&[0.5, -0.0])).unwrap();
            writer.array("i", Array::Indices(&[7, usize::MAX])).unwrap();
            writer.array("none", Array::Indices(&[])).unwrap();
            writer.array("m", Array::Matrix(matrix.as_ref())).unwrap();
            writer.matrix_by_columns("c", 2, 3).unwrap();
            writer.columns(matrix.as_ref()).unwrap();
            writer.finish().unwrap();
            let read = read_arrays(&path).unwrap();
            assert_eq!(read.names().collect::<Vec<_>>(), ["c", "i", "m", "none", "v"]);
            assert_eq!(read.vector("v").unwrap(), [0.5, -0.0]);
            assert_eq!(read.indices("i").unwrap(), [7, usize::MAX]);
            assert_eq!(read.indices("none").unwrap(), [0; 0]);
            assert_eq!(read.matrix("m").unwrap(), matrix);
            assert_eq!(read.matrix("c").unwrap(), matrix);
            let said = read.matrix("v").unwrap_err().to_string();
            assert!(said.contains("`v` is not a matrix"), "{said}");
            let said = read.vector("w").unwrap_err().to_string();
            assert!(said.contains("has no array `w`"), "{said}");
        }
    }

    #[test]
    fn names_of_arrays_may_end_as_those_of_files_do() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npz");
        let output = Output::create(&path, Overwrite::Never).unwrap();
        let mut writer = ArraysWriter::new(output).unwrap();
        writer.array("x", Array::Vector(&[1.0])).unwrap();
        writer.array("x.npy", Array::Vector(&[2.0])).unwrap();
        writer.finish().unwrap();
        let read = read_arrays(&path).unwrap();
        assert_eq!(read.names().collect::<Vec<_>>(), ["x", "x.npy"]);
        assert_eq!(read.vector("x").unwrap(), [1.0]);
        assert_eq!(read.vector("x.npy").unwrap(), [2.0]);
    }

    #[test]
    fn missing_files_are_named_with_the_cause() {
        let folder = tempfile::tempdir().unwrap();
        for name in &["a.npz", "a.h5"][..if cfg!(feature = "hdf5") { 2 } else { 1 }] {
            let path = folder.path().join(name);
            match read_arrays(&path).unwrap_err() {
                Error::Io { path: named, line: None, what, cause } => {
                    assert_eq!((named, &what[..]), (path, "no such file"));
                    assert!(cause.is_some(), "{name}");
                }
                other => panic!("{other:?}"),
            }
        }
    }

    #[test]
    fn compressed_arrays_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npz");
        let mut archive = zip::ZipWriter::new(File::create(&path).unwrap());
        // As `numpy.savez_compressed` writes them.
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
        archive.start_file("v.npy", options).unwrap();
        archive.write_all(&npy("<f8", "False", "(1000,)", &[0; 8000])).unwrap();
        archive.finish().unwrap();
        assert!(std::fs::metadata(&path).unwrap().len() < 1000);
        assert_eq!(read_arrays(&path).unwrap().vector("v").unwrap(), [0.0; 1000]);
    }

    #[test]
    fn truncated_files_and_other_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npz");
        let output = Output::create(&path, Overwrite::Never).unwrap();
        let mut writer = ArraysWriter::new(output).unwrap();
        writer.array("v", Array::Vector(&[0.5; 100])).unwrap();
        writer.finish().unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let refused = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            let error = read_arrays(&path).unwrap_err();
            assert!(matches!(error, Error::Io { .. }));
            error.to_string()
        };
        for length in (0..bytes.len()).step_by(50) {
            let error = refused(&bytes[..length]);
            let ends = ["damaged or truncated .npz file: it can't be unpacked", "ends too early"];
            assert!(ends.iter().any(|end| error.ends_with(end)), "{error}");
        }
        // The array itself, whose checksum differs then.
        let mut damaged = bytes.clone();
        damaged[bytes.len() / 2] ^= 1;
        let error = refused(&damaged);
        assert!(error.ends_with("`v`: damaged or truncated .npz file: it can't be unpacked"));
        assert!(read_arrays(&folder.path().join("a.txt")).is_err());
    }

    #[test]
    fn headers_of_arrays_that_announce_too_much_are_refused() {
        let shape =
            "{'descr': '<f8', 'fortran_order': False, 'shape': (9999999999, 9999999999), }\n";
        let mut product = b"\x93NUMPY\x01\x00".to_vec();
        product.extend((shape.len() as u16).to_le_bytes());
        product.extend(shape.as_bytes());
        let long = b"\x93NUMPY\x02\x00\xff\xff\xff\x7f{";
        for (content, expected) in [(&product[..], "too large"), (&long[..], "2147483647 bytes")] {
            let said = decode(content).unwrap_err().to_string();
            assert!(said.contains(expected), "{said}");
        }
    }

    #[test]
    fn arrays_without_entries_are_refused_when_their_loops_would_not_end() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npz");
        let write = |shape: &str| {
            let mut archive = zip::ZipWriter::new(File::create(&path).unwrap());
            archive.start_file("m.npy", SimpleFileOptions::default()).unwrap();
            archive.write_all(&npy("<f8", "False", shape, &[])).unwrap();
            archive.finish().unwrap();
        };
        for (shape, why) in [
            ("(2305843009213693952, 0)", "`m`: shape too large: (2305843009213693952, 0)"),
            ("(0, 9223372036854775808)", "`m`: shape too large: (0, 9223372036854775808)"),
            ("(0, 4000000000)", "`m` of shape (0, 4000000000), where 0 counts as 1, would take 29"),
            ("(4000000000, 0)", "`m` of shape (4000000000, 0), where 0 counts as 1, would take 29"),
        ] {
            write(shape);
            let said = read_arrays(&path).unwrap_err().to_string();
            assert!(said.contains("a.npz: ") && said.contains(why), "{said}");
        }
        for (shape, expected) in [("(0, 1000)", (0, 1000)), ("(1000, 0)", (1000, 0))] {
            write(shape);
            assert_eq!(read_arrays(&path).unwrap().matrix("m").unwrap().shape(), expected);
        }
    }

    #[test]
    fn arrays_of_numpy_come_in_any_order_and_byte_order() {
        let entries = [1.0_f64, -2.5].map(f64::to_be_bytes).concat();
        let stored = decode(&npy(">f8", "True", "(1, 2L)", &entries)).unwrap();
        assert_eq!((stored.shape, stored.by_columns), (vec![1, 2], true));
        assert!(matches!(stored.entries, Entries::Numbers(values) if values == [1.0, -2.5]));
        let entries = [7, u64::MAX].map(u64::to_be_bytes).concat();
        let stored = decode(&npy(">u8", "False", "(2,)", &entries)).unwrap();
        assert_eq!((stored.shape, stored.by_columns), (vec![2], false));
        assert!(matches!(stored.entries, Entries::Indices(values) if values == [7, u64::MAX]));
    }

    #[test]
    fn arrays_of_other_types_and_lengths_are_refused() {
        for (content, expected) in [
            (npy("<i8", "False", "(1,)", &[0; 8]), "type '<i8' are not numbers (f8) or unsigned"),
            (npy("<f4", "False", "(2,)", &[0; 8]), "type '<f4' are not numbers (f8) or unsigned"),
            (npy("<f8", "False", "(2,)", &[0; 15]), "truncated: fewer than the 2 entries"),
            (npy("<f8", "False", "(2,)", &[0; 17]), "data after the 2 entries"),
            (npy("<u8", "False", "(2,)", &[0; 24]), "data after the 2 entries"),
        ] {
            let said = decode(&content).unwrap_err().to_string();
            assert!(said.contains(expected), "{said}");
        }
    }

    #[cfg(feature = "hdf5")]
    #[test]
    fn entries_that_are_only_announced_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.h5");
        let file = ::hdf5::File::create(&path).unwrap();
        let dataset = file.new_dataset::<f64>().chunk(1024).shape(1usize << 40);
        dataset.create("v").unwrap();
        file.close().unwrap();
        assert!(path.metadata().unwrap().len() < 10_000);
        let said = read_arrays(&path).unwrap_err().to_string();
        assert!(said.contains("8192.00 GiB"), "{said}");
    }
}
