//! The boundary between C and Rust: every export that can fail passes through it.

use std::any::Any;
use std::ffi::{CStr, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Once;

use super::message::set_last_message;
use super::regions::Call;
use super::status::{CATA_ERR_ARGUMENT, CATA_ERR_PANIC, CATA_OK, Failure, cata_status};
use catamaran::base::{FloatEnv, use_own_threads_only};

/// Calls `work` in the default floating-point environment; turns its failure, or its panic, into a
/// status and this thread's last message.
pub(super) fn boundary(work: impl FnOnce() -> Result<(), Failure>) -> cata_status {
    let _nearest = FloatEnv::nearest();
    let _call = Call::begin();
    static OWN_THREADS: Once = Once::new();
    OWN_THREADS.call_once(use_own_threads_only);
    // Memory that `work` borrowed mutably is the caller's, and documented as unspecified then.
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => CATA_OK,
        Ok(Err(failure)) => fail(failure),
        Err(payload) => {
            let message = format!("internal error, please report it: {}", panic_text(payload));
            fail(Failure::new(CATA_ERR_PANIC, message))
        }
    }
}

fn fail(Failure { status, message }: Failure) -> cata_status {
    set_last_message(&message);
    status
}

fn panic_text(payload: Box<dyn Any + Send>) -> String {
    let payload = match payload.downcast::<String>() {
        Ok(text) => return *text,
        Err(payload) => payload,
    };
    match payload.downcast::<&'static str>() {
        Ok(text) => (*text).to_owned(),
        Err(other) => {
            // The destructor of the payload might panic in turn.
            std::mem::forget(other);
            "panic without a message".to_owned()
        }
    }
}

/// Returns a copy of a text of C.
///
/// # Safety
/// `text` is NULL or NUL-terminated.
#[cfg(feature = "chapters")]
pub(super) unsafe fn utf8(what: &str, text: *const c_char) -> Result<String, Failure> {
    // SAFETY: clause `texts` (`text`).
    let text = unsafe { self::text(what, text) }?.to_str();
    let not_utf8 = |_| Failure::new(CATA_ERR_ARGUMENT, format!("{what}: must be in UTF-8"));
    Ok(text.map_err(not_utf8)?.to_owned())
}

/// Returns a C string as text.
///
/// # Safety
/// `text` is NULL or NUL-terminated, and stays so for `'a`.
unsafe fn text<'a>(what: &str, text: *const c_char) -> Result<&'a CStr, Failure> {
    if text.is_null() {
        return Err(Failure::null(what));
    }
    // SAFETY: not NULL; clause `texts`: it ends with a NUL and is not written during `'a`.
    Ok(unsafe { CStr::from_ptr(text) })
}

/// Returns a file name of C, which may have any bytes on Unix.
///
/// # Safety
/// As [`text`].
pub(super) unsafe fn path(what: &str, path: *const c_char) -> Result<PathBuf, Failure> {
    // SAFETY: clause `texts` (`path`).
    let path = unsafe { text(what, path) }?;
    if path.is_empty() {
        return Err(Failure::new(CATA_ERR_ARGUMENT, format!("{what}: must not be empty")));
    }
    #[cfg(unix)]
    {
        use std::os::unix::ffi::OsStrExt;
        Ok(std::ffi::OsStr::from_bytes(path.to_bytes()).into())
    }
    #[cfg(not(unix))]
    {
        let not_utf8 = |_| Failure::new(CATA_ERR_ARGUMENT, format!("{what}: must be in UTF-8"));
        Ok(path.to_str().map_err(not_utf8)?.into())
    }
}

#[cfg(test)]
mod tests {
    use super::super::message::last_message;
    use super::super::status::{CATA_ERR_NULL, CATA_ERR_SHAPE};
    use super::*;
    use catamaran::Error;

    fn message() -> String {
        // SAFETY: NUL-terminated, and no call of this thread fails before it is copied.
        unsafe { CStr::from_ptr(last_message()) }.to_str().unwrap().to_owned()
    }

    #[test]
    fn panic_becomes_status() {
        assert_eq!(boundary(|| panic!("number {}", 7)), CATA_ERR_PANIC);
        assert_eq!(message(), "internal error, please report it: number 7");
        assert_eq!(boundary(|| panic!("plain")), CATA_ERR_PANIC);
        assert_eq!(message(), "internal error, please report it: plain");
        assert_eq!(boundary(|| std::panic::panic_any(7)), CATA_ERR_PANIC);
        assert_eq!(message(), "internal error, please report it: panic without a message");
    }

    #[test]
    fn payload_whose_destructor_panics() {
        struct Bomb;
        impl Drop for Bomb {
            fn drop(&mut self) {
                panic!("bomb");
            }
        }
        assert_eq!(boundary(|| std::panic::panic_any(Bomb)), CATA_ERR_PANIC);
    }

    #[test]
    fn panic_of_a_worker_becomes_status() {
        let work = || {
            super::super::internal::on_a_worker(|| panic!("worker"));
            Ok(())
        };
        assert_eq!(boundary(work), CATA_ERR_PANIC);
        assert!(message().contains("worker"), "{}", message());
    }

    #[test]
    fn success_keeps_message() {
        assert_eq!(boundary(|| Err(Failure::null("a"))), CATA_ERR_NULL);
        assert_eq!(boundary(|| Ok(())), CATA_OK);
        assert_eq!(message(), "a: must not be NULL");
    }

    #[test]
    fn error_keeps_its_text() {
        let error = Error::Shape { what: "C", expected: (2, 2), got: (3, 2) };
        assert_eq!(boundary(|| Err(error.clone().into())), CATA_ERR_SHAPE);
        assert_eq!(message(), error.to_string());
    }

    #[test]
    fn message_with_nul_survives() {
        boundary(|| Err(Failure::null("a\0b")));
        assert_eq!(message(), "a\\0b: must not be NULL");
    }

    #[test]
    fn message_is_per_thread() {
        boundary(|| Err(Failure::null("mine")));
        std::thread::spawn(|| {
            assert_eq!(message(), "");
            boundary(|| Err(Failure::null("other")));
        })
        .join()
        .unwrap();
        assert_eq!(message(), "mine: must not be NULL");
    }
}
