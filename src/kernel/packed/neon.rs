//! The kernels for NEON, which every AArch64 CPU has.
//!
//! Tiles have the extents of those for AVX2 and sum in the same order.

use std::arch::aarch64::*;

use super::kernel::instantiate;
use super::tuning::{self, Tuning};
use super::vectors::{Vectors, low_bits};
use crate::base::IsaLevel;
use crate::kernel::prefetch;

/// Implements `Vectors` for pairs of registers.
macro_rules! vectors {
    (
        $name:ident, $t:ident, $v:ident, $half:expr, $splat_each:ident,
        $splat:ident, $load:ident, $store:ident, $fma:ident, $($pairwise:ident: $function:ident),*
    ) => {
        pub(super) struct $name;

        impl Vectors for $name {
            type Scalar = $t;
            type Vector = [$v; 2];
            type Mask = u64;
            const LANES: usize = 2 * $half;
            const ROWS: usize = 4;
            const COUNT: usize = 3;
            const MASK_REGISTERS: bool = false;
            const TUNING: Tuning = tuning::NEON;

            #[inline(always)]
            unsafe fn splat(x: $t) -> [$v; 2] {
                // SAFETY: every AArch64 CPU has NEON; no memory is accessed.
                [unsafe { $splat(x) }; 2]
            }
            #[inline(always)]
            unsafe fn load(from: *const $t) -> [$v; 2] {
                // SAFETY: `from` points to LANES scalars, two registers, by the contract of `load`;
                // any alignment of a scalar will do, and every AArch64 CPU has NEON.
                unsafe { [$load(from), $load(from.add($half))] }
            }
            #[inline(always)]
            unsafe fn store(to: *mut $t, vector: [$v; 2]) {
                // SAFETY: `to` has room for LANES scalars, two registers, by the contract of
                // `store`; any alignment of a scalar will do, and every AArch64 CPU has NEON.
                unsafe {
                    $store(to, vector[0]);
                    $store(to.add($half), vector[1]);
                }
            }
            #[inline(always)]
            unsafe fn mask(bits: u64) -> u64 {
                bits & const { low_bits(2 * $half) }
            }
            #[inline(always)]
            unsafe fn load_masked(from: *const $t, mask: u64) -> [$v; 2] {
                // SAFETY: the lanes of the mask exist by the contract of `load_masked`, and no
                // others are read: all of them if the mask is full, else each whose bit is set. The
                // array has LANES scalars.
                unsafe {
                    if mask == const { low_bits(2 * $half) } {
                        return Self::load(from);
                    }
                    let lane = |i| if mask >> i & 1 == 1 { *from.add(i) } else { 0.0 };
                    Self::load(std::array::from_fn::<$t, { 2 * $half }, _>(lane).as_ptr())
                }
            }
            #[inline(always)]
            unsafe fn store_lanes(to: *mut $t, bits: u64, vector: [$v; 2]) {
                let mut lanes = [0.0; 2 * $half];
                // SAFETY: there is room for the lanes whose bits are set by the contract of
                // `store_lanes`, and no others are written. `lanes` has LANES scalars.
                unsafe {
                    Self::store(lanes.as_mut_ptr(), vector);
                    for (i, &lane) in lanes.iter().enumerate() {
                        if bits >> i & 1 == 1 {
                            *to.add(i) = lane;
                        }
                    }
                }
            }
            #[inline(always)]
            unsafe fn mul_add(a: [$v; 2], b: [$v; 2], c: [$v; 2]) -> [$v; 2] {
                // SAFETY: every AArch64 CPU has NEON; no memory is accessed.
                unsafe { [$fma(c[0], b[0], a[0]), $fma(c[1], b[1], a[1])] }
            }
            #[inline(always)]
            unsafe fn add_products<const ROWS: usize, const N: usize>(
                left: *const $t,
                right: [[$v; 2]; N],
                tile: &mut [[[$v; 2]; N]; ROWS],
            ) {
                // SAFETY: `left` points to ROWS scalars by the contract of `add_products`, as many
                // as `$splat_each` reads.
                unsafe {
                    // Lanes of registers that hold several scalars: `fmla` takes a lane as it is.
                    let left = $splat_each::<ROWS>(left);
                    for i in 0..ROWS {
                        for j in 0..N {
                            for half in 0..2 {
                                let sum = &mut tile[i][j][half];
                                *sum = $fma(*sum, right[j][half], left[i]);
                            }
                        }
                    }
                }
            }
            $(
                #[inline(always)]
                unsafe fn $pairwise(a: [$v; 2], b: [$v; 2]) -> [$v; 2] {
                    // SAFETY: every AArch64 CPU has NEON; no memory is accessed.
                    unsafe { [$function(a[0], b[0]), $function(a[1], b[1])] }
                }
            )*
            #[inline(always)]
            fn prefetch(address: *const $t) {
                prefetch::<false>(address.cast());
            }
            #[inline(always)]
            fn prefetch_far(address: *const $t) {
                prefetch::<true>(address.cast());
            }
        }
    };
}

