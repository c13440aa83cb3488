//! Matrix files that are read by blocks of rows, never as a whole.

#[cfg(feature = "hdf5")]
mod dataset;
mod file;
mod npy;
#[cfg(test)]
mod tests;

use std::ops::Range;
use std::path::{Path, PathBuf};

use faer::MatMut;

#[cfg(feature = "hdf5")]
use self::dataset::DatasetRows;
#[cfg(feature = "hdf5")]
pub(super) use self::dataset::open as open_hdf5;
pub(super) use self::file::{CHANGED, Stamp, canonical, check_rows, seekable};
use self::npy::NpyRows;
use super::columns::checked_columns;
#[cfg(not(feature = "hdf5"))]
use super::names::without_hdf5;
use super::names::{RowsFormat, foreign};
use super::npy::is_complex;
use super::rounding::FirstRounded;
use super::source::error;
use crate::base::{Error, Real, Result};
use crate::rows::RowBlocks;

/// A matrix in a file whose rows are read block by block, so that the matrix may be larger than
/// memory. It can be sent to a thread that reads.
///
/// - `NAME.npy`: two dimensions, or one (a column); f4, f8 and integers. In C order a block of
///   whole rows is one piece of the file. In Fortran order it is one piece for every column, which
///   is much slower when blocks are small.
/// - `NAME.h5:/path/to/dataset`, also `.hdf5`, `.he5` and any other name (such as `.nc` and
///   `.mat`) of a file whose content is HDF5 (feature `hdf5`): a dataset of two dimensions, or one
///   (a column), of floats, of integers of 1 to 8 bytes, of booleans or of an enumeration, also
///   virtual. `NAME.h5` alone means its only dataset of two dimensions.
///   - Entries mean what the attributes of netCDF say: `scale_factor`, `add_offset` and `_Unsigned`
///     are applied, and entries equal to `_FillValue` or `missing_value` are NaN.
///   - A matrix of MATLAB (version 7.3), which is stored by columns, has the shape that MATLAB
///     shows.
///   - A packed chunk is unpacked once, however many blocks it spans, if a row of chunks takes at
///     most a sixteenth of the available memory.
///   - A file that can't be locked is read without a lock. [`RowFile::notes`] tells.
///
/// Rows go straight from the file into a destination of the precision of the file whose rows are
/// contiguous; other destinations, and columns left out, go through a buffer of a few MiB. Entries
/// are those that [`read`](super::read()) gives: f4 is exact in f32, all others are rounded to f64
/// first.
///
/// A file that is changed, shrinks or vanishes while it is read is an error. After a `.npy` file is
/// replaced by another file of its name, the old rows are still read.
///
/// ```
/// use catamaran::rows::RowBlocks;
/// use catamaran::faer::Mat;
/// use catamaran::io::{self, Output, Overwrite, RowFile};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let name = &folder.path().join("a.npy");
/// let a = Mat::<f64>::from_fn(7, 3, |i, j| (10 * i + j) as f64);
/// io::write(Output::create(name, Overwrite::Never)?, a.as_ref())?;
/// let mut rows = RowFile::open(name)?;
/// let mut block = Mat::<f64>::zeros(2, 3);
/// rows.read(5, block.as_mut())?;
/// assert_eq!(block, a.get(5..7, ..));
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug)]
pub struct RowFile {
    /// The name given to [`RowFile::open`].
    name: PathBuf,
    content: Content,
    /// The columns that are part of the matrix.
    columns: Range<usize>,
    rounded: FirstRounded,
}

impl RowFile {
    /// Opens the file (and dataset) of this name and checks its header and, of `.npy`, its size.
    ///
    /// # Errors
    /// [`Error::Io`]: no such file or dataset (the message lists those that exist), a gzipped or
    /// unknown kind of file, HDF5 without feature `hdf5`, a broken header, too few or too many
    /// bytes, entries that are not real numbers, neither one nor two dimensions.
    pub fn open(name: impl AsRef<Path>) -> Result<Self> {
        let name = name.as_ref();
        let content = match RowsFormat::of(name)? {
            RowsFormat::Npy => Content::Npy(NpyRows::open(name)?),
            RowsFormat::Hdf5 { path, dataset } => open_dataset(&path, dataset.as_deref())?,
        };
        let columns = 0..content.shape().1;
        let rounded = FirstRounded::new(columns.len());
        Ok(Self { name: name.into(), content, columns, rounded })
    }

