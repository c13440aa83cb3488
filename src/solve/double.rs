//! Numbers that are sums of two or three f64.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Returns `x + y` rounded, and the rounding error (Knuth 1969).
#[inline(always)]
pub(super) fn two_sum(x: f64, y: f64) -> (f64, f64) {
    let sum = x + y;
    let part = sum - x;
    (sum, (x - (sum - part)) + (y - part))
}

/// Returns what [`two_sum`] returns, for `|x| >= |y|` or `x == 0` (Dekker 1971).
#[inline(always)]
pub(super) fn fast_two_sum(x: f64, y: f64) -> (f64, f64) {
    let sum = x + y;
    (sum, y - (sum - x))
}

/// Returns `x y` rounded, and the rounding error.
#[inline(always)]
pub(super) fn two_product(x: f64, y: f64) -> (f64, f64) {
    let product = x * y;
    (product, x.mul_add(y, -product))
}

/// A number `hi + lo` of about 106 bits: `hi` is the sum rounded to f64.
///
/// The operations are those of Joldes, Muller and Popescu (2017); the relative error of each is a
/// few units of 2^-106. They contain no branches.
///
/// ```
/// use catamaran::solve::DoubleDouble;
///
/// let third = DoubleDouble::from(1.0) / DoubleDouble::from(3.0);
/// let error = third * DoubleDouble::from(3.0) - DoubleDouble::from(1.0);
/// assert!(error.hi.abs() < 1e-31);
/// assert_eq!(DoubleDouble::new(1.0, 1e-20).lo, 1e-20);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default)]
pub struct DoubleDouble {
    /// The number rounded to f64.
    pub hi: f64,
    /// The rest.
    pub lo: f64,
}

impl DoubleDouble {
    /// 0.
    pub const ZERO: Self = Self { hi: 0.0, lo: 0.0 };
    /// 1.
    pub const ONE: Self = Self { hi: 1.0, lo: 0.0 };

    /// Returns `x + y`, whatever their sizes.
    #[inline(always)]
    pub fn new(x: f64, y: f64) -> Self {
        let (hi, lo) = two_sum(x, y);
        Self { hi, lo }
    }

    /// Returns the square root; that of a negative number is NaN.
    ///
    /// ```
    /// use catamaran::solve::DoubleDouble;
    ///
    /// let two = DoubleDouble::from(2.0);
    /// let error = two.sqrt() * two.sqrt() - two;
    /// assert!(error.hi.abs() < 1e-30);
    /// ```
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        let root = self.hi.sqrt();
        let rest = self - Self::product(root, root);
        // A root of zero has no correction.
        let lo = if root > 0.0 { rest.hi / (2.0 * root) } else { 0.0 };
        let (hi, lo) = fast_two_sum(root, lo);
        Self { hi, lo }
    }

    /// Returns `self * factor + addend`.
    #[inline(always)]
    pub fn mul_add(self, factor: f64, addend: Self) -> Self {
        let (hi, rest) = two_product(self.hi, factor);
        let (hi, lo) = fast_two_sum(hi, self.lo.mul_add(factor, rest));
        Self { hi, lo } + addend
    }

    /// Returns `x y`, without an error.
    ///
    /// ```
    /// use catamaran::solve::DoubleDouble;
    ///
    /// let e = f64::EPSILON;
    /// let square = DoubleDouble::product(1.0 + e, 1.0 + e);
    /// assert_eq!((square.hi, square.lo), (1.0 + 2.0 * e, e * e));
    /// ```
    #[inline(always)]
    pub fn product(x: f64, y: f64) -> Self {
        let (hi, lo) = two_product(x, y);
        Self { hi, lo }
    }

    /// Returns the absolute value.
    #[inline(always)]
    pub fn abs(self) -> Self {
        if self.hi < 0.0 { -self } else { self }
    }

    /// Returns `self 2^exponent`.
    pub(super) fn scaled(self, exponent: i32) -> Self {
        Self { hi: scaled(self.hi, exponent), lo: scaled(self.lo, exponent) }
    }
}

/// Returns `x 2^exponent`, rounded where it is subnormal.
pub(super) fn scaled(x: f64, exponent: i32) -> f64 {
    crate::kernel::int8::scaled(x, exponent)
}

impl From<f64> for DoubleDouble {
    fn from(x: f64) -> Self {
        Self { hi: x, lo: 0.0 }
    }
}

impl Neg for DoubleDouble {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl Add for DoubleDouble {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (high, rest) = two_sum(self.hi, other.hi);
        let (low, last) = two_sum(self.lo, other.lo);
        let (high, rest) = fast_two_sum(high, rest + low);
        let (hi, lo) = fast_two_sum(high, last + rest);
        Self { hi, lo }
    }
}

impl Sub for DoubleDouble {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for DoubleDouble {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (hi, rest) = two_product(self.hi, other.hi);
        let cross = self.hi.mul_add(other.lo, self.lo * other.lo);
        let (hi, lo) = fast_two_sum(hi, rest + self.lo.mul_add(other.hi, cross));
        Self { hi, lo }
    }
}

