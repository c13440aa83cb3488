//! The measured constants of the loops around tiles: a line for each instruction set.

/// Constants of the loops around the tiles of one instruction set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Tuning {
    /// Most rows of the sources that a tile sums in registers: the left side of a row of tiles
    /// stays in the first-level cache, and sums stay short. Determines how sums are rounded.
    pub depth: usize,
    /// Eighths of the second-level cache for the sums and the right side of an item; the left side
    /// passes through the rest.
    pub item: usize,
    /// Distance of prefetches from the operands of a tile, in steps.
    pub ahead: usize,
    /// The same for a packed left side; with 0 its strip, which all tiles of a row read, is not
    /// prefetched.
    pub left_ahead: usize,
    /// Distance of prefetches from the sources of packing, in rows.
    pub rows_ahead: usize,
    /// Most panels of a side that is read in place: with more panels, rows are read so often that
    /// packing pays.
    pub in_place: usize,
}

/// Most rows that any instruction set sums in registers.
pub(super) const DEEPEST: usize = 320;

impl Tuning {
    const fn new([depth, item, ahead, left_ahead, rows_ahead, in_place]: [usize; 6]) -> Self {
        assert!(depth <= DEEPEST && item < 8);
        Self { depth, item, ahead, left_ahead, rows_ahead, in_place }
    }
}

// In the order of the fields. Measured on Zen 4 and 5 and on Sapphire Rapids, the fourth of AVX2 on
// Zen 3; those of NEON and of plain Rust are not measured.
#[cfg(target_arch = "x86_64")]
pub(super) const AVX512: Tuning = Tuning::new([320, 7, 16, 16, 6, 2]);
#[cfg(target_arch = "x86_64")]
pub(super) const AVX2: Tuning = Tuning::new([320, 7, 16, 0, 6, 2]);
#[cfg(target_arch = "aarch64")]
pub(super) const NEON: Tuning = Tuning::new([320, 7, 16, 16, 6, 2]);
pub(super) const PORTABLE: Tuning = Tuning::new([320, 7, 16, 16, 6, 2]);
