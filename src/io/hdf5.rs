//! Several arrays in one HDF5 file, each a dataset of its root.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use ::hdf5::types::{IntSize, TypeDescriptor};
use ::hdf5::{Dataset, Dataspace, Datatype, File, H5Type, Hyperslab, Selection};
use faer::MatRef;

use super::npz::Array;
use super::output::Output;
use super::source::{error, error_at};
use super::stored::{Begin, Entries, Stored};
use super::unwritten::Unwritten;
use crate::base::{Error, Real, Result, reserved};

/// Entries of rows that are written together.
const BUFFER: usize = 1 << 20;

/// Most rows of a chunk of a matrix that is written by columns.
const CHUNK: usize = 1 << 16;

/// The HDF5 side of [`super::ArraysWriter`].
pub(super) struct Hdf5Writer {
    file: File,
    output: Output,
    /// The matrix that was begun last, and its dataset.
    matrix: Unwritten,
    dataset: Option<Dataset>,
}

impl Hdf5Writer {
    pub(super) fn new(output: Output) -> Result<Self> {
        let file = File::create(output.temporary_path()).map_err(|e| failure(&output, e))?;
        Ok(Self { file, output, matrix: Unwritten::default(), dataset: None })
    }

    pub(super) fn array(&mut self, name: &str, array: Array<'_>) -> Result<()> {
        self.matrix.check_end()?;
        let (file, fail) = (&self.file, |e| failure(&self.output, e));
        match array {
            Array::Vector(values) => {
                let dataset = file.new_dataset::<f64>().shape(values.len()).create(name);
                dataset.and_then(|dataset| dataset.write_raw(values)).map_err(fail)
            }
            Array::Indices(values) => {
                let values: Vec<u64> = values.iter().map(|&value| value as u64).collect();
                let dataset = file.new_dataset::<u64>().shape(values.len()).create(name);
                dataset.and_then(|dataset| dataset.write_raw(&values)).map_err(fail)
            }
            Array::Matrix(matrix) => {
                let dataset = file.new_dataset::<f64>().shape(matrix.shape()).create(name);
                let entry = |i: usize, j: usize| matrix[(i, j)];
                write_at(&dataset.map_err(fail)?, [0, 0], matrix.shape(), entry, fail)
            }
        }
    }

    pub(super) fn matrix_by_columns(
        &mut self,
        name: &str,
        rows: usize,
        columns: usize,
    ) -> Result<()> {
        self.matrix.check_end()?;
        let dataset = self.file.new_dataset::<f64>();
        let dataset = match rows.min(columns) {
            0 => dataset.shape((rows, columns)).create(name),
            // Chunks keep the entries of a column together.
            _ => dataset.chunk((rows.min(CHUNK), 1)).shape((rows, columns)).create(name),
        };
        self.dataset = Some(dataset.map_err(|e| failure(&self.output, e))?);
        self.matrix = Unwritten { by_rows: false, shape: (rows, columns), written: 0 };
        Ok(())
    }

    pub(super) fn columns(&mut self, columns: MatRef<'_, f64>) -> Result<()> {
        self.append(false, columns)
    }

    pub(super) fn matrix_by_rows(&mut self, name: &str, rows: usize, columns: usize) -> Result<()> {
        self.matrix.check_end()?;
        let dataset = self.file.new_dataset::<f64>().shape((rows, columns)).create(name);
        self.dataset = Some(dataset.map_err(|e| failure(&self.output, e))?);
        self.matrix = Unwritten { by_rows: true, shape: (rows, columns), written: 0 };
        Ok(())
    }

    pub(super) fn rows(&mut self, rows: MatRef<'_, f64>) -> Result<()> {
        self.append(true, rows)
    }

    /// Writes the next rows or columns.
    fn append(&mut self, by_rows: bool, next: MatRef<'_, f64>) -> Result<()> {
        self.matrix.check(by_rows, next.shape())?;
        let Some(dataset) = &self.dataset else { return Ok(()) };
        let written = self.matrix.written;
        let (corner, count) = match by_rows {
            true => ([written, 0], next.nrows()),
            false => ([0, written], next.ncols()),
        };
        let entry = |i: usize, j: usize| next[(i, j)];
        write_at(dataset, corner, next.shape(), entry, |e| failure(&self.output, e))?;
        self.matrix.written += count;
        Ok(())
    }

    pub(super) fn finish(self) -> Result<()> {
        self.matrix.check_end()?;
        let Self { file, output, dataset, .. } = self;
        drop(dataset);
        file.close().map_err(|e| failure(&output, e))?;
        output.commit()
    }
}

/// Returns the version of the HDF5 library, such as `1.10.8`.
///
/// ```
/// assert_eq!(catamaran::io::hdf5_version().split('.').count(), 3);
/// ```
pub fn hdf5_version() -> String {
    let (major, minor, patch) = ::hdf5::library_version();
    format!("{major}.{minor}.{patch}")
}

