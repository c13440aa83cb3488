//! Threads: their number, and the loop that distributes work among them.

use std::ops::{ControlFlow, Range};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, OnceLock, PoisonError};

use super::cores::{allowed_threads, available_cores};
use super::float_env::FloatEnv;
use super::operations::spend;
use super::pool::{Pin, pinned, shared};
use super::watch::unwatched;

/// Most operations of a thread between two requests to go on, unless one item takes more.
pub(crate) const PIECE: usize = 1 << 25;

/// How many threads a call may use. Results do not depend on it, bit for bit.
///
/// ```
/// use catamaran::{AtaOptions, Par, ata_into, faer::Mat};
///
/// let a = Mat::<f64>::from_fn(300, 50, |i, j| (i * j % 17) as f64 / 16.0);
/// let product = |par| {
///     let mut c = Mat::zeros(50, 50);
///     ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &AtaOptions::new().par(par)).map(|()| c)
/// };
/// assert_eq!(product(Par::Seq)?, product(Par::Threads(4))?);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Par {
    /// The calling thread only.
    Seq,
    /// At most this many threads (at least 1): inside of a rayon pool, as in
    /// [`ThreadPool::run`](super::ThreadPool::run), threads of that pool; elsewhere the calling
    /// thread and threads that the process keeps for all calls
    /// ([`release_threads`](super::release_threads)). At most [`Par::MOST_PER_CORE`] threads per
    /// core are used, because more would only wait for each other.
    Threads(usize),
}

impl Par {
    /// Largest number of threads per core.
    pub const MOST_PER_CORE: usize = 4;

    /// Returns as many threads as this process may use: one for each core in its affinity mask, or
    /// fewer where the calling thread belongs to a smaller rayon pool, or where the environment has
    /// a lower number in `RAYON_NUM_THREADS` or `CATAMARAN_NUM_THREADS`
    /// ([`obey_omp_num_threads`](super::obey_omp_num_threads) adds `OMP_NUM_THREADS`). The
    /// variables are read once.
    pub fn all() -> Self {
        Self::Threads(threads_of_pool().unwrap_or(usize::MAX).min(allowed_threads()))
    }

    /// Returns the number of threads that are used.
    ///
    /// ```
    /// use catamaran::Par;
    ///
    /// assert_eq!((Par::Seq.threads(), Par::Threads(0).threads()), (1, 1));
    /// ```
    pub fn threads(self) -> usize {
        match self {
            Self::Seq => 1,
            Self::Threads(n) => n.clamp(1, Self::MOST_PER_CORE * available_cores()),
        }
    }

    /// Calls `work` on the calling thread or, with [`Pin::Cores`], on one of as many pinned
    /// threads. In the second case all threads of `work` are pinned, and the calling thread, which
    /// waits, keeps its affinity mask.
    pub(crate) fn on_cores<R: Send>(self, pin: Pin, work: impl FnOnce() -> R + Send) -> R {
        match (self, pin) {
            (Self::Seq, _) | (_, Pin::No) => work(),
            (Self::Threads(_), Pin::Cores) => match pinned(self.threads()) {
                Ok(pool) => pool.run(work),
                // As in `tickets`: the system gives no more threads.
                Err(_) => work(),
            },
        }
    }

    /// Returns the same setting, limited to one thread per piece of work.
    pub(crate) fn at_most(self, pieces: usize) -> Self {
        match self.threads().min(pieces) {
            0 | 1 => Self::Seq,
            n => Self::Threads(n),
        }
    }

    /// Calls `work(i, item)` for every item, each once; where there is one thread, in their order.
    #[doc(hidden)]
    pub fn for_each<T: Send>(self, items: impl Iterator<Item = T>, work: impl Fn(usize, T) + Sync) {
        if self.threads() == 1 {
            items.enumerate().for_each(|(i, item)| work(i, item));
            return;
        }
        let items: Vec<_> = items.map(|item| Mutex::new(Some(item))).collect();
        self.tickets(items.len(), |i| {
            if let Some(item) = items[i].lock().ok().and_then(|mut item| item.take()) {
                work(i, item);
            }
            ControlFlow::Continue(())
        });
    }

