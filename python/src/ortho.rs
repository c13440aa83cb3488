//! Orthonormal bases.

use catamaran::ortho::{GramSchmidtOptions, cholesky_qr, gram_schmidt, rank_revealing};
use pyo3::prelude::*;

use crate::array::{Array, from_matrix, from_vec, zeros};
use crate::gram::gram_qr;
use crate::options::{Threads, par, word};
use crate::sparse::mass as mass_of;
use crate::task::{Length, run};

/// Returns Q and R; see `catamaran.qr`.
#[pyfunction]
#[pyo3(signature = (a, mass, threads, progress))]
pub fn qr<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    mass: Option<&Bound<'py, PyAny>>,
    threads: Threads,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let par = par(threads)?;
    if mass.is_none() {
        return gram_qr(py, a, par, progress);
    }
    let a = Array::<f64>::new("a", a, &[2])?;
    let (m, n) = a.shape();
    let mass = mass_of(mass, m)?;
    let mut q = zeros::<f64>(py, [m, n])?;
    let (a, mut out) = (a.view(), q.view_mut());
    let r = run(py, Length::Long, progress, move |_| {
        out.copy_from(a);
        cholesky_qr(out, &mass, par)
    })?;
    Ok((q.into_any(), from_matrix(py, r.as_ref())?.into_any()))
}

/// Returns Q, R and the columns that Q is made of; see `catamaran.orthogonalize`.
#[pyfunction]
#[pyo3(signature = (a, mass, method, threshold, threads, progress))]
pub fn orthogonalize<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    mass: Option<&Bound<'py, PyAny>>,
    method: &str,
    threshold: Option<f64>,
    threads: Threads,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let known = [("single_pass", 0), ("reorthogonalized", 1), ("rank_revealing", 2)];
    let (method, par) = (word("method", method, &known)?, par(threads)?);
    let a = Array::<f64>::new("a", a, &[2])?;
    let mass = mass_of(mass, a.shape().0)?;
    let a = a.view();
    let found = run(py, Length::Long, progress, move |progress| {
        let options = match method {
            0 => GramSchmidtOptions::single_pass(),
            _ => GramSchmidtOptions::reorthogonalized(),
        };
        let options = options.par(par).progress(progress);
        let options = match threshold {
            Some(threshold) => options.threshold(threshold),
            None => options,
        };
        match method {
            2 => rank_revealing(a, &mass, &options),
            _ => gram_schmidt(a, &mass, &options),
        }
    })?;
    Ok((
        from_matrix(py, found.q.as_ref())?.into_any(),
        from_matrix(py, found.r.as_ref())?.into_any(),
        from_vec(py, found.kept).into_any(),
    ))
}
