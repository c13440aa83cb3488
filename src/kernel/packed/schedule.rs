//! Runs products one after another, each by all threads: chunk by chunk of the rows, pack, then
//! multiply. Threads share what is packed.
//!
//! Pieces of work have numbers, tickets. A thread takes the next ticket, and waits when it needs
//! pieces that are not done. Threads that run hold the tickets of these pieces, so that nothing
//! hangs even if fewer threads exist than were asked for. There are two buffers for packed chunks:
//! a thread that finds no more to multiply packs the next chunk while others still multiply this
//! one.

use std::ops::ControlFlow;

use super::blocking::Blocking;
use super::geometry::{CACHE_LINE, Geometry, line_len};
use super::kernel::Kernel;
use super::operands::{Product, Shape};
use super::phase::{Phase, Plan, Step};
use crate::base::{Arena, Latch, Par, Real, SharedPtr, Tracker, tickets};

/// Products, and how to run them.
pub(crate) struct Job<'a, T: 'static> {
    pub kernel: &'static dyn Kernel<T>,
    pub products: &'a [Product<'a, T>],
    /// Scalars that packed operands may take, if that is possible.
    pub budget: usize,
    /// Told of work done (products of scalars).
    pub progress: &'a Tracker<'a>,
}

/// Scalars of scratch that [`run`] needs for products of these shapes on so many threads.
pub(crate) fn scratch_len<T: Real>(
    geometry: Geometry,
    shapes: impl Iterator<Item = Shape>,
    budget: usize,
    threads: usize,
) -> usize {
    let (mut packed, mut sums, mut chunks) = (0, 0, 0);
    for shape in shapes {
        let blocking = Blocking::new(geometry, size_of::<T>(), shape, budget);
        packed = packed.max(blocking.packed_len(geometry, shape));
        sums = sums.max(blocking.sums_len(geometry));
        chunks += blocking.chunks(shape);
    }
    chunks.min(BUFFERS) * (packed + line_len::<T>()) + threads * (sums + line_len::<T>())
}

/// Chunks in memory at a time.
const BUFFERS: usize = 2;

/// Takes the next `len` scalars of the arena, from the start of a cache line on.
pub(super) fn aligned<'a, T: Real>(arena: &mut Arena<'a, T>, len: usize) -> &'a mut [T] {
    let piece = arena.take(len + line_len::<T>());
    let skipped = piece.as_ptr().align_offset(CACHE_LINE).min(line_len::<T>());
    &mut piece[skipped..skipped + len]
}

/// Runs the products in order, on `par` threads.
///
/// Entries of the targets belong to the caller's borrow ([`super::Destination`]); the result does
/// not depend on the number of threads.
///
/// # Safety
/// Nobody else uses the matrices that the targets come from.
pub(crate) unsafe fn run<T: Real>(job: &Job<'_, T>, par: Par, scratch: &mut [T]) {
    let geometry = job.kernel.geometry();
    // Products of which nothing is wanted would be packed for nobody; and phases wait for those
    // before them by waiting for their pieces, of which there must be some.
    let plans: Vec<_> = job
        .products
        .iter()
        .map(|product| Plan::new(geometry, product, job.budget))
        .filter(Plan::is_wanted)
        .collect();
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
            // SAFETY: what this phase needs is done, each ticket is handed out once, and pieces of
            // a phase write disjoint memory: panels, or entries of C.
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
