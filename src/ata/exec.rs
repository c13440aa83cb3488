//! Runs a [`Plan`] on threads.

use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{MatMut, MatRef};

use super::combine::{accumulate, accumulate_lower};
use super::options::AtaOptions;
use super::plan::Plan;
use super::recurse::Engine;
use super::tree::Task;
use crate::base::{Arena, Error, Flow, Par, Progress, Result};
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
    let lane_scratch: Vec<_> = (0..lanes).map(|_| Mutex::new(arena.take(lane_len))).collect();

    let destinations: Vec<_> = std::iter::once(Blocks::new(c.rb_mut()))
        .chain(partials.into_iter().map(Blocks::new))
        .collect();
    let engine =
        Engine { kernels: T::kernels(options.backend.as_ref()), recursion: &plan.recursion };
    let progress =
        Tracker::new(options, plan.slabs as f64 * tasks.iter().map(Task::cost).sum::<f64>());

    let _held = options.backend.single_threaded();
    let par = Par::Threads(lanes);
    let next = AtomicUsize::new(0);
    par.run_lanes(|lane| {
        let _held = options.backend.single_threaded();
        let mut scratch = lane_scratch[lane].lock().expect("one lane, one lock");
        // Which lane computes a task does not matter to its result.
        while let Some((slab, task)) = take(&next, plan.slabs, &tasks) {
            if progress.cancelled() {
                return;
            }
            // SAFETY: the tasks of a tree own disjoint blocks, each slab has its own destination,
            // and `next` hands out each (slab, task) once.
            let mut dst = unsafe { destinations[slab].of_task(task) };
            let mut beta = if slab == 0 { beta } else { T::ZERO };
            for rows in plan.chunks(slab) {
                let left = a.submatrix(rows.start, task.rows.start, rows.len(), task.rows.len());
                let right = b.submatrix(rows.start, task.cols.start, rows.len(), task.cols.len());
                engine.run(task.op(same), alpha, left, right, beta, dst.rb_mut(), &mut scratch);
                beta = T::ONE;
            }
            progress.add(task.cost());
        }
    });
    if progress.cancelled() {
        return Err(Error::Cancelled);
    }

    if plan.slabs > 1 {
        let next = AtomicUsize::new(0);
        par.run_lanes(|_| {
            while let Some((_, task)) = take(&next, 1, &tasks) {
                // SAFETY: as above; the first pass is over, and each task is handed out once.
                let mut sum = unsafe { destinations[0].of_task(task) };
                for partial in &destinations[1..] {
                    // SAFETY: as above.
                    let partial = unsafe { partial.of_task(task) };
                    if task.triangle {
                        accumulate_lower(sum.rb_mut(), T::ONE, T::ONE, partial.rb());
                    } else {
                        accumulate(sum.rb_mut(), T::ONE, T::ONE, partial.rb());
                    }
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

/// The next pair of slab and task.
fn take<'t>(next: &AtomicUsize, slabs: usize, tasks: &'t [Task]) -> Option<(usize, &'t Task)> {
    let i = next.fetch_add(1, Ordering::Relaxed);
    (i < slabs * tasks.len()).then(|| (i / tasks.len(), &tasks[i % tasks.len()]))
}

/// A matrix whose disjoint blocks may be written from several threads.
pub(super) struct Blocks<'a, T> {
    ptr: *mut T,
    row_stride: isize,
    col_stride: isize,
    rows: usize,
    cols: usize,
    _borrow: std::marker::PhantomData<MatMut<'a, T>>,
}

// SAFETY: `block` is unsafe and asks its callers for disjointness, which is all that sharing needs;
// `T: Send` as the blocks move elements between threads.
unsafe impl<T: Send> Sync for Blocks<'_, T> {}

impl<'a, T> Blocks<'a, T> {
    pub fn new(matrix: MatMut<'a, T>) -> Self {
        Self {
            ptr: matrix.as_ptr_mut(),
            row_stride: matrix.row_stride(),
            col_stride: matrix.col_stride(),
            rows: matrix.nrows(),
            cols: matrix.ncols(),
            _borrow: std::marker::PhantomData,
        }
    }

    pub fn nrows(&self) -> usize {
        self.rows
    }

    pub fn ncols(&self) -> usize {
        self.cols
    }

    /// A block of it.
    ///
    /// # Safety
    /// No two blocks alive at a time may overlap.
    #[allow(clippy::mut_from_ref)]
    pub unsafe fn block(&self, rows: Range<usize>, cols: Range<usize>) -> MatMut<'_, T> {
        assert!(rows.start <= rows.end && rows.end <= self.rows);
        assert!(cols.start <= cols.end && cols.end <= self.cols);
        // SAFETY: the block lies inside the matrix, as asserted; the caller sees to the rest.
        unsafe {
            let offset =
                rows.start as isize * self.row_stride + cols.start as isize * self.col_stride;
            MatMut::from_raw_parts_mut(
                self.ptr.offset(offset),
                rows.len(),
                cols.len(),
                self.row_stride,
                self.col_stride,
            )
        }
    }
}

impl<T> Blocks<'_, T> {
    /// The block that `task` owns.
    ///
    /// # Safety
    /// As for [`Blocks::block`].
    unsafe fn of_task(&self, task: &Task) -> MatMut<'_, T> {
        // SAFETY: the caller's promise.
        unsafe { self.block(task.rows.clone(), task.cols.clone()) }
    }
}

/// Reports progress, and remembers a request to stop.
pub(super) struct Tracker<'a> {
    callback: Option<Progress<'a>>,
    total: f64,
    done: Mutex<f64>,
    cancelled: AtomicBool,
}

impl<'a> Tracker<'a> {
    pub fn new(options: &AtaOptions<'a>, total: f64) -> Self {
        Self {
            callback: options.progress,
            total,
            done: Mutex::new(0.0),
            cancelled: AtomicBool::new(false),
        }
    }

    pub fn add(&self, cost: f64) {
        let Some(callback) = self.callback else { return };
        let done = {
            let mut done = self.done.lock().unwrap_or_else(|e| e.into_inner());
            *done += cost;
            *done
        };
        // Not under the lock: a callback may itself use the threads that wait for it.
        if callback((done / self.total).min(1.0)) == Flow::Cancel {
            self.cancelled.store(true, Ordering::Relaxed);
        }
    }

    pub fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}
