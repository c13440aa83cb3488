//! Checks whether the columns of the operands have similar norms.
//!
//! Errors of fast levels are relative to the largest columns of a block sum, those of classical
//! products to the two columns of an entry. Multiplying columns by powers of two, which is exact,
//! until all norms are alike makes the two bounds the same.

use faer::MatRef;

use crate::base::{Par, Real, widest};

/// How the norms of the columns of one operand, or of both, compare.
pub(super) enum Balance {
    /// They are alike: fast levels need no scales.
    Even,
    /// They differ, and are alike once column j is multiplied by `2^exponents[j]`. A column of
    /// zeros has no exponent: its products must be zero, which a fast level does not ensure.
    Uneven(Vec<Option<i32>>),
    /// A column is not finite. A fast level would spread it to other entries.
    NotFinite,
}

/// Norms count as alike when they differ by less than `2^ALIKE`.
const ALIKE: i32 = 2;

/// Rows of a block whose sums one thread computes.
const ROWS: usize = 1024;

impl Balance {
    /// Computes the balance of the columns of `a`.
    pub fn of<T: Real>(a: MatRef<'_, T>, par: Par) -> Self {
        let Some(norms) = norm_exponents(a, par) else { return Self::NotFinite };
        // A missing exponent, that of a column of zeros, is less than all others.
        match (norms.iter().min(), norms.iter().max()) {
            (Some(&Some(least)), Some(&Some(most))) if most - least < ALIKE => Self::Even,
            (None, _) | (_, None) => Self::Even,
            _ => {
                // The scale must be a number of T, and its inverse too.
                let (least, most) = if size_of::<T>() == 8 { (-1022, 1023) } else { (-126, 127) };
                let scale = |norm: Option<i32>| norm.map(|norm| (-norm).clamp(least, most));
                Self::Uneven(norms.into_iter().map(scale).collect())
            }
        }
    }
}

/// Returns the exponent e of each column's Euclidean norm, `2^e <= norm < 2^(e + 1)` up to
/// rounding; `None` for a column of zeros. Returns `None` when a column is not finite.
fn norm_exponents<T: Real>(a: MatRef<'_, T>, par: Par) -> Option<Vec<Option<i32>>> {
    /// Squares that are neither lost below nor above the range.
    const SAFE: std::ops::Range<f64> = 1e-280..1e280;
    let exponent = |square: f64| (0.5 * square.log2()).floor() as i32;
    let squares = sums_of_squares(a, par);
    let of_column = |(j, square): (usize, f64)| {
        if SAFE.contains(&square) {
            return Some(Some(exponent(square)));
        }
        let entries = || (0..a.nrows()).map(|i| a[(i, j)].to_f64().abs());
        // A maximum drops NaN, but the sum does not.
        let largest = entries().fold(0.0, f64::max);
        match largest {
            0.0 if square == 0.0 => Some(None),
            _ if square.is_nan() || largest.is_infinite() => None,
            _ => {
                let unit = largest.log2().floor();
                // In two steps, because one power may be out of range.
                let half = (-unit / 2.0).floor();
                let scale = |x: f64| x * half.exp2() * (-unit - half).exp2();
                let square = entries().map(scale).map(|x| x * x).sum::<f64>();
                Some(Some(unit as i32 + exponent(square)))
            }
        }
    };
    squares.into_iter().enumerate().map(of_column).collect()
}

/// Returns the sum of the squares of each column, in f64.
fn sums_of_squares<T: Real>(a: MatRef<'_, T>, par: Par) -> Vec<f64> {
    let (m, n) = a.shape();
    let by_columns = a.row_stride() == 1;
    let parts = par.map_blocks(m, ROWS, |rows| {
        let mut sums = vec![0.0; n];
        widest(
            #[inline(always)]
            || {
                if by_columns {
                    for (j, sum) in sums.iter_mut().enumerate() {
                        *sum = column_square(a, rows.clone(), j);
                    }
                } else {
                    for i in rows {
                        let row = a.row(i);
                        for (sum, x) in sums.iter_mut().zip(row.iter()) {
                            let x = x.to_f64();
                            *sum += x * x;
                        }
                    }
                }
            },
        );
        sums
    });
    let mut sums = vec![0.0; n];
    // In the order of the blocks, not of the threads that computed them.
    for part in parts {
        for (sum, part) in sums.iter_mut().zip(part) {
            *sum += part;
        }
    }
    sums
}

