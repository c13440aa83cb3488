//! The threads of this library, for one call at a time.
//!
//! A call that finds them busy computes on its own thread: a program that calls from many threads
//! at once uses the cores already.

use std::sync::atomic::{AtomicBool, Ordering};

use catamaran::Par;

use crate::entry::forget_calls;

/// Whether a call uses the threads.
static BUSY: AtomicBool = AtomicBool::new(false);

/// Calls `work` with `wanted` threads if they are idle, else with the thread of the caller, and
/// returns its result.
pub fn run<R>(wanted: usize, work: impl FnOnce(Par) -> R) -> R {
    if wanted > 1
        && let Some(_turn) = Turn::take()
    {
        return work(Par::Threads(wanted));
    }
    work(Par::Seq)
}

/// The use of the threads until it is dropped.
struct Turn(());

impl Turn {
    fn take() -> Option<Self> {
        watch_forks();
        (!BUSY.swap(true, Ordering::Acquire)).then_some(Self(()))
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        BUSY.store(false, Ordering::Release);
    }
}

/// Makes children forget the calls of their parent, also those that run.
pub fn watch_forks() {
    extern "C" fn in_child() {
        BUSY.store(false, Ordering::Release);
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
