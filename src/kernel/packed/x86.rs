//! The kernels for AVX-512 and AVX2, with FMA and BMI2.

use std::arch::x86_64::*;

use super::kernel::instantiate;
use super::tuning::{self, Tuning};
use super::vectors::Vectors;
use crate::base::IsaLevel;

/// Implements `Vectors` for one register type.
macro_rules! vectors {
    (
        $name:ident, $t:ident, $v:ident, $lanes:expr, rows: $rows:expr,
        mask_registers: $mask_registers:expr, $tuning:expr,
        $splat:ident, $load:ident, $store:ident, $stream:ident,
        $m:ident, $mask:ident, $load_masked:ident, $store_lanes:ident,
        $fma:ident, $($pairwise:ident: $function:ident),*
    ) => {
        pub(super) struct $name;

        impl Vectors for $name {
            type Scalar = $t;
            type Vector = $v;
            type Mask = $m;
            const LANES: usize = $lanes;
            const ROWS: usize = $rows;
            const COUNT: usize = 3;
            const MASK_REGISTERS: bool = $mask_registers;
            const TUNING: Tuning = $tuning;

            #[inline(always)]
            unsafe fn splat(x: $t) -> $v {
                // SAFETY: the CPU has the instruction (clause `instructions` of the module
                // `packed`); no memory is accessed.
                unsafe { $splat(x) }
            }
            #[inline(always)]
            unsafe fn load(from: *const $t) -> $v {
                // SAFETY: clause `instructions`; `from` points to LANES scalars by the contract of
                // `load`, and the instruction takes any alignment.
                unsafe { $load(from) }
            }
            #[inline(always)]
            unsafe fn store(to: *mut $t, vector: $v) {
                // SAFETY: clause `instructions`; `to` has room for LANES scalars by the contract of
                // `store`, and the instruction takes any alignment.
                unsafe { $store(to, vector) }
            }
            #[inline(always)]
            unsafe fn store_past_caches(to: *mut $t, vector: $v) {
                // SAFETY: clause `instructions`; `to` has room for LANES scalars and is aligned to
                // a vector by the contract of `store_past_caches` (clause `alignment`), which the
                // stores of AVX-512 need.
                unsafe { $stream(to, vector) }
            }
            #[inline(always)]
            unsafe fn mask(bits: u64) -> $m {
                // SAFETY: clause `instructions`; no memory is accessed.
                unsafe { $mask(bits) }
            }
            #[inline(always)]
            unsafe fn load_masked(from: *const $t, mask: $m) -> $v {
                // SAFETY: clause `instructions`; the lanes of the mask exist by the contract of
                // `load_masked`, and the instruction reads no others and takes any alignment.
                unsafe { $load_masked(from, mask) }
            }
            #[inline(always)]
            unsafe fn store_lanes(to: *mut $t, bits: u64, vector: $v) {
                // SAFETY: clause `instructions`; there is room for the lanes of the mask by the
                // contract of `store_lanes`, and the function writes no others and takes any
                // alignment of a scalar.
                unsafe { $store_lanes(to, bits, vector) }
            }
            #[inline(always)]
            unsafe fn mul_add(a: $v, b: $v, c: $v) -> $v {
                // SAFETY: clause `instructions`; no memory is accessed.
                unsafe { $fma(a, b, c) }
            }
            $(
                #[inline(always)]
                unsafe fn $pairwise(a: $v, b: $v) -> $v {
                    // SAFETY: clause `instructions`; no memory is accessed.
                    unsafe { $function(a, b) }
                }
            )*
            #[inline(always)]
            fn prefetch(address: *const $t) {
                // SAFETY: every x86-64 CPU has the instruction, a hint that is allowed for any
                // address.
                unsafe { _mm_prefetch::<_MM_HINT_T0>(address.cast()) }
            }
            #[inline(always)]
            fn prefetch_far(address: *const $t) {
                // SAFETY: every x86-64 CPU has the instruction, a hint that is allowed for any
                // address.
                unsafe { _mm_prefetch::<_MM_HINT_T1>(address.cast()) }
            }
        }
    };
}

#[inline(always)]
unsafe fn mask_8_bits(bits: u64) -> __mmask8 {
    bits as __mmask8
}

#[inline(always)]
unsafe fn mask_16_bits(bits: u64) -> __mmask16 {
    bits as __mmask16
}

