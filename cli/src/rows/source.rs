//! The rows of A: a file that is read block by block, or a matrix in memory.

use std::fs;
use std::ops::ControlFlow;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use catamaran::base::{Real, zeros};
use catamaran::blas::BlasReal;
use catamaran::faer::prelude::ReborrowMut;
use catamaran::faer::{Mat, MatMut, MatRef};
use catamaran::io::{self as files, CsMat, Matrix, ReadOptions, RowFile, SparseRows};
use catamaran::rows::{DenseRows, RowBlocks};

use super::list::RowList;
use crate::claims::file_of;
use crate::input;
use crate::progress::Bar;
use crate::ranks::Ranks;
use crate::report::{note, seconds, status};

/// The matrix A.
pub struct Source {
    name: PathBuf,
    content: Content,
    /// The names of the columns, in the header of a text table; empty elsewhere.
    names: Vec<String>,
}

enum Content {
    File(RowFile),
    Whole(Matrix),
}

/// Opens a matrix, and reports its size and kind.
pub fn open(label: &'static str, path: &Path, columns: Option<Range<usize>>) -> Result<Source> {
    let start = Instant::now();
    let source = Source::open(path, columns)?;
    if let Content::File(file) = &source.content {
        notes_of(file);
    }
    let (m, n) = source.shape();
    let time = (!source.is_file()).then(|| start.elapsed());
    let how = time.map_or("read by blocks".into(), |time| format!("read in {}", seconds(time)));
    let (path, kind) = (path.display().to_string(), source.kind());
    status!(
        "matrix": label,
        name = label,
        path = path,
        rows = m,
        columns = n,
        scalar = if source.is_single() { "f32" } else { "f64" },
        nonzeros = source.sparse().map(|sparse| sparse.nnz()),
        seconds = time.map(|time| time.as_secs_f64());
        "{path}: {m} x {n}, {kind}, {how}"
    )?;
    Ok(source)
}

/// Prints what a user may not expect of the rows of a file.
fn notes_of(file: &RowFile) {
    for line in file.notes() {
        note(format_args!("{}: {line}", file.path().display()));
    }
}

/// Rows that a thread may read.
pub type Rows<'a, T> = Box<dyn RowBlocks<T> + Send + 'a>;

impl Source {
    /// Opens `.npy` and HDF5 files, and reads all others.
    pub fn open(name: &Path, columns: Option<Range<usize>>) -> Result<Self> {
        let (content, names) = if RowFile::is_one(name) {
            let file = RowFile::open(name)?;
            let file = match columns {
                Some(columns) => named(name, file.with_columns(columns))?,
                None => file,
            };
            (Content::File(file), Vec::new())
        } else {
            let (matrix, names) = read(name, "reading", columns)?;
            (Content::Whole(matrix), names)
        };
        Ok(Self { name: name.into(), content, names })
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        &self.name
    }

    /// Returns the names of the columns, in the header of a text table; empty elsewhere.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns a name of each column: that in the header of a text table, else its number in the
    /// file, of which `first` is that of the first column.
    pub fn column_names(&self, first: usize) -> Vec<String> {
        match self.names() {
            [] => (first..first + self.shape().1).map(|column| column.to_string()).collect(),
            names => names.to_vec(),
        }
    }

    /// Returns whether the matrix is read block by block.
    pub fn is_file(&self) -> bool {
        matches!(self.content, Content::File(_))
    }

    /// Returns the number of rows and columns.
    pub fn shape(&self) -> (usize, usize) {
        match &self.content {
            Content::File(file) => (file.nrows(), file.ncols()),
            Content::Whole(matrix) => (matrix.nrows(), matrix.ncols()),
        }
    }

    /// Returns how many rows are packed together; 1 where rows are not packed.
    pub fn chunk_rows(&self) -> usize {
        match &self.content {
            Content::File(file) => file.chunk_rows(),
            Content::Whole(_) => 1,
        }
    }

    /// Returns whether the entries are in single precision.
    pub fn is_single(&self) -> bool {
        match &self.content {
            Content::File(file) => file.is_single(),
            Content::Whole(matrix) => matches!(matrix, Matrix::F32(_)),
        }
    }

    /// Returns the sparse matrix, if the source is one.
    pub fn sparse(&self) -> Option<&CsMat<f64>> {
        match &self.content {
            Content::Whole(Matrix::Sparse(sparse)) => Some(sparse),
            _ => None,
        }
    }

    /// Describes the type of the entries.
    pub fn kind(&self) -> String {
        match self.sparse() {
            Some(sparse) => format!("f64, {} nonzeros", sparse.nnz()),
            None => if self.is_single() { "f32" } else { "f64" }.into(),
        }
    }

