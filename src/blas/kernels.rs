//! The products that every back end has.

use std::ops::ControlFlow;

use faer::prelude::ReborrowMut;
use faer::{MatMut, MatRef};

use crate::base::{Progress, Real};

/// The matrix products of one precision, sequential, transposed on the left.
///
/// Any strides are taken, negative and zero ones (in inputs) too. `beta == 0` means that `c` is
/// not read. The three inputs never overlap `c`.
pub trait Kernels<T: Real>: Send + Sync {
    /// Computes `C := alpha A^T B + beta C`; A is m x n, B is m x k, C is n x k.
    fn gemm(&self, alpha: T, a: MatRef<'_, T>, b: MatRef<'_, T>, beta: T, c: MatMut<'_, T>);

    /// Computes the lower triangle, diagonal included, of `C := alpha A^T A + beta C`; A is m x n.
    /// The strict upper triangle of C is neither read nor written.
    fn syrk(&self, alpha: T, a: MatRef<'_, T>, beta: T, c: MatMut<'_, T>);

    /// Computes the lower triangle, diagonal included, of `C := alpha A^T B + beta C`; A and B are
    /// m x n. The strict upper triangle of C is neither read nor written.
    fn gemmt(&self, alpha: T, a: MatRef<'_, T>, b: MatRef<'_, T>, beta: T, c: MatMut<'_, T>);

    /// Computes [`Kernels::gemm`], or of a `triangle` [`Kernels::syrk`] (B is `None`) or
    /// [`Kernels::gemmt`], and tells `progress` the fraction that is done. On a request to stop it
    /// breaks, with C unfinished.
    ///
    /// A back end that does not ask for itself is called with some rows at a time: for 10^8
    /// operations, but at least 192, because C is read and written once for each piece.
    fn compute(
        &self,
        triangle: bool,
        alpha: T,
        a: MatRef<'_, T>,
        b: Option<MatRef<'_, T>>,
        beta: T,
        c: MatMut<'_, T>,
        progress: Progress<'_>,
    ) -> ControlFlow<()> {
        by_rows(self, triangle, alpha, a, b, beta, c, progress)
    }
}

/// Computes [`Kernels::compute`] with some rows at a time.
fn by_rows<T: Real, K: Kernels<T> + ?Sized>(
    kernels: &K,
    triangle: bool,
    alpha: T,
    a: MatRef<'_, T>,
    b: Option<MatRef<'_, T>>,
    mut beta: T,
    mut c: MatMut<'_, T>,
    progress: Progress<'_>,
) -> ControlFlow<()> {
    const MOST: f64 = 1e8;
    const LEAST: usize = 192;
    let m = a.nrows();
    let row = 2.0 * c.nrows() as f64 * c.ncols() as f64;
    let rows = ((MOST / row) as usize).max(LEAST);
    for first in (0..m.max(1)).step_by(rows) {
        let count = rows.min(m - first);
        let a = a.subrows(first, count);
        let (b, c) = (b.map(|b| b.subrows(first, count)), c.rb_mut());
        match (b, triangle) {
            (None, true) => kernels.syrk(alpha, a, beta, c),
            (Some(b), true) => kernels.gemmt(alpha, a, b, beta, c),
            (b, false) => kernels.gemm(alpha, a, b.unwrap_or(a), beta, c),
        }
        beta = T::ONE;
        let done = first + count;
        progress.tell(if done == m { 1.0 } else { done as f64 / m as f64 })?;
    }
    ControlFlow::Continue(())
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicBool, Ordering};

    use faer::Mat;

    use super::*;
    use crate::blas::{BlasReal, native};

    #[test]
    fn a_product_in_pieces_is_the_whole_and_stops_when_asked() {
        let backend = native();
        let kernels = f64::kernels(backend.as_ref());
        for m in [0, 1, 191, 500] {
            let a = Mat::from_fn(m, 600, |i, j| ((i * 7 + j * 3) % 11) as f64 - 5.0);
            let b = Mat::from_fn(m, 600, |i, j| ((i * 5 + j * 2) % 13) as f64 - 6.0);
            let (a, b) = (a.as_ref(), b.as_ref());
            for (right, triangle) in [(None, true), (Some(b), true), (Some(b), false)] {
                let mut whole = Mat::from_fn(600, 600, |i, j| (i + 2 * j) as f64);
                let mut pieces = [whole.clone(), whole.clone()];
                match (right, triangle) {
                    (None, _) => kernels.syrk(2.0, a, 3.0, whole.as_mut()),
                    (Some(b), true) => kernels.gemmt(2.0, a, b, 3.0, whole.as_mut()),
                    (Some(b), false) => kernels.gemm(2.0, a, b, 3.0, whole.as_mut()),
                }
                for (pieces, by_itself) in pieces.iter_mut().zip([true, false]) {
                    let compute = |c: MatMut<'_, f64>, progress: Progress<'_>| match by_itself {
                        true => kernels.compute(triangle, 2.0, a, right, 3.0, c, progress),
                        false => by_rows(kernels, triangle, 2.0, a, right, 3.0, c, progress),
                    };
                    let asked = AtomicBool::new(false);
                    let once = |_: f64| match asked.swap(true, Ordering::Relaxed) {
                        false => ControlFlow::Break(()),
                        true => ControlFlow::Continue(()),
                    };
                    let stopped = compute(pieces.clone().as_mut(), Progress::new(&once));
                    assert!(stopped.is_break());
                    let told = Mutex::new(Vec::new());
                    let note = |fraction| {
                        told.lock().unwrap().push(fraction);
                        ControlFlow::Continue(())
                    };
                    let done = compute(pieces.as_mut(), Progress::new(&note));
                    let told = told.into_inner().unwrap();
                    assert!(done.is_continue() && told.is_sorted() && told.last() == Some(&1.0));
                    assert!(told.len() >= m / 192, "{told:?}");
                }
                assert!(pieces.iter().all(|c| *c == whole), "{m} rows, triangle: {triangle}");
            }
        }
    }
}
