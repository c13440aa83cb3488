use faer::diag::Diag;
use faer::dyn_stack::MemStack;
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::{Mat, MatRef};

use super::memory::{buffer, zeros};
use crate::base::{Error, Result, apart};

/// Eigenpairs of a dense symmetric matrix.
#[derive(Debug, Clone)]
pub struct SymmetricEigen {
    /// n values, ascending.
    pub values: Vec<f64>,
    /// n x n, one orthonormal column for each value.
    pub vectors: Mat<f64>,
}

/// Operations of a decomposition, in units of n^3 (Golub and Van Loan, section 8.3).
const OPERATIONS: f64 = 9.0;

/// Computes all eigenpairs of the symmetric matrix (n x n) whose lower triangle is given, on the
/// calling thread.
///
/// ```
/// use catamaran::{dense::symmetric_eigen, faer::mat};
///
/// let found = symmetric_eigen(mat![[2.0, 1.0], [1.0, 2.0]].as_ref())?;
/// assert!((found.values[0] - 1.0).abs() < 1e-14 && (found.values[1] - 3.0).abs() < 1e-14);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when the matrix is not square; [`Error::NonFinite`] names the first entry of
/// the lower triangle that is not finite; [`Error::OutOfMemory`]; [`Error::Cancelled`];
/// [`Error::NotConverged`].
pub fn symmetric_eigen(matrix: MatRef<'_, f64>) -> Result<SymmetricEigen> {
    let n = matrix.nrows();
    Error::check_shape("matrix", (n, n), matrix.shape())?;
    let mut largest = 0.0f64;
    for j in 0..n {
        for i in j..n {
            if !matrix[(i, j)].is_finite() {
                return Err(Error::NonFinite { what: "matrix", index: (i, j) });
            }
            largest = largest.max(matrix[(i, j)].abs());
        }
    }
    if n == 0 {
        // faer's scratch query subtracts from the size.
        return Ok(SymmetricEigen { values: vec![], vectors: Mat::new() });
    }
    // faer's divide and conquer takes entries below its tolerance for zeros: it is one for matrices
    // whose entries are about 1. A power of two changes no digit.
    let exponent = largest.log2().floor().clamp(-1000.0, 1022.0) as i32;
    let (down, up) = (2f64.powi(-exponent), 2f64.powi(exponent));
    let mut scaled = zeros(n, n)?;
    for j in 0..n {
        for i in j..n {
            scaled[(i, j)] = down * matrix[(i, j)];
        }
    }
    let mut found = apart(OPERATIONS * (n as f64).powi(3), move || decompose(&scaled))??;
    found.values.iter_mut().for_each(|value| *value *= up);
    Ok(found)
}

/// Computes [`symmetric_eigen`] of a finite matrix that has entries, the largest of them about 1.
fn decompose(matrix: &Mat<f64>) -> Result<SymmetricEigen> {
    let (n, par) = (matrix.nrows(), faer::Par::Seq);
    let requirement =
        self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, par, Default::default());
    let mut memory = buffer(requirement)?;
    let mut values = Diag::<f64>::zeros(n);
    let mut vectors = zeros(n, n)?;
    self_adjoint_evd(
        matrix.as_ref(),
        values.as_mut(),
        Some(vectors.as_mut()),
        par,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .map_err(|_| Error::NotConverged { iterations: 0, residual: f64::NAN })?;
    Ok(SymmetricEigen { values: values.column_vector().iter().copied().collect(), vectors })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Rng;

    #[test]
    fn the_factors_give_the_matrix_back() {
        let mut rng = Rng::new(1);
        for n in [0, 1, 2, 7, 33] {
            let half = Mat::from_fn(n, n, |_, _| rng.normal());
            let matrix = &half + half.transpose();
            let SymmetricEigen { values, vectors } = symmetric_eigen(matrix.as_ref()).unwrap();
            assert!(values.is_sorted());
            let scaled = Mat::from_fn(n, n, |i, j| vectors[(i, j)] * values[j]);
            let back = &scaled * vectors.transpose();
            let gap = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
            assert!(gap.into_iter().all(|p| (back[p] - matrix[p]).abs() < 1e-12 * n as f64));
        }
    }

    #[test]
    fn errors_are_relative_to_matrices_of_every_size() {
        let mut rng = Rng::new(2);
        // Divide and conquer begins above 128 columns.
        let n = 200;
        let half = Mat::from_fn(n, n, |_, _| rng.normal());
        let matrix = &half + half.transpose();
        let whole = symmetric_eigen(matrix.as_ref()).unwrap();
        for exponent in [-1060, -1020, -300, -27, 40, 900, 1015] {
            // In two factors, as one may be out of range.
            let [one, other] = [exponent / 2, exponent - exponent / 2].map(|e| 2f64.powi(e));
            let scaled = Mat::from_fn(n, n, |i, j| matrix[(i, j)] * one * other);
            let found = symmetric_eigen(scaled.as_ref()).unwrap();
            if exponent > -1000 {
                assert!(found.vectors == whole.vectors, "{exponent}");
                let values: Vec<f64> = whole.values.iter().map(|x| x * one * other).collect();
                assert_eq!(found.values, values);
            } else {
                let gap = found.vectors.transpose() * &found.vectors - Mat::<f64>::identity(n, n);
                assert!(gap.norm_max() < 1e-13, "{exponent}");
            }
        }
    }

    #[test]
    fn what_is_not_finite_is_named() {
        let mut matrix = Mat::<f64>::identity(3, 3);
        matrix[(2, 1)] = f64::NAN;
        let refused = symmetric_eigen(matrix.as_ref()).unwrap_err();
        assert_eq!(refused, Error::NonFinite { what: "matrix", index: (2, 1) });
    }
}
