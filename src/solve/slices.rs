//! Loops over vectors of extended numbers, whose parts are in one slice each: call them inside
//! [`widest`](crate::base::widest), where they use the widest registers there are.

use super::double::{DoubleDouble, fast_two_sum, normalized, two_product, two_sum};

/// A vector of numbers `hi + lo`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pairs<'a> {
    pub hi: &'a [f64],
    pub lo: &'a [f64],
}

/// A vector of numbers `hi + lo`, to write.
#[derive(Debug)]
pub(super) struct PairsMut<'a> {
    pub hi: &'a mut [f64],
    pub lo: &'a mut [f64],
}

impl PairsMut<'_> {
    /// Subtracts `factor x`. The low parts may grow beyond the rounding of the high ones, until
    /// [`PairsMut::normalize`]; an error is about 2^-106 of the sizes of the products for each of
    /// them.
    #[inline(always)]
    pub fn subtract(&mut self, x: Pairs<'_>, factor: DoubleDouble) {
        let n = self.hi.len();
        let (hi, lo) = (&mut self.hi[..n], &mut self.lo[..n]);
        let (x_hi, x_lo) = (&x.hi[..n], &x.lo[..n]);
        for i in 0..n {
            let product = x_hi[i] * factor.hi;
            let rest = x_hi[i].mul_add(factor.hi, -product);
            let rest = x_hi[i].mul_add(factor.lo, rest);
            let rest = x_lo[i].mul_add(factor.hi, rest);
            let (sum, lost) = two_sum(hi[i], -product);
            hi[i] = sum;
            lo[i] += lost - rest;
        }
    }

    /// Subtracts `factor x` for f64.
    #[inline(always)]
    pub fn subtract_f64(&mut self, x: &[f64], factor: DoubleDouble) {
        let n = self.hi.len();
        let (hi, lo, x) = (&mut self.hi[..n], &mut self.lo[..n], &x[..n]);
        for i in 0..n {
            let product = x[i] * factor.hi;
            let rest = x[i].mul_add(factor.lo, x[i].mul_add(factor.hi, -product));
            let (sum, lost) = two_sum(hi[i], -product);
            hi[i] = sum;
            lo[i] += lost - rest;
        }
    }

    /// Makes the high part of each number the number rounded to f64.
    #[inline(always)]
    pub fn normalize(&mut self) {
        let n = self.hi.len();
        let (hi, lo) = (&mut self.hi[..n], &mut self.lo[..n]);
        for i in 0..n {
            (hi[i], lo[i]) = two_sum(hi[i], lo[i]);
        }
    }

    /// Multiplies by `factor`; the result is normalized.
    #[inline(always)]
    pub fn scale(&mut self, factor: DoubleDouble) {
        let n = self.hi.len();
        let (hi, lo) = (&mut self.hi[..n], &mut self.lo[..n]);
        for i in 0..n {
            let x = DoubleDouble { hi: hi[i], lo: lo[i] } * factor;
            (hi[i], lo[i]) = (x.hi, x.lo);
        }
    }

    /// Subtracts the squares of `x`; the result is normalized.
    #[inline(always)]
    pub fn subtract_squares(&mut self, x: Pairs<'_>) {
        let n = self.hi.len();
        let (hi, lo) = (&mut self.hi[..n], &mut self.lo[..n]);
        let (x_hi, x_lo) = (&x.hi[..n], &x.lo[..n]);
        for i in 0..n {
            let (square, rest) = two_product(x_hi[i], x_hi[i]);
            let rest = (2.0 * x_hi[i]).mul_add(x_lo[i], rest);
            let (sum, lost) = two_sum(hi[i], -square);
            (hi[i], lo[i]) = fast_two_sum(sum, lo[i] + (lost - rest));
        }
    }
}

/// Adds `factor x` to a vector of sums of three parts, as [`TripleSum`](super::double::TripleSum)
/// adds: `x` and `factor` are normalized, the sums need not be.
#[inline(always)]
pub(super) fn add_triples(sum: [&mut [f64]; 3], x: [&[f64]; 3], factor: [f64; 3]) {
    let n = sum[0].len();
    let [a, b, c] = sum;
    let (a, b, c) = (&mut a[..n], &mut b[..n], &mut c[..n]);
    let [x, y, z] = x.map(|part| &part[..n]);
    let [f, g, h] = factor;
    for i in 0..n {
        let (product, rest) = two_product(x[i], f);
        let (left, left_rest) = two_product(x[i], g);
        let (right, right_rest) = two_product(y[i], f);
        let (first, lost) = two_sum(a[i], product);
        let (second, e0) = two_sum(b[i], lost);
        let (second, e1) = two_sum(second, rest);
        let (second, e2) = two_sum(second, left);
        let (second, e3) = two_sum(second, right);
        let last = y[i].mul_add(g, x[i].mul_add(h, z[i] * f));
        a[i] = first;
        b[i] = second;
        c[i] += ((e0 + e1) + (e2 + e3)) + ((left_rest + right_rest) + last);
    }
}

/// Normalizes a vector of numbers of three parts.
#[inline(always)]
pub(super) fn normalize_triples(sum: [&mut [f64]; 3]) {
    let n = sum[0].len();
    let [a, b, c] = sum;
    let (a, b, c) = (&mut a[..n], &mut b[..n], &mut c[..n]);
    for i in 0..n {
        [a[i], b[i], c[i]] = normalized([a[i], b[i], c[i]]);
    }
}
