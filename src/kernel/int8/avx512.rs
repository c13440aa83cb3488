//! The kernel for AVX-512 with VNNI: dot products of four bytes in each 32-bit lane.

use std::arch::x86_64::*;

use super::kernel::{Conversion, Kernel, Operands, Recombination};
use super::lane_set::LaneSet;
use super::lanes_avx512::Avx512Lanes;
use super::moduli::{Moduli, Modulus, WORD_BITS};
use super::tile::{
    MAGNITUDE, PANEL, PanelBlock, Powers, Residues, STEP, Slice, Square, Tile, TileNorms, WIDTH,
    biased, norm_exponents, power_of_two,
};
use crate::base::IsaLevel;
use crate::kernel::finish_stores;

/// The kernel. A value exists only if the CPU has the instructions, so the calls below are sound.
pub(super) struct Vnni(());

static VNNI: Vnni = Vnni(());

impl Vnni {
    /// Returns the kernel, or why this machine can't use it.
    pub fn new() -> Result<&'static Self, &'static str> {
        IsaLevel::Vnni.permitted()?;
        let found = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512vnni")
            && is_x86_feature_detected!("fma");
        if found { Ok(&VNNI) } else { Err("the CPU has no AVX-512 with VNNI") }
    }
}

/// Defines a function with the instructions of this module enabled.
macro_rules! enabled {
    ($($item:tt)*) => {
        #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vnni,fma")]
        $($item)*
    };
}

impl Kernel for Vnni {
    fn norms_f64(&self, tile: &Tile<f64>) -> TileNorms {
        enabled! {
            fn run(tile: &Tile<f64>) -> TileNorms {
                // SAFETY: a row has 16 elements, of which 8 are read from 0 or 8 on.
                norms(tile, |row| [0, 8].map(|j| unsafe { _mm512_loadu_pd(row.as_ptr().add(j)) }))
            }
        }
        // SAFETY: `self` exists, so the CPU has the instructions.
        unsafe { run(tile) }
    }

    fn norms_f32(&self, tile: &Tile<f32>) -> TileNorms {
        enabled! {
            fn run(tile: &Tile<f32>) -> TileNorms {
                norms(tile, |row| {
                    // SAFETY: a row has 16 elements, of which 8 are read from 0 or 8 on.
                    let half = |j: usize| unsafe { _mm256_loadu_ps(row.as_ptr().add(j)) };
                    [0, 8].map(|j| _mm512_cvtps_pd(half(j)))
                })
            }
        }
        // SAFETY: `self` exists, so the CPU has the instructions.
        unsafe { run(tile) }
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
        biased(right, left);
    }

    fn product(&self, operands: &Operands<'_>, residues: &mut [PanelBlock<i8>]) {
        // SAFETY: `self` exists, so the CPU has the instructions.
        unsafe { product(operands, residues) }
    }

    fn recombine(&self, it: Recombination<'_>, out: &mut Square<f64>) {
        // SAFETY: `self` exists, so the CPU has the instructions.
        unsafe {
            match it.moduli.parts {
                ..=2 => recombine::<2>(it, out),
                _ => recombine::<3>(it, out),
            }
        }
    }

    fn lanes(&self) -> LaneSet {
        // SAFETY: `self` exists, so the CPU has the instructions.
        LaneSet::Avx512(unsafe { Avx512Lanes::new() })
    }
}

