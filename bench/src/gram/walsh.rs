//! Tall matrices with exactly known singular values, although their entries are f64.

use std::path::Path;

use catamaran::faer::Mat;
use catamaran::io::{Output, Overwrite, write};

use crate::Result;

/// Number of columns that are mixed with each other.
const BLOCK: usize = 16;

/// `A = W D V^T + 1 mean^T`: the columns of W are distinct columns of a Walsh-Hadamard matrix, D is
/// diagonal, and V has a normalized Hadamard matrix of side 16 in each diagonal block.
///
/// The entries of W and V are +-1 and +-1/4, their columns are orthogonal, and those of W have the
/// norm `sqrt(rows)`. Therefore the singular values of A without a mean are `sqrt(rows) d_k`, and
/// where all d_k are powers of two no smaller than 2^-52 no entry of A is rounded. The columns of W
/// sum to zero, so that a mean does not change the covariance.
#[derive(Debug, Clone)]
pub struct WalshMatrix {
    /// Number of rows: a power of 4, so that the norm of the columns of W is a power of 2; more
    /// than the number of columns.
    pub rows: usize,
    /// Number of columns: a multiple of 16.
    pub columns: usize,
    /// The diagonal of D, which falls geometrically from 1.
    diagonal: Vec<f64>,
    /// The mean, which is added to each entry.
    mean: f64,
}

impl WalshMatrix {
    /// Creates a matrix with d_k from 1 to 2^-bits, all powers of two, and no mean: no entry is
    /// rounded. The condition number is 2^bits.
    pub fn exact(rows: usize, columns: usize, bits: i32) -> Self {
        let steps = columns.saturating_sub(1).max(1) as f64;
        let power = |k: usize| -(k as f64 * f64::from(bits) / steps).round() as i32;
        let diagonal = (0..columns).map(|k| 2.0_f64.powi(power(k))).collect();
        Self { rows, columns, diagonal, mean: 0.0 }
    }

    /// Creates a matrix with d_k from 1 to 2^-bits that are no powers of two: entries are rounded
    /// to 53 bits. The resulting relative errors of the singular values are at most about
    /// `(1 + mean) 2^bits 2^-53`.
    pub fn rounded(rows: usize, columns: usize, bits: i32, mean: f64) -> Self {
        let steps = columns.saturating_sub(1).max(1) as f64;
        let value = |k: usize| 2.0_f64.powf(-f64::from(bits) * k as f64 / steps);
        Self { rows, columns, diagonal: (0..columns).map(value).collect(), mean }
    }

    /// Returns the singular values without the mean, the largest first.
    pub fn singular_values(&self) -> Vec<f64> {
        let norm = (self.rows as f64).sqrt();
        self.diagonal.iter().map(|d| norm * d).collect()
    }

    /// Returns the eigenvalues of the covariance matrix (over rows - 1), the largest first.
    pub fn variances(&self) -> Vec<f64> {
        let m = self.rows as f64;
        self.diagonal.iter().map(|d| d * d * (m / (m - 1.0))).collect()
    }

    /// Computes row i.
    fn row(&self, i: usize, out: &mut [f64]) {
        let blocks = self.columns / BLOCK;
        for block in 0..blocks {
            let mut values = [0.0; BLOCK];
            for (s, value) in values.iter_mut().enumerate() {
                // Each block has large and small singular values, so that no scaling of columns
                // separates them.
                let k = s * blocks + block;
                *value = walsh_sign(i, walsh_index(k, self.rows)) * self.diagonal[k] / 4.0;
            }
            hadamard(&mut values);
            for (x, value) in out[block * BLOCK..].iter_mut().zip(values) {
                *x = self.mean + value;
            }
        }
    }

    /// Returns the whole matrix.
    ///
    /// # Errors
    /// When the shape is invalid for a Walsh matrix.
    pub fn matrix(&self) -> Result<Mat<f64>> {
        let (m, n) = (self.rows, self.columns);
        let fits = m.is_power_of_two() && m.trailing_zeros().is_multiple_of(2) && m > n;
        if !fits || !n.is_multiple_of(BLOCK) {
            return Err(format!("{m} x {n}: invalid shape of a Walsh matrix").into());
        }
        let mut transposed = Mat::zeros(n, m);
        let mut row = vec![0.0; n];
        for i in 0..m {
            self.row(i, &mut row);
            transposed.col_mut(i).iter_mut().zip(&row).for_each(|(x, value)| *x = *value);
        }
        Ok(transposed)
    }

