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

/// One line on stdout. A closed pipe, as in `... --report | head -1`, is no error: nobody is left
/// to tell, and there may be files to write.
pub fn report(line: std::fmt::Arguments<'_>) -> Result<()> {
    if is_quiet() {
        return Ok(());
    }
    match writeln!(io::stdout(), "{line}") {
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        written => Ok(written?),
    }
}

/// One line on stderr, after the program's name. It is written at once: other ranks write there
/// too, and what is written in pieces gets mixed with theirs.
pub fn complain(line: std::fmt::Arguments<'_>) {
    // Nobody is left to tell that stderr is closed.
    let _ = io::stderr().write_all(format!("catamaran: {line}\n").as_bytes());
}

/// A line on stderr about something that is no error; written at once, as those of [`complain`].
pub fn note(line: std::fmt::Arguments<'_>) {
    if !is_quiet() {
        // Nobody is left to tell that stderr is closed.
        let _ = io::stderr().write_all(format!("note: {line}\n").as_bytes());
    }
}

/// An error with its context. What the library says contains what its sources say.
pub fn message(error: &anyhow::Error) -> String {
    let mut message = String::new();
    for cause in error.chain() {
        if !message.is_empty() {
            message += ": ";
        }
        message += &cause.to_string();
        if cause.is::<catamaran::Error>() {
            break;
        }
    }
    message
}

/// A time with its unit.
pub fn seconds(time: Duration) -> String {
    match time.as_secs_f64() {
        s if s < 1e-3 => format!("{:.1} us", s * 1e6),
        s if s < 1.0 => format!("{:.1} ms", s * 1e3),
        s => format!("{s:.2} s"),
    }
}

#[cfg(test)]
mod tests {
    use anyhow::Context;

    use super::*;

    #[test]
    fn a_message_has_the_context_and_no_cause_twice() {
        let refused = || io::Error::from(io::ErrorKind::PermissionDenied);
        let cause = refused().to_string();
        let error = Err::<(), _>(catamaran::Error::io("a.npy", refused())).context("weights");
        assert_eq!(message(&error.unwrap_err()), format!("weights: a.npy: {cause}"));
        let error = Err::<(), _>(refused()).context("weights").unwrap_err();
        assert_eq!(message(&error), format!("weights: {cause}"));
    }
}
