use faer::{Mat, MatRef};

use super::cholesky::{PivotedCholesky, Pivoting, check_centered};
use super::double::{DoubleDouble, scaled};
use super::jacobi::jacobi;
use crate::base::{Error, Par, Result, options};
use crate::rows::ExtendedGram;

/// How many principal components are kept; never more than the rank of the centred columns.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Components {
    /// All of them.
    All,
    /// This many.
    Count(usize),
    /// As few as explain this share of the variance, above 0 and at most 1.
    Share(f64),
}

impl Components {
    /// Checks that there are no more components than columns, and that a share is in range.
    fn check(self, columns: usize) -> Result<()> {
        let why = match self {
            Self::Count(count) if count > columns => {
                format!("must be at most {columns} (columns), but is {count}")
            }
            Self::Share(share) if !(share > 0.0 && share <= 1.0) => {
                format!("a share must be in (0, 1], but is {share}")
            }
            _ => return Ok(()),
        };
        Err(Error::Argument { what: "components", why })
    }

    /// Returns how many components are kept, given their shares of the variance in order.
    fn count(self, shares: &[f64]) -> usize {
        match self {
            Self::All => shares.len(),
            Self::Count(count) => count.min(shares.len()),
            Self::Share(share) => {
                let mut sum = 0.0;
                let reached = shares.iter().position(|part| {
                    sum += part;
                    sum >= share
                });
                reached.map_or(shares.len(), |last| last + 1)
            }
        }
    }
}

/// Returns the columns as rows, each with the sign that makes its entry of largest magnitude
/// positive.
fn oriented(columns: MatRef<'_, f64>) -> Result<Mat<f64>> {
    let (n, count) = columns.shape();
    let mut rows = crate::dense::zeros(count, n)?;
    for k in 0..count {
        let column = columns.col(k);
        let first = column.iter().fold(0.0_f64, |a, &b| if b.abs() > a.abs() { b } else { a });
        let sign = if first < 0.0 { -1.0 } else { 1.0 };
        (0..n).for_each(|c| rows[(k, c)] = sign * column[c]);
    }
    Ok(rows)
}

options! {
    /// How [`PrincipalComponents`] are computed.
    ///
    /// ```
    /// use catamaran::solve::{Components, PrincipalComponentsOptions};
    ///
    /// let options = PrincipalComponentsOptions::new()
    ///     .components(Components::Share(0.99))
    ///     .standardize(true);
    /// assert!(!options.whiten);
    /// ```
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct PrincipalComponentsOptions {
        /// How many are kept.
        components: Components = Components::All;
        /// Whether columns are divided by their standard deviations; those without variance are
        /// not.
        standardize: bool = false;
        /// Whether scores are divided by the root of the variance that they explain.
        whiten: bool = false;
        /// Threads. Their number does not change the result.
        par: Par = Par::all();
    }
}

/// The principal components of rows of n columns, from their Gram matrix about the mean.
///
/// Variances have the divisor `weight - 1`, as if weights counted repetitions of rows.
///
/// ```
/// use catamaran::rows::ExtendedGram;
/// use catamaran::solve::{PrincipalComponents, PrincipalComponentsOptions};
/// use catamaran::faer::{Mat, mat};
///
/// // Rows (1, 1), (3, 3) and (5, 5).
/// let c = mat![[8.0, 0.0], [8.0, 8.0]];
/// let gram = ExtendedGram::from_f64(c.as_ref(), 3, &[3.0, 3.0])?;
/// let found = PrincipalComponents::from_gram(&gram, &PrincipalComponentsOptions::new())?;
/// assert_eq!(found.components.nrows(), 1);
/// assert!((found.explained_variance[0] - 8.0).abs() < 1e-14);
/// let scores = found.scores(mat![[5.0, 5.0]].as_ref())?;
/// assert!((scores[(0, 0)] - 8_f64.sqrt()).abs() < 1e-14);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct PrincipalComponents {
    /// count x n: one orthonormal row for each component, the most variance first; the first of
    /// the largest entries of a row is positive.
    pub components: Mat<f64>,
    /// The variance along each component.
    pub explained_variance: Vec<f64>,
    /// The variance along each component, divided by the variance of all columns.
    pub explained_variance_ratio: Vec<f64>,
    /// The singular values of the centred (and standardized) rows.
    pub singular_values: Vec<f64>,
    /// The mean of each column.
    pub mean: Vec<f64>,
    /// The divisor of each column: its standard deviation, or 1.
    pub scale: Vec<f64>,
    /// Whether scores are divided by the root of the variance that they explain.
    pub whiten: bool,
}