    /// Returns a text that distinguishes the source from others, and from itself after a change.
    pub fn identity(&self) -> String {
        match &self.content {
            Content::File(file) => file.identity(),
            Content::Whole(matrix) => {
                let path = fs::canonicalize(&self.name).unwrap_or_else(|_| self.name.clone());
                let about = fs::metadata(&self.name).ok();
                let changed = about.as_ref().and_then(|about| about.modified().ok());
                let (bytes, columns) = (about.map(|about| about.len()), matrix.ncols());
                format!("{}, {columns} columns, {bytes:?} bytes, {changed:?}", path.display())
            }
        }
    }

    /// Returns numbers that are the same for copies of the file, with their names.
    pub fn numbers(&self) -> [(&'static str, usize); 2] {
        let about = fs::metadata(file_of(&self.name)).ok().filter(fs::Metadata::is_file);
        let bytes = about.map_or(0, |about| about.len() as usize);
        let scalar = if self.is_single() { size_of::<f32>() } else { size_of::<f64>() };
        [("the size of an entry", scalar), ("the size of the file", bytes)]
    }

    /// Checks that all processes have read or opened the same matrix.
    ///
    /// # Errors
    /// A process has another one; the error names it, and what differs.
    pub fn check_same(&self, ranks: &Ranks) -> Result<()> {
        if ranks.size() == 1 {
            return Ok(());
        }
        let mut rows = self.rows::<f64>(false)?;
        let same = ranks.same_rows(&mut *rows, &self.numbers());
        ranks.meet(same.with_context(|| self.name.display().to_string()))
    }

    /// Returns the rows, converted to T; `require_finite` refuses NaN and infinities. May be called
    /// several times.
    pub fn rows<T: BlasReal>(&self, require_finite: bool) -> Result<Rows<'_, T>> {
        let rows = match &self.content {
            Content::File(file) => Box::new(file.try_clone()?),
            Content::Whole(matrix) => rows_of::<T>(matrix),
        };
        Ok(if require_finite { Box::new(Finite { rows, name: &self.name }) } else { rows })
    }

    /// Returns the first entry that is NaN or infinite, with its place; reads all entries if there
    /// is none.
    pub fn not_finite(&self) -> Result<Option<String>> {
        if let Some(sparse) = self.sparse() {
            let found = sparse.iter().find(|(x, _)| !x.is_finite());
            return Ok(found.map(|(x, (row, column))| at(*x, row, column)));
        }
        let (m, n) = self.shape();
        if m == 0 || n == 0 {
            return Ok(None);
        }
        let bar = Bar::new("checking");
        let mut rows = Watched { rows: self.rows::<f64>(false)?, bar: &bar };
        let height = (BLOCK / n).clamp(1, m);
        let mut entries = zeros::<f64>(height * n)?;
        for first in (0..m).step_by(height) {
            let count = height.min(m - first);
            let entries = &mut entries[..count * n];
            let mut block = MatMut::from_row_major_slice_mut(entries, count, n);
            rows.read(first, block.rb_mut())?;
            if let Some((i, j)) = first_not_finite(block.as_ref()) {
                return Ok(Some(at(block[(i, j)], first + i, j)));
            }
        }
        Ok(None)
    }
}

/// Entries that are read at a time to be checked.
const BLOCK: usize = 1 << 20;

/// Rows that must be finite.
struct Finite<'a, T> {
    rows: Rows<'a, T>,
    name: &'a Path,
}

impl<T: Real> RowBlocks<T> for Finite<'_, T> {
    fn nrows(&self) -> usize {
        self.rows.nrows()
    }

    fn ncols(&self) -> usize {
        self.rows.ncols()
    }

    fn read(&mut self, first: usize, mut out: MatMut<'_, T>) -> catamaran::Result<()> {
        self.rows.read(first, out.rb_mut())?;
        match first_not_finite(out.as_ref()) {
            Some((i, j)) => {
                let what = at(out[(i, j)].to_f64(), first + i, j);
                Err(catamaran::Error::file(self.name, what))
            }
            None => Ok(()),
        }
    }
}

/// Returns the first row of a block with an entry that is NaN or infinite, and the column of that
/// entry.
fn first_not_finite<T: Real>(block: MatRef<'_, T>) -> Option<(usize, usize)> {
    let column = |i: usize| (0..block.ncols()).find(|&j| !block[(i, j)].is_finite());
    (0..block.nrows()).find_map(|i| Some((i, column(i)?)))
}

