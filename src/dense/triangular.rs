use faer::dyn_stack::MemStack;
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{MatMut, MatRef};

use super::ROW_BLOCK;
use super::memory::{buffer, zeros};
use super::rows::{block, by_pieces};
use crate::base::{Par, Result, apart, count};

/// Operations of a factorization that is not copied for another thread to do.
const WHOLE: f64 = 1e7;

/// Computes L of `A = L L^T` in the lower triangle of A, the only part that is read or written.
/// Returns `Ok(Err(i))` when the i-th pivot is not positive.
///
/// # Errors
/// [`Error::OutOfMemory`](crate::Error::OutOfMemory) when memory is refused, and `Cancelled`.
pub fn cholesky(mut a: MatMut<'_, f64>) -> Result<std::result::Result<(), usize>> {
    let operations = (a.nrows() as f64).powi(3) / 3.0;
    if operations < WHOLE {
        count(operations);
        return factorize(a);
    }
    let n = a.nrows();
    let mut owned = zeros(n, n)?;
    owned.copy_from(a.rb());
    let (owned, done) = apart(operations, move || {
        let done = factorize(owned.as_mut());
        (owned, done)
    })?;
    for j in 0..n {
        (j..n).for_each(|i| a[(i, j)] = owned[(i, j)]);
    }
    done
}

fn factorize(mut a: MatMut<'_, f64>) -> Result<std::result::Result<(), usize>> {
    let requirement =
        cholesky_in_place_scratch::<f64>(a.nrows(), faer::Par::Seq, Default::default());
    let mut memory = buffer(requirement)?;
    let stack = MemStack::new(&mut memory);
    // faer's test of the pivots does not reject NaN.
    let nan = (0..a.nrows()).find(|&i| a[(i, i)].is_nan());
    if let Some(i) = nan {
        return Ok(Err(i));
    }
    let done = cholesky_in_place(
        a.rb_mut(),
        Default::default(),
        faer::Par::Seq,
        stack,
        Default::default(),
    );
    Ok(match done {
        Ok(_) => Ok(()),
        Err(faer::linalg::cholesky::llt::factor::LltError::NonPositivePivot { index }) => {
            Err(index)
        }
    })
}

/// Computes `X := X R^-1` for an upper triangular R, given as `L = R^T`: rows by blocks, each on
/// one thread.
///
/// # Errors
/// [`Error::Cancelled`](crate::Error::Cancelled).
pub fn divide_by_upper(x: MatMut<'_, f64>, l: MatRef<'_, f64>, par: Par) -> Result<()> {
    let operations = l.nrows() * l.nrows();
    let block = block(operations, ROW_BLOCK);
    by_pieces(x, block, operations, par, |_, rows| lower_solve_in_place(l, rows.transpose_mut()))
}

/// Computes `X := L^-1 X` on the calling thread.
pub fn lower_solve_in_place(l: MatRef<'_, f64>, x: MatMut<'_, f64>) {
    solve_lower_triangular_in_place(l, x, faer::Par::Seq);
}

/// Computes `X := U^-1 X` on the calling thread.
pub fn upper_solve_in_place(u: MatRef<'_, f64>, x: MatMut<'_, f64>) {
    solve_upper_triangular_in_place(u, x, faer::Par::Seq);
}
