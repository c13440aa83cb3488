//! The orthogonalized eigenproducts (thesis, section 1.3.3).

use faer::{Mat, MatRef, Scale};

use super::dictionary::Eigenproducts;
use crate::spectral::basis::Basis;
use crate::spectral::eigenbasis::Eigenbasis;
use catamaran::base::{Error, Par, Progress, Result, check_request, options};
use catamaran::dense::zeros;
use catamaran::ortho::{
    GramSchmidtOptions, TriangularFactor, gram_schmidt_in_place, rank_revealing_in_place,
};

/// The method of orthogonalization of eigenproducts: the two methods of the thesis (section 1.4),
/// and one by rank.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Orthogonalization {
    /// "ours": one pass of Gram-Schmidt; a product is dropped when less than 1e-2 of its norm is
    /// left. The result is not exactly orthogonal, so that projections are by least squares. The
    /// more stable method under transfer.
    SinglePass,
    /// "ours*": repeated until orthogonal; a product is dropped when less than 1e-9 of its norm is
    /// left. The basis is larger, for approximation and filters.
    Reorthogonalized,
    /// Keeps as many products as their numerical rank: singular values above 1e-9 of the largest,
    /// of all products scaled to norm 1 ([`rank_revealing`](catamaran::ortho::rank_revealing())).
    /// Orthogonal to rounding. Where "ours*" keeps nearly dependent products, this basis has fewer
    /// functions, and coefficients of moderate size. `Q R = B` up to the threshold in all columns.
    RankRevealing,
}

options! {
    /// Options of [`ProductBasis::new`].
    #[derive(Debug, Clone)]
    pub struct ProductBasisOptions<'a> {
        /// The method.
        orthogonalization: Orthogonalization = Orthogonalization::SinglePass;
        /// Threads. Their number does not change the result.
        par: Par = Par::all();
        /// Callback for progress, which may cancel.
        progress: Progress<'a> = Progress::none(), setter into;
    }
}

/// A basis of the Fourier polynomials on a mesh: the eigenproducts of at most a given order,
/// orthogonalized.
///
/// The factors are the eigenfunctions divided by the constant one, `phi_i / phi_0`: they have no
/// unit and mean square 1, so that the basis does not depend on the size of the mesh. With the L
/// products as columns of B, `Q R = B` to rounding in the columns that are kept, and up to the
/// threshold in the others (equation 1.13).
///
/// ```
/// use catamaran_geometry::spectral::{Eigenbasis, ProductBasis, ProductBasisOptions};
/// use catamaran_geometry::prelude::*;
/// use catamaran_geometry::mesh::families;
///
/// let Laplacian { stiffness, mass, .. } =
///     laplacian(&families::icosphere(3)?, &LaplacianOptions::new())?;
/// let pairs = eigs(stiffness.view(), &mass, &EigenOptions::new().k(5))?;
/// let basis = Eigenbasis::new(pairs.values, pairs.vectors, mass)?;
/// let products = ProductBasis::new(&basis, 2, &ProductBasisOptions::new())?;
/// assert!(products.len() > basis.len());
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct ProductBasis {
    products: Eigenproducts,
    kept: Vec<usize>,
    r: Mat<f64>,
    basis: Basis,
}

