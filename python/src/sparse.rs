//! Sparse matrices by rows: three arrays each way.

use catamaran::sparse::{CsMat, Mass};
use pyo3::prelude::*;

use crate::array::{Array, from_vec};
use crate::error::refused;

/// A matrix of `scipy.sparse` by rows, as a tuple: data, indices, indptr, shape. Indices are of
/// type `numpy.uintp`.
#[derive(FromPyObject)]
pub struct Csr<'py>(Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>, (usize, usize));

/// Its arrays.
pub struct CsrArrays<'py> {
    name: &'static str,
    data: Array<'py, f64>,
    indices: Array<'py, usize>,
    starts: Array<'py, usize>,
    shape: (usize, usize),
}

impl<'py> Csr<'py> {
    /// Returns the matrix.
    pub fn matrix(&self, name: &'static str) -> PyResult<CsrArrays<'py>> {
        let Self(data, indices, starts, shape) = self;
        Ok(CsrArrays {
            name,
            data: Array::new(name, data, &[1])?,
            indices: Array::new(name, indices, &[1])?,
            starts: Array::new(name, starts, &[1])?,
            shape: *shape,
        })
    }
}

impl CsrArrays<'_> {
    /// Returns the matrix, copied.
    pub fn to_matrix(&self) -> PyResult<CsMat<f64>> {
        let parts = (self.starts.entries(), self.indices.entries(), self.data.entries());
        let (starts, indices, data) =
            (parts.0.into_owned(), parts.1.into_owned(), parts.2.into_owned());
        CsMat::try_new(self.shape, starts, indices, data)
            .map_err(|(.., why)| refused(self.name, why))
    }
}

/// The data, column indices and row starts of a matrix.
pub type Parts<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>, (usize, usize));

/// Returns a matrix by rows as arrays.
pub fn parts(py: Python<'_>, matrix: CsMat<f64>) -> Parts<'_> {
    let shape = (matrix.rows(), matrix.cols());
    let matrix = if matrix.is_csr() { matrix } else { matrix.to_csr() };
    let (starts, indices, data) = matrix.into_raw_storage();
    // As scipy has them, whose 64-bit indices are signed.
    let signed = |indices: Vec<usize>| {
        from_vec(py, indices.into_iter().map(|i| i as i64).collect::<Vec<_>>()).into_any()
    };
    (from_vec(py, data).into_any(), signed(indices), signed(starts), shape)
}

/// Returns a mass as arrays: a matrix by rows, whatever it is in the library.
pub fn mass_parts(py: Python<'_>, mass: Mass) -> Parts<'_> {
    match mass {
        Mass::Full(matrix) => parts(py, matrix),
        Mass::Lumped(diagonal) => {
            let n = diagonal.len();
            parts(py, CsMat::new((n, n), (0..=n).collect(), (0..n).collect(), diagonal))
        }
    }
}

/// Returns a mass of the caller: none, a vector of masses, or a sparse matrix as a tuple.
pub fn mass(object: Option<&Bound<'_, PyAny>>, n: usize) -> PyResult<Mass> {
    let Some(object) = object else { return Ok(Mass::identity(n)) };
    if let Ok(csr) = object.extract::<Csr<'_>>() {
        return Ok(Mass::Full(csr.matrix("mass")?.to_matrix()?));
    }
    Ok(Mass::Lumped(Array::<f64>::new("mass", object, &[1])?.entries().into_owned()))
}
