//! The sums of a pass over rows beside their product: weights, and sums for the mean.

use faer::MatMut;

use super::pieces::{Piece, block_pieces};
use crate::base::{Error, Par, Real, Result, widest, zeros};
use crate::kernel::int8::scaled;

/// Rows that one thread takes at a time, and whose sums are added up before they go to the total.
const PIECE: usize = 1024;

/// Entries that keep one thread busy for less time than another takes to wake up.
const SMALL: usize = 1 << 17;

/// Weights and weighted sums of the rows so far.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Moments<T> {
    /// Rows so far.
    pub rows: u64,
    /// Sum of their weights.
    pub weight: f64,
    /// Sum of the absolute values of their weights.
    pub weight_size: f64,
    /// Whether the product is to be about the mean.
    pub centered: bool,
    /// Subtracted from every row: n entries, or none.
    pub shift: Vec<T>,
    /// Weighted sum of the rows less the shift: n entries when centred, or none.
    pub sum: Vec<f64>,
}

impl<T: Real> Moments<T> {
    /// Creates the moments of no rows of `n` columns. When `centered`, the mean of the first block
    /// becomes the shift.
    pub fn new(n: usize, centered: bool) -> Result<Self> {
        let sum = zeros(if centered { n } else { 0 })?;
        Ok(Self { rows: 0, weight: 0.0, weight_size: 0.0, centered, shift: Vec::new(), sum })
    }

    /// Creates the moments of no rows, from each of which `shift` is subtracted.
    pub fn with_shift(shift: &[T]) -> Result<Self> {
        Ok(Self { shift: shift.to_vec(), ..Self::new(shift.len(), false)? })
    }

    /// Adds `count` rows of `n` columns: subtracts the shift from them, adds them to the sums, and
    /// writes them times their weights into `weighted`, of the same length when there are weights.
    pub fn take(
        &mut self,
        count: usize,
        block: &mut [T],
        weights: Option<&[T]>,
        weighted: &mut [T],
        par: Par,
    ) {
        let n = block.len().checked_div(count).unwrap_or(0);
        if self.centered && self.shift.is_empty() && n > 0 {
            self.shift = mean(block, n, weights);
        }
        self.rows = self.rows.saturating_add(count as u64);
        match weights {
            None => {
                self.weight += count as f64;
                self.weight_size += count as f64;
            }
            Some(weights) => {
                self.weight += weights.iter().map(|w| w.to_f64()).sum::<f64>();
                self.weight_size += weights.iter().map(|w| w.to_f64().abs()).sum::<f64>();
            }
        }
        if n == 0 || self.shift.is_empty() && weights.is_none() {
            return;
        }
        let par = if block.len() < SMALL { Par::Seq } else { par };
        let sums = if self.centered { n } else { 0 };
        let pieces = block_pieces(block, n, PIECE, weights, [weighted]);
        let mut pieces: Vec<_> = pieces.map(|piece| (piece, vec![0.0; sums])).collect();
        par.for_each(pieces.iter_mut(), |_, (piece, sum)| adjust(piece, sum, n, &self.shift));
        // In the order of the pieces, not of the threads that computed them.
        for (_, part) in pieces {
            for (sum, part) in self.sum.iter_mut().zip(part) {
                *sum += part;
            }
        }
    }

    /// Returns whether there is a mean to subtract.
    ///
    /// # Errors
    /// [`Error::Argument`] when there should be, and the weights sum to zero.
    pub fn check_mean(&self) -> Result<bool> {
        if !self.centered || self.rows == 0 {
            return Ok(false);
        }
        check_weight(self.rows as f64, self.weight, self.weight_size).map(|()| true)
    }

    /// Returns the mean row.
    pub fn mean(&self) -> Vec<f64> {
        let mean = |(sum, shift): (&f64, &T)| shift.to_f64() + sum / self.weight;
        self.sum.iter().zip(&self.shift).map(mean).collect()
    }