    /// Returns whether a file of this name is read by rows: the name or the content is that of an
    /// HDF5 file, with a dataset or without, the content is that of an older format (HDF4, netCDF,
    /// MATLAB) about which [`RowFile::open`] says what converts it, or the name is that of a `.npy`
    /// file that is no folder, pipe or device. Complex numbers are not read by rows.
    ///
    /// ```
    /// use catamaran::io::RowFile;
    ///
    /// assert!(RowFile::is_one("a.h5:/x".as_ref()) && !RowFile::is_one("a.csv".as_ref()));
    /// ```
    pub fn is_one(name: &Path) -> bool {
        match RowsFormat::of(name) {
            Ok(RowsFormat::Npy) => name.is_file() && !is_complex(name),
            Ok(RowsFormat::Hdf5 { .. }) => true,
            // Opening says what converts it.
            Err(_) => foreign(name).is_some(),
        }
    }

    /// Keeps only these columns of the file, from 0, half open.
    ///
    /// ```
    /// use catamaran::{faer::Mat, io::{self, Output, Overwrite, RowFile}};
    ///
    /// # let folder = tempfile::tempdir().unwrap();
    /// # let path = &folder.path().join("a.npy");
    /// io::write(Output::create(path, Overwrite::Never)?, Mat::<f64>::ones(7, 3).as_ref())?;
    /// let rows = RowFile::open(path)?.with_columns(1..3)?;
    /// assert_eq!((rows.nrows(), rows.ncols()), (7, 2));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] when the columns are not inside the matrix of the file.
    pub fn with_columns(mut self, columns: Range<usize>) -> Result<Self> {
        self.columns = checked_columns(Some(&columns), self.content.shape().1)?;
        Ok(self)
    }

    /// Opens the same rows and columns once more, for a second reader.
    ///
    /// # Errors
    /// As [`RowFile::open`]; [`Error::Io`] when the file has changed since it was opened.
    pub fn try_clone(&self) -> Result<Self> {
        let other = Self::open(&self.name)?.with_columns(self.columns.clone())?;
        if other.identity() == self.identity() {
            Ok(Self { rounded: self.rounded.clone(), ..other })
        } else {
            Err(error(self.path(), None, CHANGED))
        }
    }

    /// Returns the number of rows.
    pub fn nrows(&self) -> usize {
        self.content.shape().0
    }

    /// Returns the number of columns.
    pub fn ncols(&self) -> usize {
        self.columns.len()
    }

    /// Returns whether the file holds single precision. All other types are read as f64, which
    /// rounds integers beyond 2^53 ([`RowFile::rounded_integers`]).
    pub fn is_single(&self) -> bool {
        self.content.is_single()
    }

    /// Returns how many rows are packed together, 1 where rows are not packed. Ranks that each read
    /// a part of the rows begin it at a multiple of this number, so that no two unpack the same.
    pub fn chunk_rows(&self) -> usize {
        match &self.content {
            Content::Npy(_) => 1,
            #[cfg(feature = "hdf5")]
            Content::Hdf5(dataset) => dataset.chunk_rows(),
        }
    }

    /// Returns what a user may not expect of these rows, such as attributes that change the meaning
    /// of entries; empty for most files.
    pub fn notes(&self) -> &[String] {
        match &self.content {
            Content::Npy(_) => &[],
            #[cfg(feature = "hdf5")]
            Content::Hdf5(dataset) => dataset.notes(),
        }
    }

