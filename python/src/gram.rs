//! Least squares, principal components and singular values.

use catamaran::base::{Progress, block_rows};
use catamaran::faer::{Mat, MatRef};
use catamaran::io::SparseRows;
use catamaran::rows::{
    Center, DenseRows, Design, DesignColumn, ExtendedGram, Factor, RowBlocks, RowOptions, Survey,
    ata_extended,
};
use catamaran::solve::{
    Components, GramQr, JoinedRows, LeastSquares, LeastSquaresOptions,
    PrincipalComponents as Principal, PrincipalComponentsOptions, RankDeficiency, SingularValues,
    check_weights, correlation, orthogonality as distance,
};
use catamaran::sparse::CsMat;
use catamaran::{AtaOptions, Error, Par};
use numpy::{PyArrayDescrMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::array::{Array, from_matrix, from_vec, untyped, zeros};
use crate::error::exception;
use crate::frame::Frame;
use crate::options::{Threads, arguments, par, word};
use crate::sparse::Csr;
use crate::task::{Length, run};

/// Rows of f32 or of f64, which become f64 without rounding, those of a data frame, or those of a
/// sparse matrix, which are filled up block by block.
pub enum Rows<'py> {
    F32(Array<'py, f32>),
    F64(Array<'py, f64>),
    Frame(Frame),
    Sparse(CsMat<f64>),
}

/// Their view, which other threads may hold.
#[derive(Clone, Copy)]
pub enum RowsView<'a> {
    F32(MatRef<'a, f32>),
    F64(MatRef<'a, f64>),
    Frame(&'a Frame),
    Sparse(SparseRows<'a>),
}

impl<'py> Rows<'py> {
    /// Returns the rows of an array of these numbers of dimensions, of a data frame or of a sparse
    /// matrix.
    pub fn new(
        name: &'static str,
        object: &Bound<'py, PyAny>,
        dimensions: &[usize],
    ) -> PyResult<Self> {
        if object.hasattr("indptr")? {
            return Ok(Self::Sparse(object.extract::<Csr<'_>>()?.matrix(name)?.to_matrix()?));
        }
        if let Some(frame) = Frame::of(name, object)? {
            return Ok(Self::Frame(frame));
        }
        let array = untyped(name, object)?;
        let (kind, bytes) = (array.dtype().kind(), array.dtype().itemsize());
        Ok(match kind == b'f' && bytes == 4 {
            true => Self::F32(Array::new(name, &array, dimensions)?),
            false => Self::F64(Array::new(name, &array, dimensions)?),
        })
    }

    /// Rows and columns; a vector is a column.
    pub fn shape(&self) -> (usize, usize) {
        match self {
            Self::F32(array) => array.shape(),
            Self::F64(array) => array.shape(),
            Self::Frame(frame) => frame.shape(),
            Self::Sparse(matrix) => matrix.shape(),
        }
    }

    /// Returns the view.
    pub fn view(&self) -> RowsView<'_> {
        match self {
            Self::F32(array) => RowsView::F32(array.view()),
            Self::F64(array) => RowsView::F64(array.view()),
            Self::Frame(frame) => RowsView::Frame(frame),
            Self::Sparse(matrix) => RowsView::Sparse(SparseRows(matrix)),
        }
    }
}

impl RowBlocks<f64> for RowsView<'_> {
    fn nrows(&self) -> usize {
        match self {
            Self::F32(view) => view.nrows(),
            Self::F64(view) => view.nrows(),
            Self::Frame(frame) => frame.shape().0,
            Self::Sparse(rows) => RowBlocks::<f64>::nrows(rows),
        }
    }

    fn ncols(&self) -> usize {
        match self {
            Self::F32(view) => view.ncols(),
            Self::F64(view) => view.ncols(),
            Self::Frame(frame) => frame.shape().1,
            Self::Sparse(rows) => RowBlocks::<f64>::ncols(rows),
        }
    }

    fn read(
        &mut self,
        first: usize,
        out: catamaran::faer::MatMut<'_, f64>,
    ) -> catamaran::Result<()> {
        match self {
            Self::F32(view) => DenseRows(*view).read(first, out),
            Self::F64(view) => DenseRows(*view).read(first, out),
            Self::Frame(frame) => frame.read(first, out),
            Self::Sparse(rows) => rows.read(first, out),
        }
    }
}

/// The share of the time that passes over the rows take, of work that goes on after them.
const PASSES: f64 = 0.9;

/// Returns the Gram matrix of rows in extended precision.
fn gram_of(
    rows: &mut (dyn RowBlocks<f64> + Send),
    weights: Option<&[f64]>,
    centered: bool,
    par: Par,
    progress: Progress<'_>,
) -> catamaran::Result<ExtendedGram> {
    let center = if centered { Center::Mean } else { Center::No };
    let options = AtaOptions::new().par(par).progress(progress.part(0.0..PASSES));
    ata_extended(rows, &RowOptions::new().weights(weights).center(center), &options)
}

arguments! {
    /// How least squares are solved, as a dictionary.
    pub struct FitOptions {
        ridge: f64,
        intercept: bool,
        rank_deficiency: String,
        standard_errors: bool,
        /// All cores by default.
        pub threads: Threads,
    }
}

impl FitOptions {
    fn options(&self) -> PyResult<LeastSquaresOptions> {
        let known =
            [("minimum_norm", RankDeficiency::MinimumNorm), ("refuse", RankDeficiency::Refuse)];
        Ok(LeastSquaresOptions::new()
            .ridge(self.ridge)
            .intercept(self.intercept)
            .rank_deficiency(word("rank_deficiency", &self.rank_deficiency, &known)?)
            .standard_errors(self.standard_errors)
            .par(par(self.threads)?))
    }
}

/// A solution, which becomes a dictionary.
pub struct Fit(LeastSquares);

impl Fit {
    /// Solves for the last columns of a Gram matrix.
    pub fn of(
        py: Python<'_>,
        gram: ExtendedGram,
        targets: usize,
        options: &FitOptions,
    ) -> PyResult<Self> {
        let options = options.options()?;
        run(py, Length::Long, None, move |_| LeastSquares::from_gram(&gram, targets, &options))
            .map(Self)
    }
}

impl<'py> IntoPyObject<'py> for Fit {
    type Target = PyDict;
    type Output = Bound<'py, PyDict>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let fit = &self.0;
        let [deviations, adjusted] = [fit.residual_deviations(), fit.adjusted_r_squared()];
        let [intercept_t, intercept_p] = [fit.intercept_t_statistics(), fit.intercept_p_values()];
        let f_p_values = fit.f_p_values();
        let (t, p) = match fit.standard_errors.ncols() {
            0 => (Mat::new(), Mat::new()),
            _ => (fit.t_statistics().map_err(exception)?, fit.p_values().map_err(exception)?),
        };
        let (root, mean, weight) = match fit.model().uncertainty {
            Some(found) => (found.root.to_owned(), found.mean.to_vec(), found.weight),
            None => (Mat::new(), Vec::new(), f64::INFINITY),
        };
        let LeastSquares {
            coefficients,
            coefficients_low,
            intercepts,
            residual_norms,
            r_squared,
            f_statistics,
            observations,
            standard_errors,
            intercept_errors,
            rank,
            dependent,
            condition,
            degrees_of_freedom,
            digits,
            ..
        } = self.0;
        let found = PyDict::new(py);
        found.set_item("x", from_matrix(py, coefficients.as_ref())?)?;
        found.set_item("x_low", from_matrix(py, coefficients_low.as_ref())?)?;
        found.set_item("intercept", from_vec(py, intercepts))?;
        found.set_item("residual_norm", from_vec(py, residual_norms))?;
        found.set_item("r_squared", from_vec(py, r_squared))?;
        found.set_item("standard_errors", from_matrix(py, standard_errors.as_ref())?)?;
        found.set_item("intercept_errors", from_vec(py, intercept_errors))?;
        found.set_item("t_statistics", from_matrix(py, t.as_ref())?)?;
        found.set_item("p_values", from_matrix(py, p.as_ref())?)?;
        found.set_item("intercept_t_statistics", from_vec(py, intercept_t))?;
        found.set_item("intercept_p_values", from_vec(py, intercept_p))?;
        found.set_item("residual_deviation", from_vec(py, deviations))?;
        found.set_item("adjusted_r_squared", from_vec(py, adjusted))?;
        found.set_item("f_statistic", from_vec(py, f_statistics))?;
        found.set_item("f_p_value", from_vec(py, f_p_values))?;
        found.set_item("root", from_matrix(py, root.as_ref())?)?;
        found.set_item("mean", from_vec(py, mean))?;
        found.set_item("weight", weight)?;
        found.set_item("observations", observations)?;
        found.set_item("rank", rank)?;
        found.set_item("dependent", from_vec(py, dependent))?;
        found.set_item("condition", condition)?;
        found.set_item("degrees_of_freedom", degrees_of_freedom)?;
        found.set_item("digits", digits)?;
        Ok(found)
    }
}

/// Computes least squares; see `catamaran.lstsq`.
#[pyfunction]
#[pyo3(signature = (a, b, weights, options, progress))]
pub fn lstsq<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    b: &Bound<'py, PyAny>,
    weights: Option<&Bound<'py, PyAny>>,
    options: FitOptions,
    progress: Option<Py<PyAny>>,
) -> PyResult<Fit> {
    let (a, b) = (Rows::new("a", a, &[2])?, Rows::new("b", b, &[1, 2])?);
    let weights = weights.map(|w| Array::<f64>::new("weights", w, &[1])).transpose()?;
    let weights = weights.as_ref().map(Array::entries);
    let options = options.options()?;
    let (m, n) = a.shape();
    let (mut a, mut b, weights) = (a.view(), b.view(), weights.as_deref());
    // Extended products take about a hundred times as long as plain ones.
    let length = Length::of(1e2 * m as f64 * n as f64 * n as f64);
    run(py, length, progress, move |progress| {
        check_weights(weights)?;
        let targets = RowBlocks::<f64>::ncols(&b);
        let mut rows = JoinedRows::new(&mut a, &mut b)?;
        let gram = gram_of(&mut rows, weights, options.intercept, options.par, progress)
            .map_err(|error| of_table(error, n))?;
        LeastSquares::from_gram(&gram, targets, &options)
    })
    .map(Fit)
}

/// Returns an error of the rows of [A B], where A has n columns, as that of the argument at fault.
fn of_table(error: Error, n: usize) -> Error {
    let Error::NonFinite { what: "rows", index: (i, j) } = error else { return error };
    let (what, column) = argument(j, n, 0);
    let why = "missing=\"drop\" leaves out rows with a NaN";
    Error::Argument { what, why: format!("not finite at row {i}, column {column}: {why}") }
}

/// Returns the argument of a column of a table, and its column there. The table has the n columns
/// of A, so many columns of factors, and those of B.
fn argument(column: usize, n: usize, factors: usize) -> (&'static str, usize) {
    match column {
        j if j < n => ("a", j),
        j if j < n + factors => ("factors", j - n),
        j => ("b", j - n - factors),
    }
}

/// Returns the error of a row of a table with a NaN as that of the argument at fault; A has n
/// columns.
fn missing_in(
    table: &mut (dyn RowBlocks<f64> + Send),
    row: usize,
    n: usize,
    factors: &[Coded],
) -> catamaran::Result<Error> {
    let width = table.ncols();
    let mut entries = vec![0.0_f64; width];
    let out = catamaran::faer::MatMut::from_row_major_slice_mut(&mut entries, 1, width);
    table.read(row, out)?;
    let column = entries.iter().position(|entry| entry.is_nan()).unwrap_or(0);
    let (what, column) = argument(column, n, factors.len());
    let value = match what {
        "factors" => format!("a label of {} is missing in row {row}", factors[column].0),
        _ => format!("a value is missing in row {row}, column {column}"),
    };
    Ok(Error::Argument { what, why: format!("{value}: missing=\"drop\" leaves it out") })
}

/// Returns an error of rows as that of the argument `a`.
fn of_rows(error: Error) -> Error {
    match error {
        Error::NonFinite { what: "rows", index } => Error::NonFinite { what: "a", index },
        other => other,
    }
}

/// A factor: its name, its levels in the order of their codes, and whether the order stays.
type Coded = (String, Vec<String>, bool);

/// Computes least squares of a table: columns of A, then codes of factors, NaN where one is
/// missing. Returns also the names of the columns that factors become, and the rows that are left
/// out.
#[pyfunction]
#[pyo3(signature = (a, codes, factors, b, weights, drop, options, progress))]
pub fn lstsq_table<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    codes: &Bound<'py, PyAny>,
    factors: Vec<Coded>,
    b: &Bound<'py, PyAny>,
    weights: Option<&Bound<'py, PyAny>>,
    drop: bool,
    options: FitOptions,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Fit, Vec<String>, Vec<usize>)> {
    let (a, b) = (Rows::new("a", a, &[2])?, Rows::new("b", b, &[1, 2])?);
    let codes = Rows::new("factors", codes, &[2])?;
    let weights = weights.map(|w| Array::<f64>::new("weights", w, &[1])).transpose()?;
    let weights = weights.as_ref().map(Array::entries);
    let options = options.options()?;
    let (n, targets) = (a.shape().1, b.shape().1);
    let (mut a, mut codes, mut b) = (a.view(), codes.view(), b.view());
    let weights = weights.as_deref();
    let (found, columns, left_out) = run(py, Length::Long, progress, move |progress| {
        check_weights(weights)?;
        let mut with_codes = JoinedRows::new(&mut a, &mut codes)?;
        let mut table = JoinedRows::new(&mut with_codes, &mut b)?;
        let m = RowBlocks::<f64>::nrows(&table);
        if let Some(weights) = weights
            && weights.len() != m
        {
            let (expected, got) = ((m, 1), (weights.len(), 1));
            return Err(Error::Shape { what: "weights", expected, got });
        }
        let all = n + factors.len() + targets;
        let used: Vec<usize> = (0..all).collect();
        let survey = Survey::of(&mut table, &used, &used[n..n + factors.len()], options.par);
        let survey = survey.map_err(|error| match error {
            Error::NonFinite { what: "table", index: (row, j) } => {
                let (what, column) = argument(j, n, factors.len());
                Error::NonFinite { what, index: (row, column) }
            }
            other => other,
        })?;
        if let (false, Some(&row)) = (drop, survey.missing.first()) {
            return Err(missing_in(&mut table, row, n, &factors)?);
        }
        let mut design: Vec<DesignColumn> = used.into_iter().map(DesignColumn::Numbers).collect();
        let mut columns = Vec::new();
        for (k, (name, levels, ordered)) in factors.into_iter().enumerate() {
            let factor = match ordered {
                true => Factor::in_order(name, levels)?,
                false => Factor::of_codes(name, levels)?,
            };
            let factor = factor.with_entries(&survey.entries[k])?;
            columns.extend(factor.columns());
            design[n + k] = DesignColumn::Indicators(n + k, factor);
        }
        let left_out = survey.missing.clone();
        let design = Design::new(design).without_rows(survey.missing);
        let kept = weights.map(|weights| design.kept(weights)).transpose()?;
        let mut rows = design.rows(&mut table)?;
        let (par, intercept) = (options.par, options.intercept);
        let gram = gram_of(&mut rows, kept.as_deref(), intercept, par, progress)?;
        Ok((LeastSquares::from_gram(&gram, targets, &options)?, columns, left_out))
    })?;
    Ok((Fit(found), columns, left_out))
}

/// Returns the half-width of a confidence interval in standard errors: the quantile of Student's t
/// distribution that is exceeded in size with this probability.
#[pyfunction]
pub fn t_quantile(probability: f64, freedom: f64) -> f64 {
    catamaran::solve::t_quantile(probability, freedom)
}

/// Computes principal components of a Gram matrix about the mean, as a dictionary. Those whose
/// singular values are less than `floor` times the largest are rounding, and left out.
pub fn components_of<'py>(
    py: Python<'py>,
    gram: ExtendedGram,
    floor: f64,
    components: &Bound<'py, PyAny>,
    standardize: bool,
    whiten: bool,
    threads: Threads,
) -> PyResult<Bound<'py, PyDict>> {
    let options = principal_options(components, standardize, whiten, threads)?;
    let mut found = run(py, Length::Long, None, move |_| Principal::from_gram(&gram, &options))?;
    let least = floor * found.singular_values.first().copied().unwrap_or(0.0);
    let count = found.singular_values.partition_point(|&value| value >= least);
    found.components = found.components.as_ref().subrows(0, count).to_owned();
    found.explained_variance.truncate(count);
    found.explained_variance_ratio.truncate(count);
    found.singular_values.truncate(count);
    principal(py, found)
}

