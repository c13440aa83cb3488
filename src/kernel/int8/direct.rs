//! The arithmetic of small products, which fill no tiles: integers are multiplied as such instead
//! of by their residues. The results are the same.
//!
//! Columns are taken in strips of eight, and integers in parts of 32 bits, whose products have 64.
//! An integer of f64 has two parts, `low + high 2^28`; the product of their sums gives the two
//! mixed products at once (Karatsuba 1962).

use std::ops::Range;

use super::lanes::{LANES, Lanes, Row};
use super::tile::power_of_two;
use crate::base::Real;

/// The most rows whose sums fit 64 bits.
pub(super) const MOST_ROWS: usize = 256;

/// Bits of the low part of an integer of f64, which is signed.
const LOW_BITS: u32 = 28;

/// Added to a number below 2^51 in magnitude, rounds it to an integer (ties to even), whose bits
/// are then the lowest ones of the sum.
const ROUNDER: f64 = (3_u64 << 51) as f64;

/// Integers of 118 bits: the first two numbers are at most 28 bits of each, the last the rest.
type Sums<I> = [I; 3];

/// A scalar whose integers are multiplied in parts.
pub trait Direct: Real {
    /// Products of parts that a product of integers takes: 3 where they have two parts, else 1.
    const PARTS: usize;

    /// Reads adjacent numbers, as [`Lanes::read_f64`] does.
    ///
    /// # Safety
    /// As for [`Lanes::read_f64`].
    #[allow(private_interfaces, private_bounds)]
    unsafe fn read<L: Lanes>(lanes: L, from: *const Self, range: Range<usize>) -> L::Floats;

    /// Writes adjacent numbers, as [`Lanes::write_f64`] does.
    ///
    /// # Safety
    /// As for [`Lanes::write_f64`].
    #[allow(private_interfaces, private_bounds)]
    unsafe fn write<L: Lanes>(lanes: L, x: L::Floats, to: *mut Self, range: Range<usize>);
}

impl Direct for f64 {
    const PARTS: usize = 3;

    #[inline(always)]
    #[allow(private_interfaces, private_bounds)]
    unsafe fn read<L: Lanes>(lanes: L, from: *const f64, range: Range<usize>) -> L::Floats {
        // SAFETY: the contract is that of `read_f64`: so many numbers as the range is long can be
        // read.
        unsafe { lanes.read_f64(from, range) }
    }

    #[inline(always)]
    #[allow(private_interfaces, private_bounds)]
    unsafe fn write<L: Lanes>(lanes: L, x: L::Floats, to: *mut f64, range: Range<usize>) {
        // SAFETY: the contract is that of `write_f64`: there is room for so many numbers as the
        // range is long.
        unsafe { lanes.write_f64(x, to, range) }
    }
}

impl Direct for f32 {
    const PARTS: usize = 1;

    #[inline(always)]
    #[allow(private_interfaces, private_bounds)]
    unsafe fn read<L: Lanes>(lanes: L, from: *const f32, range: Range<usize>) -> L::Floats {
        // SAFETY: the contract is that of `read_f32`: so many numbers as the range is long can be
        // read.
        unsafe { lanes.read_f32(from, range) }
    }

    #[inline(always)]
    #[allow(private_interfaces, private_bounds)]
    unsafe fn write<L: Lanes>(lanes: L, x: L::Floats, to: *mut f32, range: Range<usize>) {
        // SAFETY: the contract is that of `write_f32`: there is room for so many numbers as the
        // range is long.
        unsafe { lanes.write_f32(x, to, range) }
    }
}