/// The dataset of a file with one matrix.
const MATRIX: &str = "matrix";

/// Writes a matrix in its precision.
pub(super) fn write_matrix<T: Real>(output: Output, matrix: MatRef<'_, T>) -> Result<()> {
    match T::NAME == f32::NAME {
        true => write_only(output, matrix.shape(), |i, j| matrix[(i, j)].to_f64() as f32),
        false => write_only(output, matrix.shape(), |i, j| matrix[(i, j)].to_f64()),
    }
}

/// Writes a matrix of integers of 64 bits.
pub(super) fn write_integers(output: Output, matrix: MatRef<'_, i64>) -> Result<()> {
    write_only(output, matrix.shape(), |i, j| matrix[(i, j)])
}

/// Writes the file of one matrix.
fn write_only<S: H5Type>(
    output: Output,
    shape: (usize, usize),
    entry: impl Fn(usize, usize) -> S,
) -> Result<()> {
    let fail = |e| failure(&output, e);
    let file = File::create(output.temporary_path()).map_err(fail)?;
    let dataset = file.new_dataset::<S>().shape(shape).create(MATRIX).map_err(fail)?;
    write_at(&dataset, [0, 0], shape, entry, fail)?;
    drop(dataset);
    file.close().map_err(fail)?;
    output.commit()
}

/// Reads all datasets of the root.
pub(super) fn read(path: &Path, begin: Begin<'_>) -> Result<BTreeMap<String, Stored>> {
    let fail = |e| error(path, None, format!("can't be read: HDF5 says: {e}"));
    // HDF5 does not say that there is no such file.
    fs::metadata(path).map_err(|e| error_at(path, None, e))?;
    let (file, _) = super::rows::open_hdf5(path)?;
    let mut arrays = BTreeMap::new();
    let names = file.member_names().map_err(fail)?;
    let count = names.len();
    for (i, name) in names.into_iter().enumerate() {
        let dataset = file.dataset(&name).map_err(fail)?;
        // Parts of a dataset that were never written take no space in the file, but are read as
        // zeros.
        begin(i, count, (dataset.size() as u64).saturating_mul(8))?;
        let kind = dataset.dtype().and_then(|kind| kind.to_descriptor()).map_err(fail)?;
        let entries = match kind {
            TypeDescriptor::Unsigned(IntSize::U8) => {
                Entries::Indices(dataset.read_raw().map_err(fail)?)
            }
            _ => Entries::Numbers(dataset.read_raw().map_err(fail)?),
        };
        arrays.insert(name, Stored { shape: dataset.shape(), entries, by_columns: false });
    }
    Ok(arrays)
}

fn failure(output: &Output, e: ::hdf5::Error) -> Error {
    error(output.path(), None, format!("can't be written: HDF5 says: {e}"))
}

/// Writes the entries of a matrix of this shape into the dataset, the first one at `corner`.
fn write_at<S: H5Type>(
    dataset: &Dataset,
    corner: [usize; 2],
    (rows, width): (usize, usize),
    entry: impl Fn(usize, usize) -> S,
    fail: impl Fn(::hdf5::Error) -> Error,
) -> Result<()> {
    if width == 0 {
        return Ok(());
    }
    let at_once = (BUFFER / width).clamp(1, rows.max(1));
    let mut block = reserved(at_once * width)?;
    for top in (0..rows).step_by(at_once) {
        let height = at_once.min(rows - top);
        block.clear();
        for i in top..top + height {
            block.extend((0..width).map(|j| entry(i, j)));
        }
        write_block(dataset, [corner[0] + top, corner[1]], width, &block).map_err(&fail)?;
    }
    Ok(())
}

/// Writes rows of `width` entries, the first one at `corner`.
fn write_block<S: H5Type>(
    dataset: &Dataset,
    corner: [usize; 2],
    width: usize,
    block: &[S],
) -> ::hdf5::Result<()> {
    let rows = block.len() / width;
    let span = [(corner[0]..corner[0] + rows).into(), (corner[1]..corner[1] + width).into()];
    let target = dataset.space()?.select(Selection::from(Hyperslab::from(span.to_vec())))?;
    let source = Dataspace::try_new([rows, width])?;
    let memory = Datatype::from_type::<S>()?;
    ::hdf5::sync::sync(|| {
        // SAFETY: the handles are alive; HDF5 reads rows x width entries, which the block has.
        let status = unsafe {
            ::hdf5_sys::h5d::H5Dwrite(
                dataset.id(),
                memory.id(),
                source.id(),
                target.id(),
                ::hdf5_sys::h5p::H5P_DEFAULT,
                block.as_ptr().cast(),
            )
        };
        if status < 0 { Err(::hdf5::Error::query().unwrap_or_else(|e| e)) } else { Ok(()) }
    })
}
