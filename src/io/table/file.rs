//! Text tables whose rows are read block by block.

use std::fmt;
use std::fs::File;
use std::io::{Seek, SeekFrom};
use std::path::{Path, PathBuf};

use faer::MatMut;

use super::encoding::{self, HEAD};
use super::engine::{Engine, begin, copy_rows};
use super::factors::Factors;
use super::layout::Layout;
use super::message::no_rows;
use super::options::{Missing, TableOptions};
use super::reading::TableReading;
use super::text::Text;
use crate::base::{Error, Real, Result, push};
use crate::io::ReadOptions;
use crate::io::columns::Columns;
use crate::io::limits::{longest_line, memory_limit};
use crate::io::names::{FileFormat, begins_mtx, lower_name};
use crate::io::packing::Packing;
use crate::io::rows::{CHANGED, Stamp, canonical, check_rows, seekable};
use crate::io::source::{error, error_at};
use crate::rows::RowBlocks;

/// A text table whose rows are read block by block. Opening it counts the rows, and finds the
/// levels of factors and the rows with missing cells that are left out.
///
/// Rows that follow one another are read once; a step back reads again from the megabyte before it.
pub struct TextFile {
    path: PathBuf,
    options: TableOptions,
    columns: Columns,
    layout: Layout,
    reading: TableReading,
    factors: std::sync::Arc<Factors>,
    marks: std::sync::Arc<Vec<Mark>>,
    nrows: usize,
    stamp: Stamp,
    longest: usize,
    /// Reads the rows behind those in `held`.
    engine: Option<Engine<File>>,
    /// Entries of rows that were read.
    held: Vec<f64>,
    /// Rows in `held` that were given.
    given: usize,
    /// The first row in `held` that was not given.
    next: usize,
}

/// A place in the file where a record begins.
#[derive(Debug, Clone, Copy)]
struct Mark {
    row: usize,
    offset: u64,
    lines: usize,
}

impl fmt::Debug for TextFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TextFile").field("path", &self.path).finish_non_exhaustive()
    }
}

impl TextFile {
    /// Opens a table, and reads it once; `None` for other formats and for text that is packed, must
    /// be decoded or has no place in a plain file, which [`read_file`](crate::io::read_file) reads.
    ///
    /// # Errors
    /// As [`read_file`](crate::io::read_file).
    pub fn open(path: &Path, options: &ReadOptions<'_>) -> Result<Option<Self>> {
        let Ok(stamp) = seekable(path) else { return Ok(None) };
        let format = options.format.or(FileFormat::of_name(path).map(|(format, _)| format));
        if format != Some(FileFormat::Table) {
            return Ok(None);
        }
        let (table, columns) = (&options.table, &options.columns);
        let longest = longest_line(memory_limit(stamp.len, options.max_memory));
        let open = || File::open(path).map_err(|e| error_at(path, None, e));
        let mut text = Text::new(path, open()?, 0, 0, longest);
        text.hold(HEAD)?;
        let (_, named) = Packing::of(&lower_name(path));
        let packing = named.or_of_content(text.held());
        packing.check(text.held()).map_err(|e| error_at(path, None, e))?;
        // Of another format, in spite of its name.
        let is_other =
            options.format.is_none() && (text.held().contains(&0) || begins_mtx(text.held()));
        if packing != Packing::None
            || is_other
            || encoding::detect(text.held(), table.encoding.as_deref())?.is_some()
        {
            return Ok(None);
        }
        let mut text = Text::new(path, open()?, 0, 0, longest);
        let (layout, mut reading) = begin(&mut text, table, columns)?;
        let mut factors = Factors::new(&layout);
        let needs_cells = layout.missing == Missing::Drop || layout.nfactors > 0;
        let mut engine = Engine::new(text, layout, table.par);
        let (mut marks, mut nrows, mut dropped) = (Vec::new(), 0, 0);
        loop {
            let (offset, lines) = (engine.text.offset, engine.text.lines);
            let Some(batch) = engine.next(!needs_cells)? else { break };
            push(&mut marks, Mark { row: nrows, offset, lines })?;
            engine.pieces().iter().for_each(|piece| factors.learn(piece));
            nrows += batch.rows;
            dropped += batch.dropped;
            options.progress.report(engine.text.offset as f64 / stamp.len.max(1) as f64)?;
        }
        if nrows == 0 {
            return Err(no_rows(path, engine.text.lines, dropped));
        }
        factors.sort(&mut [], engine.layout.ncols.max(1));
        factors.give_levels(&mut reading);
        reading.dropped_rows = dropped;
        reading.has_commented_rows |= engine.has_commented_rows;
        reading.rounded = engine.rounded.take();
        Ok(Some(Self {
            path: path.into(),
            options: table.clone(),
            columns: columns.clone(),
            layout: engine.layout,
            reading,
            factors: factors.into(),
            marks: marks.into(),
            nrows,
            stamp,
            longest,
            engine: None,
            held: Vec::new(),
            given: 0,
            next: 0,
        }))
    }