    /// Calls [`Par::for_each`] with some of the items at a time, of which each takes so many
    /// `operations`, and asks in between whether to go on.
    ///
    /// # Errors
    /// [`Error::Cancelled`](super::Error::Cancelled).
    pub(crate) fn for_each_asking<T: Send>(
        self,
        mut items: impl Iterator<Item = T>,
        operations: f64,
        work: impl Fn(usize, T) + Sync,
    ) -> super::Result<()> {
        let each = (PIECE as f64 / operations).max(1.0) as usize;
        let mut first = 0;
        loop {
            let some: Vec<T> = items.by_ref().take(each.saturating_mul(self.threads())).collect();
            if some.is_empty() {
                return Ok(());
            }
            let count = some.len();
            self.for_each(some.into_iter(), |i, item| work(first + i, item));
            first += count;
            spend(operations * count.div_ceil(self.threads()) as f64)?;
        }
    }

    /// Returns what `work` returns for `0..size`, `size..2 size`, ... below `n`, in this order.
    #[doc(hidden)]
    pub fn map_blocks<T: Send + Sync>(
        self,
        n: usize,
        size: usize,
        work: impl Fn(Range<usize>) -> T + Sync,
    ) -> Vec<T> {
        let results: Vec<OnceLock<T>> = (0..n.div_ceil(size)).map(|_| OnceLock::new()).collect();
        self.tickets(results.len(), |block| {
            let range = block * size..n.min((block + 1) * size);
            results[block].get_or_init(|| work(range));
            ControlFlow::Continue(())
        });
        results.into_iter().filter_map(OnceLock::into_inner).collect()
    }

    /// Returns what [`Par::map_blocks`] returns, for some blocks at a time, of which each takes so
    /// many `operations`, and asks in between whether to go on.
    ///
    /// # Errors
    /// [`Error::Cancelled`](super::Error::Cancelled).
    #[doc(hidden)]
    pub fn map_blocks_asking<T: Send + Sync>(
        self,
        n: usize,
        size: usize,
        operations: f64,
        work: impl Fn(Range<usize>) -> T + Sync,
    ) -> super::Result<Vec<T>> {
        let mut found: Vec<Option<T>> = (0..n.div_ceil(size)).map(|_| None).collect();
        self.for_each_asking(found.iter_mut(), operations, |block, found| {
            *found = Some(work(block * size..n.min((block + 1) * size)));
        })?;
        Ok(found.into_iter().flatten().collect())
    }

    /// Calls [`tickets`] with workers that have no memory of their own.
    pub fn tickets(self, count: usize, work: impl Fn(usize) -> ControlFlow<()> + Sync) {
        let mut workers = vec![(); self.at_most(count).threads()];
        tickets(&mut workers, count, |(), i| work(i));
    }
}

/// Calls `work(worker, i)` for every ticket `i` in `0..count`, each once, from one thread for each
/// of `workers`; waits for all. Tickets are handed out in ascending order, and none after a
/// `Break`.
///
/// Which worker gets which ticket varies from run to run, so results must not depend on it. The
/// calling thread is the first worker. If no thread is free for another worker, those that run
/// serve its tickets.
pub fn tickets<W: Send>(
    workers: &mut [W],
    count: usize,
    work: impl Fn(&mut W, usize) -> ControlFlow<()> + Sync,
) {
    let next = AtomicUsize::new(0);
    let serve = |worker: &mut W| {
        loop {
            let ticket = next.fetch_add(1, Ordering::Relaxed);
            if ticket >= count {
                return;
            }
            if work(worker, ticket).is_break() {
                next.store(count, Ordering::Relaxed);
            }
        }
    };
    on_threads(workers, &serve);
}

