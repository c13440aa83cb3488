//! The kernel for AVX-512 with VNNI: dot products of four bytes in each 32-bit lane.

use std::arch::x86_64::*;

use super::kernel::Kernel;
use super::moduli::{Moduli, Modulus};
use super::recombine;
use super::tile::{
    Block, Powers, Quarter, Residues, STEP, Slice, Tile, TileNorms, WIDTH, tile_norms,
};

/// Exists only where the CPU has the instructions: what makes the calls below sound.
pub(super) struct Vnni(());

static VNNI: Vnni = Vnni(());

impl Vnni {
    /// The kernel, or why there is none.
    pub fn new() -> Result<&'static Self, &'static str> {
        let found = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512vnni")
            && is_x86_feature_detected!("fma");
        if found { Ok(&VNNI) } else { Err("the CPU has no AVX-512 with VNNI") }
    }
}

/// A function of this module with its instructions enabled.
macro_rules! enabled {
    ($($item:tt)*) => {
        #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vnni,fma")]
        $($item)*
    };
}

impl Kernel for Vnni {
    fn norms_f64(&self, tile: &Tile<f64>) -> TileNorms {
        enabled! { fn norms(tile: &Tile<f64>) -> TileNorms { tile_norms(tile) } }
        // SAFETY: `self` exists, so the CPU has the instructions.
        unsafe { norms(tile) }
    }

    fn norms_f32(&self, tile: &Tile<f32>) -> TileNorms {
        enabled! { fn norms(tile: &Tile<f32>) -> TileNorms { tile_norms(tile) } }
        // SAFETY: `self` exists, so the CPU has the instructions.
        unsafe { norms(tile) }
    }

    fn convert_f64(
        &self,
        tile: &Tile<f64>,
        powers: &Powers<f64>,
        moduli: &Moduli,
        out: &mut [&mut Residues],
    ) {
        // SAFETY: `self` exists, so the CPU has the instructions.
        unsafe { convert_f64(tile, powers, moduli, out) }
    }

    fn convert_f32(
        &self,
        tile: &Tile<f32>,
        powers: &Powers<f32>,
        moduli: &Moduli,
        out: &mut [&mut Residues],
    ) {
        // SAFETY: `self` exists, so the CPU has the instructions.
        unsafe { convert_f32(tile, powers, moduli, out) }
    }

    fn multiply(&self, left: &[Slice], right: &[Slice], sums: &mut Block<i32>, _ahead: *const i8) {
        assert_eq!(left.len(), right.len());
        // SAFETY: `self` exists, so the CPU has the instructions.
        unsafe { multiply(left, right, sums) }
    }

    fn reduce(&self, sums: &Block<i32>, modulus: &Modulus, out: &mut Block<i8>) {
        // SAFETY: `self` exists, so the CPU has the instructions.
        unsafe { reduce(sums, modulus, out) }
    }

    fn recombine(
        &self,
        residues: &[&Quarter<i8>],
        moduli: &Moduli,
        rows: &[i32; WIDTH],
        columns: &[i32; WIDTH],
        out: &mut Quarter<f64>,
    ) {
        enabled! {
            fn run(
                residues: &[&Quarter<i8>],
                moduli: &Moduli,
                rows: &[i32; WIDTH],
                columns: &[i32; WIDTH],
                out: &mut Quarter<f64>,
            ) {
                recombine::quarter::<true>(residues, moduli, rows, columns, out);
            }
        }
        // SAFETY: `self` exists, so the CPU has the instructions.
        unsafe { run(residues, moduli, rows, columns, out) }
    }

    fn spin(&self, count: usize) -> Option<usize> {
        let rounds = count.div_ceil(12 * 64).max(1);
        // SAFETY: `self` exists, so the CPU has the instructions.
        unsafe { spin(rounds) };
        Some(rounds * 12 * 64)
    }
}

