//! Loops over vectors of extended numbers, whose parts are in one slice each: call them inside
//! [`widest`](crate::base::widest), where they use the widest registers there are.

use pulp::{Simd, WithSimd};

use super::double::{DoubleDouble, fast_two_sum, normalized, two_product, two_sum};
use crate::base::arch;

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

/// Vectors of numbers `hi + lo`, one after another: vector k begins at `k stride`.
#[derive(Debug, Clone, Copy)]
pub(super) struct PairColumns<'a> {
    pub hi: &'a [f64],
    pub lo: &'a [f64],
    pub stride: usize,
}

impl PairColumns<'_> {
    /// Returns entry i of vector j.
    #[inline(always)]
    pub fn get(self, i: usize, j: usize) -> DoubleDouble {
        let at = j * self.stride + i;
        DoubleDouble { hi: self.hi[at], lo: self.lo[at] }
    }

    /// Returns the vectors from vector j on, each from its entry i on.
    #[inline(always)]
    pub fn starting(self, i: usize, j: usize) -> Self {
        // There is no such entry behind the last vector.
        let at = (j * self.stride + i).min(self.hi.len());
        Self { hi: &self.hi[at..], lo: &self.lo[at..], stride: self.stride }
    }
}

impl PairsMut<'_> {
    /// Subtracts `factor(k) x_k` of each of the first `count` vectors x_k, one after another. The
    /// low parts may grow beyond the rounding of the high ones, until [`PairsMut::normalize`]; an
    /// error is about 2^-106 of the sizes of the products for each of them.
    ///
    /// The length is a multiple of [`LANES`](super::columns::LANES). The loop finds the widest
    /// registers by itself, and keeps a few of the sums in them for all k.
    #[inline]
    pub fn subtract(
        &mut self,
        x: PairColumns<'_>,
        count: usize,
        factor: impl Fn(usize) -> DoubleDouble,
    ) {
        arch().dispatch(Subtraction { hi: &mut *self.hi, lo: &mut *self.lo, x, count, factor });
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

/// The arguments of [`PairsMut::subtract`].
struct Subtraction<'a, F> {
    hi: &'a mut [f64],
    lo: &'a mut [f64],
    x: PairColumns<'a>,
    count: usize,
    factor: F,
}

impl<F: Fn(usize) -> DoubleDouble> WithSimd for Subtraction<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        // Four sums hide the latency of additions, and AVX2 has registers for no more.
        let next = self.tiles::<S, 4>(simd, 0);
        let next = self.tiles::<S, 2>(simd, next);
        let next = self.tiles::<S, 1>(simd, next);
        debug_assert_eq!(next, self.hi.len());
    }
}

impl<F: Fn(usize) -> DoubleDouble> Subtraction<'_, F> {
    /// Subtracts from entry `from` on, `WIDTH` registers at a time; returns the first entry that is
    /// left.
    #[inline(always)]
    fn tiles<S: Simd, const WIDTH: usize>(&mut self, simd: S, mut from: usize) -> usize {
        while from + WIDTH * S::F64_LANES <= self.hi.len() {
            let mut hi = loaded::<S, WIDTH>(&self.hi[from..]);
            let mut lo = loaded::<S, WIDTH>(&self.lo[from..]);
            for k in 0..self.count {
                let at = k * self.x.stride + from;
                let x_hi = loaded::<S, WIDTH>(&self.x.hi[at..]);
                let x_lo = loaded::<S, WIDTH>(&self.x.lo[at..]);
                let factor = (self.factor)(k);
                let minus = simd.splat_f64s(-factor.hi);
                let high = simd.splat_f64s(factor.hi);
                let low = simd.splat_f64s(factor.lo);
                for v in 0..WIDTH {
                    let product = simd.mul_f64s(x_hi[v], minus);
                    let rest = simd.mul_add_f64s(x_hi[v], high, product);
                    let rest = simd.mul_add_f64s(x_hi[v], low, rest);
                    let rest = simd.mul_add_f64s(x_lo[v], high, rest);
                    // As `two_sum`.
                    let sum = simd.add_f64s(hi[v], product);
                    let part = simd.sub_f64s(sum, hi[v]);
                    let of_sum = simd.sub_f64s(hi[v], simd.sub_f64s(sum, part));
                    let lost = simd.add_f64s(of_sum, simd.sub_f64s(product, part));
                    hi[v] = sum;
                    lo[v] = simd.add_f64s(lo[v], simd.sub_f64s(lost, rest));
                }
            }
            store::<S, WIDTH>(&mut self.hi[from..], hi);
            store::<S, WIDTH>(&mut self.lo[from..], lo);
            from += WIDTH * S::F64_LANES;
        }
        from
    }
}

/// Returns the first registers of a slice, which is long enough.
#[inline(always)]
fn loaded<S: Simd, const WIDTH: usize>(x: &[f64]) -> [S::f64s; WIDTH] {
    *S::as_simd_f64s(x).0.first_chunk().unwrap()
}

/// Stores registers at the beginning of a slice, which is long enough.
#[inline(always)]
fn store<S: Simd, const WIDTH: usize>(x: &mut [f64], registers: [S::f64s; WIDTH]) {
    *S::as_mut_simd_f64s(x).0.first_chunk_mut().unwrap() = registers;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{Rng, widest};

    #[test]
    fn many_products_are_subtracted_as_one_after_another() {
        let mut rng = Rng::new(1);
        let mut numbers = |count: usize| {
            let mut number = |_| {
                let size = (40.0 * rng.uniform() - 20.0).exp2();
                let x = DoubleDouble::new(rng.normal(), rng.normal() * 2f64.powi(-53));
                (x.hi * size, x.lo * size)
            };
            (0..count).map(&mut number).unzip::<f64, f64, Vec<_>, Vec<_>>()
        };
        // Lengths for all widths of tiles.
        for n in [8, 24, 32, 56, 120] {
            for count in [0, 1, 2, 33] {
                let stride = n + 8;
                let (x_hi, x_lo) = numbers(stride * count);
                let x = PairColumns { hi: &x_hi, lo: &x_lo, stride };
                let (factor_hi, factor_lo) = numbers(count);
                let factor = |k: usize| DoubleDouble { hi: factor_hi[k], lo: factor_lo[k] };
                let (hi, lo) = numbers(n);
                let (mut expected_hi, mut expected_lo) = (hi.clone(), lo.clone());
                for i in 0..n {
                    for k in 0..count {
                        let (x, factor) = (x.get(i + 8, k), factor(k));
                        let (product, rest) = two_product(x.hi, factor.hi);
                        let rest = x.lo.mul_add(factor.hi, x.hi.mul_add(factor.lo, rest));
                        let (sum, lost) = two_sum(expected_hi[i], -product);
                        expected_hi[i] = sum;
                        expected_lo[i] += lost - rest;
                    }
                }
                let subtract = |inside: bool| {
                    let (mut hi, mut lo) = (hi.clone(), lo.clone());
                    let mut to = PairsMut { hi: &mut hi, lo: &mut lo };
                    match inside {
                        true => widest(
                            #[inline(always)]
                            || to.subtract(x.starting(8, 0), count, factor),
                        ),
                        false => to.subtract(x.starting(8, 0), count, factor),
                    }
                    (hi, lo)
                };
                for inside in [false, true] {
                    let found = subtract(inside);
                    assert!(found == (expected_hi.clone(), expected_lo.clone()), "{n}, {count}");
                }
            }
        }
    }
}