/// Calls `serve` for the first of `workers` on the calling thread, and for others on threads that
/// are free. Compiled once for each kind of worker, not for each work.
fn on_threads<W: Send>(workers: &mut [W], serve: &(dyn Fn(&mut W) + Sync)) {
    let [first, others @ ..] = workers else { return };
    let inside = threads_of_pool();
    let most = others.len().min(inside.unwrap_or(usize::MAX) - 1);
    let others = &mut others[..most];
    if others.is_empty() {
        return serve(first);
    }
    // A callback must not be called while others wait for its thread.
    if inside.is_some() {
        return unwatched(|| {
            rayon::in_place_scope(|scope| {
                for worker in others {
                    scope.spawn(|_| {
                        // The pool is one of the caller, whose threads may have another
                        // environment.
                        let _nearest = FloatEnv::nearest();
                        serve(worker);
                    });
                }
                serve(first);
            });
        });
    }
    // The system may give no more threads: slower, but the same result.
    let Ok(pool) = shared(others.len() + 1) else { return serve(first) };
    let others: Vec<_> = others.iter_mut().map(Mutex::new).collect();
    let help = |i: usize| {
        // Each is locked once.
        if let Ok(mut worker) = others[i].lock() {
            serve(&mut worker);
        }
    };
    unwatched(|| pool.help(others.len(), &help, || serve(first)));
}

/// Returns the number of threads (>= 1) of the rayon pool that the calling thread belongs to.
/// rayon's global pool is not started.
fn threads_of_pool() -> Option<usize> {
    rayon::current_thread_index().map(|_| rayon::current_num_threads().max(1))
}

/// A counter that threads wait for until it has been counted down to zero.
#[derive(Debug)]
pub struct Latch {
    left: AtomicUsize,
    /// Number of threads asleep.
    asleep: Mutex<usize>,
    over: Condvar,
}

impl Latch {
    /// Creates a latch that is over after `count` calls of [`Latch::count_down`].
    pub fn new(count: usize) -> Self {
        Self { left: AtomicUsize::new(count), asleep: Mutex::new(0), over: Condvar::new() }
    }

    /// Counts one piece as done. What its thread wrote is visible to the threads that wait.
    pub fn count_down(&self) {
        if self.left.fetch_sub(1, Ordering::AcqRel) == 1 {
            // Under the lock: a thread that saw a piece left is asleep by now, and is woken.
            let asleep = self.asleep.lock().unwrap_or_else(PoisonError::into_inner);
            if *asleep > 0 {
                self.over.notify_all();
            }
        }
    }

    fn is_over(&self) -> bool {
        self.left.load(Ordering::Acquire) == 0
    }

    /// Waits until the count is zero: spins for some microseconds, because the next piece of work
    /// usually ends that soon, then sleeps.
    pub fn wait(&self) {
        const SPINS: usize = 2000;
        const YIELDS: usize = 20;
        for spin in 0..SPINS + YIELDS {
            if self.is_over() {
                return;
            }
            if spin < SPINS { std::hint::spin_loop() } else { std::thread::yield_now() }
        }
        let mut asleep = self.asleep.lock().unwrap_or_else(PoisonError::into_inner);
        *asleep += 1;
        while !self.is_over() {
            asleep = self.over.wait(asleep).unwrap_or_else(PoisonError::into_inner);
        }
        *asleep -= 1;
    }
}

#[cfg(test)]
mod tests {
    #[cfg(target_os = "linux")]
    use core_affinity::CoreId;

    use super::super::pool::ThreadPool;
    use super::*;

    /// Returns the cores that the calling thread may run on.
    #[cfg(target_os = "linux")]
    fn mask() -> Vec<CoreId> {
        core_affinity::get_core_ids().unwrap()
    }

