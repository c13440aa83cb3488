//! What tells of the rank of a small matrix, on the calling thread.

use faer::diag::Diag;
use faer::dyn_stack::MemStack;
use faer::linalg::qr::{col_pivoting, no_pivoting};
use faer::linalg::svd;
use faer::{MatRef, Spec};

use super::memory::{buffer, zeros};
use crate::base::{Error, Result};

const SEQ: faer::Par = faer::Par::Seq;

/// The singular values of a finite matrix, descending.
pub(crate) fn singular_values(a: MatRef<'_, f64>) -> Result<Vec<f64>> {
    let (m, n) = a.shape();
    if m.min(n) == 0 {
        return Ok(vec![]);
    }
    let params = Spec::<svd::SvdParams, f64>::default();
    let none = svd::ComputeSvdVectors::No;
    let mut values = Diag::zeros(m.min(n));
    let mut memory = buffer(svd::svd_scratch::<f64>(m, n, none, none, SEQ, params))?;
    svd::svd(a, values.as_mut(), None, None, SEQ, MemStack::new(&mut memory), params)
        .map_err(|_| Error::NotConverged { iterations: 0, residual: f64::NAN })?;
    Ok(values.column_vector().iter().copied().collect())
}

/// The columns of a matrix in the order in which QR with column pivoting takes them.
pub(crate) fn pivots(a: MatRef<'_, f64>) -> Result<Vec<usize>> {
    let (m, n) = a.shape();
    if m.min(n) == 0 {
        return Ok((0..n).collect());
    }
    let mut work = zeros(m, n)?;
    work.copy_from(a);
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
        // Orthogonal columns of length 5 and 2, a multiple of the second, and nothing.
        let a = mat![[0.0, 3.0, 0.0, 0.0], [2.0, 0.0, 1.0, 0.0], [0.0, 4.0, 0.0, 0.0]];
        let values = singular_values(a.as_ref()).unwrap();
        for (value, expected) in values.iter().zip([5.0, 5f64.sqrt(), 0.0]) {
            assert!((value - expected).abs() < 1e-14, "{values:?}");
        }
        assert_eq!(pivots(a.as_ref()).unwrap()[..2], [1, 0]);
        for (m, n) in [(0, 3), (3, 0), (1, 1)] {
            assert_eq!(singular_values(faer::Mat::ones(m, n).as_ref()).unwrap().len(), m.min(n));
            assert_eq!(pivots(faer::Mat::ones(m, n).as_ref()).unwrap().len(), n);
        }
    }
}
