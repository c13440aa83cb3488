//! The rows of A: a file that is read block by block, or a matrix in memory.

use std::fmt::Display;
use std::fs;
use std::ops::ControlFlow;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Instant, UNIX_EPOCH};

use anyhow::{Context, Result, bail};
use catamaran::base::{Real, zeros};
use catamaran::blas::BlasReal;
use catamaran::faer::prelude::ReborrowMut;
use catamaran::faer::{Mat, MatMut, MatRef, c64};
use catamaran::io::{
    self as files, ColumnKind, CsMat, FileContent, FileFormat, Matrix, ReadOptions, RowFile,
    SparseRows, TableFile, TableReading,
};
use catamaran::rows::{Coding, DenseRows, RowBlocks};

use super::list::RowList;
use crate::claims::file_of;
use crate::progress::Bar;
use crate::ranks::Ranks;
use crate::report::{note, seconds, status};
use crate::tables::{self, TableArgs};

/// Most columns of a file of rows of which all are used. A^T A of more takes 32 PiB, and a list of
/// them, or a row, may take all memory of a machine before a plan refuses them.
const MOST_COLUMNS: usize = 1 << 26;

/// The matrix A.
pub struct Source {
    name: PathBuf,
    content: Content,
    /// The names of the columns, in the header of a text table; empty elsewhere.
    names: Vec<String>,
    /// The columns of a file of rows that are used.
    chosen: Vec<usize>,
}

enum Content {
    File(RowFile),
    Table(Box<TableFile>),
    Whole(FileContent),
}

/// Bytes of the smallest table that is read block by block. A smaller one is read once, into at
/// most four times as much memory.
const STREAMED: u64 = 32 << 20;

/// Opens a matrix, and reports its size and kind.
pub fn open(label: &'static str, path: &Path, options: &ReadOptions<'_>) -> Result<Source> {
    let start = Instant::now();
    let source = Source::open(path, options)?;
    source.say(options)?;
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
        scalar = source.scalar(),
        nonzeros = source.sparse().map(|sparse| sparse.nnz()),
        seconds = time.map(|time| time.as_secs_f64());
        "{path}: {m} x {n}, {kind}, {how}"
    )?;
    Ok(source)
}

/// Rows that a thread may read.
pub type Rows<'a, T> = Box<dyn RowBlocks<T> + Send + 'a>;

impl Source {
    /// Opens `.npy`, HDF5 and columnar files and large text tables, and reads all others. Options
    /// that do not apply to the file are no error: see [`check_options`].
    pub fn open(name: &Path, options: &ReadOptions<'_>) -> Result<Self> {
        let (mut names, mut chosen) = (Vec::new(), Vec::new());
        let content = if options.format.is_none() && RowFile::is_one(name) {
            options.check_array(name)?;
            let file = RowFile::open(name)?;
            if options.columns.is_all() && file.ncols() > MOST_COLUMNS {
                let (m, n) = (file.nrows(), file.ncols());
                let pib = 8.0 * (n as f64).powi(2) / (1_u64 << 50) as f64;
                bail!("{}: {m} x {n}: A^T A takes {pib:.0} PiB of memory", name.display());
            }
            chosen = named(name, options.columns.of(&[], file.ncols()))?;
            Content::File(file)
        } else if let Some(file) = large_table(name, options)? {
            names = file.reading().names();
            Content::Table(Box::new(file))
        } else {
            let content = read(name, options)?;
            names = content.names.clone();
            Content::Whole(content)
        };
        Ok(Self { name: name.into(), content, names, chosen })
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        &self.name
    }

    /// Returns how the text table or columnar file was read; `None` for other formats.
    pub fn reading(&self) -> Option<&TableReading> {
        match &self.content {
            Content::File(_) => None,
            Content::Table(file) => Some(file.reading()),
            Content::Whole(content) => content.reading.as_ref(),
        }
    }

    /// Returns the format of a table; `None` for an array.
    fn format(&self) -> Option<FileFormat> {
        self.reading().map(|reading| reading.format)
    }

    /// Says how a text table was read, and what a user may not expect of the rows of a file.
    fn say(&self, options: &ReadOptions<'_>) -> Result<()> {
        if let Content::File(file) = &self.content {
            for line in file.notes() {
                note(format_args!("{}: {line}", file.path().display()));
            }
        }
        match self.reading() {
            Some(reading) => tables::say(&self.name, reading, options),
            None => Ok(()),
        }
    }

