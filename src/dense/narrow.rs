//! Products of a tall matrix A with at most [`NARROW`] columns, both by columns: A is read once,
//! from where it lies. A general product packs A first, which takes as long as such a product.

use faer::prelude::ReborrowMut;
use faer::{MatMut, MatRef};
use pulp::{Simd, WithSimd};

use crate::base::arch;

/// Most columns of the narrow matrix.
const NARROW: usize = 16;

/// Rows of the narrow matrix that stay in the first-level cache while columns of A pass.
const ROWS: usize = 256;

/// Returns whether the functions of this module take A with `columns` columns beside it.
pub(super) fn serves(a: MatRef<'_, f64>, columns: MatRef<'_, f64>) -> bool {
    columns.ncols() <= NARROW && a.row_stride() == 1 && columns.row_stride() == 1
}

/// Adds `A^T B` to C, for A and B that [`serves`] accepts, on one thread.
pub(super) fn add_transposed(c: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    arch().dispatch(Transposed { c, a, b });
}

/// Computes `X := X - A B`, for A and X that [`serves`] accepts, on one thread.
pub(super) fn subtract(x: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    arch().dispatch(Subtraction { x, a, b });
}

struct Transposed<'a> {
    c: MatMut<'a, f64>,
    a: MatRef<'a, f64>,
    b: MatRef<'a, f64>,
}

impl WithSimd for Transposed<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { mut c, a, b } = self;
        for first in (0..a.nrows()).step_by(ROWS) {
            let height = ROWS.min(a.nrows() - first);
            let (a, b) = (a.subrows(first, height), b.subrows(first, height));
            for i in (0..a.ncols()).step_by(2) {
                for j in (0..b.ncols()).step_by(4) {
                    let dots = dots(simd, columns(a, i), columns(b, j));
                    for (i, dots) in (i..a.ncols()).zip(dots) {
                        (j..b.ncols()).zip(dots).for_each(|(j, dot)| c[(i, j)] += dot);
                    }
                }
            }
        }
    }
}

/// Returns the columns from `first` on; beyond the last one, the last one again.
#[inline(always)]
fn columns<const COUNT: usize>(x: MatRef<'_, f64>, first: usize) -> [&[f64]; COUNT] {
    std::array::from_fn(|k| column(x, (first + k).min(x.ncols() - 1)))
}

#[inline(always)]
fn column(x: MatRef<'_, f64>, j: usize) -> &[f64] {
    x.col(j).try_as_col_major().expect("accepted by `serves`").as_slice()
}

/// Returns all inner products of columns.
#[inline(always)]
fn dots<S: Simd>(simd: S, a: [&[f64]; 2], b: [&[f64]; 4]) -> [[f64; 4]; 2] {
    let (a, b) = (a.map(S::as_simd_f64s), b.map(S::as_simd_f64s));
    let [(a0, _), (a1, _)] = a;
    let [(b0, _), (b1, _), (b2, _), (b3, _)] = b;
    let mut sums = [[simd.splat_f64s(0.0); 4]; 2];
    for (((((&a0, &a1), &b0), &b1), &b2), &b3) in a0.iter().zip(a1).zip(b0).zip(b1).zip(b2).zip(b3)
    {
        for (sums, a) in sums.iter_mut().zip([a0, a1]) {
            for (sum, b) in sums.iter_mut().zip([b0, b1, b2, b3]) {
                *sum = simd.mul_add_e_f64s(a, b, *sum);
            }
        }
    }
    let mut dots = sums.map(|sums| sums.map(|sum| simd.reduce_sum_f64s(sum)));
    for (dots, (_, a)) in dots.iter_mut().zip(a) {
        for (dot, (_, b)) in dots.iter_mut().zip(b) {
            *dot += a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        }
    }
    dots
}

struct Subtraction<'a> {
    x: MatMut<'a, f64>,
    a: MatRef<'a, f64>,
    b: MatRef<'a, f64>,
}

