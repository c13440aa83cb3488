//! Matrix files: NumPy `.npy`, MatrixMarket `.mtx` and text tables (`.csv`, `.tsv`, `.txt`), each
//! also packed (`.gz`, `.xz`, `.bz2`, `.zip`); several arrays in one NumPy `.npz` or HDF5 file
//! ([`write_arrays`], [`read_arrays()`]). Files of rows, read block by block ([`RowFile`]): `.npy`,
//! and HDF5 with feature `hdf5`. Parquet, Arrow and `.zst` files with feature `columnar`.
//!
//! A reader checks everything it reads: a broken header, a ragged row, text where a number should
//! be, a truncated file and trailing data are errors that name the file and, in text, the line. A
//! writer makes its file appear whole or not at all ([`Output`]).

mod accumulator;
mod archive;
mod arrays;
mod bz2;
#[cfg(feature = "columnar")]
mod columnar;
mod columns;
mod extents;
mod gzip;
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
mod packing;
mod read_arrays;
mod read_options;
mod rounding;
mod rows;
mod source;
mod stored;
mod strips;
mod table;
mod table_file;
#[cfg(test)]
mod tests;
mod unwritten;
mod xz;
mod zipped;
#[cfg(feature = "columnar")]
mod zstd;

use std::path::Path;

#[cfg(feature = "hdf5")]
pub use self::hdf5::hdf5_version;
pub use accumulator::{accumulator_scalar, read_accumulator, write_accumulator};
pub use arrays::{ArraysWriter, check_arrays_name, write_arrays};
pub use columns::Columns;
use faer::{MatRef, c64};
pub use limits::SourceOptions;
pub use matrix::{Dense, Matrix, SparseRows};
pub use names::FileFormat;
pub use npz::{Array, NpzWriter, write_npz};
pub use output::{Output, Overwrite, discard_unfinished, try_discard_unfinished};
pub use read_arrays::{Arrays, read_arrays, read_arrays_with};
pub use read_options::ReadOptions;
pub use rounding::RoundedIntegers;
pub use rows::RowFile;
/// The sparse matrix of [`Matrix::Sparse`], from crate sprs.
pub use sprs::CsMat;
pub use strips::StripOutput;
pub use table::{ColumnKind, Missing, Separator, TableColumn, TableOptions, TableReading, Words};
pub use table_file::TableFile;

// For the other crates of this workspace: no part of the interface.
#[doc(hidden)]
pub use accumulator::accumulator_labels;
#[doc(hidden)]
pub use limits::LARGER_MAX_MEMORY;
#[doc(hidden)]
pub use packing::Packing;
#[doc(hidden)]
pub use source::Source;
#[doc(hidden)]
pub use xz::unxz;

use self::columns::ColumnNumbers;
use self::names::MatrixFormat;
use crate::base::{Error, Real, Result};

/// A matrix that was read, and what is known about its columns.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct FileContent {
    /// The matrix.
    pub matrix: Matrix,
    /// The names of its columns, in the header of a text table or in a columnar file; none
    /// elsewhere.
    pub names: Vec<String>,
    /// How the text table or columnar file was read; `None` for other formats.
    pub reading: Option<TableReading>,
    /// The integers of an array or of MatrixMarket that were rounded; `None` where there are none,
    /// and for tables, whose `reading` has them.
    pub rounded: Option<RoundedIntegers>,
    numbers: ColumnNumbers,
}

impl FileContent {
    /// Returns the number that a column of the matrix has in the file, from 0.
    pub fn number(&self, column: usize) -> usize {
        self.numbers.of(column)
    }
}

