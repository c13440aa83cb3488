//! Arguments that must be refused.

use std::ffi::CStr;

use catamaran_capi::{CATA_ERR_PANIC, CATA_OK, cata_last_error_message, cata_status};

use super::choices::Choices;

/// What is wrong with a call.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    None,
    Layout,
    Uplo,
    LdA,
    LdB,
    LdC,
    NullA,
    NullB,
    NullC,
    OddA,
    OddC,
    /// A has so many rows that no memory has them.
    Huge,
    /// C is where A is.
    Overlap,
    ShortScratch,
    ScratchIsC,
}

impl Fault {
    pub fn pick(choices: &mut Choices<'_>, possible: &[Fault]) -> Self {
        if choices.one_in(4) { choices.pick(possible) } else { Self::None }
    }

    /// Returns what the message of the error begins with.
    pub fn names(self) -> &'static [&'static str] {
        match self {
            Self::None => &[],
            Self::Layout => &["layout: "],
            Self::Uplo => &["uplo: "],
            Self::LdA => &["lda: "],
            Self::LdB => &["ldb: "],
            Self::LdC => &["ldc: "],
            Self::NullA | Self::OddA => &["a: "],
            Self::NullB => &["b: "],
            Self::NullC | Self::OddC => &["c: "],
            Self::Huge => &["a: ", "b: ", "lda: ", "ldb: ", "c: ", "ldc: ", "weights: "],
            Self::Overlap => &["c: "],
            Self::ShortScratch | Self::ScratchIsC => &["scratch: "],
        }
    }
}

/// Returns the message of this thread's last error.
pub fn message() -> String {
    // SAFETY: NUL-terminated, and no call of this thread fails before it is copied.
    unsafe { CStr::from_ptr(cata_last_error_message()) }.to_string_lossy().into_owned()
}

/// # Panics
/// When a call was not refused with a message that begins with one of the names, or has a field.
pub fn check_refused(what: &str, status: cata_status, names: &[&str]) {
    let message = message();
    assert!(status != CATA_OK, "{what}: accepted, although {names:?} must be refused");
    // The library names a field without the name of its struct.
    let names_it = |name: &&str| match name.strip_prefix("params.") {
        Some(field) => message.contains(field.trim_end_matches(": ")),
        None => message.starts_with(name),
    };
    let named = names.iter().any(names_it);
    assert!(status != CATA_ERR_PANIC && named, "{what}: {status}, {message} instead of {names:?}");
}

/// # Panics
/// When a call was refused.
pub fn check_accepted(what: &str, status: cata_status) {
    assert!(status == CATA_OK, "{what}: {status}, {}", message());
}

/// Returns a pointer that is not aligned.
pub fn odd<T>(pointer: *const T) -> *const T {
    pointer.wrapping_byte_add(1)
}