/// Returns the sum of the squares of `a[rows, j]`, whose column is contiguous, in eight partial
/// sums that a vector register holds.
#[inline(always)]
fn column_square<T: Real>(a: MatRef<'_, T>, rows: std::ops::Range<usize>, j: usize) -> f64 {
    const SUMS: usize = 8;
    let column = a.subrows(rows.start, rows.len()).col(j);
    let Some(column) = column.try_as_col_major() else { return 0.0 };
    let mut sums = [0.0; SUMS];
    let mut chunks = column.as_slice().chunks_exact(SUMS);
    for chunk in chunks.by_ref() {
        for (sum, x) in sums.iter_mut().zip(chunk) {
            let x = x.to_f64();
            *sum += x * x;
        }
    }
    for (sum, x) in sums.iter_mut().zip(chunks.remainder()) {
        let x = x.to_f64();
        *sum += x * x;
    }
    sums.iter().sum()
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::*;
    use crate::base::Rng;

    fn exponents(a: &Mat<f64>) -> Option<Vec<Option<i32>>> {
        let found = norm_exponents(a.as_ref(), Par::Seq);
        let rows = a.transpose().to_owned();
        for par in [Par::Seq, Par::Threads(3)] {
            assert_eq!(norm_exponents(rows.as_ref().transpose(), par), found);
        }
        found
    }

    #[test]
    fn exponents_are_those_of_the_norms_over_the_whole_range() {
        let mut rng = Rng::new(1);
        for m in [1, 7, 8, 1023, 2500] {
            let base: Vec<f64> = (0..m).map(|_| rng.uniform() + 0.5).collect();
            let norm = base.iter().map(|x| x * x).sum::<f64>().sqrt();
            let powers = [0, -3, 300, 900, 1000, -300, -500, -1000, -1030];
            let a = Mat::from_fn(m, powers.len(), |i, j| {
                base[i] * 2_f64.powi(powers[j] / 2) * 2_f64.powi(powers[j] - powers[j] / 2)
            });
            for (found, power) in exponents(&a).unwrap().into_iter().zip(powers) {
                let wanted = power + norm.log2().floor() as i32;
                assert!((found.unwrap() - wanted).abs() <= 1, "{found:?}, {wanted}, {m} rows");
            }
        }
    }

    #[test]
    fn zero_columns_have_no_exponent_and_columns_that_are_not_finite_refuse_all() {
        let mut a = Mat::from_fn(30, 3, |i, j| if j == 1 { 0.0 } else { i as f64 });
        assert_eq!(exponents(&a).unwrap()[1], None);
        assert!(matches!(Balance::of(a.as_ref(), Par::Seq), Balance::Uneven(_)));
        assert!(matches!(Balance::of(a.as_ref().subcols(0, 1), Par::Seq), Balance::Even));
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            a[(17, 2)] = bad;
            assert_eq!(exponents(&a), None);
        }
        assert_eq!(exponents(&Mat::zeros(0, 2)), Some(vec![None; 2]));
    }

    #[test]
    fn scales_bring_norms_together() {
        let a = Mat::from_fn(64, 5, |i, j| (1 + i % 3) as f64 * 10_f64.powi(-60 * j as i32));
        let Balance::Uneven(scales) = Balance::of(a.as_ref(), Par::Seq) else { panic!("uneven") };
        for (j, scale) in scales.into_iter().enumerate() {
            let scale = 2_f64.powi(scale.unwrap());
            let norm = (0..64).map(|i| (a[(i, j)] * scale).powi(2)).sum::<f64>().sqrt();
            assert!((0.99..2.01).contains(&norm), "{norm}");
        }
    }
}
