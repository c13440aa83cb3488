//! Columnar files whose rows are read block by block.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use faer::MatMut;
use faer::prelude::ReborrowMut;

use super::arrow::ArrowStore;
use super::group::{Context, Group, Used};
use super::parquet::ParquetStore;
use super::plan::plan;
use super::store::Store;
use super::words::Words;
use crate::base::{Error, Real, Result};
use crate::io::ReadOptions;
use crate::io::columns::Columns;
use crate::io::limits::{LARGER_MAX_MEMORY, check_memory, memory_limit};
use crate::io::matrix::Dense;
use crate::io::names::FileFormat;
use crate::io::rounding::RoundedIntegers;
use crate::io::rows::{Stamp, canonical, check_rows, seekable};
use crate::io::source::error;
use crate::io::table::{ColumnKind, Missing, TableOptions, TableReading, option, texts};
use crate::rows::RowBlocks;

/// A Parquet or Arrow file whose rows are read block by block.
pub struct ColumnarFile {
    path: PathBuf,
    options: TableOptions,
    columns: Columns,
    store: Arc<dyn Store>,
    used: Arc<Vec<Used>>,
    reading: TableReading,
    /// The first row of each group among those that are kept, and the number of all.
    starts: Arc<Vec<usize>>,
    stamp: Stamp,
    group: Option<Group>,
    /// Decoded rows of the group that were given.
    given: usize,
    /// The first row that was not given.
    next: usize,
}

impl fmt::Debug for ColumnarFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ColumnarFile").field("path", &self.path).finish_non_exhaustive()
    }
}

impl ColumnarFile {
    /// Opens a file of this format. Reads all columns where rows are dropped, else those of words
    /// and of integers that may be rounded, once.
    ///
    /// # Errors
    /// [`Error::Io`] names the file and what is wrong; [`Error::Argument`] for columns that do not
    /// exist or have no numbers.
    pub fn open(path: &Path, format: FileFormat, options: &ReadOptions<'_>) -> Result<Self> {
        let stamp = seekable(path)?;
        let limit = memory_limit(stamp.len, options.max_memory);
        let store: Arc<dyn Store> = match format {
            FileFormat::Parquet => Arc::new(ParquetStore::open(path, stamp.len, limit)?),
            _ => Arc::new(ArrowStore::open(path, stamp.len, limit)?),
        };
        let contents = store.contents();
        let all = contents.groups.iter().sum::<usize>();
        // Nulls, and what repeats, may take no bytes: rows beyond one for each byte that the file
        // may unpack to would take hours.
        if all as u64 > limit.max(memory_limit(stamp.len, None)) {
            let what = format!("announces {all} rows in {} bytes: {LARGER_MAX_MEMORY}", stamp.len);
            return Err(error(path, None, what));
        }
        let table = &options.table;
        let mut reading = plan(path, format, contents, table, &options.columns)?;
        let words = |kind: &ColumnKind| match kind {
            ColumnKind::Numbers => None,
            ColumnKind::Factor { .. } => Some(Arc::new(Words::new(limit))),
        };
        let mut used: Vec<Used> = reading
            .columns
            .iter()
            .map(|column| Used { column: column.clone(), words: words(&column.kind) })
            .collect();
        let context = Context { path, store: &*store, missing: table.missing, par: table.par };
        let Scan { kept, seen, rounded } = scan(context, &used, options)?;
        reading.rounded = rounded;
        for ((used, column), seen) in used.iter_mut().zip(&mut reading.columns).zip(seen) {
            if let (Some(words), ColumnKind::Factor { levels }) = (&used.words, &mut column.kind) {
                let sorted = words.sorted(&seen);
                *levels = texts(&sorted);
                used.words = Some(Arc::new(Words::closed(&sorted)));
            }
        }
        let mut starts = vec![0];
        for rows in kept {
            starts.push(starts[starts.len() - 1] + rows);
        }
        let nrows = starts[starts.len() - 1];
        reading.dropped_rows = (all - nrows) as u64;
        if nrows == 0 && all > 0 {
            let columns = option("columns");
            let what =
                format!("each of its {all} rows has a missing cell; {columns} leaves columns out");
            return Err(error(path, None, what));
        }
        Ok(Self {
            path: path.into(),
            options: table.clone(),
            columns: options.columns.clone(),
            store,
            used: used.into(),
            reading,
            starts: starts.into(),
            stamp,
            group: None,
            given: 0,
            next: 0,
        })
    }