/// Loads 1, 2, 4 or 8 scalars and returns a register filled with each of them.
///
/// # Safety
/// `from` points to so many scalars.
#[inline(always)]
unsafe fn splat_each_f64<const ROWS: usize>(from: *const f64) -> [float64x2_t; ROWS] {
    // SAFETY: `add_products` passes ROWS scalars (1, 2, 4 or 8); the load of one is done if ROWS is
    // 1, those of pairs below ROWS else. Every AArch64 CPU has NEON.
    unsafe {
        let mut found = [vdupq_n_f64(0.0); ROWS];
        if ROWS == 1 {
            found[0] = vld1q_dup_f64(from);
        }
        for (k, pair) in found.as_chunks_mut::<2>().0.iter_mut().enumerate() {
            let both = vld1q_f64(from.add(2 * k));
            *pair = [vdupq_laneq_f64::<0>(both), vdupq_laneq_f64::<1>(both)];
        }
        found
    }
}

/// Does the same as [`splat_each_f64`], for f32.
///
/// # Safety
/// As for [`splat_each_f64`].
#[inline(always)]
unsafe fn splat_each_f32<const ROWS: usize>(from: *const f32) -> [float32x4_t; ROWS] {
    // SAFETY: `add_products` passes ROWS scalars (1, 2, 4 or 8); each arm loads ROWS of them in
    // all. Every AArch64 CPU has NEON.
    unsafe {
        let mut found = [vdupq_n_f32(0.0); ROWS];
        match ROWS {
            1 => found[0] = vld1q_dup_f32(from),
            2 => {
                let both = vld1_f32(from);
                found[0] = vdupq_lane_f32::<0>(both);
                found[1] = vdupq_lane_f32::<1>(both);
            }
            _ => {
                for (k, four) in found.as_chunks_mut::<4>().0.iter_mut().enumerate() {
                    let all = vld1q_f32(from.add(4 * k));
                    *four = [
                        vdupq_laneq_f32::<0>(all),
                        vdupq_laneq_f32::<1>(all),
                        vdupq_laneq_f32::<2>(all),
                        vdupq_laneq_f32::<3>(all),
                    ];
                }
            }
        }
        found
    }
}

// 4 x 6 sums, 6 registers of the right panel and up to 2 of the left: all 32 registers. The rows of
// a tile divide the width, since a panel is packed for both sides.
vectors!(
    NeonF64, f64, float64x2_t, 2, splat_each_f64,
    vdupq_n_f64, vld1q_f64, vst1q_f64, vfmaq_f64,
    add: vaddq_f64, mul: vmulq_f64, div: vdivq_f64, min: vminq_f64, max: vmaxq_f64
);
vectors!(
    NeonF32, f32, float32x4_t, 4, splat_each_f32,
    vdupq_n_f32, vld1q_f32, vst1q_f32, vfmaq_f32,
    add: vaddq_f32, mul: vmulq_f32, div: vdivq_f32, min: vminq_f32, max: vmaxq_f32
);

/// The kernels.
pub(super) struct Neon(());

impl Neon {
    /// Returns the kernels, or why this process can't use them.
    pub fn new() -> Result<&'static Self, &'static str> {
        IsaLevel::Neon.permitted().map(|()| &Self(()))
    }
}

instantiate!(Neon, f64, NeonF64,);
instantiate!(Neon, f32, NeonF32,);
