//! A matrix whose eigenvalues are known, for the tests of this module.

use sprs::{CsMat, TriMat};

/// Returns the Laplacian of a path of n vertices, with eigenvalues `2 - 2 cos(pi i / n)`, i from 0.
pub(super) fn path(n: usize) -> CsMat<f64> {
    let mut entries = TriMat::new((n, n));
    for i in 1..n {
        for (a, b, x) in [(i, i, 1.0), (i - 1, i - 1, 1.0), (i, i - 1, -1.0), (i - 1, i, -1.0)] {
            entries.add_triplet(a, b, x);
        }
    }
    entries.to_csr()
}
