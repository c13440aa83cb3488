//! Rows of HDF5 datasets.

mod access;
mod entry;
mod layout;
mod listing;
mod packing;

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use ::hdf5::{Dataset, Dataspace, Datatype, File, H5Type, Hyperslab, LocationType, Selection};
use faer::MatMut;
use faer::prelude::ReborrowMut;

pub(in crate::io) use self::access::open;
use self::entry::{Entry, Long};
use self::layout::{Chunks, Sources};
use self::packing::Packing;
use super::file::{BUFFER, Stamp, canonical, seekable};
use crate::base::{Real, Result, reserved};
use crate::io::extents::padded_bytes;
use crate::io::rounding::{FirstRounded, is_rounded};
use crate::io::source::{error, error_at};

#[derive(Debug)]
pub(super) struct DatasetRows {
    path: PathBuf,
    dataset: Dataset,
    /// The dataset's own name in the file that holds it.
    name: String,
    /// The file that a link in `path` leads to, or `path` itself.
    holder: PathBuf,
    stamp: Stamp,
    /// The files that hold the entries of a virtual dataset.
    sources: Sources,
    shape: (usize, usize),
    dimensions: usize,
    /// Whether the rows of the matrix are the columns of the dataset.
    transposed: bool,
    entry: Entry,
    packing: Packing,
    /// Rows that are packed together.
    chunk_rows: usize,
    notes: Vec<String>,
    /// Closed after the dataset: fields are dropped in order.
    _file: File,
}

/// A number as HDF5 gives it.
trait Stored: H5Type + Copy + Default {
    /// Returns the nearest f64.
    fn number(self) -> f64;

    /// Returns whether the number is an integer and no f64.
    fn is_rounded(self) -> bool {
        false
    }
}

impl Stored for f32 {
    fn number(self) -> f64 {
        self.into()
    }
}

impl Stored for f64 {
    fn number(self) -> f64 {
        self
    }
}

impl Stored for i64 {
    fn number(self) -> f64 {
        self as f64
    }

    fn is_rounded(self) -> bool {
        is_rounded(self.unsigned_abs().into())
    }
}

impl Stored for u64 {
    fn number(self) -> f64 {
        self as f64
    }

    fn is_rounded(self) -> bool {
        is_rounded(self.into())
    }
}

impl DatasetRows {
    /// Opens the dataset of this name, or the only one of two dimensions.
    pub(super) fn open(path: &Path, name: Option<&str>) -> Result<Self> {
        seekable(path)?;
        let (file, unlocked) = open(path)?;
        let name = match name {
            Some(name) => name.to_owned(),
            None => listing::only(path, &file)?,
        };
        let dataset = match file.dataset(&name) {
            Ok(dataset) => dataset,
            Err(_) if file.loc_type_by_name(&name).ok() != Some(LocationType::Dataset) => {
                return Err(listing::missing(path, &file, &name));
            }
            Err(e) => return Err(error(path, None, format!("dataset {name}: HDF5 says: {e}"))),
        };
        let refuse = |why: String| error(path, None, format!("dataset {name} {why}"));
        if dataset.attr("MATLAB_empty").is_ok() {
            return Err(refuse("is an empty matrix of MATLAB".into()));
        }
        let class = dataset.attr("MATLAB_class").ok();
        if class.as_ref().and_then(packing::text).is_some_and(|class| class == "char") {
            return Err(refuse("is text of MATLAB, not real numbers".into()));
        }
        let dimensions = dataset.ndim();
        // MATLAB stores columns one after another, and writes the extents in this order.
        let transposed = dimensions == 2 && class.is_some();
        let shape = match dataset.shape()[..] {
            [rows] => (rows, 1),
            [columns, rows] if transposed => (rows, columns),
            [rows, columns] => (rows, columns),
            ref other => {
                return Err(refuse(format!(
                    "has {} dimensions, where a matrix has 2",
                    other.len()
                )));
            }
        };
        padded_bytes(&[shape.0, shape.1], size_of::<f64>())
            .map_err(|what| refuse(format!("has a {what}")))?;
        let entry = Entry::of(&dataset).map_err(refuse)?;
        let packing = Packing::of(&dataset, &entry).map_err(refuse)?;
        let holder = PathBuf::from(dataset.filename());
        let metadata = fs::metadata(&holder).map_err(|e| error_at(&holder, None, e))?;
        let sources = layout::sources(&dataset, &holder).map_err(refuse)?;
        layout::check_filters(&dataset).map_err(refuse)?;
        let own_name = dataset.name();
        let bytes = dataset.dtype().map_or(size_of::<f64>(), |kind| kind.size());
        let chunks = Chunks::of(&dataset, shape, bytes, transposed);
        // The settings of chunks are those of the first one of several handles.
        drop(dataset);
        let dataset = chunks.open(&file, &name).map_err(|e| access::fail(path, &e))?;
        let mut notes: Vec<String> = unlocked.into_iter().collect();
        let of_dataset = packing.notes().into_iter().chain(entry.note.clone()).chain(chunks.note);
        notes.extend(of_dataset.map(|note| format!("dataset {name}: {note}")));
        Ok(Self {
            path: path.into(),
            name: own_name,
            holder,
            stamp: Stamp::of(&metadata),
            sources,
            shape,
            dimensions,
            transposed,
            entry,
            packing,
            chunk_rows: chunks.rows,
            notes,
            dataset,
            _file: file,
        })
    }

