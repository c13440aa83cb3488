//! Pools of threads: those that a program makes, and those that the process keeps for all calls.

use std::any::Any;
use std::cell::Cell;
use std::collections::BTreeMap;
use std::mem::{self, ManuallyDrop};
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicPtr, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};
use std::{process, ptr};

use core_affinity::CoreId;

use super::cores::{allowed_threads, available_cores};
use super::float_env::FloatEnv;
use super::{Error, Result};

/// Collections of garbage that leave nothing of 400 threads: each takes what 8 of them left, once
/// it is three collections old.
const COLLECTIONS: usize = 64;

/// Whether threads stay on one core each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Pin {
    /// The operating system may move threads between cores.
    No,
    /// Thread `i` stays on the `i`-th core of the affinity mask (modulo their number), where the
    /// operating system allows it.
    ///
    /// The mask is that of the process at the first call that needs it, as set by `taskset` or by
    /// the binding of `mpirun`. Processes that share a mask share its first cores, unless they are
    /// ranks of a `ranks::World` whose function `share_cores` divides them.
    Cores,
}

/// Returns the cores of the affinity mask in ascending order, or none where the system does not
/// report them. The mask is read once, because a pinned thread sees one core only.
fn mask() -> &'static [CoreId] {
    static CORES: OnceLock<Vec<CoreId>> = OnceLock::new();
    CORES.get_or_init(|| core_affinity::get_core_ids().unwrap_or_default())
}

/// The part of the mask that this process has for its pinned threads: which one, and of how many.
static SHARE: Mutex<(usize, usize)> = Mutex::new((0, 1));

/// Returns the cores for pinned threads: the part of the mask that [`share_cores`] has set.
fn cores() -> &'static [CoreId] {
    let (part, parts) = *SHARE.lock().unwrap_or_else(PoisonError::into_inner);
    &mask()[part_of_cores(mask().len(), part, parts)]
}

/// Returns part `part` of `parts` of `count` cores: at least one core, which parts share when there
/// are more parts than cores.
fn part_of_cores(count: usize, part: usize, parts: usize) -> Range<usize> {
    let bound = |part: usize| part * count / parts.max(1);
    let start = bound(part);
    start..bound(part + 1).max(start + 1).min(count)
}

/// Returns the numbers of the cores in the affinity mask, ascending; none where the system does not
/// report them.
#[cfg(feature = "mpi")]
pub(crate) fn core_ids() -> Vec<usize> {
    mask().iter().map(|core| core.id).collect()
}

/// Restricts threads that are pinned from now on to part `part` of `parts` equal parts of the
/// affinity mask, and returns how many cores this part has, at least 1.
#[cfg(feature = "mpi")]
pub(crate) fn share_cores(part: usize, parts: usize) -> usize {
    *SHARE.lock().unwrap_or_else(PoisonError::into_inner) = (part, parts);
    cores().len().max(1)
}

/// A group of threads, made once and used for many calls: everything that is called inside
/// [`ThreadPool::run`] computes on these threads and no others, except calls with [`Pin::Cores`],
/// which have pinned threads of their own. A call that reads rows from a file starts one thread
/// more, which reads ahead while the threads of the pool compute. Where a call has a progress
/// callback, a long dense eigenproblem, and the order of elimination of a large sparse matrix, are
/// computed on a thread of their own.
///
/// When the pool is dropped its threads end, and the caller waits for them.
///
/// ```
/// use catamaran::{AtaOptions, Uplo, ata_into, base::{Pin, ThreadPool}, faer::Mat};
///
/// let pool = ThreadPool::new(2, Pin::No)?;
/// let (a, mut c) = (Mat::<f64>::identity(6, 3), Mat::zeros(3, 3));
/// let options = AtaOptions::new().threads(2).uplo(Uplo::Both);
/// pool.run(|| ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options))?;
/// assert_eq!(c, Mat::<f64>::identity(3, 3));
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug)]
pub struct ThreadPool {
    pool: ManuallyDrop<rayon::ThreadPool>,
    threads: Vec<JoinHandle<()>>,
    /// Calls of [`ThreadPool::help`] that wait for a thread.
    waiting: Arc<AtomicUsize>,
    /// The process that has the threads.
    process: u32,
}

