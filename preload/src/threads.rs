//! The threads of this library, for one call at a time.
//!
//! A call that finds them busy computes on its own thread: a program that calls from many threads
//! at once uses the cores already. A process that is forked gets new threads when it needs them.

use std::ptr;
use std::sync::atomic::{AtomicBool, AtomicPtr, Ordering};

use catamaran::Par;
use catamaran::base::{Pin, ThreadPool};

use crate::entry::forget_calls;

struct Pool {
    threads: ThreadPool,
    busy: AtomicBool,
}

/// The threads of this process; null before the first call, and in a child. Never freed.
static POOL: AtomicPtr<Pool> = AtomicPtr::new(ptr::null_mut());

/// Calls `work` with `wanted` threads if they are idle, else with the thread of the caller, and
/// returns its result.
pub fn run<R: Send>(wanted: usize, work: impl FnOnce(Par) -> R + Send) -> R {
    if wanted > 1
        && let Some(pool) = pool(wanted)
        && let Some(_turn) = Turn::take(&pool.busy)
    {
        return pool.threads.run(|| work(Par::Threads(wanted)));
    }
    work(Par::Seq)
}

/// The use of the threads until it is dropped.
struct Turn<'a>(&'a AtomicBool);

impl<'a> Turn<'a> {
    fn take(busy: &'a AtomicBool) -> Option<Self> {
        (!busy.swap(true, Ordering::Acquire)).then_some(Self(busy))
    }
}

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Release);
    }
}

/// Returns the threads, `count` of them, or `None` where the system refuses them.
fn pool(count: usize) -> Option<&'static Pool> {
    let existing = POOL.load(Ordering::Acquire);
    if !existing.is_null() {
        // SAFETY: never freed once it is there.
        return Some(unsafe { &*existing });
    }
    watch_forks();
    let threads = ThreadPool::new(count, Pin::No).ok()?;
    let pool = Box::into_raw(Box::new(Pool { threads, busy: AtomicBool::new(false) }));
    match POOL.compare_exchange(ptr::null_mut(), pool, Ordering::AcqRel, Ordering::Acquire) {
        // SAFETY: as above.
        Ok(_) => Some(unsafe { &*pool }),
        Err(other) => {
            // SAFETY: no other thread has seen this pool; as above.
            unsafe {
                drop(Box::from_raw(pool));
                Some(&*other)
            }
        }
    }
}

/// Makes children forget the threads, which they do not have, and the calls of their parent.
pub fn watch_forks() {
    extern "C" fn in_child() {
        POOL.store(ptr::null_mut(), Ordering::Release);
        forget_calls();
    }
    static WATCHED: AtomicBool = AtomicBool::new(false);
    if !WATCHED.swap(true, Ordering::Relaxed) {
        // SAFETY: the handler only writes to atomics; this library is never unloaded.
        unsafe { libc::pthread_atfork(None, None, Some(in_child)) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_call_at_a_time_has_the_threads() {
        let inner = run(2, |par| (par, run(2, |par| par)));
        assert_eq!(inner, (Par::Threads(2), Par::Seq));
        assert_eq!(run(1, |par| par), Par::Seq);
        assert_eq!(run(2, |par| par), Par::Threads(2));
    }
}
