//! Tables whose rows are read block by block: text, Parquet and Arrow.

use std::path::Path;

use faer::MatMut;

use super::ReadOptions;
#[cfg(feature = "columnar")]
use super::columnar::ColumnarFile;
use super::matrix::Dense;
use super::names::FileFormat;
#[cfg(not(feature = "columnar"))]
use super::names::without_columnar;
use super::packing::Packing;
use super::table::{TableReading, TextFile};
use crate::base::{Real, Result};
use crate::rows::RowBlocks;

/// A table whose rows are read block by block, so that it may be larger than memory: text, Parquet
/// or Arrow's IPC format (feature `columnar`). It can be sent to a thread that reads.
///
/// Opening it counts the rows, and finds the levels of factors and the rows with missing cells that
/// are left out. That reads a text table, and those columns of others, once.
///
/// ```
/// use catamaran::faer::{Mat, mat};
/// use catamaran::io::{ReadOptions, TableFile};
/// use catamaran::rows::RowBlocks;
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("a.csv");
/// std::fs::write(path, "x,y\n1,2\n3,4\n5,6\n").unwrap();
/// let mut rows = TableFile::open(path, &ReadOptions::new())?.unwrap();
/// let mut block = Mat::<f64>::zeros(2, 2);
/// rows.read(1, block.as_mut())?;
/// assert_eq!(block, mat![[3.0, 4.0], [5.0, 6.0]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug)]
pub struct TableFile(Content);

#[derive(Debug)]
enum Content {
    Text(Box<TextFile>),
    #[cfg(feature = "columnar")]
    Columnar(Box<ColumnarFile>),
}

/// Calls a method of the content.
macro_rules! content {
    ($self:ident, $file:ident => $call:expr) => {
        match $self {
            Content::Text($file) => $call,
            #[cfg(feature = "columnar")]
            Content::Columnar($file) => $call,
        }
    };
}

impl TableFile {
    /// Opens a table; `None` for other formats and for text that is packed, must be decoded or has
    /// no place in a plain file, which [`read_file`](crate::io::read_file) reads.
    ///
    /// # Errors
    /// As [`read_file`](crate::io::read_file).
    pub fn open(path: &Path, options: &ReadOptions<'_>) -> Result<Option<Self>> {
        let file = Self::open_one_of_several(path, options)?;
        if let Some(file) = &file {
            options.check_effects(path, &[Some(file.reading().format)], false)?;
        }
        Ok(file)
    }

    /// Opens as [`TableFile::open`] does one of several files that have the same options: those
    /// that do not apply to it are no error. For the command line.
    #[doc(hidden)]
    pub fn open_one_of_several(path: &Path, options: &ReadOptions<'_>) -> Result<Option<Self>> {
        let named = FileFormat::of_name(path);
        let is_packed = named.is_some_and(|(_, packing)| packing != Packing::None);
        match options.format.or(named.map(|(format, _)| format)) {
            Some(format) if format.is_columnar() && !is_packed => {
                Self::columnar(path, format, options).map(Some)
            }
            _ => {
                let file = TextFile::open(path, options)?;
                Ok(file.map(|file| Self(Content::Text(Box::new(file)))))
            }
        }
    }

    /// Returns whether a file of this name is in a format that stores columns with their names:
    /// Parquet, or Arrow's IPC format. Such a file is opened without being read.
    ///
    /// ```
    /// use catamaran::io::TableFile;
    ///
    /// assert!(TableFile::is_columnar("a.parquet".as_ref()));
    /// assert!(!TableFile::is_columnar("a.csv".as_ref()));
    /// ```
    pub fn is_columnar(path: &Path) -> bool {
        FileFormat::of_name(path).is_some_and(|(format, _)| format.is_columnar())
    }

    /// Reads a columnar file as a whole.
    pub(super) fn read_columnar(
        path: &Path,
        format: FileFormat,
        options: &ReadOptions<'_>,
    ) -> Result<(Dense<f64>, TableReading)> {
        #[cfg(feature = "columnar")]
        return ColumnarFile::open(path, format, options)?.read_all(options);
        #[cfg(not(feature = "columnar"))]
        Self::columnar(path, format, options).and(Err(without_columnar(path)))
    }

    #[cfg(feature = "columnar")]
    fn columnar(path: &Path, format: FileFormat, options: &ReadOptions<'_>) -> Result<Self> {
        let file = ColumnarFile::open(path, format, options)?;
        Ok(Self(Content::Columnar(Box::new(file))))
    }

    #[cfg(not(feature = "columnar"))]
    fn columnar(path: &Path, _: FileFormat, _: &ReadOptions<'_>) -> Result<Self> {
        Err(without_columnar(path))
    }

    /// Opens the same rows once more, for a second reader.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io) when the file has changed since it was opened.
    pub fn try_clone(&self) -> Result<Self> {
        Ok(Self(match &self.0 {
            Content::Text(file) => Content::Text(Box::new(file.try_clone()?)),
            #[cfg(feature = "columnar")]
            Content::Columnar(file) => Content::Columnar(Box::new(file.try_clone()?)),
        }))
    }

    /// Returns how the table is read.
    pub fn reading(&self) -> &TableReading {
        let content = &self.0;
        content!(content, file => file.reading())
    }

    /// Returns the number of rows.
    pub fn nrows(&self) -> usize {
        let content = &self.0;
        content!(content, file => file.nrows())
    }

    /// Returns the number of columns.
    pub fn ncols(&self) -> usize {
        let content = &self.0;
        content!(content, file => file.ncols())
    }

    /// Returns a line of text that identifies these rows and their version, as that of
    /// [`RowFile::identity`](crate::io::RowFile::identity).
    pub fn identity(&self) -> String {
        let content = &self.0;
        content!(content, file => file.identity())
    }
}

impl<T: Real> RowBlocks<T> for TableFile {
    fn nrows(&self) -> usize {
        self.nrows()
    }

    fn ncols(&self) -> usize {
        self.ncols()
    }

    fn read(&mut self, first: usize, out: MatMut<'_, T>) -> Result<()> {
        let content = &mut self.0;
        content!(content, file => file.read(first, out))
    }
}

#[cfg(all(test, not(feature = "columnar")))]
mod tests {
    use super::*;

    #[test]
    fn columnar_files_ask_for_their_feature() {
        for name in ["a.parquet", "a.feather"] {
            let error = TableFile::open(Path::new(name), &ReadOptions::new()).unwrap_err();
            let error = error.to_string();
            assert!(error.starts_with(name), "{error}");
            assert!(error.ends_with("build it with --features columnar"), "{error}");
        }
    }
}
