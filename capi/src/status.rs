//! # Status, version, memory
//!
//! Functions that can fail return a status. Others report the capabilities and the version of the
//! build, or release the scratch memory and the threads that are kept between calls.
//!
//! ```c
//! if (cata_memory_release() != CATA_OK) {
//!     fprintf(stderr, "%s\n", cata_last_error_message());
//! }
//! printf("catamaran %s\n", cata_version_string());
//! ```

use std::ffi::{CStr, c_char};
use std::fmt::Display;

use super::message::last_message;
use catamaran::Error;

/// What a call returns. A value with a meaning keeps it forever.
pub type cata_status = i32;

/// Done.
pub const CATA_OK: cata_status = 0;
/// A pointer is NULL where it may not be.
pub const CATA_ERR_NULL: cata_status = 1;
/// A size is too small, does not fit, or overflows.
pub const CATA_ERR_SHAPE: cata_status = 2;
/// An argument is outside its range.
pub const CATA_ERR_ARGUMENT: cata_status = 3;
/// A NaN or an infinity where only finite numbers are allowed.
pub const CATA_ERR_NON_FINITE: cata_status = 4;
/// An iteration ended before it reached its tolerance.
pub const CATA_ERR_NOT_CONVERGED: cata_status = 5;
/// A file could not be read or written.
pub const CATA_ERR_IO: cata_status = 6;
/// Memory could not be allocated.
pub const CATA_ERR_OUT_OF_MEMORY: cata_status = 7;
/// A BLAS back end could not be loaded, or refused a request.
pub const CATA_ERR_BACKEND: cata_status = 8;
/// The progress callback asked to stop.
pub const CATA_ERR_CANCELLED: cata_status = 9;
/// This build or version can't do it (cata_capabilities).
pub const CATA_ERR_UNSUPPORTED: cata_status = 10;
/// A bug in Catamaran, caught; the library stays usable.
pub const CATA_ERR_PANIC: cata_status = 11;
/// Another rank failed, or its arguments disagree; the message names it.
pub const CATA_ERR_RANK: cata_status = 12;
/// A mesh or plant is invalid; the message names the element.
pub const CATA_ERR_MESH: cata_status = 13;

/// Returns the message of the last call of this thread that failed, in UTF-8, NUL-terminated; empty
/// when none has. A call that succeeds leaves it alone. Never NULL.
///
/// The pointer is valid until the next call of this thread that fails, and not after the
/// thread's end; do not free it.
#[unsafe(no_mangle)]
pub extern "C" fn cata_last_error_message() -> *const c_char {
    last_message()
}

/// Returns the name of a status, such as "CATA_ERR_SHAPE"; "unknown status" for any other value.
/// Static, never NULL; do not free it.
#[unsafe(no_mangle)]
pub extern "C" fn cata_status_name(status: cata_status) -> *const c_char {
    name(status).as_ptr()
}

fn name(status: cata_status) -> &'static CStr {
    match status {
        CATA_OK => c"CATA_OK",
        CATA_ERR_NULL => c"CATA_ERR_NULL",
        CATA_ERR_SHAPE => c"CATA_ERR_SHAPE",
        CATA_ERR_ARGUMENT => c"CATA_ERR_ARGUMENT",
        CATA_ERR_NON_FINITE => c"CATA_ERR_NON_FINITE",
        CATA_ERR_NOT_CONVERGED => c"CATA_ERR_NOT_CONVERGED",
        CATA_ERR_IO => c"CATA_ERR_IO",
        CATA_ERR_OUT_OF_MEMORY => c"CATA_ERR_OUT_OF_MEMORY",
        CATA_ERR_BACKEND => c"CATA_ERR_BACKEND",
        CATA_ERR_CANCELLED => c"CATA_ERR_CANCELLED",
        CATA_ERR_UNSUPPORTED => c"CATA_ERR_UNSUPPORTED",
        CATA_ERR_PANIC => c"CATA_ERR_PANIC",
        CATA_ERR_RANK => c"CATA_ERR_RANK",
        CATA_ERR_MESH => c"CATA_ERR_MESH",
        _ => c"unknown status",
    }
}

/// Why a call fails: its status and its message.
#[derive(Debug)]
pub(super) struct Failure {
    pub(super) status: cata_status,
    pub(super) message: String,
}

impl Failure {
    pub(super) fn new(status: cata_status, message: impl Into<String>) -> Self {
        Self { status, message: message.into() }
    }

    /// Returns the failure of a value that an argument, or a field, may not have.
    pub(super) fn argument(what: &str, must_be: impl Display, is: impl Display) -> Self {
        Self::new(CATA_ERR_ARGUMENT, format!("{what}: must be {must_be}, is {is}"))
    }

    /// Returns the failure of a number of one of `count` things, named `things`, that has to be
    /// less.
    #[cfg(feature = "chapters")]
    pub(super) fn beyond(what: &str, count: usize, things: &str, is: impl Display) -> Self {
        Self::argument(what, format!("less than {count} ({things})"), is)
    }

    /// Returns the same failure, of one of several things whose arguments have the same names.
    #[cfg(feature = "chapters")]
    pub(super) fn of(self, what: &str) -> Self {
        Self::new(self.status, format!("{what}: {}", self.message))
    }

    pub(super) fn null(what: &str) -> Self {
        Self::new(CATA_ERR_NULL, format!("{what}: must not be NULL"))
    }

    /// Returns the failure of a call that needs a feature, with the option of CMake that builds it
    /// in.
    #[cfg(not(all(feature = "mpi", feature = "openblas", feature = "opencl")))]
    pub(super) fn absent(feature: &str) -> Self {
        let option = feature.to_uppercase();
        let why = format!("built without the feature {feature} (CMake: CATAMARAN_{option}=ON)");
        Self::new(CATA_ERR_UNSUPPORTED, why)
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let status = match &error {
            Error::Shape { .. } => CATA_ERR_SHAPE,
            Error::Argument { .. } => CATA_ERR_ARGUMENT,
            Error::NonFinite { .. } => CATA_ERR_NON_FINITE,
            Error::NotConverged { .. } => CATA_ERR_NOT_CONVERGED,
            Error::Io { .. } => CATA_ERR_IO,
            Error::OutOfMemory { .. } => CATA_ERR_OUT_OF_MEMORY,
            Error::Backend { .. } => CATA_ERR_BACKEND,
            Error::Rank { .. } => CATA_ERR_RANK,
            Error::Mesh { .. } => CATA_ERR_MESH,
            Error::Cancelled => CATA_ERR_CANCELLED,
            _ => unreachable!("a kind of error without a value of its own: {error}"),
        };
        Self::new(status, error.to_string())
    }
}
