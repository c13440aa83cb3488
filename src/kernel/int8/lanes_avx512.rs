//! Vectors of eight numbers in a register of AVX-512.

use std::arch::x86_64::*;
use std::ops::Range;

use super::lanes::{LANES, Lanes, OnLanes, Row, by_instructions};

/// Vectors of a register each. A value exists only if the CPU has the instructions.
#[derive(Clone, Copy)]
pub(crate) struct Avx512Lanes(());

impl Avx512Lanes {
    /// Returns the value.
    ///
    /// # Safety
    /// The CPU has AVX-512 F, BW, DQ and VL, and FMA.
    pub unsafe fn new() -> Self {
        Self(())
    }

    /// Runs `work`, compiled for these vectors.
    #[inline(always)]
    pub fn run<W: OnLanes>(self, work: W) -> W::Output {
        #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,fma")]
        fn run<W: OnLanes>(lanes: Avx512Lanes, work: W) -> W::Output {
            work.run(lanes)
        }
        // SAFETY: `self` exists, so the CPU has the instructions.
        unsafe { run(self, work) }
    }
}

/// Returns the mask of these lanes.
#[inline(always)]
fn mask(range: &Range<usize>) -> __mmask8 {
    ((1_u32 << range.end) - (1 << range.start)) as __mmask8
}

impl Lanes for Avx512Lanes {
    type Floats = __m512d;
    type Integers = __m512i;
    const COLUMNS: usize = 4;

    #[inline(always)]
    unsafe fn read_f64(self, from: *const f64, range: Range<usize>) -> __m512d {
        // SAFETY: `self` exists, so the CPU has the instructions. Only the lanes of `range` are
        // read, which exist by the contract; any alignment will do.
        unsafe { _mm512_maskz_loadu_pd(mask(&range), from.wrapping_sub(range.start)) }
    }

    #[inline(always)]
    unsafe fn read_f32(self, from: *const f32, range: Range<usize>) -> __m512d {
        // SAFETY: `self` exists, so the CPU has the instructions. Only the lanes of `range` are
        // read, which exist by the contract; any alignment will do.
        unsafe {
            let from = from.wrapping_sub(range.start);
            _mm512_cvtps_pd(_mm256_maskz_loadu_ps(mask(&range), from))
        }
    }

    #[inline(always)]
    unsafe fn write_f64(self, x: __m512d, to: *mut f64, range: Range<usize>) {
        // SAFETY: `self` exists, so the CPU has the instructions. Only the lanes of `range` are
        // written, for which there is room by the contract; any alignment will do.
        unsafe { _mm512_mask_storeu_pd(to.wrapping_sub(range.start), mask(&range), x) }
    }

    #[inline(always)]
    unsafe fn write_f32(self, x: __m512d, to: *mut f32, range: Range<usize>) {
        let to = to.wrapping_sub(range.start);
        // SAFETY: `self` exists, so the CPU has the instructions. Only the lanes of `range` are
        // written, for which there is room by the contract; any alignment will do.
        unsafe { _mm256_mask_storeu_ps(to, mask(&range), _mm512_cvtpd_ps(x)) }
    }

    #[inline(always)]
    fn transpose(self, rows: [__m512d; LANES]) -> [__m512d; LANES] {
        // SAFETY: `self` exists, so the CPU has the instructions.
        unsafe {
            // Pairs of rows: the even columns, then the odd ones.
            let mut pairs = rows;
            for i in (0..LANES).step_by(2) {
                pairs[i] = _mm512_unpacklo_pd(rows[i], rows[i + 1]);
                pairs[i + 1] = _mm512_unpackhi_pd(rows[i], rows[i + 1]);
            }
            // Quarters of the vectors are columns c, c + 2, c + 4 and c + 6 of two rows.
            let mut columns = rows;
            for c in 0..2 {
                let [p, q, r, s] = [pairs[c], pairs[c + 2], pairs[c + 4], pairs[c + 6]];
                let low_pq = _mm512_shuffle_f64x2::<0x88>(p, q);
                let high_pq = _mm512_shuffle_f64x2::<0xdd>(p, q);
                let low_rs = _mm512_shuffle_f64x2::<0x88>(r, s);
                let high_rs = _mm512_shuffle_f64x2::<0xdd>(r, s);
                columns[c] = _mm512_shuffle_f64x2::<0x88>(low_pq, low_rs);
                columns[c + 2] = _mm512_shuffle_f64x2::<0x88>(high_pq, high_rs);
                columns[c + 4] = _mm512_shuffle_f64x2::<0xdd>(low_pq, low_rs);
                columns[c + 6] = _mm512_shuffle_f64x2::<0xdd>(high_pq, high_rs);
            }
            columns
        }
    }