    pub(super) fn shape(&self) -> (usize, usize) {
        self.shape
    }

    pub(super) fn is_single(&self) -> bool {
        self.entry.is_single && !self.packing.has_scale()
    }

    /// Returns the number of rows that are packed together.
    pub(super) fn chunk_rows(&self) -> usize {
        self.chunk_rows
    }

    /// Returns what a user of the rows may not expect, one sentence each.
    pub(super) fn notes(&self) -> &[String] {
        &self.notes
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn origin(&self) -> String {
        let (holder, kind) = (canonical(&self.holder), &self.entry.text);
        let mut text = format!("{}:{}, {kind}", holder.display(), self.name);
        if !self.packing.is_none() {
            text += &format!(", {}", self.packing);
        }
        for (path, stamp) in &self.sources {
            text += &format!(", with {} ({stamp})", canonical(path).display());
        }
        text
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
        let as_stored = self.packing.is_none() && !self.transposed;
        let done = match (self.entry.long, self.is_single(), T::NAME == f32::NAME) {
            // The library does not tell which of them it rounds.
            (Some(Long::Signed), ..) => self.read_pieces::<T, i64>(rows, columns, out, rounded),
            (Some(Long::Unsigned), ..) => self.read_pieces::<T, u64>(rows, columns, out, rounded),
            (None, true, true) if as_stored => {
                self.read_same::<T, f32>(rows, columns, out, rounded)
            }
            (None, false, false) if as_stored => {
                self.read_same::<T, f64>(rows, columns, out, rounded)
            }
            (None, true, _) => self.read_pieces::<T, f32>(rows, columns, out, rounded),
            (None, false, _) => self.read_pieces::<T, f64>(rows, columns, out, rounded),
        };
        // This check comes first, because HDF5 reads missing bytes at the end of a file as zeros,
        // or fails with another message.
        self.stamp.check(&self.holder, fs::metadata(&self.holder))?;
        for (path, stamp) in &self.sources {
            stamp.check(path, fs::metadata(path))?;
        }
        done
    }

    /// Reads a block in the precision of the file: T is S.
    fn read_same<T: Real, S: Stored>(
        &self,
        rows: Range<usize>,
        columns: Range<usize>,
        out: MatMut<'_, T>,
        rounded: &FirstRounded,
    ) -> Result<()> {
        let (height, width) = out.shape();
        let rows_apart = height == 1 || out.row_stride() >= width as isize;
        if rows_apart && (width == 1 || out.col_stride() == 1) {
            // A column is a row-major matrix too, whatever the stride along its one-entry rows.
            let stride = if height == 1 { width } else { out.row_stride().unsigned_abs() };
            // SAFETY: T is S; entry (i, j) is at i * stride + j, j < width <= stride.
            return unsafe {
                self.read_into::<S>(rows, columns, out.as_ptr_mut().cast(), height, width, stride)
            };
        }
        self.read_pieces::<T, S>(rows, columns, out, rounded)
    }

    /// Reads a block through a buffer of numbers S, and gives each entry its meaning.
    fn read_pieces<T: Real, S: Stored>(
        &self,
        rows: Range<usize>,
        columns: Range<usize>,
        out: MatMut<'_, T>,
        rounded: &FirstRounded,
    ) -> Result<()> {
        // From here on, rows are those of the dataset.
        let (rows, columns, mut out) = match self.transposed {
            true => (columns, rows, out.transpose_mut()),
            false => (rows, columns, out),
        };
        let as_stored = self.packing.is_none();
        let at_once = BUFFER / size_of::<S>();
        let width = at_once.min(columns.len());
        let height = (at_once / width).min(rows.len());
        let mut values: Vec<S> = reserved(height * width)?;
        values.resize(height * width, S::default());
        for i in (0..rows.len()).step_by(height) {
            let height = height.min(rows.len() - i);
            for j in (0..columns.len()).step_by(width) {
                let width = width.min(columns.len() - j);
                let (row, column) = (rows.start + i, columns.start + j);
                let (rows, columns) = (row..row + height, column..column + width);
                // SAFETY: the buffer has as many entries, row after row.
                unsafe {
                    let to = values.as_mut_ptr();
                    self.read_into(rows, columns, to, height, width, width)?;
                }
                let mut out = out.rb_mut().submatrix_mut(i, j, height, width);
                for (i, entries) in values.chunks_exact(width).take(height).enumerate() {
                    for (j, &stored) in entries.iter().enumerate() {
                        let value = stored.number();
                        let meant = if as_stored { value } else { self.packing.value(value) };
                        // A missing entry has no value that was rounded.
                        if stored.is_rounded() && !meant.is_nan() {
                            let place = (row + i, column + j);
                            let place = if self.transposed { (place.1, place.0) } else { place };
                            rounded.add(place.0, place.1);
                        }
                        out[(i, j)] = T::from_f64(meant);
                    }
                }
            }
        }
        Ok(())
    }

    /// Makes HDF5 write the `height` x `width` entries, converted to S, entry (i, j) at `to + i *
    /// stride + j`.
    ///
    /// # Safety
    /// All these places may be written, and `stride >= width`.
    unsafe fn read_into<S: H5Type>(
        &self,
        rows: Range<usize>,
        columns: Range<usize>,
        to: *mut S,
        height: usize,
        width: usize,
        stride: usize,
    ) -> Result<()> {
        let select = |ranges: Vec<Range<usize>>| {
            let slices: Vec<_> = ranges.into_iter().map(Into::into).collect();
            Selection::from(Hyperslab::from(slices))
        };
        let source = if self.dimensions == 1 { vec![rows] } else { vec![rows, columns] };
        let transfer = || {
            let from = self.dataset.space()?.select(select(source))?;
            let target = Dataspace::try_new([height, stride])?;
            let target = target.select(select(vec![0..height, 0..width]))?;
            let memory = Datatype::from_type::<S>()?;
            ::hdf5::sync::sync(|| {
                let default = ::hdf5_sys::h5p::H5P_DEFAULT;
                // SAFETY: the handles are alive; HDF5 writes the selected entries only, those of
                // the caller.
                let status = unsafe {
                    ::hdf5_sys::h5d::H5Dread(
                        self.dataset.id(),
                        memory.id(),
                        target.id(),
                        from.id(),
                        default,
                        to.cast(),
                    )
                };
                if status < 0 { Err(::hdf5::Error::query().unwrap_or_else(|e| e)) } else { Ok(()) }
            })
        };
        transfer().map_err(|e: ::hdf5::Error| {
            error(&self.path, None, format!("dataset {}: HDF5 says: {e}", self.name))
        })
    }
}
