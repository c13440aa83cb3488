use faer::prelude::{Reborrow, ReborrowMut};
use faer::{MatMut, MatRef};

use super::kernels::Kernels;
use crate::base::Real;

/// Order of the diagonal blocks that are computed whole and then halved.
const DIAGONAL: usize = 96;

/// Computes the lower triangle of `C := alpha A^T B + beta C` from general products: halves C until
/// its diagonal blocks are small, and computes those in a buffer on the stack.
pub(super) fn gemmt_by_gemm<T: Real>(
    kernels: &(impl Kernels<T> + ?Sized),
    alpha: T,
    a: MatRef<'_, T>,
    b: MatRef<'_, T>,
    beta: T,
    c: MatMut<'_, T>,
) {
    let n = c.nrows();
    if n <= DIAGONAL {
        return diagonal_block(kernels, alpha, a, b, beta, c);
    }
    // A multiple of the block, so that all diagonal blocks but the last are full.
    let half = (n / 2).next_multiple_of(DIAGONAL).min(n - 1);
    let (a1, a2) = a.split_at_col(half);
    let (b1, b2) = b.split_at_col(half);
    let (c11, _, c21, c22) = c.split_at_mut(half, half);
    gemmt_by_gemm(kernels, alpha, a1, b1, beta, c11);
    kernels.gemm(alpha, a2, b1, beta, c21);
    gemmt_by_gemm(kernels, alpha, a2, b2, beta, c22);
}

/// Computes a whole diagonal block. Not inlined, so the recursion above does not carry its buffer.
#[inline(never)]
fn diagonal_block<T: Real>(
    kernels: &(impl Kernels<T> + ?Sized),
    alpha: T,
    a: MatRef<'_, T>,
    b: MatRef<'_, T>,
    beta: T,
    c: MatMut<'_, T>,
) {
    let n = c.nrows();
    let mut buffer = [T::ZERO; DIAGONAL * DIAGONAL];
    let mut square = MatMut::from_column_major_slice_mut(&mut buffer[..n * n], n, n);
    kernels.gemm(alpha, a, b, T::ZERO, square.rb_mut());
    merge_lower(square.rb(), beta, c);
}

/// Computes `C := M + beta C` on the lower triangle.
fn merge_lower<T: Real>(m: MatRef<'_, T>, beta: T, mut c: MatMut<'_, T>) {
    for j in 0..c.ncols() {
        for i in j..c.nrows() {
            c[(i, j)] = if beta == T::ZERO { m[(i, j)] } else { m[(i, j)] + beta * c[(i, j)] };
        }
    }
}
