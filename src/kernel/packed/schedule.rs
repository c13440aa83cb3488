//! Runs products one after another, each by all threads: chunk by chunk of the rows, pack, then
//! multiply. Threads share what is packed.
//!
//! Pieces of work have numbers, tickets; a thread takes the next one, and waits when it needs pieces
//! that are not done. Those are in the hands of threads that run, so that nothing hangs however few
//! of the threads asked for exist. There are two buffers for packed chunks: who finds no more to
//! multiply goes on and packs the next chunk, while others still work on this one.

use std::ops::{ControlFlow, Range};

use super::generic::line_len;
use super::operands::{Product, Shape, Source, Target};
use super::{Area, Blocking, Geometry, Kernel, Row, piece};
use crate::base::{Arena, Latch, Par, Real, SharedPtr, Tracker, tickets};

/// Products and how to run them.
pub(crate) struct Job<'a, T: 'static> {
    pub kernel: &'static dyn Kernel<T>,
    pub products: &'a [Product<'a, T>],
    /// Scalars that packed operands may take, if that is possible.
    pub budget: usize,
    /// Told of work done (products of scalars).
    pub progress: &'a Tracker<'a>,
}

/// Scalars of scratch that [`run`] needs for products of these shapes on `lanes` threads.
pub(crate) fn scratch_len<T: Real>(
    geometry: Geometry,
    shapes: impl Iterator<Item = Shape>,
    budget: usize,
    lanes: usize,
) -> usize {
    let (mut packed, mut sums, mut chunks) = (0, 0, 0);
    for shape in shapes {
        let blocking = Blocking::new(geometry, size_of::<T>(), shape, budget);
        packed = packed.max(blocking.packed_len(geometry, shape));
        sums = sums.max(blocking.sums_len(geometry));
        chunks += blocking.chunks(shape);
    }
    chunks.min(BUFFERS) * (packed + line_len::<T>()) + lanes * (sums + line_len::<T>())
}

/// Chunks in memory at a time.
const BUFFERS: usize = 2;

/// The next `len` scalars on a cache line of their own.
fn aligned<'a, T: Real>(arena: &mut Arena<'a, T>, len: usize) -> &'a mut [T] {
    let piece = arena.take(len + line_len::<T>());
    let skipped = piece.as_ptr().align_offset(64).min(line_len::<T>());
    &mut piece[skipped..skipped + len]
}

