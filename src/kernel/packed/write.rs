//! Writes finished tiles to blocks of C.
//!
//! Everything here is inlined into functions that enable the instructions of one [`Vectors`].

use std::mem::MaybeUninit;
use std::ops::Range;

use super::target::{Scales, Target};
use super::vectors::{Vectors, low_bits};
use crate::base::Real;

/// Scalars of the largest tile: 8 x 48, f32 with AVX-512.
pub(super) const LARGEST_TILE: usize = 8 * 48;

/// Adds a tile of `height` x `width`, whose corner is entry `(row, col)` of the product, to a block
/// of C: `C := beta C + coefficient sums`, for the wanted entries inside the block.
///
/// # Safety
/// `sums` holds rows of WIDTH, computed where they are wanted; nobody else uses these entries of C.
#[inline(always)]
pub(super) unsafe fn write<V: Vectors>(
    mut sums: *const V::Scalar,
    target: &Target<V::Scalar>,
    row: usize,
    col: usize,
    height: usize,
    width: usize,
) {
    let height = height.min(target.rows.saturating_sub(row));
    let mut unscaled = MaybeUninit::<[V::Scalar; LARGEST_TILE]>::uninit();
    // SAFETY: clauses `instructions`, `sums` and `targets`: `height` ends at the last row of the
    // block, and the columns that it wants are those of its rows. `unscaled` has room for the
    // largest tile, and `unscale` writes what is read from it.
    unsafe {
        if let Some(scales) = target.scales() {
            let wanted = target.wanted_of(row..row + height);
            let wanted =
                wanted.start.saturating_sub(col)..wanted.end.saturating_sub(col).min(width);
            let out = unscaled.as_mut_ptr().cast();
            unscale::<V>(sums, &scales.at(row, col), height, wanted, out);
            sums = out;
        }
        if target.col_stride != 1 {
            write_elements::<V>(sums, target, row, col, height, width);
        } else {
            write_wanted::<V>(sums, target, row, col, height, width);
        }
    }
}

/// Writes the wanted entries of a tile like [`write()`], to a target stored by rows.
#[inline(always)]
unsafe fn write_wanted<V: Vectors>(
    sums: *const V::Scalar,
    target: &Target<V::Scalar>,
    row: usize,
    col: usize,
    height: usize,
    width: usize,
) {
    // SAFETY: clauses `instructions` and `targets`: `columns` are the wanted ones of each row,
    // below `width` and inside the block, and `write` has cut `height`. Whole vectors are loaded
    // from sums whose rows have WIDTH, a multiple of LANES.
    unsafe {
        let (c, beta) = (V::splat(target.coefficient), V::splat(target.beta));
        let reads = target.beta != V::Scalar::ZERO;
        let columns = target.columns_from(row, col, width);
        let mut start = target.at(row, col);
        for i in 0..height {
            let wanted = columns.of_row(i);
            let sums = sums.add(i * V::WIDTH);
            let mut at = wanted.start / V::LANES * V::LANES;
            while at < wanted.end {
                let to = start.wrapping_add(at);
                let is_whole = wanted.start <= at && at + V::LANES <= wanted.end;
                if is_whole || V::MASK_REGISTERS {
                    // With masks, tiles have all lanes of their last vectors.
                    let sum = V::mul(c, V::load(sums.add(at)));
                    if is_whole {
                        let sum = if reads { V::add(V::mul(beta, V::load(to)), sum) } else { sum };
                        V::store(to, sum);
                    } else {
                        let bits = columns.bits_of_row(i) >> at;
                        let old = || V::load_masked(to, V::mask(bits));
                        let sum = if reads { V::add(V::mul(beta, old()), sum) } else { sum };
                        V::store_lanes(to, bits, sum);
                    }
                } else {
                    // Without registers for masks, lanes beyond the tile have no sums.
                    for j in wanted.start.max(at)..wanted.end.min(at + V::LANES) {
                        let sum = target.coefficient * *sums.add(j);
                        let to = start.wrapping_add(j);
                        *to = if reads { target.beta * *to + sum } else { sum };
                    }
                }
                at += V::LANES;
            }
            start = start.wrapping_offset(target.row_stride);
        }
    }
}

/// Writes N vectors in each of ROWS rows like [`write()`], directly from registers to a target
/// without scales that is stored by rows: the wanted entries if `MASKED`, else all.
///
/// # Safety
/// As for [`write()`]; without `MASKED` the target [takes](Target::takes_whole) all entries.
#[inline(always)]
pub(super) unsafe fn write_registers<
    V: Vectors,
    const ROWS: usize,
    const N: usize,
    const MASKED: bool,
