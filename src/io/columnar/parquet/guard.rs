//! Panics of crate parquet.

use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::io::columnar::fault::Fault;

/// Returns what `work` returns. The crate panics on some damaged files.
pub fn guarded<R>(work: impl FnOnce() -> Result<R, Fault>) -> Result<R, Fault> {
    let done = catch_unwind(AssertUnwindSafe(work));
    done.unwrap_or_else(|_| Err("damaged".into()))
}
