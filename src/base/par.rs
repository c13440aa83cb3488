//! Threads: their number, pools of them, and the loop that distributes work among them.

use std::collections::BTreeMap;
use std::ops::{ControlFlow, Range};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, OnceLock, PoisonError};

use core_affinity::CoreId;

#[cfg(feature = "geometry")]
use super::operations::spend;
use super::watch::unwatched;
use super::{Error, Result};

/// How many threads a call may use. Results do not depend on it, bit for bit.
///
/// ```
/// use catamaran::{AtaOptions, Par, ata, faer::Mat};
///
/// let a = Mat::<f64>::from_fn(300, 50, |i, j| (i * j % 17) as f64 / 16.0);
/// let product = |par| {
///     let mut c = Mat::zeros(50, 50);
///     ata(1.0, a.as_ref(), 0.0, c.as_mut(), &AtaOptions::new().par(par)).map(|()| c)
/// };
/// assert_eq!(product(Par::Seq)?, product(Par::Threads(4))?);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Par {
    /// The calling thread only.
    Seq,
    /// At most this many threads (at least 1): those of the rayon pool that the call runs in, or of
    /// a pool made for the call if that pool is smaller. At most [`Par::MOST_PER_CORE`] threads per
    /// core are used, because more would only wait for each other.
    Threads(usize),
}

impl Par {
    /// Largest number of threads per core.
    pub const MOST_PER_CORE: usize = 4;

