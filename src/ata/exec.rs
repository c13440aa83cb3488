//! Runs a [`Plan`] on threads.

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{MatMut, MatRef};

use super::combine::{accumulate, accumulate_lower};
use super::options::AtaOptions;
use super::plan::Plan;
use super::recurse::Engine;
use super::tree::Task;
use crate::base::{Arena, Disjoint, Par, Result, Tracker, tickets};
use crate::blas::BlasReal;

/// `C := alpha A^T B + beta C` by `plan`; B is `None` for A^T A. Symmetric plans touch only the
/// lower triangle.
pub(crate) fn execute<T: BlasReal>(
    plan: &Plan,
    alpha: T,
    a: MatRef<'_, T>,
    b: Option<MatRef<'_, T>>,
    beta: T,
    mut c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
    scratch: &mut [T],
) -> Result<()> {
    let mut tasks = plan.tree.tasks();
    // The largest first, so that the small ones fill the gaps at the end.
    tasks.sort_by(|a, b| b.cost().total_cmp(&a.cost()));
    let same = b.is_none();
    let b = b.unwrap_or(a);
    let lanes = plan.lanes(options.par.threads());
    let mut arena = Arena::new(scratch);
    // Stored as C is: back ends are not equally fast at both.
    let row_major = c.col_stride() == 1;
    let partials: Vec<MatMut<'_, T>> = (1..plan.slabs)
        .map(|_| partial(arena.take(plan.n * plan.k), plan.n, plan.k, row_major))
        .collect();
    let lane_len = plan.lane_scratch_len(same);
    let mut workers: Vec<_> = (0..lanes).map(|_| arena.take(lane_len)).collect();

    let destinations: Vec<_> = std::iter::once(Disjoint::new(c.rb_mut()))
        .chain(partials.into_iter().map(Disjoint::new))
        .collect();
    let engine =
        Engine { kernels: T::kernels(options.backend.as_ref()), recursion: &plan.recursion };
    let progress = Tracker::new(
        options.progress,
        plan.slabs as f64 * tasks.iter().map(Task::cost).sum::<f64>(),
    );

    let _held = options.backend.single_threaded();
    tickets(&mut workers, plan.slabs * tasks.len(), |scratch, ticket| {
        let _held = options.backend.single_threaded();
        let (slab, task) = (ticket / tasks.len(), &tasks[ticket % tasks.len()]);
        // SAFETY: the tasks of a tree own disjoint blocks, each slab has its own destination,
        // and `next` hands out each (slab, task) once.
        let mut dst = unsafe { block_of(&destinations[slab], task) };
        let mut beta = if slab == 0 { beta } else { T::ZERO };
        for rows in plan.chunks(slab) {
            let left = a.submatrix(rows.start, task.rows.start, rows.len(), task.rows.len());
            let right = b.submatrix(rows.start, task.cols.start, rows.len(), task.cols.len());
            engine.run(task.op(same), alpha, left, right, beta, dst.rb_mut(), scratch);
            beta = T::ONE;
        }
        progress.add(task.cost())
    });
    progress.finish()?;

    if plan.slabs > 1 {
        Par::Threads(lanes).for_each(tasks.iter(), |_, task| {
            // SAFETY: as above; the first pass is over, and each task is handed out once.
            let mut sum = unsafe { block_of(&destinations[0], task) };
            for partial in &destinations[1..] {
                // SAFETY: as above.
                let partial = unsafe { block_of(partial, task) };
                if task.triangle {
                    accumulate_lower(sum.rb_mut(), T::ONE, T::ONE, partial.rb());
                } else {
                    accumulate(sum.rb_mut(), T::ONE, T::ONE, partial.rb());
                }
            }
        });
    }
    Ok(())
}

/// An n x k matrix in `memory`.
pub(super) fn partial<T>(memory: &mut [T], n: usize, k: usize, row_major: bool) -> MatMut<'_, T> {
    if row_major {
        MatMut::from_row_major_slice_mut(memory, n, k)
    } else {
        MatMut::from_column_major_slice_mut(memory, n, k)
    }
}

/// The block of `matrix` that `task` owns.
///
/// # Safety
/// As for [`Disjoint::block`].
unsafe fn block_of<'m, T>(matrix: &'m Disjoint<'_, T>, task: &Task) -> MatMut<'m, T> {
    // SAFETY: the caller's promise.
    unsafe { matrix.block(task.rows.clone(), task.cols.clone()) }
}
