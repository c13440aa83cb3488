//! The kernels for AVX2 and AVX-VNNI, which differ in their products: of 16-bit numbers, added in
//! pairs, or by dot products of bytes ([`dots`](super::dots)). Norms, the reduction of the sums of
//! pairs and recombination are the portable code, compiled for AVX2.

use std::arch::x86_64::*;

use super::kernel::{Conversion, Kernel, Operands, Recombination, product_by_pairs};
use super::lane_set::LaneSet;
use super::lanes_avx2::Avx2Lanes;
use super::moduli::{Modulus, WORD_BITS};
use super::tile::{
    PanelBlock, Powers, Residues, STEP, Slice, Square, Tile, TileNorms, WIDTH, biased,
    power_of_two, tile_norms,
};
use super::{portable, recombine};
use crate::base::IsaLevel;

/// The kernel. A value exists only if the CPU has AVX2, FMA and the instructions of `dots`, so the
/// calls below are sound.
pub(super) struct Avx2 {
    /// Implements [`Kernel::product`] by dot products, with the left side biased by 128.
    dots: Option<Product>,
}

/// A function with the signature of [`Kernel::product`].
type Product = unsafe fn(&Operands<'_>, &mut [PanelBlock<i8>]);

static AVX2: Avx2 = Avx2 { dots: None };

impl Avx2 {
    /// Returns the kernel without dot products, or why this machine can't use it.
    pub fn new() -> Result<&'static Self, &'static str> {
        IsaLevel::Avx2.permitted()?;
        let found = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
        if found { Ok(&AVX2) } else { Err("the CPU has no AVX2 with FMA") }
    }

    /// Returns the kernel with this [`Kernel::product`] by dot products.
    ///
    /// # Safety
    /// The kernel is used only where the CPU has AVX2, FMA and the instructions of `product`.
    pub const unsafe fn with_dots(product: Product) -> Self {
        Self { dots: Some(product) }
    }
}

/// Calls a function with the instructions of this module enabled.
macro_rules! enabled {
    ($function:expr => ($($name:ident: $t:ty),*) $(-> $out:ty)?) => {{
        #[target_feature(enable = "avx2,fma")]
        fn run($($name: $t),*) $(-> $out)? {
            $function($($name),*)
        }
        // SAFETY: a method of `Avx2`, which exists only where the CPU has the instructions.
        unsafe { run($($name),*) }
    }};
}

impl Kernel for Avx2 {
    fn norms_f64(&self, tile: &Tile<f64>) -> TileNorms {
        enabled!(tile_norms => (tile: &Tile<f64>) -> TileNorms)
    }

    fn norms_f32(&self, tile: &Tile<f32>) -> TileNorms {
        enabled!(tile_norms => (tile: &Tile<f32>) -> TileNorms)
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
        if self.dots.is_some() { biased(right, left) } else { left.copy_from_slice(right) }
    }

    fn product(&self, operands: &Operands<'_>, residues: &mut [PanelBlock<i8>]) {
        if let Some(product) = self.dots {
            // SAFETY: `self` exists, so the CPU has the instructions.
            return unsafe { product(operands, residues) };
        }
        product_by_pairs(
            operands,
            residues,
            // SAFETY: `self` exists, so the CPU has the instructions.
            |left, right, sums| unsafe { multiply(left, right, sums) },
            |sums, modulus, out| {
                enabled!(portable::reduce =>
                    (sums: &PanelBlock<i32>, modulus: &Modulus, out: &mut PanelBlock<i8>))
            },
        );
    }

    fn recombine(&self, it: Recombination<'_>, out: &mut Square<f64>) {
        enabled!(recombine::block::<true> =>
            (it: Recombination<'_>, out: &mut Square<f64>))
    }

    fn lanes(&self) -> LaneSet {
        // SAFETY: `self` exists, so the CPU has the instructions.
        LaneSet::Avx2(unsafe { Avx2Lanes::new() })
    }
}

/// The bytes of eight biased dwords as 16-bit numbers: the first and third of each dword, then the
/// second and fourth.
type Digits = [__m256i; 2];

#[target_feature(enable = "avx2,fma")]
fn digits(dwords: __m256i) -> Digits {
    let low = _mm256_set1_epi32(0x00ff_00ff);
    [_mm256_and_si256(dwords, low), _mm256_and_si256(_mm256_srli_epi32::<8>(dwords), low)]
}

/// Broadcasts four weights of a modulus, in the order of [`Digits`].
#[target_feature(enable = "avx2,fma")]
fn pairs(weights: &[i8]) -> [__m256i; 2] {
    let pair = |first: i8, second: i8| {
        _mm256_set1_epi32(i32::from(second) << 16 | (i32::from(first) & 0xffff))
    };
    [pair(weights[0], weights[2]), pair(weights[1], weights[3])]
}

#[target_feature(enable = "avx2,fma")]
fn add_products(sums: __m256i, digits: Digits, weights: [__m256i; 2]) -> __m256i {
    let [even, odd] = std::array::from_fn(|i| _mm256_madd_epi16(digits[i], weights[i]));
    _mm256_add_epi32(sums, _mm256_add_epi32(even, odd))
}

/// Reduces sums of digits (see [`Modulus`]) to residues between -128 and 127. As floats the sums
/// are exact, and the quotients before rounding are wrong by less than 2^-12.
#[inline]
#[target_feature(enable = "avx2,fma")]
pub(super) fn finish(sums: __m256i, p: i32) -> __m256i {
    let quotient = _mm256_mul_ps(_mm256_cvtepi32_ps(sums), _mm256_set1_ps(1.0 / p as f32));
    let quotient = _mm256_cvtps_epi32(quotient);
    _mm256_sub_epi32(sums, _mm256_mullo_epi32(quotient, _mm256_set1_epi32(p)))
}

/// Stores the residues of rows `4 r .. 4 r + 4` and eight columns from `8 half` on.
#[target_feature(enable = "avx2,fma")]
fn store(rows: [__m256i; 4], out: &mut Residues, r: usize, half: usize) {
    let byte = _mm256_set1_epi32(0xff);
    let [r0, r1, r2, r3] = rows;
    let low = _mm256_or_si256(
        _mm256_and_si256(r0, byte),
        _mm256_slli_epi32::<8>(_mm256_and_si256(r1, byte)),
    );
    let high = _mm256_or_si256(
        _mm256_slli_epi32::<16>(_mm256_and_si256(r2, byte)),
        _mm256_slli_epi32::<24>(r3),
    );
    let line = &mut out.as_chunks_mut::<32>().0[2 * r + half];
    // SAFETY: `line` has the 32 bytes that are written; any alignment will do.
    unsafe { _mm256_storeu_si256(line.as_mut_ptr().cast(), _mm256_or_si256(low, high)) };
}

/// Implements [`Kernel::convert_f64`].
#[target_feature(enable = "avx2,fma")]
fn convert_f64(Conversion { tile, powers, moduli, out, .. }: Conversion<'_, '_, f64>) {
    let dwords = all_dwords(tile, powers, |values| split(values));
    residues(&dwords, moduli, |m| (m.start_64, [&m.weights[..4], &m.weights[4..]]), out);
}

/// Implements [`Kernel::convert_wide`]: dwords are the low and high dwords of the lower words, then
/// the higher words.
#[target_feature(enable = "avx2,fma")]
fn convert_wide(Conversion { tile, powers, moduli, out, .. }: Conversion<'_, '_, f64>) {
    const NEAREST: i32 = _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC;
    let dwords = all_dwords(tile, powers, |values| {
        let unit = power_of_two(WORD_BITS as i32);
        let high = _mm256_mul_pd(values, _mm256_set1_pd(1.0 / unit));
        let high = _mm256_round_pd::<NEAREST>(high);
        let [low, middle] = split(_mm256_fnmadd_pd(high, _mm256_set1_pd(unit), values));
        let bias = _mm_set1_epi32(i32::MIN);
        [low, middle, _mm_xor_si128(_mm256_cvtpd_epi32(high), bias)]
    });
    residues(
        &dwords,
        moduli,
        |m| (m.start_wide, [&m.weights[..4], &m.weights[4..], &m.high_weights]),
        out,
    );
}

/// Returns the digits of the D biased dwords of every scaled entry, for each row and half of its
/// columns; `split` returns the dwords of four entries.
#[target_feature(enable = "avx2,fma")]
fn all_dwords<const D: usize>(
    tile: &Tile<f64>,
    powers: &Powers<f64>,
    split: impl Fn(__m256d) -> [__m128i; D],
) -> [[[Digits; D]; 2]; STEP] {
    let mut dwords = [[[digits(_mm256_setzero_si256()); D]; 2]; STEP];
    for (dwords, row) in dwords.iter_mut().zip(&tile.0) {
        for (half, dwords) in dwords.iter_mut().enumerate() {
            let [left, right] = [8 * half, 8 * half + 4].map(|j| {
                // SAFETY: four of the 16 elements of a row and of its powers.
                let load = |from: &[f64; WIDTH]| unsafe { _mm256_loadu_pd(from.as_ptr().add(j)) };
                let value = _mm256_mul_pd(load(row), load(&powers.first));
                split(_mm256_mul_pd(value, load(&powers.second)))
            });
            *dwords = std::array::from_fn(|i| digits(_mm256_set_m128i(right[i], left[i])));
        }
    }
    dwords
}

/// Computes the residues of numbers of D dwords; `constants` returns the start and the weights of a
/// modulus.
#[target_feature(enable = "avx2,fma")]
fn residues<'m, const D: usize>(
    dwords: &[[[Digits; D]; 2]; STEP],
    moduli: &'m [Modulus],
    constants: impl Fn(&'m Modulus) -> (i32, [&'m [i8]; D]),
    out: &mut [&mut Residues],
) {
    for (modulus, out) in moduli.iter().zip(out) {
        let (start, weights) = constants(modulus);
        let start = _mm256_set1_epi32(start);
        let weights = weights.map(|weights| pairs(weights));
        for (r, rows) in dwords.as_chunks::<4>().0.iter().enumerate() {
            for half in 0..2 {
                let row = |i: usize| {
                    let dwords = rows[i][half].into_iter().zip(weights);
                    let sums = dwords
                        .fold(start, |sums, (dword, weights)| add_products(sums, dword, weights));
                    finish(sums, modulus.p)
                };
                store([row(0), row(1), row(2), row(3)], out, r, half);
            }
        }
    }
}

/// Rounds four numbers below 2^62 in magnitude to integers, adds 2^63, and returns the low and the
/// high dwords.
#[target_feature(enable = "avx2,fma")]
fn split(values: __m256d) -> [__m128i; 2] {
    const UNIT: f64 = 4_294_967_296.0;
    let values = _mm256_round_pd::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(values);
    let high = _mm256_floor_pd(_mm256_mul_pd(values, _mm256_set1_pd(1.0 / UNIT)));
    // Exact, in [0, 2^32); 2^31 is subtracted to fit a signed dword.
    let low = _mm256_fnmadd_pd(high, _mm256_set1_pd(UNIT), values);
    let low = _mm256_cvtpd_epi32(_mm256_sub_pd(low, _mm256_set1_pd(UNIT / 2.0)));
    let bias = _mm_set1_epi32(i32::MIN);
    [_mm_xor_si128(low, bias), _mm_xor_si128(_mm256_cvtpd_epi32(high), bias)]
}

/// Implements [`Kernel::convert_f32`].
#[target_feature(enable = "avx2,fma")]
fn convert_f32(Conversion { tile, powers, moduli, out, .. }: Conversion<'_, '_, f32>) {
    let bias = _mm256_set1_epi32(i32::MIN);
    let mut dwords = [[[digits(bias)]; 2]; STEP];
    for (dwords, row) in dwords.iter_mut().zip(&tile.0) {
        for (half, dwords) in dwords.iter_mut().enumerate() {
            // SAFETY: eight of the 16 elements of a row and of its powers.
            let load =
                |from: &[f32; WIDTH]| unsafe { _mm256_loadu_ps(from.as_ptr().add(8 * half)) };
            let value = _mm256_mul_ps(load(row), load(&powers.first));
            let value = _mm256_mul_ps(value, load(&powers.second));
            *dwords = [digits(_mm256_xor_si256(_mm256_cvtps_epi32(value), bias))];
        }
    }
    residues(&dwords, moduli, |m| (m.start_32, [&m.weights[..4]]), out);
}

/// Rows of a quarter whose sums are held in registers.
const HELD: usize = 2;

/// Adds the product of two panels to the sums. A register holds two sums for each entry: of the
/// first two and of the last two of every four products.
#[target_feature(enable = "avx2,fma")]
fn multiply(left: &[Slice], right: &[Slice], sums: &mut PanelBlock<i32>) {
    for (quarter, sums) in sums.iter_mut().enumerate() {
        for (first, sums) in sums.chunks_exact_mut(HELD).enumerate() {
            let mut held = [[_mm256_setzero_si256(); 4]; HELD];
            for (left, right) in left.iter().zip(right) {
                let (left, right) = (&left[quarter / 2], &right[quarter % 2]);
                for (left, right) in left.chunks_exact(64).zip(right.chunks_exact(64)) {
                    let four: [_; HELD] = std::array::from_fn(|r| {
                        // SAFETY: dword `HELD first + r` of the 16 of this row.
                        let dword = unsafe {
                            left.as_ptr().add(4 * (HELD * first + r)).cast::<i32>().read_unaligned()
                        };
                        _mm256_broadcastq_epi64(_mm_cvtepi8_epi16(_mm_cvtsi32_si128(dword)))
                    });
                    for c in 0..4 {
                        // SAFETY: 16 bytes from 16 c on of this row's 64.
                        let bytes = unsafe { _mm_loadu_si128(right.as_ptr().add(16 * c).cast()) };
                        let right = _mm256_cvtepi8_epi16(bytes);
                        for (held, four) in held.iter_mut().zip(four) {
                            held[c] = _mm256_add_epi32(held[c], _mm256_madd_epi16(four, right));
                        }
                    }
                }
            }
            for (sums, held) in sums.iter_mut().zip(held) {
                for (c, held) in held.into_iter().enumerate() {
                    let mut pairs = [0_i32; 8];
                    // SAFETY: `pairs` has the 8 elements that are written; any alignment will do.
                    unsafe { _mm256_storeu_si256(pairs.as_mut_ptr().cast(), held) };
                    for (sum, pair) in sums[4 * c..].iter_mut().zip(pairs.chunks_exact(2)) {
                        *sum = sum.wrapping_add(pair[0].wrapping_add(pair[1]));
                    }
                }
            }
        }
    }
}
