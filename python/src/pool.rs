//! Threads in processes that were forked: the threads of the global pool stay with the parent.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use catamaran::Par;
use catamaran::base::{Pin, ThreadPool};

/// The process that imported the module; 0 before.
static FIRST: AtomicU32 = AtomicU32::new(0);

/// The pool of a forked process, and its number. The first process never locks it, so that no fork
/// finds it locked, unless a forked process forks again while another one of its threads starts
/// the pool.
static OF_CHILD: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// Remembers the process that imports the module.
pub fn remember_process() {
    FIRST.store(std::process::id(), Ordering::Relaxed);
}

/// Calls `work` where its threads are: as it is, or in a pool of this process after a fork.
pub fn with_threads<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    let process = std::process::id();
    if FIRST.load(Ordering::Relaxed) == process {
        return work();
    }
    match of_child(process) {
        Some(pool) => pool.run(work),
        None => work(),
    }
}

fn of_child(process: u32) -> Option<Arc<ThreadPool>> {
    let mut known = OF_CHILD.lock().unwrap_or_else(PoisonError::into_inner);
    match &*known {
        Some((owner, pool)) if *owner == process => Some(pool.clone()),
        _ => {
            let pool = Arc::new(ThreadPool::new(Par::all().threads(), Pin::No).ok()?);
            // The pool of the parent has no threads here, and is never dropped: that would wait.
            if let Some((_, parents)) = known.replace((process, pool.clone())) {
                std::mem::forget(parents);
            }
            Some(pool)
        }
    }
}