/// Computes principal components as a dictionary.
fn principal(py: Python<'_>, of: Principal) -> PyResult<Bound<'_, PyDict>> {
    let found = PyDict::new(py);
    found.set_item("components", from_matrix(py, of.components.as_ref())?)?;
    found.set_item("explained_variance", from_vec(py, of.explained_variance))?;
    found.set_item("explained_variance_ratio", from_vec(py, of.explained_variance_ratio))?;
    found.set_item("singular_values", from_vec(py, of.singular_values))?;
    found.set_item("mean", from_vec(py, of.mean))?;
    found.set_item("scale", from_vec(py, of.scale))?;
    found.set_item("whiten", of.whiten)?;
    Ok(found)
}

/// Returns all components by default, a number of them, or a share of the variance between 0 and 1.
fn principal_options(
    components: &Bound<'_, PyAny>,
    standardize: bool,
    whiten: bool,
    threads: Threads,
) -> PyResult<PrincipalComponentsOptions> {
    let components = if components.is_none() {
        Components::All
    } else if let Ok(count) = components.extract::<usize>() {
        Components::Count(count)
    } else {
        Components::Share(crate::options::extracted("n_components", components)?)
    };
    Ok(PrincipalComponentsOptions::new()
        .components(components)
        .standardize(standardize)
        .whiten(whiten)
        .par(par(threads)?))
}

/// Computes principal components; see `catamaran.pca`.
#[pyfunction]
#[pyo3(signature = (a, weights, components, standardize, whiten, threads, progress))]
pub fn pca<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    weights: Option<&Bound<'py, PyAny>>,
    components: &Bound<'py, PyAny>,
    standardize: bool,
    whiten: bool,
    threads: Threads,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let a = Rows::new("a", a, &[2])?;
    let weights = weights.map(|w| Array::<f64>::new("weights", w, &[1])).transpose()?;
    let weights = weights.as_ref().map(Array::entries);
    let options = principal_options(components, standardize, whiten, threads)?;
    let (mut a, weights) = (a.view(), weights.as_deref());
    let found = run(py, Length::Long, progress, move |progress| {
        let gram = gram_of(&mut a, weights, true, options.par, progress).map_err(of_rows)?;
        Principal::from_gram(&gram, &options)
    })?;
    principal(py, found)
}