/// As many sums as fill the pipelines, round after round.
///
/// # Safety
/// The CPU has the instructions; `rounds > 0`.
unsafe fn spin(rounds: usize) {
    // SAFETY: touches registers only.
    unsafe {
        std::arch::asm!(
            "2:",
            "vpdpbusd zmm0, zmm12, zmm13",
            "vpdpbusd zmm1, zmm12, zmm13",
            "vpdpbusd zmm2, zmm12, zmm13",
            "vpdpbusd zmm3, zmm12, zmm13",
            "vpdpbusd zmm4, zmm12, zmm13",
            "vpdpbusd zmm5, zmm12, zmm13",
            "vpdpbusd zmm6, zmm12, zmm13",
            "vpdpbusd zmm7, zmm12, zmm13",
            "vpdpbusd zmm8, zmm12, zmm13",
            "vpdpbusd zmm9, zmm12, zmm13",
            "vpdpbusd zmm10, zmm12, zmm13",
            "vpdpbusd zmm11, zmm12, zmm13",
            "dec {rounds}",
            "jnz 2b",
            rounds = inout(reg) rounds => _,
            out("zmm0") _, out("zmm1") _, out("zmm2") _, out("zmm3") _,
            out("zmm4") _, out("zmm5") _, out("zmm6") _, out("zmm7") _,
            out("zmm8") _, out("zmm9") _, out("zmm10") _, out("zmm11") _,
            options(nostack, nomem),
        );
    }
}

/// The constants of a modulus in registers.
struct Reduction {
    second_weights: __m512i,
    centre: __m512i,
    inverse: __m512i,
    p: __m512i,
}

impl Reduction {
    enabled! {
        fn new(modulus: &Modulus) -> Self {
            Self {
                second_weights: _mm512_set1_epi32(i32::from_le_bytes(
                    modulus.second_weights().map(|w| w as u8),
                )),
                centre: _mm512_set1_epi32(modulus.centre),
                inverse: _mm512_set1_epi16(modulus.inverse),
                p: _mm512_set1_epi16(modulus.p as i16),
            }
        }
    }

    enabled! {
        /// First sums (see [`Modulus`]) to residues: byte `16 l + 4 v + i` of the result is from lane
        /// `4 l + i` of `sums[v]`.
        #[inline]
        fn finish(&self, sums: [__m512i; 4]) -> __m512i {
            let [s0, s1, s2, s3] = sums;
            let second = |s| _mm512_dpbusd_epi32(self.centre, s, self.second_weights);
            let low = _mm512_packs_epi32(second(s0), second(s1));
            let high = _mm512_packs_epi32(second(s2), second(s3));
            _mm512_packs_epi16(self.barrett(low), self.barrett(high))
        }
    }

    enabled! {
        #[inline]
        fn barrett(&self, t: __m512i) -> __m512i {
            let scaled = _mm512_mulhrs_epi16(t, self.inverse);
            let quotient = _mm512_mulhrs_epi16(scaled, _mm512_set1_epi16(256));
            _mm512_sub_epi16(t, _mm512_mullo_epi16(quotient, self.p))
        }
    }
}

/// Four weights as one dword.
fn dword(weights: &[i8]) -> i32 {
    i32::from_le_bytes(std::array::from_fn(|i| weights[i] as u8))
}

enabled! {
    /// Byte `16 l + 4 v + i` to byte `16 l + 4 i + v`: turns the order of [`Reduction::finish`], with a row in each
    /// of the four sums, into that of [`Residues`].
    fn rows_to_dwords(bytes: __m512i) -> __m512i {
        let order = _mm_setr_epi8(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15);
        _mm512_shuffle_epi8(bytes, _mm512_broadcast_i32x4(order))
    }
}

enabled! {
    fn convert_f64(
        tile: &Tile<f64>,
        powers: &Powers<f64>,
        moduli: &Moduli,
        out: &mut [&mut Residues],
    ) {
        let low_dwords = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
        let high_dwords = _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
        let bias = _mm512_set1_epi64(i64::MIN);
        let mut low = [_mm512_setzero_si512(); STEP];
        let mut high = [_mm512_setzero_si512(); STEP];
        for (i, row) in tile.0.iter().enumerate() {
            // SAFETY: both halves of a row and of its powers are 8 elements.
            let half = |j: usize| unsafe {
                let value = _mm512_loadu_pd(row.as_ptr().add(j));
                let value = _mm512_mul_pd(value, _mm512_loadu_pd(powers.first.as_ptr().add(j)));
                let value = _mm512_mul_pd(value, _mm512_loadu_pd(powers.second.as_ptr().add(j)));
                _mm512_xor_si512(_mm512_cvtpd_epi64(value), bias)
            };
            let (left, right) = (half(0), half(8));
            low[i] = _mm512_permutex2var_epi32(left, low_dwords, right);
            high[i] = _mm512_permutex2var_epi32(left, high_dwords, right);
        }
        for (modulus, out) in moduli.list.iter().zip(out) {
            let reduction = Reduction::new(modulus);
            let start = _mm512_set1_epi32(modulus.start_64);
            let low_weights = _mm512_set1_epi32(dword(&modulus.weights[..4]));
            let high_weights = _mm512_set1_epi32(dword(&modulus.weights[4..]));
            for r in 0..STEP / 4 {
                let sums = std::array::from_fn(|v| {
                    let sum = _mm512_dpbusd_epi32(start, low[4 * r + v], low_weights);
                    _mm512_dpbusd_epi32(sum, high[4 * r + v], high_weights)
                });
                let bytes = rows_to_dwords(reduction.finish(sums));
                // SAFETY: dword-row `r` of the 16 of a tile; tiles are aligned as `Slice` is not, hence unaligned.
                unsafe { _mm512_storeu_si512(out.as_mut_ptr().add(64 * r).cast(), bytes) };
            }
        }
    }
}

