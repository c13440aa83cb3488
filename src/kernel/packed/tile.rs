//! Computes tiles of products: the innermost loop.
//!
//! Everything here is inlined into functions that enable the instructions of one [`Vectors`].

use std::ops::Range;

use super::geometry::line_len;
use super::target::Target;
use super::vectors::{Vectors, low_bits};
use super::write::{write, write_registers};
use crate::base::Real;

/// One side of a product as tiles read it: panels of WIDTH columns. Packed panels are padded with
/// zeros; the last panel of a matrix that is read in place may be narrower.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Side<T> {
    pub start: *const T,
    /// Scalars from one row to the next.
    pub row_stride: isize,
    /// Scalars from one panel to the next.
    pub panel_stride: usize,
}

impl<T> Side<T> {
    /// Returns the same side from column `col` on, in panels of `width` columns.
    pub fn at_column(self, col: usize, width: usize) -> Self {
        // Panels that are read in place are adjacent, which saves a division.
        let offset = match self.panel_stride == width {
            true => col,
            false => col / width * self.panel_stride + col % width,
        };
        Self { start: self.start.wrapping_add(offset), ..self }
    }
}

/// Most targets whose entries are prefetched while a tile is computed; a tile lacks steps for more.
const MOST_FETCHED: usize = 4;

/// A row of tiles: ROWS columns of the left side times consecutive panels of the right side.
pub(crate) struct Row<'r, T> {
    /// Rows of both sides to sum over.
    pub steps: usize,
    /// Starts at the column for the first row of the tiles.
    pub left: Side<T>,
    /// Starts at the first of `panels`.
    pub right: Side<T>,
    /// The left side of the next row of tiles, to be prefetched.
    pub next_left: *const T,
    /// A part of the right side of the next block of rows, to be prefetched: `next_lines` cache
    /// lines per tile.
    pub next_right: *const T,
    pub next_lines: usize,
    pub panels: Range<usize>,
    /// Columns of the product that some target wants of these rows.
    pub wanted: Range<usize>,
    /// The sums of the tiles, ROWS x WIDTH each: one tile for all when `kept` is false.
    pub sums: *mut T,
    pub kept: bool,
    /// Whether the sums hold the result of earlier steps, to be added to.
    pub add: bool,
    /// The targets of the sums; empty until the sums are complete.
    pub targets: &'r [Target<T>],
    /// The row of the product where the tiles begin.
    pub corner: usize,
}

/// Implements [`Kernel::multiply_row`](super::kernel::Kernel::multiply_row).
///
/// # Safety
/// As for the method.
#[inline(always)]
pub(super) unsafe fn multiply_row<V: Vectors, const ROWS: usize, const COUNT: usize>(
    row: &Row<'_, V::Scalar>,
) {
    // Rows of the next left side that each tile prefetches.
    let share = row.steps.div_ceil(row.panels.len().max(1));
    for (j, panel) in row.panels.clone().enumerate() {
        let col = panel * V::WIDTH;
        if col >= row.wanted.end || col + V::WIDTH <= row.wanted.start {
            continue;
        }
        // The vectors of the panel that some target wants.
        let first = row.wanted.start.saturating_sub(col) / V::LANES;
        let rest = (row.wanted.end - col).min(V::WIDTH);
        let count = rest.div_ceil(V::LANES) - first;
        // SAFETY: clauses `instructions`, `sides` and `sums`: panel j of the right side and the
        // left side have `steps` rows of WIDTH scalars, the sums a tile for each panel if `kept`,
        // else one. `first + count` vectors are at most COUNT, so all stay inside a panel and a
        // tile. `write_registers` without masks gets targets that take the whole tile only.
        unsafe {
            let sums = row.sums.add(if row.kept { j * V::ROWS * V::WIDTH } else { 0 });
            let tile = Tile {
                steps: row.steps,
                left: row.left.start,
                // Constants, although the sides know them: addresses become offsets.
                left_stride: V::WIDTH as isize,
                right: row.right.start.add(j * row.right.panel_stride + first * V::LANES),
                right_stride: V::WIDTH as isize,
                shift: 0,
                sums: sums.add(first * V::LANES),
                add: row.add,
            };
            let left = row.next_left.wrapping_add(j * share * V::WIDTH);
            let right = match row.next_lines {
                0 => left,
                lines => row.next_right.wrapping_add(j * lines * const { line_len::<V::Scalar>() }),
            };
            let ahead =
                Some(Ahead { targets: row.targets, corner: (row.corner, col), left, right });
            let all = V::mask(low_bits(V::LANES));
            match count {
                1 => tile.store::<V, ROWS, 1>(tile.multiply::<V, ROWS, 1, false>(all, ahead)),
                2 if COUNT > 2 => {
                    tile.store::<V, ROWS, 2>(tile.multiply::<V, ROWS, 2, false>(all, ahead));
                }
                _ => {
                    let sums = tile.multiply::<V, ROWS, COUNT, false>(all, ahead);
                    let whole = |target: &Target<_>| {
                        let rows = row.corner..row.corner + V::ROWS;
                        target.takes_whole(rows, col..col + V::WIDTH)
                    };
                    if !row.targets.is_empty() && row.targets.iter().all(whole) {
                        for target in row.targets {
                            write_registers::<V, ROWS, COUNT, false>(sums, target, row.corner, col);
                        }
                        continue;
                    }
                    tile.store::<V, ROWS, COUNT>(sums);
                }
            }
            for target in row.targets {
                write::<V>(sums, target, row.corner, col, V::ROWS, V::WIDTH);
            }
        }
    }
}