    /// Turns C, the product of the shifted rows times `alpha`, into that of the rows less their
    /// mean. Row `i` of `c` is row `first + i` of C, whose lower triangle is touched.
    ///
    /// # Errors
    /// As [`Moments::check_mean`].
    pub fn correct(&self, alpha: f64, first: usize, mut c: MatMut<'_, T>) -> Result<()> {
        if !self.check_mean()? {
            return Ok(());
        }
        for i in 0..c.nrows() {
            let row = alpha / self.weight * self.sum[first + i];
            for j in 0..=first + i {
                c[(i, j)] = T::from_f64(c[(i, j)].to_f64() - row * self.sum[j]);
            }
        }
        Ok(())
    }
}

/// Returns [`Error::Argument`] when `m` weights with this sum, and this sum of absolute values,
/// have no mean.
pub(crate) fn check_weight(m: f64, sum: f64, size: f64) -> Result<()> {
    // More rows than 2^51 have no entries, and equal weights.
    if sum.abs() <= (m * f64::EPSILON).min(0.5) * size {
        return Err(Error::Argument { what: "weights", why: "they sum to zero: no mean".into() });
    }
    Ok(())
}

/// Returns the mean row of a block by the sizes of the weights, or the plain one if all are zero.
fn mean<T: Real>(block: &[T], n: usize, weights: Option<&[T]>) -> Vec<T> {
    let size = |i: usize| weights.map_or(1.0, |w| w[i].to_f64().abs());
    let count = block.len() / n;
    let total: f64 = (0..count).map(size).sum();
    let weights = if total > 0.0 { weights } else { None };
    let size = |i: usize| weights.map_or(1.0, |w| w[i].to_f64().abs());
    let total = if total > 0.0 { total } else { count as f64 };
    let mut sum = vec![0.0; n];
    for (i, row) in block.chunks_exact(n).enumerate() {
        let size = size(i);
        for (sum, &x) in sum.iter_mut().zip(row) {
            *sum += size * x.to_f64();
        }
    }
    let mean = |(j, sum): (usize, f64)| match sum.is_finite() {
        true => sum / total,
        false => scaled_mean(block, n, j, size, total),
    };
    sum.into_iter().enumerate().map(mean).map(T::from_f64).collect()
}

/// Returns entry j of the [`mean`] where the sum of the column overflows, or an entry is not
/// finite; `total` is the sum of the sizes of the weights.
fn scaled_mean<T: Real>(
    block: &[T],
    n: usize,
    j: usize,
    size: impl Fn(usize) -> f64,
    total: f64,
) -> f64 {
    // A power of two changes no digit. The sum is at most half of the largest number.
    let exponent = (total.log2() + 1.0).ceil().max(0.0) as i32;
    let term = |(i, row): (usize, &[T])| size(i) * scaled(row[j].to_f64(), -exponent);
    let sum: f64 = block.chunks_exact(n).enumerate().map(term).sum();
    scaled(sum / total, exponent)
}

/// Adjusts the rows of a piece as [`Moments::take`] describes; their weighted sum goes to `sum`,
/// which is empty when it is not needed.
fn adjust<T: Real>(piece: &mut Piece<'_, T, 1>, sum: &mut [f64], n: usize, shift: &[T]) {
    let Piece { rows, weights, outputs: [weighted] } = piece;
    widest(
        #[inline(always)]
        || {
            for (i, row) in rows.chunks_exact_mut(n).enumerate() {
                for (x, &shift) in row.iter_mut().zip(shift) {
                    *x -= shift;
                }
                if let Some(weights) = weights {
                    let weight = weights[i];
                    for (out, &x) in weighted[i * n..].iter_mut().zip(row.iter()) {
                        *out = weight * x;
                    }
                    let weight = weight.to_f64();
                    for (sum, &x) in sum.iter_mut().zip(row.iter()) {
                        *sum += weight * x.to_f64();
                    }
                } else {
                    for (sum, &x) in sum.iter_mut().zip(row.iter()) {
                        *sum += x.to_f64();
                    }
                }
            }
        },
    );
}