    /// Returns the note about integers that have been rounded, but for tables, whose reading has
    /// it.
    fn rounded(&self) -> Option<String> {
        match &self.content {
            Content::File(file) => file.rounded_integers(),
            Content::Table(_) => None,
            Content::Whole(content) => content.rounded.as_ref().map(ToString::to_string),
        }
    }

    /// Returns the levels that the entries of a column are numbers of; none for numbers.
    pub fn levels(&self, column: usize) -> &[String] {
        let column = self.reading().and_then(|reading| reading.columns.get(column));
        match column.map(|column| &column.kind) {
            Some(ColumnKind::Factor { levels }) => levels,
            _ => &[],
        }
    }

    /// Refuses a table without some of its rows, where each row belongs to one of another file.
    ///
    /// # Errors
    /// Rows with a missing cell were left out.
    pub fn refuse_dropped(&self, other: &Path) -> Result<()> {
        match self.reading().map_or(0, |reading| reading.dropped_rows) {
            0 => Ok(()),
            count => bail!(
                "{}: --missing drop leaves out rows ({count}), so that the rows of {} are no \
                 longer theirs: it needs all columns in one table",
                self.name.display(),
                other.display()
            ),
        }
    }

    /// Returns the number of each column in the file, from 0.
    pub fn numbers(&self) -> Vec<usize> {
        match &self.content {
            Content::File(_) => self.chosen.clone(),
            Content::Table(file) => {
                file.reading().columns.iter().map(|column| column.number).collect()
            }
            Content::Whole(content) => {
                (0..content.matrix.ncols()).map(|j| content.number(j)).collect()
            }
        }
    }

    /// Returns a name of each column: that in the header of a text table, else its number in the
    /// file.
    pub fn column_names(&self) -> Vec<String> {
        let numbers = self.numbers();
        let name = |j: usize| match self.names.get(j).filter(|name| !name.is_empty()) {
            Some(name) => name.clone(),
            None => numbers[j].to_string(),
        };
        (0..numbers.len()).map(name).collect()
    }

    /// Returns whether the file has names of columns.
    pub fn is_named(&self) -> bool {
        self.names.iter().any(|name| !name.is_empty())
    }

    /// Returns columns for a message, by their numbers in the file and their names: `column 2 (x)`,
    /// or `columns 2, 3 (counted from 0)` without names.
    pub fn described(&self, columns: &[usize]) -> String {
        /// Most columns that are listed.
        const LISTED: usize = 10;
        let s = if columns.len() == 1 { "" } else { "s" };
        let some = &columns[..columns.len().min(LISTED)];
        let places = self.places();
        let label = |&j: &usize| places.columns[j].as_str();
        let mut list = some.iter().map(label).collect::<Vec<_>>().join(", ");
        if columns.len() > LISTED {
            list += &format!(" and {} more", columns.len() - LISTED);
        }
        let base = if self.is_named() { "" } else { " (counted from 0)" };
        format!("column{s} {list}{base}")
    }

    /// Returns what messages about entries need.
    pub fn places(&self) -> Places {
        let label = |(j, number): (usize, usize)| match self.names.get(j) {
            Some(name) if !name.is_empty() => format!("{number} ({name})"),
            _ => number.to_string(),
        };
        let columns = self.numbers().into_iter().enumerate().map(label).collect();
        Places { columns, are_named: self.is_named() }
    }

    /// Returns whether the matrix is read block by block.
    pub fn is_file(&self) -> bool {
        !matches!(self.content, Content::Whole(_))
    }

    /// Returns the number of rows and columns.
    pub fn shape(&self) -> (usize, usize) {
        match &self.content {
            Content::File(file) => (file.nrows(), self.chosen.len()),
            Content::Table(file) => (file.nrows(), file.ncols()),
            Content::Whole(content) => (content.matrix.nrows(), content.matrix.ncols()),
        }
    }

    /// Returns how many rows are packed together; 1 where rows are not packed.
    pub fn chunk_rows(&self) -> usize {
        match &self.content {
            Content::File(file) => file.chunk_rows(),
            Content::Table(_) | Content::Whole(_) => 1,
        }
    }

    /// Returns whether the entries are in single precision.
    pub fn is_single(&self) -> bool {
        match &self.content {
            Content::File(file) => file.is_single(),
            Content::Table(_) => false,
            Content::Whole(content) => matches!(content.matrix, Matrix::F32(_)),
        }
    }

