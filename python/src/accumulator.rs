//! Sums over rows that come in blocks.

use std::path::PathBuf;

use catamaran::base::FloatEnv;
use catamaran::blas::BlasReal;
use catamaran::faer::Mat;
use catamaran::io::{
    Output, Overwrite, RowFile, accumulator_scalar, read_accumulator, write_accumulator,
};
use catamaran::rows::{
    Accumulator as Sum, DenseRows, ExtendedGram, RowBlocks, RowBounds, scalar_of,
};
use catamaran::{Error, Real, Uplo};
use numpy::{PyArrayDescrMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::array::{Array, from_matrix, from_vec};
use crate::error::{exception, refused};
use crate::exclusive::{Exclusive, Guard};
use crate::frame::array_of;
use crate::gram::{Fit, FitOptions, components_of};
use crate::options::{Products, Threads, par, word};
use crate::scalar::Scalar;
use crate::task::{Length, run};

/// The sums of one scalar or the other.
enum Sums {
    F32(Sum<f32>),
    F64(Sum<f64>),
}

/// `$body` with `$sum` the accumulator of the library.
macro_rules! each {
    ($sums:expr, $sum:ident => $body:expr) => {
        match $sums {
            Sums::F32($sum) => $body,
            Sums::F64($sum) => $body,
        }
    };
}

/// What rows will keep to: lower, upper, number of rows, largest weight.
type Bounds<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, u64, Option<f64>);

/// Sums of rows; see `catamaran.Accumulator`, which inherits from this class.
#[pyclass(frozen, module = "catamaran._catamaran", subclass)]
pub struct Accumulator {
    state: Exclusive<State>,
}

/// The sums, and whether they may be used.
struct State {
    sums: Sums,
    /// Why it must not be used any more.
    broken: Option<String>,
}

impl State {
    fn of(sums: Sums) -> Self {
        Self { sums, broken: None }
    }

    fn check(&self) -> PyResult<()> {
        match &self.broken {
            None => Ok(()),
            Some(why) => {
                Err(refused("accumulator", format_args!("must not be used after an error: {why}")))
            }
        }
    }

    fn sum_f64(&self) -> PyResult<Sum<f64>> {
        match &self.sums {
            Sums::F64(sum) => copy(sum),
            Sums::F32(_) => Err(refused("accumulator", "float32 sums have no extended precision")),
        }
    }

    /// Returns alpha C.
    fn result<'py>(&self, py: Python<'py>, alpha: f64, part: Uplo) -> PyResult<Bound<'py, PyAny>> {
        match &self.sums {
            Sums::F32(sum) => finished(py, sum, alpha, part),
            Sums::F64(sum) => finished(py, sum, alpha, part),
        }
    }

    /// Adds rows or removes them, block by block.
    fn change(
        &mut self,
        py: Python<'_>,
        rows: &Bound<'_, PyAny>,
        change: Change<'_, '_>,
    ) -> PyResult<()> {
        let mut started = false;
        let rows = array_of("rows", rows)?;
        let changed = match &mut self.sums {
            Sums::F32(sum) => array::<f32, f32>(py, sum, &rows, change, &mut started),
            Sums::F64(sum) if is_single(&rows) => {
                array::<f32, f64>(py, sum, &rows, change, &mut started)
            }
            Sums::F64(sum) => array::<f64, f64>(py, sum, &rows, change, &mut started),
        };
        self.note(py, changed, started)
    }

    /// Adds the rows of a file.
    fn add_file(
        &mut self,
        py: Python<'_>,
        mut file: RowFile,
        change: Change<'_, '_>,
    ) -> PyResult<()> {
        let (mut started, shape) = (false, (file.nrows(), file.ncols()));
        let added = each!(&mut self.sums, sum => {
            blocks(py, sum, &mut file, shape, change, &mut started)
        });
        self.note(py, added, started)
    }

    /// Notes an error that leaves the sums in between.
    fn note(&mut self, py: Python<'_>, changed: PyResult<()>, started: bool) -> PyResult<()> {
        if let Err(error) = &changed
            && started
        {
            self.broken = Some(error.value(py).to_string());
        }
        changed
    }
}