    /// Opens the same rows once more, for a second reader.
    pub fn try_clone(&self) -> Result<Self> {
        self.check_stamp()?;
        Ok(Self {
            path: self.path.clone(),
            options: self.options.clone(),
            columns: self.columns.clone(),
            store: self.store.clone(),
            used: self.used.clone(),
            reading: self.reading.clone(),
            starts: self.starts.clone(),
            stamp: self.stamp,
            group: None,
            given: 0,
            next: 0,
        })
    }

    pub fn reading(&self) -> &TableReading {
        &self.reading
    }

    pub fn nrows(&self) -> usize {
        self.starts.last().copied().unwrap_or(0)
    }

    pub fn ncols(&self) -> usize {
        self.used.len()
    }

    /// Returns a line of text that identifies these rows and their version.
    pub fn identity(&self) -> String {
        let (path, columns, stamp) = (canonical(&self.path), &self.columns, self.stamp);
        let (m, n, format) = (self.nrows(), self.ncols(), self.reading.format);
        let options = self.options.identity();
        format!("{}, {m} x {n} of {format:?}, {columns}{options}, {stamp}", path.display())
    }

    /// Reads all rows.
    pub fn read_all(mut self, options: &ReadOptions<'_>) -> Result<(Dense<f64>, TableReading)> {
        let (m, n) = (self.nrows(), self.ncols());
        let bytes = (m as u64).saturating_mul(n as u64).saturating_mul(size_of::<f64>() as u64);
        check_memory(memory_limit(self.stamp.len, options.max_memory), "the matrix", bytes)
            .map_err(|what| error(&self.path, None, what))?;
        let mut values = crate::base::zeros::<f64>(m.saturating_mul(n))?;
        let mut all = MatMut::from_row_major_slice_mut(&mut values, m, n);
        for first in (0..m).step_by(super::group::BATCH) {
            let count = super::group::BATCH.min(m - first);
            RowBlocks::<f64>::read(&mut self, first, all.rb_mut().subrows_mut(first, count))?;
            options.progress.report((first + count) as f64 / m as f64)?;
        }
        Ok((Dense::new(values, (m, n), true, 0..n), self.reading))
    }

    fn context(&self) -> Context<'_> {
        let Self { path, store, options, .. } = self;
        Context { path, store: &**store, missing: options.missing, par: options.par }
    }

    /// Checks that the file has not changed.
    fn check_stamp(&self) -> Result<()> {
        self.stamp.check(&self.path, std::fs::metadata(&self.path))
    }

    /// Opens a group.
    fn open_group(&self, number: usize) -> Result<Group> {
        self.check_stamp()?;
        Group::open(self.context(), number, self.used.iter())
    }

    /// Goes to a row.
    fn seek(&mut self, row: usize) -> Result<()> {
        // The last of the groups that begin there is the one with rows.
        let number = self.starts.partition_point(|&start| start <= row).max(1) - 1;
        self.group = Some(self.open_group(number)?);
        (self.given, self.next) = (0, self.starts[number]);
        while self.next < row {
            let rows = self.decoded(row - self.next)?;
            self.given += rows;
            self.next += rows;
        }
        Ok(())
    }

    /// Decodes rows until one that is kept was not given, and returns how many there are, at most
    /// `most`.
    fn decoded(&mut self, most: usize) -> Result<usize> {
        loop {
            let context = Context {
                path: &self.path,
                store: &*self.store,
                missing: self.options.missing,
                par: self.options.par,
            };
            let next = match &mut self.group {
                Some(group) if self.given < group.kept() => {
                    return Ok(most.min(group.kept() - self.given));
                }
                Some(group) if group.left > 0 => {
                    let done = group.next(context);
                    let done = self.check_stamp().and(done);
                    if done.is_err() {
                        // Its columns may be at different rows: the next call opens it again.
                        self.group = None;
                    }
                    done?;
                    self.given = 0;
                    continue;
                }
                Some(group) => group.number + 1,
                None => 0,
            };
            if next >= self.store.contents().groups.len() {
                return Err(error(&self.path, None, "fewer rows than it announces"));
            }
            self.group = Some(self.open_group(next)?);
            self.given = 0;
        }
    }
}