    /// Returns the complex matrix, if the source is one.
    pub fn complex(&self) -> Option<MatRef<'_, c64>> {
        match &self.content {
            Content::Whole(FileContent { matrix: Matrix::Complex(dense), .. }) => {
                Some(dense.as_ref())
            }
            _ => None,
        }
    }

    /// Returns the name of the type of the entries.
    fn scalar(&self) -> &'static str {
        match (self.is_single(), self.complex()) {
            (_, Some(_)) => "c64",
            (true, None) => "f32",
            (false, None) => "f64",
        }
    }

    /// Returns the sparse matrix, if the source is one.
    pub fn sparse(&self) -> Option<&CsMat<f64>> {
        match &self.content {
            Content::Whole(FileContent { matrix: Matrix::Sparse(sparse), .. }) => Some(sparse),
            _ => None,
        }
    }

    /// Describes the type of the entries.
    pub fn kind(&self) -> String {
        match self.sparse() {
            Some(sparse) => format!("f64, {} nonzeros", sparse.nnz()),
            None => self.scalar().into(),
        }
    }

    /// Returns a text that distinguishes the source from others, and from itself after a change.
    pub fn identity(&self) -> String {
        match &self.content {
            Content::File(file) => match self.range() {
                Some(Range { start, end }) => {
                    format!("{}, of which {start}..{end}", file.identity())
                }
                None => format!("{}, of which {:?}", file.identity(), self.chosen),
            },
            Content::Table(file) => file.identity(),
            Content::Whole(content) => {
                let path = fs::canonicalize(&self.name).unwrap_or_else(|_| self.name.clone());
                let (m, n) = (content.matrix.nrows(), content.matrix.ncols());
                let version = version(file_of(&self.name));
                format!("{}, {m} x {n}{version}", path.display())
            }
        }
    }

    /// Returns numbers that are the same for copies of the file, with their names.
    pub fn facts(&self) -> [(&'static str, usize); 2] {
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
        let same = ranks.same_rows(&mut *rows, &self.facts());
        ranks.meet(same.with_context(|| self.name.display().to_string()))
    }

    /// Returns the rows, converted to T; `require_finite` refuses NaN and infinities. May be called
    /// several times.
    pub fn rows<T: BlasReal>(&self, require_finite: bool) -> Result<Rows<'_, T>> {
        Ok(match (&self.content, require_finite) {
            (_, true) => self.checked(self.rows(false)?, false),
            (Content::File(file), _) => self.chosen_rows(file)?,
            (Content::Table(file), _) => Box::new(file.try_clone()?),
            (Content::Whole(content), _) => rows_of::<T>(&self.name, &content.matrix)?,
        })
    }

    /// Returns the rows, of which NaN stands for missing values; refuses infinities.
    pub fn rows_with_missing<T: BlasReal>(&self) -> Result<Rows<'_, T>> {
        Ok(self.checked(self.rows(false)?, true))
    }

    fn checked<'a, T: Real>(&'a self, rows: Rows<'a, T>, takes_nan: bool) -> Rows<'a, T> {
        Box::new(Finite { rows, path: &self.name, places: self.places(), takes_nan })
    }

    /// Returns the rows of a file with the columns that are used.
    fn chosen_rows<T: BlasReal>(&self, file: &RowFile) -> Result<Rows<'_, T>> {
        let file = file.try_clone()?;
        Ok(match self.range() {
            Some(range) => Box::new(file.with_columns(range)?),
            None => Box::new(Chosen { rows: file, columns: &self.chosen, all: Vec::new() }),
        })
    }

    /// Returns the columns of a file of rows that are used, if they follow one another.
    fn range(&self) -> Option<Range<usize>> {
        let first = self.chosen.first().copied().unwrap_or(0);
        let range = first..first + self.chosen.len();
        self.chosen.iter().copied().eq(range.clone()).then_some(range)
    }

    /// Returns the first entry that is NaN or infinite, with its place; reads all entries if there
    /// is none.
    pub fn not_finite(&self) -> Result<Option<String>> {
        if let Some(sparse) = self.sparse() {
            let found = sparse.iter().find(|(x, _)| !x.is_finite());
            return Ok(found.map(|(x, (row, column))| self.places().at(x, row, column)));
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
            if let Some((i, j)) = first_not_finite(block.as_ref(), false) {
                return Ok(Some(self.places().at(block[(i, j)], first + i, j)));
            }
        }
        Ok(None)
    }
}

