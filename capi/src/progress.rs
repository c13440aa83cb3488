//! # Threads and progress
//!
//! ```c
//! static int32_t tell(double fraction, void *wanted)
//! {
//!     fprintf(stderr, "\r%3.0f %%", 100 * fraction);
//!     return *(int *)wanted == 0; // 1: stop
//! }
//! ```

use std::ffi::c_void;
use std::ops::ControlFlow;

#[cfg(feature = "chapters")]
use super::status::Failure;
use catamaran::base::{Par, Progress};

/// A progress callback: `fraction` of the work done, in [0, 1]. Returns 0 to continue; anything
/// else asks to stop soon, and the call then returns CATA_ERR_CANCELLED.
///
/// It is called from any thread that works for the call, one call at a time: each begins after
/// the one before it has returned, and sees what that has written. No thread waits for it, so it
/// may be slow, and it may call this library. It must not leave by longjmp or a C++ exception.
pub type cata_progress = Option<extern "C" fn(fraction: f64, user: *mut c_void) -> i32>;

/// The `user` pointer of a progress callback.
#[derive(Clone, Copy)]
struct User(*mut c_void);

// SAFETY: clause `callbacks`: the pointer is only passed to the callback, on any thread.
unsafe impl Send for User {}
// SAFETY: clause `callbacks`: calls never overlap and are ordered, as `Progress` promises.
unsafe impl Sync for User {}

impl User {
    fn get(&self) -> *mut c_void {
        self.0
    }
}

/// The progress callback of a caller, and what it gets.
#[derive(Clone, Copy)]
pub(super) struct Caller {
    progress: cata_progress,
    user: User,
}

impl Caller {
    pub(super) fn new(progress: cata_progress, user: *mut c_void) -> Self {
        Self { progress, user: User(user) }
    }

    /// Calls `work` with the callback as a progress.
    pub(super) fn with<R>(self, work: impl FnOnce(Progress<'_>) -> R) -> R {
        let Some(callback) = self.progress else { return work(Progress::none()) };
        let watch = |fraction| match callback(fraction, self.user.get()) {
            0 => ControlFlow::Continue(()),
            _ => ControlFlow::Break(()),
        };
        work(Progress::from(&watch))
    }

    /// Calls `work` with the callback as a progress. Every call of the library in it asks the
    /// callback whether to stop.
    pub(super) fn watch<R>(self, work: impl FnOnce(Progress<'_>) -> R) -> R {
        self.with(|progress| progress.watch(|| work(progress)))
    }

    /// Calls `work`, which asks the callback whether to stop, after it was told that all is done.
    #[cfg(feature = "chapters")]
    pub(super) fn watch_the_end<R>(self, work: impl FnOnce() -> R) -> R {
        self.with(|progress| progress.part(1.0..1.0).watch(work))
    }

    /// Calls `work` with the callback as a progress, and reports the beginning and the end.
    #[cfg(feature = "chapters")]
    pub(super) fn reported<R>(
        self,
        work: impl FnOnce(Progress<'_>) -> Result<R, Failure>,
    ) -> Result<R, Failure> {
        self.watch(|progress| reported(progress, || work(progress)))
    }
}

/// Calls `work`, which reports nothing, and reports its beginning and its end.
#[cfg(feature = "chapters")]
pub(super) fn reported<R, E>(
    progress: Progress<'_>,
    work: impl FnOnce() -> Result<R, E>,
) -> Result<R, Failure>
where
    Failure: From<E>,
{
    progress.report(0.0)?;
    let found = work()?;
    progress.report(1.0)?;
    Ok(found)
}

/// Returns the threads of a field of that name: 0 stands for all.
pub(super) fn par(threads: usize) -> Par {
    if threads == 0 { Par::all() } else { Par::Threads(threads) }
}
