use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::{Error, Result};

/// How many threads a call may use. Results do not depend on it, bit for bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Par {
    /// The calling thread only.
    Seq,
    /// At most this many threads (at least 1): those of the rayon pool the call runs in, or a pool
    /// made for the call when that one is smaller.
    Threads(usize),
}

impl Par {
    /// All cores in the affinity mask of this process.
    pub fn all() -> Self {
        Self::Threads(available_cores())
    }

    /// The number of threads.
    pub fn threads(self) -> usize {
        match self {
            Self::Seq => 1,
            Self::Threads(n) => n.max(1),
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
        let next = AtomicUsize::new(0);
        Self::Threads(self.threads().min(items.len())).run_lanes(|_| {
            loop {
                let i = next.fetch_add(1, Ordering::Relaxed);
                let Some(item) = items.get(i) else { return };
                if let Some(item) = item.lock().ok().and_then(|mut item| item.take()) {
                    work(i, item);
                }
            }
        });
    }

    /// Runs `lane(0), ..., lane(n - 1)` on up to `n = self.threads()` threads and waits for all.
    pub(crate) fn run_lanes(self, lane: impl Fn(usize) + Sync) {
        let lanes = self.threads();
        let run = || {
            rayon::in_place_scope(|scope| {
                for i in 1..lanes {
                    let lane = &lane;
                    scope.spawn(move |_| lane(i));
                }
                lane(0);
            });
        };
        if lanes == 1 {
            lane(0);
        } else if enough_threads(lanes) {
            run();
        } else {
            match Team::new(lanes, Pin::No) {
                Ok(team) => team.run(run),
                // No more threads to be had: slower, but the same result.
                Err(_) => (0..lanes).for_each(lane),
            }
        }
    }
}

/// Whether the rayon pool that the caller is in, or else the global one, has that many. The global
/// pool is started by this; where the system refuses its threads, rayon panics.
fn enough_threads(lanes: usize) -> bool {
    std::panic::catch_unwind(rayon::current_num_threads).is_ok_and(|threads| threads >= lanes)
}

/// The number of cores in the affinity mask of this process, at least 1.
pub fn available_cores() -> usize {
    std::thread::available_parallelism().map_or(1, |n| n.get())
}

/// Whether the threads of a [`Team`] stay on one core each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pin {
    /// The operating system moves them as it likes.
    No,
    /// Thread `i` stays on the `i`-th core of the affinity mask (modulo their number).
    Cores,
}

/// A group of threads, made once and used for many calls: everything called inside
/// [`Team::run`] uses these threads and no others.
#[derive(Debug)]
pub struct Team {
    pool: rayon::ThreadPool,
}

impl Team {
    /// A team of `threads` threads (at least 1).
    ///
    /// # Errors
    /// [`Error::Argument`] when the operating system gives no more threads.
    pub fn new(threads: usize, pin: Pin) -> Result<Self> {
        let mut builder = rayon::ThreadPoolBuilder::new().num_threads(threads.max(1));
        if pin == Pin::Cores {
            let cores = core_affinity::get_core_ids().unwrap_or_default();
            builder = builder.start_handler(move |i| {
                if !cores.is_empty() {
                    core_affinity::set_for_current(cores[i % cores.len()]);
                }
            });
        }
        let pool =
            builder.build().map_err(|e| Error::Argument { what: "threads", why: e.to_string() })?;
        Ok(Self { pool })
    }

    /// Calls `work` on a thread of the team.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.pool.install(work)
    }
}
