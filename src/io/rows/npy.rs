//! Rows of NumPy arrays.
//!
//! A file is a sequence of lines: rows in C order, columns in Fortran order. A block of rows of the
//! latter is the transpose of a piece of every line.

use std::fs::File;
use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};

use faer::MatMut;
use faer::prelude::ReborrowMut;

use super::file::{BUFFER, Stamp, canonical, seekable, shrank};
use crate::base::{Real, Result};
use crate::io::SourceOptions;
use crate::io::npy::{Layout, trailing, truncated};
use crate::io::packing::Packing;
use crate::io::rounding::FirstRounded;
use crate::io::source::{Source, error, error_at};

/// Entries between the pieces of two lines are also read when they have at most this many bytes,
/// because that takes less time than a seek.
const GAP: usize = 4096;

#[derive(Debug)]
pub(super) struct NpyRows {
    path: PathBuf,
    file: File,
    layout: Layout,
    stamp: Stamp,
    /// Bytes of the file that are being converted.
    buffer: Vec<u8>,
}

impl NpyRows {
    pub(super) fn open(path: &Path) -> Result<Self> {
        // The open of a pipe would wait.
        seekable(path)?;
        // Blocks are read at their offsets in the file, which a packed file does not have.
        let options = SourceOptions::new();
        let layout = Layout::read(&mut Source::open_packed(path, |_| Packing::None, &options)?)?;
        let opened = File::open(path).and_then(|file| file.metadata().map(|about| (file, about)));
        let (file, metadata) = opened.map_err(|e| error_at(path, None, e))?;
        let stamp = Stamp::of(&metadata);
        let entries = (layout.len() as u64).checked_mul(layout.entry.bytes() as u64);
        let end = entries.and_then(|bytes| bytes.checked_add(layout.offset));
        match end {
            Some(end) if stamp.len == end => {}
            Some(end) if stamp.len > end => return Err(error(path, None, trailing(layout.len()))),
            _ => return Err(error(path, None, truncated(layout.len()))),
        }
        Ok(Self { path: path.into(), file, layout, stamp, buffer: Vec::new() })
    }

    pub(super) fn shape(&self) -> (usize, usize) {
        self.layout.shape
    }

    pub(super) fn is_single(&self) -> bool {
        self.layout.is_single()
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn origin(&self) -> String {
        let order = if self.layout.row_major { "C" } else { "Fortran" };
        format!("{}, {:?} in {order} order", canonical(&self.path).display(), self.layout.entry)
    }

    pub(super) fn stamp(&self) -> Stamp {
        self.stamp
    }

    /// Reads a block. Both ranges lie inside the matrix and are not empty; `out` has their shape.
    pub(super) fn read<T: Real>(
        &mut self,
        rows: Range<usize>,
        columns: Range<usize>,
        out: MatMut<'_, T>,
        rounded: &FirstRounded,
    ) -> Result<()> {
        if self.layout.row_major {
            self.read_lines(rows, columns, out, rounded)?;
        } else {
            self.read_lines(columns, rows, out.transpose_mut(), rounded)?;
        }
        self.stamp.check(&self.path, self.file.metadata())
    }

    fn read_lines<T: Real>(
        &mut self,
        lines: Range<usize>,
        entries: Range<usize>,
        mut out: MatMut<'_, T>,
        rounded: &FirstRounded,
    ) -> Result<()> {
        let (rows, columns) = self.layout.shape;
        let line = if self.layout.row_major { columns } else { rows };
        let size = self.layout.entry.bytes();
        let at_once = BUFFER / size;
        let together = (line - entries.len()).saturating_mul(size) <= GAP;
        let height = if together { (at_once / line).max(1) } else { 1 };
        let mut values = Vec::new();
        for i in (0..lines.len()).step_by(height) {
            let height = height.min(lines.len() - i);
            for j in (0..entries.len()).step_by(at_once) {
                let width = at_once.min(entries.len() - j);
                let start = (lines.start + i) * line + entries.start + j;
                let out = out.rb_mut().submatrix_mut(i, j, height, width);
                self.read_piece(start, line, out, &mut values, rounded)?;
            }
        }
        Ok(())
    }

    /// Fills `out` with the entries from `start` on. Each row of it starts `line` entries later.
    fn read_piece<T: Real>(
        &mut self,
        start: usize,
        line: usize,
        mut out: MatMut<'_, T>,
        values: &mut Vec<T>,
        rounded: &FirstRounded,
    ) -> Result<()> {
        let (height, width) = out.shape();
        let (entry, big) = (self.layout.entry, self.layout.big);
        let native = big == cfg!(target_endian = "big");
        let same = entry.is::<T>() && native;
        if same
            && (width == line || height == 1)
            && let Some(bytes) = bytes_of(out.rb_mut())
        {
            return read_at(&mut self.file, &self.layout, &self.path, start, bytes);
        }
        let count = (height - 1) * line + width;
        self.buffer.resize(count * entry.bytes(), 0);
        read_at(&mut self.file, &self.layout, &self.path, start, &mut self.buffer)?;
        let layout = &self.layout;
        entry.each_rounded(big, &self.buffer, |at| {
            // Between the pieces of two lines are entries that are not used.
            if at % line < width {
                let (row, column) = layout.place(start + at);
                rounded.add(row, column);
            }
        });
        values.clear();
        entry.decode(big, &self.buffer, values);
        for (i, row) in values.chunks(line).enumerate() {
            for (j, &value) in row[..width].iter().enumerate() {
                out[(i, j)] = value;
            }
        }
        Ok(())
    }
}

/// Fills `out` with the entries from `start` on.
fn read_at(
    file: &mut File,
    layout: &Layout,
    path: &Path,
    start: usize,
    out: &mut [u8],
) -> Result<()> {
    let at = layout.offset + start as u64 * layout.entry.bytes() as u64;
    file.seek(SeekFrom::Start(at)).and_then(|_| file.read_exact(out)).map_err(|e| match e.kind() {
        ErrorKind::UnexpectedEof => shrank(path),
        _ => error_at(path, None, e),
    })
}

/// Returns the memory of `out` if its rows follow one another without a gap.
fn bytes_of<T: Real>(out: MatMut<'_, T>) -> Option<&mut [u8]> {
    let (height, width) = out.shape();
    let lines = height == 1 || out.row_stride() == width as isize;
    let entries = width == 1 || out.col_stride() == 1;
    let bytes = height * width * size_of::<T>();
    // SAFETY: the entries fill this memory without a gap and are borrowed for as long as the
    // result; they are f32 or f64, of which every pattern of bytes is a value.
    (lines && entries)
        .then(|| unsafe { std::slice::from_raw_parts_mut(out.as_ptr_mut().cast(), bytes) })
}
