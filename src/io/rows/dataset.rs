//! Rows of HDF5 datasets.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use ::hdf5::dataset::Layout;
use ::hdf5::types::{FloatSize, TypeDescriptor};
use ::hdf5::{
    Dataset, Dataspace, Datatype, File, Group, H5Type, Hyperslab, LinkType, LocationType,
    MinorErrorCode, Selection,
};
use faer::MatMut;
use faer::prelude::ReborrowMut;

use super::file::{BUFFER, Stamp, canonical, seekable};
use crate::base::{Error, Real, Result, reserved};
use crate::io::extents::padded_bytes;
use crate::io::source::{error, error_at};

/// Bytes of unpacked chunks that are kept, and slots of the table that finds them: a prime, as the
/// documentation of HDF5 recommends.
const CACHE: (usize, usize) = (32 << 20, 12_421);

/// Datasets named in an error.
const LISTED: usize = 20;

#[derive(Debug)]
pub(super) struct DatasetRows {
    path: PathBuf,
    dataset: Dataset,
    /// The dataset's own name in the file that holds it.
    name: String,
    /// The file that a link in `path` leads to, or `path` itself.
    holder: PathBuf,
    stamp: Stamp,
    shape: (usize, usize),
    dimensions: usize,
    entry: TypeDescriptor,
    /// Closed after the dataset: fields are dropped in order.
    _file: File,
}

impl DatasetRows {
    /// Opens the dataset of this name, or the only one of two dimensions.
    pub(super) fn open(path: &Path, name: Option<&str>) -> Result<Self> {
        seekable(path)?;
        let file = File::with_options()
            .with_fapl(|access| access.chunk_cache(CACHE.1, CACHE.0, 1.0))
            .open(path)
            .map_err(|e| match e.contains_minor(MinorErrorCode::NotHdf5) {
                true => error(path, None, "not an HDF5 file"),
                false => fail(path, &e),
            })?;
        let name = match name {
            Some(name) => name.to_owned(),
            None => only(path, &file)?,
        };
        let dataset = match file.dataset(&name) {
            Ok(dataset) => dataset,
            Err(_) if file.loc_type_by_name(&name).ok() != Some(LocationType::Dataset) => {
                let what = format!("no dataset {name}; {}", listing(path, &file)?);
                return Err(error(path, None, what));
            }
            Err(e) => return Err(error(path, None, format!("dataset {name}: HDF5 says: {e}"))),
        };
        let refuse = |why: String| error(path, None, format!("dataset {name} {why}"));
        let shape = match dataset.shape()[..] {
            [rows] => (rows, 1),
            [rows, columns] => (rows, columns),
            ref other => {
                return Err(refuse(format!(
                    "has {} dimensions, where a matrix has 2",
                    other.len()
                )));
            }
        };
        let (rows, columns) = shape;
        padded_bytes(&[rows, columns], size_of::<f64>())
            .map_err(|what| refuse(format!("has a {what}")))?;
        let kind = dataset.dtype().map_err(|e| refuse(format!("has no type: HDF5 says: {e}")))?;
        let entry = match kind.to_descriptor() {
            Ok(
                entry @ (TypeDescriptor::Float(_)
                | TypeDescriptor::Integer(_)
                | TypeDescriptor::Unsigned(_)),
            ) => entry,
            Ok(other) => {
                return Err(refuse(format!("has entries of type {other}, not real numbers")));
            }
            Err(e) => return Err(refuse(format!("has entries of a type that is not read: {e}"))),
        };
        let creation = dataset.dcpl().map_err(|e| fail(path, &e))?;
        let inside =
            matches!(creation.layout(), Layout::Compact | Layout::Contiguous | Layout::Chunked);
        if !inside || !creation.external().is_empty() {
            return Err(refuse("has its entries in other files".into()));
        }
        if let Some(filter) = dataset.filters().iter().find(|filter| !filter.is_available()) {
            return Err(refuse(format!("is packed by {filter:?}, which this HDF5 library lacks")));
        }
        let holder = PathBuf::from(dataset.filename());
        let metadata = fs::metadata(&holder).map_err(|e| error_at(&holder, None, e))?;
        Ok(Self {
            path: path.into(),
            name: dataset.name(),
            holder,
            stamp: Stamp::of(&metadata),
            shape,
            dimensions: dataset.ndim(),
            entry,
            dataset,
            _file: file,
        })
    }

    pub(super) fn shape(&self) -> (usize, usize) {
        self.shape
    }