    by_instructions! {
        fn load(from: &[f64; LANES]) -> __m512d { _mm512_loadu_pd(from.as_ptr()) }
        fn store(x: __m512d, to: &mut [f64; LANES]) -> () { _mm512_storeu_pd(to.as_mut_ptr(), x) }
        fn load_row(from: &Row) -> __m512i { _mm512_loadu_si512(from.as_ptr().cast()) }
        fn store_row(x: __m512i, to: &mut Row) -> () {
            _mm512_storeu_si512(to.as_mut_ptr().cast(), x)
        }
        fn store_low(x: __m512i, to: &mut [i32; LANES]) -> () {
            _mm256_storeu_si256(to.as_mut_ptr().cast(), _mm512_cvtepi64_epi32(x))
        }
        fn splat(x: f64) -> __m512d { _mm512_set1_pd(x) }
        fn splat_integer(x: i64) -> __m512i { _mm512_set1_epi64(x) }
        fn splat_low(x: i32) -> __m512i { _mm512_set1_epi32(x) }
        fn add(x: __m512d, y: __m512d) -> __m512d { _mm512_add_pd(x, y) }
        fn sub(x: __m512d, y: __m512d) -> __m512d { _mm512_sub_pd(x, y) }
        fn mul(x: __m512d, y: __m512d) -> __m512d { _mm512_mul_pd(x, y) }
        fn max(x: __m512d, y: __m512d) -> __m512d { _mm512_max_pd(x, y) }
        fn mul_add(x: __m512d, y: __m512d, z: __m512d) -> __m512d { _mm512_fmadd_pd(x, y, z) }
        fn all_within(x: __m512d, least: f64, most: f64) -> bool {{
            let above = _mm512_cmp_pd_mask::<_CMP_GE_OQ>(x, _mm512_set1_pd(least));
            above & _mm512_cmp_pd_mask::<_CMP_LE_OQ>(x, _mm512_set1_pd(most)) == 0xff
        }}
        fn where_nonzero(x: __m512d) -> __m512i {
            _mm512_movm_epi64(_mm512_cmp_pd_mask::<_CMP_NEQ_OQ>(x, _mm512_setzero_pd()))
        }
        fn bits(x: __m512d) -> __m512i { _mm512_castpd_si512(x) }
        fn floats(x: __m512i) -> __m512d { _mm512_castsi512_pd(x) }
        fn add_integers(x: __m512i, y: __m512i) -> __m512i { _mm512_add_epi64(x, y) }
        fn sub_integers(x: __m512i, y: __m512i) -> __m512i { _mm512_sub_epi64(x, y) }
        fn and(x: __m512i, y: __m512i) -> __m512i { _mm512_and_si512(x, y) }
        fn or(x: __m512i, y: __m512i) -> __m512i { _mm512_or_si512(x, y) }
        fn xor(x: __m512i, y: __m512i) -> __m512i { _mm512_xor_si512(x, y) }
        fn min_integers(x: __m512i, y: __m512i) -> __m512i { _mm512_min_epi64(x, y) }
        fn all_equal(x: __m512i, y: __m512i) -> bool { _mm512_cmpneq_epi64_mask(x, y) == 0 }
        fn mul_low(x: __m512i, y: __m512i) -> __m512i { _mm512_mul_epi32(x, y) }
    }

    #[inline(always)]
    fn shift_left<const BITS: u32>(self, x: __m512i) -> __m512i {
        // SAFETY: `self` exists, so the CPU has the instruction.
        unsafe { _mm512_slli_epi64::<BITS>(x) }
    }

    #[inline(always)]
    fn shift_right<const BITS: u32>(self, x: __m512i) -> __m512i {
        // SAFETY: `self` exists, so the CPU has the instruction.
        unsafe { _mm512_srli_epi64::<BITS>(x) }
    }

    #[inline(always)]
    fn shift_right_signed<const BITS: u32>(self, x: __m512i) -> __m512i {
        // SAFETY: `self` exists, so the CPU has the instruction.
        unsafe { _mm512_srai_epi64::<BITS>(x) }
    }
}