    /// Opens the same rows once more, for a second reader.
    ///
    /// # Errors
    /// [`Error::Io`] when the file has changed since it was opened.
    pub fn try_clone(&self) -> Result<Self> {
        self.stamp.check(&self.path, std::fs::metadata(&self.path))?;
        Ok(Self {
            path: self.path.clone(),
            options: self.options.clone(),
            columns: self.columns.clone(),
            layout: self.layout.clone(),
            reading: self.reading.clone(),
            factors: self.factors.clone(),
            marks: self.marks.clone(),
            nrows: self.nrows,
            stamp: self.stamp,
            longest: self.longest,
            engine: None,
            held: Vec::new(),
            given: 0,
            next: 0,
        })
    }

    /// Returns how the table is read.
    pub fn reading(&self) -> &TableReading {
        &self.reading
    }

    /// Returns the number of rows.
    pub fn nrows(&self) -> usize {
        self.nrows
    }

    /// Returns the number of columns.
    pub fn ncols(&self) -> usize {
        self.layout.ncols
    }

    /// Returns a line of text that identifies these rows and their version, as that of
    /// [`RowFile::identity`](crate::io::RowFile::identity).
    pub fn identity(&self) -> String {
        let (path, columns, stamp) = (canonical(&self.path), &self.columns, self.stamp);
        let (m, n, options) = (self.nrows, self.layout.ncols, self.options.identity());
        format!("{}, {m} x {n}, {columns}{options}, {stamp}", path.display())
    }

    /// Goes to a row.
    fn seek(&mut self, row: usize) -> Result<()> {
        let at = self.marks.partition_point(|mark| mark.row <= row).max(1) - 1;
        let Mark { row: first, offset, lines } = self.marks[at];
        let fail = |e| error_at(&self.path, None, e);
        let mut file = File::open(&self.path).map_err(fail)?;
        self.stamp.check(&self.path, file.metadata())?;
        file.seek(SeekFrom::Start(offset)).map_err(fail)?;
        let text = Text::new(&self.path, file, offset, lines, self.longest);
        self.engine = Some(Engine::new(text, self.layout.clone(), self.options.par));
        self.held.clear();
        (self.given, self.next) = (0, first);
        while self.next < row {
            let rows = self.some_rows(row - self.next)?;
            self.give(rows);
        }
        Ok(())
    }

    /// Makes at least a row be held, and returns how many of the next `most` are.
    fn some_rows(&mut self, most: usize) -> Result<usize> {
        let ncols = self.layout.ncols;
        loop {
            let held = self.held.len() / ncols.max(1) - self.given;
            if held > 0 {
                return Ok(held.min(most));
            }
            self.given = 0;
            self.held.clear();
            let changed = || error(&self.path, None, CHANGED);
            // After an error there is none, so that the next call begins again.
            let Some(mut engine) = self.engine.take() else { return Err(changed()) };
            if engine.next(false)?.is_none() {
                return Err(changed());
            }
            for piece in engine.pieces() {
                let start = self.held.len();
                self.held.extend_from_slice(&piece.values);
                if !self.factors.translate(piece, &mut self.held[start..], ncols.max(1)) {
                    return Err(changed());
                }
            }
            self.engine = Some(engine);
        }
    }

    /// Counts rows of `held` as given.
    fn give(&mut self, rows: usize) {
        self.given += rows;
        self.next += rows;
    }
}

impl<T: Real> RowBlocks<T> for TextFile {
    fn nrows(&self) -> usize {
        self.nrows
    }

    fn ncols(&self) -> usize {
        self.layout.ncols
    }

    fn read(&mut self, first: usize, mut out: MatMut<'_, T>) -> Result<()> {
        let (ncols, count) = (self.layout.ncols, out.nrows());
        check_rows(first, count, self.nrows)?;
        Error::check_shape("block of rows", (count, ncols), out.shape())?;
        if count == 0 || ncols == 0 {
            return Ok(());
        }
        if self.engine.is_none() || self.next != first {
            self.seek(first)?;
        }
        let mut done = 0;
        while done < count {
            let rows = self.some_rows(count - done)?;
            let held = &self.held[self.given * ncols..][..rows * ncols];
            copy_rows(held, done, &mut out);
            self.give(rows);
            done += rows;
        }
        Ok(())
    }
}
