//! Random checks of products.

use catamaran::product::Verification;
use catamaran::rows::{RowOptions, verify_rows};
use catamaran::{Real, Uplo};
use numpy::{PyArrayDescrMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::array::{Array, untyped};
use crate::ata::About;
use crate::gram::{Rows, RowsView};
use crate::options::uplo;
use crate::scalar::Scalar;
use crate::task::{Length, run};

/// What is checked beside A and C.
struct Claim<'a> {
    about: RowOptions<'a, f64>,
    alpha: f64,
    part: Uplo,
    rounds: u32,
    seed: u64,
}

/// Returns whether C is `alpha A^T A`, the residual, the tolerance, and the probability that
/// another C passes; see `catamaran.verify`.
#[pyfunction]
#[pyo3(signature = (a, c, weights, center, alpha, part, rounds, seed))]
pub fn verify<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    c: &Bound<'py, PyAny>,
    weights: Option<&Bound<'py, PyAny>>,
    center: Option<&Bound<'py, PyAny>>,
    alpha: f64,
    part: &str,
    rounds: u32,
    seed: u64,
) -> PyResult<(bool, f64, f64, f64)> {
    let (a, c) = (Rows::new("a", a, &[2])?, untyped("c", c)?);
    let about = About::<f64>::new(weights, center)?;
    let [weights, row] = about.entries();
    let about = about.options(weights.as_deref(), row.as_deref());
    let claim = Claim { about, alpha, part: uplo(part)?, rounds, seed };
    let is_single = c.dtype().kind() == b'f' && c.dtype().itemsize() == 4;
    let found = match is_single {
        true => check::<f32>(py, a.view(), &c, &claim)?,
        false => check::<f64>(py, a.view(), &c, &claim)?,
    };
    let Verification { passed, residual, tolerance, false_accept_probability } = found;
    Ok((passed, residual, tolerance, false_accept_probability))
}

fn check<T: Scalar + Real>(
    py: Python<'_>,
    mut a: RowsView<'_>,
    c: &Bound<'_, PyAny>,
    claim: &Claim<'_>,
) -> PyResult<Verification> {
    let c = Array::<T>::new("c", c, &[2])?;
    let c = c.view();
    let Claim { about, alpha, part, rounds, seed } = *claim;
    run(py, Length::Long, None, move |_| verify_rows(alpha, &mut a, &about, c, part, rounds, seed))
}
