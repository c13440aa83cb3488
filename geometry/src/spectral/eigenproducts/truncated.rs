//! Eigenproducts without orthogonalization: the baseline "prods" of the thesis (Nogneng et al.
//! 2018).

use faer::{Mat, MatRef};

use super::orthogonalized::ProductBasis;
use crate::spectral::dense;
use catamaran::base::{Error, Par, Result};
use catamaran::dense::Svd;

/// Functions as coefficients of the eigenproducts themselves. Among the many possible coefficients,
/// a truncated singular value decomposition of the products gives the least ones.
///
/// This baseline serves for comparison with [`ProductBasis`]; it is larger, slower and less stable.
/// Coefficients are transferred by [`ProductMap::apply`](super::ProductMap::apply).
///
/// ```
/// use catamaran_geometry::spectral::{Eigenbasis, Orthogonalization, ProductBasis, ProductBasisOptions};
/// use catamaran_geometry::prelude::*;
/// use catamaran_geometry::{mesh::families, spectral::TruncatedProducts};
///
/// # let mesh = families::icosphere(2)?;
/// # let operator = laplacian(&mesh, &LaplacianOptions::new())?;
/// # let pairs = eigs(operator.stiffness.view(), &operator.mass, &EigenOptions::new().k(4))?;
/// # let basis = Eigenbasis::new(pairs.values, pairs.vectors, operator.mass)?;
/// let kind = Orthogonalization::Reorthogonalized;
/// let options = ProductBasisOptions::new().orthogonalization(kind);
/// let products = ProductBasis::new(&basis, 2, &options)?;
/// let truncated = TruncatedProducts::new(&products, 1e-9)?;
/// // An eigenfunction is one of the products.
/// let f = basis.functions().subcols(2, 1);
/// let coefficients = truncated.analysis(f, Par::Seq)?;
/// let found = truncated.synthesis(coefficients.as_ref(), Par::Seq)?;
/// assert!((found - f).norm_max() < 1e-8);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct TruncatedProducts<'a> {
    basis: &'a ProductBasis,
    /// The decomposition of R, r x L.
    svd: Svd,
    rank: usize,
}

impl<'a> TruncatedProducts<'a> {
    /// Decomposes the products of `basis`, which should be
    /// [`Reorthogonalized`](super::Orthogonalization::Reorthogonalized): `Q R = B`, so that R has
    /// the singular values of the products B in the norm of the mass.
    ///
    /// Singular values of at most `threshold`, in `[0, 1)`, times the largest are left out. For
    /// transfer, the code published with the thesis takes 2e-3 times the number of eigenfunctions,
    /// the constant included, minus two; for approximation, it leaves out only those due to
    /// rounding.
    ///
    /// # Errors
    /// [`Error::Argument`] for an invalid threshold, [`Error::NotConverged`] when the decomposition
    /// fails.
    pub fn new(basis: &'a ProductBasis, threshold: f64) -> Result<Self> {
        let svd = dense::thin_svd("R", basis.r())?;
        let mut products = Self { basis, svd, rank: 0 };
        products.set_threshold(threshold)?;
        Ok(products)
    }

    /// Changes which singular values are left out, as in [`TruncatedProducts::new`], without
    /// another decomposition.
    ///
    /// # Errors
    /// [`Error::Argument`] for an invalid threshold.
    pub fn set_threshold(&mut self, threshold: f64) -> Result<()> {
        if !(0.0..1.0).contains(&threshold) {
            let why = format!("must be at least 0 and less than 1, is {threshold}");
            return Err(Error::Argument { what: "threshold", why });
        }
        let least = threshold * self.svd.s.first().copied().unwrap_or(0.0);
        self.rank = self.svd.s.iter().take_while(|&&s| s > least).count();
        Ok(())
    }

    /// Returns the number of singular values that are used.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Computes the least coefficients of products, L x c, of the functions of their (truncated)
    /// span that are nearest to the columns of `f`, n x c.
    ///
    /// # Errors
    /// As [`Basis::analysis`](crate::spectral::Basis::analysis).
    pub fn analysis(&self, f: MatRef<'_, f64>, par: Par) -> Result<Mat<f64>> {
        let coefficients = self.basis.basis().analysis(f, par)?;
        let left = self.svd.u.subcols(0, self.rank);
        let mut parts = dense::transposed_product(left, coefficients.as_ref(), par)?;
        for j in 0..parts.ncols() {
            for i in 0..self.rank {
                parts[(i, j)] /= self.svd.s[i];
            }
        }
        dense::product(self.svd.v.subcols(0, self.rank), parts.as_ref(), par)
    }

    /// Computes the functions, n x c, with these coefficients of products, L x c.
    ///
    /// # Errors
    /// [`Error::Shape`] when there are not L rows, [`Error::OutOfMemory`].
    pub fn synthesis(&self, coefficients: MatRef<'_, f64>, par: Par) -> Result<Mat<f64>> {
        let expected = (self.basis.products().len(), coefficients.ncols());
        Error::check_shape("coefficients", expected, coefficients.shape())?;
        let coefficients = dense::product(self.basis.r(), coefficients, par)?;
        self.basis.basis().synthesis(coefficients.as_ref(), par)
    }
}
