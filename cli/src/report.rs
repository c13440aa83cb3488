//! What goes to stdout.

use std::io::{self, Write};
use std::time::Duration;

use anyhow::Result;

/// One line on stdout; a closed pipe is an error, not a panic.
pub fn report(line: std::fmt::Arguments<'_>) -> Result<()> {
    Ok(writeln!(io::stdout(), "{line}")?)
}

/// A time with its unit.
pub fn seconds(time: Duration) -> String {
    match time.as_secs_f64() {
        s if s < 1e-3 => format!("{:.1} us", s * 1e6),
        s if s < 1.0 => format!("{:.1} ms", s * 1e3),
        s => format!("{s:.2} s"),
    }
}
