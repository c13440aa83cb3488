//! What is expected of least squares beside the solution: p values, intervals, covariances.

use faer::Mat;

use super::least_squares::LeastSquares;
use super::predict::{LinearModel, Uncertainty};
use super::spread::{Spread, confidence_factor, deviations};
use super::tails::{f_probability, t_probability};
use crate::base::{Error, Result};
use crate::dense::zeros;

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
