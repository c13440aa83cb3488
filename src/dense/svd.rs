//! Singular values and vectors of a small matrix, on the calling thread.

use faer::diag::Diag;
use faer::dyn_stack::MemStack;
use faer::linalg::svd::{ComputeSvdVectors, SvdParams, svd, svd_scratch};
use faer::{Mat, MatRef, Spec};

use super::memory::{buffer, zeros};
use crate::base::{Error, Result, apart};

const SEQ: faer::Par = faer::Par::Seq;

/// Operations of a decomposition with vectors of both sides, and of one with those of the right
/// side, in units of `max(m, n) min(m, n)^2` (Golub and Van Loan, section 8.6).
const OPERATIONS: [f64; 2] = [20.0, 12.0];

/// A thin singular value decomposition `A = U diag(s) V^T` of an m x n matrix.
#[derive(Debug, Clone)]
pub struct Svd {
    /// m x min(m, n), orthonormal columns.
    pub u: Mat<f64>,
    /// min(m, n) values, descending.
    pub s: Vec<f64>,
    /// n x min(m, n), orthonormal columns.
    pub v: Mat<f64>,
}

/// Computes the thin singular value decomposition of a finite matrix.
///
/// # Errors
/// [`Error::OutOfMemory`]; [`Error::NotConverged`].
pub fn thin_svd(a: MatRef<'_, f64>) -> Result<Svd> {
    let owned = copied(a)?;
    apart(operations(a, OPERATIONS[0]), move || {
        let mut u = zeros(owned.nrows(), owned.nrows().min(owned.ncols()))?;
        let (s, v) = decompose(owned.as_ref(), Some(&mut u))?;
        Ok(Svd { u, s, v })
    })?
}

/// Returns the singular values of a finite matrix (m x n), descending, and the right singular
/// vectors, n x min(m, n).
///
/// # Errors
/// [`Error::OutOfMemory`]; [`Error::NotConverged`].
pub(crate) fn right_singular(a: MatRef<'_, f64>) -> Result<(Vec<f64>, Mat<f64>)> {
    let owned = copied(a)?;
    apart(operations(a, OPERATIONS[1]), move || decompose(owned.as_ref(), None))?
}

fn copied(a: MatRef<'_, f64>) -> Result<Mat<f64>> {
    let mut owned = zeros(a.nrows(), a.ncols())?;
    owned.copy_from(a);
    Ok(owned)
}

fn operations(a: MatRef<'_, f64>, unit: f64) -> f64 {
    let (m, n) = a.shape();
    unit * m.max(n) as f64 * (m.min(n) as f64).powi(2)
}

fn decompose(a: MatRef<'_, f64>, left: Option<&mut Mat<f64>>) -> Result<(Vec<f64>, Mat<f64>)> {
    let (m, n) = a.shape();
    let size = m.min(n);
    let (mut values, mut right) = (Diag::zeros(size), zeros(n, size)?);
    if size > 0 {
        let params = Spec::<SvdParams, f64>::default();
        let thin = ComputeSvdVectors::Thin;
        let of_left = if left.is_some() { thin } else { ComputeSvdVectors::No };
        let mut memory = buffer(svd_scratch::<f64>(m, n, of_left, thin, SEQ, params))?;
        let left = left.map(|left| left.as_mut());
        let stack = MemStack::new(&mut memory);
        svd(a, values.as_mut(), left, Some(right.as_mut()), SEQ, stack, params)
            .map_err(|_| Error::NotConverged { iterations: 0, residual: f64::NAN })?;
    }
    Ok((values.column_vector().iter().copied().collect(), right))
}

#[cfg(test)]
mod tests {
    use faer::mat;

    use super::*;
    use crate::base::Rng;

    #[test]
    fn values_of_a_matrix_of_rank_two() {
        // The columns: half of the last one; one of length 5, orthogonal to it; zeros; one of
        // length 2.
        let a = mat![[0.0, 3.0, 0.0, 0.0], [1.0, 0.0, 0.0, 2.0], [0.0, 4.0, 0.0, 0.0]];
        let (values, vectors) = right_singular(a.as_ref()).unwrap();
        assert!((vectors[(1, 0)].abs() - 1.0).abs() < 1e-14);
        for (value, expected) in values.iter().zip([5.0, 5f64.sqrt(), 0.0]) {
            assert!((value - expected).abs() < 1e-14, "{values:?}");
        }
    }

    #[test]
    fn the_factors_give_the_matrix_back() {
        let mut rng = Rng::new(1);
        for (m, n) in [(0, 3), (3, 0), (1, 1), (7, 3), (3, 7), (29, 31)] {
            let a = Mat::from_fn(m, n, |_, _| rng.normal());
            let Svd { u, s, v } = thin_svd(a.as_ref()).unwrap();
            assert_eq!((u.shape(), v.shape()), ((m, m.min(n)), (n, m.min(n))));
            assert!(s.is_sorted_by(|a, b| a >= b));
            let scaled = Mat::from_fn(m, m.min(n), |i, j| u[(i, j)] * s[j]);
            let gap = &scaled * v.transpose() - &a;
            assert!(gap.norm_max() < 1e-13 * (m + n) as f64);
            assert_eq!(right_singular(a.as_ref()).unwrap().1.shape(), (n, m.min(n)));
        }
    }
}
