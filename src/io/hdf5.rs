//! Several arrays in one HDF5 file, each a dataset of its root.

use std::collections::BTreeMap;
use std::path::Path;

use ::hdf5::types::{IntSize, TypeDescriptor};
use ::hdf5::{Dataset, Dataspace, Datatype, File, Hyperslab, Selection};
use faer::MatRef;

use super::npz::Array;
use super::output::Output;
use super::source::error;
use super::stored::{Begin, Entries, Stored};
use crate::base::{Error, Result, reserved};

/// Entries of rows that are written together.
const BUFFER: usize = 1 << 20;

/// Most rows of a chunk of a matrix that is written by columns.
const CHUNK: usize = 1 << 16;

/// The HDF5 side of [`super::ArraysWriter`].
pub(super) struct Hdf5Writer {
    file: File,
    output: Output,
    /// The matrix that was begun.
    matrix: Option<Begun>,
}

/// A matrix of which some rows or columns are written.
struct Begun {
    dataset: Dataset,
    by_rows: bool,
    /// Rows or columns so far.
    written: usize,
}

impl Begun {
    /// Rows and columns that are left.
    fn rest(&self) -> (usize, usize) {
        let (rows, columns) = shape(&self.dataset);
        match self.by_rows {
            true => (rows - self.written, columns),
            false => (rows, columns - self.written),
        }
    }
}

impl Hdf5Writer {
    pub(super) fn new(output: Output) -> Result<Self> {
        let file = File::create(output.temporary_path()).map_err(|e| failure(&output, e))?;
        Ok(Self { file, output, matrix: None })
    }

    pub(super) fn array(&mut self, name: &str, array: Array<'_>) -> Result<()> {
        self.check_end()?;
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
                write_at(&dataset.map_err(fail)?, [0, 0], matrix, fail)
            }
        }
    }

    pub(super) fn matrix_by_columns(
        &mut self,
        name: &str,
        rows: usize,
        columns: usize,
    ) -> Result<()> {
        self.check_end()?;
        let dataset = self.file.new_dataset::<f64>();
        let dataset = match rows.min(columns) {
            0 => dataset.shape((rows, columns)).create(name),
            // Chunks keep the entries of a column together.
            _ => dataset.chunk((rows.min(CHUNK), 1)).shape((rows, columns)).create(name),
        };
        let dataset = dataset.map_err(|e| failure(&self.output, e))?;
        self.matrix = Some(Begun { dataset, by_rows: false, written: 0 });
        Ok(())
    }

    pub(super) fn columns(&mut self, columns: MatRef<'_, f64>) -> Result<()> {
        let Some(begun) = self.matrix.as_mut().filter(|begun| !begun.by_rows) else {
            return Error::check_shape("columns", (0, 0), columns.shape());
        };
        let (rows, left) = begun.rest();
        Error::check_shape("columns", (rows, left.min(columns.ncols())), columns.shape())?;
        let fail = |e| failure(&self.output, e);
        write_at(&begun.dataset, [0, begun.written], columns, fail)?;
        begun.written += columns.ncols();
        Ok(())
    }

    pub(super) fn matrix_by_rows(&mut self, name: &str, rows: usize, columns: usize) -> Result<()> {
        self.check_end()?;
        let dataset = self.file.new_dataset::<f64>().shape((rows, columns)).create(name);
        let dataset = dataset.map_err(|e| failure(&self.output, e))?;
        self.matrix = Some(Begun { dataset, by_rows: true, written: 0 });
        Ok(())
    }

    pub(super) fn rows(&mut self, rows: MatRef<'_, f64>) -> Result<()> {
        let Some(begun) = self.matrix.as_mut().filter(|begun| begun.by_rows) else {
            return Error::check_shape("rows", (0, 0), rows.shape());
        };
        let (left, columns) = begun.rest();
        Error::check_shape("rows", (left.min(rows.nrows()), columns), rows.shape())?;
        let fail = |e| failure(&self.output, e);
        write_at(&begun.dataset, [begun.written, 0], rows, fail)?;
        begun.written += rows.nrows();
        Ok(())
    }

    pub(super) fn finish(self) -> Result<()> {
        self.check_end()?;
        let Self { file, output, matrix } = self;
        drop(matrix);
        file.close().map_err(|e| failure(&output, e))?;
        output.commit()
    }

    fn check_end(&self) -> Result<()> {
        let Some(begun) = &self.matrix else { return Ok(()) };
        let (rows, columns) = begun.rest();
        match begun.by_rows {
            true => Error::check_shape("rows", (rows, columns), (0, columns)),
            false => Error::check_shape("columns", (rows, columns), (rows, 0)),
        }
    }
}

/// Reads all datasets of the root.
pub(super) fn read(path: &Path, begin: Begin<'_>) -> Result<BTreeMap<String, Stored>> {
    let fail = |e| error(path, None, format!("can't be read: HDF5 says: {e}"));
    let file = File::open(path).map_err(fail)?;
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

fn shape(dataset: &Dataset) -> (usize, usize) {
    match dataset.shape()[..] {
        [rows, columns] => (rows, columns),
        _ => (0, 0),
    }
}

/// Writes the entries of `matrix` into the dataset, the first one at `corner`.
fn write_at(
    dataset: &Dataset,
    corner: [usize; 2],
    matrix: MatRef<'_, f64>,
    fail: impl Fn(::hdf5::Error) -> Error,
) -> Result<()> {
    let (rows, width) = matrix.shape();
    if width == 0 {
        return Ok(());
    }
    let at_once = (BUFFER / width).clamp(1, rows.max(1));
    let mut block = reserved(at_once * width)?;
    for top in (0..rows).step_by(at_once) {
        let height = at_once.min(rows - top);
        block.clear();
        for i in top..top + height {
            block.extend((0..width).map(|j| matrix[(i, j)]));
        }
        write_block(dataset, [corner[0] + top, corner[1]], width, &block).map_err(&fail)?;
    }
    Ok(())
}

/// Writes rows of `width` entries, the first one at `corner`.
fn write_block(
    dataset: &Dataset,
    corner: [usize; 2],
    width: usize,
    block: &[f64],
) -> ::hdf5::Result<()> {
    let rows = block.len() / width;
    let span = [(corner[0]..corner[0] + rows).into(), (corner[1]..corner[1] + width).into()];
    let target = dataset.space()?.select(Selection::from(Hyperslab::from(span.to_vec())))?;
    let source = Dataspace::try_new([rows, width])?;
    let memory = Datatype::from_type::<f64>()?;
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
