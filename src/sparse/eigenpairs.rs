use faer::{Mat, MatRef};

use crate::base::{Par, Result};
use crate::dense::columns;

/// Eigenpairs of `W phi = lambda M phi`.
#[derive(Debug, Clone)]
pub struct Eigenpairs {
    /// k eigenvalues, ascending.
    pub values: Vec<f64>,
    /// n x k: an eigenvector for each value, `V^T M V = I` (to rounding).
    pub vectors: Mat<f64>,
    /// For each pair `|W phi - lambda M phi| / max(|W phi|, s |M phi|)` in the Euclidean norm, as
    /// computed from the result, `W phi` by differences in rows that sum to zero. The scale s of
    /// the smallest eigenvalues ([`eigs`](super::eigs())) stands for that of `W phi` where lambda
    /// is about 0.
    pub residuals: Vec<f64>,
    /// Vectors that `(W - sigma M)^-1 M` was applied to; 0 if the problem was solved as a dense
    /// one.
    pub solves: usize,
}

impl Eigenpairs {
    /// Returns the index of the pair with the largest residual, the first of several, and that
    /// residual; `None` without pairs. The residual is above the requested tolerance where the
    /// rounding of the vectors allows no less
    /// ([`EigenOptions::tolerance`](super::EigenOptions::tolerance)).
    ///
    /// ```
    /// use catamaran::prelude::*;
    /// # use catamaran::sparse::Mass;
    ///
    /// // A ring of 100 nodes: eigenvalues 2 - 2 cos(2 pi j / 100), for j and -j.
    /// # let mut ring = sprs::TriMat::new((100, 100));
    /// # for (i, j) in (0..100).map(|i| (i, (i + 1) % 100)) {
    /// #     for (i, j, x) in [(i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)] {
    /// #         ring.add_triplet(i, j, x);
    /// #     }
    /// # }
    /// # let (ring, mass) = (ring.to_csr::<usize>(), Mass::identity(100));
    /// let pairs = eigs(ring.view(), &mass, &EigenOptions::new().k(4))?;
    /// assert!(pairs.worst().is_some_and(|(_, residual)| residual <= 1e-9));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn worst(&self) -> Option<(usize, f64)> {
        let all = self.residuals.iter().copied().enumerate();
        all.rev().max_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// Returns these pairs in ascending order.
///
/// # Errors
/// [`Error::OutOfMemory`](crate::Error::OutOfMemory).
pub(crate) fn ascending(
    values: &[f64],
    vectors: MatRef<'_, f64>,
    residuals: &[f64],
    solves: usize,
    par: Par,
) -> Result<Eigenpairs> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    Ok(Eigenpairs {
        values: order.iter().map(|&j| values[j]).collect(),
        vectors: columns(vectors, &order, par)?,
        residuals: order.iter().map(|&j| residuals[j]).collect(),
        solves,
    })
}
