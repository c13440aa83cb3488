//! Views of numpy arrays, and arrays of results.
//!
//! A view keeps its array alive. The array may be of any strides, negative ones and zeros too, and
//! read-only: nothing is copied unless its numbers are of another type, in another byte order or
//! not aligned. As in numpy's own functions, which release the interpreter too, an array that
//! another thread writes meanwhile has no defined result.

use std::borrow::Cow;
use std::ptr::NonNull;

use catamaran::faer::{MatMut, MatRef};
use numpy::npyffi::flags::{NPY_ARRAY_ALIGNED, NPY_ARRAY_WRITEABLE};
use numpy::{
    PyArray1, PyArray2, PyArrayDescrMethods, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;

use crate::error::refused;
use crate::scalar::Scalar;

/// Steps of numpy's search for a common element of two arrays; after so many they may have one.
const MAX_WORK: usize = 1_000_000;

/// Rows, columns and strides of a matrix, in elements; a vector is a column.
#[derive(Clone, Copy)]
struct Layout {
    shape: [usize; 2],
    strides: [isize; 2],
}

/// A numpy array of one or two dimensions whose elements are of type T.
pub struct Array<'py, T> {
    array: Bound<'py, PyUntypedArray>,
    data: NonNull<T>,
    layout: Layout,
}

/// Returns the module `numpy`.
fn numpy<'py>(py: Python<'py>) -> PyResult<&'py Bound<'py, PyAny>> {
    static NUMPY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let module =
        NUMPY.get_or_try_init(py, || Ok::<_, PyErr>(py.import("numpy")?.into_any().unbind()))?;
    Ok(module.bind(py))
}

/// Returns what `numpy.asarray` or `numpy.from_dlpack` makes of an object: the object itself if it
/// is an array. Masked entries, whose values mean nothing, are refused.
pub fn untyped<'py>(
    name: &str,
    object: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyUntypedArray>> {
    if let Ok(array) = object.cast::<PyUntypedArray>() {
        if !array.is_exact_instance_of::<PyUntypedArray>() && array.hasattr("mask")? {
            let ma = numpy(object.py())?.getattr("ma")?;
            let count: usize = ma.call_method1("count_masked", (array,))?.extract()?;
            if count > 0 {
                let why = "fill them, or leave out their rows";
                return Err(refused(name, format_args!("{count} entries are masked: {why}")));
            }
        }
        return Ok(array.clone());
    }
    let py = object.py();
    // What only exports DLPack would become an array of one object.
    let exports = object.hasattr(intern!(py, "__dlpack__"))?;
    let make = match exports && !object.hasattr(intern!(py, "__array__"))? {
        true => intern!(py, "from_dlpack"),
        false => intern!(py, "asarray"),
    };
    Ok(numpy(py)?.call_method1(make, (object,))?.cast_into()?)
}

/// Returns whether the elements are a T as it is in memory.
fn is_of<T: Scalar>(array: &Bound<'_, PyUntypedArray>) -> bool {
    let kind = array.dtype();
    // 'l' and 'q' have different numbers and the same size.
    let same = kind.num() == T::NUMBER
        || kind.itemsize() == size_of::<T>()
            && matches!((T::NAME, kind.kind()), ("int64", b'i') | ("uint64", b'u'));
    same && kind.byteorder() != b'>' && cfg!(target_endian = "little")
}

/// Returns the flags of numpy.
fn has_flag(array: &Bound<'_, PyUntypedArray>, flag: i32) -> bool {
    // SAFETY: the object is a numpy array, whose header is read while the interpreter is held.
    unsafe { (*array.as_array_ptr()).fields.flags & flag != 0 }
}

/// Returns rows, columns and strides in elements of type T; `None` where an element would not be
/// aligned.
fn layout<T>(array: &Bound<'_, PyUntypedArray>) -> Option<Layout> {
    let size = size_of::<T>() as isize;
    let (mut shape, mut strides) = ([1, 1], [0, 0]);
    for (axis, (&length, &stride)) in array.shape().iter().zip(array.strides()).enumerate() {
        shape[axis] = length;
        // The stride of one element counts for nothing.
        strides[axis] = if length > 1 { stride / size } else { 0 };
        if length > 1 && stride % size != 0 {
            return None;
        }
    }
    let aligned = has_flag(array, NPY_ARRAY_ALIGNED) || array.is_empty();
    aligned.then_some(Layout { shape, strides })
}

