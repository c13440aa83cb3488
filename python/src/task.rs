//! Runs the work of a call with the interpreter released, so that Ctrl-C and callbacks can end it.
//!
//! Work that takes long runs on a thread of its own. The calling thread waits for it and looks
//! after the interpreter every [`INTERVAL`]: it lets Python handle signals and calls the progress
//! callback. An exception from either is kept, the work is asked to stop, and the exception is
//! raised once the work has stopped: no thread uses the arrays of a call that has returned.

use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use catamaran::base::{FloatEnv, Progress};
use pyo3::prelude::*;

use crate::error::{exception, of_panic};

/// How often signals are handled and progress is told.
const INTERVAL: Duration = Duration::from_millis(50);

/// Steps that a callback is told of: `done` of them.
const TOTAL: u32 = 1000;

/// Multiplications of work that ends within a few milliseconds, and stays on the calling thread.
const SHORT: f64 = 2e7;

/// How long work takes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Length {
    /// A few milliseconds at most: signals can wait for it.
    Short,
    /// Perhaps longer.
    Long,
}

impl Length {
    /// Returns the length of a call of so many multiplications.
    pub fn of(multiplications: f64) -> Self {
        if multiplications < SHORT { Self::Short } else { Self::Long }
    }
}

/// What the worker tells the calling thread, and the other way round.
#[derive(Default)]
struct Watch {
    /// Bits of the fraction that is done.
    fraction: AtomicU64,
    stop: AtomicBool,
    ended: Mutex<bool>,
    end: Condvar,
}

impl Watch {
    /// Notes the progress that the library reports, and tells it to go on or to stop.
    fn update(&self, fraction: f64) -> ControlFlow<()> {
        self.fraction.store(fraction.to_bits(), Ordering::Relaxed);
        match self.stop.load(Ordering::Relaxed) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }

    fn finish(&self) {
        *self.ended.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.end.notify_all();
    }

    /// Waits for the end, or for [`INTERVAL`]; returns whether it is the end.
    fn wait(&self) -> bool {
        let ended = self.ended.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.end.wait_timeout_while(ended, INTERVAL, |ended| !*ended);
        *waited.unwrap_or_else(PoisonError::into_inner).0
    }
}

/// The callback of the caller, `progress(done, total)`.
struct Callback {
    function: Py<PyAny>,
    told: Option<u32>,
}

impl Callback {
    fn tell(&mut self, py: Python<'_>, done: u32) -> PyResult<()> {
        if self.told != Some(done) {
            self.told = Some(done);
            self.function.call1(py, (done, TOTAL))?;
        }
        Ok(())
    }
}

/// Calls `work` with the interpreter released, in the default floating-point environment, and
/// returns what it returns.
///
/// `progress` is None or a callable that is told how much is done: `progress(done, total)`.
pub fn run<R: Send>(
    py: Python<'_>,
    length: Length,
    progress: Option<Py<PyAny>>,
    work: impl FnOnce(Progress<'_>) -> catamaran::Result<R> + Send,
) -> PyResult<R> {
    // The thread that is started below inherits it.
    let _nearest = FloatEnv::nearest();
    if length == Length::Short && progress.is_none() {
        let guarded = || catch_unwind(AssertUnwindSafe(|| work(Progress::none())));
        return flatten(py.detach(guarded));
    }
    let watch = Watch::default();
    let update = |fraction: f64| watch.update(fraction);
    let guarded = || {
        let progress = Progress::new(&update);
        // Also what takes no progress asks.
        let watched = || progress.watch(|| work(progress));
        let found = catch_unwind(AssertUnwindSafe(watched));
        watch.finish();
        found
    };
    let mut callback = progress.map(|function| Callback { function, told: None });
    let mut raised = None;
    let found = py.detach(|| {
        thread::scope(|scope| {
            let worker = thread::Builder::new().name("catamaran".into());
            let worker = worker.spawn_scoped(scope, guarded)?;
            while !watch.wait() {
                if raised.is_some() {
                    continue;
                }
                if let Err(error) = look_after(&watch, callback.as_mut()) {
                    raised = Some(error);
                    watch.stop.store(true, Ordering::Relaxed);
                }
            }
            Ok::<_, std::io::Error>(worker.join().and_then(|found| found))
        })
    })?;
    if let Some(error) = raised {
        return Err(error);
    }
    let found = flatten(found)?;
    if let Some(callback) = &mut callback {
        callback.tell(py, TOTAL)?;
    }
    Ok(found)
}

/// Lets Python handle signals, and tells the progress.
fn look_after(watch: &Watch, callback: Option<&mut Callback>) -> PyResult<()> {
    let looked = Python::try_attach(|py| {
        py.check_signals()?;
        let Some(callback) = callback else { return Ok(()) };
        let fraction = f64::from_bits(watch.fraction.load(Ordering::Relaxed));
        // The end is told once the work has ended.
        callback.tell(py, ((fraction * f64::from(TOTAL)) as u32).min(TOTAL - 1))
    });
    match looked {
        Some(result) => result,
        None => {
            // The interpreter shuts down, which this thread, a daemon, must not enter any more.
            watch.stop.store(true, Ordering::Relaxed);
            loop {
                thread::park();
            }
        }
    }
}

fn flatten<R>(found: thread::Result<catamaran::Result<R>>) -> PyResult<R> {
    match found {
        Ok(result) => result.map_err(exception),
        Err(payload) => Err(of_panic(payload)),
    }
}
