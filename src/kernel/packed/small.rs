//! Products that are over before threads wake up: on the calling thread, packed on the stack.

use std::mem::MaybeUninit;

use super::blocking::DEPTH;
use super::operands::{Shape, Source, Target};
use super::{Area, Blocking, Kernel, Row};
use crate::base::Real;

/// Scalars that a chunk is packed into, and those of the largest tile.
const PACKED: usize = 6144;
const TILE: usize = 8 * 48;

/// Rows that fit the stack.
fn depth<T: Real>(kernel: &dyn Kernel<T>, shape: Shape) -> usize {
    let columns = Blocking::packed_columns(kernel.geometry(), shape);
    (PACKED / columns.max(1)).min(DEPTH)
}

/// Whether [`run_small`] is the way to go: for little work on few columns.
pub(crate) fn is_small<T: Real>(kernel: &dyn Kernel<T>, shape: Shape) -> bool {
    const WORK: usize = 1 << 20;
    let Shape { depth: m, rows, cols, .. } = shape;
    let work = m.saturating_mul(rows).saturating_mul(cols);
    work <= WORK && depth(kernel, shape) >= m.min(32)
}

#[repr(align(64))]
struct Memory<T>(MaybeUninit<[T; PACKED + TILE]>);

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
    let mut memory = Memory::<T>(MaybeUninit::uninit());
    let packed = memory.0.as_mut_ptr().cast::<T>();
    let sums = packed.wrapping_add(PACKED);
    assert!(geometry.rows * geometry.width <= TILE);
    // Without rows any number of columns is little work, and none of them fit.
    let most = depth(kernel, shape).max(1);
    let steps = m.div_ceil(m.div_ceil(most).max(1)).max(1);
    let mut targets = [target];
    for first in (0..m.max(1)).step_by(steps) {
        let steps = steps.min(m - first);
        let own = if same { 0 } else { steps * rows.next_multiple_of(geometry.width) };
        let area = |n| Area { rows: first..first + steps, cols: 0..n };
        // SAFETY: the panels of `most` rows fit the memory, and are written before they are read.
        unsafe {
            let stride = steps * geometry.width;
            kernel.pack(&[left], &area(rows), packed, stride);
            if !same {
                kernel.pack(&[right], &area(cols), packed.add(own), stride);
            }
        }
        for row in 0..rows.div_ceil(geometry.rows) {
            let corner = row * geometry.rows;
            let left = packed.wrapping_add(
                corner / geometry.width * steps * geometry.width + corner % geometry.width,
            );
            let wanted = target.wanted_of(corner..corner + geometry.rows);
            let row = Row {
                steps,
                left,
                next_left: left,
                right: packed.wrapping_add(own),
                next_right: left,
                next_lines: 0,
                panels: 0..cols.div_ceil(geometry.width),
                wanted: wanted.start..wanted.end.min(cols),
                sums,
                kept: false,
                add: false,
                targets: &targets,
                corner,
            };
            // SAFETY: as above; the caller promises that the target is ours.
            unsafe { kernel.multiply_row(&row) };
        }
        targets = [target.accumulating()];
    }
}
