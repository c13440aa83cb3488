//! Plans the pieces of a product, and runs them: a piece packs some panels, or computes a rectangle
//! of tiles.

use std::ops::Range;

use super::blocking::Blocking;
use super::geometry::{Area, Geometry, line_len, piece};
use super::in_place::InPlace;
use super::kernel::Kernel;
use super::operands::KernelProduct;
use super::pack::Panels;
use super::target::{Target, wanted_of};
use super::tile::{Row, Side};
use crate::base::{Latch, Real, SharedPtr};

/// The step that a phase performs on a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Step {
    Pack,
    Multiply,
}

/// A product and its pieces.
pub(super) struct Plan<'a, T> {
    pub product: &'a KernelProduct<'a, T>,
    geometry: Geometry,
    pub blocking: Blocking,
    /// Panels of each side that are packed: none of sides that are read in place, and none of a
    /// right side that is the same as the left one.
    left_panels: usize,
    right_panels: usize,
    /// Panels that one ticket packs.
    group: usize,
    in_place: bool,
    /// Whether packed chunks are written past the caches ([`CACHED_BYTES`]).
    past_caches: bool,
    items: Vec<Item>,
    /// The targets for the chunks after the first one, which add to it.
    later: Vec<Target<T>>,
}

/// A rectangle of the product, in panels.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Item {
    rows: Range<usize>,
    cols: Range<usize>,
    /// Estimate of the entries that some target wants.
    cost: usize,
}

/// Bytes of a packed chunk beyond which the third-level cache of a core does not keep it until it
/// is multiplied: writing it past the caches then saves reading its lines first. Measured on Zen 5.
const CACHED_BYTES: usize = 16 << 20;

/// Largest number of panels that one ticket packs.
const MOST_IN_GROUP: usize = 8;

/// Tickets to aim for in the packing of a chunk, for each thread.
const PACKING_SHARE: usize = 4;

impl<'a, T: Real> Plan<'a, T> {
    /// Plans a product on `threads` threads; `budget` as for [`Blocking::new`].
    pub fn new(
        geometry: Geometry,
        product: &'a KernelProduct<'a, T>,
        budget: usize,
        threads: usize,
    ) -> Self {
        let shape = product.shape;
        let blocking = Blocking::new(geometry, size_of::<T>(), shape, budget, threads);
        let (left_panels, right_panels) =
            (shape.rows.div_ceil(geometry.width), shape.cols.div_ceil(geometry.width));
        let mut items = Vec::new();
        // Consecutive items share their right side, which is then in the cache.
        for j in (0..right_panels).step_by(blocking.panels) {
            for i in (0..left_panels).step_by(blocking.panels) {
                let rows = i..left_panels.min(i + blocking.panels);
                let cols = j..right_panels.min(j + blocking.panels);
                let cost = Self::wanted(geometry, product, &rows, &cols);
                if cost > 0 {
                    items.push(Item { rows, cols, cost });
                }
            }
        }
        // Small items last, so that all threads finish at about the same time.
        items.sort_by_key(|item| std::cmp::Reverse(item.cost));
        let later = product.targets.iter().map(|t| t.accumulating()).collect();
        let in_place = product.in_place(geometry);
        let left_panels = if in_place { 0 } else { left_panels };
        let right_panels = if in_place || shape.same { 0 } else { right_panels };
        let packed_panels = (left_panels + right_panels) * (blocking.chunk / blocking.depth);
        let group = (packed_panels / (PACKING_SHARE * threads)).clamp(1, MOST_IN_GROUP);
        let packed_bytes = blocking.packed_len(geometry, shape) * size_of::<T>();
        Self {
            product,
            geometry,
            blocking,
            left_panels,
            right_panels,
            group,
            in_place,
            past_caches: packed_bytes > CACHED_BYTES,
            items,
            later,
        }
    }

    /// Returns whether any entry of the product is wanted.
    pub fn is_wanted(&self) -> bool {
        !self.items.is_empty()
    }

