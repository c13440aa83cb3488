//! Products of matrices that are read where they are: no packing, nothing beyond their edges is
//! read.
//!
//! Everything here is inlined into functions that enable the instructions of one [`Vectors`].

use std::ops::Range;

use super::target::{Target, wanted_of};
use super::tile::{Side, Tile};
use super::vectors::{Vectors, low_bits};
use super::write::{write, write_registers};

/// A rectangle of a product, whose sides may be read in place.
pub(crate) struct InPlace<'r, T> {
    /// Rows of both sides.
    pub steps: usize,
    /// From column 0 on; packed sides have one panel.
    pub left: Side<T>,
    pub right: Side<T>,
    /// Rows and columns of the product; the first row is the first one of a tile.
    pub rows: Range<usize>,
    pub cols: Range<usize>,
    /// The sums of the tiles, ROWS x WIDTH each: one tile for all when `kept` is false.
    pub sums: *mut T,
    pub kept: bool,
    /// Whether the sums hold those of earlier steps.
    pub add: bool,
    /// The targets of the product.
    pub targets: &'r [Target<T>],
    /// Whether the sums are complete and go to the targets.
    pub last: bool,
}

/// Computes what the targets want of the rectangle, and writes it if it is complete.
///
/// # Safety
/// The sides hold `steps` rows and these columns, the sums a tile per tile (or one); nobody else
/// uses the sums and these entries of the targets.
#[inline(always)]
pub(super) unsafe fn multiply_in_place<V: Vectors, const ROWS: usize, const COUNT: usize>(
    product: &InPlace<'_, V::Scalar>,
) {
    let InPlace { steps, left, right, ref cols, targets, .. } = *product;
    let mut sums = product.sums;
    // What is neither read again nor written twice need not go through memory.
    let direct = match targets {
        [target] if V::MASKED_STORES && product.last && !product.kept && target.is_plain() => {
            Some(target)
        }
        _ => None,
    };
    let mut row = product.rows.start;
    while row < product.rows.end {
        let height = V::ROWS.min(product.rows.end - row);
        let wanted = match targets {
            [target] => target.wanted_of(row..row + height),
            _ => wanted_of(targets, row..row + height),
        };
        let end = wanted.end.min(cols.end);
        let mut col = cols.start.max(wanted.start / V::LANES * V::LANES);
        while col < end {
            let width = V::WIDTH.min(end - col);
            let count = width.div_ceil(V::LANES);
            // SAFETY: the caller's promise; the tile lies inside of the sides.
            unsafe {
                let tail = V::mask(low_bits(width - (count - 1) * V::LANES));
                let tile = Tile {
                    steps,
                    left: left.start.wrapping_add(row),
                    left_stride: left.row_stride,
                    right: right.start.wrapping_add(col),
                    right_stride: right.row_stride,
                    sums,
                    add: product.add,
                };
                part_of_tile::<V, ROWS, COUNT>(tile, (row, col), height, count, tail, direct);
                if product.last && direct.is_none() {
                    for target in targets {
                        write::<V>(sums, target, row, col, height, width);
                    }
                }
                if product.kept {
                    sums = sums.add(V::ROWS * V::WIDTH);
                }
            }
            col += V::WIDTH;
        }
        row += V::ROWS;
    }
}

/// `height` rows and `count` vectors of a tile, of which the last one has the lanes `tail`: nothing
/// else is read. The sums go to the target at `(row, col)`, or to memory.
///
/// # Safety
/// As for [`multiply_in_place`].
#[inline(always)]
unsafe fn part_of_tile<V: Vectors, const ROWS: usize, const COUNT: usize>(
    mut tile: Tile<V::Scalar>,
    (mut row, col): (usize, usize),
    mut height: usize,
    count: usize,
    tail: V::Mask,
    target: Option<&Target<V::Scalar>>,
) {
    macro_rules! part {
        ($rows:expr, $count:expr) => {{
            let sums = tile.multiply::<V, { $rows }, { $count }, true>(tail, &[]);
            match target {
                Some(target) => write_registers::<V, { $rows }, { $count }>(sums, target, row, col),
                None => tile.store::<V, { $rows }, { $count }>(sums),
            }
        }};
    }
    macro_rules! rows {
        ($rows:expr) => {
            match count {
                1 => part!($rows, 1),
                2 if COUNT > 2 => part!($rows, 2),
                _ => part!($rows, COUNT),
            }
        };
    }
    macro_rules! rows_and_on {
        ($rows:expr) => {
            if ROWS > $rows && height >= $rows {
                rows!($rows);
                tile.left = tile.left.add($rows);
                tile.sums = tile.sums.add($rows * V::WIDTH);
                row += $rows;
                height -= $rows;
            }
        };
    }
    // SAFETY: the caller's promise.
    unsafe {
        if height == ROWS {
            return rows!(ROWS);
        }
        rows_and_on!(4);
        rows_and_on!(2);
        if height == 1 {
            rows!(1);
        }
    }
}