/// Reads the matrix in the file at `path`, in the format of its name.
///
/// - `.npy`: two dimensions, or one (a vector, read as a column), either order. f4 stays f32; f2,
///   f8, f16 (the long double of x86), b1 and integers become f64 (rounded beyond 53 bits), c8 and
///   c16 complex numbers.
/// - `.mtx`: `array` becomes a dense f64 matrix, `coordinate` a sparse one; `real`, `integer` and
///   `pattern` (ones); `general`, `symmetric`, `skew-symmetric`, with one triangle, be it the lower
///   or the upper one. Repeated coordinates are summed. `complex`, also `hermitian`, becomes a
///   dense complex matrix.
/// - `.csv`, `.tsv`, `.txt`: f64. Separators, the notation of numbers and whether there is a header
///   are found as [`TableOptions`] says; [`read_file`] returns what was found. Lines that start
///   with `#` and empty lines are skipped, columns of words are left out, and a missing cell is an
///   error ([`Missing`]). At least one row of numbers must be there.
/// - `.parquet`, `.pq`, and Arrow's IPC format in `.arrow`, `.feather`, `.ipc` (feature
///   `columnar`): f64. Columns have names; those of numbers, truth values and decimals are read,
///   words are factors ([`Words::Factor`]) or left out, and all others are left out. A null is a
///   missing cell, and so is NaN.
/// - `.npz`, packed or not: the array `FILE.npz:NAME`, or `FILE.npz` with one array or a sparse
///   matrix as `scipy.sparse.save_npz` writes it.
///
/// Other names leave the format to the content, and so does the name of a text for a binary file.
/// The names may have `.gz`, `.xz`, `.bz2`, `.zst` (feature `columnar`) or `.zip`, of an archive of
/// one file, after them; whether a file is packed, its content says.
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
/// [`Error::Io`] with file and line, and with the option that decides where a
/// text table has several readings; [`Error::OutOfMemory`](crate::Error),
/// [`Error::Cancelled`](crate::Error); [`Error::Argument`] when
/// `options.columns` is not inside the matrix, or an option of a table is out of its range. An
/// option of tables that does not apply to the format of the file is an [`Error::Io`], too.
pub fn read(path: &Path, options: &ReadOptions<'_>) -> Result<Matrix> {
    Ok(read_file(path, options)?.matrix)
}

/// Reads the matrix in the file at `path` as [`read`] does, the names and numbers of its columns,
/// and how a text table or columnar file was read.
///
/// ```
/// use catamaran::io::{ReadOptions, read_file};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("a.csv");
/// std::fs::write(path, "name, age, \"height\"\nann,3,0.9\nbob,7,1.2\n").unwrap();
/// let content = read_file(path, &ReadOptions::new())?;
/// assert_eq!((content.matrix.nrows(), content.number(0)), (2, 1));
/// assert_eq!(content.names, ["age", "height"]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`read`].
pub fn read_file(path: &Path, options: &ReadOptions<'_>) -> Result<FileContent> {
    read_checked(path, options, |format| options.check_effects(path, &[format], false))
}

/// Reads as [`read_file`] does one of several files that have the same options: those of tables
/// that do not apply to it are no error. For the command line.
#[doc(hidden)]
pub fn read_one_of_several(path: &Path, options: &ReadOptions<'_>) -> Result<FileContent> {
    read_checked(path, options, |_| Ok(()))
}