impl ThreadPool {
    /// Creates a pool of `threads` threads (at least 1). They compute in the default floating-point
    /// environment, whatever that of the calling thread is.
    ///
    /// # Errors
    /// [`Error::Argument`] when the operating system refuses the threads.
    pub fn new(threads: usize, pin: Pin) -> Result<Self> {
        let mut handles = Vec::new();
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads.max(1))
            .spawn_handler(|worker| {
                let named = thread::Builder::new().name("catamaran".into());
                handles.push(named.spawn(move || {
                    // Threads inherit the environment of the thread that makes them.
                    let _nearest = FloatEnv::nearest();
                    if pin == Pin::Cores && !cores().is_empty() {
                        core_affinity::set_for_current(cores()[worker.index() % cores().len()]);
                    }
                    worker.run();
                })?);
                Ok(())
            })
            .build()
            .map_err(|e| Error::Argument { what: "threads", why: e.to_string() })?;
        Ok(Self {
            pool: ManuallyDrop::new(pool),
            threads: handles,
            waiting: Arc::default(),
            process: process::id(),
        })
    }

    /// Calls `work` on a thread of the pool.
    ///
    /// ```
    /// use catamaran::base::{Pin, ThreadPool};
    ///
    /// let pool = ThreadPool::new(2, Pin::No)?;
    /// assert_eq!(pool.run(|| (1..=4).product::<u32>()), 24);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.pool.install(work)
    }

    /// Calls `own` on the calling thread, and meanwhile `work(i)` for i in `0..count` on threads of
    /// the pool, for as many i as find a thread before `own` returns. Waits for those that have
    /// begun, so that a pool that is busy with other calls delays none. A panic of one of them is
    /// passed on.
    pub(super) fn help(&self, count: usize, work: &(dyn Fn(usize) + Sync), own: impl FnOnce()) {
        let visit = Arc::new(Visit::default());
        // SAFETY: only the lifetime changes. `work` is called by visitors only, between `enter` and
        // `leave`. `Closing` closes the visit before this function returns, also by a panic: it
        // waits for the visitors that are inside, and no other one enters from then on.
        let work = unsafe {
            mem::transmute::<&(dyn Fn(usize) + Sync), &'static (dyn Fn(usize) + Sync)>(work)
        };
        let closing = Closing(&visit);
        // Where threads share cores, one that stays awake would take the time of those that work.
        let has_cores = self.threads.len() < available_cores();
        for i in 0..count {
            // More would only pile up while the pool is busy.
            if self.waiting.fetch_add(1, Ordering::Relaxed) >= self.threads.len() {
                self.waiting.fetch_sub(1, Ordering::Relaxed);
                break;
            }
            let (waiting, visit) = (self.waiting.clone(), visit.clone());
            self.pool.spawn(move || {
                waiting.fetch_sub(1, Ordering::Relaxed);
                let call = || {
                    if visit.enter() {
                        visit.leave(catch_unwind(AssertUnwindSafe(|| work(i))).err());
                    }
                };
                if has_cores { in_series(call) } else { call() }
            });
        }
        own();
        drop(closing);
        let panic = visit.state().panic.take();
        if let Some(panic) = panic {
            resume_unwind(panic);
        }
    }
}

/// Calls `work` on a thread of a pool. If the call before has ended shortly before, the thread then
/// stays awake for a while and takes the next calls: waking it takes as long as a small product.
fn in_series(work: impl FnOnce()) {
    /// Longest pause between two calls of a series, with the time to wake the thread.
    const PAUSE: Duration = Duration::from_micros(500);
    /// How long a thread stays awake without a call.
    const AWAKE: Duration = Duration::from_micros(100);
    /// When a thread that is awake returns to rayon, also from a series that goes on: rayon may
    /// have called it inside of work that waits for a part of its own.
    const LONGEST: Duration = Duration::from_millis(5);
    thread_local! {
        /// When the last call of this thread ended.
        static ENDED: Cell<Option<Instant>> = const { Cell::new(None) };
        /// Whether a call of this thread is at work, or stays awake and takes `work`.
        static IS_INSIDE: Cell<bool> = const { Cell::new(false) };
    }
    let ended_within = |time: Duration| ENDED.get().is_some_and(|ended| ended.elapsed() < time);
    let (is_series, was_inside) = (ended_within(PAUSE), IS_INSIDE.replace(true));
    work();
    let ended = Instant::now();
    ENDED.set(Some(ended));
    if was_inside {
        return;
    }
    while is_series && ended_within(AWAKE) && ended.elapsed() < LONGEST {
        rayon::yield_now();
        thread::yield_now();
    }
    IS_INSIDE.set(false);
}

/// Threads of a pool that help a caller.
#[derive(Default)]
struct Visit {
    state: Mutex<VisitState>,
    left: Condvar,
}

