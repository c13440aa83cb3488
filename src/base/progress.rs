//! Progress of long work, and requests to stop it.

use std::ops::{ControlFlow, Range};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use super::watch::{self, Callback};
use super::{Error, Result};

/// Reports the fraction of the work that is done to a callback, or does nothing
/// ([`Progress::none`], the default).
///
/// The callback gets a fraction in `[0, 1]` that never decreases, and stops the work soon by
/// returning [`ControlFlow::Break`]; the call then returns [`Error::Cancelled`]. It is called from
/// any thread of the call, but one call at a time, and never while other threads wait for its
/// thread: it may take its time, use rayon, or call this library.
///
/// ```
/// use std::ops::ControlFlow;
/// use catamaran::base::Progress;
///
/// let print = |fraction: f64| {
///     println!("{:.0} %", 100.0 * fraction);
///     ControlFlow::Continue(())
/// };
/// Progress::new(&print).part(0.5..1.0).report(0.5)?; // prints 75 %
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Clone, Copy)]
pub struct Progress<'a> {
    callback: Option<Callback<'a>>,
    start: f64,
    length: f64,
}

impl Default for Progress<'_> {
    fn default() -> Self {
        Self::none()
    }
}

impl std::fmt::Debug for Progress<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(if self.is_watched() { "Progress(callback)" } else { "Progress(none)" })
    }
}

impl<'a, F: Fn(f64) -> ControlFlow<()> + Sync> From<&'a F> for Progress<'a> {
    fn from(callback: &'a F) -> Self {
        Self::new(callback)
    }
}

impl<'a> Progress<'a> {
    /// Returns a progress without a callback of its own: it asks the one that watches the thread
    /// ([`Progress::watch`]), if there is one.
    pub const fn none() -> Self {
        Self { callback: None, start: 0.0, length: 1.0 }
    }

    /// Returns a progress that reports to `callback`.
    ///
    /// ```
    /// use std::ops::ControlFlow;
    /// use catamaran::{Error, base::Progress};
    ///
    /// // Stops the work when half of it is done.
    /// let callback = |fraction: f64| match fraction < 0.5 {
    ///     true => ControlFlow::Continue(()),
    ///     false => ControlFlow::Break(()),
    /// };
    /// let progress = Progress::new(&callback);
    /// assert_eq!(progress.report(0.2), Ok(()));
    /// assert_eq!(progress.report(0.5), Err(Error::Cancelled));
    /// ```
    pub const fn new(callback: Callback<'a>) -> Self {
        Self { callback: Some(callback), start: 0.0, length: 1.0 }
    }