    /// Returns one thread for each core in the affinity mask of this process.
    pub fn all() -> Self {
        Self::Threads(available_cores())
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

    /// Calls `work(i, item)` for every item, each once, in order on one thread.
    pub(crate) fn for_each<T: Send>(
        self,
        items: impl Iterator<Item = T>,
        work: impl Fn(usize, T) + Sync,
    ) {
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
    /// [`Error::Cancelled`].
    #[cfg(feature = "geometry")]
    pub(crate) fn for_each_asking<T: Send>(
        self,
        mut items: impl Iterator<Item = T>,
        operations: f64,
        work: impl Fn(usize, T) + Sync,
    ) -> Result<()> {
        /// Operations of a thread between two requests.
        const PIECE: f64 = 2.5e7;
        let each = (PIECE / operations).max(1.0) as usize;
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
    pub(crate) fn map_blocks<T: Send + Sync>(
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
    /// [`Error::Cancelled`].
    #[cfg(feature = "geometry")]
    pub(crate) fn map_blocks_asking<T: Send + Sync>(
        self,
        n: usize,
        size: usize,
        operations: f64,
        work: impl Fn(Range<usize>) -> T + Sync,
    ) -> Result<Vec<T>> {
        let mut found: Vec<Option<T>> = (0..n.div_ceil(size)).map(|_| None).collect();
        self.for_each_asking(found.iter_mut(), operations, |block, found| {
            *found = Some(work(block * size..n.min((block + 1) * size)));
        })?;
        Ok(found.into_iter().flatten().collect())
    }

    /// Calls [`tickets`] with workers that have no memory of their own.
    pub(crate) fn tickets(self, count: usize, work: impl Fn(usize) -> ControlFlow<()> + Sync) {
        let mut workers = vec![(); self.at_most(count).threads()];
        tickets(&mut workers, count, |(), i| work(i));
    }
}

/// Calls `work(worker, i)` for every ticket `i` in `0..count`, each once, from one thread for each
/// of `workers`; waits for all. Tickets are handed out in ascending order, and none after a
/// `Break`.
///
/// Which worker gets which ticket varies from run to run, so results must not depend on it. The
/// calling thread is the first worker. If the thread of a worker never starts, the other workers
/// serve its tickets.
pub(crate) fn tickets<W: Send>(
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
    let [first, others @ ..] = workers else { return };
    if others.is_empty() {
        return serve(first);
    }
    let wanted = others.len() + 1;
    let run = |first: &mut W, others: &mut [W]| {
        // A callback must not be called while others wait for its thread.
        unwatched(|| {
            rayon::in_place_scope(|scope| {
                for worker in others {
                    scope.spawn(|_| serve(worker));
                }
                serve(first);
            });
        });
    };
    if enough_threads(wanted) {
        return run(first, others);
    }
    match ThreadPool::new(wanted, Pin::No) {
        Ok(pool) => pool.run(|| run(first, others)),
        // The system gives no more threads: slower, but the same result.
        Err(_) => serve(first),
    }
}

/// Returns whether the rayon pool of the caller, or else the global pool, has at least `wanted`
/// threads. This call starts the global pool; rayon panics where the system refuses its threads.
fn enough_threads(wanted: usize) -> bool {
    std::panic::catch_unwind(rayon::current_num_threads).is_ok_and(|threads| threads >= wanted)
}

/// Returns the number of cores in the affinity mask of this process, at least 1. The mask is read
/// on the first call.
///
/// ```
/// use catamaran::{Par, base::available_cores};
///
/// assert_eq!(Par::all().threads(), available_cores());
/// ```
pub fn available_cores() -> usize {
    // Asking the system takes longer than a small product.
    static CORES: OnceLock<usize> = OnceLock::new();
    *CORES.get_or_init(|| std::thread::available_parallelism().map_or(1, |n| n.get()))
}

/// A counter that threads wait for until it has been counted down to zero.
#[derive(Debug)]
pub(crate) struct Latch {
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

/// Whether threads stay on one core each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Pin {
    /// The operating system may move threads between cores.
    #[default]
    No,
    /// Thread `i` stays on the `i`-th core of the affinity mask (modulo their number), where the
    /// operating system allows it.
    ///
    /// The mask is that of the process at the first call that needs it, as set by `taskset` or by
    /// the binding of `mpirun`. Processes that share a mask share its first cores.
    Cores,
}

/// Returns the cores of the affinity mask in ascending order, or none where the system does not
/// report them. The mask is read once, because a pinned thread sees one core only.
fn cores() -> &'static [CoreId] {
    static CORES: OnceLock<Vec<CoreId>> = OnceLock::new();
    CORES.get_or_init(|| core_affinity::get_core_ids().unwrap_or_default())
}

/// Returns a pool of `threads` pinned threads. Pools are kept, because starting threads takes
/// longer than a small product.
fn pinned(threads: usize) -> Result<Arc<ThreadPool>> {
    static POOLS: Mutex<BTreeMap<usize, Arc<ThreadPool>>> = Mutex::new(BTreeMap::new());
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(pool) = pools.get(&threads) {
        return Ok(pool.clone());
    }
    let pool = Arc::new(ThreadPool::new(threads, Pin::Cores)?);
    pools.insert(threads, pool.clone());
    Ok(pool)
}

/// A group of threads, made once and used for many calls: everything called inside
/// [`ThreadPool::run`] uses these threads and no others.
///
/// ```
/// use catamaran::{AtaOptions, Uplo, ata, base::{Pin, ThreadPool}, faer::Mat};
///
/// let pool = ThreadPool::new(2, Pin::No)?;
/// let (a, mut c) = (Mat::<f64>::identity(6, 3), Mat::zeros(3, 3));
/// let options = AtaOptions::new().threads(2).uplo(Uplo::Both);
/// pool.run(|| ata(1.0, a.as_ref(), 0.0, c.as_mut(), &options))?;
/// assert_eq!(c, Mat::<f64>::identity(3, 3));
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug)]
pub struct ThreadPool {
    pool: rayon::ThreadPool,
}

impl ThreadPool {
    /// Creates a pool of `threads` threads (at least 1).
    ///
    /// # Errors
    /// [`Error::Argument`] when the operating system refuses the threads.
    pub fn new(threads: usize, pin: Pin) -> Result<Self> {
        let mut builder = rayon::ThreadPoolBuilder::new().num_threads(threads.max(1));
        if pin == Pin::Cores {
            let cores = cores();
            builder = builder.start_handler(|i| {
                if !cores.is_empty() {
                    core_affinity::set_for_current(cores[i % cores.len()]);
                }
            });
        }
        let pool =
            builder.build().map_err(|e| Error::Argument { what: "threads", why: e.to_string() })?;
        Ok(Self { pool })
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
}

#[cfg(test)]
mod tests {
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