/// Returns the scores of rows, block by block. `of` has the attributes of
/// `catamaran.PrincipalComponents`.
#[pyfunction]
#[pyo3(signature = (rows, of, progress))]
pub fn scores<'py>(
    py: Python<'py>,
    rows: &Bound<'py, PyAny>,
    of: &Bound<'py, PyAny>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let vector = |name: &str| -> PyResult<Vec<f64>> {
        Ok(Array::<f64>::new(name, &of.getattr(name)?, &[1])?.entries().into_owned())
    };
    let found = Principal::from_parts(
        Array::<f64>::new("components", &of.getattr("components")?, &[2])?.view().to_owned(),
        [
            vector("explained_variance")?,
            vector("explained_variance_ratio")?,
            vector("singular_values")?,
        ],
        vector("mean")?,
        vector("scale")?,
        of.getattr("whiten")?.extract()?,
    )
    .map_err(exception)?;
    let rows = Rows::new("rows", rows, &[2])?;
    let (m, n) = rows.shape();
    let mut scores = zeros::<f64>(py, [m, found.components.nrows()])?;
    let (mut rows, mut out) = (rows.view(), scores.view_mut());
    let length = Length::of(m as f64 * n as f64 * found.components.nrows() as f64);
    run(py, length, progress, move |progress| {
        Error::check_shape("rows", (m, found.mean.len()), (m, n))?;
        for_blocks(&mut rows, progress, |first, block| {
            let scores = found.scores(block)?;
            out.as_mut().subrows_mut(first, scores.nrows()).copy_from(&scores);
            Ok(())
        })
    })?;
    Ok(scores.into_any())
}

