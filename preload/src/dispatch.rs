//! Decides whether a call is computed here or forwarded.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use catamaran::base::FloatEnv;

use crate::arguments::Wrong;
use crate::element::Element;
use crate::entry::{Entry, Why, count_large_forwarded, gain};
use crate::host::Code;
use crate::request::Request;
use crate::settings::{Mode, Settings, complain};
use crate::{policy, product, report};

/// Computes the request, or calls `forward` with the address of the symbol in the next library.
/// Where no library is next, everything is computed here.
///
/// # Safety
/// The caller of BLAS owns the memory that the request names for the length of this call. `forward`
/// calls the address by the type of the symbol.
pub unsafe fn call<T: Element>(
    entry: &'static Entry,
    request: Result<Request<T>, Wrong>,
    forward: &dyn Fn(Code),
) {
    let settings = Settings::get();
    if settings.verbose {
        report::at_exit();
    }
    let start = settings.verbose.then(Instant::now);
    // SAFETY: `attempt` has the contract of this function, that the caller of BLAS owns the memory.
    let why = match unsafe { attempt(&request, settings) } {
        Ok(()) => {
            gain();
            if let Some(start) = start {
                entry.count_ours(start);
            }
            return;
        }
        Err(why) => why,
    };
    if let Some(next) = entry.next(settings.forwards_small()) {
        warn_of_other_bytes(entry, why, settings);
        if settings.mode == Mode::Auto && why == Why::Slower {
            count_large_forwarded();
            if settings.hints {
                report::at_exit();
            }
        }
        forward(next);
        if let Some(start) = start {
            entry.count_forwarded(why, start);
        }
        return;
    }
    // SAFETY: `alone` has the contract of this function, that the caller of BLAS owns the memory.
    unsafe { alone(entry, &request, settings) };
    if let Some(start) = start {
        entry.count_ours(start);
    }
}

/// Warns once that a product is forwarded although the mode promises our own results.
fn warn_of_other_bytes(entry: &Entry, why: Why, settings: &Settings) {
    static SAID: AtomicBool = AtomicBool::new(false);
    let ours = matches!(settings.mode, Mode::Reproducible | Mode::Max);
    let what = match why {
        Why::Memory => "it takes more than CATAMARAN_BLAS_MEMORY",
        Why::Overlap => "its result shares memory with an operand",
        _ => return,
    };
    if ours && !SAID.swap(true, Ordering::Relaxed) {
        let (name, mode) = (entry.name(), settings.mode.name());
        complain(&format!("{name}: forwarded in spite of mode {mode}: {what} (reported once)"));
    }
}

/// Computes the request to nearest, or returns why it is forwarded.
///
/// # Safety
/// As [`call`].
unsafe fn attempt<T: Element>(
    request: &Result<Request<T>, Wrong>,
    settings: &Settings,
) -> Result<(), Why> {
    let request = request.as_ref().map_err(|_| Why::Arguments)?;
    if settings.mode == Mode::Auto && !FloatEnv::is_default() {
        return Err(Why::Rounding);
    }
    let _nearest = FloatEnv::nearest();
    let plan = policy::decide(request, settings)?;
    // SAFETY: the caller of BLAS owns the memory, by the contract, and `policy::decide` gives
    // requests whose C overlaps an operand no plan.
    unsafe { product::compute(request, &plan, settings.threads) }.map_err(|_| Why::Memory)
}

/// Does what the next library would do: computes the product, or reports the wrong argument.
///
/// # Safety
/// As [`call`].
unsafe fn alone<T: Element>(
    entry: &Entry,
    request: &Result<Request<T>, Wrong>,
    settings: &Settings,
) {
    let _nearest = FloatEnv::nearest();
    let name = entry.name();
    let request = match request {
        Ok(request) => request,
        Err(Wrong(number)) => {
            return complain(&format!("{name}: parameter number {number} has an illegal value"));
        }
    };
    if request.is_trivial() && request.beta == T::ONE {
        return;
    }
    let done = policy::plan(request, settings).and_then(|plan| {
        // SAFETY: the caller of BLAS owns the memory, by the contract; `compute` gets only requests
        // whose C overlaps no operand.
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
