use faer::{MatMut, MatRef};

use crate::base::{Real, Result};
use crate::product::combine::{in_lower, scale, scale_lower};
use crate::product::options::Uplo;

/// The matrices of one call: `C := alpha A^T B + beta C`, B being A when `None`.
///
/// A is m x n, B is m x k, C is n x k. A symmetric product touches only the triangle or triangles
/// of `uplo`; with `beta == 0` C is not read.
pub(crate) struct Product<'p, T> {
    pub alpha: T,
    pub a: MatRef<'p, T>,
    pub b: Option<MatRef<'p, T>>,
    pub beta: T,
    pub c: MatMut<'p, T>,
    /// `None` when all of C is computed, without symmetry.
    pub uplo: Option<Uplo>,
}

impl<T: Real> Product<'_, T> {
    /// Returns whether no entry of A and B is read: `C := beta C`.
    pub fn is_scaling(&self) -> bool {
        self.alpha == T::ZERO || self.a.nrows() == 0
    }

    /// Computes `C := beta C`.
    pub fn scale(self) -> Result<()> {
        let beta = self.beta;
        let symmetric = self.uplo.is_some();
        self.into_lower(|lower| {
            if symmetric {
                scale_lower(lower.c, beta)
            } else {
                scale(lower.c, beta)
            }
            Ok(())
        })
    }

    /// Calls `work` with the same product for the lower triangle, and mirrors the result when both
    /// triangles are requested.
    #[inline(always)]
    pub fn into_lower(self, work: impl FnOnce(Product<'_, T>) -> Result<()>) -> Result<()> {
        let Some(uplo) = self.uplo else { return work(self) };
        let Self { alpha, a, b, beta, c, .. } = self;
        // A^T W A is symmetric, so that its transpose is the same product.
        in_lower(c, uplo, |c| work(Product { alpha, a, b, beta, c, uplo: Some(Uplo::Lower) }))
    }
}