impl Div for DoubleDouble {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let first = self.hi / other.hi;
        let rest = other.mul_add(-first, self);
        let second = rest.hi / other.hi;
        let rest = other.mul_add(-second, rest);
        let (hi, lo) = fast_two_sum(first, second);
        let (hi, lo) = fast_two_sum(hi, lo + rest.hi / other.hi);
        Self { hi, lo }
    }
}

/// A sum in three parts. After k terms its error is about k^2 2^-159 of the sum of their sizes
/// (Ogita, Rump and Oishi 2005).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct TripleSum {
    parts: [f64; 3],
}

impl TripleSum {
    /// Adds an f64.
    #[inline(always)]
    pub fn add(&mut self, x: f64) {
        let [first, second, third] = self.parts;
        let (first, rest) = two_sum(first, x);
        let (second, rest) = two_sum(second, rest);
        self.parts = [first, second, third + rest];
    }

    /// Adds a number of three parts.
    #[inline(always)]
    pub fn add_parts(&mut self, x: [f64; 3]) {
        x.into_iter().for_each(|part| self.add(part));
    }

    /// Adds `x y`.
    #[inline(always)]
    pub fn add_product(&mut self, x: f64, y: f64) {
        let (product, rest) = two_product(x, y);
        self.add(product);
        self.add(rest);
    }

    /// Adds `x y`, of which each part is at most 2^-52 of the one before.
    #[inline(always)]
    pub fn add_products(&mut self, x: [f64; 3], y: [f64; 3]) {
        for i in 0..3 {
            for j in 0..3 - i {
                self.add_product(x[i], y[j]);
            }
        }
    }

    /// Returns the parts, the largest first, each at most half a unit in the last place of the one
    /// before.
    #[inline(always)]
    pub fn parts(self) -> [f64; 3] {
        normalized(self.parts)
    }

    /// Returns the sum rounded to 106 bits.
    #[inline(always)]
    pub fn double(self) -> DoubleDouble {
        let [hi, lo, rest] = self.parts();
        DoubleDouble { hi, lo: lo + rest }
    }

    /// Returns the sum rounded to the nearest f64.
    pub fn rounded(self) -> f64 {
        let [sum, half, rest] = self.parts();
        // Halfway between two numbers, the third part decides.
        let next = sum + 2.0 * half;
        let away = half != 0.0 && rest != 0.0 && (half < 0.0) == (rest < 0.0);
        if away && next - sum == 2.0 * half { next } else { sum }
    }
}

/// Returns a number of three parts with each part at most half a unit in the last place of the one
/// before.
#[inline(always)]
pub(super) fn normalized([first, second, third]: [f64; 3]) -> [f64; 3] {
    let (second, third) = two_sum(second, third);
    let (first, second) = two_sum(first, second);
    let (second, third) = two_sum(second, third);
    let (first, second) = two_sum(first, second);
    let (second, third) = two_sum(second, third);
    [first, second, third]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Rng;

    fn number(rng: &mut Rng) -> DoubleDouble {
        let size = (60.0 * rng.uniform() - 30.0).exp2();
        DoubleDouble::new(rng.normal() * size, rng.normal() * size * 2f64.powi(-53))
    }

    #[test]
    fn operations_undo_each_other_to_106_bits() {
        let mut rng = Rng::new(1);
        let near = |x: DoubleDouble, y: DoubleDouble, size: f64| {
            assert!((x - y).hi.abs() <= 2f64.powi(-102) * size, "{x:?} {y:?}");
        };
        for _ in 0..2000 {
            let (x, y) = (number(&mut rng), number(&mut rng));
            near(x / y * y, x, x.hi.abs());
            near(x + y - y, x, x.hi.abs() + y.hi.abs());
            near(x.abs().sqrt() * x.abs().sqrt(), x.abs(), x.hi.abs());
            near(x.mul_add(y.hi, -(x * DoubleDouble::from(y.hi))), DoubleDouble::ZERO, {
                (x.hi * y.hi).abs()
            });
        }
        assert_eq!(DoubleDouble::ZERO.sqrt(), DoubleDouble::ZERO);
    }

    #[test]
    fn products_of_integers_below_2_106_are_exact() {
        let mut rng = Rng::new(2);
        for _ in 0..2000 {
            let (a, b) = ((rng.bits() >> 12) as i64, (rng.bits() >> 12) as i64);
            let product = DoubleDouble::from(a as f64) * DoubleDouble::from(b as f64);
            assert_eq!(product.hi as i128 + product.lo as i128, i128::from(a) * i128::from(b));
        }
    }

    #[test]
    fn sums_in_three_parts_outlive_cancellation() {
        let mut sum = TripleSum::default();
        for x in [1e30, 1.0, 1e-16, -1e30, -1.0] {
            sum.add(x);
        }
        assert_eq!(sum.rounded(), 1e-16);
        // Halfway cases: 1 + 2^-53 is even at 1 unless something is left over.
        for (rest, rounded) in [(0.0, 1.0), (1e-40, 1.0 + f64::EPSILON), (-1e-40, 1.0)] {
            let mut sum = TripleSum::default();
            [1.0, 2f64.powi(-53), rest].into_iter().for_each(|x| sum.add(x));
            assert_eq!(sum.rounded(), rounded);
        }
    }
}