impl WithSimd for Subtraction<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { mut x, a, b } = self;
        for first in (0..x.nrows()).step_by(ROWS) {
            let height = ROWS.min(x.nrows() - first);
            let a = a.subrows(first, height);
            let mut x = x.rb_mut().subrows_mut(first, height);
            for i in (0..a.ncols()).step_by(4) {
                let columns = columns::<4>(a, i);
                // A column that stands for one beyond the last has the factor 0.
                let factors = |j: usize| {
                    std::array::from_fn(|k| if i + k < a.ncols() { -b[(i + k, j)] } else { 0.0 })
                };
                for j in (0..b.ncols()).step_by(2) {
                    let pair = x.rb_mut().subcols_mut(j, 2.min(b.ncols() - j));
                    let (left, right) = pair.split_at_col_mut(1);
                    if right.ncols() == 0 {
                        add(simd, [into(left)], columns, [factors(j)]);
                    } else {
                        add(simd, [into(left), into(right)], columns, [factors(j), factors(j + 1)]);
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn into(x: MatMut<'_, f64>) -> &mut [f64] {
    x.col_mut(0).try_as_col_major_mut().expect("accepted by `serves`").as_slice_mut()
}

/// Adds to each of these columns X its combination of the columns of A.
#[inline(always)]
fn add<S: Simd, const COUNT: usize>(
    simd: S,
    x: [&mut [f64]; COUNT],
    a: [&[f64]; 4],
    factors: [[f64; 4]; COUNT],
) {
    let a = a.map(S::as_simd_f64s);
    let [(a0, _), (a1, _), (a2, _), (a3, _)] = a;
    let splat = factors.map(|factors| factors.map(|factor| simd.splat_f64s(factor)));
    let mut x = x.map(S::as_mut_simd_f64s);
    for (i, (((&a0, &a1), &a2), &a3)) in a0.iter().zip(a1).zip(a2).zip(a3).enumerate() {
        for ((x, _), factors) in x.iter_mut().zip(splat) {
            let mut sum = x[i];
            for (a, factor) in [a0, a1, a2, a3].into_iter().zip(factors) {
                sum = simd.mul_add_e_f64s(a, factor, sum);
            }
            x[i] = sum;
        }
    }
    for ((_, x), factors) in x.iter_mut().zip(factors) {
        for ((_, a), factor) in a.iter().zip(factors) {
            x.iter_mut().zip(*a).for_each(|(x, a)| *x += a * factor);
        }
    }
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::*;

    /// Returns small integers, whose products and sums are exact.
    fn integers(rows: usize, cols: usize, seed: usize) -> Mat<f64> {
        Mat::from_fn(rows, cols, |i, j| ((7 * i + 3 * j + seed) % 11) as f64 - 5.0)
    }

    fn each_shape(check: impl Fn(usize, usize, usize)) {
        for rows in [0, 1, 3, 8, 255, 256, 257, 601] {
            for columns in [1, 2, 3, 4, 5, 9] {
                (1..=NARROW).for_each(|narrow| check(rows, columns, narrow));
            }
        }
    }

    #[test]
    fn transposed_products_of_integers_are_exact() {
        each_shape(|rows, columns, narrow| {
            let (a, b) = (integers(rows, columns, 1), integers(rows, narrow, 5));
            let mut c = integers(columns, narrow, 2);
            let expected = &c + a.transpose() * &b;
            add_transposed(c.as_mut(), a.as_ref(), b.as_ref());
            assert_eq!(c, expected, "{rows} x {columns}, {narrow}");
        });
    }

    #[test]
    fn subtracted_products_of_integers_are_exact() {
        each_shape(|rows, columns, narrow| {
            let (a, b) = (integers(rows, columns, 1), integers(columns, narrow, 5));
            let mut x = integers(rows, narrow, 3);
            let expected = &x - &a * &b;
            subtract(x.as_mut(), a.as_ref(), b.as_ref());
            assert_eq!(x, expected, "{rows} x {columns}, {narrow}");
        });
    }

    #[test]
    fn columns_may_be_apart_and_rows_may_not() {
        let (whole, b) = (integers(40, 6, 1), integers(10, 2, 4));
        let a = whole.as_ref().submatrix(7, 1, 10, 3);
        assert!(serves(a, b.as_ref()));
        assert!(!serves(a.transpose(), b.as_ref()));
        assert!(!serves(a, integers(10, NARROW + 1, 0).as_ref()));
        let mut c = Mat::zeros(3, 2);
        add_transposed(c.as_mut(), a, b.as_ref());
        assert_eq!(c, a.transpose() * &b);
    }
}
