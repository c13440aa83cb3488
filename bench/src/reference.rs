//! The reference result: entries of a product in double-double, and the errors of a result.

use catamaran::Real;
use catamaran::base::Rng;
use rayon::prelude::*;

use crate::double::DoubleDouble;
use crate::input::Shape;
use crate::product::{Operation, Product};

/// Entries of C, and their positions.
pub struct Reference {
    entries: Vec<(usize, usize)>,
    values: Vec<DoubleDouble>,
    /// Euclidean norms of the columns of A.
    left_norms: Vec<f64>,
    /// Euclidean norms of the columns of B.
    right_norms: Vec<f64>,
    n: usize,
    /// Relative error above which a result is wrong, not inaccurate.
    tolerance: f64,
}

/// The error of an entry of C.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EntryError {
    /// Its row.
    pub row: usize,
    /// Its column.
    pub column: usize,
    /// The error, relative to a scale.
    pub error: f64,
}

/// Largest number of products for all entries; the entries of a larger C are sampled.
const MOST_PRODUCTS: usize = 1_000_000_000;
/// Largest number of entries that are computed in one pass through A and B: their sums fit the
/// second-level cache.
const PIECE: usize = 16_384;

impl Reference {
    /// Creates the reference for `product`: all entries, or at most `sample` random ones where all
    /// would be too many.
    pub fn new<T: Real>(product: &Product<'_, T>, sample: usize, seed: u64) -> Self {
        let shape = product.shape();
        let entries = entries(product.operation(), shape, sample, seed);
        let [a, b] = product.operands();
        let piece = entries.len().div_ceil(rayon::current_num_threads()).clamp(1, PIECE);
        let values =
            entries.par_chunks(piece).flat_map_iter(|piece| dots(a, b, shape.n, piece)).collect();
        let left_norms = column_norms(a, shape.n);
        let right_norms = match product.operation() {
            Operation::Syrk => left_norms.clone(),
            Operation::Gemm => column_norms(b, shape.n),
        };
        let tolerance = (shape.m as f64).max(32.0) * T::UNIT_ROUNDOFF;
        Self { entries, values, left_norms, right_norms, n: shape.n, tolerance }
    }

    /// Fills a result with values that show up if they are not overwritten.
    pub fn poison<T: Real>(&self, c: &mut [T]) {
        for &(i, j) in &self.entries {
            c[i * self.n + j] = T::from_f64(f64::NAN);
        }
    }

    /// Returns `max |C - C_ref|` over the entries, relative to the largest norms of a column of A
    /// and of B; for A^T A this is relative to the largest entry of C. C is n x n, row-major.
    ///
    /// # Errors
    /// When the error is larger than any rounding error.
    pub fn check<T: Real>(&self, c: &[T]) -> Result<f64, String> {
        let largest = |norms: &[f64]| norms.iter().copied().fold(0.0, f64::max);
        let scale = largest(&self.left_norms) * largest(&self.right_norms);
        self.errors(c, |_, _| scale).try_fold(0.0, |worst, entry| Ok(entry?.error.max(worst)))
    }

    /// Returns `|C_ij - C_ref_ij| / (|a_i| |b_j|)` for every entry; C is n x n, row-major.
    ///
    /// # Errors
    /// When an error is larger than any rounding error.
    pub fn entry_errors<T: Real>(&self, c: &[T]) -> Result<Vec<EntryError>, String> {
        self.errors(c, |i, j| self.left_norms[i] * self.right_norms[j]).collect()
    }

    fn errors<T: Real>(
        &self,
        c: &[T],
        scale: impl Fn(usize, usize) -> f64,
    ) -> impl Iterator<Item = Result<EntryError, String>> {
        self.entries.iter().zip(&self.values).map(move |(&(row, column), value)| {
            let computed = c[row * self.n + column];
            let distance = value.distance_from(computed.to_f64()).abs();
            // Columns of zeros have exact products.
            let error = if distance == 0.0 { 0.0 } else { distance / scale(row, column) };
            if error <= self.tolerance {
                return Ok(EntryError { row, column, error });
            }
            let right = value.to_f64();
            Err(format!("wrong result: C[{row}, {column}] = {computed}, should be {right}"))
        })
    }
}

fn entries(
    operation: Operation,
    Shape { m, n }: Shape,
    sample: usize,
    seed: u64,
) -> Vec<(usize, usize)> {
    let end = |i: usize| if operation == Operation::Syrk { i + 1 } else { n };
    if operation.entries(n).saturating_mul(m) <= MOST_PRODUCTS {
        return (0..n).flat_map(|i| (0..end(i)).map(move |j| (i, j))).collect();
    }
    let mut rng = Rng::new(seed);
    let mut index = || (rng.uniform() * n as f64) as usize;
    (0..sample.min(MOST_PRODUCTS / m).max(1))
        .map(|s| {
            let (i, j) = (index(), index());
            match operation {
                // Every eighth entry is on the diagonal, where the largest entries are.
                Operation::Syrk if s % 8 == 0 => (i, i),
                Operation::Syrk => (i.max(j), i.min(j)),
                Operation::Gemm => (i, j),
            }
        })
        .collect()
}