/// Returns a mask with all bits of the 64-bit lanes whose bits are set.
#[inline(always)]
unsafe fn mask_4_lanes(bits: u64) -> __m256i {
    // SAFETY: called by `Avx2F64::mask` only, and clause `instructions` gives it AVX2; no memory is
    // accessed.
    unsafe {
        let own = _mm256_set_epi64x(8, 4, 2, 1);
        _mm256_cmpeq_epi64(_mm256_and_si256(_mm256_set1_epi64x(bits as i64), own), own)
    }
}

/// Returns a mask with all bits of the 32-bit lanes whose bits are set.
#[inline(always)]
unsafe fn mask_8_lanes(bits: u64) -> __m256i {
    // SAFETY: called by `Avx2F32::mask` only, and clause `instructions` gives it AVX2; no memory is
    // accessed.
    unsafe {
        let own = _mm256_set_epi32(128, 64, 32, 16, 8, 4, 2, 1);
        _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(bits as i32), own), own)
    }
}

#[inline(always)]
unsafe fn load_f64x8(from: *const f64, mask: __mmask8) -> __m512d {
    // SAFETY: called by `Avx512F64::load_masked` only, whose CPU has AVX-512 F (clause
    // `instructions`) and whose contract says that the lanes of the mask exist; no others are read.
    unsafe { _mm512_maskz_loadu_pd(mask, from) }
}

#[inline(always)]
unsafe fn load_f32x16(from: *const f32, mask: __mmask16) -> __m512 {
    // SAFETY: called by `Avx512F32::load_masked` only, whose CPU has AVX-512 F (clause
    // `instructions`) and whose contract says that the lanes of the mask exist; no others are read.
    unsafe { _mm512_maskz_loadu_ps(mask, from) }
}

#[inline(always)]
unsafe fn store_f64x8(to: *mut f64, bits: u64, vector: __m512d) {
    // SAFETY: called by `Avx512F64::store_lanes` only, whose CPU has AVX-512 F (clause
    // `instructions`) and whose contract gives room for the lanes of the mask; no others are
    // written.
    unsafe { _mm512_mask_storeu_pd(to, bits as __mmask8, vector) }
}

#[inline(always)]
unsafe fn store_f32x16(to: *mut f32, bits: u64, vector: __m512) {
    // SAFETY: called by `Avx512F32::store_lanes` only, whose CPU has AVX-512 F (clause
    // `instructions`) and whose contract gives room for the lanes of the mask; no others are
    // written.
    unsafe { _mm512_mask_storeu_ps(to, bits as __mmask16, vector) }
}

/// Stores lanes by halves and single ones: the masked stores of AVX2 are slow on CPUs of AMD.
#[inline(always)]
unsafe fn store_f64x4(to: *mut f64, bits: u64, vector: __m256d) {
    // SAFETY: called by `Avx2F64::store_lanes` only, whose CPU has AVX2 (clause `instructions`) and
    // whose contract gives room for the lanes whose bits are set: both, the upper or the lower one
    // of each half, and no others are written. `to` is aligned to a scalar, and stores of both take
    // any alignment.
    unsafe {
        let halves = [_mm256_castpd256_pd128(vector), _mm256_extractf128_pd::<1>(vector)];
        for (i, half) in halves.into_iter().enumerate() {
            let to = to.wrapping_add(2 * i);
            match bits >> (2 * i) & 3 {
                3 => _mm_storeu_pd(to, half),
                2 => _mm_storeh_pd(to.wrapping_add(1), half),
                1 => _mm_storel_pd(to, half),
                _ => {}
            }
        }
    }
}

/// As [`store_f64x4`].
#[inline(always)]
unsafe fn store_f32x8(to: *mut f32, bits: u64, vector: __m256) {
    // SAFETY: called by `Avx2F32::store_lanes` only, whose CPU has AVX2 (clause `instructions`) and
    // whose contract gives room for the lanes whose bits are set: all of a half, or both, the upper
    // or the lower one of each quarter, and no others are written. `to` is aligned to a scalar, and
    // stores of several lanes take any alignment.
    unsafe {
        let halves = [_mm256_castps256_ps128(vector), _mm256_extractf128_ps::<1>(vector)];
        for (i, half) in halves.into_iter().enumerate() {
            let (to, bits) = (to.wrapping_add(4 * i), bits >> (4 * i) & 15);
            if bits == 15 {
                _mm_storeu_ps(to, half);
                continue;
            }
            for (j, pair) in [half, _mm_movehl_ps(half, half)].into_iter().enumerate() {
                let to = to.wrapping_add(2 * j);
                match bits >> (2 * j) & 3 {
                    3 => _mm_storel_epi64(to.cast(), _mm_castps_si128(pair)),
                    2 => _mm_store_ss(to.wrapping_add(1), _mm_movehdup_ps(pair)),
                    1 => _mm_store_ss(to, pair),
                    _ => {}
                }
            }
        }
    }
}

