//! QR of a small matrix on the calling thread: pivots that show its rank, and least squares.

use faer::dyn_stack::{MemStack, StackReq};
use faer::linalg::qr::{col_pivoting, no_pivoting};
use faer::{Mat, MatRef, Spec};

use super::memory::{buffer, zeros};
use crate::base::{Result, apart};

const SEQ: faer::Par = faer::Par::Seq;

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

/// Returns the X that minimizes `|A X - B|`, for A of full column rank, by Householder's QR.
///
/// # Errors
/// [`Error::OutOfMemory`](crate::Error::OutOfMemory).
pub fn qr_least_squares(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Result<Mat<f64>> {
    let (m, n) = a.shape();
    let mut basis = zeros(m, n)?;
    basis.copy_from(a);
    let mut x = zeros(m, b.ncols())?;
    x.copy_from(b);
    let operations = 2.0 * m as f64 * n as f64 * (n + 2 * b.ncols()) as f64;
    apart(operations, move || solve(basis, x))?
}

fn solve(mut basis: Mat<f64>, mut x: Mat<f64>) -> Result<Mat<f64>> {
    let ((m, n), columns) = (basis.shape(), x.ncols());
    let block = no_pivoting::factor::recommended_block_size::<f64>(m, n).min(m.min(n)).max(1);
    let mut coefficients = zeros(block, m.min(n))?;
    let mut memory = buffer(StackReq::any_of(&[
        no_pivoting::factor::qr_in_place_scratch::<f64>(m, n, block, SEQ, Spec::default()),
        no_pivoting::solve::solve_lstsq_in_place_scratch::<f64>(m, n, block, columns, SEQ),
    ]))?;
    let stack = MemStack::new(&mut memory);
    no_pivoting::factor::qr_in_place(
        basis.as_mut(),
        coefficients.as_mut(),
        SEQ,
        stack,
        Spec::default(),
    );
    no_pivoting::solve::solve_lstsq_in_place(
        basis.as_ref(),
        coefficients.as_ref(),
        basis.get(..m.min(n), ..),
        x.as_mut(),
        SEQ,
        stack,
    );
    Ok(x.subrows(0, n).to_owned())
}

#[cfg(test)]
mod tests {
    use faer::mat;

    use super::*;

    #[test]
    fn pivots_of_a_matrix_of_rank_two() {
        // The columns: half of the last one; one of length 5, orthogonal to it; zeros; one of
        // length 2.
        let a = mat![[0.0, 3.0, 0.0, 0.0], [1.0, 0.0, 0.0, 2.0], [0.0, 4.0, 0.0, 0.0]];
        assert_eq!(pivots(a.as_ref()).unwrap()[..2], [1, 3]);
        for (m, n) in [(0, 3), (3, 0), (1, 1)] {
            assert_eq!(pivots(Mat::ones(m, n).as_ref()).unwrap().len(), n);
        }
    }

    #[test]
    fn least_squares_through_four_points_of_a_line() {
        let a = mat![[1.0, 0.0], [1.0, 1.0], [1.0, 2.0], [1.0, 3.0]];
        let b = mat![[1.0], [3.0], [4.0], [4.0]];
        let x = qr_least_squares(a.as_ref(), b.as_ref()).unwrap();
        assert!((x[(0, 0)] - 1.5).abs() < 1e-14 && (x[(1, 0)] - 1.0).abs() < 1e-14);
    }
}