/// Returns the Euclidean norms of the columns of A, n columns, row-major.
fn column_norms<T: Real>(a: &[T], n: usize) -> Vec<f64> {
    let mut squares = vec![0.0; n];
    for row in a.chunks_exact(n) {
        for (square, x) in squares.iter_mut().zip(row) {
            *square += x.to_f64() * x.to_f64();
        }
    }
    squares.into_iter().map(f64::sqrt).collect()
}

fn dots<T: Real>(a: &[T], b: &[T], n: usize, entries: &[(usize, usize)]) -> Vec<DoubleDouble> {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("fma") {
        #[target_feature(enable = "fma")]
        fn with_fma<T: Real>(
            a: &[T],
            b: &[T],
            n: usize,
            entries: &[(usize, usize)],
        ) -> Vec<DoubleDouble> {
            dots_inline(a, b, n, entries)
        }
        // SAFETY: the CPU has the instruction.
        return unsafe { with_fma(a, b, n, entries) };
    }
    dots_inline(a, b, n, entries)
}

#[inline(always)]
fn dots_inline<T: Real>(
    a: &[T],
    b: &[T],
    n: usize,
    entries: &[(usize, usize)],
) -> Vec<DoubleDouble> {
    let mut sums = vec![DoubleDouble::default(); entries.len()];
    for (a, b) in a.chunks_exact(n).zip(b.chunks_exact(n)) {
        for (sum, &(i, j)) in sums.iter_mut().zip(entries) {
            sum.add_product(a[i].to_f64(), b[j].to_f64());
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPE: Shape = Shape { m: 3, n: 2 };
    const A: [f64; 6] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];

    #[test]
    fn right_passes_and_wrong_does_not() {
        let reference = Reference::new(&Product::syrk(SHAPE, &A), 1, 1);
        let mut c = [35.0, 7.0, 44.0, 56.0];
        assert_eq!(reference.check(&c), Ok(0.0));
        c[2] += 1e-3;
        assert!(reference.check(&c).is_err());
        c[2] = 44.0;
        reference.poison(&mut c);
        assert!(reference.check(&c).is_err());
        assert_eq!(c[1], 7.0, "the upper triangle is no part of the result");
    }

    #[test]
    fn general_products_are_checked_in_both_triangles() {
        let b = [1.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        let reference = Reference::new(&Product::gemm(SHAPE, &A, &b), 1, 1);
        let right = [6.0, 8.0, 8.0, 10.0];
        assert_eq!(reference.check(&right), Ok(0.0));
        for i in 0..4 {
            let mut c = right;
            c[i] += 1e-3;
            assert!(reference.check(&c).is_err(), "{i}");
        }
    }

    #[test]
    fn errors_are_relative_to_the_columns() {
        // Columns of norms 1 and 2^-40: an error in C[1, 1] that is small relative to the largest
        // entry.
        let small = 2f64.powi(-40);
        let a = [1.0, 0.0, 0.0, small];
        let reference = Reference::new(&Product::syrk(Shape { m: 2, n: 2 }, &a), 1, 1);
        let e = f64::EPSILON;
        let mut c = [1.0, 0.0, 0.0, small * small * (1.0 + e)];
        assert!(reference.check(&c).unwrap() < 1e-30);
        let errors = reference.entry_errors(&c).unwrap();
        let errors: Vec<_> =
            errors.iter().map(|found| (found.row, found.column, found.error)).collect();
        assert_eq!(errors, [(0, 0, 0.0), (1, 0, 0.0), (1, 1, e)]);
        c[3] *= 2.0;
        assert!(reference.check(&c).is_ok());
        assert!(reference.entry_errors(&c).unwrap_err().contains("C[1, 1]"));
    }

    #[test]
    fn columns_of_zeros_have_no_error() {
        let a = [0.0, 1.0, 0.0, 1.0];
        let reference = Reference::new(&Product::syrk(Shape { m: 2, n: 2 }, &a), 1, 1);
        assert!(
            reference.entry_errors(&[0.0, 0.0, 0.0, 2.0]).unwrap().iter().all(|e| e.error == 0.0)
        );
        assert!(reference.entry_errors(&[0.0, 0.0, 1e-30, 2.0]).is_err());
    }

    #[test]
    fn large_results_are_sampled() {
        let shape = Shape { m: 8192, n: 8192 };
        let sample = entries(Operation::Syrk, shape, 2000, 1);
        assert_eq!(sample.len(), 2000);
        assert!(sample.iter().all(|&(i, j)| j <= i && i < shape.n));
        assert!(sample.iter().any(|&(i, j)| i == j));
        let sample = entries(Operation::Gemm, shape, usize::MAX, 1);
        assert_eq!(sample.len(), MOST_PRODUCTS / shape.m);
        assert!(sample.iter().any(|&(i, j)| i < j));
    }
}