/// Multiplies the columns of a strip of floats by `powers`, and rounds them to integers (ties to
/// even), whose two parts take the place of the float. Writes the sums of both parts to `both`.
///
/// The integers are those of columns whose products are below P/2, of at most 118 bits (f32: 64
/// bits).
#[inline(always)]
pub(crate) fn to_integers<L: Lanes, T: Direct>(
    lanes: L,
    rows: &mut [Row],
    powers: L::Floats,
    both: &mut [[i32; LANES]],
) {
    let rounder = lanes.splat(ROUNDER);
    let unit = lanes.splat(-power_of_two(LOW_BITS as i32));
    let inverse = lanes.splat(power_of_two(-(LOW_BITS as i32)));
    let low_half = lanes.splat_integer(i64::from(u32::MAX));
    for (row, both) in rows.iter_mut().zip(both) {
        let entries = lanes.floats(lanes.load_row(row));
        if T::PARTS == 1 {
            lanes.store_row(lanes.bits(lanes.mul_add(entries, powers, rounder)), row);
            continue;
        }
        // The norm of a column is at most 2^58.5, so that the high part is below 2^31 in
        // magnitude; what remains is exact, and at most 2^27 before it is rounded.
        let scaled = lanes.mul(entries, powers);
        let high = lanes.mul_add(scaled, inverse, rounder);
        let low = lanes.mul_add(lanes.sub(high, rounder), unit, scaled);
        let (high, low) = (lanes.bits(high), lanes.bits(lanes.add(low, rounder)));
        lanes.store_low(lanes.add_integers(low, high), both);
        lanes.store_row(lanes.or(lanes.and(low, low_half), lanes.shift_left::<32>(high)), row);
    }
}

/// A column of the right side of a product.
#[derive(Clone, Copy)]
pub(crate) struct Right<'s> {
    /// Its strip, from [`to_integers`].
    pub rows: &'s [Row],
    pub both: &'s [[i32; LANES]],
    /// The place of the column in the strip.
    pub lane: usize,
}

