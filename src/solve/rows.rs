//! Functions from rows to results, in one call each.

use faer::prelude::ReborrowMut;
use faer::{MatMut, MatRef};

use super::{
    LeastSquares, LeastSquaresOptions, PrincipalComponents, PrincipalComponentsOptions,
    SingularValues,
};
use crate::base::{Error, Par, Result};
use crate::product::AtaOptions;
use crate::rows::{Center, DenseRows, RowBlocks, RowOptions, ata_extended};

/// The rows of `[A B]` for the rows of A (m x n) and of B (m x k).
///
/// ```
/// use catamaran::rows::{DenseRows, RowBlocks};
/// use catamaran::faer::{Mat, mat};
/// use catamaran::solve::JoinedRows;
///
/// let (a, b) = (mat![[1.0, 2.0], [3.0, 4.0]], mat![[5.0], [6.0]]);
/// let (mut a, mut b) = (DenseRows(a.as_ref()), DenseRows(b.as_ref()));
/// let mut rows: JoinedRows<'_, f64> = JoinedRows::new(&mut a, &mut b)?;
/// let mut all = Mat::zeros(2, 3);
/// rows.read(0, all.as_mut())?;
/// assert_eq!(all, mat![[1.0, 2.0, 5.0], [3.0, 4.0, 6.0]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
pub struct JoinedRows<'r, T> {
    a: &'r mut (dyn RowBlocks<T> + Send),
    b: &'r mut (dyn RowBlocks<T> + Send),
}

impl<'r, T> JoinedRows<'r, T> {
    /// Joins two sources.
    ///
    /// # Errors
    /// [`Error::Shape`] of "B" when it has another number of rows.
    pub fn new(
        a: &'r mut (dyn RowBlocks<T> + Send),
        b: &'r mut (dyn RowBlocks<T> + Send),
    ) -> Result<Self> {
        Error::check_shape("B", (a.nrows(), b.ncols()), (b.nrows(), b.ncols()))?;
        Ok(Self { a, b })
    }
}

impl<T> RowBlocks<T> for JoinedRows<'_, T> {
    fn nrows(&self) -> usize {
        self.a.nrows()
    }

    fn ncols(&self) -> usize {
        self.a.ncols() + self.b.ncols()
    }

    fn read(&mut self, first: usize, mut out: MatMut<'_, T>) -> Result<()> {
        let (a, b) = out.rb_mut().split_at_col_mut(self.a.ncols());
        self.a.read(first, a)?;
        self.b.read(first, b)
    }
}

/// Solves `min |W^(1/2) (A X - B)|^2 + ridge |X|^2` for A (m x n), B (m x k) and W a diagonal of m
/// weights, none of them negative; without weights all are 1. [`lstsq_rows`] takes rows in files or
/// in blocks.
///
/// ```
/// use catamaran::faer::mat;
/// use catamaran::solve::{LeastSquaresOptions, lstsq};
///
/// let (a, b) = (mat![[0.0], [1.0], [2.0]], mat![[1.0], [3.0], [5.0]]);
/// let options = LeastSquaresOptions::new().intercept(true);
/// let found = lstsq(a.as_ref(), b.as_ref(), None, &options)?;
/// assert_eq!((found.coefficients[(0, 0)], found.intercepts[0]), (2.0, 1.0));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] for B and the weights; [`Error::Argument`] for a negative weight;
/// [`Error::NonFinite`] for "A" or "B"; else as [`ata_extended`] and [`LeastSquares::from_gram`].
pub fn lstsq(
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    weights: Option<&[f64]>,
    options: &LeastSquaresOptions,
) -> Result<LeastSquares> {
    lstsq_rows(&mut DenseRows(a), &mut DenseRows(b), weights, options)
}

/// Solves as [`lstsq`] does, for the rows of A and of B from any source. They are read twice, block
/// by block.
///
/// ```
/// use catamaran::rows::DenseRows;
/// use catamaran::faer::mat;
/// use catamaran::solve::{LeastSquaresOptions, lstsq_rows};
///
/// // Rows in single precision, converted block by block.
/// let (a, b) = (mat![[1.0_f32], [2.0]], mat![[2.0_f32], [4.0]]);
/// let (mut a, mut b) = (DenseRows(a.as_ref()), DenseRows(b.as_ref()));
/// let found = lstsq_rows(&mut a, &mut b, None, &LeastSquaresOptions::new())?;
/// assert_eq!(found.coefficients, mat![[2.0]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`lstsq`], and those of the sources.
pub fn lstsq_rows(
    a: &mut (dyn RowBlocks<f64> + Send),
    b: &mut (dyn RowBlocks<f64> + Send),
    weights: Option<&[f64]>,
    options: &LeastSquaresOptions,
) -> Result<LeastSquares> {
    check_weights(weights)?;
    let center = if options.intercept { Center::Mean } else { Center::No };
    let (n, targets) = (a.ncols(), b.ncols());
    let mut rows = JoinedRows::new(a, b)?;
    let row_options = RowOptions::new().weights(weights).center(center);
    let gram = ata_extended(&mut rows, &row_options, &AtaOptions::new().par(options.par))
        .map_err(|error| named_by_matrix(error, n))?;
    LeastSquares::from_gram(&gram, targets, options)
}