enabled! {
    /// Computes the same as [`tile_norms`](super::tile::tile_norms); `load` returns a row as two
    /// vectors.
    #[inline]
    fn norms<T>(tile: &Tile<T>, load: impl Fn(&[T; WIDTH]) -> [__m512d; 2]) -> TileNorms {
        let magnitude = _mm512_set1_epi64(MAGNITUDE as i64);
        let magnitudes = |row| load(row).map(|v| _mm512_and_si512(_mm512_castpd_si512(v), magnitude));
        let mut largest = [_mm512_setzero_si512(); 2];
        for row in &tile.0 {
            for (largest, v) in largest.iter_mut().zip(magnitudes(row)) {
                *largest = _mm512_max_epu64(*largest, v);
            }
        }
        let mut bits = [0; WIDTH];
        for (bits, largest) in bits.chunks_exact_mut(8).zip(largest) {
            // SAFETY: the chunk has the 8 elements that are written; any alignment will do.
            unsafe { _mm512_storeu_si512(bits.as_mut_ptr().cast(), largest) };
        }
        let (exponents, powers) = norm_exponents(bits);
        // SAFETY: an array has 16 elements, of which 8 are read from 0 or 8 on.
        let halves = |p: &[f64; WIDTH]| [0, 8].map(|j| unsafe { _mm512_loadu_pd(p.as_ptr().add(j)) });
        let (first, second) = (halves(&powers.first), halves(&powers.second));
        let mut sums = [_mm512_setzero_pd(); 2];
        for row in &tile.0 {
            let row = magnitudes(row);
            for half in 0..2 {
                let v = _mm512_mul_pd(_mm512_castsi512_pd(row[half]), first[half]);
                let v = _mm512_mul_pd(v, second[half]);
                let v = _mm512_roundscale_pd::<{ _MM_FROUND_TO_POS_INF | _MM_FROUND_NO_EXC }>(v);
                sums[half] = _mm512_fmadd_pd(v, v, sums[half]);
            }
        }
        let mut squares = [0.0; WIDTH];
        for (squares, sums) in squares.chunks_exact_mut(8).zip(sums) {
            // SAFETY: the chunk has the 8 elements that are written; any alignment will do.
            unsafe { _mm512_storeu_pd(squares.as_mut_ptr(), sums) };
        }
        TileNorms { exponents, squares }
    }
}

/// The constants of a modulus in registers, to reduce 32-bit sums to residues.
pub(super) struct Reduction {
    /// Biases numbers to be unsigned.
    pub bias: __m512i,
    /// [`Modulus::start_32`]; with the first four weights for the first sums.
    pub start: __m512i,
    pub weights: __m512i,
    pub second_weights: __m512i,
    pub centre: __m512i,
    pub inverse: __m512i,
    /// The factor 256, which makes the rounding product a shift by 7 bits.
    pub shift: __m512i,
    pub p: __m512i,
    /// Permutation of dword `4 l + v` to `4 v + l`: rows one after another.
    pub rows: __m512i,
}

impl Reduction {
    enabled! {
        /// Broadcasts the constants of the reduction to one modulus.
        pub fn new(modulus: &Modulus) -> Self {
            Self {
                bias: _mm512_set1_epi32(i32::MIN),
                start: _mm512_set1_epi32(modulus.start_32),
                weights: _mm512_set1_epi32(dword(&modulus.weights[..4])),
                second_weights: _mm512_set1_epi32(dword(&modulus.second_weights())),
                centre: _mm512_set1_epi32(modulus.centre),
                inverse: _mm512_set1_epi16(modulus.inverse),
                shift: _mm512_set1_epi16(256),
                p: _mm512_set1_epi16(modulus.p as i16),
                rows: _mm512_setr_epi32(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15),
            }
        }
    }

    enabled! {
        /// Reduces first sums (see [`Modulus`]) to residues: byte `16 l + 4 v + i` of the result is
        /// from lane `4 l + i` of `sums[v]`.
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
            let quotient = _mm512_mulhrs_epi16(scaled, self.shift);
            _mm512_sub_epi16(t, _mm512_mullo_epi16(quotient, self.p))
        }
    }
}

/// Packs four weights into one dword.
fn dword(weights: &[i8]) -> i32 {
    i32::from_le_bytes(std::array::from_fn(|i| weights[i] as u8))
}

enabled! {
    /// Moves byte `16 l + 4 v + i` to byte `16 l + 4 i + v`: turns the order of
    /// [`Reduction::finish`], with a row in each of the four sums, into that of [`Residues`].
    fn rows_to_dwords(bytes: __m512i) -> __m512i {
        let order = _mm_setr_epi8(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15);
        _mm512_shuffle_epi8(bytes, _mm512_broadcast_i32x4(order))
    }
}

enabled! {
    fn convert_f64(Conversion { tile, powers, moduli, out, far }: Conversion<'_, '_, f64>) {
        let bias = _mm512_set1_epi64(i64::MIN);
        let mut dwords = [[_mm512_setzero_si512(); 2]; STEP];
        for (dwords, row) in dwords.iter_mut().zip(&tile.0) {
            *dwords = halves([0, 8].map(|j| {
                _mm512_xor_si512(_mm512_cvtpd_epi64(eight(row, powers, j)), bias)
            }));
        }
        let constants = |m: &Modulus| (m.start_64, [&m.weights[..4], &m.weights[4..]].map(dword));
        store_residues(&dwords, moduli, constants, out, far);
    }
}

