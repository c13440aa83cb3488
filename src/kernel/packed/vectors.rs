//! The operations on vectors that the algorithm is written in.

use super::tuning::Tuning;
use crate::base::Real;

/// Vectors of one instruction set, and the tiles that suit its registers.
pub(super) trait Vectors {
    type Scalar: Real;
    type Vector: Copy;
    /// A subset of the lanes of a vector.
    type Mask: Copy;
    /// Number of scalars of a vector.
    const LANES: usize;
    /// Number of rows of a tile: 4 or 8.
    const ROWS: usize;
    /// Number of vectors of a row of a tile: 2 or 3.
    const COUNT: usize;
    /// Whether masks have registers of their own: masked loads and stores then cost about as much
    /// as plain ones.
    const MASK_REGISTERS: bool;
    /// The constants of the loops around tiles.
    const TUNING: Tuning;
    /// Number of columns of a tile, and of a panel.
    const WIDTH: usize = Self::LANES * Self::COUNT;

    /// Returns a vector with `x` in every lane.
    ///
    /// # Safety
    /// The CPU has the instructions, as for every function of this trait.
    unsafe fn splat(x: Self::Scalar) -> Self::Vector;
    /// Loads a vector, from any scalar on.
    ///
    /// # Safety
    /// `from` points to [`Vectors::LANES`] scalars.
    unsafe fn load(from: *const Self::Scalar) -> Self::Vector;
    /// Stores a vector, from any scalar on.
    ///
    /// # Safety
    /// `to` points to room for [`Vectors::LANES`] scalars.
    unsafe fn store(to: *mut Self::Scalar, vector: Self::Vector);
    /// Stores a vector past the caches, by default as [`Vectors::store`] does. Other threads may
    /// read the vector only after [`finish_stores`](crate::kernel::finish_stores).
    ///
    /// # Safety
    /// As for [`Vectors::store`]; `to` is aligned to a vector.
    unsafe fn store_past_caches(to: *mut Self::Scalar, vector: Self::Vector) {
        // SAFETY: the contract includes that of `store`.
        unsafe { Self::store(to, vector) }
    }
    /// Returns the mask of the lanes whose bits are set; bits beyond the lanes are ignored.
    ///
    /// # Safety
    /// As for [`Vectors::splat`].
    unsafe fn mask(bits: u64) -> Self::Mask;
    /// Loads the lanes of the mask; the others are zero.
    ///
    /// # Safety
    /// The scalars of these lanes exist.
    unsafe fn load_masked(from: *const Self::Scalar, mask: Self::Mask) -> Self::Vector;
    /// Stores the lanes whose bits are set, and writes nothing else; bits beyond the lanes are
    /// ignored.
    ///
    /// # Safety
    /// There is room for these lanes.
    unsafe fn store_lanes(to: *mut Self::Scalar, bits: u64, vector: Self::Vector);
    /// Returns `a b + c`, rounded twice by the portable vectors and once by all others.
    ///
    /// # Safety
    /// As for [`Vectors::splat`].
    unsafe fn mul_add(a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
    /// Adds to each row of a tile the product of its scalar of the left side with the right side.
    ///
    /// # Safety
    /// `left` points to ROWS scalars.
    #[inline(always)]
    unsafe fn add_products<const ROWS: usize, const N: usize>(
        left: *const Self::Scalar,
        right: [Self::Vector; N],
        tile: &mut [[Self::Vector; N]; ROWS],
    ) {
        // SAFETY: `left` points to ROWS scalars, and i is below ROWS; the rest accesses no memory,
        // and the CPU has the instructions (clause `instructions`).
        unsafe {
            for i in 0..ROWS {
                let l = Self::splat(*left.add(i));
                for j in 0..N {
                    tile[i][j] = Self::mul_add(l, right[j], tile[i][j]);
                }
            }
        }
    }
    /// Returns `a + b`.
    ///
    /// # Safety
    /// As for [`Vectors::splat`].
    unsafe fn add(a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Returns `a b`.
    ///
    /// # Safety
    /// As for [`Vectors::splat`].
    unsafe fn mul(a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Returns `a / b`.
    ///
    /// # Safety
    /// As for [`Vectors::splat`].
    unsafe fn div(a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Returns the smaller of each pair of lanes.
    ///
    /// # Safety
    /// As for [`Vectors::splat`].
    unsafe fn min(a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Returns the larger of each pair of lanes.
    ///
    /// # Safety
    /// As for [`Vectors::splat`].
    unsafe fn max(a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Prefetches a cache line into the first-level cache; any address is allowed.
    fn prefetch(_address: *const Self::Scalar) {}
    /// Prefetches a cache line into the second-level cache; any address is allowed.
    fn prefetch_far(_address: *const Self::Scalar) {}
}

/// Returns a number with the lowest `count` bits set, at most 63.
#[inline(always)]
pub(super) const fn low_bits(count: usize) -> u64 {
    (1 << count) - 1
}
