//! The arithmetic of small products, which fill no tiles: integers are multiplied as such instead
//! of by their residues. The results are the same.
//!
//! Columns are taken in strips of eight, and integers in parts of 32 bits, whose products have 64.
//! An integer of f64 has two parts, `low + high 2^28`; the product of their sums gives the two
//! mixed products at once (Karatsuba 1962).

use super::rounding::nearest_of_ordered;
use super::tile::power_of_two;
use crate::base::Real;

/// Columns of a strip.
pub(crate) const LANES: usize = 8;
/// One row of a strip: a part of the integer of each column.
pub(crate) type Row = [i32; LANES];
/// Sums of products of two strips: entry `[j][i]` belongs to column i of the left one and column j
/// of the right one.
pub(crate) type Products = [[i64; LANES]; LANES];

/// The most products of parts that a product of integers takes.
pub(crate) const MOST_PARTS: usize = 3;
/// The most rows whose sums fit 64 bits.
pub(crate) const MOST_ROWS: usize = 256;

/// Bits of the low part of an integer of f64, which is signed.
const LOW_BITS: i32 = 28;

/// A scalar whose integers are multiplied in parts.
pub trait Direct: Real {
    /// Products of parts that a product of integers takes, at most [`MOST_PARTS`].
    const PARTS: usize;

    /// Rounds the entries of a row to integers, ties to even, and returns the first [`Self::PARTS`]
    /// factors of their products.
    ///
    /// # Safety
    /// The integers are those of columns whose products are below P/2, of at most 118 bits (f32:
    /// 64 bits).
    unsafe fn parts(row: [Self; LANES]) -> [Row; MOST_PARTS];

    /// Adds the products of the parts of at most [`MOST_ROWS`] rows to the sums.
    fn accumulate(parts: &[Products; MOST_PARTS], sums: &mut [Products; MOST_PARTS]);

    /// Returns the sums of products with column j of the right strip, rounded to the nearest f64.
    fn values(sums: &[Products; MOST_PARTS], j: usize) -> [f64; LANES];
}

impl Direct for f64 {
    const PARTS: usize = 3;

    #[inline(always)]
    unsafe fn parts(row: [f64; LANES]) -> [Row; MOST_PARTS] {
        /// Added to a number below 2^51, rounds it to an integer.
        const ROUNDER: f64 = (3_u64 << 51) as f64;
        let (unit, inverse) = (power_of_two(LOW_BITS), power_of_two(-LOW_BITS));
        let mut parts = [[0; LANES]; MOST_PARTS];
        for j in 0..LANES {
            let integer = row[j].round_ties_even();
            let high = (integer * inverse + ROUNDER) - ROUNDER;
            let low = integer - high * unit;
            // SAFETY: the norm of the column is at most 2^58.5, so that the high part is below
            // 2^31 in magnitude, and the low part is at most 2^27.
            let [low, high] = [low, high].map(|part| unsafe { part.to_int_unchecked::<i32>() });
            (parts[0][j], parts[1][j], parts[2][j]) = (low, low + high, high);
        }
        parts
    }

    /// The sums become those of the low, the mixed and the high products, the first two below
    /// 2^28. Those of the parts wrap around, but not those of the mixed products, `2^28 16 2^30.5`
    /// for 256 rows: the norms of the low parts are at most `2^27 16`, those of the high parts
    /// 2^30.5.
    #[inline(always)]
    fn accumulate(parts: &[Products; MOST_PARTS], sums: &mut [Products; MOST_PARTS]) {
        const MASK: i64 = (1 << LOW_BITS) - 1;
        let [low, both, high] = parts.each_ref().map(|part| part.as_flattened());
        let [lows, mixed, highs] = sums.each_mut().map(|sums| sums.as_flattened_mut());
        for i in 0..LANES * LANES {
            let l = lows[i] + low[i];
            let m = both[i].wrapping_sub(low[i]).wrapping_sub(high[i]) + mixed[i] + (l >> LOW_BITS);
            lows[i] = l & MASK;
            mixed[i] = m & MASK;
            highs[i] += high[i] + (m >> LOW_BITS);
        }
    }

    #[inline(always)]
    fn values(sums: &[Products; MOST_PARTS], j: usize) -> [f64; LANES] {
        /// Bits of each of the two lower numbers that the sum is made of; they, and the highest,
        /// are exact in f64.
        const BITS: i32 = 41;
        const MASK: i64 = (1 << BITS) - 1;
        let [low, mixed, high] = sums.each_ref().map(|sums| sums[j]);
        let mut values = [0.0; LANES];
        for i in 0..LANES {
            let lower = low[i] | mixed[i] << LOW_BITS;
            let rest = 2 * BITS - 2 * LOW_BITS;
            let middle = lower >> BITS | (high[i] & ((1 << rest) - 1)) << (2 * LOW_BITS - BITS);
            values[i] = nearest_of_ordered([
                (high[i] >> rest) as f64 * power_of_two(2 * BITS),
                middle as f64 * power_of_two(BITS),
                (lower & MASK) as f64,
            ]);
        }
        values
    }
}

impl Direct for f32 {
    const PARTS: usize = 1;

    #[inline(always)]
    unsafe fn parts(row: [f32; LANES]) -> [Row; MOST_PARTS] {
        // SAFETY: the caller's promise: below 2^31.
        let integers = row.map(|x| unsafe { x.round_ties_even().to_int_unchecked() });
        [integers, [0; LANES], [0; LANES]]
    }

    /// The sums have 63 bits, as P has 64.
    #[inline(always)]
    fn accumulate(parts: &[Products; MOST_PARTS], sums: &mut [Products; MOST_PARTS]) {
        let products = parts[0].as_flattened();
        for (sum, &product) in sums[0].as_flattened_mut().iter_mut().zip(products) {
            *sum = sum.wrapping_add(product);
        }
    }

    #[inline(always)]
    fn values(sums: &[Products; MOST_PARTS], j: usize) -> [f64; LANES] {
        sums[0][j].map(|sum| sum as f64)
    }
}

/// Implements [`Kernel::multiply_strips`](super::Kernel::multiply_strips).
#[inline(always)]
pub(super) fn multiply_strips(left: &[Row], right: &[Row], products: &mut Products) {
    *products = [[0; LANES]; LANES];
    for (left, right) in left.iter().zip(right) {
        for (sums, &right) in products.iter_mut().zip(right) {
            for (sum, &left) in sums.iter_mut().zip(left) {
                *sum = sum.wrapping_add(i64::from(left) * i64::from(right));
            }
        }
    }
}