impl<'py, T: Scalar> Array<'py, T> {
    /// Returns a view of an array, or of a copy where numbers must be converted. `name` is that of
    /// the argument, in errors; `dimensions` are those that are allowed.
    pub fn new(name: &str, object: &Bound<'py, PyAny>, dimensions: &[usize]) -> PyResult<Self> {
        let mut array = untyped(name, object)?;
        let found = array.ndim();
        if !dimensions.contains(&found) {
            let wanted: Vec<_> = dimensions.iter().map(usize::to_string).collect();
            let wanted = wanted.join(" or ");
            let plural = if wanted == "1" { "" } else { "s" };
            let why =
                format!("{name}: expected an array of {wanted} dimension{plural}, got {found}");
            return Err(PyValueError::new_err(why));
        }
        if !is_of::<T>(&array) || layout::<T>(&array).is_none() {
            array = converted::<T>(name, &array)?;
        }
        let Some(layout) = layout::<T>(&array) else {
            return Err(PyValueError::new_err(format!("{name}: not aligned in memory")));
        };
        Ok(Self::of(array, layout))
    }

    fn of(array: Bound<'py, PyUntypedArray>, layout: Layout) -> Self {
        // SAFETY: the object is a numpy array, whose header is read while the interpreter is held.
        let data = unsafe { (*array.as_array_ptr()).fields.data }.cast::<T>();
        let empty = layout.shape.contains(&0);
        let data = if empty {
            NonNull::dangling()
        } else {
            NonNull::new(data).unwrap_or(NonNull::dangling())
        };
        Self { array, data, layout }
    }

    /// Returns the array that the caller gives for a result: of this shape, nothing converted.
    pub fn output(name: &str, object: &Bound<'py, PyAny>, shape: [usize; 2]) -> PyResult<Self> {
        let refuse = |why: String| Err(PyValueError::new_err(format!("{name}: {why}")));
        let Ok(array) = object.cast::<PyUntypedArray>() else {
            return Err(PyTypeError::new_err(format!("{name}: expected a numpy array")));
        };
        if !is_of::<T>(array) {
            let why = format!("{name}: expected {}, got {}", T::NAME, array.dtype());
            return Err(PyTypeError::new_err(why));
        }
        if array.shape() != shape {
            let [m, n] = shape;
            return refuse(format!("expected shape ({m}, {n}), got {:?}", array.shape()));
        }
        if !has_flag(array, NPY_ARRAY_WRITEABLE) {
            return refuse("read-only".into());
        }
        let Some(layout) = layout::<T>(array) else {
            return refuse("not aligned in memory".into());
        };
        if overlaps_itself(&layout) {
            return refuse("some of its elements are the same memory".into());
        }
        Ok(Self::of(array.clone(), layout))
    }

    /// Returns the matrix; a vector is a column.
    pub fn view(&self) -> MatRef<'_, T> {
        let Layout { shape: [m, n], strides: [row, column] } = self.layout;
        // SAFETY: numpy vouches for the memory between its first and its last element, and the
        // array is kept alive by `self`.
        unsafe { MatRef::from_raw_parts(self.data.as_ptr(), m, n, row, column) }
    }

    /// Returns the matrix of [`Array::output`].
    pub fn view_mut(&mut self) -> MatMut<'_, T> {
        let Layout { shape: [m, n], strides: [row, column] } = self.layout;
        // SAFETY: as in `view`; the array is writeable and its elements are distinct, as `output`
        // and `zeros` made sure.
        unsafe { MatMut::from_raw_parts_mut(self.data.as_ptr(), m, n, row, column) }
    }

    /// Returns the elements of a vector one after the other, copied unless they are so in memory.
    pub fn entries(&self) -> Cow<'_, [T]> {
        let view = self.view();
        if self.layout.strides[0] == 1 || view.nrows() <= 1 {
            // SAFETY: as in `view`; the stride is 1, or there is at most one element, so that the
            // elements follow each other.
            return Cow::Borrowed(unsafe {
                std::slice::from_raw_parts(self.data.as_ptr(), view.nrows())
            });
        }
        Cow::Owned((0..view.nrows()).map(|i| view[(i, 0)]).collect())
    }

    /// Rows and columns; a vector is a column.
    pub fn shape(&self) -> (usize, usize) {
        let [m, n] = self.layout.shape;
        (m, n)
    }

    /// Returns the array, to return it.
    pub fn into_any(self) -> Bound<'py, PyAny> {
        self.array.into_any()
    }

    /// Refuses an output that has an element in common with an input. Both may be in one buffer.
    pub fn check_apart<S>(&self, name: &str, input: &Array<'py, S>) -> PyResult<()> {
        let py = self.array.py();
        let arrays = (&self.array, &input.array, MAX_WORK);
        if numpy(py)?.call_method1(intern!(py, "may_share_memory"), arrays)?.is_truthy()? {
            return Err(PyValueError::new_err(format!("{name}: shares memory with an input")));
        }
        Ok(())
    }
}

