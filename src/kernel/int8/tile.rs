//! The data of the steps: tiles of the operands, of residues and of sums.

use faer::MatRef;

use crate::base::{Real, widest};

/// Rows of a tile, and of one step of a product.
pub(crate) const STEP: usize = 64;
/// Columns of a tile.
pub(crate) const WIDTH: usize = 16;
/// Columns of a panel: two tiles.
pub(crate) const PANEL: usize = 2 * WIDTH;
/// The most steps of one product: a panel of the right side (32 KiB) stays in the first-level
/// cache, and sums of 1024 products of residues stay below 2^25.
pub(crate) const DEPTH: usize = 16;
/// 16 x 16 entries of C, row by row.
pub(crate) type Quarter<T> = [[T; WIDTH]; WIDTH];
/// 32 x 32 entries of C: the two quarters of the first 16 rows, then those of the last 16.
pub(crate) type PanelBlock<T> = [Quarter<T>; 4];
/// 32 x 32 entries of C, row by row.
pub(crate) type Square<T> = [[T; PANEL]; PANEL];

/// 64 x 16 entries of an operand, row by row; zeros where the operand ends.
#[derive(Clone)]
#[repr(C, align(64))]
pub(crate) struct Tile<T>(pub [[T; WIDTH]; STEP]);

/// Residues of a tile modulo one number, as a right operand: dword `16 r + j` holds column `j` of
/// rows `4 r .. 4 r + 4`.
pub(crate) type Residues = [i8; STEP * WIDTH];
/// One step of a panel: its two tiles.
pub(crate) type Slice = [Residues; 2];

impl<T: Real> Tile<T> {
    /// Creates a tile of zeros.
    pub fn zeros() -> Self {
        Self([[T::ZERO; WIDTH]; STEP])
    }

    /// Reads the tile whose first entry is `a[(row, col)]`; entries beyond the end of `a` are zero.
    pub fn load(&mut self, a: MatRef<'_, T>, row: usize, col: usize) {
        let rows = STEP.min(a.nrows().saturating_sub(row));
        let cols = WIDTH.min(a.ncols().saturating_sub(col));
        if rows < STEP || cols < WIDTH {
            *self = Self::zeros();
        }
        if rows == 0 || cols == 0 {
            return;
        }
        let a = a.submatrix(row, col, rows, cols);
        widest(
            #[inline(always)]
            || self.fill(a),
        );
    }

    /// Reads the entries of `a`, at most as many as a tile has.
    #[inline(always)]
    fn fill(&mut self, a: MatRef<'_, T>) {
        let (rows, cols) = a.shape();
        if a.col_stride() == 1 {
            for (i, line) in self.0[..rows].iter_mut().enumerate() {
                // Prefetches the next tile: its rows are too far apart for the hardware to do so.
                fetch_lines(a.ptr_at(i, 0).wrapping_add(2 * WIDTH), 2);
                // SAFETY: row `i` is below the rows of the view, whose stride along columns is 1,
                // so that `cols` adjacent elements are the row.
                let source = unsafe { std::slice::from_raw_parts(a.ptr_at(i, 0), cols) };
                match source.first_chunk::<WIDTH>() {
                    Some(whole) => *line = *whole,
                    None => line[..cols].copy_from_slice(source),
                }
            }
        } else if a.row_stride() == 1 {
            // SAFETY: `j` is below the columns of the view, whose stride along rows is 1, so that
            // `rows` adjacent elements are the column.
            let column = |j| unsafe { std::slice::from_raw_parts(a.ptr_at(0, j), rows) };
            if rows < STEP || cols < WIDTH {
                for j in 0..cols {
                    for (line, &value) in self.0.iter_mut().zip(column(j)) {
                        line[j] = value;
                    }
                }
                return;
            }
            // SAFETY: the view has at least WIDTH columns of at least STEP adjacent elements, as
            // asked above, and a column of a tile has STEP; an array is aligned as its elements
            // are.
            let columns = std::array::from_fn(|j| unsafe { &*a.ptr_at(0, j).cast() });
            transpose(columns, &mut self.0);
        } else {
            for (i, line) in self.0[..rows].iter_mut().enumerate() {
                for (j, value) in line[..cols].iter_mut().enumerate() {
                    *value = a[(i, j)];
                }
            }
        }
    }
}

/// Adds 128 to every residue, for a left side: `vpdpbusd` multiplies unsigned by signed bytes.
#[inline]
pub(super) fn biased(right: &[Slice], left: &mut [Slice]) {
    let (right, left) = (right.as_flattened().as_flattened(), left.as_flattened_mut());
    for (left, &right) in left.as_flattened_mut().iter_mut().zip(right) {
        *left = right ^ i8::MIN;
    }
}

/// Transposes a matrix of multiples of eight rows and columns.
#[inline(always)]
pub(crate) fn transpose<T: Copy, const M: usize, const N: usize>(
    rows: [&[T; N]; M],
    columns: &mut [[T; M]; N],
) {
    const { assert!(M.is_multiple_of(8) && N.is_multiple_of(8)) };
    for (j, columns) in columns.as_chunks_mut::<8>().0.iter_mut().enumerate() {
        for i in 0..M / 8 {
            let block: [[T; 8]; 8] = std::array::from_fn(|r| rows[8 * i + r].as_chunks::<8>().0[j]);
            for (c, column) in columns.iter_mut().enumerate() {
                column.as_chunks_mut::<8>().0[i] = std::array::from_fn(|r| block[r][c]);
            }
        }
    }
}