    /// Returns a note with the place of the first integer beyond 2^53 that was rounded when rows
    /// were read, from these or from their clones; `None` if there is none.
    ///
    /// ```
    /// use catamaran::faer::{Mat, mat};
    /// use catamaran::io::{self, Output, Overwrite, RowFile};
    /// use catamaran::rows::RowBlocks;
    ///
    /// # let folder = tempfile::tempdir().unwrap();
    /// # let path = &folder.path().join("a.npy");
    /// let a = mat![[1 << 53, (1 << 53) + 1]];
    /// io::write_integers(Output::create(path, Overwrite::Never)?, a.as_ref())?;
    /// let mut rows = RowFile::open(path)?;
    /// assert_eq!(rows.rounded_integers(), None);
    /// rows.read(0, Mat::<f64>::zeros(1, 2).as_mut())?;
    /// let note = "integers beyond 2^53 rounded, the first in row 0, column 1 (counted from 0)";
    /// assert_eq!(rows.rounded_integers().as_deref(), Some(note));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn rounded_integers(&self) -> Option<String> {
        self.rounded.note()
    }

    /// Returns the path of the file; for HDF5 without the name of the dataset.
    pub fn path(&self) -> &Path {
        self.content.path()
    }

    /// Returns a line of text that identifies these rows and their version: canonical path,
    /// dataset, shape, type, columns, size and time of modification of the file. Equal lines mean
    /// the same rows, as far as the file system can tell.
    ///
    /// ```
    /// use catamaran::{faer::Mat, io::{self, Output, Overwrite, RowFile}};
    ///
    /// # let folder = tempfile::tempdir().unwrap();
    /// # let path = &folder.path().join("a.npy");
    /// io::write(Output::create(path, Overwrite::Never)?, Mat::<f64>::ones(7, 3).as_ref())?;
    /// let rows = RowFile::open(path)?;
    /// assert_eq!(rows.identity(), rows.try_clone()?.identity());
    /// assert_ne!(rows.identity(), rows.try_clone()?.with_columns(0..2)?.identity());
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn identity(&self) -> String {
        let (m, n) = self.content.shape();
        let Range { start, end } = self.columns;
        let (origin, stamp) = (self.content.origin(), self.content.stamp());
        format!("{origin}, {m} x {n}, columns {start}..{end}, {stamp}")
    }
}

impl<T: Real> RowBlocks<T> for RowFile {
    fn nrows(&self) -> usize {
        self.nrows()
    }

    fn ncols(&self) -> usize {
        self.ncols()
    }

    fn read(&mut self, first: usize, out: MatMut<'_, T>) -> Result<()> {
        check_rows(first, out.nrows(), self.nrows())?;
        let rows = first..first + out.nrows();
        Error::check_shape("block of rows", (rows.len(), self.ncols()), out.shape())?;
        if rows.is_empty() || self.columns.is_empty() {
            return Ok(());
        }
        let (columns, rounded) = (self.columns.clone(), &self.rounded);
        match &mut self.content {
            Content::Npy(npy) => npy.read(rows, columns, out, rounded),
            #[cfg(feature = "hdf5")]
            Content::Hdf5(dataset) => dataset.read(rows, columns, out, rounded),
        }
    }
}

#[derive(Debug)]
enum Content {
    Npy(NpyRows),
    #[cfg(feature = "hdf5")]
    Hdf5(Box<DatasetRows>),
}

macro_rules! content {
    ($($name:ident -> $type:ty),* $(,)?) => {
        impl Content {
            $(fn $name(&self) -> $type {
                match self {
                    Self::Npy(npy) => npy.$name(),
                    #[cfg(feature = "hdf5")]
                    Self::Hdf5(dataset) => dataset.$name(),
                }
            })*
        }
    };
}

content! {
    shape -> (usize, usize),
    is_single -> bool,
    path -> &Path,
    origin -> String,
    stamp -> Stamp,
}

#[cfg(feature = "hdf5")]
fn open_dataset(path: &Path, name: Option<&str>) -> Result<Content> {
    DatasetRows::open(path, name).map(|dataset| Content::Hdf5(Box::new(dataset)))
}

#[cfg(not(feature = "hdf5"))]
fn open_dataset(path: &Path, _: Option<&str>) -> Result<Content> {
    Err(without_hdf5(path))
}