/// Runs the products in order, on `par` threads.
///
/// Entries of the targets belong to the caller's borrow ([`super::Destination`]); the result does not
/// depend on the number of threads.
///
/// # Safety
/// Nobody else uses the matrices that the targets come from.
pub(crate) unsafe fn run<T: Real>(job: &Job<'_, T>, par: Par, scratch: &mut [T]) {
    let geometry = job.kernel.geometry();
    let plans: Vec<_> = job.products.iter().map(|p| Plan::new(geometry, p, job.budget)).collect();
    let len = |f: &dyn Fn(&Plan<'_, T>) -> usize| plans.iter().map(f).max().unwrap_or(0);
    let packed_len = len(&|p| p.blocking.packed_len(geometry, p.product.shape));
    let sums_len = len(&|p| p.blocking.sums_len(geometry));
    let chunks: usize = plans.iter().map(|p| p.blocking.chunks(p.product.shape)).sum();
    let mut arena = Arena::new(scratch);
    let buffers: Vec<_> = (0..chunks.min(BUFFERS))
        .map(|_| SharedPtr::new(aligned(&mut arena, packed_len).as_mut_ptr()))
        .collect();
    let mut phases = Vec::with_capacity(2 * chunks);
    let mut tickets_in_all = 0;
    for plan in &plans {
        let depth = plan.product.shape.depth;
        for first in (0..depth.max(1)).step_by(plan.blocking.chunk) {
            let rows = first..depth.min(first + plan.blocking.chunk);
            let packed = buffers[phases.len() / 2 % BUFFERS];
            for step in [Step::Pack, Step::Multiply] {
                let start = tickets_in_all;
                tickets_in_all += plan.tickets(step, &rows);
                let (rows, tickets) = (rows.clone(), start..tickets_in_all);
                let done = Latch::new(tickets.len());
                phases.push(Phase { plan, step, rows, packed, tickets, done });
            }
        }
    }
    let workers = par.at_most(tickets_in_all).threads();
    let mut workers: Vec<_> = (0..workers).map(|_| (0, aligned(&mut arena, sums_len))).collect();
    tickets(&mut workers, tickets_in_all, |(p, sums), ticket| {
        while ticket >= phases[*p].tickets.end {
            *p += 1;
        }
        let phase = &phases[*p];
        for needed in needed_by(*p) {
            phases[needed].done.wait();
        }
        let work = {
            // Counted even if it panics: the others would wait for ever.
            let _done = Finally(|| phase.done.count_down());
            let i = ticket - phase.tickets.start;
            if job.progress.state().is_break() {
                // All tickets are handed out, for some wait for others.
                return ControlFlow::Continue(());
            }
            // SAFETY: what this phase needs is done, each ticket is handed out once, and pieces of a
            // phase write disjoint memory: panels, or entries of C.
            unsafe {
                match phase.step {
                    Step::Pack => phase.pack(job.kernel, i),
                    Step::Multiply => phase.multiply(job.kernel, i, sums),
                }
            }
        };
        if work > 0.0 {
            // The next tickets look at the state; nobody waits for this one any more.
            let _ = job.progress.add(work);
        }
        ControlFlow::Continue(())
    });
}

/// The phases that have to be done before phase `p`: packing, the one that read the buffer before;
/// multiplying, the packing of the chunk, and the one before, which writes the same entries of C.
fn needed_by(p: usize) -> impl Iterator<Item = usize> {
    let back: &[usize] = if p.is_multiple_of(2) { &[2 * BUFFERS - 1] } else { &[1, 2] };
    back.iter().filter_map(move |back| p.checked_sub(*back))
}

/// Calls its function when dropped.
struct Finally<F: Fn()>(F);

impl<F: Fn()> Drop for Finally<F> {
    fn drop(&mut self) {
        (self.0)();
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    Pack,
    Multiply,
}

/// A product and its pieces.
struct Plan<'a, T> {
    product: &'a Product<'a, T>,
    geometry: Geometry,
    blocking: Blocking,
    /// Panels of each side.
    left_panels: usize,
    right_panels: usize,
    items: Vec<Item>,
    /// The targets after the first chunk.
    later: Vec<Target<T>>,
}

/// A rectangle of the product, in panels.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Item {
    rows: Range<usize>,
    cols: Range<usize>,
    /// Entries that somebody wants, roughly.
    cost: usize,
}

/// Panels of a piece of packing.
const GROUP: usize = 8;

impl<'a, T: Real> Plan<'a, T> {
    fn new(geometry: Geometry, product: &'a Product<'a, T>, budget: usize) -> Self {
        let shape = product.shape;
        let blocking = Blocking::new(geometry, size_of::<T>(), shape, budget);
        let (left_panels, right_panels) =
            (shape.rows.div_ceil(geometry.width), shape.cols.div_ceil(geometry.width));
        let mut items = Vec::new();
        // Items in a row share their right side, which then is in the cache already.
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
        // The smaller ones last, to fill the gaps at the end.
        items.sort_by_key(|item| std::cmp::Reverse(item.cost));
        let later = product.targets.iter().map(|t| t.accumulating()).collect();
        Self { product, geometry, blocking, left_panels, right_panels, items, later }
    }

    /// Entries of a rectangle of panels that a target wants.
    fn wanted(
        geometry: Geometry,
        product: &Product<'_, T>,
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

    fn tickets(&self, step: Step, rows: &Range<usize>) -> usize {
        match step {
            Step::Multiply => self.items.len(),
            Step::Pack => {
                let (left, right) = self.groups();
                rows.len().div_ceil(self.blocking.depth) * (left + right)
            }
        }
    }

    /// Groups of panels of each side that are packed.
    fn groups(&self) -> (usize, usize) {
        let right = if self.product.shape.same { 0 } else { self.right_panels };
        (self.left_panels.div_ceil(GROUP), right.div_ceil(GROUP))
    }
}

/// One step of one chunk of a product.
struct Phase<'p, 'a, T> {
    plan: &'p Plan<'a, T>,
    step: Step,
    rows: Range<usize>,
    packed: SharedPtr<T>,
    tickets: Range<usize>,
    done: Latch,
}

impl<T: Real> Phase<'_, '_, T> {
    /// An address in the packed chunk.
    fn at(&self, offset: usize) -> *mut T {
        self.packed.at(offset as isize)
    }