#[derive(Default)]
struct VisitState {
    is_closed: bool,
    /// Number of visitors at work.
    inside: usize,
    /// The first panic of a visitor.
    panic: Option<Box<dyn Any + Send>>,
}

impl Visit {
    fn state(&self) -> MutexGuard<'_, VisitState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns whether the visitor may work, and has to leave after that.
    fn enter(&self) -> bool {
        let mut state = self.state();
        state.inside += usize::from(!state.is_closed);
        !state.is_closed
    }

    fn leave(&self, panic: Option<Box<dyn Any + Send>>) {
        let mut state = self.state();
        state.inside -= 1;
        state.panic = state.panic.take().or(panic);
        self.left.notify_all();
    }
}

/// Closes a visit when it is dropped, and waits for the visitors inside.
struct Closing<'v>(&'v Visit);

impl Drop for Closing<'_> {
    fn drop(&mut self) {
        let mut state = self.0.state();
        state.is_closed = true;
        while state.inside > 0 {
            state = self.0.left.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl Drop for ThreadPool {
    fn drop(&mut self) {
        if self.process != process::id() {
            // A forked process has no such threads, and may not have the locks to end them.
            return mem::forget(mem::take(&mut self.threads));
        }
        let inside = self.pool.current_thread_index().is_some();
        // SAFETY: taken here only, and never used again.
        drop(unsafe { ManuallyDrop::take(&mut self.pool) });
        if inside {
            // The thread would wait for itself.
            return;
        }
        for thread in self.threads.drain(..) {
            // rayon aborts the process when one of its threads panics.
            let _ = thread.join();
        }
    }
}

/// The pools of a process, by their threads.
struct Kept {
    process: u32,
    pools: Mutex<BTreeMap<(Pin, usize), Arc<ThreadPool>>>,
}

/// The pools of this process, or of that which it was forked from; null before the first call.
static KEPT: AtomicPtr<Kept> = AtomicPtr::new(ptr::null_mut());

/// Returns the pools of this process. Those of a parent are left alone: their threads stayed with
/// it, and another thread may have held their lock when the process was forked.
fn kept() -> &'static Kept {
    let process = process::id();
    let mut known = KEPT.load(Ordering::Acquire);
    // SAFETY: what KEPT points to is never freed.
    let valid = |known: *mut Kept| unsafe { known.as_ref() }.filter(|k| k.process == process);
    loop {
        if let Some(kept) = valid(known) {
            return kept;
        }
        let fresh = Box::into_raw(Box::new(Kept { process, pools: Mutex::default() }));
        match KEPT.compare_exchange(known, fresh, Ordering::AcqRel, Ordering::Acquire) {
            Ok(_) => known = fresh,
            Err(other) => {
                // SAFETY: made above, and no other thread has seen it.
                drop(unsafe { Box::from_raw(fresh) });
                known = other;
            }
        }
    }
}

impl Kept {
    /// Returns the smallest pool of `least` threads or more; makes one of `width` where there is
    /// none. Pools are kept, because starting threads takes longer than a small product.
    fn get(&self, pin: Pin, least: usize, width: usize) -> Result<Arc<ThreadPool>> {
        let mut pools = self.pools.lock().unwrap_or_else(PoisonError::into_inner);
        let most = if pin == Pin::Cores { least } else { usize::MAX };
        if let Some((_, pool)) = pools.range((pin, least)..=(pin, most)).next() {
            return Ok(pool.clone());
        }
        let pool = Arc::new(ThreadPool::new(width, pin)?);
        pools.insert((pin, width), pool.clone());
        Ok(pool)
    }
}

/// Returns a pool that helps a caller to have `wanted` (>= 2) threads, its own included.
///
/// All calls that want at most the default number of threads use the same pool. Larger pools have,
/// with the caller, a multiple of the cores as their width, so that few pools exist.
pub(super) fn shared(wanted: usize) -> Result<Arc<ThreadPool>> {
    let width = match allowed_threads() {
        allowed if wanted <= allowed => allowed,
        _ => wanted.next_multiple_of(available_cores()),
    };
    kept().get(Pin::No, wanted - 1, width - 1)
}

/// Returns a pool of exactly `threads` (>= 1) pinned threads.
pub(super) fn pinned(threads: usize) -> Result<Arc<ThreadPool>> {
    kept().get(Pin::Cores, threads, threads)
}

/// Makes faer compute on the calling thread, where some of its operators would start rayon's global
/// pool beside the threads of this library: for programs and libraries whose copy of faer has no
/// other user, as those with a C interface.
///
/// ```
/// use catamaran::{base::use_own_threads_only, faer};
///
/// use_own_threads_only();
/// assert_eq!(faer::get_global_parallelism(), faer::Par::Seq);
/// ```
pub fn use_own_threads_only() {
    faer::set_global_parallelism(faer::Par::Seq);
}

/// Ends the threads that this process keeps for its calls, and waits until they have ended.
///
/// Later calls start new threads. A call that runs at the same time keeps its threads until it
/// returns. Threads of a [`ThreadPool`] or of rayon's pools are not affected.
///
/// ```
/// use catamaran::{AtaOptions, ata_into, base::release_threads, faer::Mat};
///
/// let (a, mut c) = (Mat::<f64>::identity(300, 200), Mat::zeros(200, 200));
/// ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &AtaOptions::new())?;
/// release_threads(); // as before a long part of a program that does not multiply
/// # Ok::<(), catamaran::Error>(())
/// ```
pub fn release_threads() {
    let mut pools = kept().pools.lock().unwrap_or_else(PoisonError::into_inner);
    let ended = mem::take(&mut *pools);
    // Threads that end may wait for a call that needs this lock.
    drop(pools);
    drop(ended);
    // They leave records to the next thread that collects garbage, which checks of leaks find.
    (0..COLLECTIONS).for_each(|_| crossbeam_epoch::pin().flush());
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;
    use std::sync::mpsc;

    use super::super::Latch;
    use super::*;

    #[test]
    fn pools_are_shared_until_they_are_released() {
        let (narrow, wide) = (shared(2).unwrap(), shared(allowed_threads() + 1).unwrap());
        assert!(Arc::ptr_eq(&narrow, &shared(2).unwrap()));
        assert!(Arc::ptr_eq(&wide, &shared(allowed_threads() + 1).unwrap()));
        let fixed = pinned(3).unwrap();
        assert!(Arc::ptr_eq(&fixed, &pinned(3).unwrap()));
        assert_eq!((fixed.threads.len(), pinned(2).unwrap().threads.len()), (3, 2));
        release_threads();
        // Whoever still has a pool can use it.
        assert_eq!(narrow.run(|| 7), 7);
        assert!(!Arc::ptr_eq(&narrow, &shared(2).unwrap()));
    }

    #[test]
    fn ranks_of_a_node_pin_to_parts_of_its_cores_that_differ() {
        let all = |count: usize, parts: usize| -> Vec<_> {
            (0..parts).map(|part| part_of_cores(count, part, parts)).collect()
        };
        assert_eq!(all(8, 2), [0..4, 4..8]);
        assert_eq!(all(8, 3), [0..2, 2..5, 5..8]);
        assert_eq!(part_of_cores(5, 0, 1), 0..5);
        // More processes than cores.
        assert_eq!(all(2, 4), [0..1, 0..1, 1..2, 1..2]);
        assert_eq!(all(0, 2), [0..0, 0..0]);
    }

    #[test]
    fn the_widths_of_shared_pools_are_few() {
        let (cores, allowed) = (available_cores(), allowed_threads());
        for wanted in 2..=4 * cores {
            let width = shared(wanted).unwrap().threads.len() + 1;
            assert!(width >= wanted && (width == allowed || width.is_multiple_of(cores)));
        }
    }

    #[test]
    fn a_caller_waits_for_helpers_that_have_begun_and_for_no_others() {
        let pool = ThreadPool::new(1, Pin::No).unwrap();
        let (begun, ended) = (Latch::new(1), AtomicUsize::new(0));
        let first = |_: usize| {
            begun.count_down();
            thread::sleep(Duration::from_millis(20));
            ended.fetch_add(1, Ordering::Relaxed);
        };
        pool.help(1, &first, || begun.wait());
        assert_eq!(ended.into_inner(), 1);
        // The only thread waits for this caller, which the second one does not wait for.
        let (begun, over) = (Latch::new(1), Latch::new(1));
        let busy = |_: usize| {
            begun.count_down();
            over.wait();
        };
        pool.help(1, &busy, || {
            begun.wait();
            for _ in 0..100 {
                pool.help(3, &|_| unreachable!("no thread is free"), || {});
            }
            assert!(pool.waiting.load(Ordering::Relaxed) <= 1);
            over.count_down();
        });
    }

    #[test]
    fn every_call_of_a_long_series_is_helped_on_a_stack_of_bounded_depth() {
        /// Calls that would overflow the stack of a thread that took each inside of the last.
        const CALLS: usize = if cfg!(miri) { 10 } else { 20_000 };
        let pool = ThreadPool::new(1, Pin::No).unwrap();
        let helped = AtomicUsize::new(0);
        for _ in 0..CALLS {
            let begun = Latch::new(1);
            let help = |_: usize| {
                helped.fetch_add(1, Ordering::Relaxed);
                begun.count_down();
            };
            pool.help(1, &help, || begun.wait());
        }
        assert_eq!(helped.into_inner(), CALLS);
    }

    #[test]
    fn a_call_inside_of_another_takes_no_further_calls() {
        let pool = ThreadPool::new(1, Pin::No).unwrap();
        let is_inside = Arc::new(AtomicBool::new(true));
        let (sender, seen) = mpsc::channel();
        pool.run(|| {
            in_series(|| {
                let is_inside = is_inside.clone();
                rayon::spawn(move || sender.send(is_inside.load(Ordering::Relaxed)).unwrap());
                // The second one is in a series.
                in_series(|| ());
                in_series(|| ());
            });
            is_inside.store(false, Ordering::Relaxed);
        });
        assert_eq!(seen.recv(), Ok(false));
    }

    #[test]
    fn a_thread_that_is_awake_returns_from_a_series_that_goes_on() {
        /// Calls that take much longer than a thread stays awake.
        const CALLS: usize = 2_000_000;
        fn call(left: Arc<AtomicUsize>) {
            in_series(|| ());
            if left.fetch_sub(1, Ordering::Relaxed) > 1 {
                rayon::spawn(move || call(left));
            }
        }
        let pool = ThreadPool::new(1, Pin::No).unwrap();
        let left = Arc::new(AtomicUsize::new(CALLS));
        pool.run(|| {
            in_series(|| ());
            let calls = left.clone();
            rayon::spawn(move || call(calls));
            in_series(|| ());
            // Ends the series, which was not taken to its end.
            assert!(left.swap(1, Ordering::Relaxed) > 1);
        });
    }

    #[test]
    fn panics_of_helpers_and_of_the_caller_are_passed_on() {
        let pool = ThreadPool::new(1, Pin::No).unwrap();
        let begun = Latch::new(1);
        let fails = |i: usize| {
            begun.count_down();
            assert!(i > 0, "helper");
        };
        let found = catch_unwind(AssertUnwindSafe(|| pool.help(1, &fails, || begun.wait())));
        assert_eq!(found.unwrap_err().downcast_ref(), Some(&"helper"));
        let (begun, ended) = (Latch::new(1), AtomicUsize::new(0));
        let slow = |_: usize| {
            begun.count_down();
            thread::sleep(Duration::from_millis(20));
            ended.fetch_add(1, Ordering::Relaxed);
        };
        let own = || {
            begun.wait();
            assert!(ended.load(Ordering::Relaxed) > 1, "caller");
        };
        let found = catch_unwind(AssertUnwindSafe(|| pool.help(1, &slow, own)));
        assert_eq!(found.unwrap_err().downcast_ref(), Some(&"caller"));
        assert_eq!(ended.into_inner(), 1);
    }

    #[test]
    fn a_pool_may_be_dropped_by_one_of_its_threads() {
        let pool = Arc::new(ThreadPool::new(2, Pin::No).unwrap());
        let inner = Mutex::new(Some(pool.clone()));
        pool.run(|| drop(inner.lock().unwrap().take()));
        let (last, taken) = (Arc::into_inner(pool).unwrap(), Mutex::new(None));
        *taken.lock().unwrap() = Some(last);
        let other = ThreadPool::new(1, Pin::No).unwrap();
        other.run(|| drop(taken.lock().unwrap().take()));
    }

    #[cfg(all(target_os = "linux", target_arch = "x86_64", not(miri)))]
    #[test]
    fn threads_have_the_default_environment_whatever_their_maker_has() {
        unsafe extern "C" {
            fn fesetround(mode: std::ffi::c_int) -> std::ffi::c_int;
        }
        const UPWARD: std::ffi::c_int = 0x800;
        // SAFETY: a function of C's mathematical library; nothing is computed before it is undone.
        let set = |mode| unsafe { fesetround(mode) };
        for pin in [Pin::No, Pin::Cores] {
            set(UPWARD);
            let pool = ThreadPool::new(3, pin);
            set(0);
            let environments = pool.unwrap().pool.broadcast(|_| FloatEnv::is_default());
            assert_eq!(environments, [true; 3]);
        }
    }
}
