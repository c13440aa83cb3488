use faer::Mat;

use super::cholesky::{check_centered, check_lengths, exponent};
use super::double::DoubleDouble;
use crate::base::Result;
use crate::rows::ExtendedGram;

/// Returns the correlation matrix (n x n, symmetric) of columns, from their Gram matrix about the
/// mean: entries within [-1, 1], wrong by little more than one rounding; NaN for a column without
/// variance.
///
/// ```
/// use catamaran::{rows::ExtendedGram, faer::mat, solve::correlation};
///
/// let c = mat![[4.0, 0.0], [3.0, 9.0]];
/// let gram = ExtendedGram::from_f64(c.as_ref(), 5, &[0.0, 0.0])?;
/// assert_eq!(correlation(&gram)?, mat![[1.0, 0.5], [0.5, 1.0]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`](crate::Error::Argument) when the matrix is not about the mean; else as
/// [`PivotedCholesky::from_gram`](super::PivotedCholesky::from_gram).
pub fn correlation(gram: &ExtendedGram) -> Result<Mat<f64>> {
    check_lengths(gram, gram.n())?;
    check_centered(gram)?;
    let n = gram.n();
    let exponents: Vec<_> = (0..n).map(|j| exponent(gram.entry(j, j)[0])).collect();
    let scaled = |i: usize, j: usize| {
        let [hi, mid, low] = gram.entry(i, j);
        DoubleDouble::new(hi, mid + low).scaled(-exponents[i] - exponents[j])
    };
    let roots: Vec<_> = (0..n).map(|j| scaled(j, j).sqrt()).collect();
    let mut matrix = crate::dense::zeros(n, n)?;
    for j in 0..n {
        let defined = |i: usize| roots[i].hi > 0.0;
        matrix[(j, j)] = if defined(j) { 1.0 } else { f64::NAN };
        for i in j + 1..n {
            let value = if defined(i) && defined(j) {
                (scaled(i, j) / (roots[i] * roots[j])).hi.clamp(-1.0, 1.0)
            } else {
                f64::NAN
            };
            matrix[(i, j)] = value;
            matrix[(j, i)] = value;
        }
    }
    Ok(matrix)
}
