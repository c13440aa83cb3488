//! Counts of operations, and requests to stop between them, for work without a progress of its own.

use std::ops::ControlFlow;
use std::panic::resume_unwind;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use super::float_env::FloatEnv;
use super::watch;
use super::{Error, Result};

/// Floating-point operations between two requests: about 5 ms of slow ones.
const BETWEEN: f64 = 1e7;

/// How long a thread waits for another one before it asks again: less than 10^8 operations.
const PAUSE: Duration = Duration::from_millis(2);

/// Counts floating-point operations of the calling thread; estimates are enough. For a search, one
/// step counts as some operations.
pub fn count(operations: f64) {
    watch::add(operations);
    #[cfg(debug_assertions)]
    measure::count(operations);
}

/// Asks the callback that watches the calling thread, if there is one, once in 10^7 operations.
///
/// # Errors
/// [`Error::Cancelled`] when the callback asks to stop.
pub fn ask() -> Result<()> {
    if watch::add(0.0) < BETWEEN { Ok(()) } else { ask_now() }
}

/// Counts operations, and asks as [`ask`] does.
///
/// # Errors
/// [`Error::Cancelled`] when the callback asks to stop.
pub fn spend(operations: f64) -> Result<()> {
    count(operations);
    ask()
}

fn ask_now() -> Result<()> {
    match watch::ask_again() {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::Cancelled),
    }
}

/// Calls `work`, which takes about this many operations and can't ask whether to stop, and returns
/// its result. If that is long and the calling thread is watched, another thread does the work,
/// while the calling thread asks. Nobody waits for that thread once the callback asks to stop: it
/// owns all that it uses.
///
/// # Errors
/// [`Error::Cancelled`] when the callback asks to stop.
pub fn apart<R: Send + 'static>(
    operations: f64,
    work: impl FnOnce() -> R + Send + 'static,
) -> Result<R> {
    if !watch::is_watched() || operations < BETWEEN {
        count(operations);
        return Ok(work());
    }
    let (done, wait) = channel();
    // Not moved into the thread, which may be refused.
    let work = Arc::new(Mutex::new(Some(work)));
    let take = |work: &Mutex<Option<_>>| work.lock().unwrap_or_else(PoisonError::into_inner).take();
    let theirs = Arc::clone(&work);
    let thread = thread::Builder::new().name("catamaran".into()).spawn(move || {
        // Threads inherit the environment of the thread that makes them.
        let _nearest = FloatEnv::nearest();
        if let Some(work) = take(&theirs) {
            // After a request to stop, the receiver is gone.
            let _ = done.send(work());
        }
    });
    let Ok(thread) = thread else {
        let Some(work) = take(&work) else { return Err(Error::Cancelled) };
        count(operations);
        return Ok(work());
    };
    loop {
        match wait.recv_timeout(PAUSE) {
            Ok(found) => return ask_now().map(|()| found),
            Err(RecvTimeoutError::Timeout) => ask_now()?,
            Err(RecvTimeoutError::Disconnected) => match thread.join() {
                Err(panic) => resume_unwind(panic),
                Ok(()) => return Err(Error::Cancelled),
            },
        }
    }
}

/// What a thread has counted: for the tests of all crates, in development builds.
#[cfg(debug_assertions)]
pub mod measure {
    use std::cell::Cell;

    thread_local! {
        static LONGEST: Cell<f64> = const { Cell::new(0.0) };
        static TOTAL: Cell<f64> = const { Cell::new(0.0) };
    }

    pub(super) fn count(operations: f64) {
        LONGEST.set(LONGEST.get().max(super::watch::add(0.0)));
        TOTAL.set(TOTAL.get() + operations);
    }

    /// Returns the most operations between two requests of `work` on this thread, and all of them.
    pub fn operations(work: impl FnOnce()) -> (f64, f64) {
        super::watch::add(-super::watch::add(0.0));
        LONGEST.set(0.0);
        TOTAL.set(0.0);
        work();
        (LONGEST.get(), TOTAL.get())
    }
}