impl Drop for Source {
    /// Says what only shows while rows are read.
    fn drop(&mut self) {
        if let Some(line) = self.rounded() {
            note(format_args!("{}: {line}", self.name.display()));
        }
    }
}

/// Some of the columns of rows.
struct Chosen<'a, T> {
    rows: RowFile,
    columns: &'a [usize],
    /// Entries of a block with all columns.
    all: Vec<T>,
}

impl<T: Real> RowBlocks<T> for Chosen<'_, T> {
    fn nrows(&self) -> usize {
        self.rows.nrows()
    }

    fn ncols(&self) -> usize {
        self.columns.len()
    }

    fn read(&mut self, first: usize, mut out: MatMut<'_, T>) -> catamaran::Result<()> {
        let (n, end) = (self.rows.ncols(), out.nrows());
        let height = (BLOCK / n.max(1)).clamp(1, end.max(1));
        self.all.resize(height * n, T::ZERO);
        for start in (0..end).step_by(height) {
            let count = height.min(end - start);
            let all = &mut self.all[..count * n];
            self.rows.read(first + start, MatMut::from_row_major_slice_mut(all, count, n))?;
            for (i, row) in all.chunks_exact(n.max(1)).enumerate() {
                for (j, &column) in self.columns.iter().enumerate() {
                    out[(start + i, j)] = row[column];
                }
            }
        }
        Ok(())
    }
}

/// Entries that are read at a time to be checked.
const BLOCK: usize = 1 << 20;

/// Where entries are in a file.
pub struct Places {
    /// The number of each column, and its name where it has one.
    columns: Vec<String>,
    are_named: bool,
}

impl Places {
    /// Says what an entry is, and where.
    pub fn at(&self, entry: impl Display, row: usize, column: usize) -> String {
        let base = if self.are_named { ", counted from 0" } else { " (counted from 0)" };
        format!("{entry} at row {row}, column {}{base}", self.columns[column])
    }
}

/// Rows that must be finite.
struct Finite<'a, T> {
    rows: Rows<'a, T>,
    path: &'a Path,
    places: Places,
    takes_nan: bool,
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
        match first_not_finite(out.as_ref(), self.takes_nan) {
            Some((i, j)) => {
                let what = self.places.at(out[(i, j)].to_f64(), first + i, j);
                Err(catamaran::Error::file(self.path, what))
            }
            None => Ok(()),
        }
    }
}

/// Returns the first row of a block with an entry that is infinite, or NaN unless it `takes_nan`,
/// and the column of that entry.
fn first_not_finite<T: Real>(block: MatRef<'_, T>, takes_nan: bool) -> Option<(usize, usize)> {
    let is_right = |x: T| x.is_finite() || takes_nan && x.to_f64().is_nan();
    let column = |i: usize| (0..block.ncols()).find(|&j| !is_right(block[(i, j)]));
    (0..block.nrows()).find_map(|i| Some((i, column(i)?)))
}

/// Returns the size and the time of modification of a file, each behind a comma.
fn version(path: &Path) -> String {
    let Ok(about) = fs::metadata(path) else { return String::new() };
    let since = about.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok());
    let modified = since.map_or_else(String::new, |since| {
        format!(", modified {}.{:09}", since.as_secs(), since.subsec_nanos())
    });
    format!(", {} bytes{modified}", about.len())
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

fn rows_of<'a, T: BlasReal>(path: &Path, a: &'a Matrix) -> Result<Rows<'a, T>> {
    Ok(match a {
        Matrix::F32(dense) => Box::new(DenseRows(dense.as_ref())),
        Matrix::F64(dense) => Box::new(DenseRows(dense.as_ref())),
        Matrix::Sparse(sparse) => Box::new(SparseRows(sparse)),
        _ => bail!("{}: complex numbers, where real ones are needed", path.display()),
    })
}

/// Opens a table that is read block by block: a large one of text, or any in a columnar format,
/// which is opened without being read.
fn large_table(path: &Path, options: &ReadOptions<'_>) -> Result<Option<TableFile>> {
    let is_columnar = options.format.is_none() && TableFile::is_columnar(path);
    let is_streamed = |len: u64| is_columnar || len >= STREAMED;
    if !fs::metadata(path).is_ok_and(|about| about.is_file() && is_streamed(about.len())) {
        return Ok(None);
    }
    let bar = Bar::new("reading");
    let update = |fraction| bar.update(fraction);
    named(path, TableFile::open_one_of_several(path, &options.clone().progress(&update)))
}

