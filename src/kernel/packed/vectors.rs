//! What an instruction set has to offer: all that the algorithm is written in.

use crate::base::Real;

/// Vectors of one instruction set, and the tiles that suit its registers.
pub(super) trait Vectors {
    type Scalar: Real;
    type Vector: Copy;
    /// Some lanes of a vector.
    type Mask: Copy;
    /// Scalars of a vector.
    const LANES: usize;
    /// Rows of a tile: 4 or 8.
    const ROWS: usize;
    /// Vectors of a row of a tile: 2 or 3.
    const COUNT: usize;
    /// Whether masked stores cost about what plain ones do.
    const MASKED_STORES: bool;
    /// Columns of a tile, and of a panel.
    const WIDTH: usize = Self::LANES * Self::COUNT;

    /// # Safety
    /// The CPU has the instructions; so for all of these.
    unsafe fn splat(x: Self::Scalar) -> Self::Vector;
    /// # Safety
    /// `from` points to [`Vectors::LANES`] scalars.
    unsafe fn load(from: *const Self::Scalar) -> Self::Vector;
    /// # Safety
    /// `to` points to room for [`Vectors::LANES`] scalars.
    unsafe fn store(to: *mut Self::Scalar, vector: Self::Vector);
    /// Stores past the caches: other threads may see the vector only after
    /// [`finish_stores`](crate::kernel::finish_stores).
    ///
    /// # Safety
    /// As for [`Vectors::store`]; `to` is aligned to a vector.
    unsafe fn store_past_caches(to: *mut Self::Scalar, vector: Self::Vector) {
        // SAFETY: the caller's promise.
        unsafe { Self::store(to, vector) }
    }
    /// The mask of the lanes whose bits are set; bits beyond the lanes do not matter.
    ///
    /// # Safety
    /// As above.
    unsafe fn mask(bits: u64) -> Self::Mask;
    /// Loads the lanes of the mask; the others are zero.
    ///
    /// # Safety
    /// The scalars of these lanes exist.
    unsafe fn load_masked(from: *const Self::Scalar, mask: Self::Mask) -> Self::Vector;
    /// Stores the lanes of the mask; nothing else is touched.
    ///
    /// # Safety
    /// There is room for these lanes.
    unsafe fn store_masked(to: *mut Self::Scalar, mask: Self::Mask, vector: Self::Vector);
    /// `a b + c`.
    ///
    /// # Safety
    /// As above.
    unsafe fn mul_add(a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
    /// # Safety
    /// As above.
    unsafe fn add(a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// # Safety
    /// As above.
    unsafe fn mul(a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// # Safety
    /// As above.
    unsafe fn div(a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// # Safety
    /// As above.
    unsafe fn min(a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// # Safety
    /// As above.
    unsafe fn max(a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Asks for a cache line; any address will do.
    fn prefetch(_address: *const Self::Scalar) {}
    /// The same, for the second-level cache.
    fn prefetch_far(_address: *const Self::Scalar) {}
}

/// The lowest `count` bits, at most 63.
#[inline(always)]
pub(super) fn low_bits(count: usize) -> u64 {
    (1 << count) - 1
}
