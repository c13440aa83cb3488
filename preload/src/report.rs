//! What the library prints on standard error at exit: with `CATAMARAN_BLAS_VERBOSE=1` its calls,
//! and by default a line if nothing was gained.

use std::fmt::Write;
use std::sync::atomic::{AtomicBool, Ordering};

use catamaran::kernel::packed::FloatIsa;

use crate::entry::{Entry, called, forwarded_without_gain};
use crate::host::file_of;
use crate::settings::{Settings, complain};
use crate::threads::watch_forks;

/// Makes the process print what the settings ask for when it ends by `exit`.
pub fn at_exit() {
    extern "C" fn print() {
        let settings = Settings::get();
        if settings.verbose {
            print_calls(settings);
        }
        if settings.hints
            && let Some(count) = forwarded_without_gain()
        {
            complain(&hint(count));
        }
    }
    static ASKED: AtomicBool = AtomicBool::new(false);
    if !ASKED.swap(true, Ordering::Relaxed) {
        watch_forks();
        // SAFETY: a function of this library, which is never unloaded.
        unsafe { libc::atexit(print) };
    }
}

/// Prints a line about the process, and one about each symbol.
fn print_calls(settings: &Settings) {
    let (mode, threads) = (settings.mode.name(), settings.threads);
    let memory = match settings.memory {
        Some(bytes) => format!("{} MiB", bytes >> 20),
        None => "any memory".into(),
    };
    complain(&format!("process {}, {mode}, {threads} threads, {memory}", std::process::id()));
    for entry in called() {
        if let Some(line) = line(entry) {
            complain(&line);
        }
    }
}

/// Returns the line that says that nothing was gained.
fn hint(count: u64) -> String {
    format!(
        "nothing gained: auto forwarded all large products ({count}), for which kernels for {} are \
         not expected to be faster (CATAMARAN_BLAS_VERBOSE=1: why, 0: without this line)",
        FloatIsa::best().name()
    )
}

/// Returns the line of a symbol, or `None` when it was not called.
fn line(entry: &Entry) -> Option<String> {
    let ours = entry.ours();
    let reasons: Vec<_> = entry.forwarded().filter(|(_, tally)| tally.calls() > 0).collect();
    let forwarded: u64 = reasons.iter().map(|(_, tally)| tally.calls()).sum();
    if ours.calls() + forwarded == 0 {
        return None;
    }
    let mut line = format!(
        "{}: {} calls, {} computed in {:.6} s",
        entry.name(),
        ours.calls() + forwarded,
        ours.calls(),
        ours.seconds()
    );
    if forwarded > 0 {
        let seconds: f64 = reasons.iter().map(|(_, tally)| tally.seconds()).sum();
        let reasons: Vec<_> =
            reasons.iter().map(|(name, tally)| format!("{name} {}", tally.calls())).collect();
        let file = entry.next(false).map(file_of).unwrap_or_default();
        let _ = write!(
            line,
            ", {forwarded} forwarded in {seconds:.6} s ({}) to {file}",
            reasons.join(", ")
        );
    }
    Some(line)
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use super::*;
    use crate::entry::Why;

    #[test]
    fn a_line_counts_what_was_computed_and_what_was_forwarded_and_why() {
        static ENTRY: Entry = Entry::new(c"strlen");
        assert_eq!(line(&ENTRY), None);
        ENTRY.count_ours(Instant::now());
        assert!(line(&ENTRY).unwrap().starts_with("strlen: 1 calls, 1 computed in 0.0"));
        ENTRY.count_forwarded(Why::Small, Instant::now());
        ENTRY.count_forwarded(Why::Small, Instant::now());
        ENTRY.count_forwarded(Why::Trivial, Instant::now());
        let line = line(&ENTRY).unwrap();
        assert!(line.starts_with("strlen: 4 calls, 1 computed in "), "{line}");
        assert!(line.contains(", 3 forwarded in "), "{line}");
        assert!(line.contains(" s (trivial 1, small 2) to "), "{line}");
        assert!(line.contains("libc"), "{line}");
    }
}