/// Returns a copy with elements of type T, where numpy converts them without loss of kind.
fn converted<'py, T: Scalar>(
    name: &str,
    array: &Bound<'py, PyUntypedArray>,
) -> PyResult<Bound<'py, PyUntypedArray>> {
    let py = array.py();
    let wanted = numpy::dtype::<T>(py);
    // Longer floating-point numbers would lose digits.
    let longer = array.dtype().kind() == b'f' && array.dtype().itemsize() > 8;
    let casting = (array.dtype(), &wanted, intern!(py, "same_kind"));
    let may = numpy(py)?.call_method1(intern!(py, "can_cast"), casting)?.is_truthy()?;
    // No numbers, such as those of an empty list, are of any type.
    if !array.is_empty() && (longer || !may) {
        let why = format!("{name}: {} can't be converted to {}", array.dtype(), T::NAME);
        return Err(PyTypeError::new_err(why));
    }
    Ok(array.call_method1(intern!(py, "astype"), (wanted,))?.cast_into()?)
}

/// Returns whether two elements may be at one place.
fn overlaps_itself(layout: &Layout) -> bool {
    let Layout { shape, strides } = layout;
    let mut axes: Vec<_> = (0..2)
        .filter(|&axis| shape[axis] > 1)
        .map(|axis| (strides[axis].unsigned_abs(), shape[axis]))
        .collect();
    axes.sort_unstable();
    let mut span = 1;
    axes.iter().any(|&(stride, length)| {
        let overlaps = stride < span;
        span = stride.saturating_mul(length - 1).saturating_add(span);
        overlaps
    })
}

/// Returns a new array of zeros, in C order. That there is not enough memory is numpy's
/// `MemoryError`.
pub fn zeros<'py, T: Scalar>(py: Python<'py>, shape: [usize; 2]) -> PyResult<Array<'py, T>> {
    let shape = (shape[0], shape[1]);
    let found = numpy(py)?.call_method1(intern!(py, "zeros"), (shape, numpy::dtype::<T>(py)))?;
    let array = found.cast_into::<PyUntypedArray>()?;
    let layout = layout::<T>(&array).expect("new arrays are aligned");
    Ok(Array::of(array, layout))
}

/// Returns a new array of a matrix, in Fortran order, as the library holds it.
pub fn from_matrix<'py>(
    py: Python<'py>,
    matrix: MatRef<'_, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (m, n) = matrix.shape();
    let options = PyDict::new(py);
    options.set_item(intern!(py, "order"), intern!(py, "F"))?;
    let found = numpy(py)?.call_method(intern!(py, "empty"), ((m, n),), Some(&options))?;
    let array = found.cast_into::<PyArray2<f64>>()?;
    if m * n > 0 {
        // SAFETY: the array is new, so that nothing else refers to its memory, and in Fortran
        // order, which makes it columns of m elements, one after the other.
        let entries = unsafe { std::slice::from_raw_parts_mut(array.data(), m * n) };
        for (j, column) in entries.chunks_exact_mut(m).enumerate() {
            for (i, entry) in column.iter_mut().enumerate() {
                *entry = matrix[(i, j)];
            }
        }
    }
    Ok(array)
}

/// Returns a new vector.
pub fn from_vec<T: numpy::Element>(py: Python<'_>, values: Vec<T>) -> Bound<'_, PyArray1<T>> {
    PyArray1::from_vec(py, values)
}

/// Returns a new array with a row for each of the values.
pub fn from_rows<T: numpy::Element, const N: usize>(
    py: Python<'_>,
    rows: Vec<[T; N]>,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    let count = rows.len();
    PyArray1::from_vec(py, rows.into_flattened()).reshape([count, N])
}