    /// Returns an estimate of the entries of a rectangle of panels that some target wants; zero if
    /// none does.
    fn wanted(
        geometry: Geometry,
        product: &KernelProduct<'_, T>,
        rows: &Range<usize>,
        cols: &Range<usize>,
    ) -> usize {
        let width = geometry.width;
        let cols = cols.start * width..cols.end * width;
        let of = |t: &Target<T>, panel: usize| {
            let wanted = t.wanted_of(panel * width..(panel + 1) * width);
            wanted.end.min(cols.end).saturating_sub(wanted.start.max(cols.start))
        };
        let most = |panel| product.targets.iter().map(|t| of(t, panel)).max().unwrap_or(0);
        rows.clone().map(|panel| width * most(panel)).sum()
    }

    /// Returns the number of tickets (units of work for one thread) of a step for these rows.
    pub fn tickets(&self, step: Step, rows: &Range<usize>) -> usize {
        match step {
            Step::Multiply => self.items.len(),
            Step::Pack => {
                let [left, right] = self.groups();
                rows.len().div_ceil(self.blocking.depth) * (left + right)
            }
        }
    }

    /// Returns the number of groups of panels that are packed, left and right.
    fn groups(&self) -> [usize; 2] {
        [self.left_panels, self.right_panels].map(|panels| panels.div_ceil(self.group))
    }
}

/// One step of one chunk of a product.
pub(super) struct Phase<'p, 'a, T> {
    pub plan: &'p Plan<'a, T>,
    pub step: Step,
    pub rows: Range<usize>,
    pub packed: SharedPtr<T>,
    pub tickets: Range<usize>,
    pub done: Latch,
}

impl<T: Real> Phase<'_, '_, T> {
    /// Returns the address of scalar `offset` of the packed chunk.
    fn at(&self, offset: usize) -> *mut T {
        self.packed.at(offset as isize)
    }

    /// Returns the rows of block `b`.
    fn block_rows(&self, b: usize) -> Range<usize> {
        piece(&self.rows, b, self.plan.blocking.depth)
    }

    /// Returns the offsets at which the packed panels of block `b` begin, left and right.
    fn packed_starts(&self, b: usize) -> [usize; 2] {
        let Plan { geometry, blocking, left_panels, right_panels, .. } = self.plan;
        let left = b * blocking.depth * (left_panels + right_panels) * geometry.width;
        [left, left + self.block_rows(b).len() * left_panels * geometry.width]
    }

    /// Returns the left and the right side of block `b`.
    fn sides(&self, b: usize) -> [Side<T>; 2] {
        let Plan { geometry, product, in_place, .. } = self.plan;
        let (rows, starts) = (self.block_rows(b), self.packed_starts(b));
        let side = |i: usize| match product.sources(i) {
            [source] if *in_place => source.in_place(rows.start, geometry.width),
            _ => Side {
                start: self.at(starts[i]),
                row_stride: geometry.width as isize,
                panel_stride: rows.len() * geometry.width,
            },
        };
        let left = side(0);
        [left, if product.shape.same { left } else { side(1) }]
    }

    /// Packs the i-th group of panels. Returns 0: packing does not count as progress.
    ///
    /// # Safety
    /// Nobody else uses that part of the memory.
    pub unsafe fn pack(&self, kernel: &dyn Kernel<T>, i: usize) -> f64 {
        let Plan { geometry, product, past_caches, .. } = self.plan;
        let [left_groups, right_groups] = self.plan.groups();
        let (b, group) = (i / (left_groups + right_groups), i % (left_groups + right_groups));
        let (rows, starts) = (self.block_rows(b), self.packed_starts(b));
        let (side, group, width) = if group < left_groups {
            (0, group, product.shape.rows)
        } else {
            (1, group - left_groups, product.shape.cols)
        };
        let panel_stride = rows.len() * geometry.width;
        let start = self.at(starts[side] + group * self.plan.group * panel_stride);
        let out = Panels { past_caches: *past_caches, ..Panels::new(start, panel_stride) };
        let cols = piece(&(0..width), group, self.plan.group * geometry.width);
        // SAFETY: the panels of the group lie in the chunk, which has `packed_len` scalars.
        unsafe { kernel.pack(product.sources(side), &Area { rows, cols }, out) };
        0.0
    }

