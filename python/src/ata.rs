//! A^T A and A^T B.

use std::borrow::Cow;

use catamaran::blas::BlasReal;
use catamaran::faer::complex::Complex;
use catamaran::io::SparseRows;
use catamaran::product::{ata_batched_into, ata_sparse as sparse_product};
use catamaran::rows::{Center, DenseRows, RowBlocks, RowOptions, ata_rows};
use catamaran::{AtaOptions, Real, aha_into, ahb_into, ata_into as product, atb_into};
use numpy::{PyArrayDescrMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::PyBool;

use crate::array::{Array, untyped, zeros};
use crate::error::refused;
use crate::frame::{Frame, array_of};
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
    /// Returns where the result goes.
    fn output<T: Scalar>(&self, py: Python<'py>, shape: [usize; 2]) -> PyResult<Array<'py, T>> {
        match self.out {
            Some(out) => Array::output("out", out, shape),
            None => zeros(py, shape),
        }
    }

    /// Refuses an `out` that has an element in common with an input.
    fn check_apart<S, T: Scalar>(&self, c: &Array<'py, T>, input: &Array<'py, S>) -> PyResult<()> {
        if self.out.is_some() { c.check_apart("out", input) } else { Ok(()) }
    }

    fn has_rows_options(&self) -> bool {
        self.weights.is_some() || self.center.is_some()
    }
}

/// Returns the product; see `catamaran.ata`. `center` is None, True for the mean, or a row. `wide`
/// asks for an f64 result of f32 rows.
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
    let frame = Frame::of("a", a)?;
    // Whether `out` is memory of a frame is not known; a small frame is an array soon.
    let is_read = |frame: &&Frame| b.is_none() && out.is_none() && frame.is_large();
    if let Some(frame) = frame.as_ref().filter(is_read) {
        let call = Call { b: None, weights, center, out, alpha, beta, options, progress };
        let (mut rows, n) = (frame, frame.shape().1);
        return match frame.is_single && !wide {
            true => {
                let about = About::<f32>::new(weights, center)?;
                of_rows(py, &mut rows, &about, zeros(py, [n, n])?, call)
            }
            false => {
                let about = About::<f64>::new(weights, center)?;
                of_rows(py, &mut rows, &about, zeros(py, [n, n])?, call)
            }
        };
    }
    let a = match frame {
        Some(frame) => frame.whole(py)?,
        None => untyped("a", a)?,
    };
    let kind = |array: &Bound<'py, PyUntypedArray>| {
        let kind = array.dtype();
        (kind.kind(), kind.itemsize())
    };
    let b = b.map(|b| array_of("b", b)).transpose()?;
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

/// Returns a real product.
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
    let array = a.cast::<PyUntypedArray>().map(|array| array.shape());
    if let (Ok(&[count, m, n]), None) = (array, call.b) {
        return stack::<T>(py, a, [count, m, n], call);
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

/// Returns the products of a stack of matrices, count x m x n: a stack, count x n x n.
fn stack<'py, T>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    [count, m, n]: [usize; 3],
    call: Call<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>>
where
    T: Scalar + BlasReal,
{
    if call.out.is_some() {
        return Err(refused("out", "not with a stack of matrices"));
    }
    let reshape = intern!(py, "reshape");
    // Copied where the rows of one matrix and of the next one are not at one distance.
    let a = a.call_method1(reshape, ((count.saturating_mul(m), n),))?;
    let a = Array::<T>::new("a", &a, &[2])?;
    let mut c = zeros::<T>(py, [count.saturating_mul(n), n])?;
    let (view, mut rest) = (a.view(), c.view_mut());
    // Empty results take no memory, whatever their number.
    let filled = if n == 0 { 0 } else { count };
    let left: Vec<_> = (0..filled).map(|i| view.subrows(i * m, m)).collect();
    let mut products = Vec::with_capacity(filled);
    for _ in 0..filled {
        let (first, others) = rest.split_at_row_mut(n);
        products.push(first);
        rest = others;
    }
    let (alpha, beta) = (T::from_f64(call.alpha), T::from_f64(call.beta));
    let length = Length::of(count as f64 * m as f64 * n as f64 * n as f64 / 2.0);
    let options = &call.options;
    run(py, length, call.progress, move |progress| {
        let options = options.clone().progress(progress);
        ata_batched_into(alpha, &left, beta, &mut products, &options)
    })?;
    c.into_any().call_method1(reshape, ((count, n, n),))
}

/// The weights of rows, and what is subtracted from each.
pub struct About<'py, T> {
    weights: Option<Array<'py, T>>,
    mean: bool,
    row: Option<Array<'py, T>>,
}

