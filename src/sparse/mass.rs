use faer::prelude::ReborrowMut;
use faer::{ColRef, MatMut, MatRef, unzip, zip};
use sprs::CsMat;

use super::check::check_symmetric;
use super::product::multiply_symmetric_or_rows;
use crate::base::{Error, Par, Result};
use crate::dense::{ROW_BLOCK, for_row_blocks};

/// The matrix M of an inner product `<u, v> = u^T M v`: symmetric, positive definite.
///
/// ```
/// use catamaran::{Par, faer::{Mat, mat}, sparse::Mass};
///
/// let mass = Mass::Lumped(vec![2.0, 3.0]);
/// let (x, mut y) = (mat![[1.0], [1.0]], Mat::zeros(2, 1));
/// mass.multiply(x.as_ref(), y.as_mut(), Par::Seq)?;
/// assert_eq!(y, mat![[2.0], [3.0]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Mass {
    /// A diagonal: lumped masses, one for each row, all positive.
    Lumped(Vec<f64>),
    /// A full (consistent) matrix, both triangles stored.
    Full(CsMat<f64>),
}

impl Mass {
    /// Creates the identity of n rows: the Euclidean inner product.
    pub fn identity(n: usize) -> Self {
        Self::Lumped(vec![1.0; n])
    }

    /// Returns the number of rows.
    pub fn len(&self) -> usize {
        match self {
            Self::Lumped(diagonal) => diagonal.len(),
            Self::Full(matrix) => matrix.rows(),
        }
    }

    /// Returns whether the matrix has no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Checks that the matrix is an inner product for vectors of n entries, as far as possible
    /// without a factorization: n rows, finite, symmetric, the diagonal positive.
    ///
    /// ```
    /// use catamaran::sparse::Mass;
    ///
    /// assert!(Mass::identity(2).check(2).is_ok());
    /// assert!(Mass::Lumped(vec![1.0, -1.0]).check(2).is_err());
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NonFinite`], [`Error::Argument`], all of "mass" and naming an
    /// entry.
    pub fn check(&self, n: usize) -> Result<()> {
        match self {
            Self::Lumped(diagonal) => {
                Error::check_shape("mass", (n, 1), (diagonal.len(), 1))?;
                if let Some(i) = diagonal.iter().position(|m| !m.is_finite()) {
                    return Err(Error::NonFinite { what: "mass", index: (i, 0) });
                }
            }
            Self::Full(matrix) => {
                Error::check_shape("mass", (n, n), matrix.shape())?;
                check_symmetric("mass", matrix.view())?;
            }
        }
        match (0..n).find(|&i| self.diagonal(i) <= 0.0) {
            None => Ok(()),
            Some(i) => Err(Error::Argument {
                what: "mass",
                why: format!("must be positive, but entry {i} is {:e}", self.diagonal(i)),
            }),
        }
    }

    /// Returns the i-th diagonal entry, `i < self.len()`.
    pub fn diagonal(&self, i: usize) -> f64 {
        match self {
            Self::Lumped(diagonal) => diagonal[i],
            Self::Full(matrix) => matrix.get(i, i).copied().unwrap_or(0.0),
        }
    }

    /// Computes `Y := M X`; X and Y are n x c, any strides. The result is the same for every `par`,
    /// bit for bit.
    ///
    /// # Errors
    /// [`Error::Shape`].
    pub fn multiply(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>, par: Par) -> Result<()> {
        Error::check_shape("X", (self.len(), x.ncols()), x.shape())?;
        Error::check_shape("Y", x.shape(), y.shape())?;
        match self {
            Self::Full(matrix) => multiply_symmetric_or_rows(matrix.view(), x, y, par),
            Self::Lumped(diagonal) => for_row_blocks(y, ROW_BLOCK, par, |first, mut y| {
                let masses = ColRef::from_slice(&diagonal[first..first + y.nrows()]);
                let x = x.subrows(first, y.nrows());
                for (y, x) in y.rb_mut().col_iter_mut().zip(x.col_iter()) {
                    zip!(y, x, masses).for_each(|unzip!(y, x, mass)| *y = mass * x);
                }
            }),
        }
        Ok(())
    }
}