    /// Writes the matrix as `a.npy` of a folder.
    ///
    /// # Errors
    /// As [`WalshMatrix::matrix`], and the errors of the file.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let output = Output::create(&folder.join("a.npy"), Overwrite::Replace)?;
        Ok(write(output, self.matrix()?.transpose())?)
    }
}

/// Returns the index of the k-th column of W among those of the Walsh matrix of side `rows`.
/// Multiplication by an odd number permutes the columns and spreads the selected ones, so that few
/// rows are equal; the first column, which does not sum to zero, is left out.
fn walsh_index(k: usize, rows: usize) -> usize {
    ((k + 1) * 0x9e37_79b1) % rows
}

/// Returns entry (i, j) of the Walsh-Hadamard matrix.
fn walsh_sign(i: usize, j: usize) -> f64 {
    if (i & j).count_ones().is_multiple_of(2) { 1.0 } else { -1.0 }
}

/// Multiplies by the Hadamard matrix of side 16, with entries +-1.
fn hadamard(values: &mut [f64; BLOCK]) {
    let mut half = 1;
    while half < BLOCK {
        for start in (0..BLOCK).step_by(2 * half) {
            for i in start..start + half {
                let (x, y) = (values[i], values[i + half]);
                (values[i], values[i + half]) = (x + y, x - y);
            }
        }
        half *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Computes in integers of 2^-54, without rounding: the Gram matrix is V D^2 V^T times the
    /// number of rows.
    #[test]
    fn gram_matrix_is_what_the_singular_values_say_exactly() {
        let walsh = WalshMatrix::exact(1024, 32, 50);
        let a = walsh.matrix().unwrap();
        let unit = 2.0_f64.powi(54);
        let integer = |x: f64| {
            let scaled = x * unit;
            assert_eq!(scaled, scaled.trunc());
            scaled as i128
        };
        let sign = |i: usize, j: usize| if (i & j).count_ones().is_multiple_of(2) { 1 } else { -1 };
        for (i, j) in [(0, 0), (0, 5), (3, 3), (15, 2), (31, 16), (20, 20), (31, 31), (0, 16)] {
            let entry: i128 = (0..1024).map(|r| integer(a[(i, r)]) * integer(a[(j, r)])).sum();
            let known: i128 = (0..16)
                .map(|s| {
                    let d = integer(walsh.diagonal[2 * s + i / 16] / 4.0);
                    sign(i % 16, s) * sign(j % 16, s) * d * d * 1024
                })
                .sum();
            assert_eq!(entry, if i / 16 == j / 16 { known } else { 0 }, "({i}, {j})");
        }
    }

    #[test]
    fn singular_values_and_condition_are_as_asked_for() {
        let walsh = WalshMatrix::exact(1024, 48, 40);
        let values = walsh.singular_values();
        assert_eq!(values[0] / values[47], 2.0_f64.powi(40));
        assert_eq!(values[0], 32.0);
        assert!(values.is_sorted_by(|x, y| x >= y));
    }

    #[test]
    fn columns_of_a_rounded_one_have_the_mean_and_the_variances() {
        let walsh = WalshMatrix::rounded(1024, 16, 7, 3.0);
        let a = walsh.matrix().unwrap();
        let mut trace = 0.0;
        for column in 0..16 {
            let entries: Vec<f64> = (0..1024).map(|r| a[(column, r)]).collect();
            let mean = entries.iter().sum::<f64>() / 1024.0;
            assert!((mean - 3.0).abs() < 1e-14);
            trace += entries.iter().map(|x| (x - 3.0).powi(2)).sum::<f64>() / 1023.0;
        }
        let known: f64 = walsh.variances().iter().sum();
        assert!((trace - known).abs() < 1e-13 * known);
    }

    #[test]
    fn impossible_shapes_are_errors() {
        for (m, n) in [(1000, 16), (512, 16), (16, 16), (1024, 20)] {
            assert!(WalshMatrix::exact(m, n, 10).matrix().is_err(), "{m} x {n}");
        }
    }
}
