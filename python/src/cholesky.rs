//! Sparse Cholesky factorizations.

use catamaran::sparse::{Cholesky, CholeskyOptions, Triangle};
use pyo3::prelude::*;

use crate::array::{Array, from_matrix, from_vec};
use crate::error::refused;
use crate::exclusive::Exclusive;
use crate::options::{Threads, par, word};
use crate::sparse::Csr;
use crate::task::{Length, run};

/// A factorization; see `catamaran.Cholesky`.
#[pyclass(frozen, module = "catamaran._catamaran")]
pub struct CholeskyHandle {
    state: Exclusive<Cholesky>,
}

#[pymethods]
impl CholeskyHandle {
    #[new]
    #[pyo3(signature = (a, triangle, semidefinite, tolerance, order, threads, progress))]
    fn new(
        py: Python<'_>,
        a: Csr<'_>,
        triangle: &str,
        semidefinite: bool,
        tolerance: Option<f64>,
        order: Option<&Bound<'_, PyAny>>,
        threads: Threads,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let known =
            [("both", Triangle::Both), ("lower", Triangle::Lower), ("upper", Triangle::Upper)];
        let options = CholeskyOptions::new()
            .triangle(word("triangle", triangle, &known)?)
            .semidefinite(semidefinite)
            .tolerance(tolerance)
            .par(par(threads)?);
        let a = a.matrix("a")?.to_matrix()?;
        let order = order.map(|order| numbers("order", order)).transpose()?;
        let cholesky = run(py, Length::Long, progress, move |progress| {
            Cholesky::new(a.view(), &options.order(order.as_deref()).progress(progress))
        })?;
        Ok(Self { state: Exclusive::new(cholesky) })
    }

    /// Factorizes another matrix without entries in other places.
    #[pyo3(signature = (a, progress))]
    fn factor(&self, py: Python<'_>, a: Csr<'_>, progress: Option<Py<PyAny>>) -> PyResult<()> {
        let a = a.matrix("a")?.to_matrix()?;
        let mut state = self.state.lock(py)?;
        let (cholesky, a) = (&mut *state, a.view());
        run(py, Length::Long, progress, move |progress| cholesky.factor(a, progress))
    }

    /// Returns the solution for the columns of b, or these rows of it.
    #[pyo3(signature = (b, rows, progress))]
    fn solve<'py>(
        &self,
        py: Python<'py>,
        b: &Bound<'py, PyAny>,
        rows: Option<&Bound<'py, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let b = Array::<f64>::new("b", b, &[1, 2])?;
        let rows = rows.map(|rows| numbers("rows", rows)).transpose()?;
        let state = self.state.lock(py)?;
        let (cholesky, b) = (&*state, b.view());
        let found = run(py, Length::Long, progress, move |_| match rows {
            Some(rows) => cholesky.solve_rows(b, &rows),
            None => cholesky.solve(b),
        })?;
        Ok(from_matrix(py, found.as_ref())?.into_any())
    }

    #[getter]
    fn n(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.state.lock(py)?.n())
    }

    #[getter]
    fn entries(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.state.lock(py)?.entries())
    }

    #[getter]
    fn held<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let state = self.state.lock(py)?;
        let held: Vec<i64> = state.held().iter().map(|&row| row as i64).collect();
        Ok(from_vec(py, held).into_any())
    }

    #[getter]
    fn weakest(&self, py: Python<'_>) -> PyResult<Option<(usize, f64)>> {
        Ok(self.state.lock(py)?.weakest())
    }
}

/// Numbers of rows, from 0; whether a matrix has them is for the library to say.
fn numbers(name: &str, object: &Bound<'_, PyAny>) -> PyResult<Vec<usize>> {
    let array = Array::<i64>::new(name, object, &[1])?;
    let entries = array.entries();
    let numbers = entries.iter().map(|&row| {
        usize::try_from(row)
            .map_err(|_| refused(name, format_args!("{row} is not the number of a row")))
    });
    numbers.collect()
}