impl Accumulator {
    fn of(sums: Sums) -> Self {
        Self { state: Exclusive::new(State::of(sums)) }
    }

    /// Returns the state, when no other thread uses it, for a call that needs valid sums.
    fn valid(&self, py: Python<'_>) -> PyResult<Guard<'_, State>> {
        let state = self.state.lock(py)?;
        state.check()?;
        Ok(state)
    }

    /// Returns what `get` returns of the sums.
    fn get<R>(&self, py: Python<'_>, get: impl FnOnce(&Sums) -> R) -> PyResult<R> {
        Ok(get(&self.state.lock(py)?.sums))
    }

    fn extended(&self, py: Python<'_>, threads: Threads) -> PyResult<ExtendedGram> {
        let (sum, par) = (self.valid(py)?.sum_f64()?, par(threads)?);
        run(py, Length::Long, None, move |_| sum.finish_extended(par))
    }
}

fn is_single(rows: &Bound<'_, PyUntypedArray>) -> bool {
    let kind = rows.dtype();
    kind.kind() == b'f' && kind.itemsize() == 4
}

/// Returns a copy, bit for bit.
fn copy<T: BlasReal>(sum: &Sum<T>) -> PyResult<Sum<T>> {
    let mut bytes = Vec::new();
    sum.write(&mut bytes)?;
    Ok(Sum::read(&mut &bytes[..])?)
}

/// Adds the sums of another accumulator; an error leaves them as they were.
fn merge<T: BlasReal>(own: &mut Sum<T>, others: Sum<T>) -> PyResult<()> {
    if !own.is_exact() {
        // An error comes before the first change.
        return own.merge(others).map_err(exception);
    }
    // Integers may turn out too large when a part of them is added.
    let mut merged = own.try_clone().map_err(exception)?;
    merged.merge(others).map_err(exception)?;
    *own = merged;
    Ok(())
}

/// What is done with rows.
struct Change<'a, 'py> {
    weights: Option<&'a Bound<'py, PyAny>>,
    remove: bool,
    products: Products<'py>,
    progress: Option<Py<PyAny>>,
}

/// Adds or removes rows of S, as [`blocks`] does.
fn array<S: Scalar + Real, T: Scalar + BlasReal>(
    py: Python<'_>,
    sum: &mut Sum<T>,
    rows: &Bound<'_, PyAny>,
    change: Change<'_, '_>,
    started: &mut bool,
) -> PyResult<()> {
    let rows = Array::<S>::new("rows", rows, &[2])?;
    blocks(py, sum, &mut DenseRows(rows.view()), rows.shape(), change, started)
}

/// Adds or removes m x n rows. `started` tells whether an error leaves the sums in between.
fn blocks<T: Scalar + BlasReal>(
    py: Python<'_>,
    sum: &mut Sum<T>,
    rows: &mut (dyn RowBlocks<T> + Send),
    (m, n): (usize, usize),
    change: Change<'_, '_>,
    started: &mut bool,
) -> PyResult<()> {
    if n != sum.ncols() {
        let why = format!("rows: expected {} columns, got {n}", sum.ncols());
        return Err(PyValueError::new_err(why));
    }
    let weights = change.weights.map(|w| Array::<T>::new("weights", w, &[1])).transpose()?;
    let weights = weights.as_ref().map(Array::entries);
    if let Some(weights) = &weights
        && weights.len() != m
    {
        return Err(refused(
            "weights",
            format_args!("expected {m} of them, got {}", weights.len()),
        ));
    }
    let options = change.products.options()?;
    let length = Length::of(m as f64 * n as f64 * n as f64);
    let (remove, weights) = (change.remove, weights.as_deref());
    run(py, length, change.progress, move |progress| {
        use Error::{Argument, Io, NonFinite, Shape};
        let options = options.progress(progress);
        let before = sum.rows();
        let done = match remove {
            false => sum.add_rows(rows, weights, &options),
            true => sum.remove_rows(rows, weights, &options),
        };
        // What is refused, or can't be read, in the first block leaves the sums as they were.
        let refused =
            matches!(done, Err(Argument { .. } | NonFinite { .. } | Shape { .. } | Io { .. }));
        *started = !refused || sum.rows() != before;
        done
    })
}

#[pymethods]
impl Accumulator {
    /// `kind` is float, exact or extended; the last two need `bounds`: lower, upper, rows and the
    /// largest weight.
    #[new]
    #[pyo3(signature = (columns, center, scalar, kind, bounds))]
    fn new(
        columns: usize,
        center: bool,
        scalar: &str,
        kind: &str,
        bounds: Option<Bounds<'_>>,
    ) -> PyResult<Self> {
        let _nearest = FloatEnv::nearest();
        let single = word("dtype", scalar, &[("float64", false), ("float32", true)])?;
        let kind = word("kind", kind, &[("float", 0), ("exact", 1), ("extended", 2)])?;
        Ok(Self::of(match single {
            true => Sums::F32(make(columns, center, kind, bounds)?),
            false => Sums::F64(make(columns, center, kind, bounds)?),
        }))
    }

