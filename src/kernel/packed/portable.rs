//! Plain Rust: arrays for vectors, which compilers put into the registers of any CPU.

use super::generic::Vectors;
use super::instantiate;
use crate::base::Real;

pub(super) struct Portable;

/// Vectors of N scalars: 16 bytes, what every x86-64 has.
pub(super) struct Array<T, const N: usize>(std::marker::PhantomData<T>);

impl<T: Real, const N: usize> Vectors for Array<T, N> {
    type Scalar = T;
    type Vector = [T; N];
    const LANES: usize = N;
    const ROWS: usize = 4;
    const COUNT: usize = 2;

    #[inline(always)]
    unsafe fn splat(x: T) -> [T; N] {
        [x; N]
    }
    #[inline(always)]
    unsafe fn load(from: *const T) -> [T; N] {
        // SAFETY: the caller's promise.
        unsafe { from.cast::<[T; N]>().read() }
    }
    #[inline(always)]
    unsafe fn store(to: *mut T, vector: [T; N]) {
        // SAFETY: the caller's promise.
        unsafe { to.cast::<[T; N]>().write(vector) }
    }
    #[inline(always)]
    unsafe fn mul_add(a: [T; N], b: [T; N], c: [T; N]) -> [T; N] {
        // Two roundings: without the instruction a fused one is a call.
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
}

instantiate!(Portable, f64, Array<f64, 2>,);
instantiate!(Portable, f32, Array<f32, 4>,);