impl<'py, T: Scalar + BlasReal> About<'py, T> {
    /// `center` is None, True for the mean, or a row.
    pub fn new(
        weights: Option<&Bound<'py, PyAny>>,
        center: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Self> {
        let vector = |name, object| Array::<T>::new(name, object, &[1]);
        let mean = center.is_some_and(|center| center.is_exact_instance_of::<PyBool>());
        Ok(Self {
            weights: weights.map(|weights| vector("weights", weights)).transpose()?,
            mean,
            row: center.filter(|_| !mean).map(|row| vector("center", row)).transpose()?,
        })
    }

    /// Returns the entries of the weights and of the row.
    pub fn entries(&self) -> [Option<Cow<'_, [T]>>; 2] {
        [&self.weights, &self.row].map(|array| array.as_ref().map(Array::entries))
    }

    /// Options of the library with these entries.
    pub fn options<'a>(&self, weights: Option<&'a [T]>, row: Option<&'a [T]>) -> RowOptions<'a, T> {
        let center = match row {
            Some(row) => Center::Given(row),
            None if self.mean => Center::Mean,
            None => Center::No,
        };
        RowOptions::new().weights(weights).center(center)
    }
}

/// Returns the product of weighted or centred rows of S, with a result of T.
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
    let about = About::<T>::new(call.weights, call.center)?;
    for vector in [&about.weights, &about.row].into_iter().flatten() {
        call.check_apart(&c, vector)?;
    }
    of_rows(py, &mut DenseRows(a.view()), &about, c, call)
}

/// Returns the product of rows, weighted or centred, in `c`.
fn of_rows<'py, T>(
    py: Python<'py>,
    a: &mut (dyn RowBlocks<T> + Send),
    about: &About<'py, T>,
    mut c: Array<'py, T>,
    call: Call<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>>
where
    T: Scalar + BlasReal,
{
    let (m, n) = (a.nrows(), a.ncols());
    let (alpha, beta) = (T::from_f64(call.alpha), T::from_f64(call.beta));
    let [weights, row] = about.entries();
    let about = about.options(weights.as_deref(), row.as_deref());
    let length = Length::of(m as f64 * n as f64 * n as f64 / 2.0);
    let (view, options) = (c.view_mut(), &call.options);
    run(py, length, call.progress, move |progress| {
        let options = options.clone().progress(progress);
        ata_rows(alpha, a, &about, beta, view, &options)
    })?;
    Ok(c.into_any())
}

/// Returns a complex product.
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

/// Returns A^T A of a sparse matrix by rows; see `catamaran.ata`. Centred rows are not sparse: they
/// are filled up block by block.
#[pyfunction]
#[pyo3(signature = (a, weights, center, out, alpha, beta, products, progress))]
pub fn ata_sparse<'py>(
    py: Python<'py>,
    a: Csr<'py>,
    weights: Option<&Bound<'py, PyAny>>,
    center: Option<&Bound<'py, PyAny>>,
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
    let about = About::<f64>::new(weights, center)?;
    if out.is_some() {
        for vector in [&about.weights, &about.row].into_iter().flatten() {
            c.check_apart("out", vector)?;
        }
    }
    let [weights, row] = about.entries();
    let (weights, rows) = (weights.as_deref(), about.options(weights.as_deref(), row.as_deref()));
    let (view, options, matrix) = (c.view_mut(), &options, &matrix);
    let is_centered = center.is_some();
    run(py, Length::Long, progress, move |progress| {
        let options = options.clone().progress(progress);
        match is_centered {
            true => ata_rows(alpha, &mut SparseRows(matrix), &rows, beta, view, &options),
            false => sparse_product(alpha, a, weights, beta, view, &options),
        }
    })?;
    Ok(c.into_any())
}
