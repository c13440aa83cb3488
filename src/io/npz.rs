//! Several arrays in one file, as `numpy.load` reads them: NumPy `.npz`, a zip archive of `.npy`
//! files, not packed.

use std::io::{self, Seek, SeekFrom, Write};
use std::path::PathBuf;

use faer::MatRef;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::output::write_error;
use super::unwritten::Unwritten;
use super::{Output, npy, npy_header};
use crate::base::Result;

/// An array in a file of several arrays.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Array<'a> {
    /// One dimension, f8.
    Vector(&'a [f64]),
    /// One dimension, u8: unsigned integers of 64 bits.
    Indices(&'a [usize]),
    /// Two dimensions in C order, f8.
    Matrix(MatRef<'a, f64>),
}

/// Writes named arrays into `output` and lets it appear.
///
/// ```
/// use catamaran::io::{Array, Output, Overwrite, read_arrays, write_npz};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("a.npz");
/// let output = Output::create(path, Overwrite::Never)?;
/// write_npz(output, &[("indices", Array::Indices(&[3, 5]))])?;
/// assert_eq!(read_arrays(path)?.indices("indices")?, [3, 5]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Io`](crate::Error::Io); no file is left behind then.
pub fn write_npz(output: Output, arrays: &[(&str, Array<'_>)]) -> Result<()> {
    let mut writer = NpzWriter::new(output);
    for (name, array) in arrays {
        writer.array(name, *array)?;
    }
    writer.finish()
}

/// An `.npz` file that is written array by array. Matrices are written by blocks of columns or of
/// rows, so they may be larger than memory. The file appears with [`NpzWriter::finish`]; if the
/// writer is dropped before that, no file is left behind.
///
/// ```
/// use catamaran::{faer::Mat, io::{Array, NpzWriter, Output, Overwrite, read_arrays}};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("a.npz");
/// let a = Mat::<f64>::from_fn(3, 4, |i, j| (4 * i + j) as f64);
/// let mut writer = NpzWriter::new(Output::create(path, Overwrite::Never)?);
/// writer.array("values", Array::Vector(&[1.0, 2.0]))?;
/// writer.matrix_by_columns("a", 3, 4)?;
/// writer.columns(a.subcols(0, 3))?;
/// writer.columns(a.subcols(3, 1))?;
/// writer.finish()?;
/// assert_eq!(read_arrays(path)?.matrix("a")?, a);
/// # Ok::<(), catamaran::Error>(())
/// ```
pub struct NpzWriter {
    archive: ZipWriter<Sink>,
    path: PathBuf,
    /// The matrix that was begun last.
    matrix: Unwritten,
}

/// The destination of the archive. After the first error it discards what is written and reports
/// success: an archive that is dropped still writes its end, and prints to stderr when it can't.
struct Sink {
    output: Output,
    failed: bool,
    /// The position that the archive assumes.
    position: u64,
}

impl Sink {
    fn new(output: Output) -> Self {
        Self { output, failed: false, position: 0 }
    }

    fn finish(self) -> Result<Output> {
        if self.failed {
            return Err(self.output.error(io::Error::other("an earlier write has failed")));
        }
        Ok(self.output)
    }

    /// Remembers that an error has occurred.
    fn noted<T>(&mut self, done: io::Result<T>) -> io::Result<T> {
        self.failed |= done.as_ref().is_err_and(|e| e.kind() != io::ErrorKind::Interrupted);
        done
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = if self.failed { Ok(bytes.len()) } else { self.output.write(bytes) };
        let count = self.noted(written)?;
        self.position += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        let flushed = if self.failed { Ok(()) } else { self.output.flush() };
        self.noted(flushed)
    }
}

impl Seek for Sink {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let there = match to {
            _ if !self.failed => self.output.seek(to),
            SeekFrom::Start(position) => Ok(position),
            SeekFrom::Current(by) | SeekFrom::End(by) => {
                Ok(self.position.saturating_add_signed(by))
            }
        };
        self.position = self.noted(there)?;
        Ok(self.position)
    }
}

impl NpzWriter {
    /// Creates a file without arrays.
    pub fn new(output: Output) -> Self {
        let path = output.path().to_path_buf();
        Self { archive: ZipWriter::new(Sink::new(output)), path, matrix: Unwritten::default() }
    }

    /// Adds an array.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io); [`Error::Shape`](crate::Error::Shape) when columns or rows
    /// of the matrix before are missing.
    pub fn array(&mut self, name: &str, array: Array<'_>) -> Result<()> {
        self.begin(name)?;
        let written = self.write_array(array);
        self.told(written)
    }

    /// Begins a matrix of f8 in Fortran order, whose columns follow.
    ///
    /// # Errors
    /// As [`NpzWriter::array`].
    pub fn matrix_by_columns(&mut self, name: &str, rows: usize, columns: usize) -> Result<()> {
        self.begin_matrix(name, false, rows, columns)
    }

    /// Writes the next columns of the matrix begun by [`NpzWriter::matrix_by_columns`].
    ///
    /// # Errors
    /// [`Error::Shape`](crate::Error::Shape) when they have other rows, or are more than were
    /// announced; [`Error::Io`](crate::Error::Io).
    pub fn columns(&mut self, columns: MatRef<'_, f64>) -> Result<()> {
        self.matrix.check(false, columns.shape())?;
        self.write_columns(columns)
    }

    /// Begins a matrix of f8 in C order, whose rows follow.
    ///
    /// # Errors
    /// As [`NpzWriter::array`].
    pub fn matrix_by_rows(&mut self, name: &str, rows: usize, columns: usize) -> Result<()> {
        self.begin_matrix(name, true, rows, columns)
    }

    /// Writes the next rows of the matrix begun by [`NpzWriter::matrix_by_rows`].
    ///
    /// # Errors
    /// [`Error::Shape`](crate::Error::Shape) when they have other columns, or are more than were
    /// announced; [`Error::Io`](crate::Error::Io).
    pub fn rows(&mut self, rows: MatRef<'_, f64>) -> Result<()> {
        self.matrix.check(true, rows.shape())?;
        self.write_columns(rows.transpose())
    }

    /// Lets the file appear.
    ///
    /// # Errors
    /// As [`NpzWriter::array`]; no file is left behind then.
    pub fn finish(self) -> Result<()> {
        self.matrix.check_end()?;
        let Self { archive, path, .. } = self;
        let sink = archive.finish().map_err(|e| write_error(&path, e.into()))?;
        sink.finish()?.commit()
    }

    fn begin(&mut self, name: &str) -> Result<()> {
        self.matrix.check_end()?;
        // Sizes are known only after all entries have been written.
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .large_file(true);
        let begun = self.archive.start_file(format!("{name}.npy"), options);
        self.told(begun.map_err(io::Error::from))
    }

    fn begin_matrix(
        &mut self,
        name: &str,
        by_rows: bool,
        rows: usize,
        columns: usize,
    ) -> Result<()> {
        self.begin(name)?;
        self.matrix = Unwritten { by_rows, shape: (rows, columns), written: 0 };
        let written = npy_header::write(&mut self.archive, "f8", !by_rows, &[rows, columns]);
        self.told(written)
    }

    /// Writes columns, or rows as columns, one after the other.
    fn write_columns(&mut self, columns: MatRef<'_, f64>) -> Result<()> {
        self.matrix.written += columns.ncols();
        let mut bytes = Vec::new();
        for column in columns.col_iter() {
            bytes.clear();
            npy::encode(column.iter().copied(), &mut bytes);
            let written = self.archive.write_all(&bytes);
            self.told(written)?;
        }
        Ok(())
    }

    fn told(&self, done: io::Result<()>) -> Result<()> {
        done.map_err(|e| write_error(&self.path, e))
    }

    fn write_array(&mut self, array: Array<'_>) -> io::Result<()> {
        let archive = &mut self.archive;
        match array {
            Array::Vector(values) => {
                npy_header::write(archive, "f8", false, &[values.len()])?;
                values.iter().try_for_each(|value| archive.write_all(&value.to_ne_bytes()))
            }
            Array::Indices(values) => {
                npy_header::write(archive, "u8", false, &[values.len()])?;
                values
                    .iter()
                    .try_for_each(|&value| archive.write_all(&(value as u64).to_ne_bytes()))
            }
            Array::Matrix(matrix) => npy::write(archive, matrix),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::io::Read;
    use std::path::Path;

    use faer::mat;

    use super::*;
    use crate::base::Error;
    use crate::io::Overwrite;

    /// Returns the header of an array, without the blanks at its end, and its entries.
    fn array(path: &Path, name: &str) -> (String, Vec<[u8; 8]>) {
        let mut archive = zip::ZipArchive::new(File::open(path).unwrap()).unwrap();
        let mut bytes = Vec::new();
        archive.by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
        let (header, entries) = bytes.split_at(128);
        assert!(header.ends_with(b" \n") && entries.len().is_multiple_of(8));
        (
            String::from_utf8_lossy(&header[10..]).trim_end().into(),
            entries.as_chunks::<8>().0.to_vec(),
        )
    }

    fn header(descr: &str, fortran_order: &str, shape: &str) -> String {
        format!("{{'descr': '{descr}', 'fortran_order': {fortran_order}, 'shape': {shape}, }}")
    }

    #[test]
    fn arrays_come_back_under_their_names() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npz");
        let matrix = mat![[1.0, 2.5], [3.0, -4.0], [0.0, 1e300]];
        let arrays = [
            ("values", Array::Vector(&[0.5, f64::INFINITY])),
            ("kept", Array::Indices(&[0, 7, usize::MAX])),
            ("none", Array::Vector(&[])),
            ("matrix", Array::Matrix(matrix.as_ref())),
        ];
        write_npz(Output::create(&path, Overwrite::Never).unwrap(), &arrays).unwrap();
        let numbers = |values: &[f64]| values.iter().map(|v| v.to_le_bytes()).collect::<Vec<_>>();
        for (name, descr, shape, entries) in [
            ("values.npy", "<f8", "(2,)", numbers(&[0.5, f64::INFINITY])),
            ("kept.npy", "<u8", "(3,)", [0, 7, u64::MAX].map(u64::to_le_bytes).to_vec()),
            ("none.npy", "<f8", "(0,)", Vec::new()),
            ("matrix.npy", "<f8", "(3, 2)", numbers(&[1.0, 2.5, 3.0, -4.0, 0.0, 1e300])),
        ] {
            assert_eq!(array(&path, name), (header(descr, "False", shape), entries), "{name}");
        }
    }

    #[test]
    fn a_matrix_comes_by_columns_and_not_without_all_of_them() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npz");
        let matrix = mat![[1.0, 2.5, 6.0], [3.0, -4.0, 7.0]];
        let begun = || {
            let mut writer = NpzWriter::new(Output::create(&path, Overwrite::Never).unwrap());
            writer.matrix_by_columns("matrix", 2, 3).unwrap();
            writer.columns(matrix.as_ref().subcols(0, 2)).unwrap();
            writer
        };
        assert!(matches!(begun().finish().unwrap_err(), Error::Shape { .. }));
        let mut writer = begun();
        assert!(matches!(writer.array("v", Array::Vector(&[])).unwrap_err(), Error::Shape { .. }));
        assert!(matches!(writer.columns(matrix.as_ref()).unwrap_err(), Error::Shape { .. }));
        drop(writer);
        assert!(!path.exists());
        let mut writer = begun();
        writer.columns(matrix.as_ref().subcols(2, 1)).unwrap();
        writer.array("v", Array::Vector(&[8.0])).unwrap();
        writer.finish().unwrap();
        let entries = [1.0, 3.0, 2.5, -4.0, 6.0, 7.0].map(f64::to_le_bytes).to_vec();
        assert_eq!(array(&path, "matrix.npy"), (header("<f8", "True", "(2, 3)"), entries));
    }

    #[test]
    fn a_matrix_comes_by_rows_and_not_without_all_of_them() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npz");
        let matrix = mat![[1.0, 2.5], [3.0, -4.0], [6.0, 7.0]];
        let begun = || {
            let mut writer = NpzWriter::new(Output::create(&path, Overwrite::Never).unwrap());
            writer.matrix_by_rows("matrix", 3, 2).unwrap();
            writer.rows(matrix.as_ref().subrows(0, 2)).unwrap();
            writer
        };
        assert!(matches!(begun().finish().unwrap_err(), Error::Shape { what: "rows", .. }));
        let mut writer = begun();
        assert!(matches!(writer.rows(matrix.as_ref()).unwrap_err(), Error::Shape { .. }));
        let column = matrix.as_ref().subcols(0, 1);
        assert!(matches!(writer.columns(column).unwrap_err(), Error::Shape { .. }));
        writer.rows(matrix.as_ref().subrows(2, 1)).unwrap();
        writer.finish().unwrap();
        assert_eq!(crate::io::read_arrays(&path).unwrap().matrix("matrix").unwrap(), matrix);
    }

    #[test]
    fn a_name_is_taken_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npz");
        let mut writer = NpzWriter::new(Output::create(&path, Overwrite::Never).unwrap());
        writer.array("größe", Array::Vector(&[1.0])).unwrap();
        writer.array("values", Array::Vector(&[2.0])).unwrap();
        let refused = writer.array("values", Array::Vector(&[3.0])).unwrap_err().to_string();
        assert!(refused.contains("a.npz") && refused.contains("values.npy"), "{refused}");
        writer.finish().unwrap();
        assert_eq!(array(&path, "größe.npy").1, [1.0_f64.to_le_bytes()]);
        assert_eq!(array(&path, "values.npy").1, [2.0_f64.to_le_bytes()]);
    }
}
