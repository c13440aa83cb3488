//! The right answer: entries of A^T A in double-double, about 100 bits.

use catamaran::Real;
use catamaran::base::Rng;
use rayon::prelude::*;

use crate::input::Shape;

/// An unevaluated sum of two numbers (Dekker 1971): `hi` plus its error.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DoubleDouble {
    hi: f64,
    lo: f64,
}

impl DoubleDouble {
    /// Adds `x * y`: the product exactly (by fma), the sum by Knuth's two-sum (1969).
    #[inline(always)]
    fn add_product(&mut self, x: f64, y: f64) {
        let product = x * y;
        let product_error = x.mul_add(y, -product);
        let sum = self.hi + product;
        let part = sum - self.hi;
        let sum_error = (self.hi - (sum - part)) + (product - part);
        self.hi = sum;
        self.lo += sum_error + product_error;
    }

    /// `x` minus this.
    fn distance_from(self, x: f64) -> f64 {
        (x - self.hi) - self.lo
    }
}

/// Entries of the lower triangle of A^T A, and where they are.
pub struct Reference {
    entries: Vec<(usize, usize)>,
    values: Vec<DoubleDouble>,
    largest: f64,
    n: usize,
    /// Above this relative error a result is wrong, not inaccurate.
    tolerance: f64,
}

/// The whole triangle up to this many m n^2, a sample above.
const WHOLE: usize = 2_000_000_000;
/// Products in all that a sample may cost.
const SAMPLE_PRODUCTS: usize = 1_000_000_000;
const SAMPLE: usize = 2000;

impl Reference {
    /// The reference for A^T A, A row-major.
    pub fn new<T: Real>(a: &[T], shape: Shape, seed: u64) -> Self {
        let entries = entries(shape, seed);
        // Pieces small enough for the cache walk down A row by row.
        let values: Vec<_> =
            entries.par_chunks(1024).flat_map_iter(|piece| dots(a, shape.n, piece)).collect();
        let largest = values.iter().map(|v| v.hi.abs()).fold(0.0, f64::max);
        let tolerance = 8.0 * (shape.m as f64).sqrt().max(4.0) * T::UNIT_ROUNDOFF;
        Self { entries, values, largest, n: shape.n, tolerance }
    }

    /// Makes a result that is not written show.
    pub fn poison<T: Real>(&self, c: &mut [T]) {
        for &(i, j) in &self.entries {
            c[i * self.n + j] = T::from_f64(f64::NAN);
        }
    }

    /// `max |C - C_ref| / max |C_ref|` over the entries; C n x n, row-major, lower triangle.
    ///
    /// # Errors
    /// When that is no rounding error.
    pub fn check<T: Real>(&self, c: &[T]) -> Result<f64, String> {
        let mut error = 0.0;
        for (&(i, j), value) in self.entries.iter().zip(&self.values) {
            let relative = value.distance_from(c[i * self.n + j].to_f64()).abs() / self.largest;
            if relative.is_nan() || relative > self.tolerance {
                return Err(format!(
                    "wrong result: C[{i}, {j}] = {}, should be {}",
                    c[i * self.n + j],
                    value.hi
                ));
            }
            error = relative.max(error);
        }
        Ok(error)
    }
}

fn entries(Shape { m, n }: Shape, seed: u64) -> Vec<(usize, usize)> {
    if m * n * n <= WHOLE {
        return (0..n).flat_map(|i| (0..=i).map(move |j| (i, j))).collect();
    }
    let mut rng = Rng::new(seed);
    let mut index = || (rng.uniform() * n as f64) as usize;
    (0..SAMPLE.min(SAMPLE_PRODUCTS / m))
        .map(|s| {
            let (i, j) = (index(), index());
            // Every eighth on the diagonal, where the largest entries are.
            if s % 8 == 0 { (i, i) } else { (i.max(j), i.min(j)) }
        })
        .collect()
}

fn dots<T: Real>(a: &[T], n: usize, entries: &[(usize, usize)]) -> Vec<DoubleDouble> {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("fma") {
        #[target_feature(enable = "fma")]
        fn with_fma<T: Real>(a: &[T], n: usize, entries: &[(usize, usize)]) -> Vec<DoubleDouble> {
            dots_inline(a, n, entries)
        }
        // SAFETY: the CPU has the instruction.
        return unsafe { with_fma(a, n, entries) };
    }
    dots_inline(a, n, entries)
}

#[inline(always)]
fn dots_inline<T: Real>(a: &[T], n: usize, entries: &[(usize, usize)]) -> Vec<DoubleDouble> {
    let mut sums = vec![DoubleDouble::default(); entries.len()];
    for row in a.chunks_exact(n) {
        for (sum, &(i, j)) in sums.iter_mut().zip(entries) {
            sum.add_product(row[i].to_f64(), row[j].to_f64());
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn double_double_keeps_what_double_loses() {
        let mut sum = DoubleDouble::default();
        let e = f64::EPSILON;
        // (1 + e)^2 - 1 = 2 e + e^2, whose last term no f64 sum of these terms can hold.
        sum.add_product(1.0 + e, 1.0 + e);
        sum.add_product(-1.0, 1.0);
        assert_eq!(sum.distance_from(2.0 * e), -e * e);

        let mut sum = DoubleDouble::default();
        for (x, y) in [(1e16, 1.0), (1.0, 1.0), (-1e16, 1.0)] {
            sum.add_product(x, y);
        }
        assert_eq!(sum.distance_from(1.0), 0.0);
    }

    #[test]
    fn right_passes_and_wrong_does_not() {
        let shape = Shape { m: 3, n: 2 };
        let a = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let reference = Reference::new(&a, shape, 1);
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
    fn large_triangles_are_sampled() {
        let shape = Shape { m: 8192, n: 8192 };
        let sample = entries(shape, 1);
        assert_eq!(sample.len(), SAMPLE);
        assert!(sample.iter().all(|&(i, j)| j <= i && i < shape.n));
        assert!(sample.iter().any(|&(i, j)| i == j));
    }
}
