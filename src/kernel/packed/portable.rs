//! The kernels in plain Rust: vectors are arrays, which compilers put into the registers of any
//! CPU.

use super::kernel::instantiate;
use super::tuning::{self, Tuning};
use super::vectors::Vectors;
use crate::base::Real;

pub(super) struct Portable;

/// Vectors of N scalars: of 16 bytes, which every x86-64 and AArch64 CPU has.
pub(super) struct Array<T, const N: usize>(std::marker::PhantomData<T>);

impl<T: Real, const N: usize> Vectors for Array<T, N> {
    type Scalar = T;
    type Vector = [T; N];
    type Mask = u64;
    const LANES: usize = N;
    const ROWS: usize = 4;
    const COUNT: usize = 2;
    const MASK_REGISTERS: bool = false;
    const TUNING: Tuning = tuning::PORTABLE;

    #[inline(always)]
    unsafe fn splat(x: T) -> [T; N] {
        [x; N]
    }
    #[inline(always)]
    unsafe fn load(from: *const T) -> [T; N] {
        // SAFETY: `from` points to N = LANES scalars by the contract of `load`, and an array is
        // aligned as they are.
        unsafe { from.cast::<[T; N]>().read() }
    }
    #[inline(always)]
    unsafe fn store(to: *mut T, vector: [T; N]) {
        // SAFETY: `to` has room for N = LANES scalars by the contract of `store`, and an array is
        // aligned as they are.
        unsafe { to.cast::<[T; N]>().write(vector) }
    }
    #[inline(always)]
    unsafe fn mask(bits: u64) -> u64 {
        bits
    }
    #[inline(always)]
    unsafe fn load_masked(from: *const T, mask: u64) -> [T; N] {
        // SAFETY: the lanes of the mask exist by the contract of `load_masked`, and only these are
        // read.
        std::array::from_fn(|i| if mask >> i & 1 == 1 { unsafe { *from.add(i) } } else { T::ZERO })
    }
    #[inline(always)]
    unsafe fn store_lanes(to: *mut T, bits: u64, vector: [T; N]) {
        for i in 0..N {
            if bits >> i & 1 == 1 {
                // SAFETY: there is room for the lanes whose bits are set by the contract of
                // `store_lanes`, and only these are written.
                unsafe { *to.add(i) = vector[i] };
            }
        }
    }
    #[inline(always)]
    unsafe fn mul_add(a: [T; N], b: [T; N], c: [T; N]) -> [T; N] {
        // Two roundings: without the instruction, a fused multiply-add is a function call.
        std::array::from_fn(|i| a[i] * b[i] + c[i])
    }
    #[inline(always)]
    unsafe fn add(a: [T; N], b: [T; N]) -> [T; N] {
        std::array::from_fn(|i| a[i] + b[i])
    }
    #[inline(always)]
    unsafe fn mul(a: [T; N], b: [T; N]) -> [T; N] {
        std::array::from_fn(|i| a[i] * b[i])
    }
    #[inline(always)]
    unsafe fn div(a: [T; N], b: [T; N]) -> [T; N] {
        std::array::from_fn(|i| a[i] / b[i])
    }
    #[inline(always)]
    unsafe fn min(a: [T; N], b: [T; N]) -> [T; N] {
        std::array::from_fn(|i| if a[i] < b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    unsafe fn max(a: [T; N], b: [T; N]) -> [T; N] {
        std::array::from_fn(|i| if a[i] > b[i] { a[i] } else { b[i] })
    }
}

instantiate!(Portable, f64, Array<f64, 2>,);
instantiate!(Portable, f32, Array<f32, 4>,);
