//! Matrix files: NumPy `.npy`, MatrixMarket `.mtx` and text tables (`.csv`, `.tsv`, `.txt`), each
//! also gzipped (`.gz`); several arrays in one NumPy `.npz` or HDF5 file ([`write_arrays`],
//! [`read_arrays()`]). Files of rows, read block by block ([`RowFile`]): `.npy`, and HDF5 with
//! feature `hdf5`.
//!
//! A reader checks everything it reads: a broken header, a ragged row, text where a number should
//! be, a truncated file and trailing data are errors that name the file and, in text, the line. A
//! writer makes its file appear whole or not at all ([`Output`]).

mod accumulator;
mod arrays;
mod columns;
mod csv;
mod extents;
#[cfg(feature = "hdf5")]
mod hdf5;
mod limits;
mod matrix;
mod mtx;
mod names;
mod npy;
mod npy_header;
mod npz;
mod output;
mod read_arrays;
mod rows;
mod source;
mod stored;
mod strips;
#[cfg(test)]
mod tests;
mod unwritten;
mod xz;

use std::ops::Range;
use std::path::Path;

#[cfg(feature = "hdf5")]
pub use self::hdf5::hdf5_version;
pub use accumulator::{accumulator_scalar, read_accumulator, write_accumulator};
pub use arrays::{ArraysWriter, check_arrays_name, write_arrays};
use faer::MatRef;
pub use limits::SourceOptions;
pub use matrix::{Dense, Matrix, SparseRows};
pub use npz::{Array, NpzWriter, write_npz};
pub use output::{Output, Overwrite, discard_unfinished, try_discard_unfinished};
pub use read_arrays::{Arrays, read_arrays, read_arrays_with};
pub use rows::RowFile;
/// The sparse matrix of [`Matrix::Sparse`], from crate sprs.
pub use sprs::CsMat;
pub use strips::StripOutput;

// For the other crates of this workspace: no part of the interface.
#[doc(hidden)]
pub use accumulator::accumulator_labels;
#[doc(hidden)]
pub use limits::LARGER_MAX_MEMORY;
#[doc(hidden)]
pub use source::{Packing, Source};

use self::names::MatrixFormat;
use crate::base::{Progress, Real, Result, options};

options! {
    /// How [`read`] reads. The default reads everything.
    ///
    /// ```
    /// use catamaran::io::{ReadOptions, read};
    ///
    /// # let folder = tempfile::tempdir().unwrap();
    /// # let path = &folder.path().join("a.csv");
    /// std::fs::write(path, "1,2,text\n3,4,text\n").unwrap();
    /// let a = read(path, &ReadOptions::new().columns(0..2).max_memory(1_000_000))?;
    /// assert_eq!((a.nrows(), a.ncols()), (2, 2));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    #[derive(Debug, Clone)]
    pub struct ReadOptions<'a> {
        /// Columns to keep, from 0, half open; `None` keeps all. In a text table the others may
        /// hold anything.
        columns: Option<Range<usize>> = None, setter into;
        /// As [`SourceOptions::max_memory`]: of the entries, too. It also bounds the size of the
        /// file, whichever columns are kept.
        max_memory: Option<u64> = None, setter into;
        /// Receives the fraction of the file that has been read; may cancel.
        progress: Progress<'a> = Progress::none(), setter into;
    }
}

/// Reads the matrix in the file at `path`, in the format of its name.
///
/// - `.npy`: two dimensions, or one (a vector, read as a column), either order. f4 stays f32; f8
///   and integers become f64 (integers beyond 2^53 are rounded).
/// - `.mtx`: `array` becomes a dense f64 matrix, `coordinate` a sparse one; `real`, `integer` and
///   `pattern` (ones); `general`, `symmetric`, `skew-symmetric`. Repeated coordinates are summed.
/// - `.csv`, `.tsv`, `.txt`: f64, split at tabs, semicolons, commas or runs of blanks, whichever of
///   these the first line holds first in this order. Lines that start with `#` and empty lines are
///   skipped. A first line without any number is a header. At least one row of numbers
///   must be there.
///
/// A file may take as much memory as `options.max_memory` says. A file whose header announces more
/// is rejected before the memory is allocated.
///
/// The extra memory beyond the entries of the file is a buffer; text tables, whose size is not
/// known beforehand, may take twice their entries while they grow, and sparse matrices twice
/// theirs.
///
/// ```
/// use catamaran::{faer::Mat, io::{Matrix, Output, Overwrite, ReadOptions, read, write}};
///
/// let path = std::env::temp_dir().join(format!("catamaran-read-{}.csv", std::process::id()));
/// let a = Mat::<f64>::from_fn(3, 2, |i, j| i as f64 - j as f64 / 3.0);
/// write(Output::create(&path, Overwrite::Replace)?, a.as_ref())?;
/// let Matrix::F64(found) = read(&path, &ReadOptions::new().columns(1..2))? else { panic!() };
/// assert_eq!(found.as_ref(), a.get(.., 1..2));
/// # std::fs::remove_file(path).unwrap();
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Io`](crate::Error::Io) with file and line, [`Error::OutOfMemory`](crate::Error),
/// [`Error::Cancelled`](crate::Error); [`Error::Argument`](crate::Error::Argument) when
/// `options.columns` is not inside the matrix.
pub fn read(path: &Path, options: &ReadOptions<'_>) -> Result<Matrix> {
    Ok(read_with_names(path, options)?.0)
}

/// Reads the matrix in the file at `path` as [`read`] does, and the names of its columns: those in
/// the header of a text table, without blanks and quotes around them. There are none in other
/// formats, without a header, and when the header has another number of fields than the rows.
///
/// ```
/// use catamaran::io::{ReadOptions, read_with_names};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("a.csv");
/// std::fs::write(path, "age, \"height\"\n3,0.9\n7,1.2\n").unwrap();
/// let (a, names) = read_with_names(path, &ReadOptions::new())?;
/// assert_eq!((a.nrows(), names), (2, vec!["age".to_owned(), "height".to_owned()]));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`read`].
pub fn read_with_names(path: &Path, options: &ReadOptions<'_>) -> Result<(Matrix, Vec<String>)> {
    let (format, gzipped) = MatrixFormat::of(path)?;
    let packing = if gzipped { Packing::Gzip } else { Packing::None };
    let ReadOptions { max_memory, progress, .. } = *options;
    let mut source = Source::open(path, packing, &SourceOptions { max_memory, progress })?;
    match format {
        MatrixFormat::Npy => Ok((npy::read(&mut source, options.columns.as_ref())?, Vec::new())),
        MatrixFormat::Mtx => Ok((mtx::read(&mut source, options.columns.as_ref())?, Vec::new())),
        MatrixFormat::Table(_) => csv::read(&mut source, options.columns.as_ref()),
        #[cfg(feature = "hdf5")]
        MatrixFormat::Hdf5 => Err(source.fail("HDF5 is read by rows (RowFile)")),
    }
}

