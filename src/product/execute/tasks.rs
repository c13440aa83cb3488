//! Blocks of C as tasks, each by a recursion over a back end.

use std::ops::ControlFlow;

use faer::MatMut;
use faer::prelude::{Reborrow, ReborrowMut};

use super::balance::Balance;
use super::product::Product;
use super::recursive::{Engine, Node};
use crate::base::{Arena, Disjoint, Par, Result, Tracker, tickets};
use crate::blas::BlasReal;
use crate::product::combine::{accumulate, accumulate_lower};
use crate::product::options::AtaOptions;
use crate::product::plan::{Op, Problem, Recursion, Task, Tasks};

/// Returns the elements of scratch that [`execute`] needs.
pub(super) fn scratch_len(plan: &Tasks, problem: &Problem, par: Par) -> usize {
    let partials = (plan.cut.slabs - 1) * problem.n * problem.k;
    plan.worker_scratch_len(problem.op) * workers(plan, par) + partials
}

/// Returns how many threads can be busy.
fn workers(plan: &Tasks, par: Par) -> usize {
    par.at_most(plan.cut.slabs * plan.tasks.len()).threads()
}

/// Computes `product`; only its lower triangle is touched where the problem is symmetric.
#[inline(never)]
pub(super) fn execute<T: BlasReal>(
    plan: &Tasks,
    problem: &Problem,
    product: Product<'_, T>,
    options: &AtaOptions<'_>,
    scratch: &mut [T],
) -> Result<()> {
    let Tasks { tasks, cut, .. } = plan;
    let (alpha, a, b, beta) =
        (product.alpha, product.a, product.b.unwrap_or(product.a), product.beta);
    let mut c = product.c;
    let mut arena = Arena::new(scratch);
    // Stored in the order of C: back ends are not equally fast for both orders.
    let row_major = c.col_stride() == 1;
    let partials: Vec<MatMut<'_, T>> = (1..cut.slabs)
        .map(|_| partial(arena.take(problem.n * problem.k), problem, row_major))
        .collect();
    let worker_len = plan.worker_scratch_len(problem.op);
    let mut workers: Vec<_> =
        (0..workers(plan, options.par)).map(|_| arena.take(worker_len)).collect();
    let threads = Par::Threads(workers.len());

    let destinations: Vec<_> = std::iter::once(Disjoint::new(c.rb_mut()))
        .chain(partials.into_iter().map(Disjoint::new))
        .collect();
    let even = |matrix| matches!(Balance::of(matrix, options.par), Balance::Even);
    let classical = Recursion::none();
    let recursion = match plan.fast && plan.guarded {
        true if !(even(a) && (problem.same() || even(b))) => &classical,
        _ => &plan.recursion,
    };
    let total = problem.m as f64 * tasks.iter().map(Task::cost).sum::<f64>();
    let tracker = Tracker::new(options.progress, total);
    let kernels = T::kernels(options.backend.as_ref());
    let engine = Engine { kernels, recursion, tracker: &tracker };

    let _held = options.backend.single_threaded();
    // Which worker computes a task does not matter to its result.
    tickets(&mut workers, cut.slabs * tasks.len(), |scratch, ticket| {
        let _held = options.backend.single_threaded();
        let (slab, task) = (ticket / tasks.len(), &tasks[ticket % tasks.len()]);
        // SAFETY: the tasks of a tree own disjoint blocks, each slab has its own destination, and
        // each ticket is handed out once.
        let mut block = unsafe { block_of(&destinations[slab], task) };
        let mut beta = if slab == 0 { beta } else { T::ZERO };
        for rows in cut.chunks_of(slab) {
            let left = a.submatrix(rows.start, task.rows.start, rows.len(), task.rows.len());
            let right = b.submatrix(rows.start, task.cols.start, rows.len(), task.cols.len());
            let (op, c) = (task.op(problem.op), block.rb_mut());
            let work = rows.len() as f64 * task.cost();
            engine.run(Node { op, alpha, a: left, b: right, beta, c }, work, scratch)?;
            beta = T::ONE;
        }
        ControlFlow::Continue(())
    });
    tracker.finish()?;

    threads.tickets(if cut.slabs > 1 { tasks.len() } else { 0 }, |i| {
        let task = &tasks[i];
        // SAFETY: tasks own disjoint blocks, each ticket is handed out once, and the first pass,
        // which had them before, has returned.
        let mut sum = unsafe { block_of(&destinations[0], task) };
        for partial in &destinations[1..] {
            // SAFETY: the block of the same task in another destination, which is memory of its
            // own; as for `sum`, no other ticket uses it.
            let partial = unsafe { block_of(partial, task) };
            if task.op(problem.op) == Op::Gemm {
                accumulate(sum.rb_mut(), T::ONE, T::ONE, partial.rb());
            } else {
                accumulate_lower(sum.rb_mut(), T::ONE, T::ONE, partial.rb());
            }
        }
        ControlFlow::Continue(())
    });
    Ok(())
}

/// Returns a matrix of C's shape in `memory`.
pub(super) fn partial<'m, T>(
    memory: &'m mut [T],
    problem: &Problem,
    row_major: bool,
) -> MatMut<'m, T> {
    if row_major {
        MatMut::from_row_major_slice_mut(memory, problem.n, problem.k)
    } else {
        MatMut::from_column_major_slice_mut(memory, problem.n, problem.k)
    }
}

/// Returns the block of `matrix` that `task` owns.
///
/// # Safety
/// As for [`Disjoint::block`].
unsafe fn block_of<'m, T>(matrix: &'m Disjoint<'_, T>, task: &Task) -> MatMut<'m, T> {
    // SAFETY: the contract is that of `Disjoint::block`: no other block that is alive overlaps this
    // one.
    unsafe { matrix.block(task.rows.clone(), task.cols.clone()) }
}
