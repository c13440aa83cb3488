use faer::prelude::ReborrowMut;
use faer::{Mat, MatMut, MatRef};

use super::gram_schmidt::{
    GramSchmidtOptions, Orthonormal, TriangularFactor, gram_schmidt, gram_schmidt_in_place,
};
use crate::base::{Progress, Result};
use crate::dense::{multiply_in_place, pivots, right_singular, transposed_product};
use crate::sparse::Mass;

/// Threshold of Gram-Schmidt before the rank is known: relative to the threshold of the options,
/// and at least `FINEST`.
const FINER: f64 = 1e-3;
const FINEST: f64 = 1e-13;

/// Computes an M-orthonormal basis of as many columns of A (n x c, any strides) as its numerical
/// rank: the number of singular values above `options.threshold` times the largest, in the inner
/// product of M, all columns scaled to length 1.
///
/// [`gram_schmidt`] keeps every column with a component outside the span of the columns before it.
/// Where singular values decay slowly, many more columns than the rank are kept, each nearly
/// dependent on all others together. Here the R of [`gram_schmidt`], whose singular values are
/// those of A, gives the rank r; the columns kept are the first r that QR with column pivoting
/// takes of the r leading right singular vectors, as rows (Golub, Klema and Stewart 1976), in their
/// own order. `A[:, kept] = Q R[:, kept]` up to the threshold, R a triangle there, and Q R is the
/// rest of A up to about the threshold times the largest singular value.
///
/// The result is the same, bit for bit, for every `options.par`; it is always re-orthogonalized.
/// Beyond [`gram_schmidt`], it computes the singular values and vectors of R on one thread, and
/// holds a few matrices of the size of R.
///
/// ```
/// use catamaran::{prelude::*, ortho::rank_revealing, sparse::Mass};
///
/// // The second column is twice the first.
/// let a = Mat::<f64>::from_fn(5, 3, |i, j| [1.0, 2.0, i as f64][j]);
/// let found = rank_revealing(a.as_ref(), &Mass::identity(5), &GramSchmidtOptions::new())?;
/// assert_eq!(found.q.ncols(), 2);
/// assert!((found.q.transpose() * &found.q - Mat::<f64>::identity(2, 2)).norm_max() < 1e-14);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`gram_schmidt`]; [`Error::NotConverged`](crate::Error::NotConverged) when the singular
/// values can't be found.
pub fn rank_revealing(
    a: MatRef<'_, f64>,
    mass: &Mass,
    options: &GramSchmidtOptions<'_>,
) -> Result<Orthonormal> {
    Orthonormal::of(a, |q| rank_revealing_in_place(q, mass, options))
}

/// Computes [`rank_revealing`] in the memory of A. Afterwards the first `kept.len()` columns are Q,
/// and the other columns are unspecified.
///
/// ```
/// use catamaran::{ortho::rank_revealing_in_place, prelude::*, sparse::Mass};
///
/// // The second column is twice the first.
/// let a = Mat::<f64>::from_fn(5, 3, |i, j| [1.0, 2.0, i as f64][j]);
/// let mut q = a.clone();
/// let options = GramSchmidtOptions::new();
/// let found = rank_revealing_in_place(q.as_mut(), &Mass::identity(5), &options)?;
/// let q = q.subcols(0, found.kept.len());
/// assert_eq!(q.ncols(), 2);
/// assert!((q * &found.r - &a).norm_max() < 1e-13);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`rank_revealing`]; A is unspecified after an error.
pub fn rank_revealing_in_place(
    mut a: MatMut<'_, f64>,
    mass: &Mass,
    options: &GramSchmidtOptions<'_>,
) -> Result<TriangularFactor> {
    options.check()?;
    let finer = GramSchmidtOptions {
        threshold: (FINER * options.threshold).max(FINEST),
        reorthogonalize: true,
        ..options.clone()
    };
    let found = gram_schmidt_in_place(a.rb_mut(), mass, &finer)?;
    let mut scaled = found.r.clone();
    for column in scaled.col_iter_mut() {
        let length = column.norm_l2();
        if length > 0.0 {
            column.iter_mut().for_each(|x| *x /= length);
        }
    }
    let (values, vectors) = right_singular(scaled.as_ref())?;
    let largest = values.first().copied().unwrap_or(0.0);
    let rank = values.iter().filter(|value| **value > options.threshold * largest).count();
    if rank == found.kept.len() {
        return Ok(found);
    }
    // Only the columns that were kept: R represents them to rounding.
    let leading = Mat::from_fn(rank, found.kept.len(), |i, j| vectors[(found.kept[j], i)]);
    let mut kept: Vec<usize> =
        pivots(leading.as_ref())?.into_iter().map(|j| found.kept[j]).take(rank).collect();
    kept.sort_unstable();
    let chosen = Mat::from_fn(found.kept.len(), rank, |i, j| found.r[(i, kept[j])]);
    let finest = GramSchmidtOptions { threshold: FINEST, progress: Progress::none(), ..finer };
    let turn = gram_schmidt(chosen.as_ref(), &Mass::identity(chosen.nrows()), &finest)?;
    // The columns that pivoting takes first are independent, far above rounding, so all of them
    // stay.
    let kept: Vec<usize> = turn.kept.iter().map(|&j| kept[j]).collect();
    multiply_in_place(a.subcols_mut(0, found.kept.len()), turn.q.as_ref(), options.par)?;
    let mut r = transposed_product(turn.q.as_ref(), found.r.as_ref(), options.par)?;
    for (j, &column) in kept.iter().enumerate() {
        // The entries below the diagonal are rounding errors.
        (j + 1..r.nrows()).for_each(|i| r[(i, column)] = 0.0);
    }
    Ok(TriangularFactor { r, kept })
}
