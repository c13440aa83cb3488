//! A^T A of a sparse matrix that never becomes dense.

use catamaran::blas::BlasReal;
use catamaran::faer::MatMut;
use catamaran::io::CsMat;
use catamaran::{AtaOptions, Uplo};

/// Multiplications of [`product`]: the square of the nonzeros of each row.
pub fn row_products(a: &CsMat<f64>) -> usize {
    a.outer_iterator().map(|row| row.nnz() * row.nnz()).sum()
}

/// Whether [`product`] beats the dense one, whose multiplications are many times faster.
pub fn is_faster(a: &CsMat<f64>) -> bool {
    /// Scattered multiplications that take as long as a dense one.
    const RATIO: f64 = 32.0;
    RATIO * row_products(a) as f64 <= a.rows() as f64 * (a.cols() as f64).powi(2)
}

/// `C = A^T W A` as the sum over the rows of `w_i a_i a_i^T`, in f64 until the entries of C. C is zero.
pub fn product<T: BlasReal>(
    a: &CsMat<f64>,
    weights: Option<&[f64]>,
    mut c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
) -> catamaran::Result<()> {
    for (i, row) in a.outer_iterator().enumerate() {
        if i % 4096 == 0 {
            options.progress.report(i as f64 / a.rows() as f64)?;
        }
        let weight = weights.map_or(1.0, |w| w[i]);
        for (j, &left) in row.iter() {
            for (k, &right) in row.iter().take_while(|&(k, _)| k <= j) {
                let at = if options.uplo == Uplo::Upper { (k, j) } else { (j, k) };
                c[at] += T::from_f64(weight * left * right);
            }
        }
    }
    if options.uplo == Uplo::Both {
        for j in 0..c.ncols() {
            for i in 0..j {
                c[(i, j)] = c[(j, i)];
            }
        }
    }
    Ok(())
}
