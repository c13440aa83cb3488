//! Small products, which are over before threads wake up: on the calling thread, without preparations,
//! read in place or packed on the stack.

use std::mem::MaybeUninit;

use super::blocking::{Blocking, DEPTH};
use super::geometry::Area;
use super::in_place::InPlace;
use super::kernel::Kernel;
use super::operands::{Shape, Source};
use super::target::Target;
use super::tile::{Row, Side};
use super::write::LARGEST_TILE;
use crate::base::Real;

/// Scalars that a chunk is packed into.
const PACKED: usize = 6144;

/// Products of scalars of a small product, at most: about 30 microseconds.
const WORK: usize = 1 << 20;

/// Rows of A that are packed at a time, at least, if there are as many: fewer steps are slow.
const LEAST_DEPTH: usize = 32;

/// Rows that fit the stack when both sides are packed.
fn packed_depth<T: Real>(kernel: &dyn Kernel<T>, shape: Shape) -> usize {
    let columns = Blocking::packed_columns(kernel.geometry(), shape);
    (PACKED / columns.max(1)).min(DEPTH)
}

/// Whether [`run_small`] is the way to go: for little work on few columns.
pub(crate) fn is_small<T: Real>(kernel: &dyn Kernel<T>, shape: Shape) -> bool {
    let Shape { depth: m, rows, cols, .. } = shape;
    let work = m.saturating_mul(rows).saturating_mul(cols);
    work <= WORK && packed_depth(kernel, shape) >= m.min(LEAST_DEPTH)
}

/// Memory on a cache line of its own, whatever it holds.
#[repr(align(64))]
struct Aligned<M>(MaybeUninit<M>);

/// One small product.
///
/// # Safety
/// Nobody else uses the matrix that the target comes from.
pub(crate) unsafe fn run_small<T: Real>(
    kernel: &dyn Kernel<T>,
    left: Source<'_, T>,
    right: Source<'_, T>,
    target: Target<T>,
    shape: Shape,
) {
    let geometry = kernel.geometry();
    let Shape { depth: m, rows, cols, same } = shape;
    let mut sums = Aligned::<[T; LARGEST_TILE]>(MaybeUninit::uninit());
    let sums = sums.0.as_mut_ptr().cast::<T>();
    if left.is_plain(m, rows) && right.is_plain(m, cols) {
        let mut targets = [target];
        let steps = if m <= DEPTH { m.max(1) } else { m.div_ceil(m.div_ceil(DEPTH)) };
        for first in (0..m.max(1)).step_by(steps) {
            let product = InPlace {
                steps: steps.min(m - first),
                left: left.in_place(first, geometry),
                right: right.in_place(first, geometry),
                rows: 0..rows,
                cols: 0..cols,
                sums,
                kept: false,
                add: false,
                targets: &targets,
                last: true,
            };
            // SAFETY: the sources have these rows, the sums hold a tile; the caller promises that the
            // target is ours.
            unsafe { kernel.multiply_in_place(&product) };
            targets = [targets[0].accumulating()];
        }
        return;
    }
    let mut memory = Aligned::<[T; PACKED]>(MaybeUninit::uninit());
    let packed = memory.0.as_mut_ptr().cast::<T>();
    // Without rows any number of columns is little work, and none of them fit.
    let most = packed_depth(kernel, shape).max(1);
    let steps = m.div_ceil(m.div_ceil(most).max(1)).max(1);
    let mut target = target;
    for first in (0..m.max(1)).step_by(steps) {
        let steps = steps.min(m - first);
        let panel_stride = steps * geometry.width;
        let side = |start| Side { start, row_stride: geometry.width as isize, panel_stride };
        let own = if same { 0 } else { steps * rows.next_multiple_of(geometry.width) };
        let sides = [side(packed.cast_const()), side(packed.wrapping_add(own).cast_const())];
        let area = |n| Area { rows: first..first + steps, cols: 0..n };
        // SAFETY: the panels of `most` rows fit the memory, and are written before they are read; the
        // caller promises that the target is ours.
        unsafe {
            kernel.pack(&[left], &area(rows), packed, panel_stride);
            if !same {
                kernel.pack(&[right], &area(cols), packed.add(own), panel_stride);
            }
            multiply(kernel, steps, sides, sums, target, shape);
        }
        target = target.accumulating();
    }
}

/// All tiles of a product of these packed sides.
///
/// # Safety
/// The sides have `steps` rows, the sums hold a tile; nobody else uses the matrix that the target comes from.
unsafe fn multiply<T: Real>(
    kernel: &dyn Kernel<T>,
    steps: usize,
    [left, right]: [Side<T>; 2],
    sums: *mut T,
    target: Target<T>,
    shape: Shape,
) {
    let geometry = kernel.geometry();
    for corner in (0..shape.rows).step_by(geometry.rows) {
        let left = left.from_column(corner, geometry.width);
        let wanted = target.wanted_of(corner..corner + geometry.rows);
        let row = Row {
            steps,
            left,
            right,
            next_left: left.start,
            next_right: left.start,
            next_lines: 0,
            panels: 0..shape.cols.div_ceil(geometry.width),
            wanted: wanted.start..wanted.end.min(shape.cols),
            sums,
            kept: false,
            add: false,
            targets: std::slice::from_ref(&target),
            corner,
        };
        // SAFETY: the caller's promise; the sums hold a tile.
        unsafe { kernel.multiply_row(&row) };
    }
}
