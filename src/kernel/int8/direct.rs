//! The arithmetic of small products, which fill no tiles: integers are multiplied as such instead
//! of by their residues. The results are the same.

use super::tile::{MAGNITUDE, norm_exponent, norm_power, power_of_two};
use crate::base::{Plain, Real};

/// A scalar whose integers are multiplied as machine words.
pub trait Direct: Real {
    /// Holds the integers that entries are converted to.
    type Word: Plain + Default;

    /// Rounds to an integer, ties to even.
    ///
    /// # Safety
    /// The number is finite, and below `2^INTEGER_BITS` in magnitude.
    unsafe fn word(self) -> Self::Word;

    /// Returns the sum of the products of the words, below P/2, rounded to the nearest f64.
    fn dot(left: &[Self::Word], right: &[Self::Word]) -> f64;
}

impl Direct for f64 {
    type Word = i64;

    #[inline(always)]
    unsafe fn word(self) -> i64 {
        // SAFETY: the caller's promise: below 2^62.
        unsafe { self.round_ties_even().to_int_unchecked() }
    }

    #[inline(always)]
    fn dot(left: &[i64], right: &[i64]) -> f64 {
        let term = |l: &i64, r: &i64| i128::from(*l) * i128::from(*r);
        let (left, left_rest) = left.as_chunks::<4>();
        let (right, right_rest) = right.as_chunks::<4>();
        let mut sum = 0_i128;
        for (left, right) in left.iter().zip(right) {
            for (l, r) in left.iter().zip(right) {
                sum = sum.wrapping_add(term(l, r));
            }
        }
        for (l, r) in left_rest.iter().zip(right_rest) {
            sum = sum.wrapping_add(term(l, r));
        }
        sum as f64
    }
}

impl Direct for f32 {
    type Word = i32;

    #[inline(always)]
    unsafe fn word(self) -> i32 {
        // SAFETY: the caller's promise: below 2^31.
        unsafe { self.round_ties_even().to_int_unchecked() }
    }

    #[inline(always)]
    fn dot(left: &[i32], right: &[i32]) -> f64 {
        // P has 64 bits, so that sums have 63.
        let terms = left.iter().zip(right).map(|(&l, &r)| i64::from(l) * i64::from(r));
        terms.fold(0_i64, i64::wrapping_add) as f64
    }
}

/// Lanes of the loops below.
const LANES: usize = 8;

/// Returns the exponent and the square of [`tile_norms`](super::tile::tile_norms) for the entries
/// of one column in a tile. Sums of squares are exact, so that their order does not matter.
#[inline(always)]
pub(crate) fn column_norm<T: Real>(entries: &[T]) -> (i32, f64) {
    // Signed, since AVX2 compares no unsigned integers.
    let bits = |x: T| (x.to_f64().to_bits() & MAGNITUDE) as i64;
    let largest = entries.iter().fold(0, |largest, &x| bits(x).max(largest));
    let exponent = norm_exponent(largest as u64);
    let power = norm_power(exponent);
    let (first, second) = (power_of_two(power >> 1), power_of_two(power - (power >> 1)));
    let square = |x: T| {
        let scaled = (x.to_f64().abs() * first * second).ceil();
        scaled * scaled
    };
    let (chunks, rest) = entries.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for chunk in chunks {
        for (sum, &x) in sums.iter_mut().zip(chunk) {
            *sum += square(x);
        }
    }
    (exponent, sums.iter().sum::<f64>() + rest.iter().map(|&x| square(x)).sum::<f64>())
}
