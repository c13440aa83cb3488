//! The kernel in plain Rust, for any CPU. Tests compare the other kernels with this one.

use super::kernel::{Conversion, Kernel, Operands, Recombination, product_by_pairs};
use super::lane_set::LaneSet;
use super::moduli::{Modulus, WORD_BITS};
use super::recombine;
use super::tile::{
    PanelBlock, Quarter, Residues, STEP, Slice, Square, Tile, TileNorms, WIDTH, power_of_two,
    tile_norms,
};
use crate::base::Real;

pub(crate) struct Portable;

impl Kernel for Portable {
    fn norms_f64(&self, tile: &Tile<f64>) -> TileNorms {
        tile_norms(tile)
    }

    fn norms_f32(&self, tile: &Tile<f32>) -> TileNorms {
        tile_norms(tile)
    }

    fn convert_f64(&self, it: Conversion<'_, '_, f64>) {
        convert(it);
    }

    fn convert_f32(&self, it: Conversion<'_, '_, f32>) {
        convert(it);
    }

    fn convert_wide(&self, it: Conversion<'_, '_, f64>) {
        convert_wide(it);
    }

    fn product(&self, operands: &Operands<'_>, residues: &mut [PanelBlock<i8>]) {
        product_by_pairs(operands, residues, multiply, reduce);
    }

    fn lanes(&self) -> LaneSet {
        LaneSet::Portable
    }

    fn recombine(&self, it: Recombination<'_>, out: &mut Square<f64>) {
        recombine::block::<false>(it, out);
    }
}

/// Implements [`Kernel::convert_f64`] and [`Kernel::convert_f32`].
fn convert<T: Real>(Conversion { tile, powers, moduli, out, .. }: Conversion<'_, '_, T>) {
    // Byte `d` of every biased integer is in `digits[d]`.
    let mut digits = [[[0_u8; WIDTH]; STEP]; 8];
    for (i, row) in tile.0.iter().enumerate() {
        for j in 0..WIDTH {
            let scaled = row[j] * powers.first[j] * powers.second[j];
            let integer = scaled.to_f64().round_ties_even() as i64;
            for (digit, byte) in digits.iter_mut().zip((integer ^ i64::MIN).to_le_bytes()) {
                digit[i][j] = byte;
            }
        }
    }
    residues(&digits, moduli, |m| (m.start_64, m.weights), out);
}

/// Implements [`Kernel::convert_wide`]: digits are the bytes of the lower words, then those of the
/// higher words.
fn convert_wide(Conversion { tile, powers, moduli, out, .. }: Conversion<'_, '_, f64>) {
    let mut digits = [[[0_u8; WIDTH]; STEP]; 12];
    for (i, row) in tile.0.iter().enumerate() {
        for j in 0..WIDTH {
            let [low, high] = words(row[j] * powers.first[j] * powers.second[j]);
            let low = (low ^ i64::MIN).to_le_bytes();
            let high = (high as i32 ^ i32::MIN).to_le_bytes();
            for (digit, byte) in digits.iter_mut().zip(low.into_iter().chain(high)) {
                digit[i][j] = byte;
            }
        }
    }
    let weights = |m: &Modulus| {
        let ([a, b, c, d, e, f, g, h], [i, j, k, l]) = (m.weights, m.high_weights);
        [a, b, c, d, e, f, g, h, i, j, k, l]
    };
    residues(&digits, moduli, |m| (m.start_wide, weights(m)), out);
}

/// Rounds a number to an integer and returns its words `[low, high]`: `low + high 2^WORD_BITS`.
/// The split is exact, since both words are parts of the mantissa.
fn words(value: f64) -> [i64; 2] {
    let unit = power_of_two(WORD_BITS as i32);
    let high = (value / unit).round_ties_even();
    let low = (value - high * unit).round_ties_even();
    [low as i64, high as i64]
}

/// Computes the residues of numbers with the D digits `digits[d][i][j]`; `constants` returns the
/// start and the weights of a modulus.
fn residues<const D: usize>(
    digits: &[[[u8; WIDTH]; STEP]; D],
    moduli: &[Modulus],
    constants: impl Fn(&Modulus) -> (i32, [i8; D]),
    out: &mut [&mut Residues],
) {
    for (modulus, out) in moduli.iter().zip(out) {
        let (start, weights) = constants(modulus);
        for i in 0..STEP {
            let mut sums = [start; WIDTH];
            for (digit, weight) in digits.iter().zip(weights) {
                for j in 0..WIDTH {
                    sums[j] += i32::from(weight) * i32::from(digit[i][j]);
                }
            }
            for j in 0..WIDTH {
                out[64 * (i / 4) + 4 * j + i % 4] = finish(sums[j], modulus.p);
            }
        }
    }
}

/// Reduces sums to residues between -128 and 127. Inlined, so that the AVX2 kernel compiles it for
/// its registers.
#[inline(always)]
pub(super) fn reduce(sums: &PanelBlock<i32>, modulus: &Modulus, out: &mut PanelBlock<i8>) {
    let [w0, w1, w2, w3, ..] = modulus.weights.map(i32::from);
    let sums = sums.as_flattened().as_flattened();
    for (out, &sum) in out.as_flattened_mut().as_flattened_mut().iter_mut().zip(sums) {
        let [b0, b1, b2, b3] = (sum ^ i32::MIN).to_le_bytes().map(i32::from);
        let first = modulus.start_32 + w0 * b0 + w1 * b1 + w2 * b2 + w3 * b3;
        *out = finish(first, modulus.p);
    }
}

/// Reduces a sum of digits (see [`Modulus`]) to a residue between -128 and 127. As a float the sum
/// is exact, and the quotient before rounding is wrong by less than 2^-12.
#[inline(always)]
fn finish(sum: i32, p: i32) -> i8 {
    let quotient = (sum as f32 * (1.0 / p as f32)).round_ties_even() as i32;
    (sum - quotient * p) as i8
}

/// Adds the product of two panels to the sums.
fn multiply(left: &[Slice], right: &[Slice], sums: &mut PanelBlock<i32>) {
    for (quarter, sums) in sums.iter_mut().enumerate() {
        for (left, right) in left.iter().zip(right) {
            multiply_tiles(&left[quarter / 2], &right[quarter % 2], sums);
        }
    }
}

#[inline(always)]
fn multiply_tiles(left: &Residues, right: &Residues, sums: &mut Quarter<i32>) {
    for (left, right) in left.chunks_exact(64).zip(right.chunks_exact(64)) {
        for (left, sums) in left.chunks_exact(4).zip(sums.iter_mut()) {
            for (right, sum) in right.chunks_exact(4).zip(sums.iter_mut()) {
                for (&l, &r) in left.iter().zip(right) {
                    *sum += i32::from(l) * i32::from(r);
                }
            }
        }
    }
}
