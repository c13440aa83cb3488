//! The singular value decomposition of a triangular factor by one-sided Jacobi rotations (Hestenes
//! 1958; Demmel and Veselic 1992; Drmac and Veselic 2008). Columns keep their exponents separately:
//! their squares, and those of the results, need not be in the range of f64.

use faer::Mat;

use super::double::scaled;
use crate::base::{Error, Par, Result, widest, zeros};

/// Columns of a block: two blocks of some thousand rows stay in the second-level cache.
const BLOCK: usize = 16;

/// Largest number of sweeps over all pairs of columns; eight or so are enough.
const SWEEPS: usize = 60;

/// Partial sums of a scalar product: enough for compilers to vectorize the loop. The lengths of
/// columns are multiples of this number.
const SUMS: usize = 64;

/// Singular values (descending) and left singular vectors of a matrix: `Y = U diag(values) W^T`.
pub(super) struct Jacobi {
    pub values: Vec<f64>,
    /// n x r, orthonormal columns.
    pub vectors: Mat<f64>,
}

/// Decomposes a matrix (n x r, r <= n) of full column rank, whose column j is that of `y` times
/// `2^exponents[j]`. The matrix should be the transpose of the R of a factorization with pivoting:
/// its columns are then graded, rotations converge in few sweeps, and the relative error even of
/// the smallest value is about r 2^-53 times the condition number of R with rows of norm 1.
///
/// Blocks of columns meet in rounds of disjoint pairs (Brent and Luk 1985), so that the result is
/// the same, bit for bit, for every `par`.
pub(super) fn jacobi(y: &Mat<f64>, exponents: &[i32], par: Par) -> Result<Jacobi> {
    let (n, r) = y.shape();
    let stride = n.next_multiple_of(SUMS);
    let mut columns = zeros(stride.saturating_mul(r))?;
    let mut exponents = exponents.to_vec();
    for (j, exponent) in exponents.iter_mut().enumerate() {
        let largest = y.col(j).norm_max();
        let own = if largest > 0.0 { largest.log2() as i32 } else { 0 };
        for i in 0..n {
            columns[j * stride + i] = scaled(y[(i, j)], -own);
        }
        *exponent += own;
    }
    if n > 0 {
        rotate(&mut columns, &mut exponents, stride, par)?;
    }
    let column = |j: usize| &columns[j * stride..(j + 1) * stride];
    let norm = |j: usize| product(column(j), column(j)).sqrt();
    let norms: Vec<f64> = (0..r).map(norm).collect();
    let values: Vec<f64> = norms.iter().zip(&exponents).map(|(&x, &e)| scaled(x, e)).collect();
    let mut order: Vec<usize> = (0..r).collect();
    order.sort_by(|&a, &b| values[b].total_cmp(&values[a]));
    let mut vectors = crate::dense::zeros(n, r)?;
    for (to, &from) in order.iter().enumerate() {
        for i in 0..n {
            vectors[(i, to)] = column(from)[i] / norms[from];
        }
    }
    let values = order.iter().map(|&j| values[j]).collect();
    Ok(Jacobi { values, vectors })
}