    #[pyo3(signature = (rows, weights, products, progress))]
    fn _add<'py>(
        &self,
        rows: &Bound<'py, PyAny>,
        weights: Option<&Bound<'py, PyAny>>,
        products: Products<'py>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<()> {
        let change = Change { weights, remove: false, products, progress };
        self.valid(rows.py())?.change(rows.py(), rows, change)
    }

    #[pyo3(signature = (rows, weights, products, progress))]
    fn _remove<'py>(
        &self,
        rows: &Bound<'py, PyAny>,
        weights: Option<&Bound<'py, PyAny>>,
        products: Products<'py>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<()> {
        let change = Change { weights, remove: true, products, progress };
        self.valid(rows.py())?.change(rows.py(), rows, change)
    }

    /// Adds the rows of a file, and returns what a user may not expect of them.
    #[pyo3(signature = (path, weights, products, progress))]
    fn _add_file<'py>(
        &self,
        py: Python<'py>,
        path: PathBuf,
        weights: Option<&Bound<'py, PyAny>>,
        products: Products<'py>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Vec<String>> {
        let file = RowFile::open(path).map_err(exception)?;
        let (mut notes, watched) = (file.notes().to_vec(), file.try_clone().map_err(exception)?);
        let change = Change { weights, remove: false, products, progress };
        self.valid(py)?.add_file(py, file, change)?;
        notes.extend(watched.rounded_integers());
        Ok(notes)
    }

    fn _merge(&self, other: &Bound<'_, Self>) -> PyResult<()> {
        let _nearest = FloatEnv::nearest();
        let py = other.py();
        // A copy, so that no thread holds one object while it waits for another.
        let others = match &other.get().valid(py)?.sums {
            Sums::F32(others) => Sums::F32(copy(others)?),
            Sums::F64(others) => Sums::F64(copy(others)?),
        };
        let mut state = self.valid(py)?;
        match (&mut state.sums, others) {
            (Sums::F32(own), Sums::F32(others)) => merge(own, others),
            (Sums::F64(own), Sums::F64(others)) => merge(own, others),
            _ => Err(refused("accumulator", "float32 and float64 sums can't be merged")),
        }
    }

    #[pyo3(signature = (alpha, part))]
    fn _result<'py>(&self, py: Python<'py>, alpha: f64, part: &str) -> PyResult<Bound<'py, PyAny>> {
        let _nearest = FloatEnv::nearest();
        let part = crate::options::uplo(part)?;
        self.valid(py)?.result(py, alpha, part)
    }

    /// Returns the covariance matrix; weight and sums are of the same rows.
    fn _cov<'py>(&self, py: Python<'py>, ddof: f64) -> PyResult<Bound<'py, PyAny>> {
        let _nearest = FloatEnv::nearest();
        let state = self.valid(py)?;
        let (centered, weight, rows) =
            each!(&state.sums, sum => (sum.is_centered(), sum.weight(), sum.rows()));
        if !centered {
            return Err(refused("accumulator", "not about the mean, make it with center=True"));
        }
        let freedom = weight - ddof;
        if freedom <= 0.0 {
            let why = format_args!("{ddof} leaves no degree of freedom of {rows} rows");
            return Err(refused("ddof", why));
        }
        state.result(py, 1.0 / freedom, Uplo::Both)
    }

    /// Returns the three parts of C, lower triangles, and whether the sums are exact.
    #[pyo3(signature = (threads))]
    fn _extended<'py>(
        &self,
        py: Python<'py>,
        threads: Threads,
    ) -> PyResult<(Vec<Bound<'py, PyAny>>, bool)> {
        let gram = self.extended(py, threads)?;
        let part = |part: usize| {
            let entry = |i, j| if i < j { 0.0 } else { gram.entry(i, j)[part] };
            Ok(from_matrix(py, Mat::from_fn(gram.n(), gram.n(), entry).as_ref())?.into_any())
        };
        Ok(((0..3).map(part).collect::<PyResult<_>>()?, gram.is_exact()))
    }

    fn _lstsq(&self, py: Python<'_>, targets: usize, options: FitOptions) -> PyResult<Fit> {
        let gram = self.extended(py, options.threads)?;
        Fit::of(py, gram, targets, &options)
    }

    #[pyo3(signature = (components, standardize, whiten, threads))]
    fn _pca<'py>(
        &self,
        py: Python<'py>,
        components: &Bound<'py, PyAny>,
        standardize: bool,
        whiten: bool,
        threads: Threads,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (sum, par) = (self.valid(py)?.sum_f64()?, par(threads)?);
        // Sums in float64 have relative errors of a few roundings for each column.
        let floor = match sum.is_extended() {
            true => 0.0,
            false => (16.0 * sum.ncols() as f64 * f64::EPSILON).sqrt(),
        };
        let gram = run(py, Length::Long, None, move |_| {
            if sum.is_extended() {
                return sum.finish_extended(par);
            }
            let (rows, mean) = (sum.rows(), sum.mean());
            if sum.weight() != rows as f64 {
                let why = "principal components of weighted rows need extended sums".into();
                return Err(Error::Argument { what: "accumulator", why });
            }
            ExtendedGram::from_f64(sum.finish(1.0, Uplo::Lower)?.as_ref(), rows, &mean)
        })?;
        components_of(py, gram, floor, components, standardize, whiten, threads)
    }

    fn _save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let state = self.valid(py)?;
        let sums = &state.sums;
        run(py, Length::Long, None, move |_| {
            let output = Output::create(&path, Overwrite::Replace)?;
            each!(sums, sum => write_accumulator(output, sum))
        })
    }

    /// Becomes the accumulator of a file.
    fn _load(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let sums = run(py, Length::Long, None, move |_| match accumulator_scalar(&path)? {
            "f32" => read_accumulator(&path).map(Sums::F32),
            _ => read_accumulator(&path).map(Sums::F64),
        })?;
        *self.state.lock(py)? = State::of(sums);
        Ok(())
    }

    fn _to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let mut bytes = Vec::new();
        each!(&self.valid(py)?.sums, sum => sum.write(&mut bytes))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Becomes the accumulator of these bytes.
    fn _restore(&self, py: Python<'_>, bytes: &[u8]) -> PyResult<()> {
        let damaged = |e: std::io::Error| refused("accumulator", e);
        let sums = match scalar_of(&mut &bytes[..]).map_err(damaged)? {
            "f32" => Sum::read(&mut &bytes[..]).map(Sums::F32),
            _ => Sum::read(&mut &bytes[..]).map(Sums::F64),
        };
        *self.state.lock(py)? = State::of(sums.map_err(damaged)?);
        Ok(())
    }

    #[getter]
    fn columns(&self, py: Python<'_>) -> PyResult<usize> {
        self.get(py, |sums| each!(sums, sum => sum.ncols()))
    }

    #[getter]
    fn rows(&self, py: Python<'_>) -> PyResult<u64> {
        self.get(py, |sums| each!(sums, sum => sum.rows()))
    }

    #[getter]
    fn weight(&self, py: Python<'_>) -> PyResult<f64> {
        self.get(py, |sums| each!(sums, sum => sum.weight()))
    }

    #[getter]
    fn centered(&self, py: Python<'_>) -> PyResult<bool> {
        self.get(py, |sums| each!(sums, sum => sum.is_centered()))
    }

    #[getter]
    fn exact(&self, py: Python<'_>) -> PyResult<bool> {
        self.get(py, |sums| each!(sums, sum => sum.is_exact()))
    }

    #[getter]
    fn is_extended(&self, py: Python<'_>) -> PyResult<bool> {
        self.get(py, |sums| each!(sums, sum => sum.is_extended()))
    }

    #[getter]
    fn dtype(&self, py: Python<'_>) -> PyResult<&'static str> {
        self.get(py, |sums| match sums {
            Sums::F32(_) => "float32",
            Sums::F64(_) => "float64",
        })
    }

    #[getter]
    fn mean<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let mean = self.get(py, |sums| each!(sums, sum => sum.mean()))?;
        Ok(from_vec(py, mean).into_any())
    }
}

