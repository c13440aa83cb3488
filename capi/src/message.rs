//! The message of the last failed call of each thread.

use std::cell::RefCell;
use std::ffi::{CString, c_char};

thread_local! {
    static LAST_MESSAGE: RefCell<CString> = RefCell::default();
}

/// Returns this thread's last message.
pub(super) fn last_message() -> *const c_char {
    // The thread-local may be gone while the thread destroys its other thread-locals.
    LAST_MESSAGE.try_with(|m| m.borrow().as_ptr()).unwrap_or(c"".as_ptr())
}

/// Replaces this thread's last message.
pub(super) fn set_last_message(message: &str) {
    let message = CString::new(message.replace('\0', "\\0")).unwrap_or_default();
    let _ = LAST_MESSAGE.try_with(|m| *m.borrow_mut() = message);
}
