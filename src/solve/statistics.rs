//! What is expected of least squares beside the solution: p values, intervals, covariances.

use faer::Mat;

use super::columns::Columns;
use super::double::DoubleDouble;
use super::least_squares::LeastSquares;
use super::predict::{LinearModel, Uncertainty};
use super::tails::{f_probability, t_probability, t_quantile};
use crate::base::{Error, Result, widest};
use crate::dense::zeros;
use crate::rows::ExtendedGram;

/// A root of the covariance of coefficients: F, for which `F F^T` is that covariance when residuals
/// have variance 1.
#[derive(Debug, Clone)]
pub(crate) struct Spread {
    /// F^T, r x n.
    pub root: Mat<f64>,
    /// The row of F for the intercept, r numbers, less what [`Spread::weight`] adds; none without
    /// intercept.
    pub constant: Vec<f64>,
    /// The mean of each column with an intercept, else zeros.
    pub mean: Vec<f64>,
    /// The sum of the weights with an intercept, else infinity: its inverse is the variance of
    /// the mean of the targets.
    pub weight: f64,
}

impl Spread {
    /// Creates a spread of n columns to be overwritten, with the most rows that a root has.
    #[cfg(feature = "mpi")]
    pub fn blank(n: usize, intercept: bool) -> Result<Self> {
        let constant = vec![0.0; if intercept { n } else { 0 }];
        Ok(Self { root: zeros(n, n)?, constant, mean: vec![0.0; n], weight: f64::INFINITY })
    }

    /// Creates the spread from F, by rows in this order of the columns.
    pub fn new(
        gram: &ExtendedGram,
        order: &[usize],
        rows: &Columns<2>,
        intercept: bool,
    ) -> Result<Self> {
        let n = order.len();
        let mut root = zeros(rows.rows, n)?;
        for (i, &column) in order.iter().enumerate() {
            let row = &rows.col(i, 0)[0][..rows.rows];
            root.col_as_slice_mut(column).copy_from_slice(row);
        }
        if !intercept {
            return Ok(Self {
                root,
                constant: Vec::new(),
                mean: vec![0.0; n],
                weight: f64::INFINITY,
            });
        }
        let mut sum = Columns::<2>::new(rows.rows, 1)?;
        widest(
            #[inline(always)]
            || {
                let mut constant = sum.pairs_mut(0, 0);
                for (i, &column) in order.iter().enumerate() {
                    let [hi, lo] = gram.mean()[column];
                    constant.subtract(rows.pairs(i, 0), DoubleDouble { hi, lo });
                }
                constant.normalize();
            },
        );
        let constant = sum.col(0, 0)[0][..rows.rows].to_vec();
        let mean = gram.mean()[..n].iter().map(|mean| mean[0]).collect();
        Ok(Self { root, constant, mean, weight: gram.weight() })
    }

    /// Returns the standard error of a coefficient when residuals have variance 1.
    pub fn length(&self, column: usize) -> f64 {
        norm(self.root.col_as_slice(column))
    }

    /// Returns the standard error of the intercept when residuals have variance 1.
    pub fn intercept_length(&self) -> f64 {
        norm(&self.constant).hypot(self.weight.sqrt().recip())
    }
}

/// Returns the Euclidean norm of a vector, whose squares may be out of range.
pub(super) fn norm(x: &[f64]) -> f64 {
    let largest = x.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    if largest == 0.0 {
        // Zeros, or NaN.
        return x.iter().sum::<f64>().abs();
    }
    let sum: f64 = x.iter().map(|x| (x / largest) * (x / largest)).sum();
    largest * sum.sqrt()
}

/// Returns the standard deviations of residuals of these norms.
pub(super) fn deviations(norms: &[f64], freedom: u64) -> Vec<f64> {
    let root = (freedom as f64).sqrt();
    let deviation = |norm| if freedom > 0 { norm / root } else { f64::NAN };
    norms.iter().map(|&norm| deviation(norm)).collect()
}

/// Returns the t quantile of confidence intervals.
pub(super) fn confidence_factor(confidence: f64, freedom: u64) -> Result<f64> {
    if confidence > 0.0 && confidence < 1.0 {
        return Ok(t_quantile(1.0 - confidence, freedom as f64));
    }
    let why = format!("must be above 0 and below 1, is {confidence}");
    Err(Error::Argument { what: "confidence", why })
}