/// What is known once the columns are read that need it.
struct Scan {
    /// The number of rows of each group that are kept.
    kept: Vec<usize>,
    /// Which words the rows have, for each column.
    seen: Vec<Vec<bool>>,
    rounded: Option<RoundedIntegers>,
}

/// Reads all columns where rows are dropped, else those of words and of integers of which some may
/// be no f64.
fn scan(context: Context<'_>, used: &[Used], options: &ReadOptions<'_>) -> Result<Scan> {
    let groups = &context.store.contents().groups;
    // A missing cell that is an error is found in the order of rows, when they are read.
    let drops = context.missing == Missing::Drop;
    let missing = if drops { Missing::Drop } else { Missing::Nan };
    let context = Context { missing, ..context };
    let mut kept = groups.clone();
    let mut seen = vec![Vec::new(); used.len()];
    // The number of the next row in the file.
    let mut first = 0;
    let mut rounded = None;
    let is_needed = |&j: &usize| {
        drops || used[j].words.is_some() || context.store.may_round(used[j].column.number)
    };
    let needed: Vec<usize> = (0..used.len()).filter(is_needed).collect();
    for (number, kept) in kept.iter_mut().enumerate() {
        if needed.is_empty() {
            continue;
        }
        let mut group = Group::open(context, number, needed.iter().map(|&j| &used[j]))?;
        *kept = 0;
        while group.left > 0 {
            let before = group.left;
            group.next(context)?;
            *kept += group.kept();
            let mut lowest: Option<(usize, usize)> = None;
            let mut count = 0;
            for (at, &j) in needed.iter().enumerate() {
                if used[j].words.is_some() {
                    group.mark(at, &mut seen[j]);
                    continue;
                }
                for row in group.rounded(at) {
                    count += 1;
                    lowest = lowest.min(Some((row, j))).or(Some((row, j)));
                }
            }
            let (row, column) = lowest.unwrap_or_default();
            RoundedIntegers::add(&mut rounded, count, || {
                let name = &used[column].column.name;
                format!("row {} (counted from 0), column {name}", first + row)
            });
            first += before - group.left;
            options.progress.report(number as f64 / groups.len() as f64)?;
        }
    }
    Ok(Scan { kept, seen, rounded })
}

impl<T: Real> RowBlocks<T> for ColumnarFile {
    fn nrows(&self) -> usize {
        self.nrows()
    }

    fn ncols(&self) -> usize {
        self.ncols()
    }

    fn read(&mut self, first: usize, mut out: MatMut<'_, T>) -> Result<()> {
        let count = out.nrows();
        check_rows(first, count, self.nrows())?;
        Error::check_shape("block of rows", (count, self.ncols()), out.shape())?;
        if count == 0 || self.ncols() == 0 {
            return Ok(());
        }
        if self.group.is_none() || self.next != first {
            self.seek(first)?;
        }
        let mut done = 0;
        while done < count {
            let rows = self.decoded(count - done)?;
            if let Some(group) = &self.group {
                let out = out.rb_mut().subrows_mut(done, rows);
                group.copy(self.given, out, self.options.par);
            }
            self.given += rows;
            self.next += rows;
            done += rows;
        }
        Ok(())
    }
}