/// Calls `work` with blocks of rows and the number of their first row.
fn for_blocks(
    rows: &mut dyn RowBlocks<f64>,
    progress: Progress<'_>,
    mut work: impl FnMut(usize, MatRef<'_, f64>) -> catamaran::Result<()>,
) -> catamaran::Result<()> {
    let (m, n) = (rows.nrows(), rows.ncols());
    let height = block_rows::<f64>(n, true).min(4096).min(m).max(1);
    let mut block = Mat::<f64>::zeros(height, n);
    for first in (0..m).step_by(height) {
        progress.report(first as f64 / m as f64)?;
        let count = height.min(m - first);
        rows.read(first, block.as_mut().subrows_mut(0, count))?;
        work(first, block.as_ref().subrows(0, count))?;
    }
    Ok(())
}

/// Returns singular values and right singular vectors; see `catamaran.svd`.
#[pyfunction]
#[pyo3(signature = (a, threads, progress))]
pub fn svd<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    threads: Threads,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let (a, par) = (Rows::new("a", a, &[2])?, par(threads)?);
    let mut a = a.view();
    let found = run(py, Length::Long, progress, move |progress| {
        SingularValues::from_gram(
            &gram_of(&mut a, None, false, par, progress).map_err(of_rows)?,
            par,
        )
    })?;
    Ok((from_vec(py, found.values).into_any(), from_matrix(py, found.v.as_ref())?.into_any()))
}

