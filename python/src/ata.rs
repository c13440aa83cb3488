//! A^T A and A^T B.

use catamaran::blas::BlasReal;
use catamaran::faer::complex::Complex;
use catamaran::product::ata_sparse as sparse_product;
use catamaran::rows::{Center, DenseRows, RowBlocks, RowOptions, ata_rows};
use catamaran::{AtaOptions, Real, aha_into, ahb_into, ata_into as product, atb_into};
use numpy::{PyArrayDescrMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyBool;

use crate::array::{Array, untyped, zeros};
use crate::error::refused;
use crate::frame::Frame;
use crate::options::Products;
use crate::scalar::Scalar;
use crate::sparse::Csr;
use crate::task::{Length, run};

/// What a call of [`ata`] says beside A.
struct Call<'a, 'py> {
    b: Option<&'a Bound<'py, PyAny>>,
    weights: Option<&'a Bound<'py, PyAny>>,
    center: Option<&'a Bound<'py, PyAny>>,
    out: Option<&'a Bound<'py, PyAny>>,
    alpha: f64,
    beta: f64,
    options: AtaOptions<'static>,
    progress: Option<Py<PyAny>>,
}

impl<'py> Call<'_, 'py> {
    /// Where the result goes.
    fn output<T: Scalar>(&self, py: Python<'py>, shape: [usize; 2]) -> PyResult<Array<'py, T>> {
        match self.out {
            Some(out) => Array::output("out", out, shape),
            None => zeros(py, shape),
        }
    }

    /// Refuses an `out` in whose memory an input is.
    fn check_apart<S, T: Scalar>(&self, c: &Array<'py, T>, input: &Array<'py, S>) -> PyResult<()> {
        if self.out.is_some() { c.check_apart("out", input) } else { Ok(()) }
    }

    fn has_rows_options(&self) -> bool {
        self.weights.is_some() || self.center.is_some()
    }
}

/// The product; see `catamaran.ata`. `center` is None, True for the mean, or a row. `wide` asks for
/// an f64 result of f32 rows.
#[pyfunction]
#[pyo3(signature = (a, b, weights, center, out, alpha, beta, products, wide, progress))]
pub fn ata<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    b: Option<&Bound<'py, PyAny>>,
    weights: Option<&Bound<'py, PyAny>>,
    center: Option<&Bound<'py, PyAny>>,
    out: Option<&Bound<'py, PyAny>>,
    alpha: f64,
    beta: f64,
    products: Products<'py>,
    wide: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let options = products.options()?;
    // Whether `out` is memory of a frame is not known; a small frame is an array soon.
    let frame = Frame::of("a", a)?.filter(|frame| b.is_none() && out.is_none() && frame.is_large());
    if let Some(frame) = frame {
        let call = Call { b: None, weights, center, out, alpha, beta, options, progress };
        let (mut rows, n) = (&frame, frame.shape().1);
        return match frame.is_single && !wide {
            true => of_rows::<f32>(py, &mut rows, zeros(py, [n, n])?, call),
            false => of_rows::<f64>(py, &mut rows, zeros(py, [n, n])?, call),
        };
    }
    let a = untyped(a)?;
    let kind = |array: &Bound<'py, PyUntypedArray>| {
        let kind = array.dtype();
        (kind.kind(), kind.itemsize())
    };
    let b = b.map(untyped).transpose()?;
    let mut kinds = vec![kind(&a)];
    kinds.extend(b.as_ref().map(kind));
    let call = Call { b: b.as_deref(), weights, center, out, alpha, beta, options, progress };
    if call.b.is_some() && call.has_rows_options() {
        return Err(refused("b", "weights and center belong to A^T A, not to A^T B"));
    }
    let complex = kinds.iter().any(|kind| kind.0 == b'c');
    let single = |&(kind, bytes): &(u8, usize)| match kind {
        b'f' => bytes <= 4,
        b'c' => bytes <= 8,
        _ => false,
    };
    let narrow = kinds.iter().all(single);
    match (complex, narrow, wide) {
        (false, true, false) => real::<f32>(py, &a, call),
        (false, true, true) if b.is_none() => rows::<f32, f64>(py, &a, call),
        (false, _, _) => real::<f64>(py, &a, call),
        (true, true, false) => hermitian::<f32>(py, &a, call),
        (true, _, _) => hermitian::<f64>(py, &a, call),
    }
}

/// A real product.
fn real<'py, T>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    call: Call<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>>
where
    T: Scalar + BlasReal,
{
    if call.has_rows_options() {
        return rows::<T, T>(py, a, call);
    }
    let a = Array::<T>::new("a", a, &[2])?;
    let (m, n) = a.shape();
    let (alpha, beta) = (T::from_f64(call.alpha), T::from_f64(call.beta));
    let Some(b) = call.b else {
        let mut c = call.output::<T>(py, [n, n])?;
        call.check_apart(&c, &a)?;
        let length = Length::of(m as f64 * n as f64 * n as f64 / 2.0);
        let (a, view, options) = (a.view(), c.view_mut(), &call.options);
        run(py, length, call.progress, move |progress| {
            product(alpha, a, beta, view, &options.clone().progress(progress))
        })?;
        return Ok(c.into_any());
    };
    let b = Array::<T>::new("b", b, &[2])?;
    let (_, k) = b.shape();
    let mut c = call.output::<T>(py, [n, k])?;
    call.check_apart(&c, &a)?;
    call.check_apart(&c, &b)?;
    let length = Length::of(m as f64 * n as f64 * k as f64);
    let (a, b, view, options) = (a.view(), b.view(), c.view_mut(), &call.options);
    run(py, length, call.progress, move |progress| {
        atb_into(alpha, a, b, beta, view, &options.clone().progress(progress))
    })?;
    Ok(c.into_any())
}