/// Says what an entry is and where.
fn at(value: f64, row: usize, column: usize) -> String {
    format!("{value} at row {row}, column {column} (counted from 0)")
}

/// Rows that report to a bar how far they were read, and stop after a signal.
pub struct Watched<'a, T> {
    /// The rows.
    pub rows: Rows<'a, T>,
    /// The bar.
    pub bar: &'a Bar,
}

impl<T> RowBlocks<T> for Watched<'_, T> {
    fn nrows(&self) -> usize {
        self.rows.nrows()
    }

    fn ncols(&self) -> usize {
        self.rows.ncols()
    }

    fn read(&mut self, first: usize, out: MatMut<'_, T>) -> catamaran::Result<()> {
        match self.bar.update(first as f64 / self.rows.nrows().max(1) as f64) {
            ControlFlow::Break(()) => Err(catamaran::Error::Cancelled),
            ControlFlow::Continue(()) => self.rows.read(first, out),
        }
    }
}

fn rows_of<T: BlasReal>(a: &Matrix) -> Rows<'_, T> {
    match a {
        Matrix::F32(dense) => Box::new(DenseRows(dense.as_ref())),
        Matrix::F64(dense) => Box::new(DenseRows(dense.as_ref())),
        Matrix::Sparse(sparse) => Box::new(SparseRows(sparse)),
        _ => unreachable!("no other kind of matrix comes out of a file"),
    }
}

fn read(
    path: &Path,
    label: &'static str,
    columns: Option<Range<usize>>,
) -> Result<(Matrix, Vec<String>)> {
    let bar = Bar::new(label);
    let update = |fraction| bar.update(fraction);
    let options = ReadOptions::new().columns(columns).progress(&update);
    named(path, files::read_with_names(path, &options.max_memory(input::limit())))
}

/// Adds the file to errors that do not name it.
fn named<R>(path: &Path, result: catamaran::Result<R>) -> Result<R> {
    match result {
        Err(e @ (catamaran::Error::Argument { .. } | catamaran::Error::OutOfMemory { .. })) => {
            Err(e).with_context(|| path.display().to_string())
        }
        result => Ok(result?),
    }
}

/// Reads the `m` weights in a file with one row or one column.
pub fn read_weights(path: &Path, input: &Path, m: usize) -> Result<Vec<f64>> {
    // Also of FILE.h5:/dataset.
    let source = Source::open(path, None)?;
    if let Content::File(file) = &source.content {
        notes_of(file);
    }
    let (nrows, ncols) = source.shape();
    if (nrows, ncols) != (m, 1) && (nrows, ncols) != (1, m) {
        bail!(
            "{}: {nrows} x {ncols} where the {m} rows of {} need {m} weights",
            path.display(),
            input.display()
        );
    }
    let mut values = Mat::zeros(nrows, ncols);
    source.rows::<f64>(false)?.read(0, values.as_mut())?;
    let weights: Vec<f64> =
        (0..m).map(|i| if ncols == 1 { values[(i, 0)] } else { values[(0, i)] }).collect();
    match weights.iter().position(|w| !w.is_finite()) {
        Some(i) => bail!("{}: weight {i} (counted from 0) is not finite", path.display()),
        None => Ok(weights),
    }
}

/// Checks that all processes have read the same weights, if there are any.
///
/// # Errors
/// A process has other ones.
pub fn check_same_weights(ranks: &Ranks, weights: Option<&[f64]>) -> Result<()> {
    let hash = weights.map_or(0, fingerprint) as usize;
    ranks.same_numbers(&[("the fingerprint of the weights", hash)])
}

/// Some of the rows of a source.
pub struct Part<'a, T> {
    /// All rows.
    pub rows: Rows<'a, T>,
    /// The rows of this part, in its order.
    pub list: &'a RowList,
}

impl<T> RowBlocks<T> for Part<'_, T> {
    fn nrows(&self) -> usize {
        self.list.len()
    }

    fn ncols(&self) -> usize {
        self.rows.ncols()
    }

    fn read(&mut self, first: usize, mut out: MatMut<'_, T>) -> catamaran::Result<()> {
        let (list, rows) = (self.list, &mut self.rows);
        list.for_each(first..first + out.nrows(), |place, range| {
            let out = out.rb_mut().subrows_mut(place, range.len());
            rows.read(range.start, out)
        })
    }
}

/// Returns a number that distinguishes weights: FNV-1a of their bits.
pub fn fingerprint(weights: &[f64]) -> u64 {
    let mix = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    weights.iter().flat_map(|w| w.to_le_bytes()).fold(0xcbf2_9ce4_8422_2325, mix)
}
