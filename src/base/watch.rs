//! The callback that watches a thread, for work that has no progress of its own, and the operations
//! of the thread since it last asked (docs/decisions/0011).

use std::cell::Cell;
use std::ops::ControlFlow;

/// A function that is told the fraction of the work that is done.
pub(super) type Callback<'a> = &'a (dyn Fn(f64) -> ControlFlow<()> + Sync);

/// A callback, and the fraction that it was last told.
#[derive(Clone, Copy)]
struct Watcher {
    callback: Callback<'static>,
    fraction: f64,
}

thread_local! {
    static WATCHER: Cell<Option<Watcher>> = const { Cell::new(None) };
    /// Operations since the last request.
    static SINCE: Cell<f64> = const { Cell::new(0.0) };
}

/// Sets the watcher back when it is dropped.
struct Restored(Option<Watcher>);

impl Drop for Restored {
    fn drop(&mut self) {
        let inner = WATCHER.get();
        let outer = self.0.map(|outer| match inner {
            Some(inner) if std::ptr::addr_eq(inner.callback, outer.callback) => {
                Watcher { fraction: outer.fraction.max(inner.fraction), ..outer }
            }
            _ => outer,
        });
        WATCHER.set(outer);
    }
}

/// Calls `work`, during which the calling thread asks `callback` whether to stop. `fraction` is the
/// last one that the callback got.
pub(super) fn watched<R>(callback: Callback<'_>, fraction: f64, work: impl FnOnce() -> R) -> R {
    // SAFETY: only the lifetime changes. `_restored` takes the reference out of the thread's
    // watcher before this call returns or unwinds. Others have it from `current` only, which asks
    // them not to keep it longer.
    let callback = unsafe { std::mem::transmute::<Callback<'_>, Callback<'static>>(callback) };
    let fraction = match WATCHER.get() {
        Some(outer) if std::ptr::addr_eq(outer.callback, callback) => outer.fraction.max(fraction),
        _ => fraction,
    };
    let _restored = Restored(WATCHER.replace(Some(Watcher { callback, fraction })));
    work()
}

/// Calls `work`, during which the calling thread asks no callback: a callback may call this
/// library, and must not be called where other threads wait for this one.
pub(super) fn unwatched<R>(work: impl FnOnce() -> R) -> R {
    let _restored = Restored(WATCHER.take());
    work()
}

/// Notes that `callback` got this fraction, and could ask to stop.
pub(super) fn reported(callback: Callback<'_>, fraction: f64) {
    if let Some(watcher) = WATCHER.get() {
        if !std::ptr::addr_eq(watcher.callback, callback) {
            return;
        }
        let fraction = watcher.fraction.max(fraction);
        WATCHER.set(Some(Watcher { fraction, ..watcher }));
    }
    SINCE.set(0.0);
}

/// Adds operations to those of the calling thread since the last request, and returns the sum.
pub(super) fn add(operations: f64) -> f64 {
    let since = SINCE.get() + operations;
    SINCE.set(since);
    since
}

/// Tells the callback that watches the calling thread, if there is one, the last fraction again,
/// and returns what it returns.
pub(super) fn ask_again() -> ControlFlow<()> {
    let Some(Watcher { callback, fraction }) = WATCHER.get() else {
        return ControlFlow::Continue(());
    };
    SINCE.set(0.0);
    unwatched(|| callback(fraction))
}

/// Returns whether a callback watches the calling thread.
pub(super) fn is_watched() -> bool {
    WATCHER.get().is_some()
}

/// Returns the callback that watches the calling thread and the fraction that it got last.
///
/// # Safety
/// The callback is not used after the call of this library has returned that asks for it.
pub(super) unsafe fn current<'a>() -> Option<(Callback<'a>, f64)> {
    let Watcher { callback, fraction } = WATCHER.get()?;
    Some((callback, fraction))
}
