use faer::{Mat, MatRef};

use super::double::TripleSum;
use super::spread::{confidence_factor, deviations, norm};
use crate::base::{Error, Result};
use crate::dense::zeros;

/// What an interval of a prediction contains.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Interval {
    /// The mean of all observations with the values of the row.
    Confidence,
    /// One new observation, of weight 1, with the values of the row.
    Prediction,
}

/// A linear model of n columns and k targets, fitted now or read from a file.
///
/// ```
/// use catamaran::faer::mat;
/// use catamaran::solve::LinearModel;
///
/// let (x, low) = (mat![[2.0], [0.5]], mat![[0.0], [0.0]]);
/// let model = LinearModel {
///     coefficients: x.as_ref(),
///     coefficients_low: low.as_ref(),
///     intercepts: &[1.0],
///     uncertainty: None,
/// };
/// assert_eq!(model.predict(mat![[1.0, 4.0]].as_ref())?, mat![[5.0]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct LinearModel<'a> {
    /// n x k.
    pub coefficients: MatRef<'a, f64>,
    /// What rounding to f64 removed from the coefficients, n x k.
    pub coefficients_low: MatRef<'a, f64>,
    /// The constants of the k targets.
    pub intercepts: &'a [f64],
    /// What standard errors of predictions take.
    pub uncertainty: Option<Uncertainty<'a>>,
}

/// How far predictions of a [`LinearModel`] may be from the truth.
#[derive(Debug, Clone, Copy)]
pub struct Uncertainty<'a> {
    /// F^T (r x n, for any r), where `F F^T` is the covariance of the coefficients when residuals
    /// have variance 1.
    pub root: MatRef<'a, f64>,
    /// The (weighted) mean of each of the n columns where a constant was fitted, else zeros.
    pub mean: &'a [f64],
    /// The sum of the weights where a constant was fitted, else infinity.
    pub weight: f64,
    /// The norm of the residual of each target.
    pub residual_norms: &'a [f64],
    /// Degrees of freedom of the residuals.
    pub degrees_of_freedom: u64,
}

impl LinearModel<'_> {
    /// Returns the predicted targets (m x k) of rows (m x n), correctly rounded but for
    /// intercepts, which are rounded; NaN for a row with a NaN or an infinity.
    ///
    /// # Errors
    /// [`Error::Shape`] when the parts of the model, or the rows, do not fit;
    /// [`Error::OutOfMemory`].
    pub fn predict(&self, rows: MatRef<'_, f64>) -> Result<Mat<f64>> {
        self.check(rows)?;
        let (n, targets) = self.coefficients.shape();
        let mut found = zeros(rows.nrows(), targets)?;
        for q in 0..targets {
            for i in 0..rows.nrows() {
                let mut sum = TripleSum::default();
                sum.add(self.intercepts[q]);
                for j in 0..n {
                    sum.add_product(rows[(i, j)], self.coefficients[(j, q)]);
                    sum.add_product(rows[(i, j)], self.coefficients_low[(j, q)]);
                }
                found[(i, q)] = sum.rounded();
            }
        }
        Ok(found)
    }

    /// Returns the standard errors (m x k) of what [`LinearModel::predict`] returns: those of the
    /// mean, without the deviation of one observation from it.
    ///
    /// ```
    /// use catamaran::faer::mat;
    /// use catamaran::solve::{LeastSquaresOptions, lstsq};
    ///
    /// let (a, b) = (mat![[0.0], [1.0], [2.0]], mat![[0.0], [3.0], [0.0]]);
    /// let options = LeastSquaresOptions::new().intercept(true);
    /// let found = lstsq(a.as_ref(), b.as_ref(), None, &options)?;
    /// let errors = found.model().standard_errors(mat![[0.0], [1.0]].as_ref())?;
    /// assert!((errors[(0, 0)].powi(2) - 5.0).abs() < 1e-14);
    /// assert!((errors[(1, 0)].powi(2) - 2.0).abs() < 1e-14);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] when the model has no uncertainty; else as [`LinearModel::predict`].
    pub fn standard_errors(&self, rows: MatRef<'_, f64>) -> Result<Mat<f64>> {
        self.errors(rows, Interval::Confidence)
    }

    /// Returns the lower and the upper ends (both m x k) of the intervals that contain the targets
    /// with this confidence, above 0 and below 1.
    ///
    /// # Errors
    /// [`Error::Argument`] for the confidence; else as [`LinearModel::standard_errors`].
    pub fn intervals(
        &self,
        rows: MatRef<'_, f64>,
        interval: Interval,
        confidence: f64,
    ) -> Result<[Mat<f64>; 2]> {
        let uncertainty = self.uncertainty()?;
        let factor = confidence_factor(confidence, uncertainty.degrees_of_freedom)?;
        let (found, errors) = (self.predict(rows)?, self.errors(rows, interval)?);
        let end = |sign: f64| {
            let mut ends = zeros(rows.nrows(), found.ncols())?;
            for q in 0..found.ncols() {
                for i in 0..rows.nrows() {
                    ends[(i, q)] = found[(i, q)] + sign * factor * errors[(i, q)];
                }
            }
            Ok(ends)
        };
        Ok([end(-1.0)?, end(1.0)?])
    }

    /// Returns the standard deviations of what an interval contains.
    fn errors(&self, rows: MatRef<'_, f64>, interval: Interval) -> Result<Mat<f64>> {
        self.check(rows)?;
        let uncertainty = self.uncertainty()?;
        let (m, n) = rows.shape();
        let mut centered = zeros(n, m)?;
        for i in 0..m {
            for j in 0..n {
                centered[(j, i)] = rows[(i, j)] - uncertainty.mean[j];
            }
        }
        let mut spread = zeros(uncertainty.root.nrows(), m)?;
        faer::linalg::matmul::matmul(
            spread.as_mut(),
            faer::Accum::Replace,
            uncertainty.root,
            centered.as_ref(),
            1.0,
            faer::Par::Seq,
        );
        let own = match interval {
            Interval::Confidence => 0.0,
            Interval::Prediction => 1.0,
        };
        let deviations = deviations(uncertainty.residual_norms, uncertainty.degrees_of_freedom);
        let of_mean = uncertainty.weight.sqrt().recip();
        let mut errors = zeros(m, deviations.len())?;
        for i in 0..m {
            let length = norm(spread.col_as_slice(i)).hypot(of_mean).hypot(own);
            for (q, deviation) in deviations.iter().enumerate() {
                errors[(i, q)] = deviation * length;
            }
        }
        Ok(errors)
    }

    /// Checks that the parts of the model, and the rows, fit.
    fn check(&self, rows: MatRef<'_, f64>) -> Result<()> {
        let (n, targets) = self.coefficients.shape();
        Error::check_shape("coefficients_low", (n, targets), self.coefficients_low.shape())?;
        Error::check_shape("intercepts", (targets, 1), (self.intercepts.len(), 1))?;
        if let Some(uncertainty) = self.uncertainty {
            let root = uncertainty.root.shape();
            Error::check_shape("root", (root.0, n), root)?;
            Error::check_shape("mean", (n, 1), (uncertainty.mean.len(), 1))?;
            let norms = uncertainty.residual_norms.len();
            Error::check_shape("residual_norms", (targets, 1), (norms, 1))?;
        }
        Error::check_shape("rows", (rows.nrows(), n), rows.shape())
    }

    fn uncertainty(&self) -> Result<Uncertainty<'_>> {
        self.uncertainty.ok_or_else(|| Error::Argument {
            what: "uncertainty",
            why: "the model has none: standard errors were not requested".into(),
        })
    }
}