    /// Returns the progress of a part of the work, whose fractions 0 and 1 are `range.start` and
    /// `range.end` of this progress.
    ///
    /// ```
    /// use std::{ops::ControlFlow, sync::Mutex};
    /// use catamaran::base::Progress;
    ///
    /// let last = Mutex::new(0.0);
    /// let callback = |fraction: f64| {
    ///     *last.lock().unwrap() = fraction;
    ///     ControlFlow::Continue(())
    /// };
    /// Progress::new(&callback).part(0.5..1.0).report(0.5)?;
    /// assert_eq!(*last.lock().unwrap(), 0.75);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn part(self, range: Range<f64>) -> Self {
        let start = self.start + range.start * self.length;
        Self { start, length: (range.end - range.start) * self.length, ..self }
    }

    /// Returns whether there is a callback.
    pub const fn is_watched(self) -> bool {
        self.callback.is_some()
    }

    /// Reports that `fraction` of the work is done. For work on several threads there is `Tracker`.
    ///
    /// # Errors
    /// [`Error::Cancelled`] when the callback asks to stop.
    pub fn report(self, fraction: f64) -> Result<()> {
        match self.tell(fraction) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Error::Cancelled),
        }
    }

    /// Reports as [`Progress::report`] does, for callbacks that forward a report: returns what the
    /// callback returns.
    pub fn tell(self, fraction: f64) -> ControlFlow<()> {
        let Some(callback) = self.callback else { return watch::ask_again() };
        let fraction = self.fraction(fraction);
        watch::reported(callback, fraction);
        watch::unwatched(|| callback(fraction))
    }

    /// Returns a fraction of this part as one of the whole work.
    fn fraction(self, fraction: f64) -> f64 {
        (self.start + fraction.clamp(0.0, 1.0) * self.length).clamp(0.0, 1.0)
    }

    /// Calls `work` on the calling thread; every call of this library in it asks this callback
    /// whether to stop, at least every 10^8 floating-point operations, whether or not it takes a
    /// progress of its own. The callback is told the last fraction again where the call does not
    /// know a better one.
    ///
    /// Loops that several threads share do not ask, except by a progress that their call takes:
    /// they are short.
    ///
    /// ```
    /// use std::ops::ControlFlow;
    /// use catamaran::{base::Progress, prelude::*};
    ///
    /// let a = Mat::<f64>::from_fn(1000, 300, |i, j| (i + j) as f64);
    /// let mut c = Mat::<f64>::zeros(300, 300);
    /// let stop = |_: f64| ControlFlow::Break(());
    /// let found = Progress::new(&stop)
    ///     .watch(|| ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &AtaOptions::new().threads(1)));
    /// assert_eq!(found, Err(Error::Cancelled));
    /// # Ok::<(), Error>(())
    /// ```
    pub fn watch<R>(self, work: impl FnOnce() -> R) -> R {
        match self.callback {
            Some(callback) => watch::watched(callback, self.start.clamp(0.0, 1.0), work),
            None => work(),
        }
    }
}

/// Adds up what several threads have done and reports it, one call at a time.
///
/// A thread that finds another thread in the callback continues at once: the next report includes
/// its work. [`Tracker::add`] must be called when no thread waits for the work of the caller: the
/// callback may run other work on this thread.
pub struct Tracker<'a> {
    progress: Progress<'a>,
    total: f64,
    /// The work that is done: the bits of an f64.
    done: AtomicU64,
    /// The work that was reported; held during a call.
    reported: Mutex<f64>,
    cancelled: AtomicBool,
}

impl<'a> Tracker<'a> {
    /// Creates a tracker of `total` units of work, none of which is done.
    ///
    /// Without a callback, the tracker asks the one that watches the calling thread.
    pub fn new(progress: Progress<'a>, total: f64) -> Self {
        let watching = || {
            // SAFETY: the tracker lives in a call inside of `watched`, which waits for its threads.
            let (callback, fraction) = unsafe { watch::current() }?;
            Some(Progress { callback: Some(callback), start: fraction, length: 0.0 })
        };
        match progress.is_watched() {
            true => Self::of(progress, total),
            false => Self::of(watching().unwrap_or(progress), total),
        }
    }

    /// Creates a tracker without a callback, for work that must be completed once it has begun.
    pub fn unwatched() -> Self {
        Self::of(Progress::none(), 0.0)
    }

    fn of(progress: Progress<'a>, total: f64) -> Self {
        Self {
            progress,
            total,
            done: AtomicU64::new(0),
            reported: Mutex::new(0.0),
            cancelled: AtomicBool::new(false),
        }
    }

    /// Adds `work` to what is done, reports the sum unless another thread is reporting, and returns
    /// whether to continue. Nothing is reported after a request to stop.
    pub fn add(&self, work: f64) -> ControlFlow<()> {
        if !self.progress.is_watched() {
            return ControlFlow::Continue(());
        }
        self.state()?;
        let sum = |done: u64| Some((f64::from_bits(done) + work).to_bits());
        // The closure never returns None.
        let _ = self.done.fetch_update(Ordering::Relaxed, Ordering::Relaxed, sum);
        // `try_lock` also refuses a callback that is called from within itself.
        if let Ok(mut reported) = self.reported.try_lock() {
            self.report(&mut reported);
        }
        self.state()
    }

