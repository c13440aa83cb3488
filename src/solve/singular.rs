use faer::Mat;

use super::cholesky::{PivotedCholesky, Pivoting};
use super::jacobi::jacobi;
use crate::base::{Par, Result};
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
    /// As [`PivotedCholesky::from_gram`]; [`Error::NotConverged`](crate::Error::NotConverged).
    pub fn from_gram(gram: &ExtendedGram, par: Par) -> Result<Self> {
        let factor = PivotedCholesky::from_gram(gram, Pivoting::Largest, par)?;
        let (columns, exponents) = factor.transposed(|c| (1.0, factor.exponents[c]))?;
        let mut found = jacobi(&columns, &exponents, par)?;
        found.values.resize(gram.n(), 0.0);
        Ok(Self { values: found.values, v: found.vectors })
    }

    /// Returns the number of values that are not zero.
    pub fn rank(&self) -> usize {
        self.v.ncols()
    }
}
