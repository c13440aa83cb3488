//! Small products, which finish before threads wake up: on the calling thread, without a plan, with
//! operands read in place or packed on the stack.

use std::mem::MaybeUninit;

use super::blocking::Blocking;
use super::geometry::{Area, CACHE_LINE, Geometry};
use super::in_place::InPlace;
use super::kernel::Kernel;
use super::operands::{Shape, Source};
use super::pack::Panels;
use super::target::Target;
use super::tile::{Row, Side};
use super::tuning::DEEPEST;
use super::write::LARGEST_TILE;
use crate::base::{Real, data_caches};

/// Scalars of the memory on the stack that a chunk is packed into.
const PACKED: usize = 9216;

/// Columns of the widest panel, f32 with AVX-512.
const WIDEST: usize = 48;

/// Bytes of the largest panel, 60 KiB on the stack: panels of f64 have half of the columns.
const PANEL: usize = DEEPEST * WIDEST * size_of::<f32>();

/// Most scalar multiplications of a small product of plain sources: what one thread computes before
/// another has woken up.
const WORK: usize = 4_000_000;

/// Rows of A whose products take as long as reading and writing C.
const STORE: usize = 16;

/// The same as [`WORK`] if sources must be packed, a few rows at a time: about 30 microseconds.
const PACKED_WORK: usize = 1 << 20;

/// Least number of rows packed at a time, if there are as many: fewer steps are slow.
const LEAST_DEPTH: usize = 32;

/// Returns whether to use [`run_small`]: for little work, and unless all sources are `plain`
/// ([`Source::is_plain`]) for few columns. Without divisions, since every product asks.
#[inline]
pub(crate) fn is_small(shape: Shape, plain: bool) -> bool {
    let Shape { depth: m, rows, cols, same } = shape;
    let work = |m: usize| m.saturating_mul(rows).saturating_mul(cols);
    if plain {
        return work(m.max(STORE)) <= WORK;
    }
    // Padded to whole panels of any kernel.
    let columns = rows.saturating_add(if same { 0 } else { cols }).saturating_add(2 * WIDEST);
    work(m) <= PACKED_WORK && m.min(LEAST_DEPTH).saturating_mul(columns) <= PACKED
}

/// Uninitialized memory, aligned to a cache line.
#[repr(align(64))]
struct Aligned<M>(MaybeUninit<M>);

/// Computes a small product ([`is_small`]), and leaves the target as one that is added to: a copy
/// of it would take a tenth of the time of the smallest products.
///
/// # Safety
/// Nobody else uses the matrix that the target comes from.
#[inline(always)]
pub(crate) unsafe fn run_small<T: Real>(
    kernel: &dyn Kernel<T>,
    left: Source<'_, T>,
    right: Source<'_, T>,
    target: &mut Target<T>,
    shape: Shape,
) {
    // SAFETY: the target is the caller's alone, as each callee asks. `is_plain` has checked for the
    // callees that read in place that both sources have `depth` contiguous rows of `rows` and
    // `cols` entries.
    unsafe {
        let geometry = kernel.geometry();
        if !left.is_plain(shape.depth, shape.rows) || !right.is_plain(shape.depth, shape.cols) {
            multiply_packed(kernel, left, right, target, shape);
        } else if strips_stay(right, shape, geometry) {
            let side = |first, _| right.in_place(first, geometry.width);
            multiply_in_place(kernel, geometry, left, target, shape, shape.cols, side);
        } else {
            multiply_panels(kernel, left, right, target, shape);
        }
    }
}

/// Returns whether a strip of the right side, a cache line of each row, stays in the first-level
/// cache where it lies: rows that are a power of two apart share few of its sets. Where few rows of
/// tiles read a panel, packing pays later or, on the narrowest left side, never. Measured on Zen 4.
#[inline(always)]
fn strips_stay<T: Real>(right: Source<'_, T>, shape: Shape, geometry: Geometry) -> bool {
    /// Rows of tiles.
    const FEW: usize = 8;
    let Shape { depth, rows, same, .. } = shape;
    if rows <= geometry.tuning.in_place * geometry.width {
        return true;
    }
    let stride = right.matrix.row_stride().unsigned_abs() * size_of::<T>();
    let apart = 1 << stride.trailing_zeros().clamp(CACHE_LINE.ilog2(), PAGE.ilog2());
    let share = if same || rows <= FEW * geometry.rows { 1 } else { 2 };
    depth.min(geometry.tuning.depth) * apart <= data_caches()[0] / share
}

/// Bytes after which addresses share a set of a first-level cache.
const PAGE: usize = 4096;

