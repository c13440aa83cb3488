//! Runs products one after another, each on all threads: packs a chunk of the rows, then multiplies
//! it. Threads share packed chunks.
//!
//! Pieces of work are numbered (tickets). A thread takes the next ticket, and waits for the earlier
//! phases that its piece needs. Running threads hold the tickets of those phases, so that no thread
//! waits for ever even if fewer threads exist than were requested. There are two buffers for packed
//! chunks: a thread that finds no more to multiply packs the next chunk while others still multiply
//! this one.

use std::ops::ControlFlow;

use super::blocking::Blocking;
use super::geometry::{CACHE_LINE, Geometry, line_len};
use super::kernel::Kernel;
use super::operands::{KernelProduct, Shape};
use super::phase::{Phase, Plan, Step};
use crate::base::{Arena, Latch, Par, Real, SharedPtr, Tracker, tickets};

/// Products, and how to run them.
pub(crate) struct Job<'a, T: 'static> {
    pub kernel: &'static dyn Kernel<T>,
    pub products: &'a [KernelProduct<'a, T>],
    /// Scalars that a packed chunk may take, as for [`Blocking::new`].
    pub budget: usize,
    /// Receives the work done, in scalar multiplications.
    pub progress: &'a Tracker<'a>,
}

/// Returns the scalars of scratch that [`run`] needs for products of these shapes, on `threads`
/// threads or on one.
pub(crate) fn scratch_len<T: Real>(
    geometry: Geometry,
    shapes: impl Iterator<Item = Shape>,
    budget: usize,
    threads: usize,
) -> usize {
    let (mut packed, mut sums, mut chunks) = (0, line_len::<T>(), 0);
    for shape in shapes {
        let blocking = |threads| Blocking::new(geometry, size_of::<T>(), shape, budget, threads);
        let all = |threads| threads * (blocking(threads).sums_len(geometry) + line_len::<T>());
        // A single thread computes larger items.
        sums = sums.max(all(1)).max(all(threads));
        let blocking = blocking(threads);
        packed = packed.max(blocking.packed_len(geometry, shape));
        chunks += blocking.chunks(shape);
    }
    chunks.min(BUFFERS) * (packed + line_len::<T>()) + sums
}

/// Packed chunks in memory at a time.
const BUFFERS: usize = 2;

/// Takes the next `len` scalars of the arena, from the start of a cache line on.
pub(super) fn aligned<'a, T: Real>(arena: &mut Arena<'a, T>, len: usize) -> &'a mut [T] {
    let piece = arena.take(len + line_len::<T>());
    let skipped = piece.as_ptr().align_offset(CACHE_LINE).min(line_len::<T>());
    &mut piece[skipped..skipped + len]
}

/// Runs the products in order, on `par` threads.
///
/// The result does not depend on the number of threads. `scratch` has at least [`scratch_len`]
/// scalars.
///
/// # Safety
/// Nobody else uses the matrices that the targets come from ([`super::Destination`]).
pub(crate) unsafe fn run<T: Real>(job: &Job<'_, T>, par: Par, scratch: &mut [T]) {
    let geometry = job.kernel.geometry();
    // Skips products of which nothing is wanted: they would be packed in vain, and a phase without
    // pieces would not make later phases wait for earlier ones.
    let plans: Vec<_> = job
        .products
        .iter()
        .map(|product| Plan::new(geometry, product, job.budget, par.threads()))
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
            // Counts down even on a panic: other threads would wait for ever.
            let _done = Finally(|| phase.done.count_down());
            let i = ticket - phase.tickets.start;
            if job.progress.state().is_break() {
                // The remaining tickets are handed out too, since threads wait for them.
                return ControlFlow::Continue(());
            }
            // SAFETY: `run` has the matrices to itself. The latches of `needed_by` say that the
            // phases that this one needs are done, `tickets` hands out each ticket once, and pieces
            // of a phase write disjoint memory: panels in a chunk of `packed_len` scalars, or
            // entries of C. Each worker has its own sums.
            unsafe {
                match phase.step {
                    Step::Pack => phase.pack(job.kernel, i),
                    Step::Multiply => phase.multiply(job.kernel, i, sums),
                }
            }
        };
        if work > 0.0 {
            // The result is ignored, since later tickets check the state.
            let _ = job.progress.add(work);
        }
        ControlFlow::Continue(())
    });
}

/// Returns the phases that must be done before phase `p`. Packing (even `p`) waits for the phase
/// that last read its buffer; multiplying waits for the packing of its chunk and for the previous
/// multiplication, which may write the same entries of C.
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
