//! Several arrays in one file, in the format that the file name ends in.

use std::path::Path;

use faer::MatRef;

#[cfg(feature = "hdf5")]
use super::hdf5::Hdf5Writer;
use super::names::ArraysFormat;
use super::npz::{Array, NpzWriter};
use super::output::Output;
use crate::base::Result;

/// Checks that [`write_arrays`] can write a file of this name.
///
/// ```
/// use catamaran::io::check_arrays_name;
///
/// assert!(check_arrays_name("a.npz".as_ref()).is_ok());
/// assert!(check_arrays_name("a.npy".as_ref()).is_err());
/// ```
///
/// # Errors
/// [`Error::Io`](crate::Error::Io) for any other end of the name, and for HDF5 without feature
/// `hdf5`.
pub fn check_arrays_name(path: &Path) -> Result<()> {
    ArraysFormat::of(path).map(drop)
}

/// Writes named arrays into `output`, in the format of its name, and lets it appear: `.npz` as
/// [`write_npz`](super::write_npz); `.h5`, `.hdf5` and `.he5` (feature `hdf5`) with a dataset for
/// each array, of the same name, shape and type.
///
/// ```
/// use catamaran::io::{Array, Output, Overwrite, read_arrays, write_arrays};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("a.npz");
/// let output = Output::create(path, Overwrite::Never)?;
/// let (values, order) = (Array::Vector(&[1.0, 2.0]), Array::Indices(&[1, 0]));
/// write_arrays(output, &[("values", values), ("order", order)])?;
/// let arrays = read_arrays(path)?;
/// assert_eq!(arrays.names().collect::<Vec<_>>(), ["order", "values"]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`check_arrays_name`]; [`Error::Io`](crate::Error::Io), and no file is left behind then.
pub fn write_arrays(output: Output, arrays: &[(&str, Array<'_>)]) -> Result<()> {
    let mut writer = ArraysWriter::new(output)?;
    for (name, array) in arrays {
        writer.array(name, *array)?;
    }
    writer.finish()
}

/// A file as [`write_arrays`] makes it, written array by array. Matrices are written by blocks of
/// columns or of rows, so they may be larger than memory. The file appears with
/// [`ArraysWriter::finish`]; if the writer is dropped before that, no file is left behind.
///
/// ```
/// use catamaran::{faer::Mat, io::{Array, ArraysWriter, Output, Overwrite, read_arrays}};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("a.npz");
/// let a = Mat::<f64>::from_fn(3, 4, |i, j| (4 * i + j) as f64);
/// let mut writer = ArraysWriter::new(Output::create(path, Overwrite::Never)?)?;
/// writer.array("values", Array::Vector(&[1.0, 2.0]))?;
/// writer.matrix_by_columns("a", 3, 4)?;
/// writer.columns(a.subcols(0, 3))?;
/// writer.columns(a.subcols(3, 1))?;
/// writer.finish()?;
/// assert_eq!(read_arrays(path)?.matrix("a")?, a);
/// # Ok::<(), catamaran::Error>(())
/// ```
pub struct ArraysWriter(Writer);

enum Writer {
    Npz(Box<NpzWriter>),
    #[cfg(feature = "hdf5")]
    Hdf5(Hdf5Writer),
}

impl ArraysWriter {
    /// Creates a file without arrays.
    ///
    /// # Errors
    /// As [`check_arrays_name`]; [`Error::Io`](crate::Error::Io).
    pub fn new(output: Output) -> Result<Self> {
        Ok(Self(match ArraysFormat::of(output.path())? {
            ArraysFormat::Npz => Writer::Npz(Box::new(NpzWriter::new(output))),
            #[cfg(feature = "hdf5")]
            ArraysFormat::Hdf5 => Writer::Hdf5(Hdf5Writer::new(output)?),
        }))
    }

    /// Adds an array.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io); [`Error::Shape`](crate::Error::Shape) when columns or rows
    /// of the matrix before are missing.
    pub fn array(&mut self, name: &str, array: Array<'_>) -> Result<()> {
        match &mut self.0 {
            Writer::Npz(writer) => writer.array(name, array),
            #[cfg(feature = "hdf5")]
            Writer::Hdf5(writer) => writer.array(name, array),
        }
    }

    /// Begins a matrix of f8, whose columns follow.
    ///
    /// # Errors
    /// As [`ArraysWriter::array`].
    pub fn matrix_by_columns(&mut self, name: &str, rows: usize, columns: usize) -> Result<()> {
        match &mut self.0 {
            Writer::Npz(writer) => writer.matrix_by_columns(name, rows, columns),
            #[cfg(feature = "hdf5")]
            Writer::Hdf5(writer) => writer.matrix_by_columns(name, rows, columns),
        }
    }

    /// Writes the next columns of the matrix begun by [`ArraysWriter::matrix_by_columns`].
    ///
    /// # Errors
    /// [`Error::Shape`](crate::Error::Shape) when they have other rows, or are more than were
    /// announced; [`Error::Io`](crate::Error::Io).
    pub fn columns(&mut self, columns: MatRef<'_, f64>) -> Result<()> {
        match &mut self.0 {
            Writer::Npz(writer) => writer.columns(columns),
            #[cfg(feature = "hdf5")]
            Writer::Hdf5(writer) => writer.columns(columns),
        }
    }

    /// Begins a matrix of f8, whose rows follow.
    ///
    /// # Errors
    /// As [`ArraysWriter::array`].
    pub fn matrix_by_rows(&mut self, name: &str, rows: usize, columns: usize) -> Result<()> {
        match &mut self.0 {
            Writer::Npz(writer) => writer.matrix_by_rows(name, rows, columns),
            #[cfg(feature = "hdf5")]
            Writer::Hdf5(writer) => writer.matrix_by_rows(name, rows, columns),
        }
    }

    /// Writes the next rows of the matrix begun by [`ArraysWriter::matrix_by_rows`].
    ///
    /// # Errors
    /// [`Error::Shape`](crate::Error::Shape) when they have other columns, or are more than were
    /// announced; [`Error::Io`](crate::Error::Io).
    pub fn rows(&mut self, rows: MatRef<'_, f64>) -> Result<()> {
        match &mut self.0 {
            Writer::Npz(writer) => writer.rows(rows),
            #[cfg(feature = "hdf5")]
            Writer::Hdf5(writer) => writer.rows(rows),
        }
    }

    /// Lets the file appear.
    ///
    /// # Errors
    /// As [`ArraysWriter::array`]; no file is left behind then.
    pub fn finish(self) -> Result<()> {
        match self.0 {
            Writer::Npz(writer) => writer.finish(),
            #[cfg(feature = "hdf5")]
            Writer::Hdf5(writer) => writer.finish(),
        }
    }
}