/// Computes a product whose left side is read in place, `wide` columns of C at a time. `right`
/// returns the right side from a first row on, for an area of those rows and columns.
///
/// # Safety
/// As for [`run_small`].
#[inline(always)]
unsafe fn multiply_in_place<T: Real>(
    kernel: &dyn Kernel<T>,
    Geometry { width, tuning, .. }: Geometry,
    left: Source<'_, T>,
    target: &mut Target<T>,
    shape: Shape,
    wide: usize,
    right: impl Fn(usize, Area) -> Side<T>,
) {
    let Shape { depth: m, rows, cols, .. } = shape;
    let mut sums = Aligned::<[T; LARGEST_TILE]>(MaybeUninit::uninit());
    let most = tuning.depth;
    let steps = if m <= most { m.max(1) } else { m.div_ceil(m.div_ceil(most)) };
    // A range with a step would be divided by it.
    let mut first = 0;
    while first < m.max(1) {
        let end = m.min(first + steps);
        let mut col = 0;
        while col < cols {
            let cols = col..cols.min(col + wide);
            let product = InPlace {
                steps: end - first,
                left: left.in_place(first, width),
                right: right(first, Area { rows: first..end, cols: cols.clone() }),
                rows: 0..rows,
                cols,
                sums: sums.0.as_mut_ptr().cast(),
                kept: false,
                add: false,
                targets: std::slice::from_ref(target),
                last: true,
            };
            // SAFETY: `run_small` has checked that the left source has these rows and columns, and
            // `right` returns a side of `end - first` rows of these columns; the sums hold the
            // largest tile, one for all since `kept` is false; nobody else uses the target, by this
            // function's contract.
            unsafe { kernel.multiply_in_place(&product) };
            col += wide;
        }
        target.beta = T::ONE;
        first += steps;
    }
}

/// Computes a product of plain sources panel by panel of the right side, which is packed on the
/// stack: it stays in the first-level cache, whatever its rows are apart. Not inlined, so that
/// other products do not reserve its memory.
///
/// # Safety
/// As for [`run_small`].
#[inline(never)]
unsafe fn multiply_panels<T: Real>(
    kernel: &dyn Kernel<T>,
    left: Source<'_, T>,
    right: Source<'_, T>,
    target: &mut Target<T>,
    shape: Shape,
) {
    let geometry = kernel.geometry();
    let width = geometry.width;
    debug_assert!(DEEPEST * width * size_of::<T>() <= PANEL);
    let mut memory = Aligned::<[u8; PANEL]>(MaybeUninit::uninit());
    let packed = memory.0.as_mut_ptr().cast::<T>();
    let side = |_, area: Area| {
        // SAFETY: a panel of at most DEEPEST rows fits the memory, which is aligned.
        unsafe { kernel.pack(&[right], &area, Panels::new(packed, 0)) };
        // Where column 0 would be.
        let start = packed.wrapping_sub(area.cols.start).cast_const();
        Side { start, row_stride: width as isize, panel_stride: width }
    };
    // SAFETY: `run_small` has checked the left source; `side` packs the rows and the columns that
    // it is asked for, one panel since they are at most `width`; nobody else uses the target, by
    // this function's contract.
    unsafe { multiply_in_place(kernel, geometry, left, target, shape, width, side) };
}

/// Computes a product of matrices that are packed on the stack. Not inlined, so that other products
/// do not reserve its memory.
///
/// # Safety
/// As for [`run_small`].
#[inline(never)]
unsafe fn multiply_packed<T: Real>(
    kernel: &dyn Kernel<T>,
    left: Source<'_, T>,
    right: Source<'_, T>,
    target: &mut Target<T>,
    shape: Shape,
) {
    let Geometry { rows: height, width, tuning, .. } = kernel.geometry();
    let Shape { depth: m, rows, cols, same } = shape;
    let mut memory = Aligned::<[T; PACKED]>(MaybeUninit::uninit());
    let packed = memory.0.as_mut_ptr().cast::<T>();
    let mut sums = Aligned::<[T; LARGEST_TILE]>(MaybeUninit::uninit());
    // Rows that fit the memory. A product without rows is small whatever its columns, so that not
    // even one row may fit.
    let columns = Blocking::packed_columns(kernel.geometry(), shape);
    let most = (PACKED / columns.max(1)).clamp(1, tuning.depth);
    let steps = m.div_ceil(m.div_ceil(most).max(1)).max(1);
    for first in (0..m.max(1)).step_by(steps) {
        let steps = steps.min(m - first);
        let panel_stride = steps * width;
        let own = if same { 0 } else { steps * rows.next_multiple_of(width) };
        let side = |offset: usize| Side {
            start: packed.wrapping_add(offset).cast_const(),
            row_stride: width as isize,
            panel_stride,
        };
        let area = |columns| Area { rows: first..first + steps, cols: 0..columns };
        // SAFETY: the panels of `most` rows fit the memory.
        unsafe {
            kernel.pack(&[left], &area(rows), Panels::new(packed, panel_stride));
            if !same {
                let out = Panels::new(packed.wrapping_add(own), panel_stride);
                kernel.pack(&[right], &area(cols), out);
            }
        }
        for corner in (0..rows).step_by(height) {
            let left = side(0).at_column(corner, width);
            let wanted = target.wanted_of(corner..corner + height);
            let row = Row {
                steps,
                left,
                right: side(own),
                next_left: left.start,
                next_right: left.start,
                next_lines: 0,
                panels: 0..cols.div_ceil(width),
                wanted: wanted.start..wanted.end.min(cols),
                sums: sums.0.as_mut_ptr().cast(),
                kept: false,
                add: false,
                targets: std::slice::from_ref(target),
                corner,
            };
            // SAFETY: `pack` has written whole panels of `steps` rows of both sides; the sums hold
            // the largest tile, one for all since `kept` is false; nobody else uses the target, by
            // this function's contract.
            unsafe { kernel.multiply_row(&row) };
        }
        target.beta = T::ONE;
    }
}
