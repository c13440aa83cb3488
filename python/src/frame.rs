//! Data frames, whose rows become numbers block by block.

use catamaran::base::block_rows;
use catamaran::faer::MatMut;
use catamaran::faer::prelude::ReborrowMut;
use catamaran::rows::{DenseRows, RowBlocks};
use catamaran::{Error, Real};
use numpy::PyUntypedArray;
use pyo3::intern;
use pyo3::prelude::*;

use crate::array::{Array, untyped};
use crate::error::{exception, raised};

/// Entries that are converted at a time.
const BLOCK: usize = 1 << 20;

/// A frame of pandas, polars or pyarrow whose columns lie apart, or are of several types.
pub struct Frame {
    /// A `catamaran._frames.Frame`.
    frame: Py<PyAny>,
    /// That of the argument, in errors.
    name: &'static str,
    shape: (usize, usize),
    /// Whether all columns are in single precision.
    pub is_single: bool,
}

impl Frame {
    /// Returns the frame that an object is; `None` for arrays, and for what is one without a copy.
    /// `name` is that of the argument, in errors.
    pub fn of(name: &'static str, object: &Bound<'_, PyAny>) -> PyResult<Option<Self>> {
        if object.cast::<PyUntypedArray>().is_ok() {
            return Ok(None);
        }
        let py = object.py();
        let module = py.import(intern!(py, "catamaran._frames"))?;
        let found = module.call_method1(intern!(py, "frame_of"), (name, object))?;
        if found.is_none() {
            return Ok(None);
        }
        let shape = found.getattr(intern!(py, "shape"))?.extract()?;
        let is_single = found.getattr(intern!(py, "is_single"))?.extract()?;
        Ok(Some(Self { frame: found.unbind(), name, shape, is_single }))
    }

    /// Returns all rows as an array.
    pub fn whole<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyUntypedArray>> {
        let rows = self.frame.bind(py).call_method1(intern!(py, "rows"), (0, self.shape.0))?;
        Ok(rows.cast_into()?)
    }

    /// Rows and columns.
    pub fn shape(&self) -> (usize, usize) {
        self.shape
    }

    /// Returns whether the rows are more than a block.
    pub fn is_large(&self) -> bool {
        self.shape.0 > block_rows::<f64>(self.shape.1, false)
    }

    /// Fills `out` with the rows from `first` on.
    pub fn read<T: Real>(&self, first: usize, mut out: MatMut<'_, T>) -> catamaran::Result<()> {
        let height = (BLOCK / self.shape.1.max(1)).max(1);
        let read = Python::try_attach(|py| -> PyResult<()> {
            let rows = self.frame.bind(py).getattr(intern!(py, "rows"))?;
            for start in (0..out.nrows()).step_by(height) {
                let count = height.min(out.nrows() - start);
                let block =
                    Array::<f64>::new(self.name, &rows.call1((first + start, count))?, &[2])?;
                let out = out.rb_mut().subrows_mut(start, count);
                DenseRows(block.view()).read(0, out).map_err(exception)?;
            }
            Ok(())
        });
        match read {
            Some(Ok(())) => Ok(()),
            Some(Err(error)) => Err(raised(error)),
            // The interpreter has ended.
            None => Err(Error::Cancelled),
        }
    }
}

/// Returns an object as an array: a frame as a whole, anything else as [`untyped`] has it.
pub fn array_of<'py>(
    name: &'static str,
    object: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyUntypedArray>> {
    match Frame::of(name, object)? {
        Some(frame) => frame.whole(object.py()),
        None => untyped(name, object),
    }
}

impl<T: Real> RowBlocks<T> for &Frame {
    fn nrows(&self) -> usize {
        self.shape.0
    }

    fn ncols(&self) -> usize {
        self.shape.1
    }

    fn read(&mut self, first: usize, out: MatMut<'_, T>) -> catamaran::Result<()> {
        Frame::read(self, first, out)
    }
}