/// Rotates pairs of columns of length `n`, a multiple of [`SUMS`], until all are orthogonal.
fn rotate(columns: &mut [f64], exponents: &mut [i32], n: usize, par: Par) -> Result<()> {
    // Rounded up to an even number: the additional block stands for no columns.
    let blocks = columns.len().div_ceil(BLOCK * n);
    let even = blocks.next_multiple_of(2);
    let limit = f64::EPSILON * (n as f64).sqrt().max(8.0);
    let mut squares = zeros(columns.len() / n)?;
    for _ in 0..SWEEPS {
        let mut largest = 0.0_f64;
        for round in 0..even.saturating_sub(1).max(1) {
            let of_columns = squares.chunks_mut(BLOCK).zip(exponents.chunks_mut(BLOCK));
            let blocks = columns.chunks_mut(BLOCK * n).zip(of_columns);
            let mut free: Vec<_> = blocks
                .map(|(columns, (squares, exponents))| {
                    Some(ColumnBlock { columns, squares, exponents })
                })
                .collect();
            let mut meetings: Vec<_> = pairs(even, round)
                .map(|(a, b)| {
                    let mut take = |i: usize| free.get_mut(i).and_then(Option::take);
                    let (a, b) = (take(a).unwrap_or_default(), take(b).unwrap_or_default());
                    (a, b, 0.0)
                })
                .collect();
            // Each pair of two blocks takes a product and perhaps a rotation.
            let operations = (8 * n * BLOCK * BLOCK) as f64;
            let par = par.at_most(meetings.len());
            par.for_each_asking(meetings.iter_mut(), operations, |_, (a, b, found)| {
                widest(
                    #[inline(always)]
                    || *found = meet(a, b, n, limit, round == 0),
                );
            })?;
            largest = meetings.iter().fold(largest, |largest, m| largest.max(m.2));
        }
        if largest <= limit {
            return Ok(());
        }
    }
    Err(Error::NotConverged { iterations: SWEEPS, residual: limit })
}

/// Returns the pairs of round `round` of a tournament of an even number of players.
fn pairs(even: usize, round: usize) -> impl Iterator<Item = (usize, usize)> {
    // The last player stays, the others go round a circle.
    let others = even.max(2) - 1;
    let seat = move |i: usize| (i + round) % others;
    std::iter::once((seat(0), others)).chain((1..even.max(2) / 2).map(move |i| {
        let (a, b) = (seat(i), seat(others - i));
        (a.min(b), a.max(b))
    }))
}

/// Some columns, one after another, and their squares, which rotations keep up to date. The actual
/// columns are these times 2 to the power of their exponents.
#[derive(Default)]
struct ColumnBlock<'c> {
    columns: &'c mut [f64],
    squares: &'c mut [f64],
    exponents: &'c mut [i32],
}

/// A column of a [`ColumnBlock`].
struct Column<'c> {
    x: &'c mut [f64],
    square: &'c mut f64,
    exponent: &'c mut i32,
}

impl ColumnBlock<'_> {
    /// Returns the columns, which have length `n`.
    #[inline(always)]
    fn columns(&mut self, n: usize) -> impl Iterator<Item = Column<'_>> {
        let of_columns = self.squares.iter_mut().zip(&mut *self.exponents);
        self.columns.chunks_exact_mut(n).zip(of_columns).map(|(x, (square, exponent))| Column {
            x,
            square,
            exponent,
        })
    }
}

/// Rotates each column of `a` against each of `b`. With `first`, which is set once per block and
/// sweep, squares are computed anew and columns of the same block are rotated too. Returns the
/// largest cosine that was found.
#[inline(always)]
fn meet<'c>(
    a: &mut ColumnBlock<'c>,
    b: &mut ColumnBlock<'c>,
    n: usize,
    limit: f64,
    first: bool,
) -> f64 {
    let mut largest = 0.0_f64;
    if first {
        for block in [&mut *a, &mut *b] {
            let mut columns: Vec<_> = block.columns(n).collect();
            for column in &mut columns {
                *column.square = product(column.x, column.x);
            }
            for i in 1..columns.len() {
                let (before, others) = columns.split_at_mut(i);
                for other in others {
                    largest = largest.max(rotate_pair(&mut before[i - 1], other, limit));
                }
            }
        }
    }
    for mut x in a.columns(n) {
        for mut y in b.columns(n) {
            largest = largest.max(rotate_pair(&mut x, &mut y, limit));
        }
    }
    largest
}

