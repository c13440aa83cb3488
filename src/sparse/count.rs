use sprs::CsMatView;

use super::Mass;
use super::eigs::check;
use super::options::EigenOptions;
use super::problem::Problem;
use super::space::WholePencil;
use crate::base::{Error, Result};

/// Computes the number of eigenvalues of `W phi = lambda M phi` below `value`, by the inertia of a
/// factorization of `W - value M` (Sylvester).
///
/// W (n x n) is symmetric, all entries stored, by rows or by columns. With the result as `k`,
/// [`eigs`](super::eigs()) finds all pairs below `value`. For the pairs in an interval, use the
/// difference of two counts as `k` and the middle of the interval as the shift.
///
/// ```
/// use catamaran::sparse::{Mass, count_below};
///
/// // A ring of 100 nodes: eigenvalues 2 - 2 cos(2 pi j / 100), for j and -j.
/// # let mut ring = sprs::TriMat::new((100, 100));
/// # for (i, j) in (0..100).map(|i| (i, (i + 1) % 100)) {
/// #     for (i, j, x) in [(i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)] {
/// #         ring.add_triplet(i, j, x);
/// #     }
/// # }
/// # let (ring, mass) = (ring.to_csr::<usize>(), Mass::identity(100));
/// assert_eq!(count_below(ring.view(), &mass, 0.98)?, 33); // j from -16 to 16
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`eigs`](super::eigs()); [`Error::Argument`] of "value" when it is not finite, or an
/// eigenvalue to the precision of the elimination.
pub fn count_below(stiffness: CsMatView<'_, f64>, mass: &Mass, value: f64) -> Result<usize> {
    check(stiffness, mass, &EigenOptions { k: 0, ..EigenOptions::default() })?;
    let refuse = |why: &str| Error::Argument { what: "value", why: format!("{value:e} {why}") };
    if !value.is_finite() {
        return Err(refuse("is not finite"));
    }
    if stiffness.rows() == 0 {
        return Ok(0);
    }
    let pencil = WholePencil { stiffness, mass };
    Problem::whole(&pencil)?
        .count_below(value)
        .and_then(|count| count.ok_or_else(|| refuse("is an eigenvalue up to rounding")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sparse::path::path;

    #[test]
    fn counts_are_those_of_a_path() {
        // 2 - 2 cos(pi i / n), i from 0.
        let n = 30;
        let path = path(n);
        let mass = Mass::Lumped(vec![2.0; n]);
        let value = |i: f64| 1.0 - (std::f64::consts::PI * i / n as f64).cos();
        for i in 0..n {
            assert_eq!(count_below(path.view(), &mass, value(i as f64 + 0.5)).unwrap(), i + 1);
        }
        assert_eq!(count_below(path.view(), &mass, -1.0).unwrap(), 0);
        let refused = count_below(path.view(), &mass, f64::NAN).unwrap_err();
        assert!(matches!(refused, Error::Argument { what: "value", .. }));
        // The last pivot of its elimination is 0, with no rows below it.
        let three = sprs::CsMat::new(
            (4, 4),
            vec![0, 1, 2, 3, 4],
            vec![0, 1, 2, 3],
            vec![0.0, 1.0, 2.0, 3.0],
        );
        let refused = count_below(three.view(), &Mass::identity(4), 3.0).unwrap_err();
        assert!(matches!(refused, Error::Argument { what: "value", .. }), "{refused}");
        assert_eq!(count_below(three.view(), &Mass::identity(4), 2.5).unwrap(), 3);
        let none = sprs::CsMat::<f64>::zero((0, 0));
        assert_eq!(count_below(none.view(), &Mass::identity(0), 1.0).unwrap(), 0);
    }
}