/// The operands and the sums of one tile.
#[derive(Clone, Copy)]
pub(super) struct Tile<T> {
    pub steps: usize,
    pub left: *const T,
    pub left_stride: isize,
    pub right: *const T,
    pub right_stride: isize,
    /// Scalars by which the last of several vectors of a row begins earlier, to end with the
    /// columns: its first sums are also those of the vector before.
    pub shift: usize,
    /// ROWS x WIDTH, row by row.
    pub sums: *mut T,
    /// Whether the sums hold the result of earlier steps, to be added to.
    pub add: bool,
}

/// Steps from one prefetch of [`Ahead`] to the next.
const PACE: usize = 4;

/// Memory that is prefetched while a tile is computed: the entries of targets, and from `left` and
/// `right` on, a row and a cache line at a time.
#[derive(Clone, Copy)]
pub(super) struct Ahead<'a, T> {
    targets: &'a [Target<T>],
    /// The first entry of the tile.
    corner: (usize, usize),
    left: *const T,
    right: *const T,
}

impl<T: Real> Tile<T> {
    /// Computes `left^T right`, ROWS columns of the left side times N vectors of the right side, in
    /// registers. Meanwhile prefetches `ahead`, which packed sides have, a little every few steps,
    /// since one burst would delay the operands. The last vector has the lanes `tail` if `MASKED`,
    /// else all. Returns the product, plus the sums of earlier steps if `self.add`.
    ///
    /// # Safety
    /// Both sides hold `steps` rows, and the sums, if they are added, ROWS rows of WIDTH.
    #[inline(always)]
    pub unsafe fn multiply<V, const ROWS: usize, const N: usize, const MASKED: bool>(
        mut self,
        tail: V::Mask,
        ahead: Option<Ahead<'_, T>>,
    ) -> [[V::Vector; N]; ROWS]
    where
        V: Vectors<Scalar = T>,
    {
        // SAFETY: clauses `instructions` and `sides`: as many steps are taken as `steps`, since
        // ROWS * PACE, PACE and 1 at a time are subtracted from `rest`. Prefetches take any
        // address. `complete` reads the sums under the same contract.
        unsafe {
            let mut tile = [[V::splat(T::ZERO); N]; ROWS];
            let mut rest = self.steps;
            // Loops of few different lengths: each end that a CPU does not predict costs a
            // hundredth of a tile.
            if let Some(ahead) = ahead {
                let lines = const { V::WIDTH.div_ceil(line_len::<T>()) + 1 };
                for target in ahead.targets.iter().take(MOST_FETCHED) {
                    if target.col_stride != 1 || rest < ROWS * PACE {
                        break;
                    }
                    let mut line = target.at(ahead.corner.0, ahead.corner.1).cast_const();
                    for _ in 0..ROWS {
                        for i in 0..lines {
                            V::prefetch_far(line.wrapping_add(i * const { line_len::<T>() }));
                        }
                        line = line.wrapping_offset(target.row_stride);
                        self.packed_steps::<V, ROWS, N, MASKED>(tail, &mut tile);
                    }
                    rest -= ROWS * PACE;
                }
                let (mut left, mut right) = (ahead.left, ahead.right);
                for _ in 0..rest / PACE {
                    V::prefetch_far(left);
                    V::prefetch_far(right);
                    left = left.wrapping_add(V::WIDTH);
                    right = right.wrapping_add(const { line_len::<T>() });
                    self.packed_steps::<V, ROWS, N, MASKED>(tail, &mut tile);
                }
                rest %= PACE;
            }
            // Of few rows all prefetches would be beyond the end.
            let fetched = if self.steps > V::TUNING.ahead { rest } else { 0 };
            for _ in 0..fetched {
                let right =
                    self.right.wrapping_offset(V::TUNING.ahead as isize * self.right_stride);
                for i in 0..(N * V::LANES).div_ceil(const { line_len::<T>() }) {
                    V::prefetch(right.wrapping_add(i * const { line_len::<T>() }));
                }
                V::prefetch(self.left.wrapping_offset(V::TUNING.ahead as isize * self.left_stride));
                self.step::<V, ROWS, N, MASKED>(tail, &mut tile);
            }
            for _ in fetched..rest {
                self.step::<V, ROWS, N, MASKED>(tail, &mut tile);
            }
            self.complete::<V, ROWS, N>(tile)
        }
    }

