//! Vectors of eight numbers in two registers of AVX2.

use std::arch::x86_64::*;
use std::ops::Range;

use super::lanes::{LANES, Lanes, OnLanes, Row, by_instructions};

/// Vectors of two registers each. A value exists only if the CPU has the instructions.
#[derive(Clone, Copy)]
pub(crate) struct Avx2Lanes(());

impl Avx2Lanes {
    /// Returns the value.
    ///
    /// # Safety
    /// The CPU has AVX2 and FMA.
    pub unsafe fn new() -> Self {
        Self(())
    }

    /// Runs `work`, compiled for these vectors.
    #[inline(always)]
    pub fn run<W: OnLanes>(self, work: W) -> W::Output {
        #[target_feature(enable = "avx2,fma")]
        fn run<W: OnLanes>(lanes: Avx2Lanes, work: W) -> W::Output {
            work.run(lanes)
        }
        // SAFETY: `self` exists, so the CPU has the instructions.
        unsafe { run(self, work) }
    }
}

/// Returns all bits of the lanes of `range` among the four lanes from `first` on.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn mask_of_four(range: &Range<usize>, first: i64) -> __m256i {
    let lanes = _mm256_add_epi64(_mm256_setr_epi64x(0, 1, 2, 3), _mm256_set1_epi64x(first));
    let end = _mm256_set1_epi64x(range.end as i64);
    let before = _mm256_set1_epi64x(range.start as i64 - 1);
    _mm256_and_si256(_mm256_cmpgt_epi64(end, lanes), _mm256_cmpgt_epi64(lanes, before))
}

/// Returns the mask of four dwords instead of quadwords.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn narrow(mask: __m256i) -> __m128i {
    let even = _mm256_setr_epi32(0, 2, 4, 6, 0, 2, 4, 6);
    _mm256_castsi256_si128(_mm256_permutevar8x32_epi32(mask, even))
}

/// Transposes four rows of four numbers.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn transpose_four([a, b, c, d]: [__m256d; 4]) -> [__m256d; 4] {
    let [even_ab, odd_ab] = [_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b)];
    let [even_cd, odd_cd] = [_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d)];
    [
        _mm256_permute2f128_pd::<0x20>(even_ab, even_cd),
        _mm256_permute2f128_pd::<0x20>(odd_ab, odd_cd),
        _mm256_permute2f128_pd::<0x31>(even_ab, even_cd),
        _mm256_permute2f128_pd::<0x31>(odd_ab, odd_cd),
    ]
}

/// Applies an instruction to both halves.
macro_rules! halves {
    ($instruction:path, $x:expr) => {
        [$instruction($x[0]), $instruction($x[1])]
    };
    ($instruction:path, $x:expr, $y:expr) => {
        [$instruction($x[0], $y[0]), $instruction($x[1], $y[1])]
    };
    ($instruction:path, $x:expr, $y:expr, $z:expr) => {
        [$instruction($x[0], $y[0], $z[0]), $instruction($x[1], $y[1], $z[1])]
    };
}

type Floats = [__m256d; 2];
type Integers = [__m256i; 2];

impl Lanes for Avx2Lanes {
    type Floats = Floats;
    type Integers = Integers;
    const COLUMNS: usize = 2;

    #[inline(always)]
    unsafe fn read_f64(self, from: *const f64, range: Range<usize>) -> Floats {
        let from = from.wrapping_sub(range.start);
        // SAFETY: `self` exists, so the CPU has the instructions. Only the lanes of `range` are
        // read, the numbers at the caller's pointer, which exist by the contract; any alignment
        // will do.
        unsafe {
            let low = _mm256_maskload_pd(from, mask_of_four(&range, 0));
            [low, _mm256_maskload_pd(from.wrapping_add(4), mask_of_four(&range, 4))]
        }
    }