impl ProductBasis {
    /// Computes the basis of all products of at most `order` of the eigenfunctions other than the
    /// constant.
    ///
    /// The products are computed and orthogonalized in the memory of the result; R takes additional
    /// memory.
    ///
    /// # Errors
    /// [`Error::Argument`] when the order is too large, the products do not fit into the memory,
    /// the constant is not among the eigenfunctions, or the functions that
    /// [`Orthogonalization::SinglePass`] keeps depend on each other, as they may where there are
    /// many; [`Error::OutOfMemory`], [`Error::Cancelled`].
    pub fn new(
        eigenbasis: &Eigenbasis,
        order: usize,
        options: &ProductBasisOptions<'_>,
    ) -> Result<Self> {
        let constant = eigenbasis.need_constant("eigenbasis")?;
        let (n, k) = (eigenbasis.basis().vertices(), eigenbasis.len() - 1);
        let products = Self::products_on(n, k, order)?;
        let mut matrix = zeros(n, products.len())?;
        let factors = Scale(1.0 / constant) * eigenbasis.functions().subcols(1, k);
        products.evaluate(factors.as_ref(), matrix.as_mut(), options.par)?;
        let mass = eigenbasis.basis().mass().clone();
        let defaults = match options.orthogonalization {
            Orthogonalization::SinglePass => GramSchmidtOptions::single_pass(),
            Orthogonalization::Reorthogonalized | Orthogonalization::RankRevealing => {
                GramSchmidtOptions::reorthogonalized()
            }
        };
        let gram_schmidt = defaults.par(options.par).progress(options.progress);
        let TriangularFactor { r, kept } = match options.orthogonalization {
            Orthogonalization::RankRevealing => {
                rank_revealing_in_place(matrix.as_mut(), &mass, &gram_schmidt)?
            }
            _ => gram_schmidt_in_place(matrix.as_mut(), &mass, &gram_schmidt)?,
        };
        matrix.truncate(matrix.nrows(), kept.len());
        let basis = match options.orthogonalization {
            Orthogonalization::SinglePass => Basis::independent(matrix, mass, options.par)
                .map_err(|error| dependent(error, products.len()))?,
            _ => Basis::orthonormal(matrix, mass)?,
        };
        Ok(Self { products, kept, r, basis })
    }

    /// Returns the products of at most `order` of `k` eigenfunctions that [`ProductBasis::new`]
    /// orthogonalizes on a mesh of `n` vertices. The command line learns by it, before it computes
    /// the eigenfunctions, whether there are too many.
    ///
    /// # Errors
    /// Those of [`ProductBasis::new`] about the order and about memory.
    #[doc(hidden)]
    pub fn products_on(n: usize, k: usize, order: usize) -> Result<Eigenproducts> {
        let products = Eigenproducts::new(k, order)?;
        let len = products.len();
        let request = format_args!("{len} functions of {n} vertices");
        check_request("order", request, 8.0 * len as f64 * n as f64)?;
        Ok(products)
    }

    /// Returns the products that were orthogonalized, L of them.
    pub fn products(&self) -> &Eigenproducts {
        &self.products
    }

    /// Returns the functions Q, n x r, with their inner product.
    pub fn basis(&self) -> &Basis {
        &self.basis
    }

    /// Returns the functions Q with their inner product, and drops the rest.
    pub fn into_basis(self) -> Basis {
        self.basis
    }

    /// Returns the functions Q, n x r.
    pub fn functions(&self) -> MatRef<'_, f64> {
        self.basis.functions()
    }

    /// Returns R, r x L: the coefficients of every product in the basis.
    pub fn r(&self) -> MatRef<'_, f64> {
        self.r.as_ref()
    }

    /// Returns for each of the r functions the index of the product it comes from, ascending:
    /// `R[.., kept]` is upper triangular.
    pub fn kept(&self) -> &[usize] {
        &self.kept
    }

    /// Returns the number r of functions.
    pub fn len(&self) -> usize {
        self.kept.len()
    }

    /// Returns whether the basis has no functions.
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// Returns `R[.., kept]`, r x r, upper triangular.
    pub(super) fn triangle(&self) -> Mat<f64> {
        Mat::from_fn(self.len(), self.len(), |i, j| self.r[(i, self.kept[j])])
    }
}

/// Returns the error about functions of a single pass, of so many products, that depend on each
/// other.
fn dependent(error: Error, products: usize) -> Error {
    match error {
        Error::Argument { what: "functions", why } => Error::Argument {
            what: "orthogonalization",
            why: format!(
                "a single pass over {products} products leaves dependent functions: {why}"
            ),
        },
        error => error,
    }
}