/// Prefetches `count` cache lines from `at` on, which may be any address.
#[inline(always)]
pub(crate) fn fetch_lines<T>(at: *const T, count: usize) {
    #[cfg(target_arch = "x86_64")]
    for line in 0..count {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: every x86-64 CPU has the instruction, a hint that is allowed for any address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(at.cast::<i8>().wrapping_add(64 * line)) };
    }
    #[cfg(target_arch = "aarch64")]
    for line in 0..count {
        crate::kernel::prefetch::<false>(at.cast::<u8>().wrapping_add(64 * line));
    }
    #[cfg(not(any(target_arch = "aarch64", target_arch = "x86_64")))]
    let _ = (at, count);
}

/// Powers of two, one per column of W, in two factors, since `2^exponent` may overflow or
/// underflow.
#[derive(Clone)]
#[repr(C, align(64))]
pub(crate) struct Powers<T, const W: usize = WIDTH> {
    pub first: [T; W],
    pub second: [T; W],
}

impl<T: Real, const W: usize> Powers<T, W> {
    /// Computes `2^e` for each exponent, which lies in `-2000..=2000` (f64) or `-250..=250` (f32).
    #[inline(always)]
    pub fn new(exponents: [i32; W]) -> Self {
        let mut powers = Self { first: [T::ZERO; W], second: [T::ZERO; W] };
        for (j, e) in exponents.into_iter().enumerate() {
            powers.first[j] = T::from_f64(power_of_two(e >> 1));
            powers.second[j] = T::from_f64(power_of_two(e - (e >> 1)));
        }
        powers
    }
}

/// Returns `2^e` exactly, for e in `-1022..=1023`.
#[inline(always)]
pub(crate) const fn power_of_two(e: i32) -> f64 {
    f64::from_bits(((e + 1023) as u64) << 52)
}

/// Returns `value 2^exponent`, rounded where it is subnormal.
#[inline(always)]
pub(crate) fn scaled(value: f64, exponent: i32) -> f64 {
    // Two factors, since one may overflow or underflow. Below -1400 every value up to 2^255
    // vanishes.
    let exponent = exponent.clamp(-1400, 2040);
    let (first, second) = (exponent >> 1, exponent - (exponent >> 1));
    value * power_of_two(first) * power_of_two(second)
}

/// Bounds of W columns of at most 64 entries, which add up to bounds of norms in any order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TileNorms<const W: usize = WIDTH> {
    /// The least e such that every entry is below 2^e in magnitude: [`EMPTY`] for zeros,
    /// [`NON_FINITE`] if an entry is NaN or infinite.
    pub exponents: [i32; W],
    /// The sum of the squares of the magnitudes of the entries, each first divided by 2^(e - 20)
    /// and rounded up to an integer. Unspecified for [`NON_FINITE`].
    pub squares: [f64; W],
}

/// Exponent of a column of zeros.
pub(crate) const EMPTY: i32 = i32::MIN;
/// Exponent of a column with a NaN or an infinity.
pub(crate) const NON_FINITE: i32 = i32::MAX;

/// Bits of an entry that norms look at: the sum of the squares of 64 such integers is exact in
/// f64.
pub(crate) const NORM_BITS: i32 = 20;

/// Mask of the bits of an f64 without its sign.
pub(super) const MAGNITUDE: u64 = !0 >> 1;

/// Returns [`TileNorms::exponents`] for the bits of the largest magnitude of each column, and the
/// powers that its entries are multiplied by before they are rounded up.
#[inline(always)]
pub(super) fn norm_exponents<const W: usize>(largest: [u64; W]) -> ([i32; W], Powers<f64, W>) {
    let exponents = largest.map(norm_exponent);
    (exponents, Powers::new(exponents.map(norm_power)))
}

/// Returns the exponent of [`TileNorms`] for the bits of the largest magnitude of a column.
#[inline(always)]
fn norm_exponent(bits: u64) -> i32 {
    const INFINITY: u64 = 0x7ff << 52;
    match bits {
        0 => EMPTY,
        INFINITY.. => NON_FINITE,
        _ if bits >> 52 == 0 => -1074 + (u64::BITS - bits.leading_zeros()) as i32,
        _ => (bits >> 52) as i32 - 1022,
    }
}

/// Returns the power of two that the entries of a column of this exponent are multiplied by before
/// they are rounded up.
#[inline(always)]
fn norm_power(exponent: i32) -> i32 {
    if exponent == EMPTY || exponent == NON_FINITE { 0 } else { NORM_BITS - exponent }
}

/// Computes the bounds of the columns of a tile.
#[inline(always)]
pub(super) fn tile_norms<T: Real>(tile: &Tile<T>) -> TileNorms {
    norms(&tile.0)
}

/// Computes the bounds of columns from at most 64 rows. All sums are exact, so that every
/// instruction set finds the same bounds.
#[inline(always)]
pub(crate) fn norms<T: Real, const W: usize>(rows: &[[T; W]]) -> TileNorms<W> {
    // Signed, since AVX2 compares no unsigned integers.
    let mut largest = [0; W];
    for row in rows {
        for j in 0..W {
            largest[j] = largest[j].max((row[j].to_f64().to_bits() & MAGNITUDE) as i64);
        }
    }
    let (exponents, powers) = norm_exponents(largest.map(|bits| bits as u64));
    let mut squares = [0.0; W];
    for row in rows {
        for j in 0..W {
            let scaled = (row[j].to_f64().abs() * powers.first[j] * powers.second[j]).ceil();
            squares[j] += scaled * scaled;
        }
    }
    TileNorms { exponents, squares }
}