    /// Where the panels of block `b` begin, left and right, and its rows.
    fn block(&self, b: usize) -> (usize, usize, Range<usize>) {
        let Plan { geometry, blocking, left_panels, product, .. } = self.plan;
        let columns = Blocking::packed_columns(*geometry, product.shape);
        let rows = piece(&self.rows, b, blocking.depth);
        let left = b * blocking.depth * columns;
        let right = if product.shape.same {
            left
        } else {
            left + rows.len() * left_panels * geometry.width
        };
        (left, right, rows)
    }

    /// Packs the i-th group of panels.
    ///
    /// # Safety
    /// Nobody else uses that part of the memory.
    unsafe fn pack(&self, kernel: &dyn Kernel<T>, i: usize) -> f64 {
        let Plan { geometry, product, .. } = self.plan;
        let (left_groups, right_groups) = self.plan.groups();
        let (b, group) = (i / (left_groups + right_groups), i % (left_groups + right_groups));
        let (left, right, rows) = self.block(b);
        let (sources, start, group, width): (&[Source<'_, T>], _, _, _) = if group < left_groups {
            (&product.left, left, group, product.shape.rows)
        } else {
            (&product.right, right, group - left_groups, product.shape.cols)
        };
        let panel_stride = rows.len() * geometry.width;
        let out = self.at(start + group * GROUP * panel_stride);
        let cols = piece(&(0..width), group, GROUP * geometry.width);
        // SAFETY: the group's panels lie in the memory, which `packed_len` has measured.
        unsafe { kernel.pack(sources, &Area { rows, cols }, out, panel_stride) };
        0.0
    }

    /// Computes and writes the i-th item; how many products of scalars that is.
    ///
    /// # Safety
    /// The panels are packed, and nobody else uses the item's entries of the targets.
    unsafe fn multiply(&self, kernel: &dyn Kernel<T>, i: usize, sums: &mut [T]) -> f64 {
        let Plan { geometry, blocking, product, items, later, .. } = self.plan;
        let item = &items[i];
        let targets = if self.rows.start == 0 { &product.targets } else { later };
        let Geometry { rows: height, width, .. } = *geometry;
        let blocks = self.rows.len().div_ceil(blocking.depth).max(1);
        // Between blocks of rows the sums of all tiles have to be kept.
        let kept = blocks > 1;
        let row_len = item.cols.len() * height * width;
        let first_row = item.rows.start * width / height;
        let end_row = (item.rows.end * width / height).min(product.shape.rows.div_ceil(height));
        for b in 0..blocks {
            let (left, right, rows) = self.block(b);
            let steps = rows.len();
            let last = b + 1 == blocks;
            let left_of = |row: usize| {
                let corner = row * height;
                self.at(left + corner / width * steps * width + corner % width)
            };
            let (_, next_right, next_rows) = self.block(b + 1);
            let next_right = next_right + item.cols.start * next_rows.len() * width;
            let next_len = item.cols.len() * next_rows.len() * width;
            let tiles = (end_row - first_row) * item.cols.len();
            let next_lines = (next_len / line_len::<T>()).div_ceil(tiles);
            for row in first_row..end_row {
                let corner = row * height;
                let fetched = (row - first_row) * item.cols.len() * next_lines * line_len::<T>();
                let wanted = wanted_of(targets, corner..corner + height);
                let first = if kept { (row - first_row) * row_len } else { 0 };
                let len = if kept { row_len } else { height * width };
                let row = Row {
                    steps,
                    left: left_of(row),
                    next_left: left_of(row + 1),
                    next_right: self.at(next_right + fetched),
                    next_lines,
                    right: self.at(right + item.cols.start * steps * width),
                    panels: item.cols.clone(),
                    wanted: wanted.start..wanted.end.min(product.shape.cols),
                    sums: sums[first..first + len].as_mut_ptr(),
                    kept,
                    add: b > 0,
                    targets: if last { targets } else { &[] },
                    corner,
                };
                // SAFETY: the panels hold `steps` rows, the sums a tile per panel or one; the caller
                // promises the rest.
                unsafe { kernel.multiply_row(&row) };
            }
        }
        item.cost as f64 * self.rows.len() as f64
    }
}

/// The columns that some target wants of these rows.
fn wanted_of<T>(targets: &[Target<T>], rows: Range<usize>) -> Range<usize> {
    let wanted = targets.iter().map(|t| t.wanted_of(rows.clone())).filter(|w| !w.is_empty());
    wanted.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)).unwrap_or(0..0)
}