enabled! {
    fn convert_wide(Conversion { tile, powers, moduli, out, far }: Conversion<'_, '_, f64>) {
        const NEAREST: i32 = _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC;
        let unit = _mm512_set1_pd(power_of_two(WORD_BITS as i32));
        let inverse = _mm512_set1_pd(power_of_two(-(WORD_BITS as i32)));
        let (bias, bias_32) = (_mm512_set1_epi64(i64::MIN), _mm512_set1_epi32(i32::MIN));
        // The dwords of the lower words, then the higher words.
        let mut dwords = [[_mm512_setzero_si512(); 3]; STEP];
        for (dwords, row) in dwords.iter_mut().zip(&tile.0) {
            let [(left, left_high), (right, right_high)] = [0, 8].map(|j| {
                let value = eight(row, powers, j);
                let high = _mm512_roundscale_pd::<NEAREST>(_mm512_mul_pd(value, inverse));
                let low = _mm512_fnmadd_pd(high, unit, value);
                (_mm512_xor_si512(_mm512_cvtpd_epi64(low), bias), _mm512_cvtpd_epi32(high))
            });
            let [low, middle] = halves([left, right]);
            let high = _mm512_inserti64x4::<1>(_mm512_castsi256_si512(left_high), right_high);
            *dwords = [low, middle, _mm512_xor_si512(high, bias_32)];
        }
        let constants = |m: &Modulus| {
            let weights = [&m.weights[..4], &m.weights[4..], &m.high_weights];
            (m.start_wide, weights.map(dword))
        };
        store_residues(&dwords, moduli, constants, out, far);
    }
}

enabled! {
    fn convert_f32(Conversion { tile, powers, moduli, out, far }: Conversion<'_, '_, f32>) {
        let bias = _mm512_set1_epi32(i32::MIN);
        // SAFETY: rows of tiles and their powers are 16 elements.
        let load = |row: &[f32; WIDTH]| unsafe { _mm512_loadu_ps(row.as_ptr()) };
        let (first, second) = (load(&powers.first), load(&powers.second));
        let mut dwords = [[_mm512_setzero_si512()]; STEP];
        for (dwords, row) in dwords.iter_mut().zip(&tile.0) {
            let value = _mm512_mul_ps(_mm512_mul_ps(load(row), first), second);
            *dwords = [_mm512_xor_si512(_mm512_cvtps_epi32(value), bias)];
        }
        let constants = |m: &Modulus| (m.start_32, [dword(&m.weights[..4])]);
        store_residues(&dwords, moduli, constants, out, far);
    }
}

enabled! {
    /// Returns eight entries of a row from `j` on, multiplied by their powers.
    #[inline]
    fn eight(row: &[f64; WIDTH], powers: &Powers<f64>, j: usize) -> __m512d {
        // SAFETY: 8 of the 16 elements of a row and of its powers.
        let load = |from: &[f64; WIDTH]| unsafe { _mm512_loadu_pd(from.as_ptr().add(j)) };
        let value = _mm512_mul_pd(load(row), load(&powers.first));
        _mm512_mul_pd(value, load(&powers.second))
    }
}

enabled! {
    /// Returns the low dwords of 16 numbers, and the high ones.
    #[inline]
    fn halves([left, right]: [__m512i; 2]) -> [__m512i; 2] {
        let low = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
        let high = _mm512_or_si512(low, _mm512_set1_epi32(1));
        [low, high].map(|dwords| _mm512_permutex2var_epi32(left, dwords, right))
    }
}