impl PrincipalComponents {
    /// Computes the principal components. The result is the same, bit for bit, for every
    /// `options.par`.
    ///
    /// # Errors
    /// [`Error::Argument`] when the matrix is not about the mean, has a weight of 1 or less, or for
    /// options out of range; else as
    /// [`SingularValues::from_gram`](super::SingularValues::from_gram).
    pub fn from_gram(gram: &ExtendedGram, options: &PrincipalComponentsOptions) -> Result<Self> {
        let n = gram.n();
        check_centered(gram)?;
        let divisor = gram.weight() - 1.0;
        if divisor.is_nan() || divisor <= 0.0 {
            let why = format!("its weight is {}, but a variance needs more than 1", gram.weight());
            return Err(Error::Argument { what: "gram", why });
        }
        options.components.check(n)?;
        let pivoting = if options.standardize { Pivoting::Scaled } else { Pivoting::Largest };
        let factor = PivotedCholesky::from_gram(gram, pivoting, options.par)?;
        let deviation = |c: usize| {
            let [hi, mid, _] = gram.entry(c, c);
            (DoubleDouble::new(hi, mid) / DoubleDouble::from(divisor)).sqrt().hi
        };
        let mut scale = vec![1.0; n];
        if options.standardize {
            let deviations = (0..n).map(deviation).map(|s| if s > 0.0 { s } else { 1.0 });
            scale = deviations.collect();
        }
        let (columns, exponents) = factor.transposed(|c| {
            let exponent = factor.exponents[c];
            if !options.standardize {
                return (1.0, exponent);
            }
            // Neither factor is out of range by itself.
            let half = scaled(1.0, exponent / 2) / scale[c];
            (half * scaled(1.0, exponent - exponent / 2), 0)
        })?;
        let found = jacobi(&columns, &exponents, options.par)?;
        let singular_values = found.values;
        let variance: Vec<_> = singular_values.iter().map(|s| s * s / divisor).collect();
        let total: f64 = (0..n).map(|c| (deviation(c) / scale[c]).powi(2)).sum();
        let ratio: Vec<_> = variance.iter().map(|v| v / total).collect();
        let count = options.components.count(&ratio);
        let components = oriented(found.vectors.as_ref().subcols(0, count))?;
        let first = |mut values: Vec<f64>| {
            values.truncate(count);
            values
        };
        Ok(Self {
            components,
            explained_variance: first(variance),
            explained_variance_ratio: first(ratio),
            singular_values: first(singular_values),
            mean: gram.mean().iter().map(|mean| mean[0]).collect(),
            scale,
            whiten: options.whiten,
        })
    }

    /// Returns components that were computed before: count x n `components`, count numbers in each
    /// of `spectrum` (variances, their shares of all variance, singular values), and n in `mean`
    /// and `scale`.
    ///
    /// ```
    /// use catamaran::{faer::mat, solve::PrincipalComponents};
    ///
    /// let spectrum = [vec![4.0], vec![1.0], vec![2.0]];
    /// let (mean, scale) = (vec![3.0, 3.0], vec![1.0, 1.0]);
    /// let found =
    ///     PrincipalComponents::from_parts(mat![[0.6, 0.8]], spectrum, mean, scale, false)?;
    /// assert_eq!(found.scores(mat![[3.0, 4.0]].as_ref())?[(0, 0)], 0.8);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] names the part that does not have as many numbers as the components need.
    pub fn from_parts(
        components: Mat<f64>,
        spectrum: [Vec<f64>; 3],
        mean: Vec<f64>,
        scale: Vec<f64>,
        whiten: bool,
    ) -> Result<Self> {
        let (count, n) = components.shape();
        for part in &spectrum {
            Error::check_shape("spectrum", (count, 1), (part.len(), 1))?;
        }
        Error::check_shape("mean", (n, 1), (mean.len(), 1))?;
        Error::check_shape("scale", (n, 1), (scale.len(), 1))?;
        let [explained_variance, explained_variance_ratio, singular_values] = spectrum;
        Ok(Self {
            components,
            explained_variance,
            explained_variance_ratio,
            singular_values,
            mean,
            scale,
            whiten,
        })
    }

    /// Returns the scores (m x count) of rows (m x n): their coordinates along the components, of
    /// variance 1 with `whiten`.
    ///
    /// ```
    /// use catamaran::rows::ExtendedGram;
    /// use catamaran::faer::mat;
    /// use catamaran::solve::{PrincipalComponents, PrincipalComponentsOptions};
    ///
    /// // Rows (1, 1), (3, 3) and (5, 5): scores -1, 0 and 1 have variance 1.
    /// let gram = ExtendedGram::from_f64(mat![[8.0, 0.0], [8.0, 8.0]].as_ref(), 3, &[3.0, 3.0])?;
    /// let options = PrincipalComponentsOptions::new().whiten(true);
    /// let scores = PrincipalComponents::from_gram(&gram, &options)?
    ///     .scores(mat![[1.0, 1.0], [3.0, 3.0], [5.0, 5.0]].as_ref())?;
    /// assert!(scores[(1, 0)].abs() < 1e-14 && (scores[(2, 0)] - 1.0).abs() < 1e-14);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] when the rows do not have n columns, [`Error::OutOfMemory`].
    pub fn scores(&self, rows: MatRef<'_, f64>) -> Result<Mat<f64>> {
        let (m, n) = (rows.nrows(), self.mean.len());
        Error::check_shape("rows", (m, n), rows.shape())?;
        let mut centered = crate::dense::zeros(m, n)?;
        for j in 0..n {
            for i in 0..m {
                centered[(i, j)] = (rows[(i, j)] - self.mean[j]) / self.scale[j];
            }
        }
        let mut scores = crate::dense::zeros(m, self.components.nrows())?;
        faer::linalg::matmul::matmul(
            scores.as_mut(),
            faer::Accum::Replace,
            centered.as_ref(),
            self.components.transpose(),
            1.0,
            faer::Par::Seq,
        );
        if self.whiten {
            for (k, variance) in self.explained_variance.iter().enumerate() {
                scores.col_mut(k).iter_mut().for_each(|score| *score /= variance.sqrt());
            }
        }
        Ok(scores)
    }
}