fn read(path: &Path, options: &ReadOptions<'_>) -> Result<FileContent> {
    let bar = Bar::new("reading");
    let update = |fraction| bar.update(fraction);
    named(path, files::read_one_of_several(path, &options.clone().progress(&update)))
}

/// Refuses options of tables that apply to none of the files of a command: A, B if there is one,
/// and weights.
pub fn check_options(
    a: &Source,
    b: Option<&Source>,
    weights: Option<&Path>,
    options: &ReadOptions<'_>,
) -> Result<()> {
    let formats: Vec<_> = [Some(a), b].into_iter().flatten().map(Source::format).collect();
    // By their name; a check after they are read would be late.
    let is_text = |path: &Path| !RowFile::is_one(path) && !TableFile::is_columnar(path);
    Ok(options.check_effects(a.path(), &formats, weights.is_some_and(is_text))?)
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

/// Reads the weights of the rows of A from a file with one row or one column, also of HDF5
/// (`FILE.h5:/dataset`).
pub fn read_weights(path: &Path, a: &Source, table: &TableArgs) -> Result<Vec<f64>> {
    a.refuse_dropped(path)?;
    let m = a.shape().0;
    let options = table.of_weights();
    let source = Source::open(path, &options).map_err(of_weights)?;
    source.say(&options)?;
    let (nrows, ncols) = source.shape();
    if (nrows, ncols) != (m, 1) && (nrows, ncols) != (1, m) {
        bail!(
            "{}: {nrows} x {ncols} where the {m} rows of {} need {m} weights",
            path.display(),
            a.path().display()
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

/// Returns the error of a file of weights without advice that applies to A only: a weight may
/// neither be missing nor be in a column that is left out.
fn of_weights(error: anyhow::Error) -> anyhow::Error {
    let shorter = match error.downcast_ref() {
        Some(catamaran::Error::Io { path, line, what, .. }) => {
            // The advice for a missing cell, and for a word that may stand for one.
            what.split_once("; option `missing").map(|(fact, _)| catamaran::Error::Io {
                path: path.clone(),
                line: *line,
                what: format!("{fact}: each row needs a weight"),
                cause: None,
            })
        }
        _ => None,
    };
    shorter.map_or(error, Into::into)
}

/// Returns the power of two that the largest weight of exact sums must reach: their units are no
/// smaller.
fn least_power<T: Real>() -> i32 {
    if size_of::<T>() == 8 { -800 } else { -76 }
}

/// Checks that weights keep their digits in exact sums of scalars T.
///
/// # Errors
/// All of them are too small, but not all are 0.
pub fn check_size_of_weights<T: Real>(path: &Path, weights: &[f64]) -> Result<()> {
    let largest = weights.iter().fold(0.0_f64, |most, w| most.max(w.abs()));
    if largest > 0.0 && largest < 2.0_f64.powi(least_power::<T>()) {
        bail!(
            "{}: the weights are too small: the largest is {largest:e}; multiply them by a power \
             of ten",
            path.display()
        );
    }
    Ok(())
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

    fn coding(&self) -> Option<Coding> {
        self.rows.coding()
    }

    fn read_coded(&mut self, first: usize, mut out: MatMut<'_, T>) -> catamaran::Result<()> {
        let (list, rows) = (self.list, &mut self.rows);
        list.for_each(first..first + out.nrows(), |place, range| {
            let out = out.rb_mut().subrows_mut(place, range.len());
            rows.read_coded(range.start, out)
        })
    }
}

/// Returns a number that distinguishes weights: FNV-1a of their bits.
pub fn fingerprint(weights: &[f64]) -> u64 {
    fnv_1a(weights.iter().flat_map(|w| w.to_le_bytes()))
}

/// Returns a number that distinguishes lists of indices: FNV-1a of their bytes.
pub fn fingerprint_of_indices(indices: &[u32]) -> u64 {
    fnv_1a(indices.iter().flat_map(|i| i.to_le_bytes()))
}

/// Returns a number that distinguishes texts: FNV-1a of their bytes.
pub fn fingerprint_of_text(text: &str) -> u64 {
    fnv_1a(text.bytes())
}

fn fnv_1a(bytes: impl Iterator<Item = u8>) -> u64 {
    let mix = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    bytes.fold(0xcbf2_9ce4_8422_2325, mix)
}
