//! The products that every back end has.

use faer::{MatMut, MatRef};

/// The matrix products of one precision, sequential, transposed on the left.
///
/// Any strides are taken, negative and zero ones (in inputs) too. `beta == 0` means that `c` is
/// not read. The three inputs never overlap `c`.
pub trait Kernels<T>: Send + Sync {
    /// Computes `C := alpha A^T B + beta C`; A is m x n, B is m x k, C is n x k.
    fn gemm(&self, alpha: T, a: MatRef<'_, T>, b: MatRef<'_, T>, beta: T, c: MatMut<'_, T>);

    /// Computes the lower triangle, diagonal included, of `C := alpha A^T A + beta C`; A is m x n.
    /// The strict upper triangle of C is neither read nor written.
    fn syrk(&self, alpha: T, a: MatRef<'_, T>, beta: T, c: MatMut<'_, T>);

    /// Computes the lower triangle, diagonal included, of `C := alpha A^T B + beta C`; A and B are
    /// m x n. The strict upper triangle of C is neither read nor written.
    fn gemmt(&self, alpha: T, a: MatRef<'_, T>, b: MatRef<'_, T>, beta: T, c: MatMut<'_, T>);
}