enabled! {
    fn convert_f32(
        tile: &Tile<f32>,
        powers: &Powers<f32>,
        moduli: &Moduli,
        out: &mut [&mut Residues],
    ) {
        let bias = _mm512_set1_epi32(i32::MIN);
        // SAFETY: rows of tiles and their powers are 16 elements.
        let load = |row: &[f32; WIDTH]| unsafe { _mm512_loadu_ps(row.as_ptr()) };
        let (first, second) = (load(&powers.first), load(&powers.second));
        let mut digits = [_mm512_setzero_si512(); STEP];
        for (digits, row) in digits.iter_mut().zip(&tile.0) {
            let value = _mm512_mul_ps(_mm512_mul_ps(load(row), first), second);
            *digits = _mm512_xor_si512(_mm512_cvtps_epi32(value), bias);
        }
        for (modulus, out) in moduli.list.iter().zip(out) {
            let reduction = Reduction::new(modulus);
            let start = _mm512_set1_epi32(modulus.start_32);
            let weights = _mm512_set1_epi32(dword(&modulus.weights[..4]));
            for r in 0..STEP / 4 {
                let sums =
                    std::array::from_fn(|v| _mm512_dpbusd_epi32(start, digits[4 * r + v], weights));
                let bytes = rows_to_dwords(reduction.finish(sums));
                // SAFETY: dword-row `r` of the 16 of a tile.
                unsafe { _mm512_storeu_si512(out.as_mut_ptr().add(64 * r).cast(), bytes) };
            }
        }
    }
}

enabled! {
    fn reduce(sums: &Block<i32>, modulus: &Modulus, out: &mut Block<i8>) {
        let reduction = Reduction::new(modulus);
        let bias = _mm512_set1_epi32(i32::MIN);
        let start = _mm512_set1_epi32(modulus.start_32);
        let weights = _mm512_set1_epi32(dword(&modulus.weights[..4]));
        // Dword 4 l + v of the bytes goes to 4 v + l: one row after another.
        let rows = _mm512_setr_epi32(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15);
        let (sums, out) = (sums.as_flattened(), out.as_flattened_mut());
        for (sums, out) in sums.chunks_exact(4).zip(out.chunks_exact_mut(4)) {
            let first = std::array::from_fn(|v| {
                // SAFETY: a row of sums is 16 elements.
                let sum = unsafe { _mm512_loadu_si512(sums[v].as_ptr().cast()) };
                _mm512_dpbusd_epi32(start, _mm512_xor_si512(sum, bias), weights)
            });
            let bytes = _mm512_permutexvar_epi32(rows, reduction.finish(first));
            // SAFETY: four rows of residues are 64 bytes.
            unsafe { _mm512_storeu_si512(out.as_mut_ptr().cast(), bytes) };
        }
    }
}

/// Rows of the left operand whose sums are held in registers.
const HELD: usize = 8;

