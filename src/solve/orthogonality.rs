use super::cholesky::check;
use super::double::{DoubleDouble, TripleSum, scaled};
use crate::base::Result;
use crate::rows::ExtendedGram;

/// How far the columns of Q are from orthonormal.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Orthogonality {
    /// The largest entry of `Q^T Q - I` by size, rounded once from the three parts of the matrix.
    pub max: f64,
    /// The Frobenius norm of `Q^T Q - I`, summed in double-double and rounded to f64.
    pub frobenius: f64,
}

/// Returns `|Q^T Q - I|` from the Gram matrix of Q: no digits are lost to cancellation.
///
/// ```
/// use catamaran::{rows::ExtendedGram, faer::mat, solve::orthogonality};
///
/// let c = mat![[1.0 + f64::EPSILON, 0.0], [0.0, 1.0]];
/// let gram = ExtendedGram::from_f64(c.as_ref(), 5, &[])?;
/// assert_eq!(orthogonality(&gram)?.max, f64::EPSILON);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::NonFinite`](crate::Error::NonFinite) and [`Error::Argument`](crate::Error::Argument)
/// for a matrix that is no Gram matrix.
pub fn orthogonality(gram: &ExtendedGram) -> Result<Orthogonality> {
    check(gram)?;
    let n = gram.n();
    let entry = |i: usize, j: usize| {
        let mut sum = TripleSum::default();
        sum.add_parts(gram.entry(i, j));
        sum.add(if i == j { -1.0 } else { 0.0 });
        sum
    };
    let entries = || (0..n).flat_map(move |j| (j..n).map(move |i| (i, j)));
    let max = entries().fold(0.0, |max: f64, (i, j)| max.max(entry(i, j).rounded().abs()));
    if max == 0.0 {
        return Ok(Orthogonality { max, frobenius: 0.0 });
    }
    // Scales the entries, so that squares are in range.
    let exponent = max.log2().floor() as i32;
    let sum = entries().fold(DoubleDouble::ZERO, |sum, (i, j)| {
        let value = entry(i, j).double().scaled(-exponent);
        let times = DoubleDouble::from(if i == j { 1.0 } else { 2.0 });
        sum + value * value * times
    });
    Ok(Orthogonality { max, frobenius: scaled(sum.sqrt().hi, exponent) })
}