/// Returns alpha C of sums, which stay as they are.
fn finished<'py, T: Scalar + BlasReal>(
    py: Python<'py>,
    sum: &Sum<T>,
    alpha: f64,
    part: Uplo,
) -> PyResult<Bound<'py, PyAny>> {
    let c = copy(sum)?.finish(alpha, part).map_err(exception)?;
    let c = c.as_ref();
    let array = crate::array::zeros::<T>(py, [c.nrows(), c.ncols()])?;
    Ok(filled(array, c).into_any())
}

/// Returns a copy of a matrix in an array.
fn filled<'py, T: Scalar>(
    mut array: Array<'py, T>,
    matrix: catamaran::faer::MatRef<'_, T>,
) -> Array<'py, T> {
    let mut view = array.view_mut();
    for i in 0..matrix.nrows() {
        for j in 0..matrix.ncols() {
            view[(i, j)] = matrix[(i, j)];
        }
    }
    array
}

/// Returns a new accumulator; `kind` is 0 (float), 1 (exact) or 2 (extended).
fn make<T: Scalar + BlasReal>(
    columns: usize,
    center: bool,
    kind: u8,
    bounds: Option<Bounds<'_>>,
) -> PyResult<Sum<T>> {
    let bounds = match (kind, bounds) {
        (0, None) => return Sum::new(columns, center).map_err(exception),
        (0, Some(_)) => return Err(refused("bounds", "floating-point sums need none")),
        (_, None) => return Err(refused("bounds", "exact sums need them: lower, upper, rows")),
        (_, Some(bounds)) => bounds,
    };
    let (lower, upper, rows, weight) = bounds;
    let [lower, upper] = [lower, upper]
        .map(|side| Ok::<_, PyErr>(Array::<T>::new("bounds", &side, &[1])?.entries().into_owned()));
    let mut bounds = RowBounds::new(lower?, upper?, rows).map_err(exception)?;
    if bounds.ncols() != columns {
        return Err(refused("bounds", format_args!("expected {columns}, got {}", bounds.ncols())));
    }
    if let Some(weight) = weight {
        bounds = bounds.with_weights(T::from_f64(weight)).map_err(exception)?;
    }
    match kind {
        1 => Sum::exact(&bounds, center),
        _ => Sum::extended(&bounds, center),
    }
    .map_err(exception)
}