/// Replaces "rows" in an error by "A" or "B", the matrix of the column; A has `n` columns.
pub(crate) fn named_by_matrix(error: Error, n: usize) -> Error {
    match error {
        Error::NonFinite { what: "rows", index: (i, j) } => {
            let (what, j) = if j < n { ("A", j) } else { ("B", j - n) };
            Error::NonFinite { what, index: (i, j) }
        }
        other => other,
    }
}

/// Checks that no weight of a least-squares problem is negative.
///
/// ```
/// use catamaran::solve::check_weights;
///
/// assert!(check_weights(Some(&[1.0, 0.0])).is_ok());
/// let refused = check_weights(Some(&[1.0, -2.0])).unwrap_err();
/// assert_eq!(refused.to_string(), "weights: weight 1 (counted from 0) is negative: -2");
/// ```
///
/// # Errors
/// [`Error::Argument`] that names the first negative weight.
pub fn check_weights(weights: Option<&[f64]>) -> Result<()> {
    match weights.unwrap_or_default().iter().position(|&w| w < 0.0) {
        Some(i) => {
            let w = weights.unwrap_or_default()[i];
            let why = format!("weight {i} (counted from 0) is negative: {w}");
            Err(Error::Argument { what: "weights", why })
        }
        None => Ok(()),
    }
}

/// Computes the principal components of the rows of A (m x n). [`pca_rows`] takes rows in files or
/// in blocks.
///
/// ```
/// use catamaran::faer::mat;
/// use catamaran::solve::{PrincipalComponentsOptions, pca};
///
/// let a = mat![[1.0, 2.0], [2.0, 4.0], [3.0, 6.0]];
/// let found = pca(a.as_ref(), &PrincipalComponentsOptions::new())?;
/// assert!((found.explained_variance_ratio[0] - 1.0).abs() < 1e-15);
/// assert_eq!(found.mean, [2.0, 4.0]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`ata_extended`] and [`PrincipalComponents::from_gram`].
pub fn pca(
    a: MatRef<'_, f64>,
    options: &PrincipalComponentsOptions,
) -> Result<PrincipalComponents> {
    pca_rows(&mut DenseRows(a), options)
}

/// Computes the principal components of rows from any source, which are read twice, block by block.
///
/// ```
/// use catamaran::rows::DenseRows;
/// use catamaran::faer::mat;
/// use catamaran::solve::{PrincipalComponentsOptions, pca_rows};
///
/// let a = mat![[1.0, 2.0], [2.0, 4.0], [3.0, 6.0]];
/// let found = pca_rows(&mut DenseRows(a.as_ref()), &PrincipalComponentsOptions::new())?;
/// assert_eq!(found.mean, [2.0, 4.0]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`pca`], and those of the source.
pub fn pca_rows(
    rows: &mut (dyn RowBlocks<f64> + Send),
    options: &PrincipalComponentsOptions,
) -> Result<PrincipalComponents> {
    let row_options = RowOptions::<f64>::new().center(Center::Mean);
    let gram = ata_extended(rows, &row_options, &AtaOptions::new().par(options.par))?;
    PrincipalComponents::from_gram(&gram, options)
}

/// Computes the singular values and right singular vectors of A (m x n);
/// [`SingularValues::left`] returns the left ones. [`singular_values_rows`] takes rows in files or
/// in blocks.
///
/// ```
/// use catamaran::{Par, faer::mat, solve::singular_values};
///
/// let found = singular_values(mat![[3.0, 0.0], [0.0, 1e-9], [0.0, 0.0]].as_ref(), Par::Seq)?;
/// assert_eq!(found.values, [3.0, 1e-9]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`ata_extended`] and [`SingularValues::from_gram`].
pub fn singular_values(a: MatRef<'_, f64>, par: Par) -> Result<SingularValues> {
    singular_values_rows(&mut DenseRows(a), par)
}

/// Computes the singular values and right singular vectors of the matrix of rows from any source,
/// which are read twice, block by block.
///
/// ```
/// use catamaran::{Par, faer::mat, rows::DenseRows, solve::singular_values_rows};
///
/// let a = mat![[3.0, 0.0], [0.0, 1e-9], [0.0, 0.0]];
/// let found = singular_values_rows(&mut DenseRows(a.as_ref()), Par::Seq)?;
/// assert_eq!(found.values, [3.0, 1e-9]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`singular_values`], and those of the source.
pub fn singular_values_rows(
    rows: &mut (dyn RowBlocks<f64> + Send),
    par: Par,
) -> Result<SingularValues> {
    let gram = ata_extended(rows, &RowOptions::<f64>::new(), &AtaOptions::new().par(par))?;
    SingularValues::from_gram(&gram, par)
}