    pub(super) fn is_single(&self) -> bool {
        self.entry == TypeDescriptor::Float(FloatSize::U4)
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn origin(&self) -> String {
        format!("{}:{}, {}", canonical(&self.holder).display(), self.name, self.entry)
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
    ) -> Result<()> {
        let done = match (self.is_single(), T::NAME == f32::NAME) {
            (true, true) => self.read_same::<T, f32>(rows, columns, out),
            (false, false) => self.read_same::<T, f64>(rows, columns, out),
            (true, false) => self.read_pieces::<T, f32>(rows, columns, out),
            (false, true) => self.read_pieces::<T, f64>(rows, columns, out),
        };
        // This check comes first, because HDF5 reads missing bytes at the end of a file as zeros,
        // or fails with another message.
        self.stamp.check(&self.holder, fs::metadata(&self.holder))?;
        done
    }

    /// Reads a block in the precision of the file: T is S.
    fn read_same<T: Real, S: Real + H5Type>(
        &self,
        rows: Range<usize>,
        columns: Range<usize>,
        out: MatMut<'_, T>,
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
        self.read_pieces::<T, S>(rows, columns, out)
    }

    /// Reads a block through a buffer of the precision S.
    fn read_pieces<T: Real, S: Real + H5Type>(
        &self,
        rows: Range<usize>,
        columns: Range<usize>,
        mut out: MatMut<'_, T>,
    ) -> Result<()> {
        let at_once = BUFFER / size_of::<S>();
        let width = at_once.min(columns.len());
        let height = (at_once / width).min(rows.len());
        let mut values: Vec<S> = reserved(height * width)?;
        values.resize(height * width, S::ZERO);
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
                for (i, row) in values.chunks_exact(width).take(height).enumerate() {
                    for (j, &value) in row.iter().enumerate() {
                        out[(i, j)] = T::from_f64(value.to_f64());
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

fn fail(path: &Path, e: &::hdf5::Error) -> Error {
    error(path, None, format!("HDF5 says: {e}"))
}

/// Returns the name of the only dataset of two dimensions.
fn only(path: &Path, file: &File) -> Result<String> {
    let names = datasets(file).map_err(|e| fail(path, &e))?;
    let mut matrices = names.iter().filter(|name| file.dataset(name).is_ok_and(|d| d.ndim() == 2));
    match (matrices.next(), matrices.next()) {
        (Some(name), None) => Ok(name.clone()),
        (first, _) => {
            let count = if first.is_some() { "several datasets" } else { "no dataset" };
            let what = format!(
                "{count} of two dimensions, so name one ({}:/path/to/dataset); {}",
                path.file_name().unwrap_or_default().display(),
                listing(path, file)?
            );
            Err(error(path, None, what))
        }
    }
}

/// Returns the part of a message that lists the datasets of the file.
fn listing(path: &Path, file: &File) -> Result<String> {
    let names = datasets(file).map_err(|e| fail(path, &e))?;
    let described: Vec<String> = names
        .iter()
        .take(LISTED)
        .map(|name| {
            let shape = file.dataset(name).map(|dataset| {
                dataset.shape().iter().map(usize::to_string).collect::<Vec<_>>().join(" x ")
            });
            format!("{name} ({})", shape.unwrap_or_else(|_| "unreadable".into()))
        })
        .collect();
    Ok(match names.len() {
        0 => "the file has no datasets".into(),
        count if count > LISTED => {
            format!("the file has {}, and {} more", described.join(", "), count - LISTED)
        }
        _ => format!("the file has {}", described.join(", ")),
    })
}

/// Returns the names of all datasets that the file itself holds, sorted.
fn datasets(file: &File) -> ::hdf5::Result<Vec<String>> {
    let mut found = Vec::new();
    // Visited groups: groups may have several names, and may contain themselves.
    let mut seen = vec![file.loc_info_by_name("/")?.token];
    let mut waiting = vec![String::new()];
    while let Some(group) = waiting.pop() {
        let folder: Group = file.group(if group.is_empty() { "/" } else { &group })?;
        let mut names = Vec::new();
        folder.iter_visit_default(|name, link| {
            // Other links lead to objects that have a name already, out of the file, or nowhere.
            if link.link_type == LinkType::Hard {
                names.push(format!("{group}/{name}"));
            }
            Ok(())
        })?;
        for name in names {
            let about = file.loc_info_by_name(&name)?;
            match about.loc_type {
                LocationType::Dataset => found.push(name),
                LocationType::Group if about.num_links < 2 => waiting.push(name),
                LocationType::Group if !seen.contains(&about.token) => {
                    seen.push(about.token);
                    waiting.push(name);
                }
                _ => {}
            }
        }
    }
    found.sort_unstable();
    Ok(found)
}
