//! The kernels for NEON: `sdot` multiplies the four bytes of a dword, and `smmla` matrices of two
//! rows and eight columns. Norms, the reduction of sums and recombination are the portable code,
//! which compilers vectorize for NEON.
//!
//! Both instructions are assembly: their intrinsics are not stable.

use std::arch::aarch64::*;
use std::arch::{asm, is_aarch64_feature_detected};

use super::kernel::{Conversion, Kernel, Operands, Recombination, product_by_pairs};
use super::lane_set::LaneSet;
use super::moduli::{Modulus, WORD_BITS};
use super::tile::{
    DEPTH, PanelBlock, Powers, Residues, STEP, Slice, Square, Tile, TileNorms, WIDTH, power_of_two,
    tile_norms,
};
use super::{portable, recombine};
use crate::base::IsaLevel;

/// The kernel. A value exists only if the CPU has `sdot`, and also `smmla` if `smmla` is set, so
/// the calls below are sound.
pub(super) struct Neon {
    smmla: bool,
}

impl Neon {
    /// Returns the kernel with `sdot` alone, or why this machine can't use it.
    pub fn with_dotprod() -> Result<&'static Self, &'static str> {
        IsaLevel::Dotprod.permitted()?;
        let found = is_aarch64_feature_detected!("dotprod");
        if found { Ok(&Self { smmla: false }) } else { Err("the CPU has no dot products of bytes") }
    }

    /// Returns the kernel with `smmla`, or why this machine can't use it.
    pub fn with_i8mm() -> Result<&'static Self, &'static str> {
        IsaLevel::I8mm.permitted()?;
        let found = is_aarch64_feature_detected!("dotprod") && is_aarch64_feature_detected!("i8mm");
        if found { Ok(&Self { smmla: true }) } else { Err("the CPU has no products of matrices") }
    }
}

impl Kernel for Neon {
    fn norms_f64(&self, tile: &Tile<f64>) -> TileNorms {
        tile_norms(tile)
    }

    fn norms_f32(&self, tile: &Tile<f32>) -> TileNorms {
        tile_norms(tile)
    }

    fn convert_f64(&self, it: Conversion<'_, '_, f64>) {
        // SAFETY: `self` exists, so the CPU has the instructions.
        unsafe { convert_f64(it) }
    }

    fn convert_f32(&self, it: Conversion<'_, '_, f32>) {
        // SAFETY: `self` exists, so the CPU has the instructions.
        unsafe { convert_f32(it) }
    }

    fn convert_wide(&self, it: Conversion<'_, '_, f64>) {
        // SAFETY: `self` exists, so the CPU has the instructions.
        unsafe { convert_wide(it) }
    }

    fn to_left(&self, right: &[Slice], left: &mut [Slice]) {
        if self.smmla {
            // SAFETY: every AArch64 CPU has NEON.
            unsafe { interleave(right, left) }
        } else {
            left.copy_from_slice(right);
        }
    }

    fn product(&self, operands: &Operands<'_>, residues: &mut [PanelBlock<i8>]) {
        if !self.smmla {
            // SAFETY: `self` exists, so the CPU has the instruction.
            let add = |l: &[Slice], r: &[Slice], sums: &mut _| unsafe { add_dots(l, r, sums) };
            return product_by_pairs(operands, residues, add, portable::reduce);
        }
        let mut right = [[[0; STEP * WIDTH]; 2]; DEPTH];
        let right = &mut right[..operands.right.len()];
        self.to_left(operands.right, right);
        // SAFETY: `self` exists with `smmla`, so the CPU has the instruction.
        let add = |l: &[Slice], r: &[Slice], sums: &mut _| unsafe { add_matrices(l, r, sums) };
        product_by_pairs(&Operands { right, ..*operands }, residues, add, portable::reduce);
    }

    fn recombine(&self, it: Recombination<'_>, out: &mut Square<f64>) {
        recombine::block::<true>(it, out);
    }

    fn lanes(&self) -> LaneSet {
        LaneSet::Portable
    }
}

#[inline]
#[target_feature(enable = "neon")]
fn load_f64(from: &[f64; 2]) -> float64x2_t {
    // SAFETY: the array has the two numbers that are read.
    unsafe { vld1q_f64(from.as_ptr()) }
}

#[inline]
#[target_feature(enable = "neon")]
fn load_f32(from: &[f32; 4]) -> float32x4_t {
    // SAFETY: the array has the four numbers that are read.
    unsafe { vld1q_f32(from.as_ptr()) }
}