    /// Calls `run` with a progress of its own, whose whole is `work` of this tracker.
    pub fn part<R>(&self, work: f64, run: impl FnOnce(Progress<'_>) -> R) -> R {
        let told = AtomicU64::new(0.0_f64.to_bits());
        let tell = |fraction: f64| {
            let before = f64::from_bits(told.swap(fraction.to_bits(), Ordering::Relaxed));
            self.add(work * (fraction - before))
        };
        run(Progress::new(&tell))
    }

    fn report(&self, reported: &mut f64) {
        // Read under the lock: fractions must not decrease.
        *reported = f64::from_bits(self.done.load(Ordering::Relaxed));
        let fraction = if self.total > 0.0 { *reported / self.total } else { 1.0 };
        if self.progress.tell(fraction).is_break() {
            self.cancelled.store(true, Ordering::Relaxed);
        }
    }

    /// Returns whether to continue.
    pub fn state(&self) -> ControlFlow<()> {
        match self.cancelled.load(Ordering::Relaxed) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }

    /// Reports the work that has not been reported yet. Call it when no thread works any more.
    ///
    /// # Errors
    /// [`Error::Cancelled`] when the callback asked to stop.
    pub fn finish(&self) -> Result<()> {
        let mut reported = self.reported.lock().unwrap_or_else(PoisonError::into_inner);
        let mut done = f64::from_bits(self.done.load(Ordering::Relaxed));
        // The sum of many parts differs from the whole by rounding.
        if (done - self.total).abs() < 1e-9 * self.total {
            done = self.total;
            self.done.store(done.to_bits(), Ordering::Relaxed);
        }
        if self.progress.is_watched() && self.state().is_continue() && *reported < done {
            self.report(&mut reported);
        }
        if let (Some(callback), true) = (self.progress.callback, self.total > 0.0) {
            // Another thread may have been in the callback last.
            watch::reported(callback, self.progress.fraction(done / self.total));
        }
        match self.state() {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Error::Cancelled),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Par;

    #[test]
    fn parts_of_parts_are_parts_of_the_whole() {
        let told = Mutex::new(Vec::new());
        let note = |fraction: f64| {
            told.lock().unwrap().push(fraction);
            ControlFlow::Continue(())
        };
        let half = Progress::new(&note).part(0.5..1.0);
        half.report(0.0).unwrap();
        half.part(0.5..1.0).report(0.5).unwrap();
        half.report(7.0).unwrap();
        assert_eq!(*told.lock().unwrap(), [0.5, 0.875, 1.0]);
        assert!(Progress::none().report(0.3).is_ok());
    }

    #[test]
    fn calls_of_many_threads_never_overlap_and_never_decrease() {
        let inside = AtomicBool::new(false);
        let last = AtomicU64::new(0);
        let callback = |fraction: f64| {
            assert!(!inside.swap(true, Ordering::SeqCst), "two calls at a time");
            let before = f64::from_bits(last.swap(fraction.to_bits(), Ordering::SeqCst));
            assert!(before <= fraction && fraction <= 1.0);
            std::thread::yield_now();
            inside.store(false, Ordering::SeqCst);
            ControlFlow::Continue(())
        };
        let tracker = Tracker::new(Progress::new(&callback), 10_000.0);
        Par::Threads(4).for_each(0..10_000, |_, _| assert!(tracker.add(1.0).is_continue()));
        tracker.finish().unwrap();
        assert_eq!(f64::from_bits(last.into_inner()), 1.0);
    }

    #[test]
    fn a_request_to_stop_is_remembered() {
        let stop = |fraction: f64| {
            if fraction >= 0.5 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let tracker = Tracker::new(Progress::new(&stop), 4.0);
        assert!(tracker.add(1.0).is_continue());
        assert!(tracker.add(1.0).is_break());
        assert!(tracker.state().is_break());
        assert_eq!(tracker.finish(), Err(Error::Cancelled));
    }
}