impl LeastSquares {
    /// Returns the standard deviation of the residuals of each target: the norm of the residual
    /// over the root of the degrees of freedom; NaN without any.
    ///
    /// ```
    /// use catamaran::faer::mat;
    /// use catamaran::solve::{LeastSquaresOptions, lstsq};
    ///
    /// let (a, b) = (mat![[1.0], [1.0], [1.0]], mat![[1.0], [2.0], [3.0]]);
    /// let found = lstsq(a.as_ref(), b.as_ref(), None, &LeastSquaresOptions::new())?;
    /// assert_eq!(found.residual_deviations(), [1.0]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn residual_deviations(&self) -> Vec<f64> {
        deviations(&self.residual_norms, self.degrees_of_freedom)
    }

    /// Returns R^2 of each target, adjusted for the number of coefficients:
    /// `1 - (1 - R^2) (degrees of freedom + rank) / degrees of freedom`; NaN without degrees of
    /// freedom.
    pub fn adjusted_r_squared(&self) -> Vec<f64> {
        let freedom = self.degrees_of_freedom as f64;
        let factor = (freedom + self.rank as f64) / freedom;
        let adjusted = |r_squared: &f64| match freedom > 0.0 {
            true => 1.0 - (1.0 - r_squared) * factor,
            false => f64::NAN,
        };
        self.r_squared.iter().map(adjusted).collect()
    }

    /// Returns the p value of each of [`LeastSquares::f_statistics`], whose degrees of freedom are
    /// [`LeastSquares::rank`] and [`LeastSquares::degrees_of_freedom`]; NaN for a NaN.
    pub fn f_p_values(&self) -> Vec<f64> {
        let [rank, freedom] = [self.rank as f64, self.degrees_of_freedom as f64];
        self.f_statistics.iter().map(|&f| f_probability(f, rank, freedom)).collect()
    }

    /// Returns the t statistic of each coefficient, n x k: the coefficient over its standard error.
    /// NaN for 0 over 0, and without degrees of freedom.
    ///
    /// # Errors
    /// [`Error::Argument`] of "standard_errors" when they were not requested,
    /// [`Error::OutOfMemory`].
    pub fn t_statistics(&self) -> Result<Mat<f64>> {
        self.spread()?;
        self.of_each(|j, q| self.coefficients[(j, q)] / self.standard_errors[(j, q)])
    }

    /// Returns the p value of each coefficient, n x k: the probability of a t statistic as far from
    /// 0, or farther, were the coefficient 0.
    ///
    /// ```
    /// use catamaran::faer::mat;
    /// use catamaran::solve::{LeastSquaresOptions, lstsq};
    ///
    /// // 2 with standard error 3^(-1/2) and two degrees of freedom: t^2 is 12.
    /// let (a, b) = (mat![[1.0], [1.0], [1.0]], mat![[1.0], [2.0], [3.0]]);
    /// let found = lstsq(a.as_ref(), b.as_ref(), None, &LeastSquaresOptions::new())?;
    /// let right = 1.0 - (12.0_f64 / 14.0).sqrt();
    /// assert!((found.p_values()?[(0, 0)] - right).abs() < 1e-15);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`LeastSquares::t_statistics`].
    pub fn p_values(&self) -> Result<Mat<f64>> {
        let (t, freedom) = (self.t_statistics()?, self.degrees_of_freedom as f64);
        self.of_each(|j, q| t_probability(t[(j, q)], freedom))
    }

    /// Returns the t statistic of each intercept; none without intercept or standard errors.
    pub fn intercept_t_statistics(&self) -> Vec<f64> {
        self.intercepts.iter().zip(&self.intercept_errors).map(|(x, error)| x / error).collect()
    }

    /// Returns the p value of each intercept; none without intercept or standard errors.
    pub fn intercept_p_values(&self) -> Vec<f64> {
        let freedom = self.degrees_of_freedom as f64;
        self.intercept_t_statistics().iter().map(|&t| t_probability(t, freedom)).collect()
    }

    /// Returns the lower and the upper ends of the intervals, both n x k, that contain the
    /// coefficients with this confidence, above 0 and below 1.
    ///
    /// ```
    /// use catamaran::faer::mat;
    /// use catamaran::solve::{LeastSquaresOptions, lstsq};
    ///
    /// let (a, b) = (mat![[1.0], [1.0], [1.0]], mat![[1.0], [2.0], [3.0]]);
    /// let found = lstsq(a.as_ref(), b.as_ref(), None, &LeastSquaresOptions::new())?;
    /// let [lower, upper] = found.confidence_intervals(0.95)?;
    /// assert!((lower[(0, 0)] + 0.484_137_711_750_3).abs() < 1e-12);
    /// assert!((lower[(0, 0)] + upper[(0, 0)] - 4.0).abs() < 1e-14);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] for the confidence; else as [`LeastSquares::t_statistics`].
    pub fn confidence_intervals(&self, confidence: f64) -> Result<[Mat<f64>; 2]> {
        self.spread()?;
        let factor = confidence_factor(confidence, self.degrees_of_freedom)?;
        let end = |sign: f64| {
            self.of_each(|j, q| {
                self.coefficients[(j, q)] + sign * factor * self.standard_errors[(j, q)]
            })
        };
        Ok([end(-1.0)?, end(1.0)?])
    }

    /// Returns the lower and the upper end of the interval that contains each intercept with this
    /// confidence, above 0 and below 1; none without intercept or standard errors.
    ///
    /// # Errors
    /// [`Error::Argument`] for the confidence.
    pub fn intercept_intervals(&self, confidence: f64) -> Result<Vec<[f64; 2]>> {
        let factor = confidence_factor(confidence, self.degrees_of_freedom)?;
        let pairs = self.intercepts.iter().zip(&self.intercept_errors);
        Ok(pairs.map(|(x, error)| [x - factor * error, x + factor * error]).collect())
    }

    /// Returns the covariance of the coefficients of a target: n x n, or n + 1 x n + 1 with the
    /// intercept first. With columns that depend on others, that of the solution of least norm.
    ///
    /// ```
    /// use catamaran::faer::mat;
    /// use catamaran::solve::{LeastSquaresOptions, lstsq};
    ///
    /// let (a, b) = (mat![[0.0], [1.0], [2.0]], mat![[0.0], [3.0], [0.0]]);
    /// let options = LeastSquaresOptions::new().intercept(true);
    /// let covariance = lstsq(a.as_ref(), b.as_ref(), None, &options)?.covariance(0)?;
    /// // The square of the residual is 6, with one degree of freedom.
    /// let difference = covariance - mat![[5.0, -3.0], [-3.0, 3.0]];
    /// assert!(difference.norm_max() < 1e-14);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] of "target" when there is no such target; else as
    /// [`LeastSquares::t_statistics`].
    pub fn covariance(&self, target: usize) -> Result<Mat<f64>> {
        let (n, targets) = self.coefficients.shape();
        let spread = self.spread()?;
        if target >= targets {
            let why = format!("must be below {targets} (targets), is {target}");
            return Err(Error::Argument { what: "target", why });
        }
        let first = usize::from(!self.intercept_errors.is_empty());
        let deviation = self.residual_deviations()[target];
        let mut root = zeros(spread.root.nrows(), first + n)?;
        if first > 0 {
            root.col_as_slice_mut(0).copy_from_slice(&spread.constant);
        }
        root.as_mut().subcols_mut(first, n).copy_from(&spread.root);
        for j in 0..first + n {
            root.col_as_slice_mut(j).iter_mut().for_each(|x| *x *= deviation);
        }
        let mut covariance = zeros(first + n, first + n)?;
        faer::linalg::matmul::matmul(
            covariance.as_mut(),
            faer::Accum::Replace,
            root.transpose(),
            root.as_ref(),
            1.0,
            faer::Par::Seq,
        );
        if first > 0 {
            covariance[(0, 0)] += deviation / spread.weight * deviation;
        }
        Ok(covariance)
    }

    /// Returns the fitted model, whose predictions have standard errors and intervals when standard
    /// errors were requested.
    ///
    /// ```
    /// use catamaran::faer::mat;
    /// use catamaran::solve::{LeastSquaresOptions, lstsq};
    ///
    /// let (a, b) = (mat![[0.0], [1.0], [2.0]], mat![[1.0], [3.0], [5.0]]);
    /// let options = LeastSquaresOptions::new().intercept(true);
    /// let found = lstsq(a.as_ref(), b.as_ref(), None, &options)?;
    /// assert_eq!(found.model().predict(mat![[10.0]].as_ref())?, mat![[21.0]]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn model(&self) -> LinearModel<'_> {
        let uncertainty = |spread| {
            let Spread { root, mean, weight, .. }: &Spread = spread;
            Uncertainty {
                root: root.as_ref(),
                mean,
                weight: *weight,
                residual_norms: &self.residual_norms,
                degrees_of_freedom: self.degrees_of_freedom,
            }
        };
        LinearModel {
            coefficients: self.coefficients.as_ref(),
            coefficients_low: self.coefficients_low.as_ref(),
            intercepts: &self.intercepts,
            uncertainty: self.spread.as_ref().map(uncertainty),
        }
    }

    /// Returns a matrix of a number for each coefficient.
    fn of_each(&self, number: impl Fn(usize, usize) -> f64) -> Result<Mat<f64>> {
        let (n, targets) = self.coefficients.shape();
        let mut matrix = zeros(n, targets)?;
        for q in 0..targets {
            (0..n).for_each(|j| matrix[(j, q)] = number(j, q));
        }
        Ok(matrix)
    }

    fn spread(&self) -> Result<&Spread> {
        self.spread.as_ref().ok_or_else(|| Error::Argument {
            what: "standard_errors",
            why: "were not requested".into(),
        })
    }
}
