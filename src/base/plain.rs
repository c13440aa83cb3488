//! Types without padding for which every bit pattern is a value.

/// A type for which every bit pattern is a value.
///
/// # Safety
/// Every bit pattern of the type is a value, and the type has no padding.
pub unsafe trait Plain: Copy + Send + Sync {}

// SAFETY: as the trait asks.
unsafe impl Plain for u8 {}
// SAFETY: as the trait asks.
unsafe impl Plain for i8 {}
// SAFETY: as the trait asks.
unsafe impl Plain for i32 {}
// SAFETY: as the trait asks.
unsafe impl Plain for i64 {}
// SAFETY: as the trait asks.
unsafe impl Plain for i128 {}
// SAFETY: as the trait asks.
unsafe impl Plain for f32 {}
// SAFETY: as the trait asks.
unsafe impl Plain for f64 {}
// SAFETY: as the trait asks: arrays have no padding of their own.
unsafe impl<T: Plain, const N: usize> Plain for [T; N] {}