/// Returns the products of the columns of the left strip with each of the right columns, rounded to
/// the nearest f64.
///
/// # Panics
/// Unless all columns have as many rows.
#[inline(always)]
pub(crate) fn products<L: Lanes, T: Direct, const COUNT: usize>(
    lanes: L,
    left: &[Row],
    right: [Right<'_>; COUNT],
) -> [L::Floats; COUNT] {
    for column in &right {
        let (rows, both) = (column.rows.len(), column.both.len());
        assert!(rows == left.len() && both == rows && column.lane < LANES);
    }
    let zero = lanes.splat_integer(0);
    let mut sums = [[zero; 3]; COUNT];
    let mut first = 0;
    while first < left.len() {
        let end = left.len().min(first + MOST_ROWS);
        let mut parts = [[zero; 3]; COUNT];
        for i in first..end {
            // SAFETY: `i < left.len()`.
            let low = lanes.load_row(unsafe { left.get_unchecked(i) });
            let high = lanes.shift_right::<32>(low);
            let both = lanes.add_integers(low, high);
            for j in 0..COUNT {
                let Right { rows, both: sums, lane } = right[j];
                // SAFETY: `i` is below the length of both, and `lane` below LANES, as asserted
                // above.
                let ([of_low, of_high], of_both) = unsafe {
                    let row = *rows.get_unchecked(i).get_unchecked(lane);
                    (row, *sums.get_unchecked(i).get_unchecked(lane))
                };
                let [lows, mixed, highs] = parts[j];
                parts[j][0] = add_product(lanes, lows, low, of_low);
                if T::PARTS > 1 {
                    parts[j][1] = add_product(lanes, mixed, both, of_both);
                    parts[j][2] = add_product(lanes, highs, high, of_high);
                }
            }
        }
        for j in 0..COUNT {
            sums[j] = carried::<L, T>(lanes, parts[j], sums[j]);
        }
        first = end;
    }
    let mut values = [lanes.splat(0.0); COUNT];
    for j in 0..COUNT {
        values[j] = match T::PARTS {
            1 => nearest_of_one(lanes, sums[j][0]),
            _ => nearest(lanes, sums[j]),
        };
    }
    values
}

/// Returns `sum + left right`.
#[inline(always)]
fn add_product<L: Lanes>(lanes: L, sum: L::Integers, left: L::Integers, right: i32) -> L::Integers {
    lanes.add_integers(sum, lanes.mul_low(left, lanes.splat_low(right)))
}

/// Adds the products of the parts of at most [`MOST_ROWS`] rows to the sums.
///
/// The sums become those of the low, the mixed and the high products, the first two below 2^28.
/// Those of the parts wrap around, but not those of the mixed products, `2^28 16 2^30.5` for 256
/// rows: the norms of the low parts are at most `2^27 16`, those of the high parts 2^30.5. In f32
/// the sums have 63 bits, as P has 64.
#[inline(always)]
fn carried<L: Lanes, T: Direct>(
    lanes: L,
    [low, both, high]: [L::Integers; 3],
    [lows, mixed, highs]: Sums<L::Integers>,
) -> Sums<L::Integers> {
    if T::PARTS == 1 {
        return [lanes.add_integers(low, lows), mixed, highs];
    }
    let mask = lanes.splat_integer((1 << LOW_BITS) - 1);
    let middle = lanes.sub_integers(lanes.sub_integers(both, low), high);
    let middle = lanes.add_integers(middle, mixed);
    let low = lanes.add_integers(low, lows);
    let middle = lanes.add_integers(middle, lanes.shift_right_signed::<LOW_BITS>(low));
    let high = lanes.add_integers(high, highs);
    let high = lanes.add_integers(high, lanes.shift_right_signed::<LOW_BITS>(middle));
    [lanes.and(low, mask), lanes.and(middle, mask), high]
}

/// Bits of the lower two of the three numbers that a sum is made of; they, and the highest, are
/// exact in f64.
const BITS: u32 = 41;

/// Returns integers below 2^51 in magnitude as floats.
#[inline(always)]
fn to_floats<L: Lanes>(lanes: L, x: L::Integers) -> L::Floats {
    let rounder = lanes.splat(ROUNDER);
    lanes.sub(lanes.floats(lanes.add_integers(x, lanes.bits(rounder))), rounder)
}

/// Returns sums, rounded to the nearest f64.
#[inline(always)]
fn nearest<L: Lanes>(lanes: L, [low, mixed, high]: Sums<L::Integers>) -> L::Floats {
    const REST: u32 = 2 * BITS - 2 * LOW_BITS;
    let lower = lanes.or(low, lanes.shift_left::<LOW_BITS>(mixed));
    let rest = lanes.and(high, lanes.splat_integer((1 << REST) - 1));
    let middle = lanes
        .or(lanes.shift_right::<BITS>(lower), lanes.shift_left::<{ 2 * LOW_BITS - BITS }>(rest));
    let last = to_floats(lanes, lanes.and(lower, lanes.splat_integer((1 << BITS) - 1)));
    let middle = lanes.mul(to_floats(lanes, middle), lanes.splat(power_of_two(BITS as i32)));
    let first = to_floats(lanes, lanes.shift_right_signed::<REST>(high));
    let first = lanes.mul(first, lanes.splat(power_of_two(2 * BITS as i32)));
    // Each number is zero, or larger than what is added to it, so that errors are exact (Dekker
    // 1971).
    let head = lanes.add(first, middle);
    let error = lanes.sub(middle, lanes.sub(head, first));
    let tail = lanes.add(error, last);
    let rest = lanes.sub(last, lanes.sub(tail, error));
    lanes.add(head, to_odd(lanes, tail, rest))
}

/// Returns `sum`, with an odd mantissa if it has an error. Added to a larger number, it is rounded
/// as if it had all its bits (Boldo and Melquiond 2008).
#[inline(always)]
fn to_odd<L: Lanes>(lanes: L, sum: L::Floats, error: L::Floats) -> L::Floats {
    let (bits, one) = (lanes.bits(sum), lanes.splat_integer(1));
    let signs = lanes.xor(bits, lanes.bits(error));
    // Away from zero where the error has the same sign, else towards it.
    let step = lanes.or(lanes.shift_right_signed::<63>(signs), one);
    let even = lanes.sub_integers(lanes.and(bits, one), one);
    let step = lanes.and(step, lanes.and(even, lanes.where_nonzero(error)));
    lanes.floats(lanes.add_integers(bits, step))
}

/// Returns integers of 63 bits, rounded to the nearest f64.
#[inline(always)]
fn nearest_of_one<L: Lanes>(lanes: L, sums: L::Integers) -> L::Floats {
    let high = to_floats(lanes, lanes.shift_right_signed::<32>(sums));
    let low = to_floats(lanes, lanes.and(sums, lanes.splat_integer(i64::from(u32::MAX))));
    lanes.add(lanes.mul(high, lanes.splat(power_of_two(32))), low)
}