    #[inline(always)]
    unsafe fn read_f32(self, from: *const f32, range: Range<usize>) -> Floats {
        let from = from.wrapping_sub(range.start);
        // SAFETY: `self` exists, so the CPU has the instructions. Only the lanes of `range` are
        // read, the numbers at the caller's pointer, which exist by the contract; any alignment
        // will do.
        unsafe {
            let low = _mm_maskload_ps(from, narrow(mask_of_four(&range, 0)));
            let high = _mm_maskload_ps(from.wrapping_add(4), narrow(mask_of_four(&range, 4)));
            [_mm256_cvtps_pd(low), _mm256_cvtps_pd(high)]
        }
    }

    #[inline(always)]
    unsafe fn write_f64(self, x: Floats, to: *mut f64, range: Range<usize>) {
        let to = to.wrapping_sub(range.start);
        // SAFETY: `self` exists, so the CPU has the instructions. Only the lanes of `range` are
        // written, all eight without a mask, for which there is room by the contract; any alignment
        // will do.
        unsafe {
            if range.len() == LANES {
                // Much faster than with masks.
                _mm256_storeu_pd(to, x[0]);
                _mm256_storeu_pd(to.add(4), x[1]);
                return;
            }
            _mm256_maskstore_pd(to, mask_of_four(&range, 0), x[0]);
            _mm256_maskstore_pd(to.wrapping_add(4), mask_of_four(&range, 4), x[1]);
        }
    }

    #[inline(always)]
    unsafe fn write_f32(self, x: Floats, to: *mut f32, range: Range<usize>) {
        let to = to.wrapping_sub(range.start);
        // SAFETY: `self` exists, so the CPU has the instructions. Only the lanes of `range` are
        // written, for which there is room by the contract; any alignment will do.
        unsafe {
            let [low, high] = halves!(_mm256_cvtpd_ps, x);
            _mm_maskstore_ps(to, narrow(mask_of_four(&range, 0)), low);
            _mm_maskstore_ps(to.wrapping_add(4), narrow(mask_of_four(&range, 4)), high);
        }
    }

    #[inline(always)]
    fn transpose(self, rows: [Floats; LANES]) -> [Floats; LANES] {
        let mut columns = rows;
        for half in 0..2 {
            for other in 0..2 {
                let i = 4 * half;
                let block =
                    [rows[i][other], rows[i + 1][other], rows[i + 2][other], rows[i + 3][other]];
                // SAFETY: `self` exists, so the CPU has the instructions.
                let block = unsafe { transpose_four(block) };
                for i in 0..4 {
                    columns[4 * other + i][half] = block[i];
                }
            }
        }
        columns
    }

