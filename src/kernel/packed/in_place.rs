//! Products of matrices that are read in place. Nothing beyond their edges is read. The right side
//! may also be a packed panel.
//!
//! Everything here is inlined into functions that enable the instructions of one [`Vectors`].

use std::ops::Range;

use super::target::{Target, wanted_of};
use super::tile::{Side, Tile};
use super::vectors::{Vectors, low_bits};
use super::write::{write, write_registers};

/// A rectangle of a product, whose sides may be read in place.
pub(crate) struct InPlace<'r, T> {
    /// Rows of both sides to sum over.
    pub steps: usize,
    /// Starts at column 0. A packed side has one panel.
    pub left: Side<T>,
    pub right: Side<T>,
    /// Rows and columns of the product; the first row is the first row of a tile.
    pub rows: Range<usize>,
    pub cols: Range<usize>,
    /// The sums of the tiles, ROWS x WIDTH each: one tile for all when `kept` is false.
    pub sums: *mut T,
    pub kept: bool,
    /// Whether the sums hold the result of earlier steps, to be added to.
    pub add: bool,
    /// The targets of the product.
    pub targets: &'r [Target<T>],
    /// Whether the sums are complete and go to the targets.
    pub last: bool,
}

/// Implements [`Kernel::multiply_in_place`](super::kernel::Kernel::multiply_in_place).
///
/// # Safety
/// As for the method.
#[inline(always)]
pub(super) unsafe fn multiply_in_place<V: Vectors, const ROWS: usize, const COUNT: usize>(
    product: &InPlace<'_, V::Scalar>,
) {
    let InPlace { steps, left, right, ref cols, targets, .. } = *product;
    // `unscale` would read lanes beyond `width`, which the last tile of a row leaves unwritten.
    debug_assert!(targets.iter().all(|target| target.scales().is_none()));
    let mut sums = product.sums;
    // Sums that are not read again and go to one target are written from registers.
    let only = match targets {
        [target] if product.last && !product.kept && target.is_plain() => Some(target),
        _ => None,
    };
    let takes_whole = |target: &Target<_>| target.takes_whole(product.rows.clone(), cols.clone());
    let double = !V::MASK_REGISTERS && cols.len() == V::LANES && only.is_some_and(takes_whole);
    let mut row = product.rows.start;
    while row < product.rows.end {
        let height = match product.rows.end - row {
            // One vector in each of few rows would wait for its sums.
            8.. if double => 8,
            rest => V::ROWS.min(rest),
        };
        let wanted = match targets {
            [target] => target.wanted_of(row..row + height),
            _ => wanted_of(targets, row..row + height),
        };
        let end = wanted.end.min(cols.end);
        let mut col = cols.start.max(wanted.start / V::LANES * V::LANES);
        while col < end {
            let width = match end - col {
                // Two tiles of two vectors each: one of a single vector would wait for its sums.
                rest if !V::MASK_REGISTERS && rest.div_ceil(V::LANES) == V::COUNT + 1 => {
                    V::LANES * V::COUNT.div_ceil(2)
                }
                rest => V::WIDTH.min(rest),
            };
            let count = width.div_ceil(V::LANES);
            let rest = width - (count - 1) * V::LANES;
            let masked = V::MASK_REGISTERS || count == 1 && rest < V::LANES;
            // Not vectors that are shifted back.
            let direct = only.filter(|_| masked || rest == V::LANES).map(|target| {
                let (rows, cols) = (row..row + height, col..col + width);
                (target, !masked && target.takes_whole(rows, cols))
            });
            // SAFETY: clauses `instructions`, `sides` and `sums`: `row + height` and `col + width`
            // are inside the rectangle that both sides have. The last vector has the lanes `tail`
            // if it is masked, else it is shifted back by `shift`, so that nothing beyond `width`
            // is read. `sums` advances by a tile for each one that is kept.
            unsafe {
                let tail = V::mask(low_bits(rest));
                let tile = Tile {
                    steps,
                    left: left.start.wrapping_add(row),
                    left_stride: left.row_stride,
                    right: right.start.wrapping_add(col),
                    right_stride: right.row_stride,
                    shift: if masked { 0 } else { V::LANES - rest },
                    sums,
                    add: product.add,
                };
                let corner = (row, col);
                if V::MASK_REGISTERS {
                    part_of_tile::<V, ROWS, COUNT, true>(tile, corner, height, count, tail, direct);
                } else if masked {
                    part_of_tile::<V, ROWS, 1, true>(tile, corner, height, 1, tail, direct);
                } else {
                    part_of_tile::<V, ROWS, COUNT, false>(
                        tile, corner, height, count, tail, direct,
                    );
                }
                if product.last && direct.is_none() {
                    for target in targets {
                        write::<V>(sums, target, row, col, height, width);
                    }
                }
                if product.kept {
                    sums = sums.add(V::ROWS * V::WIDTH);
                }
            }
            col += width;
        }
        row += height;
    }
}

/// Computes `height` rows and `count` vectors of a tile, of the last vector the lanes `tail` if
/// `MASKED`, and reads nothing else. Writes the sums to the target at `(row, col)`, all of them if
/// it says so and else the wanted ones, or without a target to memory. Tiles of one whole vector
/// and 4 rows may also have 8, with a target: the sums have no room for them.
///
/// # Safety
/// As for [`multiply_in_place`].
#[inline(always)]
unsafe fn part_of_tile<V: Vectors, const ROWS: usize, const COUNT: usize, const MASKED: bool>(
    mut tile: Tile<V::Scalar>,
    (mut row, col): (usize, usize),
    mut height: usize,
    count: usize,
    tail: V::Mask,
    target: Option<(&Target<V::Scalar>, bool)>,
) {
    macro_rules! part {
        ($rows:expr, $count:expr) => {{
            let sums = tile.multiply::<V, { $rows }, { $count }, MASKED>(tail, None);
            match target {
                // With registers for masks, one way is enough.
                Some((target, true)) if !V::MASK_REGISTERS => {
                    write_registers::<V, { $rows }, { $count }, false>(sums, target, row, col)
                }
                Some((target, _)) => {
                    write_registers::<V, { $rows }, { $count }, true>(sums, target, row, col)
                }
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
    // SAFETY: `multiply_in_place` passes `height` rows and `count` vectors that lie inside of the
    // sides; the parts have 8, 4, 2 or 1 rows that follow one another, `height` in all, and their
    // sums lie in the same tile. Eight rows of 4 have a target, so that no sums are stored.
    unsafe {
        if height == ROWS {
            return rows!(ROWS);
        }
        if ROWS == 4 && !MASKED && height == 8 {
            debug_assert!(target.is_some() && count == 1);
            return part!(8, 1);
        }
        rows_and_on!(4);
        rows_and_on!(2);
        if height == 1 {
            rows!(1);
        }
    }
}