    /// Computes and writes the i-th item. Returns about how many scalar multiplications its wanted
    /// entries take.
    ///
    /// # Safety
    /// The panels are packed, and nobody else uses the item's entries of the targets.
    pub unsafe fn multiply(&self, kernel: &dyn Kernel<T>, i: usize, sums: &mut [T]) -> f64 {
        let Plan { geometry, blocking, product, items, later, in_place, .. } = self.plan;
        let item = &items[i];
        let targets = if self.rows.start == 0 { &product.targets } else { later };
        let Geometry { rows: height, width, .. } = *geometry;
        let blocks = self.rows.len().div_ceil(blocking.depth).max(1);
        // The sums of all tiles are kept from one block of rows to the next.
        let kept = blocks > 1;
        let row_len = item.cols.len() * height * width;
        let first_row = item.rows.start * width / height;
        let end_row = (item.rows.end * width / height).min(product.shape.rows.div_ceil(height));
        for b in 0..blocks {
            let [left, right] = self.sides(b);
            let steps = self.block_rows(b).len();
            let last = b + 1 == blocks;
            if *in_place {
                let rectangle = InPlace {
                    steps,
                    left,
                    right,
                    rows: item.rows.start * width..(item.rows.end * width).min(product.shape.rows),
                    cols: item.cols.start * width..(item.cols.end * width).min(product.shape.cols),
                    sums: sums.as_mut_ptr(),
                    kept,
                    add: b > 0,
                    targets,
                    last,
                };
                // SAFETY: clause `sides`: the sources of both sides are read in place from the
                // first of `steps` rows on, and the rectangle ends at the product's last row and
                // column; clause `sums`: `sums_len` has a tile for each panel if `kept`. Nobody
                // else uses the entries, by this method's contract.
                unsafe { kernel.multiply_in_place(&rectangle) };
                continue;
            }
            let first_col = item.cols.start * width;
            let next_steps = self.block_rows(b + 1).len();
            let next_right = self.at(self.packed_starts(b + 1)[1] + first_col * next_steps);
            let tiles = (end_row - first_row) * item.cols.len();
            let next_len = item.cols.len() * next_steps * width;
            let next_lines = (next_len / line_len::<T>()).div_ceil(tiles);
            for row in first_row..end_row {
                let corner = row * height;
                let fetched = (row - first_row) * item.cols.len() * next_lines * line_len::<T>();
                let wanted = wanted_of(targets, corner..corner + height);
                let first = if kept { (row - first_row) * row_len } else { 0 };
                let len = if kept { row_len } else { height * width };
                let row = Row {
                    steps,
                    left: left.at_column(corner, width),
                    right: right.at_column(first_col, width),
                    next_left: left.at_column(corner + height, width).start,
                    next_right: next_right.wrapping_add(fetched),
                    next_lines,
                    panels: item.cols.clone(),
                    wanted: wanted.start..wanted.end.min(product.shape.cols),
                    sums: sums[first..first + len].as_mut_ptr(),
                    kept,
                    add: b > 0,
                    targets: if last { targets } else { &[] },
                    corner,
                };
                // SAFETY: clause `sides`: the panels of block `b` are packed, by this method's
                // contract; clause `sums`: the slice has a tile for each panel if `kept`, else one.
                // Nobody else uses the entries, by this method's contract.
                unsafe { kernel.multiply_row(&row) };
            }
        }
        item.cost as f64 * self.rows.len() as f64
    }
}