enabled! {
    /// Stores the residues of numbers of D dwords; `constants` returns the start and the weights of
    /// a modulus.
    #[inline]
    fn store_residues<const D: usize>(
        dwords: &[[__m512i; D]; STEP],
        moduli: &[Modulus],
        constants: impl Fn(&Modulus) -> (i32, [i32; D]),
        out: &mut [&mut Residues],
        far: bool,
    ) {
        for (modulus, out) in moduli.iter().zip(out) {
            let reduction = Reduction::new(modulus);
            let (start, weights) = constants(modulus);
            let start = _mm512_set1_epi32(start);
            let weights = weights.map(|weights| _mm512_set1_epi32(weights));
            for r in 0..STEP / 4 {
                let sums = std::array::from_fn(|v| {
                    let dwords = dwords[4 * r + v].into_iter().zip(weights);
                    dwords.fold(start, |sum, (dword, weight)| _mm512_dpbusd_epi32(sum, dword, weight))
                });
                store_line(out, r, rows_to_dwords(reduction.finish(sums)), far);
            }
        }
        finish_stores(far);
    }
}

enabled! {
    /// Stores 64 bytes as row `r` of the dwords of a tile; past the caches if `far` and aligned.
    #[inline]
    fn store_line(out: &mut Residues, r: usize, bytes: __m512i, far: bool) {
        let line = &mut out.as_chunks_mut::<64>().0[r];
        let at = line.as_mut_ptr().cast::<__m512i>();
        // SAFETY: `line` has the 64 bytes that are written. The store past the caches, which needs
        // alignment, is reached with it only; the other one takes any.
        unsafe {
            if far && at.is_aligned() {
                _mm512_stream_si512(at, bytes);
            } else {
                _mm512_storeu_si512(at, bytes);
            }
        }
    }
}

enabled! {
    fn product(operands: &Operands<'_>, residues: &mut [PanelBlock<i8>]) {
        let reduction = Reduction::new(operands.modulus);
        let excess = [0, 1].map(|half| excess(operands.right, half));
        let mut sums = Sums::ZERO;
        for (left, residues) in operands.left_panels(residues.len()).zip(residues) {
            multiply(left, operands.right, excess, &mut sums);
            reduction.reduce(&sums, operands.continued, residues);
        }
    }
}

/// Sums of a pair of panels.
#[repr(C, align(64))]
pub(super) struct Sums(pub PanelBlock<i32>);

impl Sums {
    pub const ZERO: Self = Self([[[0; WIDTH]; WIDTH]; 4]);
}

impl Reduction {
    enabled! {
        /// Reduces the sums, plus the old residues if `continued`, to residues.
        pub fn reduce(&self, sums: &Sums, continued: bool, residues: &mut PanelBlock<i8>) {
            let wanted = if continued { !0 } else { 0 };
            let (sums, residues) = (sums.0.as_flattened(), residues.as_flattened_mut());
            for (sums, residues) in sums.chunks_exact(4).zip(residues.chunks_exact_mut(4)) {
                let first = std::array::from_fn(|v| {
                    // SAFETY: a row of sums is 16 dwords, one of residues 16 bytes.
                    let (sum, old) = unsafe {
                        let old = _mm_loadu_si128(residues[v].as_ptr().cast());
                        (_mm512_loadu_si512(sums[v].as_ptr().cast()), old)
                    };
                    let sum = _mm512_add_epi32(sum, _mm512_maskz_cvtepi8_epi32(wanted, old));
                    let digits = _mm512_xor_si512(sum, self.bias);
                    _mm512_dpbusd_epi32(self.start, digits, self.weights)
                });
                let bytes = _mm512_permutexvar_epi32(self.rows, self.finish(first));
                // SAFETY: four rows of residues are 64 bytes.
                unsafe { _mm512_storeu_si512(residues.as_mut_ptr().cast(), bytes) };
            }
        }
    }
}

/// Rows of the left operand whose sums are held in registers.
const HELD: usize = 8;

/// Steps of a chunk of both operands (32 KiB), which stays in the first-level cache for its four
/// passes.
const CACHED: usize = 8;

enabled! {
    /// Computes the sums of the product of two panels, of which the left one is biased by 128, and
    /// subtracts `excess`, by which each column is then too large.
    fn multiply(left: &[Slice], right: &[Slice], excess: [__m512i; 2], sums: &mut Sums) {
        let start = excess.map(|excess| _mm512_sub_epi32(_mm512_setzero_si512(), excess));
        for row in sums.0.as_chunks_mut::<2>().0 {
            for (quarter, start) in row.iter_mut().zip(start) {
                for row in quarter {
                    // SAFETY: a row of sums is 16 `i32`, the 64 bytes that are written.
                    unsafe { _mm512_storeu_si512(row.as_mut_ptr().cast(), start) };
                }
            }
        }
        for (left, right) in left.chunks(CACHED).zip(right.chunks(CACHED)) {
            for row_half in 0..2 {
                for first in (0..WIDTH).step_by(HELD) {
                    add_rows(left, right, row_half, first, sums);
                }
            }
        }
    }
}

