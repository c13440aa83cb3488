//! Errors of the library as Python exceptions, with the sentence of the library.

use std::any::Any;
use std::error::Error as _;
use std::io;

use catamaran::Error;
use pyo3::exceptions::{PyMemoryError, PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;

/// Returns the exception for an error: `ValueError` for arguments and meshes, `OSError` (or what
/// Python has for the cause, such as `FileNotFoundError`) for files, `MemoryError`, and
/// `RuntimeError`; the exception itself for an error of [`raised`].
pub fn exception(error: Error) -> PyErr {
    if let Some(raised) = error.source().and_then(|cause| cause.downcast_ref::<PyErr>()) {
        return Python::attach(|py| raised.clone_ref(py));
    }
    let message = error.to_string();
    match &error {
        Error::Shape { .. }
        | Error::Argument { .. }
        | Error::NonFinite { .. }
        | Error::Mesh { .. } => PyValueError::new_err(message),
        Error::OutOfMemory { .. } => PyMemoryError::new_err(message),
        Error::Io { .. } => match error.source().and_then(|e| e.downcast_ref::<io::Error>()) {
            Some(cause) => io::Error::new(cause.kind(), message).into(),
            None => PyOSError::new_err(message),
        },
        _ => PyRuntimeError::new_err(message),
    }
}

/// Turns an exception of code that the library calls back into an error of the library.
pub fn raised(error: PyErr) -> Error {
    let what = error.to_string();
    Error::Io { path: "Python".into(), line: None, what, cause: Some(error.into()) }
}

/// Returns the exception for a panic, which is a bug of the library.
pub fn of_panic(payload: Box<dyn Any + Send>) -> PyErr {
    let text = payload
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| payload.downcast_ref::<&str>().copied())
        .unwrap_or("panic without a message");
    let message = format!("internal error, please report it: {text}");
    // Its destructor might panic in turn.
    std::mem::forget(payload);
    PyRuntimeError::new_err(message)
}

/// Returns a `ValueError` with a name and a sentence.
pub fn refused(name: &str, why: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(format!("{name}: {why}"))
}