#[inline]
#[target_feature(enable = "neon")]
fn load_bytes(from: &[i8; 16]) -> int8x16_t {
    // SAFETY: the array has the 16 bytes that are read.
    unsafe { vld1q_s8(from.as_ptr()) }
}

#[inline]
#[target_feature(enable = "neon")]
fn store_bytes(bytes: int8x16_t, to: &mut [i8; 16]) {
    // SAFETY: the array has the 16 bytes that are written.
    unsafe { vst1q_s8(to.as_mut_ptr(), bytes) }
}

/// Implements [`Kernel::convert_f64`].
#[target_feature(enable = "dotprod")]
fn convert_f64(Conversion { tile, powers, moduli, out, .. }: Conversion<'_, '_, f64>) {
    let dwords = all_dwords(tile, powers, |values| digits(values.map(|x| vcvtnq_s64_f64(x))));
    residues(&dwords, moduli, out);
}

/// Implements [`Kernel::convert_wide`]: dwords are the low and high dwords of the lower words, then
/// the higher words.
#[target_feature(enable = "dotprod")]
fn convert_wide(Conversion { tile, powers, moduli, out, .. }: Conversion<'_, '_, f64>) {
    let unit = power_of_two(WORD_BITS as i32);
    let dwords = all_dwords(tile, powers, |values| {
        let high = values.map(|x| vrndnq_f64(vmulq_n_f64(x, 1.0 / unit)));
        let low = [0, 1].map(|i| vfmsq_n_f64(values[i], high[i], unit));
        let [low, middle] = digits(low.map(|x| vcvtnq_s64_f64(x)));
        let [first, second] = high.map(|x| vreinterpretq_s32_s64(vcvtnq_s64_f64(x)));
        [low, middle, signed_digits(vuzp1q_s32(first, second), true)]
    });
    residues(&dwords, moduli, out);
}

/// Implements [`Kernel::convert_f32`].
#[target_feature(enable = "dotprod")]
fn convert_f32(Conversion { tile, powers, moduli, out, .. }: Conversion<'_, '_, f32>) {
    let mut dwords = [[[vdupq_n_s8(0); 1]; WIDTH / 4]; STEP];
    for (dwords, row) in dwords.iter_mut().zip(&tile.0) {
        for (quarter, dwords) in dwords.iter_mut().enumerate() {
            let load = |from: &[f32; WIDTH]| load_f32(&from.as_chunks().0[quarter]);
            let value = vmulq_f32(vmulq_f32(load(row), load(&powers.first)), load(&powers.second));
            *dwords = [signed_digits(vcvtnq_s32_f32(value), true)];
        }
    }
    residues(&dwords, moduli, out);
}

/// Returns the D dwords of four entries at a time, scaled, as signed digits; `split` returns the
/// dwords of four entries.
#[inline]
#[target_feature(enable = "neon")]
fn all_dwords<const D: usize>(
    tile: &Tile<f64>,
    powers: &Powers<f64>,
    split: impl Fn([float64x2_t; 2]) -> [int8x16_t; D],
) -> [[[int8x16_t; D]; WIDTH / 4]; STEP] {
    let mut dwords = [[[vdupq_n_s8(0); D]; WIDTH / 4]; STEP];
    for (dwords, row) in dwords.iter_mut().zip(&tile.0) {
        for (quarter, dwords) in dwords.iter_mut().enumerate() {
            *dwords = split([0, 1].map(|half| {
                let load = |from: &[f64; WIDTH]| load_f64(&from.as_chunks().0[2 * quarter + half]);
                vmulq_f64(vmulq_f64(load(row), load(&powers.first)), load(&powers.second))
            }));
        }
    }
    dwords
}

/// Returns the digits of four integers: of their lower dwords, then of the higher ones.
#[inline]
#[target_feature(enable = "neon")]
fn digits(integers: [int64x2_t; 2]) -> [int8x16_t; 2] {
    let [first, second] = integers.map(|x| vreinterpretq_s32_s64(x));
    let (low, high) = (vuzp1q_s32(first, second), vuzp2q_s32(first, second));
    [signed_digits(low, false), signed_digits(high, true)]
}

/// Returns the bytes of dwords, less 128 each, after 2^31 was added to the dwords that are the
/// `highest` of their numbers (see [`Modulus`]).
#[inline]
#[target_feature(enable = "neon")]
fn signed_digits(dwords: int32x4_t, highest: bool) -> int8x16_t {
    let flipped = if highest { 0x0080_8080 } else { 0x8080_8080 };
    vreinterpretq_s8_u32(veorq_u32(vreinterpretq_u32_s32(dwords), vdupq_n_u32(flipped)))
}