enabled! {
    /// Adds the products of [`HELD`] rows of the left panel, from `first` of tile `row_half` on.
    #[inline]
    fn add_rows(left: &[Slice], right: &[Slice], row_half: usize, first: usize, sums: &mut Sums) {
        let mut held = [[_mm512_setzero_si512(); 2]; HELD];
        for (r, held) in held.iter_mut().enumerate() {
            for (half, held) in held.iter_mut().enumerate() {
                let row = &sums.0[2 * row_half + half][first + r];
                // SAFETY: a row of sums is 16 `i32`, the 64 bytes that are read.
                *held = unsafe { _mm512_loadu_si512(row.as_ptr().cast()) };
            }
        }
        for (left, right) in left.iter().zip(right) {
            let left = &left[row_half];
            for k in (0..STEP * WIDTH).step_by(64) {
                // SAFETY: 64 bytes from `k` on are inside a tile.
                let load =
                    |tile: &Residues| unsafe { _mm512_loadu_si512(tile.as_ptr().add(k).cast()) };
                let right = [load(&right[0]), load(&right[1])];
                for (r, held) in held.iter_mut().enumerate() {
                    // SAFETY: `k` is a multiple of 64 and `first + r` below WIDTH = 16, so that the
                    // dword is inside the tile; it is read at any alignment.
                    let four = unsafe {
                        left.as_ptr().add(k + 4 * (first + r)).cast::<i32>().read_unaligned()
                    };
                    let four = _mm512_set1_epi32(four);
                    held[0] = _mm512_dpbusd_epi32(held[0], four, right[0]);
                    held[1] = _mm512_dpbusd_epi32(held[1], four, right[1]);
                }
            }
        }
        for (r, held) in held.iter().enumerate() {
            for (half, &held) in held.iter().enumerate() {
                let row = &mut sums.0[2 * row_half + half][first + r];
                // SAFETY: a row of sums is 16 `i32`, the 64 bytes that are written.
                unsafe { _mm512_storeu_si512(row.as_mut_ptr().cast(), held) };
            }
        }
    }
}

enabled! {
    /// Returns 128 times the sum of each of the 16 columns of tile `half` of the right operand.
    fn excess(right: &[Slice], half: usize) -> __m512i {
        // The instruction reads this weight as unsigned: +128.
        let weights = _mm512_set1_epi8(i8::MIN);
        // Four sums, since one would be a chain of dependent instructions.
        let mut sums = [_mm512_setzero_si512(); 4];
        for slice in right {
            for lines in slice[half].chunks_exact(4 * 64) {
                for (sum, dwords) in sums.iter_mut().zip(lines.chunks_exact(64)) {
                    // SAFETY: the chunk has the 64 bytes that are read; any alignment will do.
                    let dwords = unsafe { _mm512_loadu_si512(dwords.as_ptr().cast()) };
                    *sum = _mm512_dpbusd_epi32(*sum, weights, dwords);
                }
            }
        }
        let [s0, s1, s2, s3] = sums;
        _mm512_add_epi32(_mm512_add_epi32(s0, s1), _mm512_add_epi32(s2, s3))
    }
}

/// Vectors of a row of a block.
const VECTORS: usize = PANEL / 8;

