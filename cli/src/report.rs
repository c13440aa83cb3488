//! What goes to stdout and stderr.

use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::Result;

/// Set where another process tells the same.
static QUIET: AtomicBool = AtomicBool::new(false);

/// From now on nothing is reported, and no bar shown.
#[cfg(feature = "mpi")]
pub fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Whether nothing is to be reported.
pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// One line on stdout; a closed pipe is an error, not a panic.
pub fn report(line: std::fmt::Arguments<'_>) -> Result<()> {
    if is_quiet() {
        return Ok(());
    }
    Ok(writeln!(io::stdout(), "{line}")?)
}

/// One line on stderr, after the program's name. It is written at once: other ranks write there too, and what is
/// written in pieces gets mixed with theirs.
pub fn complain(line: std::fmt::Arguments<'_>) {
    // Nobody is left to tell that stderr is closed.
    let _ = io::stderr().write_all(format!("catamaran: {line}\n").as_bytes());
}

/// A time with its unit.
pub fn seconds(time: Duration) -> String {
    match time.as_secs_f64() {
        s if s < 1e-3 => format!("{:.1} us", s * 1e6),
        s if s < 1.0 => format!("{:.1} ms", s * 1e3),
        s => format!("{s:.2} s"),
    }
}