>(
    sums: [[V::Vector; N]; ROWS],
    target: &Target<V::Scalar>,
    row: usize,
    col: usize,
) {
    // SAFETY: clauses `instructions` and `targets`: with MASKED the bits are those of wanted
    // entries inside the block, without it the block takes all of the tile, as the caller has asked
    // `takes_whole`.
    unsafe {
        let (c, beta) = (V::splat(target.coefficient), V::splat(target.beta));
        let columns = target.columns_from(row, col, N * V::LANES);
        let start = target.at(row, col);
        // A loop for each case, short enough to be unrolled, so that the sums stay in registers.
        macro_rules! each_vector {
            ($sum:expr) => {
                for i in 0..ROWS {
                    let bits = columns.bits_of_row(i);
                    let row = start.wrapping_offset(i as isize * target.row_stride);
                    for j in 0..N {
                        let bits = bits >> (j * V::LANES);
                        let to = row.wrapping_add(j * V::LANES);
                        let sum = $sum(to, bits, V::mul(c, sums[i][j]));
                        if MASKED { V::store_lanes(to, bits, sum) } else { V::store(to, sum) }
                    }
                }
            };
        }
        if target.beta == V::Scalar::ZERO {
            each_vector!(|_, _, sum| sum);
        } else {
            each_vector!(|to, bits, sum| {
                let old = if MASKED { V::load_masked(to, V::mask(bits)) } else { V::load(to) };
                V::add(V::mul(beta, old), sum)
            });
        }
    }
}

/// Writes a tile like [`write()`], one entry after another, to a target of any strides.
#[inline(always)]
unsafe fn write_elements<V: Vectors>(
    sums: *const V::Scalar,
    target: &Target<V::Scalar>,
    row: usize,
    col: usize,
    height: usize,
    width: usize,
) {
    // SAFETY: clause `targets`: j runs over the wanted columns of row `row + i` in the tile, which
    // lie inside the block, and `write` has cut `height`.
    unsafe {
        for i in 0..height {
            let wanted = target.wanted(row + i);
            for j in wanted.start.max(col)..wanted.end.min(col + width) {
                let to = target.at(row + i, j);
                let sum = target.coefficient * *sums.add(i * V::WIDTH + j - col);
                let zero = target.beta == V::Scalar::ZERO;
                *to = if zero { sum } else { target.beta * *to + sum };
            }
        }
    }
}

/// Divides `height` rows and the columns `wanted` of a tile by their scales into `out`.
///
/// The result is exact unless it leaves the range of normal numbers. Intermediate results leave
/// that range only with it: a factor above 1 and one below 1 are first multiplied by each other,
/// two factors on the same side of 1 are applied one after the other.
///
/// # Safety
/// `sums` and `out` hold rows of WIDTH, and there are scales for these rows and columns: powers of
/// two whose inverses are finite, or infinities, which give zeros.
#[inline(always)]
unsafe fn unscale<V: Vectors>(
    sums: *const V::Scalar,
    scales: &Scales<V::Scalar>,
    height: usize,
    wanted: Range<usize>,
    out: *mut V::Scalar,
) {
    const { assert!(V::ROWS * V::WIDTH <= LARGEST_TILE) };
    // SAFETY: clauses `instructions` and `sums`: a tile has at most LARGEST_TILE scalars, as
    // asserted, and rows of WIDTH, a multiple of LANES, so that whole vectors end inside; scales
    // are read for the wanted columns only, by the mask, and for rows below `height`. All lanes of
    // the vectors that are loaded were written, those beyond `wanted` too: targets with scales have
    // sources with scales, which are packed, and `multiply_row` stores whole vectors from a
    // multiple of LANES on, for all rows. Only `multiply_in_place` leaves lanes unwritten, and it
    // asserts that its targets have no scales.
    unsafe {
        let one = V::splat(V::Scalar::ONE);
        let (first, end) = (wanted.start / V::LANES * V::LANES, wanted.end);
        for at in (first..end).step_by(V::LANES) {
            let mask = V::mask(low_bits(V::LANES.min(end - at)));
            let factors = V::div(one, V::load_masked(scales.cols.at(at as isize), mask));
            let (up, down) = (V::max(factors, one), V::min(factors, one));
            for i in 0..height {
                let factor = V::Scalar::ONE / *scales.rows.at(i as isize);
                let (against, along) =
                    if factor < V::Scalar::ONE { (up, down) } else { (down, up) };
                let sum = V::load(sums.add(i * V::WIDTH + at));
                let sum = V::mul(V::mul(sum, V::mul(V::splat(factor), against)), along);
                V::store(out.add(i * V::WIDTH + at), sum);
            }
        }
    }
}