/// Writes `matrix` (any shape and strides) into `output`, in the format of its name, and lets it
/// appear: `.npy` in C order and the precision of T, `.mtx` as a general real array, text tables
/// with commas (tabs in `.tsv`, blanks in `.txt`) and enough digits to read the same number back;
/// HDF5 (`.h5`, `.hdf5`, `.he5`, feature `hdf5`) with the dataset `/matrix`.
///
/// ```
/// use catamaran::{faer::mat, io::{Output, Overwrite, write}};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("a.csv");
/// write(Output::create(path, Overwrite::Never)?, mat![[1.0, 0.5], [2.0, -3.0]].as_ref())?;
/// assert_eq!(std::fs::read_to_string(path).unwrap(), "1.0,0.5\n2.0,-3.0\n");
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Io`](crate::Error::Io); no file is left behind then.
pub fn write<T: Real>(output: Output, matrix: MatRef<'_, T>) -> Result<()> {
    #[cfg(feature = "hdf5")]
    if MatrixFormat::of(output.path())?.0 == MatrixFormat::Hdf5 {
        return self::hdf5::write_matrix(output, matrix);
    }
    write_with(output, |sink, format| match format {
        MatrixFormat::Npy => npy::write(sink, matrix),
        MatrixFormat::Mtx => mtx::write(sink, matrix, "real"),
        MatrixFormat::Table(separator) => csv::write(sink, matrix, separator),
        #[cfg(feature = "hdf5")]
        MatrixFormat::Hdf5 => Err(std::io::Error::other("HDF5 is not written as a stream")),
    })
}

/// Writes integers, such as numbers of vertices, as [`write()`] writes real numbers: `.npy` with
/// entries of type i8 (64 bits), `.mtx` as a general integer array, text tables without a decimal
/// point.
///
/// ```
/// use catamaran::{faer::mat, io::{Output, Overwrite, write_integers}};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("a.csv");
/// write_integers(Output::create(path, Overwrite::Never)?, mat![[1, -1], [3250, 0]].as_ref())?;
/// assert_eq!(std::fs::read_to_string(path).unwrap(), "1,-1\n3250,0\n");
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Io`](crate::Error::Io); no file is left behind then.
pub fn write_integers(output: Output, matrix: MatRef<'_, i64>) -> Result<()> {
    #[cfg(feature = "hdf5")]
    if MatrixFormat::of(output.path())?.0 == MatrixFormat::Hdf5 {
        return self::hdf5::write_integers(output, matrix);
    }
    write_with(output, |sink, format| match format {
        MatrixFormat::Npy => npy::write_integers(sink, matrix),
        MatrixFormat::Mtx => mtx::write(sink, matrix, "integer"),
        MatrixFormat::Table(separator) => csv::write(sink, matrix, separator),
        #[cfg(feature = "hdf5")]
        MatrixFormat::Hdf5 => Err(std::io::Error::other("HDF5 is not written as a stream")),
    })
}

/// Lets the file appear once `body` has written its content in the format of its name.
fn write_with(
    mut output: Output,
    body: impl Fn(&mut dyn std::io::Write, MatrixFormat) -> std::io::Result<()>,
) -> Result<()> {
    let (format, gzipped) = MatrixFormat::of(output.path())?;
    let written = if gzipped {
        let mut encoder =
            flate2::write::GzEncoder::new(&mut output, flate2::Compression::default());
        body(&mut encoder, format).and_then(|()| encoder.finish().map(|_| ()))
    } else {
        body(&mut output, format)
    };
    written.map_err(|e| output.error(e))?;
    output.commit()
}

/// Checks that [`read`] and [`write()`] know the format that this file name ends in.
///
/// ```
/// use catamaran::io::check_name;
///
/// assert!(check_name("a.npy".as_ref()).is_ok());
/// assert!(check_name("a.doc".as_ref()).is_err());
/// ```
///
/// # Errors
/// [`Error::Io`](crate::Error::Io) when they do not.
pub fn check_name(path: &Path) -> Result<()> {
    MatrixFormat::of(path).map(|_| ())
}
