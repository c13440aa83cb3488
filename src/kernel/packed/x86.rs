//! AVX-512 and AVX2 with FMA.

use std::arch::x86_64::*;

use super::generic::Vectors;
use super::instantiate;

/// `Vectors` of one register type.
macro_rules! vectors {
    (
        $name:ident, $t:ident, $v:ident, $lanes:expr, rows: $rows:expr,
        $splat:ident, $load:ident, $store:ident, $fma:ident, $add:ident, $mul:ident
    ) => {
        pub(super) struct $name;

        impl Vectors for $name {
            type Scalar = $t;
            type Vector = $v;
            const LANES: usize = $lanes;
            const ROWS: usize = $rows;
            const COUNT: usize = 3;

            #[inline(always)]
            unsafe fn splat(x: $t) -> $v {
                // SAFETY: the caller's promise.
                unsafe { $splat(x) }
            }
            #[inline(always)]
            unsafe fn load(from: *const $t) -> $v {
                // SAFETY: the caller's promise.
                unsafe { $load(from) }
            }
            #[inline(always)]
            unsafe fn store(to: *mut $t, vector: $v) {
                // SAFETY: the caller's promise.
                unsafe { $store(to, vector) }
            }
            #[inline(always)]
            unsafe fn mul_add(a: $v, b: $v, c: $v) -> $v {
                // SAFETY: the caller's promise.
                unsafe { $fma(a, b, c) }
            }
            #[inline(always)]
            unsafe fn add(a: $v, b: $v) -> $v {
                // SAFETY: the caller's promise.
                unsafe { $add(a, b) }
            }
            #[inline(always)]
            unsafe fn mul(a: $v, b: $v) -> $v {
                // SAFETY: the caller's promise.
                unsafe { $mul(a, b) }
            }
            #[inline(always)]
            fn prefetch(address: *const $t) {
                // SAFETY: a hint, for any address.
                unsafe { _mm_prefetch::<_MM_HINT_T0>(address.cast()) }
            }
            #[inline(always)]
            fn prefetch_far(address: *const $t) {
                // SAFETY: a hint, for any address.
                unsafe { _mm_prefetch::<_MM_HINT_T1>(address.cast()) }
            }
        }
    };
}

// 8 x 3 sums, 3 vectors of the right panel and one of the left: 28 of 32 registers.
vectors!(
    Avx512F64, f64, __m512d, 8, rows: 8,
    _mm512_set1_pd, _mm512_loadu_pd, _mm512_storeu_pd, _mm512_fmadd_pd, _mm512_add_pd, _mm512_mul_pd
);
vectors!(
    Avx512F32, f32, __m512, 16, rows: 8,
    _mm512_set1_ps, _mm512_loadu_ps, _mm512_storeu_ps, _mm512_fmadd_ps, _mm512_add_ps, _mm512_mul_ps
);
// 4 x 3 sums, 3 and 1: all 16 registers.
vectors!(
    Avx2F64, f64, __m256d, 4, rows: 4,
    _mm256_set1_pd, _mm256_loadu_pd, _mm256_storeu_pd, _mm256_fmadd_pd, _mm256_add_pd, _mm256_mul_pd
);
vectors!(
    Avx2F32, f32, __m256, 8, rows: 4,
    _mm256_set1_ps, _mm256_loadu_ps, _mm256_storeu_ps, _mm256_fmadd_ps, _mm256_add_ps, _mm256_mul_ps
);

/// Exists only where the CPU has AVX-512: what makes its kernels sound.
pub(super) struct Avx512(());

impl Avx512 {
    pub fn new() -> Result<&'static Self, &'static str> {
        let found = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("fma");
        if found { Ok(&Self(())) } else { Err("the CPU has no AVX-512") }
    }
}

/// Exists only where the CPU has AVX2 and FMA: what makes its kernels sound.
pub(super) struct Avx2(());

impl Avx2 {
    pub fn new() -> Result<&'static Self, &'static str> {
        let found = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
        if found { Ok(&Self(())) } else { Err("the CPU has no AVX2 with FMA") }
    }
}

instantiate!(Avx512, f64, Avx512F64, #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,fma")]);
instantiate!(Avx512, f32, Avx512F32, #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,fma")]);
instantiate!(Avx2, f64, Avx2F64, #[target_feature(enable = "avx2,fma")]);
instantiate!(Avx2, f32, Avx2F32, #[target_feature(enable = "avx2,fma")]);