/// Returns Q and R of the Gram matrix, Q in the memory of a new array.
pub fn gram_qr<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    par: Par,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let a = Rows::new("a", a, &[2])?;
    let (m, n) = a.shape();
    let mut q = zeros::<f64>(py, [m, n])?;
    let (mut a, mut out) = (a.view(), q.view_mut());
    let r = run(py, Length::Long, progress, move |progress| {
        let qr =
            GramQr::from_gram(&gram_of(&mut a, None, false, par, progress).map_err(of_rows)?, par)?;
        a.read(0, out.as_mut())?;
        qr.apply(out, par)?;
        Ok(qr.r().clone())
    })?;
    Ok((q.into_any(), from_matrix(py, r.as_ref())?.into_any()))
}

/// Returns the correlation matrix; see `catamaran.corrcoef`.
#[pyfunction]
#[pyo3(signature = (a, threads, progress))]
pub fn corrcoef<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    threads: Threads,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (a, par) = (Rows::new("a", a, &[2])?, par(threads)?);
    let mut a = a.view();
    let found = run(py, Length::Long, progress, move |progress| {
        correlation(&gram_of(&mut a, None, true, par, progress).map_err(of_rows)?)
    })?;
    Ok(from_matrix(py, found.as_ref())?.into_any())
}

/// Returns how far `Q^T Q` is from the identity: in the Frobenius norm, and the largest entry.
#[pyfunction]
#[pyo3(signature = (q, threads, progress))]
pub fn orthogonality<'py>(
    py: Python<'py>,
    q: &Bound<'py, PyAny>,
    threads: Threads,
    progress: Option<Py<PyAny>>,
) -> PyResult<(f64, f64)> {
    let (q, par) = (Rows::new("q", q, &[2])?, par(threads)?);
    let mut q = q.view();
    let found = run(py, Length::Long, progress, move |progress| {
        distance(&gram_of(&mut q, None, false, par, progress)?)
    })?;
    Ok((found.frobenius, found.max))
}