    /// Returns the affinity masks that threads working at the same time see, with their numbers.
    #[cfg(target_os = "linux")]
    fn masks(threads: usize) -> Vec<(usize, Vec<CoreId>)> {
        let barrier = std::sync::Barrier::new(threads);
        let seen = Mutex::new(Vec::new());
        Par::Threads(threads).tickets(threads, |_| {
            barrier.wait();
            seen.lock().unwrap().push((rayon::current_thread_index().unwrap(), mask()));
            ControlFlow::Continue(())
        });
        seen.into_inner().unwrap()
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn pinned_threads_sit_on_the_cores_of_the_mask_and_the_caller_keeps_its_own() {
        let before = mask();
        for threads in [1, 2, before.len() + 1, 2] {
            let seen = Par::Threads(threads).on_cores(Pin::Cores, || masks(threads));
            assert_eq!(seen.len(), threads);
            for (i, own) in seen {
                assert_eq!(own, [before[i % before.len()]], "thread {i} of {threads}");
            }
            assert_eq!(mask(), before);
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_pool_that_a_pinned_thread_makes_has_all_cores() {
        let all = mask();
        let inside = || Par::Threads(all.len()).on_cores(Pin::Cores, || masks(all.len()));
        let mut seen = Par::Threads(all.len() + 2).on_cores(Pin::Cores, inside);
        seen.sort_by_key(|(i, _)| *i);
        let cores: Vec<_> = seen.into_iter().flat_map(|(_, own)| own).collect();
        assert_eq!(cores, all);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn who_is_not_asked_to_pin_works_on_the_calling_thread() {
        let caller = std::thread::current().id();
        for (par, pin) in [(Par::Threads(2), Pin::No), (Par::Seq, Pin::Cores)] {
            assert_eq!(par.on_cores(pin, || std::thread::current().id()), caller);
        }
    }

    #[test]
    fn inside_of_a_pool_its_threads_work_and_no_others() {
        for threads in [1, 2] {
            let pool = ThreadPool::new(threads, Pin::No).unwrap();
            let own = pool.run(|| {
                assert_eq!(Par::all().threads(), threads.min(allowed_threads()));
                let seen = Mutex::new(Vec::new());
                Par::Threads(4).tickets(50, |_| {
                    seen.lock().unwrap().push(std::thread::current().id());
                    ControlFlow::Continue(())
                });
                let inside = Mutex::new(vec![std::thread::current().id()]);
                rayon::broadcast(|_| inside.lock().unwrap().push(std::thread::current().id()));
                (seen.into_inner().unwrap(), inside.into_inner().unwrap())
            });
            assert!(own.0.len() == 50 && own.0.iter().all(|thread| own.1.contains(thread)));
        }
    }

    #[test]
    fn blocks_come_back_in_order_and_cover_everything() {
        for n in [0, 1, 7, 8, 23] {
            for threads in 1..4 {
                let ranges = Par::Threads(threads).map_blocks(n, 4, |r| r);
                let all: Vec<usize> = ranges.into_iter().flatten().collect();
                assert_eq!(all, (0..n).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn every_ticket_is_served_once_by_any_number_of_workers() {
        for workers in [1, 2, 3, 8] {
            for count in [0, 1, 2, 100] {
                let served: Vec<_> = (0..count).map(|_| AtomicUsize::new(0)).collect();
                let mut own = vec![0_usize; workers];
                tickets(&mut own, count, |own, i| {
                    *own += 1;
                    served[i].fetch_add(1, Ordering::Relaxed);
                    ControlFlow::Continue(())
                });
                assert!(served.iter().all(|s| s.load(Ordering::Relaxed) == 1));
                assert_eq!(own.iter().sum::<usize>(), count);
            }
        }
    }

    #[test]
    fn no_ticket_is_handed_out_after_a_break() {
        let served = AtomicUsize::new(0);
        Par::Seq.tickets(1000, |i| {
            served.fetch_add(1, Ordering::Relaxed);
            if i == 5 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert_eq!(served.into_inner(), 6);
    }

    #[test]
    fn thousands_of_threads_are_capped() {
        let most = Par::MOST_PER_CORE * available_cores();
        assert_eq!(Par::Threads(8000).threads(), most);
        assert_eq!((Par::Threads(0).threads(), Par::Seq.threads()), (1, 1));
    }

    #[test]
    fn who_waits_for_a_latch_sleeps_until_the_last_piece() {
        let latch = Latch::new(2);
        let value = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    latch.wait();
                    assert_eq!(value.load(Ordering::Relaxed), 7);
                });
            }
            latch.count_down();
            // Long enough for the waiting threads to fall asleep.
            std::thread::sleep(std::time::Duration::from_millis(20));
            value.store(7, Ordering::Relaxed);
            latch.count_down();
        });
        Latch::new(0).wait();
    }
}