enabled! {
    /// Implements [`Kernel::recombine`] with the first `PARTS` parts of a row in registers (see
    /// [`integers`](super::recombine::integers)); the others are zero.
    fn recombine<const PARTS: usize>(it: Recombination<'_>, out: &mut Square<f64>) {
        let Recombination { residues, moduli, rows, columns, next } = it;
        for (i, (out, &row)) in out.iter_mut().zip(rows).enumerate() {
            next.fetch(residues, i);
            let mut parts = [[_mm512_setzero_pd(); VECTORS]; PARTS];
            for (unit, residues) in moduli.units.iter().zip(residues) {
                let unit = unit.map(|unit| _mm512_set1_pd(unit));
                let of_row = i / WIDTH * 2;
                let quarters = [&residues[of_row][i % WIDTH], &residues[of_row + 1][i % WIDTH]];
                for v in 0..VECTORS {
                    // SAFETY: 8 of the 16 residues of a row of a quarter.
                    let bytes = unsafe {
                        _mm_loadl_epi64(quarters[v / 2].as_ptr().add(v % 2 * 8).cast())
                    };
                    let value = _mm512_cvtepi64_pd(_mm512_cvtepi8_epi64(bytes));
                    for (part, unit) in parts.iter_mut().zip(unit) {
                        part[v] = _mm512_fmadd_pd(value, unit, part[v]);
                    }
                }
            }
            for v in 0..VECTORS {
                // SAFETY: 8 of the 32 entries of a row.
                unsafe {
                    let columns = _mm256_loadu_si256(columns.as_ptr().add(8 * v).cast());
                    let exponents = _mm256_add_epi32(_mm256_set1_epi32(row), columns);
                    let value = combine(parts.map(|part| part[v]), moduli);
                    let value = _mm512_scalef_pd(value, _mm512_cvtepi32_pd(exponents));
                    _mm512_storeu_pd(out.as_mut_ptr().add(8 * v), value);
                }
            }
        }
    }
}

enabled! {
    /// Returns the f64 nearest to eight integers of least magnitude, from parts that add up to them
    /// modulo P.
    #[inline]
    fn combine<const PARTS: usize>(parts: [__m512d; PARTS], moduli: &Moduli) -> __m512d {
        let inverse = _mm512_set1_pd(moduli.inverse);
        let quotient = _mm512_mul_pd(_mm512_add_pd(parts[0], parts[1]), inverse);
        let quotient =
            _mm512_roundscale_pd::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(quotient);
        let rest: [_; PARTS] = std::array::from_fn(|p| {
            _mm512_fnmadd_pd(quotient, _mm512_set1_pd(moduli.product[p]), parts[p])
        });
        if PARTS <= 2 {
            return _mm512_add_pd(rest[0], rest[1]);
        }
        let (tail, tail_error) = two_sum(rest[1], rest[2]);
        let (head, head_error) = two_sum(rest[0], tail);
        _mm512_add_pd(head, sum_to_odd(head_error, tail_error))
    }
}

enabled! {
    /// Does what `sum_to_odd` of the portable kernel does.
    #[inline]
    fn sum_to_odd(x: __m512d, y: __m512d) -> __m512d {
        let (sum, error) = two_sum(x, y);
        let one = _mm512_set1_epi64(1);
        let (bits, error_bits) = (_mm512_castpd_si512(sum), _mm512_castpd_si512(error));
        let inexact = _mm512_cmp_pd_mask::<_CMP_NEQ_OQ>(error, _mm512_setzero_pd());
        let even = _mm512_testn_epi64_mask(bits, one);
        // 1, or -1 where the error has the other sign.
        let step = _mm512_srai_epi64::<63>(_mm512_xor_si512(bits, error_bits));
        let step = _mm512_or_si512(step, one);
        _mm512_castsi512_pd(_mm512_mask_add_epi64(bits, inexact & even, bits, step))
    }
}

enabled! {
    /// Returns `x + y` and its rounding error (Knuth 1969).
    #[inline]
    fn two_sum(x: __m512d, y: __m512d) -> (__m512d, __m512d) {
        let sum = _mm512_add_pd(x, y);
        let part = _mm512_sub_pd(sum, x);
        let error = _mm512_sub_pd(x, _mm512_sub_pd(sum, part));
        (sum, _mm512_add_pd(error, _mm512_sub_pd(y, part)))
    }
}

enabled! {
    /// Transposes a tile of 16 x 16 dwords.
    fn transpose(tile: &Residues, out: &mut Residues) {
        // Four columns at a time; lane l of `quad(i)` is row 4 l + i.
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
    /// Transposes every tile: dword (r, j) becomes dword (j, r).
    pub fn transpose(&self, tiles: &[Slice], out: &mut [Slice]) {
        for (tile, out) in tiles.as_flattened().iter().zip(out.as_flattened_mut()) {
            // SAFETY: `self` exists, so the CPU has the instructions.
            unsafe { transpose(tile, out) };
        }
    }
}
