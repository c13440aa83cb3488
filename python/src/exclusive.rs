//! Values that one thread at a time uses, while the interpreter is released.

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread::{self, ThreadId};
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// Time between two attempts to take a value that another thread uses.
const PAUSE: Duration = Duration::from_millis(1);

/// A value of a Python object. A call that works with the interpreter released holds it to its end,
/// and calls of other threads wait.
pub struct Exclusive<T> {
    value: Mutex<T>,
    /// The thread that uses the value.
    user: Mutex<Option<ThreadId>>,
}

impl<T> Exclusive<T> {
    pub fn new(value: T) -> Self {
        Self { value: Mutex::new(value), user: Mutex::new(None) }
    }

    /// Waits until no other thread uses the value; Ctrl-C ends the wait.
    ///
    /// # Errors
    /// `RuntimeError` if this thread uses it already, as in a progress callback: it would wait for
    /// itself.
    pub fn lock(&self, py: Python<'_>) -> PyResult<Guard<'_, T>> {
        loop {
            let value = match self.value.try_lock() {
                Ok(value) => value,
                Err(TryLockError::Poisoned(value)) => value.into_inner(),
                Err(TryLockError::WouldBlock) => {
                    if *self.user() == Some(thread::current().id()) {
                        return Err(PyRuntimeError::new_err(
                            "this object is in use by the call that this call is made from",
                        ));
                    }
                    py.check_signals()?;
                    py.detach(|| thread::sleep(PAUSE));
                    continue;
                }
            };
            *self.user() = Some(thread::current().id());
            return Ok(Guard { of: self, value });
        }
    }

    fn user(&self) -> MutexGuard<'_, Option<ThreadId>> {
        self.user.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The use of a value by one thread.
pub struct Guard<'a, T> {
    of: &'a Exclusive<T>,
    value: MutexGuard<'a, T>,
}

impl<T> Deref for Guard<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

impl<T> DerefMut for Guard<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.value
    }
}

impl<T> Drop for Guard<'_, T> {
    fn drop(&mut self) {
        // Before the value is released: afterwards it may have another user.
        *self.of.user() = None;
    }
}