/// The product of weighted or centred rows of S, with a result of T.
fn rows<'py, S, T>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    call: Call<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>>
where
    S: Scalar + Real,
    T: Scalar + BlasReal,
{
    let a = Array::<S>::new("a", a, &[2])?;
    let (_, n) = a.shape();
    let c = call.output::<T>(py, [n, n])?;
    call.check_apart(&c, &a)?;
    of_rows(py, &mut DenseRows(a.view()), c, call)
}

/// The product of rows, weighted or centred, in `c`.
fn of_rows<'py, T>(
    py: Python<'py>,
    a: &mut (dyn RowBlocks<T> + Send),
    mut c: Array<'py, T>,
    call: Call<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>>
where
    T: Scalar + BlasReal,
{
    let (m, n) = (a.nrows(), a.ncols());
    let (alpha, beta) = (T::from_f64(call.alpha), T::from_f64(call.beta));
    let weights = call.weights.map(|w| Array::<T>::new("weights", w, &[1])).transpose()?;
    let mean = call.center.is_some_and(|center| center.is_exact_instance_of::<PyBool>());
    let given = call.center.filter(|_| !mean);
    let given = given.map(|center| Array::<T>::new("center", center, &[1])).transpose()?;
    let weights = weights.as_ref().map(Array::entries);
    let given = given.as_ref().map(Array::entries);
    let center = match &given {
        Some(row) => Center::Given(row),
        None if mean => Center::Mean,
        None => Center::No,
    };
    let about = RowOptions::new().weights(weights.as_deref()).center(center);
    let length = Length::of(m as f64 * n as f64 * n as f64 / 2.0);
    let (view, options) = (c.view_mut(), &call.options);
    run(py, length, call.progress, move |progress| {
        let options = options.clone().progress(progress);
        ata_rows(alpha, a, &about, beta, view, &options)
    })?;
    Ok(c.into_any())
}

/// A complex product.
fn hermitian<'py, T>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    call: Call<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>>
where
    T: BlasReal,
    Complex<T>: Scalar,
{
    if call.has_rows_options() {
        return Err(PyTypeError::new_err("a: complex, where weights and center need real numbers"));
    }
    let a = Array::<Complex<T>>::new("a", a, &[2])?;
    let (m, n) = a.shape();
    let (alpha, beta) = (T::from_f64(call.alpha), T::from_f64(call.beta));
    if let Some(b) = call.b {
        let b = Array::<Complex<T>>::new("b", b, &[2])?;
        let (_, k) = b.shape();
        let mut c = call.output::<Complex<T>>(py, [n, k])?;
        call.check_apart(&c, &a)?;
        call.check_apart(&c, &b)?;
        let length = Length::of(4.0 * m as f64 * n as f64 * k as f64);
        let (a, b, view, options) = (a.view(), b.view(), c.view_mut(), &call.options);
        let [alpha, beta] = [alpha, beta].map(|re| Complex { re, im: T::ZERO });
        run(py, length, call.progress, move |progress| {
            ahb_into(alpha, a, b, beta, view, &options.clone().progress(progress))
        })?;
        return Ok(c.into_any());
    }
    let mut c = call.output::<Complex<T>>(py, [n, n])?;
    call.check_apart(&c, &a)?;
    let length = Length::of(2.0 * m as f64 * n as f64 * n as f64);
    let (a, view, options) = (a.view(), c.view_mut(), &call.options);
    run(py, length, call.progress, move |progress| {
        aha_into(alpha, a, beta, view, &options.clone().progress(progress))
    })?;
    Ok(c.into_any())
}

/// A^T A of a sparse matrix by rows; see `catamaran.ata`.
#[pyfunction]
#[pyo3(signature = (a, weights, out, alpha, beta, products, progress))]
pub fn ata_sparse<'py>(
    py: Python<'py>,
    a: Csr<'py>,
    weights: Option<&Bound<'py, PyAny>>,
    out: Option<&Bound<'py, PyAny>>,
    alpha: f64,
    beta: f64,
    products: Products<'py>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let options = products.options()?;
    let matrix = a.matrix("a")?.to_matrix()?;
    let a = matrix.view();
    let n = a.cols();
    let mut c = match out {
        Some(out) => Array::<f64>::output("out", out, [n, n])?,
        None => zeros(py, [n, n])?,
    };
    let weights = weights.map(|w| Array::<f64>::new("weights", w, &[1])).transpose()?;
    let weights = weights.as_ref().map(Array::entries);
    let (view, options, weights) = (c.view_mut(), &options, weights.as_deref());
    run(py, Length::Long, progress, move |progress| {
        sparse_product(alpha, a, weights, beta, view, &options.clone().progress(progress))
    })?;
    Ok(c.into_any())
}
