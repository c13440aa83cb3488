//! Sums of rows in floating point.

use std::ops::Range;

use faer::{MatMut, MatRef};

use super::moments::Moments;
use super::pass::{Pass, part};
use super::strip::Strip;
use crate::base::Result;
use crate::blas::BlasReal;
use crate::product::{Product, Uplo};

/// Adds a block of `count` rows of n columns: `C := alpha X^T W X + beta C`, for the rows `strip`
/// of C, which are `left` of the diagonal square and `square`. The entries of the block are
/// overwritten.
pub(super) fn add<T: BlasReal>(
    moments: &mut Moments<T>,
    (count, block, weights): (usize, &mut [T], Option<&[T]>),
    strip: &Range<usize>,
    alpha: T,
    beta: T,
    left: Option<MatMut<'_, T>>,
    square: MatMut<'_, T>,
    pass: &mut Pass<'_>,
) -> Result<()> {
    let (options, engine, memory) = pass.parts();
    let n = block.len().checked_div(count).unwrap_or(0);
    let len = if weights.is_some() { block.len() } else { 0 };
    memory.reserve::<T>(len)?;
    let weighted = &mut memory.as_mut_slice::<T>()[..len];
    options.on_cores(|| moments.take(count, block, weights, weighted, options.par));
    if strip.end == 0 {
        return Ok(());
    }
    let x = MatRef::from_row_major_slice(block, count, n);
    let wx = weights.map(|_| MatRef::from_row_major_slice(weighted, count, n));
    if let Some(left) = left {
        let rest = part(x, &(0..strip.start));
        let a = part(wx.unwrap_or(x), strip);
        let product = Product { alpha, a, b: Some(rest), beta, c: left, uplo: None };
        engine.multiply(product, &options)?;
    }
    let (a, b, uplo) = (part(x, strip), wx.map(|wx| part(wx, strip)), Some(options.uplo));
    engine.multiply(Product { alpha, a, b, beta, c: square, uplo }, &options)
}

/// Some rows of `C = sum of w_i (x_i - s)(x_i - s)^T`. Without centring the shift s is zero. With
/// centring it is the mean of the first block, and the end moves it to the mean of all rows.
#[derive(Debug)]
pub(super) struct FloatSums<T> {
    /// The lower triangle of C, about the shift.
    pub c: Strip<T>,
    pub moments: Moments<T>,
}

impl<T: BlasReal> FloatSums<T> {
    /// Creates the sums of no rows.
    pub fn new(ncols: usize, strip: Range<usize>, centered: bool) -> Result<Self> {
        Ok(Self { c: Strip::new(strip)?, moments: Moments::new(ncols, centered)? })
    }

    /// Returns a copy, bit for bit.
    pub fn try_clone(&self) -> Result<Self> {
        Ok(Self { c: self.c.try_clone()?, moments: self.moments.clone() })
    }

    /// Adds a block of `count` rows, and overwrites its entries.
    pub fn add(
        &mut self,
        count: usize,
        block: &mut [T],
        weights: Option<&[T]>,
        pass: &mut Pass<'_>,
    ) -> Result<()> {
        pass.options.uplo = Uplo::Lower;
        let strip = self.c.rows();
        let beta = if self.moments.rows == 0 { T::ZERO } else { T::ONE };
        let (left, square) = self.c.as_mut().split_at_col_mut(strip.start);
        let left = (strip.start > 0).then_some(left);
        let rows = (count, block, weights);
        add(&mut self.moments, rows, &strip, T::ONE, beta, left, square, pass)
    }

    /// Adds the rows of `other`, which are about another shift:
    /// `x - s = (x - s') + d` with `d = s' - s`, so that `C += C' + t' d^T + d t'^T + w' d d^T` and
    /// `t += t' + w' d`, t the sum of the shifted rows and w their weight. The shift of the heavier
    /// side stays, for the corrections to be small.
    pub fn merge(&mut self, mut other: Self) {
        let heavier = other.moments.weight_size > self.moments.weight_size;
        if heavier || self.moments.shift.is_empty() {
            std::mem::swap(self, &mut other);
        }
        let first = self.c.rows().start;
        let (own, others) = (&mut self.moments, &other.moments);
        own.rows = own.rows.saturating_add(others.rows);
        own.weight += others.weight;
        own.weight_size += others.weight_size;
        if others.shift.is_empty() {
            // Not centred, or without rows.
            return self.add_c(&other, first, |_, _| 0.0);
        }
        let difference = |(s, t): (&T, &T)| s.to_f64() - t.to_f64();
        let d: Vec<f64> = others.shift.iter().zip(&own.shift).map(difference).collect();
        for ((t, u), d) in own.sum.iter_mut().zip(&others.sum).zip(&d) {
            *t += u + others.weight * d;
        }
        let t = &others.sum;
        self.add_c(&other, first, |i, j| t[i] * d[j] + d[i] * (t[j] + others.weight * d[j]));
    }

    /// Computes `C += C' + correction`.
    fn add_c(&mut self, other: &Self, first: usize, correction: impl Fn(usize, usize) -> f64) {
        for i in 0..self.c.rows().len() {
            let own = self.c.lower_row_mut(i);
            for (j, (c, d)) in own.iter_mut().zip(other.c.lower_row(i)).enumerate() {
                *c = T::from_f64(c.to_f64() + d.to_f64() + correction(first + i, j));
            }
        }
    }

    /// Computes `alpha C` about the mean, in the memory of the sums.
    pub fn finish(self, alpha: f64) -> Result<Strip<T>> {
        let Self { mut c, moments } = self;
        moments.correct(1.0, c.rows().start, c.as_mut())?;
        if alpha != 1.0 {
            for i in 0..c.rows().len() {
                for x in c.lower_row_mut(i) {
                    *x = T::from_f64(alpha * x.to_f64());
                }
            }
        }
        Ok(c)
    }
}