/// Adds to each sum the dot product of its dword of `a` with dword `LANE` of `b`.
#[inline]
#[target_feature(enable = "dotprod")]
fn dot<const LANE: usize>(mut sums: int32x4_t, a: int8x16_t, b: int8x16_t) -> int32x4_t {
    // SAFETY: the attribute enables the instruction, so only code that has found it gets here, and
    // only registers are touched.
    unsafe {
        asm!("sdot {sums:v}.4s, {a:v}.16b, {b:v}.4b[{lane}]", sums = inout(vreg) sums,
            a = in(vreg) a, b = in(vreg) b, lane = const LANE,
            options(pure, nomem, nostack, preserves_flags));
    }
    sums
}

/// Adds to the 2 x 2 sums the products of the rows of `a` with those of `b`, eight bytes each.
#[inline]
#[target_feature(enable = "neon,i8mm")]
fn matrix_product(mut sums: int32x4_t, a: int8x16_t, b: int8x16_t) -> int32x4_t {
    // SAFETY: the attribute enables the instruction, so only code that has found it gets here, and
    // only registers are touched.
    unsafe {
        asm!("smmla {sums:v}.4s, {a:v}.16b, {b:v}.16b", sums = inout(vreg) sums,
            a = in(vreg) a, b = in(vreg) b, options(pure, nomem, nostack, preserves_flags));
    }
    sums
}

/// Computes the residues of numbers of D dwords.
#[target_feature(enable = "dotprod")]
fn residues<const D: usize>(
    dwords: &[[[int8x16_t; D]; WIDTH / 4]; STEP],
    moduli: &[Modulus],
    out: &mut [&mut Residues],
) {
    for (modulus, out) in moduli.iter().zip(out) {
        let start = [modulus.start_32, modulus.start_64, modulus.start_wide][D - 1];
        let mut weights = [0; 16];
        weights[..8].copy_from_slice(&modulus.weights);
        weights[8..12].copy_from_slice(&modulus.high_weights);
        // Digits are 128 too small.
        let sum: i32 = weights[..4 * D].iter().map(|&weight| i32::from(weight)).sum();
        let (start, weights) = (vdupq_n_s32(start + 128 * sum), load_bytes(&weights));
        let lines = out.as_chunks_mut::<16>().0.as_chunks_mut::<{ WIDTH / 4 }>().0;
        for (rows, lines) in dwords.as_chunks::<4>().0.iter().zip(lines) {
            for (quarter, line) in lines.iter_mut().enumerate() {
                let [r0, r1, r2, r3] = rows.each_ref().map(|row| {
                    let dwords = &row[quarter];
                    let mut sums = dot::<0>(start, dwords[0], weights);
                    if D > 1 {
                        sums = dot::<1>(sums, dwords[1], weights);
                    }
                    if D > 2 {
                        sums = dot::<2>(sums, dwords[2], weights);
                    }
                    finish(sums, modulus.p)
                });
                let pair = vsliq_n_s32::<16>(vsliq_n_s32::<8>(r0, r1), r2);
                store_bytes(vreinterpretq_s8_s32(vsliq_n_s32::<24>(pair, r3)), line);
            }
        }
    }
}

/// Reduces sums of digits (see [`Modulus`]) to residues between -128 and 127. As floats the sums
/// are exact, and the quotients before rounding are wrong by less than 2^-12.
#[inline]
#[target_feature(enable = "neon")]
fn finish(sums: int32x4_t, p: i32) -> int32x4_t {
    let quotient = vcvtnq_s32_f32(vmulq_n_f32(vcvtq_f32_s32(sums), 1.0 / p as f32));
    vmlsq_n_s32(sums, quotient, p)
}

/// The pieces of a quarter whose 8 x 8 sums are held in registers: the halves of rows and columns.
const PIECES: [(usize, usize); 4] = [(0, 0), (0, 1), (1, 0), (1, 1)];

/// Returns the registers of one half of each row, R of 2 R, in the iterations of the inner loop.
/// The remainder saves a check in that loop.
#[inline(always)]
fn halves<const R: usize>(tile: &Residues, half: usize) -> impl Iterator<Item = &[[i8; 16]; R]> {
    let rows = tile.as_chunks().0.as_chunks().0.as_chunks::<2>().0.iter();
    rows.map(move |row| &row[half % 2])
}

