//! Singular values and pivots that show the rank of a small matrix, on the calling thread.

use faer::diag::Diag;
use faer::dyn_stack::MemStack;
use faer::linalg::qr::{col_pivoting, no_pivoting};
use faer::linalg::svd;
use faer::{Mat, MatRef, Spec};

use super::memory::{buffer, zeros};
use crate::base::{Error, Result, apart};

const SEQ: faer::Par = faer::Par::Seq;

/// Operations of a decomposition of a square matrix, in units of n^3 (Golub and Van Loan, section
/// 8.6).
const OPERATIONS: f64 = 12.0;

/// Returns the singular values of a finite matrix (m x n), descending, and the right singular
/// vectors, n x min(m, n).
pub(crate) fn right_singular(a: MatRef<'_, f64>) -> Result<(Vec<f64>, Mat<f64>)> {
    let (m, n) = a.shape();
    let mut owned = zeros(m, n)?;
    owned.copy_from(a);
    apart(OPERATIONS * m.max(n) as f64 * (m.min(n) as f64).powi(2), move || decompose(&owned))?
}

fn decompose(a: &Mat<f64>) -> Result<(Vec<f64>, Mat<f64>)> {
    let (m, n) = a.shape();
    let size = m.min(n);
    let (mut values, mut vectors) = (Diag::zeros(size), zeros(n, size)?);
    if size > 0 {
        let params = Spec::<svd::SvdParams, f64>::default();
        let (none, thin) = (svd::ComputeSvdVectors::No, svd::ComputeSvdVectors::Thin);
        let mut memory = buffer(svd::svd_scratch::<f64>(m, n, none, thin, SEQ, params))?;
        let stack = MemStack::new(&mut memory);
        svd::svd(a.as_ref(), values.as_mut(), None, Some(vectors.as_mut()), SEQ, stack, params)
            .map_err(|_| Error::NotConverged { iterations: 0, residual: f64::NAN })?;
    }
    Ok((values.column_vector().iter().copied().collect(), vectors))
}

/// Returns the order in which QR with column pivoting takes the columns of a matrix. Unreliable for
/// columns of which less than the root of epsilon is left: their lengths are updated, not computed
/// again.
pub(crate) fn pivots(a: MatRef<'_, f64>) -> Result<Vec<usize>> {
    let (m, n) = a.shape();
    let mut work = zeros(m, n)?;
    work.copy_from(a);
    apart(4.0 * m.max(n) as f64 * (m.min(n) as f64).powi(2), move || order_of_pivots(work))?
}

fn order_of_pivots(mut work: Mat<f64>) -> Result<Vec<usize>> {
    let (m, n) = work.shape();
    if m.min(n) == 0 {
        return Ok((0..n).collect());
    }
    let block = no_pivoting::factor::recommended_block_size::<f64>(m, n).clamp(1, m.min(n));
    let mut coefficients = zeros(block, m.min(n))?;
    let (mut order, mut inverse) = (vec![0usize; n], vec![0usize; n]);
    let scratch =
        col_pivoting::factor::qr_in_place_scratch::<usize, f64>(m, n, block, SEQ, Spec::default());
    let mut memory = buffer(scratch)?;
    col_pivoting::factor::qr_in_place(
        work.as_mut(),
        coefficients.as_mut(),
        &mut order,
        &mut inverse,
        SEQ,
        MemStack::new(&mut memory),
        Spec::default(),
    );
    Ok(order)
}

#[cfg(test)]
mod tests {
    use faer::mat;

    use super::*;

    #[test]
    fn values_and_pivots_of_a_matrix_of_rank_two() {
        // The columns: half of the last one; one of length 5, orthogonal to it; zeros; one of
        // length 2.
        let a = mat![[0.0, 3.0, 0.0, 0.0], [1.0, 0.0, 0.0, 2.0], [0.0, 4.0, 0.0, 0.0]];
        let (values, vectors) = right_singular(a.as_ref()).unwrap();
        assert!((vectors[(1, 0)].abs() - 1.0).abs() < 1e-14);
        for (value, expected) in values.iter().zip([5.0, 5f64.sqrt(), 0.0]) {
            assert!((value - expected).abs() < 1e-14, "{values:?}");
        }
        assert_eq!(pivots(a.as_ref()).unwrap()[..2], [1, 3]);
        for (m, n) in [(0, 3), (3, 0), (1, 1)] {
            let ones = Mat::ones(m, n);
            assert_eq!(right_singular(ones.as_ref()).unwrap().1.shape(), (n, m.min(n)));
            assert_eq!(pivots(ones.as_ref()).unwrap().len(), n);
        }
    }
}