/// Reads a file after a check of the options for its format; `None` is an array.
fn read_checked(
    path: &Path,
    options: &ReadOptions<'_>,
    check: impl Fn(Option<FileFormat>) -> Result<()>,
) -> Result<FileContent> {
    let ReadOptions { max_memory, progress, .. } = *options;
    let source_options = SourceOptions { max_memory, progress };
    let columns = &options.columns;
    if let Some((file, name)) = names::npz_array(path).filter(|_| options.format.is_none()) {
        options.check_array(path)?;
        check(None)?;
        let (matrix, rounded) = archive::read(&file, name, &source_options, columns)?;
        let (matrix, numbers) = matrix.choose(columns)?;
        return Ok(FileContent { matrix, names: Vec::new(), numbers, reading: None, rounded });
    }
    let (mut source, format) = FileFormat::open(path, options.format, &source_options)?;
    let content = |(dense, reading): (Dense<f64>, TableReading)| {
        let numbers = reading.columns.iter().map(|column| column.number).collect();
        let numbers = ColumnNumbers::List(numbers);
        let (matrix, names) = (Matrix::F64(dense), reading.names());
        Ok(FileContent { matrix, names, numbers, reading: Some(reading), rounded: None })
    };
    let (matrix, rounded) = match format {
        FileFormat::Npy | FileFormat::Mtx => {
            options.check_array(path)?;
            check(None)?;
            match format {
                FileFormat::Npy => npy::read(&mut source, columns)?,
                _ => mtx::read(&mut source, columns)?,
            }
        }
        FileFormat::Table => return content(table::read(&mut source, &options.table, columns)?),
        FileFormat::Parquet | FileFormat::Arrow => {
            check(Some(format))?;
            if source.packing() != Packing::None {
                let what = "packed, so that its end can't be read first: unpack it first";
                return Err(source.fail(what));
            }
            return content(TableFile::read_columnar(path, format, options)?);
        }
    };
    let (matrix, numbers) = matrix.select(columns)?;
    Ok(FileContent { matrix, names: Vec::new(), numbers, reading: None, rounded })
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
/// [`Error::Io`]; no file is left behind then.
pub fn write<T: Real>(output: Output, matrix: MatRef<'_, T>) -> Result<()> {
    #[cfg(feature = "hdf5")]
    if MatrixFormat::of(output.path())?.0 == MatrixFormat::Hdf5 {
        return hdf5::write_matrix(output, matrix);
    }
    write_with(output, |sink, format| match format {
        MatrixFormat::Npy => npy::write(sink, matrix),
        MatrixFormat::Mtx => mtx::write(sink, matrix, "real"),
        MatrixFormat::Table(separator) => table::write(sink, matrix, separator),
        #[cfg(feature = "hdf5")]
        MatrixFormat::Hdf5 => Err(std::io::Error::other("HDF5 is not written as a stream")),
    })
}

/// Writes a complex `matrix` (any shape and strides) into `output`, in the format of its name, and
/// lets it appear: `.npy` in C order with entries of type c16, `.mtx` as a general complex array.
///
/// ```
/// use catamaran::faer::{c64, mat};
/// use catamaran::io::{Matrix, Output, Overwrite, ReadOptions, read, write_complex};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("a.mtx");
/// let a = mat![[c64::new(1.0, 2.0)], [c64::new(0.5, 0.0)]];
/// write_complex(Output::create(path, Overwrite::Never)?, a.as_ref())?;
/// let Matrix::Complex(found) = read(path, &ReadOptions::new())? else { panic!("real") };
/// assert_eq!(found.as_ref(), a);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Io`], also where the name ends in that of a text table or of HDF5,
/// which hold real numbers; no file is left behind then.
pub fn write_complex(output: Output, matrix: MatRef<'_, c64>) -> Result<()> {
    check_complex_name(output.path())?;
    write_with(output, |sink, format| match format {
        MatrixFormat::Npy => npy::write_complex(sink, matrix),
        MatrixFormat::Mtx => mtx::write_complex(sink, matrix),
        _ => Err(std::io::Error::other(NO_COMPLEX)),
    })
}

/// Checks that [`write_complex`] knows the format that this file name ends in.
///
/// ```
/// use catamaran::io::check_complex_name;
///
/// assert!(check_complex_name("a.npy".as_ref()).is_ok());
/// assert!(check_complex_name("a.csv".as_ref()).is_err());
/// ```
///
/// # Errors
/// [`Error::Io`] when it does not.
pub fn check_complex_name(path: &Path) -> Result<()> {
    match MatrixFormat::of(path)?.0 {
        MatrixFormat::Npy | MatrixFormat::Mtx => Ok(()),
        _ => Err(Error::file(path, NO_COMPLEX)),
    }
}

/// The error for complex numbers in a file of a format without them.
const NO_COMPLEX: &str = "complex numbers: the name must end in .npy or .mtx";

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
/// [`Error::Io`]; no file is left behind then.
pub fn write_integers(output: Output, matrix: MatRef<'_, i64>) -> Result<()> {
    #[cfg(feature = "hdf5")]
    if MatrixFormat::of(output.path())?.0 == MatrixFormat::Hdf5 {
        return hdf5::write_integers(output, matrix);
    }
    write_with(output, |sink, format| match format {
        MatrixFormat::Npy => npy::write_integers(sink, matrix),
        MatrixFormat::Mtx => mtx::write(sink, matrix, "integer"),
        MatrixFormat::Table(separator) => table::write(sink, matrix, separator),
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

/// Checks that [`write()`] knows the format that this file name ends in; [`read`] knows others too.
///
/// ```
/// use catamaran::io::check_name;
///
/// assert!(check_name("a.npy".as_ref()).is_ok());
/// assert!(check_name("a.doc".as_ref()).is_err());
/// ```
///
/// # Errors
/// [`Error::Io`] when it does not.
pub fn check_name(path: &Path) -> Result<()> {
    MatrixFormat::of(path).map(|_| ())
}