// 8 x 3 sums, 3 vectors of the right panel and 1 of the left: 28 of 32 registers.
vectors!(
    Avx512F64, f64, __m512d, 8, rows: 8, mask_registers: true, tuning::AVX512,
    _mm512_set1_pd, _mm512_loadu_pd, _mm512_storeu_pd, _mm512_stream_pd,
    __mmask8, mask_8_bits, load_f64x8, store_f64x8,
    _mm512_fmadd_pd, add: _mm512_add_pd, mul: _mm512_mul_pd, div: _mm512_div_pd, min: _mm512_min_pd,
    max: _mm512_max_pd
);
vectors!(
    Avx512F32, f32, __m512, 16, rows: 8, mask_registers: true, tuning::AVX512,
    _mm512_set1_ps, _mm512_loadu_ps, _mm512_storeu_ps, _mm512_stream_ps,
    __mmask16, mask_16_bits, load_f32x16, store_f32x16,
    _mm512_fmadd_ps, add: _mm512_add_ps, mul: _mm512_mul_ps, div: _mm512_div_ps, min: _mm512_min_ps,
    max: _mm512_max_ps
);
// 4 x 3 sums, 3 vectors of the right panel and 1 of the left: all 16 registers. Panels are not
// written past the caches, since their rows end within cache lines.
vectors!(
    Avx2F64, f64, __m256d, 4, rows: 4, mask_registers: false, tuning::AVX2,
    _mm256_set1_pd, _mm256_loadu_pd, _mm256_storeu_pd, _mm256_storeu_pd,
    __m256i, mask_4_lanes, _mm256_maskload_pd, store_f64x4,
    _mm256_fmadd_pd, add: _mm256_add_pd, mul: _mm256_mul_pd, div: _mm256_div_pd, min: _mm256_min_pd,
    max: _mm256_max_pd
);
vectors!(
    Avx2F32, f32, __m256, 8, rows: 4, mask_registers: false, tuning::AVX2,
    _mm256_set1_ps, _mm256_loadu_ps, _mm256_storeu_ps, _mm256_storeu_ps,
    __m256i, mask_8_lanes, _mm256_maskload_ps, store_f32x8,
    _mm256_fmadd_ps, add: _mm256_add_ps, mul: _mm256_mul_ps, div: _mm256_div_ps, min: _mm256_min_ps,
    max: _mm256_max_ps
);

/// The kernels for AVX-512. A value exists only if the CPU has it, so the kernels are sound.
pub(super) struct Avx512(());

impl Avx512 {
    /// Returns the kernels, or why this machine can't use them.
    pub fn new() -> Result<&'static Self, &'static str> {
        IsaLevel::Avx512.permitted()?;
        let found = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi2");
        if found { Ok(&Self(())) } else { Err("the CPU has no AVX-512") }
    }
}

/// The kernels for AVX2. A value exists only if the CPU has AVX2, FMA and BMI2, so the kernels are
/// sound.
pub(super) struct Avx2(());

impl Avx2 {
    /// Returns the kernels, or why this machine can't use them.
    pub fn new() -> Result<&'static Self, &'static str> {
        IsaLevel::Avx2.permitted()?;
        let found = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi2");
        if found { Ok(&Self(())) } else { Err("the CPU has no AVX2 with FMA and BMI2") }
    }
}

instantiate!(Avx512, f64, Avx512F64, #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,fma,bmi2")]);
instantiate!(Avx512, f32, Avx512F32, #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,fma,bmi2")]);
instantiate!(Avx2, f64, Avx2F64, #[target_feature(enable = "avx2,fma,bmi2")]);
instantiate!(Avx2, f32, Avx2F32, #[target_feature(enable = "avx2,fma,bmi2")]);