/// Adds the product of two panels to the sums.
#[target_feature(enable = "dotprod")]
fn add_dots(left: &[Slice], right: &[Slice], sums: &mut PanelBlock<i32>) {
    for (quarter, sums) in sums.iter_mut().enumerate() {
        for (i, j) in PIECES {
            let mut held = [[vdupq_n_s32(0); 2]; 8];
            for (left, right) in left.iter().zip(right) {
                let left = halves::<2>(&left[quarter / 2], i);
                for ([l0, l1], right) in left.zip(halves::<2>(&right[quarter % 2], j)) {
                    let (l0, l1) = (load_bytes(l0), load_bytes(l1));
                    for (c, r) in right.iter().enumerate() {
                        let r = load_bytes(r);
                        held[0][c] = dot::<0>(held[0][c], r, l0);
                        held[1][c] = dot::<1>(held[1][c], r, l0);
                        held[2][c] = dot::<2>(held[2][c], r, l0);
                        held[3][c] = dot::<3>(held[3][c], r, l0);
                        held[4][c] = dot::<0>(held[4][c], r, l1);
                        held[5][c] = dot::<1>(held[5][c], r, l1);
                        held[6][c] = dot::<2>(held[6][c], r, l1);
                        held[7][c] = dot::<3>(held[7][c], r, l1);
                    }
                }
            }
            for (sums, held) in sums[8 * i..].iter_mut().zip(held) {
                for (sums, held) in sums[8 * j..].as_chunks_mut().0.iter_mut().zip(held) {
                    add_to(sums, held);
                }
            }
        }
    }
}

/// Adds four sums to those in memory.
#[inline]
#[target_feature(enable = "neon")]
fn add_to(sums: &mut [i32; 4], held: int32x4_t) {
    // SAFETY: `sums` has the four numbers that are read and written.
    unsafe { vst1q_s32(sums.as_mut_ptr(), vaddq_s32(vld1q_s32(sums.as_ptr()), held)) }
}

/// Rearranges residues for [`add_matrices`]: 16 bytes hold eight rows of two columns.
#[target_feature(enable = "neon")]
fn interleave(from: &[Slice], to: &mut [Slice]) {
    let (from, to) = (from.as_flattened().as_flattened(), to.as_flattened_mut().as_flattened_mut());
    for (from, to) in from.as_chunks::<128>().0.iter().zip(to.as_chunks_mut::<128>().0) {
        for (four, to) in to.as_chunks_mut::<32>().0.iter_mut().enumerate() {
            let [upper, lower] = [0, WIDTH / 4]
                .map(|row| vreinterpretq_s32_s8(load_bytes(&from.as_chunks().0[row + four])));
            let [first, second] = [vzip1q_s32(upper, lower), vzip2q_s32(upper, lower)];
            let (to, _) = to.as_chunks_mut();
            store_bytes(vreinterpretq_s8_s32(first), &mut to[0]);
            store_bytes(vreinterpretq_s8_s32(second), &mut to[1]);
        }
    }
}

/// Adds the product of two panels that [`interleave`] rearranged to the sums.
#[target_feature(enable = "neon,i8mm")]
fn add_matrices(left: &[Slice], right: &[Slice], sums: &mut PanelBlock<i32>) {
    for (quarter, sums) in sums.iter_mut().enumerate() {
        for (i, j) in PIECES {
            let mut held = [[vdupq_n_s32(0); 4]; 4];
            for (left, right) in left.iter().zip(right) {
                let left = halves::<4>(&left[quarter / 2], i);
                for (left, right) in left.zip(halves::<4>(&right[quarter % 2], j)) {
                    let load = |from: &[[i8; 16]; 4]| from.each_ref().map(|r| load_bytes(r));
                    let (l, r) = (load(left), load(right));
                    for a in 0..4 {
                        for b in 0..4 {
                            held[a][b] = matrix_product(held[a][b], l[a], r[b]);
                        }
                    }
                }
            }
            for (rows, held) in sums[8 * i..].as_chunks_mut::<2>().0.iter_mut().zip(held) {
                for (k, pair) in held.as_chunks::<2>().0.iter().enumerate() {
                    let [first, second] = pair.map(|block| vreinterpretq_s64_s32(block));
                    let both = [vzip1q_s64(first, second), vzip2q_s64(first, second)];
                    for (row, sums) in rows.iter_mut().zip(both) {
                        let at = &mut row.as_chunks_mut().0[2 * j + k];
                        add_to(at, vreinterpretq_s32_s64(sums));
                    }
                }
            }
        }
    }
}