    /// Performs PACE steps on packed sides. Each cache line of the right side is prefetched once.
    ///
    /// The prefetches also keep loads in order. A tile of AVX2 needs all registers: without a
    /// prefetch, LLVM loads the next scalar of the left side early and moves a sum to memory for
    /// it, and the loop takes twice the time.
    ///
    /// # Safety
    /// Both sides hold these rows.
    #[inline(always)]
    unsafe fn packed_steps<V, const ROWS: usize, const N: usize, const MASKED: bool>(
        &mut self,
        tail: V::Mask,
        tile: &mut [[V::Vector; N]; ROWS],
    ) where
        V: Vectors<Scalar = T>,
    {
        let line = const { line_len::<T>() };
        let ahead = self.right.wrapping_add(V::TUNING.ahead * V::WIDTH);
        for k in 0..PACE {
            for i in (k * V::WIDTH).div_ceil(line)..((k + 1) * V::WIDTH).div_ceil(line) {
                V::prefetch(ahead.wrapping_add(i * line));
            }
            if V::TUNING.left_ahead > 0 {
                let rows = V::TUNING.left_ahead as isize;
                V::prefetch(self.left.wrapping_offset(rows * self.left_stride));
            }
            // SAFETY: `multiply` has PACE more rows to do when it calls this, and `step` advances
            // by one.
            unsafe { self.step::<V, ROWS, N, MASKED>(tail, tile) };
        }
    }

    /// Adds the products of one row of both sides to the tile and advances to the next row.
    ///
    /// # Safety
    /// Both sides hold this row.
    #[inline(always)]
    unsafe fn step<V, const ROWS: usize, const N: usize, const MASKED: bool>(
        &mut self,
        tail: V::Mask,
        tile: &mut [[V::Vector; N]; ROWS],
    ) where
        V: Vectors<Scalar = T>,
    {
        // SAFETY: clauses `instructions` and `sides`: this row has N vectors on the right, the last
        // one less the lanes that are not in `tail` or shifted back by `shift`, and ROWS scalars on
        // the left. The addresses of the next row are only computed, without a bound.
        unsafe {
            let mut r = [V::splat(T::ZERO); N];
            for j in 0..N {
                let at = self.right.add(self.column::<V, N>(j));
                r[j] = if MASKED && j + 1 == N { V::load_masked(at, tail) } else { V::load(at) };
            }
            V::add_products(self.left, r, tile);
            self.left = self.left.wrapping_offset(self.left_stride);
            self.right = self.right.wrapping_offset(self.right_stride);
        }
    }

    /// Returns the first column of vector `j` of N.
    #[inline(always)]
    fn column<V: Vectors, const N: usize>(&self, j: usize) -> usize {
        j * V::LANES - if j + 1 == N { self.shift } else { 0 }
    }

    /// Adds the sums of earlier steps to the tile, if `self.add`. The tile began at zero, so that
    /// rounding errors are those of short sums.
    ///
    /// # Safety
    /// The sums hold ROWS rows of WIDTH.
    #[inline(always)]
    unsafe fn complete<V, const ROWS: usize, const N: usize>(
        &self,
        mut tile: [[V::Vector; N]; ROWS],
    ) -> [[V::Vector; N]; ROWS]
    where
        V: Vectors<Scalar = T>,
    {
        if self.add {
            for i in 0..ROWS {
                for j in 0..N {
                    // SAFETY: clause `sums`: row i is below ROWS and vector j ends in its WIDTH
                    // scalars, which earlier steps have stored.
                    unsafe {
                        let at = i * V::WIDTH + self.column::<V, N>(j);
                        let earlier = V::load(self.sums.add(at));
                        tile[i][j] = V::add(earlier, tile[i][j]);
                    }
                }
            }
        }
        tile
    }

    /// Stores the tile as `sums`.
    ///
    /// # Safety
    /// The sums have room for ROWS rows of WIDTH.
    #[inline(always)]
    pub unsafe fn store<V, const ROWS: usize, const N: usize>(&self, tile: [[V::Vector; N]; ROWS])
    where
        V: Vectors<Scalar = T>,
    {
        for i in 0..ROWS {
            for j in 0..N {
                let at = i * V::WIDTH + self.column::<V, N>(j);
                // SAFETY: clause `sums`: row i is below ROWS and vector j ends in its WIDTH
                // scalars.
                unsafe { V::store(self.sums.add(at), tile[i][j]) };
            }
        }
    }
}
