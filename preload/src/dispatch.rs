//! The way of a call: computed here, or forwarded.

use std::time::Instant;

use catamaran::blas::BlasReal;

use crate::arguments::Wrong;
use crate::entry::{Entry, Why};
use crate::host::Code;
use crate::request::Request;
use crate::settings::{Settings, complain};
use crate::{policy, product, report};

/// Computes the request, or calls `forward` with the address of the symbol in the next library.
/// Where no library is next, everything is computed here.
///
/// # Safety
/// The caller of BLAS owns the memory that the request names for the length of this call; `forward`
/// takes the address for what it is.
pub unsafe fn call<T: BlasReal>(
    entry: &'static Entry,
    request: Result<Request<T>, Wrong>,
    forward: &dyn Fn(Code),
) {
    let settings = Settings::get();
    if settings.verbose {
        report::at_exit();
    }
    let start = settings.verbose.then(Instant::now);
    // SAFETY: the caller's promise.
    let why = match unsafe { attempt(&request, settings) } {
        Ok(()) => {
            if let Some(start) = start {
                entry.count_ours(start);
            }
            return;
        }
        Err(why) => why,
    };
    if let Some(next) = entry.next(settings.forwards_small()) {
        forward(next);
        if let Some(start) = start {
            entry.count_forwarded(why, start);
        }
        return;
    }
    // SAFETY: the caller's promise.
    unsafe { alone(entry, &request, settings) };
    if let Some(start) = start {
        entry.count_ours(start);
    }
}

/// # Safety
/// As [`call`].
unsafe fn attempt<T: BlasReal>(
    request: &Result<Request<T>, Wrong>,
    settings: &Settings,
) -> Result<(), Why> {
    let request = request.as_ref().map_err(|_| Why::Arguments)?;
    let plan = policy::decide(request, settings)?;
    // SAFETY: the caller's promise; requests that overlap get no plan.
    unsafe { product::compute(request, &plan, settings.threads) }.map_err(|_| Why::Memory)
}

/// Does what the next library would have done.
///
/// # Safety
/// As [`call`].
unsafe fn alone<T: BlasReal>(
    entry: &Entry,
    request: &Result<Request<T>, Wrong>,
    settings: &Settings,
) {
    let name = entry.name();
    let request = match request {
        Ok(request) => request,
        Err(Wrong(number)) => {
            return complain(&format!("{name}: parameter number {number} has an illegal value"));
        }
    };
    let done = policy::plan(request, settings).and_then(|plan| {
        // SAFETY: the caller's promise.
        unsafe {
            if request.overlaps() {
                product::compute_apart(request, &plan)
            } else {
                product::compute(request, &plan, settings.threads)
            }
        }
    });
    if let Err(error) = done {
        complain(&format!("{name}: {error}, and no other library has this symbol"));
    }
}
