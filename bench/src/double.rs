//! Double-double numbers: about 100 bits.

/// An unevaluated sum of two numbers (Dekker 1971): `hi` plus its error.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DoubleDouble {
    hi: f64,
    lo: f64,
}

impl DoubleDouble {
    /// Adds `x * y`: the product is exact (by fma), the sum is Knuth's two-sum (1969).
    #[inline(always)]
    pub fn add_product(&mut self, x: f64, y: f64) {
        let product = x * y;
        let product_error = x.mul_add(y, -product);
        let sum = self.hi + product;
        let part = sum - self.hi;
        let sum_error = (self.hi - (sum - part)) + (product - part);
        self.hi = sum;
        self.lo += sum_error + product_error;
    }

    /// Returns `x` minus this number.
    pub fn distance_from(self, x: f64) -> f64 {
        (x - self.hi) - self.lo
    }

    /// Returns the nearest f64, almost always.
    pub fn to_f64(self) -> f64 {
        self.hi + self.lo
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn double_double_keeps_what_double_loses() {
        let mut sum = DoubleDouble::default();
        let e = f64::EPSILON;
        // (1 + e)^2 - 1 = 2 e + e^2, whose last term no f64 sum of these terms represents.
        sum.add_product(1.0 + e, 1.0 + e);
        sum.add_product(-1.0, 1.0);
        assert_eq!(sum.distance_from(2.0 * e), -e * e);

        let mut sum = DoubleDouble::default();
        for (x, y) in [(1e16, 1.0), (1.0, 1.0), (-1e16, 1.0)] {
            sum.add_product(x, y);
        }
        assert_eq!(sum.distance_from(1.0), 0.0);
        assert_eq!(sum.to_f64(), 1.0);
    }
}