/// Makes two columns orthogonal, the longer one first, unless the cosine of their angle is below
/// the limit. Returns the cosine.
#[inline(always)]
fn rotate_pair(x: &mut Column<'_>, y: &mut Column<'_>, limit: f64) -> f64 {
    /// A square that gets smaller than this share of itself has lost digits.
    const SHARE: f64 = 1.0 / 16.0;
    let size = x.square.sqrt() * y.square.sqrt();
    if size == 0.0 {
        return 0.0;
    }
    let xy = product(x.x, y.x);
    let cosine = xy.abs() / size;
    if cosine <= limit {
        return cosine;
    }
    // Columns change places where the second one is the longer one, or becomes it.
    let shift = *y.exponent - *x.exponent;
    let keep = *x.square > scaled(*y.square, 2 * shift);
    let (longer, shorter) = if keep { (&*x, &*y) } else { (&*y, &*x) };
    // With r = 2^(exponent of the shorter one less that of the longer one) and the tangent t, the
    // longer one becomes cos (l - t r s) and the shorter one cos (s + (t / r) l). Both t / r and r
    // may underflow to zero, but they do not overflow.
    let r = scaled(1.0, *shorter.exponent - *longer.exponent);
    let slope = (*shorter.square * r * r - *longer.square) / (2.0 * xy);
    let tangent = slope.signum() / (slope.abs() + slope.hypot(r));
    let cos = (tangent * r).hypot(1.0).recip();
    let sin = cos * tangent;
    // The square of one column gains what that of the other loses.
    let moved = (tangent * xy).abs();
    let squares = (*longer.square + moved * r * r, *shorter.square - moved);
    let reliable = squares.1 > SHARE * *shorter.square;
    let back = sin * r * r;
    let rows = if keep { [[cos, -back], [sin, cos]] } else { [[-back, cos], [cos, sin]] };
    for (x, y) in x.x.iter_mut().zip(&mut *y.x) {
        let (was_x, was_y) = (*x, *y);
        *x = rows[0][0] * was_x + rows[0][1] * was_y;
        *y = rows[1][0] * was_x + rows[1][1] * was_y;
    }
    if !keep {
        std::mem::swap(&mut *x.exponent, &mut *y.exponent);
    }
    *x.square = squares.0;
    *y.square = if reliable { squares.1 } else { product(y.x, y.x) };
    cosine
}

/// Returns `x^T y`.
#[inline(always)]
fn product(x: &[f64], y: &[f64]) -> f64 {
    let mut sums = [0.0; SUMS];
    for (x, y) in x.chunks_exact(SUMS).zip(y.chunks_exact(SUMS)) {
        for i in 0..SUMS {
            sums[i] += x[i] * y[i];
        }
    }
    let mut half = SUMS / 2;
    while half > 0 {
        let (low, high) = sums.split_at_mut(half);
        low.iter_mut().zip(high).for_each(|(low, high)| *low += *high);
        half /= 2;
    }
    sums[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Rng;

    #[test]
    fn every_pair_of_blocks_meets_once() {
        for even in [2, 4, 8, 14] {
            let mut met = std::collections::BTreeSet::new();
            for round in 0..even - 1 {
                let mut players: Vec<_> = pairs(even, round).flat_map(|(a, b)| [a, b]).collect();
                players.sort_unstable();
                assert_eq!(players, (0..even).collect::<Vec<_>>());
                met.extend(pairs(even, round));
            }
            assert_eq!(met.len(), even * (even - 1) / 2);
        }
    }

    #[test]
    fn values_and_vectors_give_y_y_t_back_for_any_number_of_threads() {
        let mut rng = Rng::new(1);
        for (n, r) in [(0, 0), (1, 1), (5, 3), (37, 37), (71, 53)] {
            let y = Mat::from_fn(n, r, |i, j| if i >= j { rng.normal() } else { 0.0 });
            let found = jacobi(&y, &vec![0; r], Par::Seq).unwrap();
            let two = jacobi(&y, &vec![0; r], Par::Threads(3)).unwrap();
            assert_eq!((&found.values, &found.vectors), (&two.values, &two.vectors));
            assert!(found.values.is_sorted_by(|a, b| a >= b));
            let us = Mat::from_fn(n, r, |i, j| found.vectors[(i, j)] * found.values[j]);
            assert!((&us * us.transpose() - &y * y.transpose()).norm_max() < 1e-12);
            let identity = Mat::<f64>::identity(r, r);
            assert!((found.vectors.transpose() * &found.vectors - identity).norm_max() < 1e-13);
        }
    }
}
