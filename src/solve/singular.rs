use faer::{Mat, MatRef};

use super::cholesky::{PivotedCholesky, Pivoting};
use super::jacobi::jacobi;
use crate::base::{Error, Par, Result};
use crate::dense::zeros;
use crate::product::{AtaOptions, atb_into};
use crate::rows::ExtendedGram;

/// Singular values and right singular vectors of A (m x n), from its Gram matrix.
///
/// They are those of the pivoted Cholesky factor of A in double-double, by one-sided Jacobi
/// rotations in f64. With K the condition number of A with columns of norm 1, the relative error
/// of every value, the smallest included, is a few n 2^-53 plus K^2 2^-106 (K^2 2^-80 where the
/// entries of A were rounded). Nothing is lost with columns of norms from 2^-450 to 2^500 in one
/// matrix; shorter ones are refused.
///
/// ```
/// use catamaran::rows::ExtendedGram;
/// use catamaran::solve::SingularValues;
/// use catamaran::{Par, faer::mat};
///
/// // Of A = [[3, 0], [4, 5]]: 45 and 5 are the eigenvalues of A^T A.
/// let gram = ExtendedGram::from_f64(mat![[25.0, 0.0], [20.0, 25.0]].as_ref(), 2, &[])?;
/// let found = SingularValues::from_gram(&gram, Par::Seq)?;
/// assert!((found.values[0] - 45_f64.sqrt()).abs() < 1e-14);
/// assert!((found.v[(0, 1)].abs() - 0.5_f64.sqrt()).abs() < 1e-14);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct SingularValues {
    /// n values, descending; zeros where columns depend on others as far as the precision can tell.
    pub values: Vec<f64>,
    /// n x rank: one orthonormal column for each value that is not zero.
    pub v: Mat<f64>,
}

impl SingularValues {
    /// Computes the singular values and vectors. The result is the same, bit for bit, for every
    /// `par`.
    ///
    /// # Errors
    /// As [`PivotedCholesky::from_gram`]; [`Error::NotConverged`].
    pub fn from_gram(gram: &ExtendedGram, par: Par) -> Result<Self> {
        let factor = PivotedCholesky::from_gram(gram, Pivoting::Largest, par)?;
        let (columns, exponents) = factor.transposed(|c| (1.0, factor.exponents[c]))?;
        let mut found = jacobi(&columns, &exponents, par)?;
        found.values.resize(gram.n(), 0.0);
        Ok(Self { values: found.values, v: found.vectors })
    }

    /// Returns the left singular vectors, m x rank, of the matrix A (m x n) that the values are of:
    /// `U = A V S^-1`, so that `A = U S V^T`. The result is the same, bit for bit, for every `par`.
    ///
    /// Column k is wrong by about `2^-53 values[0] / values[k]`: columns of small values are less
    /// orthogonal to the others than those of V. Where that matters, use [`GramQr`](super::GramQr).
    ///
    /// ```
    /// use catamaran::{Par, faer::mat, solve::singular_values};
    ///
    /// let a = mat![[0.0, 4.0], [3.0, 0.0], [0.0, 0.0]];
    /// let found = singular_values(a.as_ref(), Par::Seq)?;
    /// let u = found.left(a.as_ref(), Par::Seq)?;
    /// assert_eq!(found.values, [4.0, 3.0]);
    /// assert_eq!((u[(0, 0)].abs(), u[(1, 1)].abs(), u[(2, 0)]), (1.0, 1.0, 0.0));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] when A has not n columns, [`Error::OutOfMemory`].
    pub fn left(&self, a: MatRef<'_, f64>, par: Par) -> Result<Mat<f64>> {
        Error::check_shape("A", (a.nrows(), self.v.nrows()), a.shape())?;
        let mut u = zeros(a.nrows(), self.rank())?;
        let options = AtaOptions::new().par(par);
        atb_into(1.0, a.transpose(), self.v.as_ref(), 0.0, u.as_mut(), &options)?;
        for (k, value) in self.values[..self.rank()].iter().enumerate() {
            u.col_mut(k).iter_mut().for_each(|entry| *entry /= value);
        }
        Ok(u)
    }

    /// Returns the number of values that are not zero.
    pub fn rank(&self) -> usize {
        self.v.ncols()
    }
}