    by_instructions! {
        fn load(from: &[f64; LANES]) -> Floats {
            [_mm256_loadu_pd(from.as_ptr()), _mm256_loadu_pd(from.as_ptr().add(4))]
        }
        fn store(x: Floats, to: &mut [f64; LANES]) -> () {{
            _mm256_storeu_pd(to.as_mut_ptr(), x[0]);
            _mm256_storeu_pd(to.as_mut_ptr().add(4), x[1]);
        }}
        fn load_row(from: &Row) -> Integers {{
            let from = from.as_ptr().cast::<__m256i>();
            [_mm256_loadu_si256(from), _mm256_loadu_si256(from.add(1))]
        }}
        fn store_row(x: Integers, to: &mut Row) -> () {{
            let to = to.as_mut_ptr().cast::<__m256i>();
            _mm256_storeu_si256(to, x[0]);
            _mm256_storeu_si256(to.add(1), x[1]);
        }}
        fn store_low(x: Integers, to: &mut [i32; LANES]) -> () {{
            let [low, high] = halves!(_mm256_castsi256_ps, x);
            // Both halves of each register hold two of the four lanes.
            let mixed = _mm256_castps_pd(_mm256_shuffle_ps::<0x88>(low, high));
            let ordered = _mm256_castpd_si256(_mm256_permute4x64_pd::<0xd8>(mixed));
            _mm256_storeu_si256(to.as_mut_ptr().cast(), ordered)
        }}
        fn splat(x: f64) -> Floats { [_mm256_set1_pd(x); 2] }
        fn splat_integer(x: i64) -> Integers { [_mm256_set1_epi64x(x); 2] }
        fn splat_low(x: i32) -> Integers { [_mm256_set1_epi32(x); 2] }
        fn add(x: Floats, y: Floats) -> Floats { halves!(_mm256_add_pd, x, y) }
        fn sub(x: Floats, y: Floats) -> Floats { halves!(_mm256_sub_pd, x, y) }
        fn mul(x: Floats, y: Floats) -> Floats { halves!(_mm256_mul_pd, x, y) }
        fn max(x: Floats, y: Floats) -> Floats { halves!(_mm256_max_pd, x, y) }
        fn mul_add(x: Floats, y: Floats, z: Floats) -> Floats {
            halves!(_mm256_fmadd_pd, x, y, z)
        }
        fn all_within(x: Floats, least: f64, most: f64) -> bool {{
            let (least, most) = ([_mm256_set1_pd(least); 2], [_mm256_set1_pd(most); 2]);
            let above = halves!(_mm256_cmp_pd::<_CMP_GE_OQ>, x, least);
            let below = halves!(_mm256_cmp_pd::<_CMP_LE_OQ>, x, most);
            let within = halves!(_mm256_and_pd, above, below);
            _mm256_movemask_pd(_mm256_and_pd(within[0], within[1])) == 0xf
        }}
        fn where_nonzero(x: Floats) -> Integers {{
            let zero = [_mm256_setzero_pd(); 2];
            let found = halves!(_mm256_cmp_pd::<_CMP_NEQ_OQ>, x, zero);
            halves!(_mm256_castpd_si256, found)
        }}
        fn bits(x: Floats) -> Integers { halves!(_mm256_castpd_si256, x) }
        fn floats(x: Integers) -> Floats { halves!(_mm256_castsi256_pd, x) }
        fn add_integers(x: Integers, y: Integers) -> Integers { halves!(_mm256_add_epi64, x, y) }
        fn sub_integers(x: Integers, y: Integers) -> Integers { halves!(_mm256_sub_epi64, x, y) }
        fn and(x: Integers, y: Integers) -> Integers { halves!(_mm256_and_si256, x, y) }
        fn or(x: Integers, y: Integers) -> Integers { halves!(_mm256_or_si256, x, y) }
        fn xor(x: Integers, y: Integers) -> Integers { halves!(_mm256_xor_si256, x, y) }
        fn min_integers(x: Integers, y: Integers) -> Integers {{
            let larger = halves!(_mm256_cmpgt_epi64, x, y);
            halves!(_mm256_blendv_epi8, x, y, larger)
        }}
        fn all_equal(x: Integers, y: Integers) -> bool {{
            let equal = halves!(_mm256_cmpeq_epi64, x, y);
            _mm256_movemask_epi8(_mm256_and_si256(equal[0], equal[1])) == -1
        }}
        fn mul_low(x: Integers, y: Integers) -> Integers { halves!(_mm256_mul_epi32, x, y) }
    }

    #[inline(always)]
    fn shift_left<const BITS: u32>(self, x: Integers) -> Integers {
        // SAFETY: `self` exists, so the CPU has the instruction.
        unsafe {
            let count = _mm_cvtsi32_si128(BITS as i32);
            [_mm256_sll_epi64(x[0], count), _mm256_sll_epi64(x[1], count)]
        }
    }

    #[inline(always)]
    fn shift_right<const BITS: u32>(self, x: Integers) -> Integers {
        // SAFETY: `self` exists, so the CPU has the instruction.
        unsafe {
            let count = _mm_cvtsi32_si128(BITS as i32);
            [_mm256_srl_epi64(x[0], count), _mm256_srl_epi64(x[1], count)]
        }
    }

    #[inline(always)]
    fn shift_right_signed<const BITS: u32>(self, x: Integers) -> Integers {
        // There is no such instruction: 2^63 is added before the shift, and subtracted after it.
        let biased = self.xor(x, self.splat_integer(i64::MIN));
        let bias = self.splat_integer((1_i64 << 62) >> (BITS - 1));
        self.sub_integers(self.shift_right::<BITS>(biased), bias)
    }
}
