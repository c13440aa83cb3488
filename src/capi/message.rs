//! The message of the last call of each thread that failed.

use std::cell::RefCell;
use std::ffi::{CString, c_char};

thread_local! {
    static LAST_MESSAGE: RefCell<CString> = RefCell::default();
}

/// This thread's last message.
pub(super) fn last_message() -> *const c_char {
    // The thread-local is gone while the thread's other thread-locals are being destroyed.
    LAST_MESSAGE.try_with(|m| m.borrow().as_ptr()).unwrap_or(c"".as_ptr())
}

/// Replaces this thread's last message.
pub(super) fn set_last_message(message: &str) {
    let message = CString::new(message.replace('\0', "\\0")).unwrap_or_default();
    let _ = LAST_MESSAGE.try_with(|m| *m.borrow_mut() = message);
}