enabled! {
    /// The instruction takes unsigned times signed bytes. So the right operand is biased by 128, and 128 times
    /// the sums of the left one are taken off.
    fn multiply(left: &[Slice], right: &[Slice], sums: &mut Block<i32>) {
        let bias = _mm512_set1_epi8(i8::MIN);
        for row_half in 0..2 {
            let excess = excess(left, row_half);
            for first in (0..WIDTH).step_by(HELD) {
                let mut held = [[_mm512_setzero_si512(); 2]; HELD];
                for (r, held) in held.iter_mut().enumerate() {
                    let excess = _mm512_set1_epi32(excess[first + r]);
                    for (half, held) in held.iter_mut().enumerate() {
                        let row = &sums[2 * row_half + half][first + r];
                        // SAFETY: a row of sums is 16 elements.
                        let sum = unsafe { _mm512_loadu_si512(row.as_ptr().cast()) };
                        *held = _mm512_sub_epi32(sum, excess);
                    }
                }
                for (left, right) in left.iter().zip(right) {
                    let left = &left[row_half];
                    for k in (0..STEP * WIDTH).step_by(64) {
                        // SAFETY: 64 bytes from `k` on are inside a tile.
                        let load = |tile: &Residues| unsafe {
                            _mm512_xor_si512(_mm512_loadu_si512(tile.as_ptr().add(k).cast()), bias)
                        };
                        let right = [load(&right[0]), load(&right[1])];
                        for (r, held) in held.iter_mut().enumerate() {
                            // SAFETY: a dword of the 16 from `k` on.
                            let four = unsafe {
                                left.as_ptr().add(k + 4 * (first + r)).cast::<i32>().read_unaligned()
                            };
                            let four = _mm512_set1_epi32(four);
                            held[0] = _mm512_dpbusd_epi32(held[0], right[0], four);
                            held[1] = _mm512_dpbusd_epi32(held[1], right[1], four);
                        }
                    }
                }
                for (r, held) in held.iter().enumerate() {
                    for (half, &held) in held.iter().enumerate() {
                        let row = &mut sums[2 * row_half + half][first + r];
                        // SAFETY: a row of sums is 16 elements.
                        unsafe { _mm512_storeu_si512(row.as_mut_ptr().cast(), held) };
                    }
                }
            }
        }
    }
}

enabled! {
    /// 128 times the sum of each of 16 columns of the left operand.
    fn excess(left: &[Slice], half: usize) -> [i32; WIDTH] {
        // As an unsigned byte the weight is +128.
        let weights = _mm512_set1_epi8(i8::MIN);
        // Four sums, so that none waits for the one before.
        let mut sums = [_mm512_setzero_si512(); 4];
        for slice in left {
            for lines in slice[half].chunks_exact(4 * 64) {
                for (sum, dwords) in sums.iter_mut().zip(lines.chunks_exact(64)) {
                    // SAFETY: 64 bytes.
                    let dwords = unsafe { _mm512_loadu_si512(dwords.as_ptr().cast()) };
                    *sum = _mm512_dpbusd_epi32(*sum, weights, dwords);
                }
            }
        }
        let [s0, s1, s2, s3] = sums;
        let sums = _mm512_add_epi32(_mm512_add_epi32(s0, s1), _mm512_add_epi32(s2, s3));
        let mut excess = [0; WIDTH];
        // SAFETY: 16 elements.
        unsafe { _mm512_storeu_si512(excess.as_mut_ptr().cast(), sums) };
        excess
    }
}

enabled! {
    /// Dword (r, j) of a tile to dword (j, r).
    fn transpose(tile: &Residues, out: &mut Residues) {
        // Four columns at a time; lane l of `quads[i]` is row 4 l + i.
        for g in 0..4 {
            let quad = |i: usize| {
                // SAFETY: 16 bytes of row `row` < 16 of the tile.
                let lane = |row: usize| unsafe {
                    _mm_loadu_si128(tile.as_ptr().add(64 * row + 16 * g).cast())
                };
                let lanes = _mm512_castsi128_si512(lane(i));
                let lanes = _mm512_inserti32x4::<1>(lanes, lane(4 + i));
                let lanes = _mm512_inserti32x4::<2>(lanes, lane(8 + i));
                _mm512_inserti32x4::<3>(lanes, lane(12 + i))
            };
            let [z0, z1, z2, z3] = std::array::from_fn(quad);
            let (a, b) = (_mm512_unpacklo_epi32(z0, z1), _mm512_unpackhi_epi32(z0, z1));
            let (c, d) = (_mm512_unpacklo_epi32(z2, z3), _mm512_unpackhi_epi32(z2, z3));
            let columns = [
                _mm512_unpacklo_epi64(a, c),
                _mm512_unpackhi_epi64(a, c),
                _mm512_unpacklo_epi64(b, d),
                _mm512_unpackhi_epi64(b, d),
            ];
            for (i, column) in columns.into_iter().enumerate() {
                // SAFETY: row 4 g + i < 16 of the tile.
                unsafe { _mm512_storeu_si512(out.as_mut_ptr().add(64 * (4 * g + i)).cast(), column) };
            }
        }
    }
}

impl Vnni {
    /// Dword (r, j) of every tile to dword (j, r).
    pub fn transpose(&self, tiles: &[Slice], out: &mut [Slice]) {
        for (tile, out) in tiles.as_flattened().iter().zip(out.as_flattened_mut()) {
            // SAFETY: `self` exists, so the CPU has the instructions.
            unsafe { transpose(tile, out) };
        }
    }
}
