//! Types without padding for which every bit pattern is a value.

/// A type for which every bit pattern is a value.
///
/// # Safety
/// Every bit pattern of the type is a value, and the type has no padding.
pub unsafe trait Plain: Copy + Send + Sync {}

// SAFETY: an integer, of which all bit patterns are values; no padding.
unsafe impl Plain for u8 {}
// SAFETY: an integer, of which all bit patterns are values; no padding.
unsafe impl Plain for i8 {}
// SAFETY: an integer, of which all bit patterns are values; no padding.
unsafe impl Plain for i32 {}
// SAFETY: an integer, of which all bit patterns are values; no padding.
unsafe impl Plain for i64 {}
// SAFETY: an integer, of which all bit patterns are values; no padding.
unsafe impl Plain for i128 {}
// SAFETY: a number of IEEE 754, of which all bit patterns are values, NaN among them; no padding.
unsafe impl Plain for f32 {}
// SAFETY: a number of IEEE 754, of which all bit patterns are values, NaN among them; no padding.
unsafe impl Plain for f64 {}
// SAFETY: every bit pattern of the elements is a value, and arrays add no padding.
unsafe impl<T: Plain, const N: usize> Plain for [T; N] {}
